#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "core/laws/springs/section.h"
#include "core/model/incidence.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// k₀ = (E A / l₀) / (1 + Σ cos_i (l_i/l₀)^p): the neighbours of a connection carry part of its load, each by the
/// cosine of the angle between them. [M03, eq. 16]; eq. 17 is lost, this is the reading of its text (p = 1: k_i/l_i
/// equal). The sum runs over the connections that share an end with 0 and open to the same side (cos_i > 0); the sums
/// of the two ends are averaged.
struct Angles {
  static constexpr std::string_view name = "angles";
  static constexpr std::string_view summary = "standard, less what connections at an angle carry (cosine-weighted)";
  static constexpr std::string_view source = "[M03] eq. 16 (eq. 17 is lost: a reading)";
  double exponent = 1;
  static constexpr std::array parameters{Parameter<Angles>{"exponent", &Angles::exponent, dimension::none, -4, 4,
                                                           "exponent p of (l_i/l0)^p; 1 is the paper's derivation"}};

  VectorX constants(const Body& body, const Material& material) const { return constants(body, material, body.rest); }

  /// The same with the angles and the ratios l_i/l₀ of molecules that stand at `positions` [m]; the connection's own
  /// bar keeps its nominal length.
  VectorX constants(const Body& body, const Material& material, const Positions& positions) const {
    const auto& ends = body.connections.ends;
    const int count = body.connections.size();
    Positions direction(3, count);  // unit vector from the first to the second end
    VectorX length(count);
    for (int c = 0; c < count; ++c) {
      const Vector3 d = positions.col(ends[c][1]) - positions.col(ends[c][0]);
      length[c] = d.norm();
      direction.col(c) = d / length[c];
    }
    const Rows incident = connections_of_molecules(body.size(), body.connections);
    VectorX k(count);
    for (int c = 0; c < count; ++c) {
      double sum = 0;
      for (const int molecule : ends[c])
        for (const int other : incident[molecule]) {
          if (other == c) continue;
          const bool same_sense = (ends[other][0] == molecule) == (ends[c][0] == molecule);
          const double cosine = (same_sense ? 1 : -1) * direction.col(other).dot(direction.col(c));
          // Rounding must not make a right angle count.
          if (cosine > 1e-9) sum += cosine * std::pow(length[other] / length[c], exponent) / 2;
        }
      k[c] = material.youngs_modulus * connection_section(body, c) / body.connections.rest_length[c] / (1 + sum);
    }
    return k;
  }
};

}  // namespace elastin
