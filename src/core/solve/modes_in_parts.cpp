#include <utility>

#include "core/solve/modes.h"
#include "elastin/core/model/parts.h"

namespace elastin {

ModeReport find_modes_in_parts(const Body& body, const std::vector<Support>& supports, const std::vector<char>& stiff) {
  if (body.parts.empty()) return find_zero_energy_modes(body, supports, stiff);
  ModeReport sum;
  for (const Part& part : body.parts) {
    if (part.rigid) continue;
    const PartAlone alone = part_alone(body, part);
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
    sum.counted = sum.counted && report.counted;
    for (ZeroEnergyMode& mode : report.modes) {
      mode.text = "body '" + part.name + "': " + mode.text;
      for (int& molecule : mode.molecules) molecule = alone.molecules[molecule];
      sum.modes.push_back(std::move(mode));
    }
  }
  return sum;
}

}  // namespace elastin
