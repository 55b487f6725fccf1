#pragma once
#include <memory>

#include "elastin/core/forces/elasticity.h"
#include "elastin/core/laws/point_laws.h"

namespace elastin::febio {

/// Where the analysis stands, set by its steps: laws look at it.
struct Clock {
  double time = 0;   ///< [s] at the end of the increment
  double share = 1;  ///< α_f: forces are those of x₀ + α_f (x₁ − x₀) within it, in (0, 1]
};

/// Cells that see the time and the beginning of each increment, where `cells` alone see its end only. Their forces are
/// those at x₀ + α_f (x₁ − x₀). Half-way, α_f = ½, each point's stress does exactly the work that its energy W says, as
/// FEBio has it:
///   S + (ΔW − S : E)/(E : G) G,  G = C⁻¹ E C⁻¹,  E = (C₁ − C₀)/2,  C and S half-way.               [after Gonzalez
///   2000]
/// @param laws of the points of `cells`, which are those of the block; they must have an energy if α_f is ever ½.
ElasticTerms make_stepped_cells(const Body& body, const CellBlock& block, ElasticTerms cells,
                                std::shared_ptr<const PointLaws<3>> laws, std::shared_ptr<const Clock> clock);

}  // namespace elastin::febio
