#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::mesh {

enum class FillPacking {
  lattice,     ///< simple cubic, about the middle of the surface's bounding box
  blue_noise,  ///< at random, no two closer than 0.9 of the spacing: one a cube of the spacing, nearly [Bridson 2007]
};

struct FillOptions {
  double spacing = 0;  ///< [m], > 0
  FillPacking packing = FillPacking::lattice;
  std::uint64_t seed = 1;
  /// Whether molecules lie on the surface, along its sharp sides (more than 40°) too, and those inside keep away from
  /// it.
  bool follow = true;
  double most_molecules = 5e6;  ///< that the surface's bounding box may hold, and the surface
};

/// What fills a surface. Shells that are not in each other are filled each by itself, so that no gap between them is
/// closed, however narrow it is; a shell in another one bounds a cavity of it.
struct Filling {
  Positions positions;        ///< [m]; those on the surface come first
  int on_surface = 0;         ///< how many of them
  Cells<4> tetrahedra;        ///< Delaunay's, without those outside; every molecule is a corner of one
  double surface_volume = 0;  ///< in the filled shells [m³], by the divergence theorem; by winding number to 0.5 %
  double volume = 0;          ///< of the tetrahedra [m³]
  VectorX share;              ///< of surface_volume, one a molecule; they sum to 1
  int left_out = 0;           ///< molecules that no tetrahedron inside needed
  int slivers = 0;            ///< see count_slivers
  std::vector<int> shell;     ///< that each molecule fills
  int empty_shells = 0;       ///< too small for a tetrahedron at this spacing
};

/// The space in a surface whose normals look outwards: of one in which check_surface finds nothing wrong by its
/// normals, of one that stays open or crosses itself where it goes round a point at least half a time, by its winding
/// number.
class FillRegion {
 public:
  struct Inside;
  FillRegion(const Positions& points, const Cells<3>& triangles, bool by_winding_number = false);
  ~FillRegion();

  /// Shells that are not in each other.
  int shells() const { return static_cast<int>(shells_.size()); }
  /// How many bodies are filled as one at most, because their boxes touch; 1 unless it is by winding number.
  int filled_as_one() const { return filled_as_one_; }

  /// Fills it with molecules and tetrahedra. The same options give the same filling. Cost O(n log n). Throws InputError
  /// where the spacing is too wide for one tetrahedron, or so narrow that there are more molecules than are taken.
  Filling fill(const FillOptions& options) const;

  /// Every pair of molecules at most `reach` [m] apart that sees each other: the way between them lies inside, but for
  /// a twentieth of its length where the surface is hollow. Sides of tetrahedra are pairs whatever they pass.
  Connections connections_within(const Filling& filling, double reach) const;

 private:
  std::vector<std::unique_ptr<Inside>> shells_;
  int filled_as_one_ = 1;
};

}  // namespace elastin::mesh
