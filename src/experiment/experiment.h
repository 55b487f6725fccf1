#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/forces/model.h"
#include "elastin/solve/statics.h"
#include "experiment/measures.h"

namespace elastin {

/// Where measuring starts: the body under the scene's other loads (its own weight, say) before the experiment's load.
struct Start {
  Positions positions;  ///< [m]
  Positions reactions;  ///< of the supports [N]
};

/// A way to hold and load a body, and what is read off it. Made once for a body; serves every strategy on it.
class Experiment {
 public:
  virtual ~Experiment() = default;
  virtual std::string name() const = 0;
  /// Unit direction of the uniaxial stress that it makes; none if it makes another.
  virtual std::optional<Vector3> axis() const { return std::nullopt; }
  /// Adds the experiment's supports and loads to a model of its body. Called once for each model.
  virtual void hold(Model& model) = 0;
  /// Sets the load to `factor` (0 … 1) of the whole, on the model that was held last.
  virtual void set_load(Model& model, double factor) = 0;
  virtual int load_steps() const = 0;
  /// Reads the state that a solve has left, as changes since the start.
  virtual Measures measure(const Model& model, const Start& start, const State& state,
                           const StaticResult& solved) const = 0;
  /// Tangent modulus at a state, by one linear solve there; adds its linear iterations.
  virtual double tangent_modulus(Model& model, const State& state, const StaticOptions& options,
                                 int& iterations) const = 0;
};

}  // namespace elastin
