#pragma once
#include <functional>
#include <memory>
#include <string>

#include "elastin/core/forces/model.h"
#include "elastin/core/solve/statics.h"

namespace elastin {

/// The shape that a body of a given one has without its loads.
struct UnloadedShape {
  Positions rest;  ///< [m], the last one tried
  Outcome outcome = Outcome::converged;
  std::string cause;  ///< why none was found; empty if one was
  int steps = 0;
  double error = 0;  ///< [m], how far from the given shape its loads bring it at most
};

/// Finds the rest shape X from which loads bring the body to the shape that it has: X ← X − (x(X) − x), x(X) their
/// equilibrium from X, and iterations mixed.                                 [Sellier 2011; Walker & Ni 2011]
/// Molecules stay where supports fix them. Springs get the length of X times what they had of the given one's.
/// @param given the body in its given shape, which it has under the loads
/// @param make a model on another rest shape of this body, with its loads and supports; called for each step
/// @param say called with each step and its error; may be empty
UnloadedShape find_unloaded(const Body& given, const std::function<std::shared_ptr<Model>(const Body&)>& make,
                            const StaticOptions& options = {},
                            const std::function<void(int step, double error)>& say = {});

/// The body with another rest shape: connections get its lengths, times the part that they had of the present ones.
Body with_rest_shape(Body body, const Positions& rest);

}  // namespace elastin
