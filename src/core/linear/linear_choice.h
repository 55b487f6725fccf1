#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/forces/tangent.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {

struct LinearChoice {
  LinearMethod method;  ///< one that can be made: never automatic
  std::string reason;   ///< in words for a user; empty where the method was not up to us
};

/// How many iterations conjugate gradients take on a body at rest with the blocks of single molecules.
double expected_iterations(const Body& body, double tolerance);

/// Whether conjugate gradients on a body at rest are quicker with a grid hierarchy of it than without, and why.
std::pair<bool, std::string> multigrid_is_worth_it(const Model& model, double tolerance);

/// What solves K x = b to this tolerance quickest: a factorisation for a handful of molecules; else conjugate
/// gradients, with a grid hierarchy of the body where they would take many iterations without. Those are some ten for
/// each connection from end to end of the body at 1e-8, in proportion to the digits required (measured: cubes, rods
/// 100 times as long as thick); with the picture some 15 of about four times the cost, and building it costs 20.
LinearChoice choose_linear_solver(const Tangent& tangent, const LinearMethod& requested, double tolerance);

/// A solver that keeps its grid hierarchy of one stiffness for the ones after it, while it serves, or how it solved it.
class KeepsWay {
 public:
  virtual ~KeepsWay() = default;
  /// Where another problem begins: its answer must not hang on what was solved before.
  virtual void forget() = 0;
};

/// Whether a factor of the stiffness takes less than so many products of each molecule, and little memory.
bool factor_is_quicker(const Body& body, const std::vector<Support>& supports, double products);

/// bicgstab behind a factorisation from its first iteration on; make_bicgstab's takes one where that is quicker.
std::unique_ptr<LinearSolver> make_bicgstab_by_factor();

/// Multigrid that gives way to a factorisation where that is quicker than the iterations that are still to come: of
/// thin and porous bodies, near ν = ½. Their numbers decide, not clocks, so that results are the same everywhere.
std::unique_ptr<LinearSolver> make_multigrid_or_direct();

}  // namespace elastin
