#pragma once
#include <string>

#include "elastin/core/laws/law.h"

namespace elastin {

/// k = 2 E A/L, A the face between the Voronoi cells of the two molecules, clipped by the hull of the body. Cells fill
/// the hull: Σ A L = 3 V where every pair of neighbours is joined and every molecule at the surface lies in it, and
/// then the mean over all directions of the affine stiffness, (1/6V) Σ k L², is E, with ν = ¼. The sister of Van
/// Gelder's rule for bodies without cells. Relaxation makes disordered bodies softer: calibrate.
struct Voronoi {
  static constexpr std::string_view name = "voronoi";
  static constexpr std::string_view summary =
      "k = 2 E A / L, A the face between the Voronoi cells of the two molecules";
  static constexpr std::string_view source = "affine average of central springs";
  static constexpr bool needs_faces = true;

  static bool needs_voronoi(const Body&) { return true; }
  static std::string unsuited(const Body& body) {
    return body.voronoi ? body.voronoi->problem : "needs the Voronoi cells of its molecules";
  }

  VectorX constants(const Body& body, const Material& material) const {
    VectorX k(body.connections.size());
    for (int c = 0; c < k.size(); ++c)
      k[c] = 2 * material.youngs_modulus * body.voronoi->face_area[c] / body.connections.rest_length[c];
    return k;
  }
};

}  // namespace elastin
