#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "core/model/incidence.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// Exact on simple cubic lattices, and on box lattices of spacings a, b, c, even graded ones: every box (cell of the
/// lattice) gets the constants with which it alone has E and ν = ¼; a connection adds up the boxes that it bounds. With
/// V = a b c and D = a² + b² + c², a box has
///   face diagonals in the plane of a, b: k = (0.4 E V − 4 k₃ a² b²/D) (a² + b²)/(2 a² b²), half of it (they bound two
///   boxes), space diagonals: k₃,   axis a: k = (1.2 E V − 0.4 E V (a²/b² + a²/c²) + 4 k₃ a⁴/D)/a², a quarter of it;
/// they follow from Σ k L² n n n n = 0.4 E V (δδ + δδ + δδ). On a cube: k₁ = k₂ + 8/3 k₃, E = 2.5 (k₂ + 4/3 k₃)/a. With
/// face and space diagonals both there one number is free: `face_part`.
struct Lattice {
  static constexpr std::string_view name = "lattice";
  static constexpr std::string_view summary =
      "exact on simple cubic and box lattices with diagonals: E itself and nu = 1/4";
  static constexpr std::string_view source = "affine lattice sums; Cauchy relations of central springs";
  double face_part = 0.5;
  static constexpr std::array parameters{
      Parameter<Lattice>{"face_part", &Lattice::face_part, dimension::none, 0.01, 0.99,
                         "share of the shear stiffness that face diagonals carry in addition to space diagonals"}};

  static std::string unsuited(const Body& body) {
    if (body.cubes.empty()) return "needs a simple cubic lattice";
    const auto present = kinds(body);
    if (!present[0]) return "needs the lattice's axis connections";
    if (!present[1] && !present[2])
      return "needs face or space diagonals: a lattice of axes alone has no shear stiffness";
    for (const auto& cube : body.cubes) {
      const Vector3 box = sides(body, cube), squares = box.cwiseAbs2();
      if (!present[1] && !(squares.maxCoeff() < 1.1 * squares.minCoeff()))
        return "needs face diagonals: space diagonals alone are exact on cubes only";
      if (Constants(box, face_share(present, Lattice{}.face_part)).axis.minCoeff() < 0)
        return "the lattice's spacings differ too much: no positive constants give E";
    }
    return "";
  }

  VectorX constants(const Body& body, const Material& material) const {
    const double share = face_share(kinds(body), face_part);
    std::vector<Constants> of_cube;
    for (const auto& cube : body.cubes) of_cube.emplace_back(sides(body, cube), share);
    VectorX k = VectorX::Zero(body.connections.size());
    each_share(body, [&](int connection, std::size_t cube, int bits) {
      k[connection] += material.youngs_modulus * of_cube[cube].share(bits);
    });
    return k;
  }

 private:
  static double face_share(const std::array<bool, 3>& present, double face_part) {
    return !present[2] ? 1 : !present[1] ? 0 : face_part;
  }

  /// The box's spacings [m]: each the mean of its four connections.
  static Vector3 sides(const Body& body, const std::array<int, 8>& cube) {
    Vector3 box = Vector3::Zero();
    for (int axis = 0; axis < 3; ++axis)
      for (int corner = 0; corner < 8; ++corner)
        if (!(corner >> axis & 1))
          box[axis] += (body.rest.col(cube[corner | 1 << axis]) - body.rest.col(cube[corner])).norm() / 4;
    return box;
  }

  /// Constants of one box, over E [m].
  struct Constants {
    Vector3 axis, face;  ///< face by the axis that it is across
    double space;

    Constants(const Vector3& box, double face_share) {
      const Vector3 s = box.cwiseAbs2();
      const double V = box.prod(), D = s.sum();
      const double most = s.prod() / s.minCoeff();  // of a² b²
      space = (1 - face_share) * 0.4 * V * D / (4 * most);
      for (int i = 0; i < 3; ++i) {
        const double a = s[i], b = s[(i + 1) % 3], c = s[(i + 2) % 3];
        axis[i] = (1.2 * V - 0.4 * V * (a / b + a / c) + 4 * space * a * a / D) / a;
        face[i] = (0.4 * V - 4 * space * b * c / D) * (b + c) / (2 * b * c);
      }
    }
    /// What a box gives to the connection between two corners whose numbers differ in these bits.
    double share(int bits) const {
      static constexpr std::array<int, 8> direction{-1, 0, 1, 2, 2, 1, 0, -1};
      if (bits == 7) return space;
      return bits == 1 || bits == 2 || bits == 4 ? axis[direction[bits]] / 4 : face[direction[bits]] / 2;
    }
  };

  /// Calls share(connection, cube, bits) for each cube and each connection between two of its corners; bits: in which
  /// directions it goes.
  template <class Share>
  static void each_share(const Body& body, Share share) {
    const Rows incident = connections_of_molecules(body.size(), body.connections);
    for (std::size_t number = 0; number < body.cubes.size(); ++number)
      for (int corner = 0; corner < 8; ++corner) {
        const auto& cube = body.cubes[number];
        for (const int c : incident[cube[corner]]) {
          const auto& [a, b] = body.connections.ends[c];
          const int other = a == cube[corner] ? b : a;
          const auto found = std::find(cube.begin() + corner + 1, cube.end(), other);
          if (found == cube.end()) continue;  // each pair once, from its lower corner
          share(c, number, corner ^ static_cast<int>(found - cube.begin()));
        }
      }
  }

  static std::array<bool, 3> kinds(const Body& body) {
    std::array<bool, 3> present{};
    each_share(body,
               [&](int, std::size_t, int bits) { present[(bits & 1) + (bits >> 1 & 1) + (bits >> 2) - 1] = true; });
    return present;
  }
};

}  // namespace elastin
