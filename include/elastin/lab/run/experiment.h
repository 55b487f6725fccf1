#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/model/material.h"
#include "elastin/core/solve/statics.h"
#include "elastin/lab/run/measures.h"

namespace elastin {
struct Vibrations;
}
namespace elastin::lab {

/// Where measuring starts: the body under the scene's other loads (its own weight, say) before the experiment's load.
struct Start {
  Positions positions;                       ///< [m]
  Positions reactions;                       ///< of the supports [N]
  std::vector<ContactHistory> touches = {};  ///< State::contact_history there
};

/// A measure by which strategies are compared.
struct MainMeasure {
  std::string name;
  /// The material's target, SI; NaN = the material has none, the measure is only shown.
  double prescribed = std::numeric_limits<double>::quiet_NaN();
  /// Strain at which the target is a law's secant; NaN: at rest.
  double strain = std::numeric_limits<double>::quiet_NaN();
};

/// Measures that describe the time history; "" where the experiment has no such measure.
struct ResponseMeasures {
  std::string displacement;   ///< that the loaded part makes: "tip_deflection"
  std::string resistance;     ///< of the body to a given displacement: "force", "torque"
  std::string released = {};  ///< once the load is gone, with its sign; "": `displacement`
};

/// Of each measure its derivatives by numbers of the scene, by their keys; SI units.
using Gradients = std::vector<std::pair<std::string, std::vector<std::pair<std::string, double>>>>;

/// One state on a response curve: under a part of the load, or at a time.
struct CurvePoint {
  double load_factor = 0;
  Measures measures;
  int newton_iterations = 0, linear_iterations = 0;
  double residual = 0;
  double time = 0, step = 0;  ///< [s] of a run in time; step: the last one before
  int steps = 0;              ///< since the point before
  Gradients gradients = {};   ///< of its measures, where they are requested
};

/// A material to be found: the secant modulus E(ε) = c₀ + c₁ |ε| + … with which an experiment shows measured values.
struct Identification {
  std::string measure;                           ///< what was measured
  std::vector<double> values;                    ///< at each load step, SI, > 0
  int degree = 2;                                ///< of the polynomial
  double up_to = 0;                              ///< strain up to which it counts, > 0; straight on beyond
  std::vector<StressStrain::SecantPoint> guess;  ///< initial guesses of E at some strains, at least one
};

class StaticExperiment;

/// An experiment as a small block with sides along a frame undergoes it, every point of it alike.
struct UniformTest {
  double strain;  ///< that was measured
  Matrix3 frame;  ///< orthonormal columns; a sheet lies along the first one
  std::function<std::unique_ptr<StaticExperiment>(const Body& block)> make;
};

class StaticRig;
class TimedRig;
class TimedExperiment;

/// What an experiment knows of the one model that it holds and loads. Experiment and model must outlive it; the model
/// must not move.
class Rig {
 public:
  Rig() = default;
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  virtual ~Rig() = default;
  /// Itself as the rig of an experiment at rest, or null.
  virtual StaticRig* at_rest() { return nullptr; }
  /// Itself as the rig of an experiment in time, or null.
  virtual TimedRig* in_time() { return nullptr; }
};

/// Loads its model step by step and measures each equilibrium.
class StaticRig : public Rig {
 public:
  StaticRig* at_rest() final { return this; }

