#pragma once
#include <vector>

#include "elastin/forces/model.h"

namespace elastin {

/// The stiffness −∂(elastic force)/∂positions of a model at one state, without a matrix: per connection d = x_b − x_a,
/// force density q and own slope, and the coupled slopes that each cell law keeps.
class Tangent {
 public:
  /// Linearises every elasticity of the model at these positions. The model must outlive the tangent.
  Tangent(Model& model, const Positions& positions);

  /// result = K motion [N], motion [m]; result is overwritten.
  void apply(const Positions& motion, Positions& result) const;

  /// Calls visit(a, b, K_ab part) for every part of every 3×3 block, both triangles; the blocks are the sums.
  using BlockVisitor = Elasticity::BlockVisitor;
  void visit_blocks(const BlockVisitor& visit) const;

  /// The diagonal blocks K_aa [N/m].
  std::vector<Matrix3> diagonal() const;

  const Model& model() const { return model_; }

 private:
  struct Link {
    Vector3 d;
    double density;  ///< q [N/m]
    double slope;    ///< 2 ∂q/∂s [N/m³]: the change of q is slope · d·δd
  };
  void visit_link_and_cell_blocks(const BlockVisitor& visit) const;
  const Model& model_;
  std::vector<Link> links_;
  bool coupled_ = false;
};

}  // namespace elastin
