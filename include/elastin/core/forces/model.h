#pragma once
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "elastin/core/forces/elasticity.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/forces/viscosity.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/state.h"

namespace elastin {

/// A fixed molecule: free to move only within the range of a projector, and moved by `displacement` [m] in the fixed
/// directions.
struct Support {
  int molecule = 0;
  Matrix3 free = Matrix3::Zero();          ///< projector on the free directions; zero = fixed in all
  Vector3 displacement = Vector3::Zero();  ///< from rest; only its fixed components count
  Vector3 velocity = Vector3::Zero();      ///< [m/s] in the fixed directions, of a support that moves in time
};

/// A projector on free directions, of which rounding may have left a little where there are none: nothing, then.
inline Matrix3 without_rounding(const Matrix3& free) {
  constexpr double rounding = 1e-9;
  return free.cwiseAbs().maxCoeff() < rounding ? Matrix3(Matrix3::Zero()) : free;
}

/// A body with everything that acts on it. The body must outlive the model. On a process's share of a body
/// (Body::share) it has the elements that this process computes: energies and forces are summed over the processes,
/// unless it has complete_rows().
class Model {
 public:
  explicit Model(const Body& body);
  ~Model();
  Model(Model&&) noexcept;

  const Body& body() const { return *body_; }
  void add(ElasticTerms elasticity);
  /// On a share: keeps of elasticity that is added from now on also what other processes compute, for
  /// force_densities().
  void keep_all_elements() { keeps_all_ = true; }
  /// On a share, before elasticity is added: it has all elements of the share, so that forces and rows of the tangent
  /// of owned molecules are those of the whole, added in the same order on any number of processes; energies are still
  /// summed over them. `spread` gives the ghosts what their owners have, and all processes call it together:
  /// set_forces() does. Ghosts then move as what they are ghosts of, bit by bit.
  using Spread = std::function<void(Positions& values)>;
  void complete_rows(Spread spread) { spread_ = std::move(spread); }
  bool has_complete_rows() const { return static_cast<bool>(spread_); }
  /// Gives the ghosts of a share with complete rows what their owners have; nothing elsewhere.
  void spread(Positions& values) const {
    if (spread_) spread_(values);
  }
  /// Throws InputError where two loads declare history under one name.
  void add(std::unique_ptr<Load> load);
  void add(std::unique_ptr<Viscosity> viscosity) { viscosity_.push_back(std::move(viscosity)); }
  /// Takes away a load, or a damping, that was added; its history goes with it.
  void remove(const Load* load);
  void remove(const Viscosity* viscosity);
  /// Hands the loads over: the model then has none.
  std::vector<std::unique_ptr<Load>> extract_loads();
  const std::vector<std::unique_ptr<Elasticity>>& elasticity() const { return elasticity_; }
  /// Those of them that are force densities, and those whose forces are found at the nodes of cells.
  const std::vector<const EdgeDensities*>& edge_laws() const { return edge_laws_; }
  const std::vector<const NodalForces*>& nodal_laws() const { return nodal_laws_; }
  const std::vector<std::unique_ptr<Viscosity>>& viscosity() const { return viscosity_; }
  const std::vector<std::unique_ptr<Load>>& loads() const { return loads_; }
  std::vector<Support> supports;  ///< at most one a molecule
  /// Adds supports that no release frees, behind those that are there: a molecule that has one already stays fixed
  /// along what either fixes. Their own displacements are 0.
  void add_supports(const std::vector<Support>& lasting);
  /// Frees the molecules of supports number `first` to before `end`, but for what add_supports has fixed.
  void release_supports(std::size_t first, std::size_t end);
  /// Moves the supports: sets their displacements and velocities for a time [s]. Empty: they stay where they are.
  /// Forces that it sets are those of that time: steppers call it for each at which they balance forces.
  std::function<void(double time, std::vector<Support>&)> drive;

  /// Of a body with Body::unstressed: makes a part of it count, 0 … 1, see Rest::part.
  void set_rest(double part) const;
  double rest_part() const { return rest_part_; }
  /// Makes what laws bear at rest without Body::unstressed count in rest_force, too: a muscle, or a law of one's own.
  void measure_rest_force() const;
  /// Size of the forces [N] that these make in the body at rest, a Euclidean norm; 0 without them.
  double rest_force() const { return rest_force_; }
  /// The part at a time [s]; empty: it does not change in time.
  std::function<double(double time)> rest_in_time;

