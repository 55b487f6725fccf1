#pragma once
#include "lab/report/stepper_report.h"
#include "lab/scene/scene.h"
#include "lab/study/request.h"

namespace elastin::lab {

/// Whether the command, or one of its scenes, compares steppers instead of strategies. Throws InputError where some
/// scenes do and others do not.
bool compares_steppers(const Request& request);

/// Runs every stepper on every scene and reports. Returns whether all rows that could run did.
bool compare_steppers(const Request& request, const Catalog& catalog);

/// The steppers of `study` on a scene's own strategy, held by its experiment at rest (of one in time: its fixture):
///   * loaded at once, under mass damping that is critical for the loaded shape, until it rests: measures at rest;
///   * released from the loaded equilibrium for one period without that damping: errors, energy and time of a step.
/// Throws InputError where there is no such experiment, or no equilibrium.
/// @param progress gets what is being done; @param stop ends the comparison after a row.
StepperComparison measure_steppers(Scene& scene, const StepperStudy& study,
                                   const std::function<void(const std::string&)>& progress = {},
                                   const std::function<bool()>& stop = {});

}  // namespace elastin::lab