  /// Sets the load to `factor` (0 … 1) of the whole.
  virtual void set_load(double factor) = 0;
  /// After an equilibrium was found: brings the load nearer to what is prescribed, if it is not there yet. True: that
  /// takes another solve.
  virtual bool adjust(const State& /*state*/) { return false; }
  /// Whether it ever does.
  virtual bool seeks_load() const { return false; }
  /// Moves the positions at rest to where the search for the first equilibrium begins, under the load set last: rest is
  /// no place to begin where stiffness is missing there.
  virtual void shape_start(Positions& /*positions*/) const {}
  /// Moves, before any load, what goes freely until it touches: friction begins there.
  virtual void approach(Positions& /*positions*/) const {}
  /// Takes what is to touch the body out of the way of the scene's own loads, which may move its surface, until
  /// meet(). True: there is such a thing.
  virtual bool withdraw() { return false; }
  /// Places it where it touches the body that these loads have brought here. Before set_load.
  virtual void meet(const Positions& /*positions*/) {}
  /// The largest fraction of the load (0 … 1) that one step may add: a turn beyond it would be taken for a shorter one
  /// in the opposite direction.
  virtual double longest_step() const { return 1; }
  /// Sets the speed of the driven supports: the load factor changes by `rate` a second. After set_load.
  virtual void set_load_rate(double /*rate*/) {}
  /// Takes the load off a body that is to move on its own: forces end, a driven end is free. Nothing happens where
  /// there is no load that could be taken off. The state is the one under the load.
  virtual void release(const State& /*loaded*/) {}
  /// Reads the state that a solve has left, as changes since the start. May solve for small motions about it, with
  /// `options`: adds their cost to `solved`, and their outcome if one fails.
  virtual Measures measure(const Start& start, const State& state, const StaticOptions& options,
                           StaticResult& solved) const = 0;
  /// Adds what is measured once, at the last of several load steps, and the linear iterations that it takes.
  virtual void measure_end(const State& /*state*/, const StaticOptions& /*options*/, Measures& /*measures*/,
                           int& /*iterations*/) const {}
  /// The vibrations that it found when it measured last; null: it looks for none.
  virtual const Vibrations* vibrations() const { return nullptr; }
  /// How many of the model's supports are the experiment's own, which come first.
  std::size_t own_supports = 0;
  /// Whether an equilibrium that is no minimum (a straight column beyond its buckling load) is left for one of less
  /// energy; if not, the body stays on the branch on which it is.
  virtual bool leaves_saddles() const { return true; }
};

/// Brings its model to time 0 and reads it as time goes on.
class TimedRig : public Rig {
 public:
  TimedRig* in_time() final { return this; }

  /// How the body stands at time 0, what is held, and what acts from now on, by Model::drive where that changes; the
  /// rig must outlive what it sets there. The result is that of the last static solve that it took, if any.
  virtual StaticResult start(State& state, const StaticOptions& options) = 0;
  /// Reads one state.
  virtual Measures read(const State& state) const = 0;
};

/// What an experiment found of its body as it was made, a sentence each: what anyone may want to know, and what must
/// not be passed over.
struct Findings {
  std::vector<std::string> notes, warnings;
};

/// An experiment: how a body is held and loaded, and what is read off it. Immutable: made once for a body, it serves
/// every strategy on it, from several threads at a time. What it must know of a model stands in the rig that it makes
/// for each. It is either static or timed.
class Experiment {
 public:
  virtual ~Experiment() = default;
  virtual std::string name() const = 0;
  /// Every measure that its rigs may take, but those that runs add themselves (see common_measures).
  virtual MeasureList measures() const = 0;
  /// Adds the experiment's supports and loads to a model of its body that has no supports yet.
  virtual std::unique_ptr<Rig> rig(Model& model) const = 0;
  /// Itself as an experiment at rest, or null.
  virtual const StaticExperiment* at_rest() const { return nullptr; }
  /// Itself as an experiment in time, or null.
  virtual const TimedExperiment* in_time() const { return nullptr; }
  /// The experiment at rest in which spring rules are calibrated; null without one.
  virtual const StaticExperiment* calibration() const { return nullptr; }
  /// Unit direction of the uniaxial stress that it makes; none if it makes another.
  virtual std::optional<Vector3> axis() const { return std::nullopt; }
  /// How many times what is modelled the whole body is: planes of symmetry may cut it.
  virtual double copies() const { return 1; }
  /// Whether only the load gives the body stiffness in directions in which it has none at rest (a flat membrane).
  virtual bool stiffened_by_load() const { return false; }
  /// The most telling measure first, with the material's target at rest; nothing measured = before any run.
  /// `calibrated` scales a rule to the first that has a target.
  virtual std::vector<MainMeasure> main_measures(const Material& material, const Measures& measured) const = 0;
  /// What limits the meaning of these measures, in words; "" if nothing does. No fault of the strategy.
  virtual std::string remark(const Measures& /*measures*/) const { return ""; }
  /// Whether `effective_modulus` is apparent: it depends on the body's shape, not on its material alone.
  virtual bool apparent() const { return false; }
  /// Why no strategy can be ranked by the material's own values, in words; "" if it can. No fault of the strategy.
  virtual std::string no_reference() const { return ""; }
  /// How it measures, where that is not what everyone expects, a sentence each.
  virtual std::vector<std::string> notes() const { return {}; }
  /// Of the ends that it holds. A scene takes them over, those of fixtures too.
  const Findings& findings() const { return findings_; }

