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
/// equilibrium from X, and iterations mixed; where that ends, by Newton's method, under all loads or more and more of
/// them.                                                 [Sellier 2011; Walker & Ni 2011; Govindjee & Mihalic 1996]
/// Molecules stay where supports fix them. Springs get the length of X times what they had of the given one's.
/// @param given the body in its given shape, which it has under the loads
/// @param make a model on another rest shape of this body, with its loads and supports; called for each step
/// @param say called with each step and its error; may be empty
UnloadedShape find_unloaded(const Body& given, const std::function<std::shared_ptr<Model>(const Body&)>& make,
                            const StaticOptions& options = {},
                            const std::function<void(int step, double error)>& say = {});

/// A body that keeps its shape under its loads by the stress that it has.
struct KeptShape {
  Body body;  ///< the given one with the rest found, all of which acts at any time
  Outcome outcome = Outcome::converged;
  std::string cause;  ///< why none was found; empty if one was
  int steps = 0;
  double error = 0;  ///< [m], how far the given shape still moves at most
  /// How much of the prestrain remains: Σ l ε ε₀ / Σ l ε₀² over the connections of length l, ε₀ given and ε found.
  double remaining = 0;
};

/// Keeps a body in its given shape: its rest, F_g of cells and lengths of connections, changes to F_g F⁻¹, F to the
/// equilibrium that this rest leads to, until nothing moves.                      [Maas, Erdemir, Halloran & Weiss
/// 2016]
/// @param given with Body::unstressed, the prestrain; what no support and no load can bear of it is lost
/// @param make, say as of find_unloaded
KeptShape keep_in_place(const Body& given, const std::function<std::shared_ptr<Model>(const Body&)>& make,
                        const StaticOptions& options = {}, const std::function<void(int step, double error)>& say = {});

/// The body with another rest shape: connections get its lengths, times the part that they had of the present ones.
Body with_rest_shape(Body body, const Positions& rest);

}  // namespace elastin
