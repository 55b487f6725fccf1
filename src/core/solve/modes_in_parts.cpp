#include <algorithm>
#include <utility>
#include <vector>

#include "core/model/neighbours.h"
#include "core/solve/modes.h"
#include "elastin/core/model/parts.h"

namespace elastin {

namespace {

/// Of all pieces of a body that nothing joins.
int free_rigid_motions(const Body& body, const std::vector<Support>& supports) {
  const DisjointSets pieces = pieces_of(body);
  const std::vector<int> piece_of = pieces.numbers();
  std::vector<std::vector<int>> molecules(static_cast<std::size_t>(pieces.count()));
  std::vector<int> own(piece_of.size());
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    std::vector<int>& piece = molecules[piece_of[molecule]];
    own[molecule] = static_cast<int>(piece.size());
    piece.push_back(molecule);
  }
  std::vector<std::vector<Support>> held(molecules.size());
  for (const Support& support : supports) {
    std::vector<Support>& piece = held[piece_of[support.molecule]];
    piece.push_back(support);
    piece.back().molecule = own[support.molecule];
  }
  int sum = 0;
  for (std::size_t piece = 0; piece < molecules.size(); ++piece)
    sum += elastin::free_rigid_motions(body.rest(Eigen::all, molecules[piece]), held[piece]);
  return sum;
}

}  // namespace

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
  sum.rigid_motions = free_rigid_motions(body, supports);
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
