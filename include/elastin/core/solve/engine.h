#pragma once
#include <functional>
#include <memory>
#include <string>

#include "elastin/core/base/table.h"
#include "elastin/core/model/share.h"
#include "elastin/core/solve/statics.h"

namespace elastin {

struct Kinematics;

/// Finds equilibria in place of this process alone, for instance with others to which it hands parts of the model:
/// StaticOptions::engine. Every process calls it for the same model in the same order, and gets the same results; where
/// a model's body is the process's share, those of its molecules, and no reaction at a support of a ghost.
class StaticEngine {
 public:
  virtual ~StaticEngine() = default;
  /// Those that have shares of a body, see elastin/core/model/share.h; null where this process is alone.
  virtual std::shared_ptr<const Processes> processes() const { return nullptr; }
  /// On a model of a share: makes forces [N] that each process has of what it computes those of all.
  virtual void complete(const Model& /*model*/, Positions& /*forces*/) {}
  /// Why it cannot take a model, in words for a user; "" if it can. The calls below throw InputError with them.
  virtual std::string unsuited(const Model& model) const = 0;
  /// As static_response.
  virtual StaticResponse respond(Model& model, const Positions& at, const Positions& load_change,
                                 const Positions& displacement, const StaticOptions& options) = 0;
  /// As solve_static with large displacements, from positions at which the supports are where they are wanted.
  virtual StaticResult balance(Model& model, State& state, const StaticOptions& options) = 0;
  /// What gives the ghosts of a share what their owners have, for Model::complete_rows, whose model it then steps. Null
  /// where it steps no shares.
  virtual Model::Spread spreading(const Body& /*share*/) { return nullptr; }
  /// The same as `balance` at the end of an implicit step, of a model with complete rows.
  virtual StaticResult balance_step(Model& model, State& state, const StaticOptions& options,
                                    const Kinematics& kinematics);
};

/// A row of the table of engines: what scenes name under solver.engine.
struct StaticEngineKind : Descriptor {
  std::function<std::shared_ptr<StaticEngine>()> make = {};  ///< empty: this process by itself, or see `missing`
  std::string missing = {};  ///< what this program would need for it, in words for a user; "" if nothing
};

/// threads, petsc. The latter is missing here: a program that links elastin::petsc has it in its catalog.
const Table<StaticEngineKind>& built_in_engines();

}  // namespace elastin