 protected:
  Findings findings_;
};

/// An experiment at rest: one equilibrium a load step.
class StaticExperiment : public Experiment {
 public:
  const StaticExperiment* at_rest() const final { return this; }
  const StaticExperiment* calibration() const override { return this; }
  std::unique_ptr<Rig> rig(Model& model) const final { return static_rig(model); }

  /// The experiment's own supports and load, and its further supports.
  std::unique_ptr<StaticRig> static_rig(Model& model) const {
    auto rig = make_rig(model);
    rig->own_supports = model.supports.size();
    model.add_supports(further_supports_);
    return rig;
  }
  /// M of what a force f at a place [m] does against the experiment's load: M f, its part along the load, or its moment
  /// about an axis. Zero: no modulus is read off a load.
  virtual Matrix3 against_load(const Vector3& /*at*/) const {
    return axis() ? Matrix3(*axis() * axis()->transpose()) : Matrix3(Matrix3::Zero());
  }
  /// Supports in addition to its own, such as planes of symmetry and a clamped rim; see Model::add_supports.
  const std::vector<Support>& further_supports() const { return further_supports_; }
  void set_further_supports(std::vector<Support> supports) { further_supports_ = std::move(supports); }
  virtual int load_steps() const { return 1; }
  /// The part of the load (0 … 1) at step 1 … load_steps(); a body may be unloaded in between.
  virtual double load_factor(int step) const { return static_cast<double>(step) / load_steps(); }
  virtual ResponseMeasures response_measures() const { return {}; }
  /// Whether what it measures is the response to small strains, however large its load is.
  virtual bool of_small_strains() const { return false; }
  /// Whether it takes out of what it measures the rigid motions that supports leave free, and says how many these are.
  virtual bool leaves_out_rigid_motions() const { return false; }
  /// The test that shows a law's own value of what was measured (a curve has another secant modulus at every strain);
  /// none where no uniform strain does.
  virtual std::optional<UniformTest> uniform(const Measures& /*measured*/) const { return std::nullopt; }
  /// The material to be found from measured values, if the experiment is there for that.
  virtual std::optional<Identification> identification() const { return std::nullopt; }

 protected:
  /// Adds its own supports and load to a model of its body that has no supports yet.
  virtual std::unique_ptr<StaticRig> make_rig(Model& model) const = 0;

 private:
  std::vector<Support> further_supports_;
};

/// An experiment that runs through time.
class TimedExperiment : public Experiment {
 public:
  const TimedExperiment* in_time() const final { return this; }
  std::unique_ptr<Rig> rig(Model& model) const final { return timed_rig(model); }

  virtual std::unique_ptr<TimedRig> timed_rig(Model& model) const = 0;
  /// The experiment at rest that says how the body is fixed, which further supports go with; null without one.
  virtual StaticExperiment* fixture() { return nullptr; }
  /// Whether what it shows happens far more slowly than the body swings: steps need not follow its vibrations.
  virtual bool slow() const { return false; }
  /// Adds what the whole time history says, from its rows at equal times, the first at time 0.
  virtual void read_history(const std::vector<CurvePoint>& history, Measures& measures) const = 0;
  /// Adds, after read_history and where the strategy relaxes, what the material's own terms say of what is to come.
  virtual void read_relaxation(const std::vector<CurvePoint>& /*history*/, const Relaxation& /*relaxation*/,
                               Measures& /*measures*/) const {}
};

}  // namespace elastin::lab
