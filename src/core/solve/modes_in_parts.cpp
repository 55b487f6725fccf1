#include <algorithm>
#include <utility>
#include <vector>

#include "core/solve/modes.h"
#include "elastin/core/model/parts.h"

namespace elastin {

ModeReport find_modes_in_parts(const Body& body, const std::vector<Support>& supports, const std::vector<char>& stiff) {
  if (body.parts.empty()) return find_zero_energy_modes(body, supports, stiff);
  std::vector<PartAlone> soft;
  std::vector<const Part*> parts;
  std::vector<int> uses(static_cast<std::size_t>(body.size()), 0);  // by how many parts
  for (const Part& part : body.parts) {
    if (part.rigid) continue;
    parts.push_back(&part);
    soft.push_back(part_alone(body, part));
    for (const int molecule : soft.back().molecules) ++uses[molecule];
  }
  ModeReport sum;
  for (std::size_t number = 0; number < soft.size(); ++number) {
    const PartAlone& alone = soft[number];
    // A skin whose molecules all are another part's, too, is as stiff as that.
    if (std::all_of(alone.molecules.begin(), alone.molecules.end(), [&](int m) { return uses[m] > 1; })) {
      for (const int molecule : alone.molecules) --uses[molecule];
      continue;
    }
    std::vector<int> own(body.size(), -1);
    for (std::size_t i = 0; i < alone.molecules.size(); ++i) own[alone.molecules[i]] = static_cast<int>(i);
    std::vector<Support> held;
    for (Support support : supports)
      if ((support.molecule = own[support.molecule]) >= 0) held.push_back(support);
    std::vector<char> counts;
    if (!stiff.empty())
      for (const int c : alone.connections) counts.push_back(stiff[c]);
    ModeReport report = find_zero_energy_modes(alone.body, held, counts);
    sum.rigid_motions += report.rigid_motions;
    sum.zero_energy_modes += report.zero_energy_modes;
    sum.out_of_plane += report.out_of_plane;
    sum.counted = sum.counted && report.counted;
    for (ZeroEnergyMode& mode : report.modes) {
      mode.text = "body '" + parts[number]->name + "': " + mode.text;
      for (int& molecule : mode.molecules) molecule = alone.molecules[molecule];
      sum.modes.push_back(std::move(mode));
    }
  }
  return sum;
}

}  // namespace elastin
