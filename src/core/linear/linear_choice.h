#pragma once
#include <memory>
#include <string>
#include <utility>

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

/// Multigrid that gives way to a factorisation where that is quicker than the iterations that are still to come: of
/// thin and porous bodies, near ν = ½. Their numbers decide, not clocks, so that results are the same everywhere.
std::unique_ptr<LinearSolver> make_multigrid_or_direct();

}  // namespace elastin
