#pragma once
#include <memory>

#include "elastin/core/forces/loads.h"

namespace elastin {

/// Forces of the body's ties (Body::ties): between a molecule at x and its position y = Σ w_j x_j on a triangle of
/// another part, energy k/2 |x − y|², k its stiffness [N/m]. Momentum is kept, and angular momentum, for at rest x = y;
/// rigid motions cost nothing. The tangent is exact, and constant.
std::unique_ptr<Load> make_ties(const Body& body);

}  // namespace elastin
