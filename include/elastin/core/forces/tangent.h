#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "elastin/core/forces/model.h"

namespace elastin {

class GridLinks;

/// What a small change of position means for velocity and acceleration, where these follow from it: static problems are
/// (0, 0), a time step has its stepper's weights.
struct Weights {
  double velocity = 0;      ///< δv/δx [1/s]
  double acceleration = 0;  ///< δa/δx [1/s²]
};

/// The stiffness −∂(all forces)/∂positions of a model at one state, without a matrix, with damping and inertia by their
/// weights: per connection d = x_b − x_a, force density q and own slope; the linearisation of each law; the loads'.
/// What is left out: that a viscosity's ṡ turns with the body (unsymmetric, and small where a step is).
class Tangent {
 public:
  /// Model and state must outlive the tangent.
  /// @param small displacements: loads that follow the surface (Load::follows_surface) do not turn and grow with it
  Tangent(const Model& model, const State& state, const Weights& weights = {}, bool small = false);
  /// Not linearised yet.
  explicit Tangent(const Model& model);
  ~Tangent();
  /// At another state, without an allocation.
  void linearise_at(const State& state, const Weights& weights);
  /// Whether all laws predict.
  bool predicts() const;
  /// At the next state of a static problem, by predicted strains: those of the state of before, and what is linear in
  /// the motion from there. Where a step turns cells, the strains that are there have the square of the turn, too,
  /// which no equilibrium has, and stiffness and forces by it lead astray. Sets the elastic forces [N] to those at the
  /// next state of laws that are linear about the predicted strains: Newton's iteration with stresses and strains of
  /// their own, which ends where usual ones do.                                            [Magisano, Leonetti & Garcea
  /// 2017] The state of before must still be what it was.
  void linearise_onward(const State& next, Positions& forces);

  /// Memory for intermediate results of apply; it belongs to the caller and only grows.
  struct ApplyWorkspace {
    VectorX squared_lengths, force_densities;
    Positions rates, change;
    Workspace force_pass;
  };
  /// result = K motion [N], motion [m]; result is overwritten. Without an allocation once `workspace` has served.
  void apply(const Positions& motion, Positions& result, ApplyWorkspace& workspace) const;
  void apply(const Positions& motion, Positions& result) const {
    ApplyWorkspace workspace;
    apply(motion, result, workspace);
  }

  /// Calls visit(a, b, K_ab part) for every part of every 3×3 block, both triangles; the blocks are the sums, less the
  /// wide parts.
  using BlockVisitor = Linearisation::BlockVisitor;
  void visit_blocks(const BlockVisitor& visit) const;

  /// What these blocks leave out, of loads that join all molecules with all.
  std::vector<WideTerm> wide_terms() const;

  /// The diagonal block K_aa [N/m] of a molecule; of one that is not symmetric the upper triangle, mirrored.
  Matrix3 diagonal(int molecule) const {
    const Six& own = diagonal_[molecule];
    Matrix3 block;
    block << own[0], own[1], own[2], own[1], own[3], own[4], own[2], own[4], own[5];
    return block;
  }

  /// Whether what loads add is symmetric.
  bool symmetric() const;

  /// Whether each connection does what link() says, and nothing else is there besides inertia.
  bool is_of_links() const { return nodes_.empty() && !coupled_ && !loads_change_; }

  /// Whether any connection has a force density, or one that changes.
  bool linked() const { return linked_; }
  /// What one connection does by itself.
  struct Link {
    Vector3 d;
    double density;  ///< q [N/m]
    double slope;    ///< 2 ∂q/∂s [N/m³]: the change of q is slope · d·δd
  };
  Link link(int connection) const {
    const auto& [a, b] = model_.body().connections.ends[connection];
    const double density = stressed_ ? force_densities_[connection] : 0;
    return {positions().col(b) - positions().col(a), density, 2 * slopes_[connection]};
  }
  /// Calls visit(cells) for the cells of each law and shape whose connections influence each other; the factor of
  /// viscous ones has the weight of the velocities.
  void visit_cells(const EdgeSlopes::CellVisitor& visit) const;
  /// Calls visit(points) for the quadrature points of each law of nodal forces.
  void visit_points(const NodalStiffness::PointsVisitor& visit) const;
  /// As Linearisation, of all laws.
  void visit_gradients(const Linearisation::GradientVisitor& visit) const;
  /// The blocks K_aa of what is neither link nor cell nor inertia: the loads' and those of laws that have more than
  /// gradients (Linearisation::visit_gradients).
  void visit_other_diagonal(const std::function<void(int, const Matrix3&)>& visit) const;

  const Model& model() const { return model_; }
  /// Of the molecules, where it was taken.
  const Positions& positions() const { return state_->positions; }
  const Weights& weights() const { return weights_; }

 private:
  using Six = Eigen::Matrix<double, 6, 1>;  ///< xx xy xz yy yz zz

  Matrix3 link_block(int connection) const {
    const auto [d, density, slope] = link(connection);
    Matrix3 block;
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row) block(row, column) = slope * d[row] * d[column] + (row == column ? density : 0);
    return block;
  }
  void set_laws();
  void set_links(const State& state, const Weights& weights);
  /// Whether of a load's change nothing counts but its wide terms.
  bool stays(const Load& load) const { return small_ && load.follows_surface(); }
  void add_load_changes(const Positions& motion, ApplyWorkspace& workspace) const;
  void apply_links(const Positions& motion, Positions& result, ApplyWorkspace& workspace) const;
  void visit_local_blocks(const BlockVisitor& visit) const;
  void set_diagonal();
  template <int nodes>
  void add_diagonal_of(const CellSlopes& cells);
  const Model& model_;
  std::size_t known_laws_ = 0;                        ///< of the model, that are linearised here
  std::vector<std::unique_ptr<Linearisation>> laws_;  ///< in the model's order
  std::vector<EdgeSlopes*> edges_;                    ///< those of them that are force densities
  std::vector<NodalStiffness*> nodes_;                ///< the others
  const State* state_ = nullptr;
  Weights weights_;
  // Vectors from end to end are computed again from the positions: that takes less time than to read them.
  VectorX force_densities_;  ///< not there in a static problem where no connection is stressed
  VectorX slopes_;
  std::unique_ptr<GridLinks> grid_;  ///< the same of a regular grid at rest
  std::vector<Six> diagonal_;
  Workspace workspace_;
  bool stressed_ = false, coupled_ = false, linked_ = false, on_grid_ = false, loads_change_ = false;
  bool small_ = false;
  std::vector<WideTerm> wide_;  ///< of loads that stay
};

}  // namespace elastin
