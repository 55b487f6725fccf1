#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {

/// What ties velocities and accelerations to the positions sought, at the end of a time step: v = v₀ + w_v (x − x₀),
/// a = a₀ + w_a (x − x₀). A static problem has none of it.
struct Kinematics {
  Weights weights;
  Positions start;          ///< x₀ [m]
  Positions velocities;     ///< v₀ [m/s]
  Positions accelerations;  ///< a₀ [m/s²]
  /// Whether the step ends after its last iteration, balanced or not; nobody then wants to hear that it is not.
  bool cut_short = false;
};

/// What solved a linear problem, and why that: "multigrid", "103823 molecules, …".
struct UsedSolver {
  std::string name, reason;
};

/// How several processes solve one problem: each has molecules of its own, which come first, and ghosts of others. All
/// call each of these together.
class SharedProblem {
 public:
  /// The stiffness at one state.
  struct Linearised {
    virtual ~Linearised() = default;
    virtual double rounding_floor() const = 0;
    virtual LinearResult solve(const Positions& rhs, double tolerance, Positions& motion, UsedSolver& used) = 0;
    /// A direction of negative stiffness; no columns without one.
    virtual Positions way_down(int& iterations) = 0;
  };

  virtual ~SharedProblem() = default;
  /// The body that the processes have among them, or a share that knows it.
  virtual const Body& whole() const = 0;
  virtual int owned() const = 0;
  virtual double sum(double own) const = 0;
  virtual double largest(double own) const = 0;
  /// Of forces that each process has of what it computes, makes those of all, at its own molecules.
  virtual void add_up(Positions& forces) const = 0;
  virtual std::unique_ptr<Linearised> linearise(const Tangent& tangent) = 0;
};

/// What stays the same through Newton's iterations, and how vectors of the problem are added up.
struct Problem {
  Model& model;
  const Kinematics* kinematics;  ///< null: static
  SharedProblem* shared;         ///< null: this process has all of it
  bool with_energy;              ///< whether the answer minimises an energy

  Problem(Model& a_model, const Kinematics* some_kinematics, SharedProblem* some_shared = nullptr);

  const Body& whole() const { return shared ? shared->whole() : model.body(); }
  double sum(double own) const { return shared ? shared->sum(own) : own; }
  double largest(double own) const { return shared ? shared->largest(own) : own; }
  bool any(bool own) const { return largest(own) > 0; }
  double dot(const Positions& a, const Positions& b) const;
  double norm(const Positions& vectors) const;
};

struct Balance {
  Positions unbalanced;  ///< all forces less inertia, in the free directions [N]
  double norm = 0;       ///< its size
  double scale = 0;      ///< size of loads, inertia and reactions; see scale_of
};

/// Where a line search stands: total energy (where there is one) and unbalanced force.
struct Trial {
  State state;
  Balance forces;
  double energy = 0;  ///< +infinity where a cell is flat or inverted
  double noise = 0;   ///< what rounding of the positions does to the energy [J]
};

/// Workspace of trials; it only grows.
struct TrialWorkspace {
  Trial next;
  Positions loads, inertia, supported;
  VectorX force_densities;
  Workspace force_pass;
};

/// What the step's kinetic energy adds to the energy [J] that its end minimises: ½ w_a |Δx|² + a₀·Δx, by mass, of the
/// molecules that its process owns.
double step_energy(const Model& model, const Kinematics& kinematics, const Positions& positions);

/// Sets the state that is `factor` · motion further on.
void set_state(const State& from, double factor, const Positions& motion, State& state);

/// Sets all of the trial that follows from its state's positions.
void evaluate(const Problem& problem, bool with_energy, Trial& trial, TrialWorkspace& workspace);

/// Halves the step until the energy falls (Armijo) or, where rounding hides that or there is no energy, the unbalanced
/// force does; and while a cell is inverted, with or without an energy. A time step with damping or drag has no
/// energy, but forces whose work along it gives the same criterion. Returns false if no step helps; `now` then stays.
/// @param growing how many steps may let the force grow whose work along them falls to half; null: none
bool line_search(const Problem& problem, const Positions& motion, bool with_energy, Trial& now, bool& inverted,
                 TrialWorkspace& workspace, int* growing = nullptr);

/// Goes along a direction, or against it, as far as the energy falls by more than its rounding. Returns whether it did.
bool leave_saddle(const Problem& problem, const Positions& direction, Trial& now, TrialWorkspace& workspace);

/// Sum of the sizes of the forces within the body [N], of each law by itself: where a muscle shortens and nothing
/// resists, those of its fibres and of the tissue around them cancel.
double internal_force(const Model& model, const Positions& positions, VectorX& force_densities, Workspace& workspace);

/// What the unbalanced force of an equilibrium is compared with [N]: the size of loads and reactions; or, where these
/// are nothing but rounding, that of the forces within the body. Both are Euclidean norms over the molecules.
double scale_of(double outer, double within);

/// The largest norm of a column, of all processes.
double furthest(const Problem& problem, const Positions& motion);

/// Mean rest length of the connections [m].
double mean_length(const Body& body);

}  // namespace elastin
