#pragma once
#include "elastin/core/forces/model.h"

namespace elastin {

/// What a body has, and what it has taken in and given away since a run began. Energies in [J].
struct Energies {
  double kinetic = 0;
  double elastic = 0;     ///< stored; 0 of laws that have no energy
  double in_laws = 0;     ///< work done on those: stored or dissipated, which cannot be distinguished
  double potential = 0;   ///< of the loads that have one and stay as they are: weight, dead forces
  double dissipated = 0;  ///< by damping, drag and laws that dissipate
  double work = 0;  ///< put in by loads that change in time or have no energy, moved supports and a rest that changes
  Vector3 momentum = Vector3::Zero();          ///< [kg m/s]
  Vector3 angular_momentum = Vector3::Zero();  ///< about the origin [kg m²/s]

  /// What the exact motion keeps: its change is the stepper's error.
  double balance() const { return kinetic + elastic + in_laws + potential + dissipated - work; }
};

/// Keeps the account of a run: adds up what passes the body's border, by the trapezoidal rule over its steps. Of a
/// share (Body::share) each process keeps that of the molecules that it owns, and all request the energies together.
class Ledger {
 public:
  Ledger(const Model& model, const State& start);
  /// To be called after each step, with its end. Costs nothing where nothing passes the border.
  void record(const Model& model, const State& state);
  Energies energies(const Model& model, const State& state) const;

  double dissipated = 0, work = 0;  ///< [J], so far; of a share this process's part of them
  /// Of laws that dissipate or have no energy, the work done on them since the start [J], and what they had stored
  /// then.
  double taken = 0;
  /// What loads that change within a step may have given in addition to the work counted, Σ (Δt ΔF)²/2m [J]: of smooth
  /// ones next to nothing, of one that jumps the speed of one step.
  double jumps = 0;

 private:
  /// Forces that take or give energy, without those with an energy of their own [N].
  struct Border {
    Positions resisting, driving, supporting;  // empty where there are no such forces
    double support_kinetic = 0;                // of the fixed components of the supports' motion [J]
  };
  Border border(const Model& model, const State& state) const;
  void record_laws(const Model& model, const State& state, const Positions& displacement);
  double work_of_rest(const Model& model, const State& state) const;
  bool open_;     // whether anything passes
  bool follows_;  // whether laws keep no account of their own
  Positions positions_;
  double rest_part_;
  double time_;
  Border last_;
  Positions law_forces_;  // of laws that it follows [N]
};

}  // namespace elastin
