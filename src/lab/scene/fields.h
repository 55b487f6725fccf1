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

/// Which of some regions each cell and connection belongs to; of several the last counts.
template <class Setup>
class Regions {
 public:
  Regions(const Body& body, std::vector<Setup> setups) : setups_(std::move(setups)) {
    for (const Setup& setup : setups_) {
      std::vector<char>& marks = among_.emplace_back(static_cast<std::size_t>(body.size()), 0);
      for (const int molecule : *setup.molecules) marks[molecule] = 1;
    }
    std::vector<char> found(setups_.size(), 0);
    const auto add = [&](const auto& members, bool is_cell) {
      regions_.push_back(region_of(members));
      middles_.push_back(middle_of(body, members));
      if (is_cell && regions_.back() >= 0) found[regions_.back()] = 1;
    };
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) add(block.cell(cell), true);
    for (const auto& cell : body.tetrahedra) add(cell, true);
    for (const auto& cell : body.triangles) add(cell, true);
    for (const auto& cube : body.cubes) add(cube, false);
    for (const auto& ends : body.connections.ends) add(ends, body.tetrahedra.empty() && body.triangles.empty());
    for (std::size_t region = 0; region < setups_.size(); ++region)
      if (!found[region]) setups_[region].place->fail("no cell has all its molecules among these");
    std::vector<Box> boxes;
    for (const Vector3& middle : middles_) boxes.push_back({middle, middle});
    tree_ = std::make_unique<BoxTree>(boxes);
  }

  const std::vector<Setup>& setups() const { return setups_; }

  /// Of the cell or connection whose middle is nearest; null: of none.
  const Setup* at(const Vector3& place) const {
    const auto distance = [&](int element) { return (middles_[element] - place).norm(); };
    const int region = regions_[tree_->nearest(place, distance).first];
    return region < 0 ? nullptr : &setups_[region];
  }

 protected:
  template <class Members>
  int region_of(const Members& members) const {
    for (std::size_t region = setups_.size(); region-- > 0;)
      if (std::all_of(members.begin(), members.end(), [&](int m) { return among_[region][m] != 0; }))
        return static_cast<int>(region);
    return -1;
  }

 private:
  std::vector<Setup> setups_;
  std::vector<std::vector<char>> among_;
  std::vector<int> regions_;
  std::vector<Vector3> middles_;
  std::unique_ptr<BoxTree> tree_;
};

}  // namespace elastin::lab
