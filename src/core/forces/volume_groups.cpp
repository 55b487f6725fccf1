#include "core/forces/volume_groups.h"

#include <algorithm>

#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// `per_tetrahedron` groups of each tetrahedron, one behind the other.
VolumeGroups grouped(Cells<4> tetrahedra, std::vector<int> groups, int per_tetrahedron, int count, double weight) {
  VolumeGroups result{std::move(tetrahedra), rows_by_target(count, groups), {}, weight};
  for (int& slot : result.members.entries) slot /= per_tetrahedron;
  for (std::size_t at = 0; at <= groups.size(); at += static_cast<std::size_t>(per_tetrahedron))
    result.groups_of.start.push_back(static_cast<int>(at));
  result.groups_of.entries = std::move(groups);
  return result;
}

}  // namespace

VolumeGroups groups_of_cubes(const Cells<8>& cubes) {
  // Corner c sits at (c & 1, c >> 1 & 1, c >> 2). The second cut is the mirror image of the first in x.
  static constexpr std::array<std::array<int, 4>, 10> cut{{{0, 1, 2, 4},
                                                           {3, 2, 1, 7},
                                                           {5, 1, 4, 7},
                                                           {6, 4, 2, 7},
                                                           {1, 2, 4, 7},
                                                           {0, 1, 3, 5},
                                                           {3, 2, 0, 6},
                                                           {0, 4, 5, 6},
                                                           {6, 7, 5, 3},
                                                           {3, 0, 5, 6}}};
  Cells<4> tetrahedra;
  std::vector<int> group;
  for (std::size_t cube = 0; cube < cubes.size(); ++cube)
    for (const auto& t : cut) {
      tetrahedra.push_back({cubes[cube][t[0]], cubes[cube][t[1]], cubes[cube][t[2]], cubes[cube][t[3]]});
      group.push_back(static_cast<int>(cube));
    }
  return grouped(std::move(tetrahedra), std::move(group), 1, static_cast<int>(cubes.size()), 1. / 2);
}

VolumeGroups groups_of_molecules(int molecules, const Cells<4>& tetrahedra) {
  std::vector<int> groups;
  for (const auto& cell : tetrahedra) groups.insert(groups.end(), cell.begin(), cell.end());
  VolumeGroups result = grouped(tetrahedra, std::move(groups), 4, molecules, 1. / 4);
  result.of_molecules = true;
  return result;
}

std::vector<int> chosen_groups(const VolumeGroups& whole, const Subdomain& own) {
  std::vector<int> chosen;
  for (int group = 0; group < whole.size(); ++group) {
    int lowest = group;
    if (!whole.of_molecules) {
      std::vector<int> molecules;
      for (const int t : whole.members[group])
        for (const int molecule : whole.tetrahedra[t]) molecules.push_back(molecule);
      lowest = lowest_in_whole(*own.whole, molecules);
    }
    if (own.owns(lowest)) chosen.push_back(group);
  }
  return chosen;
}

VolumeGroups groups_on(const VolumeGroups& whole, const Subdomain& own, const std::vector<int>& chosen) {
  std::vector<int> kept;  // tetrahedra
  for (const int group : chosen) {
    const auto members = whole.members[group];
    kept.insert(kept.end(), members.begin(), members.end());
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  const auto position_in = [](const std::vector<int>& ascending, int number) {
    const auto at = std::lower_bound(ascending.begin(), ascending.end(), number);
    return at != ascending.end() && *at == number ? static_cast<int>(at - ascending.begin()) : -1;
  };
  VolumeGroups result{{}, {{0}, {}}, {{0}, {}}, whole.weight};
  for (const int group : chosen) {
    for (const int t : whole.members[group]) result.members.entries.push_back(position_in(kept, t));
    result.members.start.push_back(static_cast<int>(result.members.entries.size()));
  }
  for (const int t : kept) {
    auto cell = whole.tetrahedra[t];
    for (int& molecule : cell) molecule = own.local(molecule);
    result.tetrahedra.push_back(cell);
    for (const int group : whole.groups_of[t])
      if (const int at = position_in(chosen, group); at >= 0) result.groups_of.entries.push_back(at);
    result.groups_of.start.push_back(static_cast<int>(result.groups_of.entries.size()));
  }
  return result;
}

}  // namespace elastin
