#pragma once
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/model/material.h"
#include "elastin/core/solve/statics.h"
#include "lab/experiment/identification.h"
#include "lab/experiment/measures.h"

namespace elastin::lab {

/// Where measuring starts: the body under the scene's other loads (its own weight, say) before the experiment's load.
struct Start {
  Positions positions;  ///< [m]
  Positions reactions;  ///< of the supports [N]
};

/// A measure by which strategies are compared.
struct MainMeasure {
  std::string_view name;
  /// What the material asks for, SI; NaN = it asks for nothing, the measure is only shown.
  double prescribed = std::numeric_limits<double>::quiet_NaN();
};

class TimedExperiment;

/// By which measures the course of a body in time is told; "" where the experiment has none.
struct ResponseMeasures {
  std::string_view displacement;  ///< that the loaded part makes: "tip_deflection"
  std::string_view resistance;    ///< of the body to a given displacement: "force", "torque"
};

/// A way to hold and load a body, and what is read off it. Made once for a body; serves every strategy on it.
class Experiment {
 public:
  virtual ~Experiment() = default;
  virtual std::string name() const = 0;
  /// Unit direction of the uniaxial stress that it makes; none if it makes another.
  virtual std::optional<Vector3> axis() const { return std::nullopt; }
  /// Adds the experiment's supports and loads to a model of its body. Called once for each model.
  virtual void set_up(Model& model) = 0;
  /// Sets the load to `factor` (0 … 1) of the whole, on the model that was held last.
  virtual void set_load(Model& model, double factor) = 0;
  /// After an equilibrium was found: brings the load nearer to what was asked for, if it is not there yet. True: that
  /// takes another solve.
  virtual bool adjust(const State& /*state*/) { return false; }
  virtual int load_steps() const = 0;
  /// How many times what is modelled the whole body is: planes of symmetry may cut it.
  virtual double copies() const { return 1; }
  /// Whether only the load gives the body stiffness in directions in which it has none at rest (a flat membrane).
  virtual bool stiffened_by_load() const { return false; }
  /// Moves the positions at rest to where the search for the first equilibrium begins, under the load set last: rest is
  /// no place to begin where stiffness is missing there.
  virtual void shape_start(Positions& /*places*/) const {}
  /// Tells the supports how fast the load moves them: its factor changes by `rate` a second. After set_load.
  virtual void set_load_rate(Model& /*model*/, double /*rate*/) {}
  /// Takes the load off a body that is to move on its own: forces end, a driven end is free. False if there is nothing
  /// that could be let go.
  virtual bool release(Model& /*model*/) { return false; }
  virtual ResponseMeasures response_measures() const { return {}; }
  /// Itself as one that runs through time; null: it is at rest.
  virtual TimedExperiment* in_time() { return nullptr; }
  /// The experiment at rest in which rules are calibrated; null where there is none.
  virtual Experiment* at_rest() { return this; }
  /// Reads the state that a solve has left, as changes since the start. May solve for small motions about it, with
  /// `options`: adds their cost to `solved`, and their outcome if one fails.
  virtual Measures measure(Model& model, const Start& start, const State& state, const StaticOptions& options,
                           StaticResult& solved) const = 0;
  /// Adds what is measured once, at the last of several load steps, and the linear iterations that it takes.
  virtual void measure_end(Model& /*model*/, const State& /*state*/, const StaticOptions& /*options*/,
                           Measures& /*measures*/, int& /*iterations*/) const {}
  /// The most telling measure first, with what the material asks for where this was measured (a curve asks for another
  /// secant modulus at every strain); nothing measured = at no strain. `calibrated` scales a rule to the first that has
  /// a prescribed value.
  virtual std::vector<MainMeasure> main_measures(const Material& material, const Measures& measured) const = 0;
  /// The material to be found from measured values, if the experiment is there for that.
  virtual std::optional<Identification> identification() const { return std::nullopt; }
  /// What limits the meaning of these measures, in words; "" if nothing does. No fault of the strategy.
  virtual std::string remark(const Measures& /*measures*/) const { return ""; }
};

}  // namespace elastin::lab
