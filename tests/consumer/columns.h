#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "elastin/core/laws/law.h"

/// A spring rule of this program's own, for cubic lattices that are joined along their axes: k = E A / L, where A is
/// the section that the connection stands for. Inside it is L²; at a face of the body half the square lies outside, at
/// an edge three quarters. The columns under tension then bear exactly E.
struct Columns {
  static constexpr std::string_view name = "columns";
  static constexpr std::string_view summary = "k = E A / L with the section inside the body; cubic lattices";
  static constexpr std::string_view source = "this program";

  elastin::VectorX constants(const elastin::Body& body, const elastin::Material& material) const {
    // Connections of each molecule along x, y, z: two inside, one at a face.
    std::vector<std::array<int, 3>> next_to(body.size());
    for (const auto& [a, b] : body.connections.ends)
      for (const int end : {a, b}) ++next_to[end][direction(body, a, b)];
    elastin::VectorX k(body.connections.size());
    for (int c = 0; c < k.size(); ++c) {
      const auto [a, b] = body.connections.ends[c];
      double section = body.connections.rest_length[c] * body.connections.rest_length[c];
      for (int axis = 0; axis < 3; ++axis)
        if (axis != direction(body, a, b)) section *= next_to[a][axis] / 2.0;
      k[c] = material.youngs_modulus * section / body.connections.rest_length[c];
    }
    return k;
  }

 private:
  static int direction(const elastin::Body& body, int a, int b) {
    Eigen::Index axis;
    (body.rest.col(b) - body.rest.col(a)).cwiseAbs().maxCoeff(&axis);
    return static_cast<int>(axis);
  }
};
