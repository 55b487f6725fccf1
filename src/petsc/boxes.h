#pragma once
#include <memory>
#include <vector>

#include "core/linear/box_grid.h"
#include "petsc/shared_model.h"

namespace elastin::petsc {

/// The grids of boxes over a shared body and what interpolates between them: nothing of the state. Every process knows
/// all boxes; the rows of points are shared out in their order, layer by layer.
class BoxHierarchy {
 public:
  /// `local`: a model of what this process has.
  BoxHierarchy(const Tangent& local, const SharedBody& body);

  const BoxGrid::Frame& frame() const { return frame_; }
  const std::vector<BoxGrid>& grids() const { return grids_; }
  const SharedBody& body() const { return body_; }
  /// From the points of the first grid to molecules; from those of grid + 1 to those of a grid.
  Mat to_molecules() const { return to_molecules_; }
  Mat interpolation(std::size_t grid) const { return interpolations_[grid]; }

 private:
  BoxGrid::Frame frame_;
  const SharedBody& body_;
  std::vector<BoxGrid> grids_;
  Matrix to_molecules_;
  std::vector<Matrix> interpolations_;
};

/// One V-cycle over the boxes for one tangent: PCMG, with Chebyshev's polynomials of the points' 3 × 3 blocks on each
/// grid but the last, which every process factorises.
class BoxCycle {
 public:
  BoxCycle(const BoxHierarchy& hierarchy, const Tangent& local, const std::vector<Support>& supports);
  /// motion += P A⁻¹ Pᵀ force, nearly.
  void add(Vec force, Vec motion) const;

 private:
  const BoxHierarchy& hierarchy_;
  std::vector<Matrix> stiffness_;               ///< of each grid, its upper half but of the last
  std::vector<std::vector<Matrix3>> inverses_;  ///< of the diagonal blocks of each grid but the last
  Solver cycle_;
  Vector force_, motion_;  ///< of the first grid's points
};

}  // namespace elastin::petsc
