#pragma once
#include <cmath>

#include "core/model/incidence.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// Tetrahedra: k = E Σ V(T) / L² over the tetrahedra on the connection [VG98; M03 eq. 15]. Triangles, thickness t:
/// k = Σ E t/(1+ν) |T|/c² + E t ν/(1−ν²) (a²+b²−c²)/(8|T|), c the connection's side [TP eq. 1]; negative where the
/// angle across is obtuse enough. Not exact on any mesh: blocks measure 0.9 to 1.2 E.
struct VanGelder {
  static constexpr std::string_view name = "van_gelder";
  static constexpr std::string_view summary =
      "k = E sum of V/L^2 over the cells on the connection (areas on membranes)";
  static constexpr std::string_view source = "[VG98], [M03] eq. 15, [TP] eq. 1";
  static constexpr bool on_cells = true;

  static std::string unsuited(const Body& body) {
    return body.tetrahedra.empty() && body.triangles.empty() ? "needs tetrahedra or triangles" : "";
  }

  VectorX constants(const Body& body, const Material& material) const {
    return constants(body, material, material.poissons_ratio);
  }

  /// The same with a Poisson's ratio of its own for the triangles; 0 is the simplified rule.
  static VectorX constants(const Body& body, const Material& material, double nu) {
    const double E = material.youngs_modulus, t = material.thickness;
    VectorX k = VectorX::Zero(body.connections.size());
    const auto squared = [&](int c) { return body.connections.rest_length[c] * body.connections.rest_length[c]; };
    const auto tetrahedra = connections_of_each_cell<4>(body.connections, body.tetrahedra);
    for (std::size_t cell = 0; cell < tetrahedra.size(); ++cell)
      for (const int c : tetrahedra[cell]) k[c] += E * signed_volume(body.rest, body.tetrahedra[cell]) / squared(c);
    for (const auto& sides : connections_of_each_cell<3>(body.connections, body.triangles)) {
      const double sum = squared(sides[0]) + squared(sides[1]) + squared(sides[2]);
      double sixteen_area_squared = sum * sum;
      for (const int c : sides) sixteen_area_squared -= 2 * squared(c) * squared(c);
      const double area = std::sqrt(sixteen_area_squared) / 4;
      for (const int c : sides)
        k[c] += E * t / (1 + nu) * area / squared(c) + E * t * nu / (1 - nu * nu) * (sum - 2 * squared(c)) / (8 * area);
    }
    return k;
  }
};

}  // namespace elastin
