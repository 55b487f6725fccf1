#pragma once
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// What a user should know of a specimen before it is loaded, in sentences: cells that are given twice, overlap with
/// obstacles or between bodies, obstacles that fit between what they meet.
std::vector<std::string> findings_at_start(const Specimen& specimen, const Model& model, bool uses_cells);

/// From this Poisson's ratio on cells need pressures of their own, or they lock: they are too stiff.
inline constexpr double kLocking = 0.4;

/// The largest ν of a material on a body: its own, or where it has fields that at some molecule.
double largest_poissons_ratio(const Material& material, const Body& body);

/// Whether this is a law of solids without a volume term, and one of the specimen's materials has ν > kLocking.
bool may_lock(const Specimen& specimen, const Strategy& strategy);

/// What to write instead of a law of solids without a volume term where the material is nearly incompressible, in a
/// sentence; "" where there is nothing to say.
std::string locking_finding(const Specimen& specimen, const Strategy& strategy);

/// What a user should know of a run that ended: a rebound faster than the impact, obstacles that something has passed
/// or may have passed through.
std::vector<std::string> findings_at_end(const Specimen& specimen, const Run& run);

}  // namespace elastin::lab
