#pragma once
#include <algorithm>
#include <array>

#include "elastin/stiffness/law.h"
#include "model/incidence.h"

namespace elastin {

/// Exact on simple cubic lattices: each connection is shared among the cubes that it bounds (axis ¼ a cube, face
/// diagonal ½, space diagonal 1). Full constants k₁ (axis), k₂ (face), k₃ (space) make an isotropic body when k₁ = k₂ +
/// 8/3 k₃; then E = 2.5 (k₂ + 4/3 k₃)/a and ν = ¼. With face and space diagonals both there one number is free:
/// `face_part`.
struct Lattice {
  static constexpr std::string_view name = "lattice";
  static constexpr std::string_view summary = "exact on simple cubic lattices with diagonals: E itself and nu = 1/4";
  static constexpr std::string_view source = "affine lattice sums; Cauchy relations of central springs";
  double face_part = 0.5;
  static constexpr std::array parameters{
      Parameter<Lattice>{"face_part", &Lattice::face_part, dimension::none, 0.01, 0.99,
                         "part of the shear stiffness that face diagonals carry where space diagonals are there too"}};

  static std::string unsuited(const Body& body) {
    if (body.cubes.empty()) return "needs a simple cubic lattice";
    const auto present = kinds(body);
    if (!present[0]) return "needs the lattice's axis connections";
    if (!present[1] && !present[2])
      return "needs face or space diagonals: a lattice of axes alone has no shear stiffness";
    return "";
  }

  VectorX constants(const Body& body, const Material& material) const {
    const auto present = kinds(body);
    const double face_share = !present[2] ? 1 : !present[1] ? 0 : face_part;
    // The corner molecules 0 and 1 of a cube are neighbours along an axis.
    const double side = (body.rest.col(body.cubes[0][1]) - body.rest.col(body.cubes[0][0])).norm();
    const double sum = 0.4 * material.youngs_modulus * side;  // k₂ + 4/3 k₃
    const double k2 = face_share * sum, k3 = (1 - face_share) * sum * 3 / 4, k1 = k2 + 8. / 3 * k3;
    const std::array<double, 3> per_cube{k1 / 4, k2 / 2, k3};
    VectorX k = VectorX::Zero(body.connections.size());
    each_share(body, [&](int connection, int kind) { k[connection] += per_cube[kind]; });
    return k;
  }

 private:
  /// Calls share(connection, kind) for each cube and each connection between two of its corners; kind 0 axis, 1 face, 2
  /// space.
  template <class Share>
  static void each_share(const Body& body, Share share) {
    const Rows incident = connections_of_molecules(body.size(), body.connections);
    for (const auto& cube : body.cubes)
      for (int corner = 0; corner < 8; ++corner)
        for (const int c : incident[cube[corner]]) {
          const auto& [a, b] = body.connections.ends[c];
          const int other = a == cube[corner] ? b : a;
          const auto found = std::find(cube.begin() + corner + 1, cube.end(), other);
          if (found == cube.end()) continue;  // each pair once, from its lower corner
          const int bits = corner ^ static_cast<int>(found - cube.begin());
          share(c, (bits & 1) + (bits >> 1 & 1) + (bits >> 2) - 1);
        }
  }

  static std::array<bool, 3> kinds(const Body& body) {
    std::array<bool, 3> present{};
    each_share(body, [&](int, int kind) { present[kind] = true; });
    return present;
  }
};

}  // namespace elastin
