#pragma once
#include <cmath>

#include "core/laws/springs/van_gelder.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// Springs fitted to the linear finite-element stiffness of equilateral cells, applied to any. [LSH07]
/// Triangles: k = Σ E t √3/4 |T|/|T₀|, |T₀| = √3/4 c² the equilateral triangle on side c. Tetrahedra: 24/25 of Van
/// Gelder's.
struct Lloyd {
  static constexpr std::string_view name = "lloyd";
  static constexpr std::string_view summary = "springs fitted to the linear finite elements of regular cells";
  static constexpr std::string_view source = "[LSH07], [TP] eq. 4";
  static constexpr bool on_cells = true;
  static std::string unsuited(const Body& body) { return VanGelder::unsuited(body); }

  VectorX constants(const Body& body, const Material& material) const {
    VectorX k = VectorX::Zero(body.connections.size());
    const auto& length = body.connections.rest_length;
    const auto tetrahedra = connections_of_each_cell<4>(body.connections, body.tetrahedra);
    for (std::size_t cell = 0; cell < tetrahedra.size(); ++cell)
      for (const int c : tetrahedra[cell])
        k[c] += 24. / 25 * material.youngs_modulus * signed_volume(body.rest, body.tetrahedra[cell]) /
                (length[c] * length[c]);
    const double root3 = std::sqrt(3.);
    const auto triangles = connections_of_each_cell<3>(body.connections, body.triangles);
    for (std::size_t cell = 0; cell < triangles.size(); ++cell) {
      const auto& [a, b, c] = body.triangles[cell];
      const Vector3 ab = body.rest.col(b) - body.rest.col(a), ac = body.rest.col(c) - body.rest.col(a);
      const double area = ab.cross(ac).norm() / 2;
      for (const int side : triangles[cell]) {
        const double equilateral = root3 / 4 * length[side] * length[side];
        k[side] += material.youngs_modulus * material.thickness * root3 / 4 * area / equilateral;
      }
    }
    return k;
  }
};

}  // namespace elastin
