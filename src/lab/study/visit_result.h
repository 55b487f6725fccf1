#pragma once
#include "core/model/visit_body.h"
#include "elastin/lab/study/laboratory.h"

/// The one description of what a result is made of, for programs that keep results; see core/base/archive.h.
namespace elastin::lab {

inline auto members(Measured& measured) { return std::tie(measured.name, measured.unit, measured.value); }
inline auto members(LaboratoryResult::Row& row) { return std::tie(row.at, row.measures); }
inline auto members(LaboratoryResult::Kept& kept) { return std::tie(kept.at, kept.positions); }
inline auto members(LaboratoryResult& result) {
  return std::tie(result.outcome, result.suited, result.good, result.newton_iterations, result.linear_iterations,
                  result.strategy, result.cause, result.solver, result.measures, result.main, result.gradients,
                  result.spreads, result.errors, result.curve, result.stiffness, result.positions, result.tensions,
                  result.states, result.warnings, result.notes, result.build_seconds, result.solve_seconds);
}

}  // namespace elastin::lab