  bool has_energy() const;
  /// Whether at rest all forces, the loads' too, come from energies.
  bool conservative() const;
  bool has_full_tangent() const;
  /// Whether no cell is flat or inverted.
  bool admissible(const Positions& positions) const;
  /// Whether a force depends on velocities: damping, drag.
  bool feels_velocity() const;
  /// Elastic energy [J], +infinity where a cell is flat or inverted; on a share of what this process computes.
  double elastic_energy(const Positions& positions) const;
  /// What laws have stored in the state reached last, see Elasticity::stored_energy.
  double stored_energy(const Positions& positions) const;
  /// Potential energy of the loads [J].
  double load_energy(const State& state) const;
  /// Force density of each connection [N/m], on a share after keep_all_elements() those of its own molecules; of cells
  /// whose forces are found at their nodes those of the pairs that are connections (see NodalForces::show).
  VectorX force_densities(const Positions& positions) const;
  /// Calls `visit` for the cells in which laws have a stress, and returns the force densities [N/m] that are in none of
  /// these (see EdgeDensities::show).
  VectorX show_cells(const Positions& positions, const Elasticity::StateVisitor& visit) const;
  /// Elastic force on each molecule [N].
  Positions elastic_forces(const Positions& positions) const;
  /// Whether the loads' tangents are symmetric.
  bool symmetric() const;
  /// The history of laws and loads at the beginning; in order of name.
  const std::vector<HistoryBlock>& history() const { return history_; }
  /// Gives a state that begins the blocks of history(), unless it has them: blocks of other names or sizes go.
  void declare_history(State& state) const;
  /// Calls these of the loads, see there: commit_step, update_multipliers (any), max_step_fraction (the least),
  /// square_frequency (the sum; of shares the largest).
  void commit_step(State& state) const;
  bool update_multipliers(State& state) const;
  /// Calls LawHistory::begin_step, see there: before forces at the end of a step to a time [s] are computed.
  void begin_step(const State& from, double time) const;
  /// Whether an elastic law takes energy from a body that moves.
  bool dissipates() const;
  double max_step_fraction(const State& from, const State& to) const;
  double square_frequency(const State& state, double ahead) const;
  /// Adds the force densities [N/m] of all laws, separated: those of laws of triangles to a column of `of_triangles`
  /// for each triangle of the body, order 01 02 12, all others to the connections.
  void add_triangle_force_densities(const Positions& positions, Eigen::Matrix3Xd& of_triangles, VectorX& of_connections,
                                    Workspace& workspace) const;
  /// Adds it to `forces`, without an allocation once `workspace` has served this model. Bitwise identical on any number
  /// of threads.
  void add_elastic_forces(const Positions& positions, Positions& forces, Workspace& workspace) const;
  /// Adds all other forces: damping and loads. The same.
  void add_other_forces(const State& state, Positions& forces, Workspace& workspace) const;
  /// Force of all loads on each molecule [N].
  Positions load_forces(const State& state) const;
  /// Squared length [m²] of each connection, and its rate [m²/s].
  std::pair<VectorX, VectorX> squared_lengths_and_rates(const State& state) const;
  /// Force density of each connection [N/m] that internal damping adds.
  VectorX viscous_force_densities(const State& state) const;
  /// All forces on each molecule [N]: elastic, damping, loads. `forces` is overwritten.
  void set_forces(const State& state, Positions& forces) const;
  /// The same without an allocation once `workspace` has served this model.
  void set_forces(const State& state, Positions& forces, Workspace& workspace) const;
  /// Sum of connection forces on each molecule: Σ q_ab (x_b − x_a). Bitwise identical on any number of threads.
  void gather(const Positions& positions, const VectorX& force_densities, Positions& forces) const;

 private:
  friend class Tangent;
  void add_law(std::unique_ptr<Elasticity> law, const CellRange& triangles);
  void set_squared_lengths_and_rates(const State& state, VectorX& squared_lengths, VectorX& rates) const;
  const Body* body_;
  std::unique_ptr<const Subdomain> computed_;  ///< of a share
  bool keeps_all_ = false;
  std::vector<std::unique_ptr<Elasticity>> all_elements_;  ///< elasticity on the share with what others compute
  std::vector<std::unique_ptr<Elasticity>> counted_;       ///< next to complete rows: whose energy is this process's
  Spread spread_;
  std::vector<std::shared_ptr<const void>> owners_;  ///< of what elasticity works on
  std::vector<std::unique_ptr<Elasticity>> elasticity_;
  std::vector<CellRange> triangles_;  ///< for which each edge law was made
  std::vector<const EdgeDensities*> edge_laws_;
  std::vector<const NodalForces*> nodal_laws_;
  std::vector<std::unique_ptr<Viscosity>> viscosity_;
  std::vector<std::unique_ptr<Load>> loads_;
  std::vector<HistoryBlock> history_;
  std::vector<std::pair<LawHistory*, std::string>> law_histories_;  ///< of elastic laws that have one, with their names
  std::unique_ptr<Graph> graph_;
  std::vector<Support> lasting_supports_;
  mutable double rest_part_ = 1, rest_force_ = 0;
};

}  // namespace elastin
