#pragma once
#include <span>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// A surface that is drawn with a body and takes no part in its mechanics, as fine as a picture wants it: each of its
/// points moves with the solid cell that holds it at rest, or that is nearest to it, by this cell's shape functions.
class EmbeddedSurface {
 public:
  /// @param points 3 × n [m], in the body's shape at rest
  /// @param triangles by numbers of points, counter-clockwise seen from outside
  /// Cells are the body's tetrahedra, hexahedra and prisms, or the cubes of a lattice. Throws InputError where it has
  /// none, a point is not finite or so far outside that no cell can be continued to it, or a triangle has no such
  /// point. For another topology (Simulation::cut) another surface has to be made.
  EmbeddedSurface(const Body& body, const Positions& points, Cells<3> triangles);

  int size() const { return static_cast<int>(starts_.size()) - 1; }
  const Cells<3>& triangles() const { return triangles_; }
  /// How far the point that is furthest from all cells lies outside of them [m], about; 0 = none does.
  double farthest() const { return farthest_; }
  /// Where its points are [m], x0 y0 z0 x1 …, in single precision as graphics take them, when the molecules are at
  /// `positions`; and the unit normals there, means of the triangles around by their areas; 0 where there is no
  /// triangle. Allocates nothing. Each must have 3 size() numbers; `normals` may be empty. Throws InputError where
  /// these counts or that of the molecules differ.
  void draw(const Positions& positions, std::span<float> points, std::span<float> normals) const;

 private:
  Cells<3> triangles_;
  // Of point p those from starts_[p] to starts_[p + 1]: molecules and how much each counts.
  std::vector<int> starts_, molecules_;
  std::vector<float> weights_;
  std::vector<int> around_starts_, around_;  ///< the triangles of each point
  int body_size_ = 0;
  double farthest_ = 0;
};

}  // namespace elastin
