#pragma once
#include <vector>

#include "core/laws/springs/section.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// k = (E₁ a₁ + E₂ a₂) / (2 L), a = 2 A / D(N), N the molecule's number of connections. [M03, Fig. 7]
struct Statistical {
  static constexpr std::string_view name = "statistical";
  static constexpr std::string_view summary = "standard with the cross-section shared by the number of connections";
  static constexpr std::string_view source = "[M03] fig. 7";

  /// How many connections share a molecule's section. The paper leaves N = 8 and N = 12 open; the steps on both sides
  /// give 7 and 8 there, so the rows "N − 1" and "N − 4" are taken to start at 8 and 12.
  static double sharers(int connections) {
    if (connections < 8) return connections;
    if (connections < 12) return connections - 1;
    if (connections < 20) return connections - 4;
    return connections / 2.;
  }

  VectorX constants(const Body& body, const Material& material) const {
    std::vector<int> degree(body.size(), 0);
    for (const auto& [a, b] : body.connections.ends) ++degree[a], ++degree[b];
    VectorX k(body.connections.size());
    for (int c = 0; c < k.size(); ++c) {
      const auto& [a, b] = body.connections.ends[c];
      const double area = 2 * section(body, a) / sharers(degree[a]) + 2 * section(body, b) / sharers(degree[b]);
      k[c] = material.youngs_modulus * area / (2 * body.connections.rest_length[c]);
    }
    return k;
  }
};

}  // namespace elastin
