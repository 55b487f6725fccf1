#pragma once
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "elastin/core/forces/time_function.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/state.h"

namespace elastin {

/// A part of a stiffness that joins all molecules with all: factor · direction directionᵀ.
struct WideTerm {
  double factor;        ///< [Pa/m³] of a pressure
  Positions direction;  ///< [m²] of a pressure
};

/// A force from outside the elastic law. Absent from the scene = absent from the model.
class Load {
 public:
  virtual ~Load() = default;
  /// Adds the force on each molecule [N].
  virtual void add_forces(const State& state, Positions& forces) const = 0;
  /// Potential energy [J], zero at rest; 0 for forces that have none (drag, damping). On a share that of the molecules
  /// that its process owns.
  virtual double energy(const State&) const { return 0; }
  /// Whether the forces change with the state; if not, the next two do nothing.
  virtual bool changes() const { return false; }
  /// Adds the change of the forces under small changes of positions [m] and velocities [m/s].
  virtual void add_change(const State&, const Positions& /*change_of_positions*/,
                          const Positions& /*change_of_velocities*/, Positions& /*change_of_forces*/) const {}
  /// Calls visit(a, b, part) for parts of the 3×3 blocks of −∂F_a/∂x_b − velocity_weight ∂F_a/∂v_b [N/m].
  using BlockVisitor = std::function<void(int a, int b, const Matrix3& block)>;
  virtual void visit_blocks(const State&, double /*velocity_weight*/, const BlockVisitor&) const {}
  /// What is left out there: stiffness that joins all molecules with all.
  virtual std::vector<WideTerm> wide_terms(const State&) const { return {}; }
  /// Whether what it does to a body that does not move comes from energy().
  virtual bool has_energy() const { return true; }
  /// Whether all that it gives is in energy(), which at one position stays the same over time. If not, what it does is
  /// external work, added up step by step.
  virtual bool steady() const { return has_energy(); }
  /// Whether the load acts on a body that does not move. Drag does not.
  virtual bool acts_at_rest() const { return true; }
  /// Whether part of it takes energy from a body that moves; add_resistance adds that part [N].
  virtual bool resists() const { return !acts_at_rest(); }
  virtual void add_resistance(const State& state, Positions& forces) const {
    if (resists()) add_forces(state, forces);
  }
  /// Whether its forces change with the velocities; if not it must not look at them.
  virtual bool feels_velocity() const { return changes(); }
  /// Calls visit for each force −k (x − p) − c (v − w) that it has on one molecule alone, k [N/m], c [N s/m]. A stepper
  /// whose row says `points_at_end` takes them as they are at the end of a step, where they limit no step.
  using PointVisitor = std::function<void(int molecule, double stiffness, double damping)>;
  virtual void visit_points(const PointVisitor&) const {}
  /// Whether the forces turn and grow with the body's surface. Small displacements take them as they are on the surface
  /// at rest, so that of their change nothing is left but wide_terms.
  virtual bool follows_surface() const { return false; }
  /// Whether the blocks of visit_blocks make a symmetric matrix.
  virtual bool symmetric() const { return true; }

