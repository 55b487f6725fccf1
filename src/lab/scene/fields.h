#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/geometry/box_tree.h"
#include "lab/scene/parts.h"

namespace elastin::lab {

using ValueAt = std::function<double(const Vector3& place)>;

/// What a map with `expression`, or `file` and `data`, says of a number from place to place.
/// Throws InputError where the file has no values near cells of the body, which may be null.
ValueAt field_values(const Reader& reader, const Dimension& dimension, const Range& range, const Body* body);

template <class Members>
Vector3 middle_of(const Body& body, const Members& members) {
  Vector3 sum = Vector3::Zero();
  for (const int molecule : members) sum += body.rest.col(molecule);
  return sum / static_cast<double>(members.size());
}

/// Which of some regions each cell and connection belongs to; of several the last counts. Places have the cell whose
/// middle is nearest: connections are asked apart, for many a one has its middle where a cell has it.
template <class Setup>
class Regions {
 public:
  Regions(const Body& body, std::vector<Setup> setups) : setups_(std::move(setups)) {
    for (const Setup& setup : setups_) {
      std::vector<char>& marks = among_.emplace_back(static_cast<std::size_t>(body.size()), 0);
      for (const int molecule : *setup.molecules) marks[molecule] = 1;
    }
    std::vector<char> found(setups_.size(), 0);
    const auto add = [&](Elements& elements, const auto& members, bool counts = true) {
      const int region = region_of(members);
      elements.add(region, middle_of(body, members), along(body, members));
      if (counts && region >= 0) found[region] = 1;
    };
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) add(cells_, block.cell(cell));
    if (!has_blocks(body, 3))
      for (const auto& cell : body.tetrahedra) add(cells_, cell);
    if (!has_blocks(body, 2))
      for (const auto& cell : body.triangles) add(cells_, cell);
    const bool alone = cells_.regions.empty();
    if (alone)
      for (const auto& cube : body.cubes) add(cells_, cube, false);
    for (const auto& ends : body.connections.ends) add(connections_, ends, alone);
    for (std::size_t region = 0; region < setups_.size(); ++region)
      if (!found[region]) setups_[region].place->fail("no cell has all its molecules among these");
    cells_.finish(), connections_.finish();
  }

  const std::vector<Setup>& setups() const { return setups_; }

  /// Of the cell, or of a body without cells the connection, whose middle is nearest; null: of none.
  const Setup* at(const Vector3& place) const {
    return setup(cells_.regions.empty() ? connections_.region_at(place) : cells_.region_at(place));
  }
  /// Of the connection between these places.
  const Setup* at(const Vector3& first, const Vector3& second) const {
    return setup(connections_.region_at((first + second) / 2, second - first));
  }
  /// Of what has these molecules.
  template <class Members>
  const Setup* of(const Members& members) const {
    return setup(region_of(members));
  }

 private:
  struct Elements {
    std::vector<int> regions;
    std::vector<Vector3> middles, along;
    std::unique_ptr<BoxTree> tree;

    void add(int region, const Vector3& middle, const Vector3& direction) {
      regions.push_back(region), middles.push_back(middle), along.push_back(direction);
    }
    void finish() {
      std::vector<Box> boxes;
      for (const Vector3& middle : middles) boxes.push_back({middle, middle});
      tree = std::make_unique<BoxTree>(boxes);
    }
    /// @param direction that of the element, where several have one middle; 0: any
    int region_at(const Vector3& place, const Vector3& direction = Vector3::Zero()) const {
      const auto distance = [&](int element) {
        const double away = (middles[element] - place).norm();
        return direction.isZero(0)
                   ? away
                   : away + std::min((along[element] - direction).norm(), (along[element] + direction).norm());
      };
      const int nearest = tree->nearest(place, distance).first;
      return nearest < 0 ? -1 : regions[nearest];
    }
  };

  const Setup* setup(int region) const { return region < 0 ? nullptr : &setups_[region]; }
  template <class Members>
  static Vector3 along(const Body& body, const Members& members) {
    return body.rest.col(members[1]) - body.rest.col(members[0]);
  }
  template <class Members>
  int region_of(const Members& members) const {
    for (std::size_t region = setups_.size(); region-- > 0;)
      if (std::all_of(members.begin(), members.end(), [&](int m) { return among_[region][m] != 0; }))
        return static_cast<int>(region);
    return -1;
  }

  std::vector<Setup> setups_;
  std::vector<std::vector<char>> among_;
  Elements cells_, connections_;
};

}  // namespace elastin::lab
