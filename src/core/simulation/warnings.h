#pragma once
#include <string>
#include <vector>

#include "core/solve/modes.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"
#include "elastin/core/simulation/catalog.h"

namespace elastin {

// What makes the results of a body doubtful, in a sentence; "" where there is nothing to say.

/// @param name "the body", or that of a part
std::string warning_of_pieces(const Body& body, const std::string& name);

/// Of a body of cells in one piece: where parts of its mesh meet and are not joined, with molecules at one place that
/// are not one, or with sides of cells that have other cells behind them. A cut makes such, too.
std::string warning_of_seams(const Body& body, const std::string& name);

/// Cells whose nodes are another's, too; of springs also connections whose ends are. Of a body that several processes
/// share: of all of them.
std::string warning_of_doubles(const Body& body, bool uses_cells);

/// @param constants of springs [N/m], one a connection; none of a body without springs
std::string warning_of_negative(const Body& body, const VectorX& constants);

std::string warning_of_modes(const ModeReport& report);

/// From this Poisson's ratio on cells need pressures of their own, or they lock: they are too stiff.
inline constexpr double kLocking = 0.4;

/// The largest ν of a material on a body: its own, or where it has fields that at some molecule.
double largest_poissons_ratio(const Material& material, const Body& body);
/// Whether this is a law of solids without a volume term, and one of the materials has ν > kLocking.
bool may_lock(const Body& body, const std::vector<Material>& materials, const Strategy& strategy);
/// What to write instead of such a law.
std::string warning_of_locking(const Body& body, const std::vector<Material>& materials, const Strategy& strategy);

}  // namespace elastin