  /// Its history from step to step, as it is at the beginning: blocks with names of their own. Empty: none.
  virtual std::vector<HistoryBlock> history() const { return {}; }
  /// Called with each state that was reached, at the end of a step: here State::history and State::contact_history
  /// change.
  virtual void commit_step(State&) const {}
  /// Changes the history so that the next equilibrium is nearer to the prescribed one. True: another solve is needed.
  virtual bool update_multipliers(State&) const { return false; }
  /// Whether it keeps a limit by these, which explicit steps do not.
  virtual bool has_multipliers() const { return false; }
  /// The largest fraction (0 … 1] of the straight path between two states on which no contact is missed.
  virtual double max_step_fraction(const State& /*from*/, const State& /*to*/) const { return 1; }
  /// A bound on the square of the frequency [1/s²] that a stiffness gives which may set in within the next `ahead` [s].
  virtual double square_frequency(const State&, double /*ahead*/) const { return 0; }
};

/// Weight: F = m g, `acceleration` [m/s²].
std::unique_ptr<Load> make_gravity(const Body& body, const Vector3& acceleration);

/// Dead forces on molecules: `forces` [N], 3 × the number of molecules named, times a factor that may change between
/// steps.
class PointLoads final : public Load {
 public:
  PointLoads(const Body& body, std::vector<int> molecules, Positions forces);
  void set_factor(double factor) { factor_ = factor; }
  /// Says that the factor changes in time: what the forces do is then work from outside.
  void set_varying() { steady_ = false; }
  bool steady() const override { return steady_; }
  void add_forces(const State& state, Positions& forces) const override;
  double energy(const State& state) const override;
  const std::vector<int>& molecules() const { return molecules_; }

 private:
  const Body& body_;
  std::vector<int> molecules_;
  Positions forces_;
  double factor_ = 1;
  bool steady_ = true;
};

/// What gives the forces of another load in its own manner: all else that it says of itself is that of the other load.
class LoadOf : public Load {
 public:
  explicit LoadOf(std::unique_ptr<Load> load) : load_(std::move(load)) {}
  bool changes() const override { return load_->changes(); }
  bool has_energy() const override { return load_->has_energy(); }
  bool steady() const override { return load_->steady(); }
  bool acts_at_rest() const override { return load_->acts_at_rest(); }
  bool resists() const override { return load_->resists(); }
  bool feels_velocity() const override { return load_->feels_velocity(); }
  bool follows_surface() const override { return load_->follows_surface(); }
  bool symmetric() const override { return load_->symmetric(); }
  std::vector<HistoryBlock> history() const override { return load_->history(); }
  void commit_step(State& state) const override { load_->commit_step(state); }
  bool update_multipliers(State& state) const override { return load_->update_multipliers(state); }
  bool has_multipliers() const override { return load_->has_multipliers(); }
  double max_step_fraction(const State& from, const State& to) const override {
    return load_->max_step_fraction(from, to);
  }

 protected:
  std::unique_ptr<Load> load_;
};

/// A load times a factor, which may change with time and between steps.
class ScaledLoad : public LoadOf {
 public:
  using LoadOf::LoadOf;
  void add_forces(const State& state, Positions& forces) const override;
  double energy(const State& state) const override { return factor(state.time) * load_->energy(state); }
  void add_change(const State& state, const Positions& change_of_positions, const Positions& change_of_velocities,
                  Positions& change_of_forces) const override;
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override;
  std::vector<WideTerm> wide_terms(const State& state) const override;
  void add_resistance(const State& state, Positions& forces) const override;
  double square_frequency(const State& state, double ahead) const override;

 protected:
  /// At a time [s].
  virtual double factor(double time) const = 0;

 private:
  mutable Positions whole_;  // of the load alone: a step must not allocate memory
};

/// A load times a function of the state's time. Its potential energy is that of the moment; it is not steady unless the
/// function is one number.
std::unique_ptr<Load> make_varying(std::unique_ptr<Load> load, TimeFunction function);

/// Ambient viscous friction F = −6π η r V, η = `viscosity` [Pa s]. [M03]
std::unique_ptr<Load> make_stokes_drag(const Body& body, double viscosity);

/// Ambient friction F = −½ ρ C π r² |V| V, ρ = `density` [kg/m³] of the medium, C = `drag_coefficient`. [M03, reading]
std::unique_ptr<Load> make_quadratic_drag(const Body& body, double density, double drag_coefficient);

/// Rayleigh's mass-proportional damping, F = −α m V, α = `rate` [1/s]. [Rayleigh 1877]
std::unique_ptr<Load> make_mass_damping(const Body& body, double rate);

}  // namespace elastin
