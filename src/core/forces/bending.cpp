#include "core/forces/bending.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "core/base/dense.h"
#include "core/forces/own_slopes.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

using Pair = std::array<int, 2>;
Pair ordered(int a, int b) { return a < b ? Pair{a, b} : Pair{b, a}; }

/// A triangle and the corners of its neighbours across the sides opposite to its corners, −1 where there is no
/// neighbour.
struct Patch {
  std::array<int, 6> molecules;
  int neighbours = 0;
};

std::vector<Patch> patches_of(const Cells<3>& triangles) {
  std::map<Pair, std::vector<int>> tips;  // of the triangles at each side
  for (const auto& cell : triangles)
    for (std::size_t e = 0; e < 3; ++e) tips[ordered(cell[(e + 1) % 3], cell[(e + 2) % 3])].push_back(cell[e]);
  std::vector<Patch> patches;
  for (const auto& cell : triangles) {
    Patch patch{{cell[0], cell[1], cell[2], -1, -1, -1}, 0};
    for (std::size_t e = 0; e < 3; ++e)
      for (const int tip : tips[ordered(cell[(e + 1) % 3], cell[(e + 2) % 3])])
        if (tip != cell[e]) patch.molecules[3 + e] = tip, ++patch.neighbours;
    patches.push_back(patch);
  }
  return patches;
}

Vector3 normal_of(const Body& body) {
  Vector3 sum = Vector3::Zero();
  for (const auto& [a, b, c] : body.triangles)
    sum += Vector3(body.rest.col(b) - body.rest.col(a)).cross(Vector3(body.rest.col(c) - body.rest.col(a)));
  return sum.normalized();
}

using Plane2 = Eigen::Matrix<double, 2, 3>;  ///< a column a corner

/// Gradients of the barycentric coordinates of a triangle in a plane.
Plane2 gradients_of(const Plane2& corners) {
  Plane2 result;
  Eigen::Matrix2d edges;
  edges << corners.col(1) - corners.col(0), corners.col(2) - corners.col(0);
  result.rightCols<2>() = edges.inverse().transpose();
  result.col(0) = -result.col(1) - result.col(2);
  return result;
}

/// Hinge vectors of a triangle's three sides, as weights of its patch's six places, and its stiffness M between them:
/// energy ½ Σ M_ef h_e·h_f.
struct Plate {
  Eigen::Matrix<double, 3, 6> weights = Eigen::Matrix<double, 3, 6>::Zero();
  Matrix3 stiffness;
};

Plate plate_of(const Patch& patch, const Eigen::Matrix2Xd& positions, double rigidity, double nu) {
  Plane2 own;
  for (int corner = 0; corner < 3; ++corner) own.col(corner) = positions.col(patch.molecules[corner]);
  const Plane2 gradients = gradients_of(own);
  Eigen::Matrix2d edges;
  edges << own.col(1) - own.col(0), own.col(2) - own.col(0);
  const double area = std::abs(edges.determinant()) / 2;
  Plate plate;
  Plane2 normals;
  Vector3 share;  // l/(2A)
  std::vector<int> inner, rim;
  for (int e = 0; e < 3; ++e) {
    normals.col(e) = -gradients.col(e).normalized();
    share[e] = (own.col((e + 2) % 3) - own.col((e + 1) % 3)).norm() / (2 * area);
    const int tip = patch.molecules[3 + e];
    (tip < 0 ? rim : inner).push_back(e);
    if (tip < 0) continue;
    Plane2 other = own;
    other.col(e) = positions.col(tip);
    const Plane2 beyond = gradients_of(other);
    for (int corner = 0; corner < 3; ++corner)
      plate.weights(e, corner == e ? 3 + e : corner) += beyond.col(corner).dot(normals.col(e));
    for (int corner = 0; corner < 3; ++corner) plate.weights(e, corner) -= gradients.col(corner).dot(normals.col(e));
  }
  for (int e = 0; e < 3; ++e)
    for (int f = 0; f < 3; ++f)
      plate.stiffness(e, f) =
          area * rigidity * share[e] * share[f] * ((1 - nu) * std::pow(normals.col(e).dot(normals.col(f)), 2) + nu);
  // On free sides h is what makes the energy least.
  if (!rim.empty() && !inner.empty()) {
    const auto part = [M = plate.stiffness](const std::vector<int>& rows, const std::vector<int>& columns) {
      MatrixX result(rows.size(), columns.size());
      for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t j = 0; j < columns.size(); ++j) result(i, j) = M(rows[i], columns[j]);
      return result;
    };
    const MatrixX followed = product(symmetric_pseudoinverse(part(rim, rim)), part(rim, inner));
    const MatrixX left = part(inner, inner) - product(part(inner, rim), followed);
    plate.stiffness.setZero();
    for (std::size_t i = 0; i < inner.size(); ++i)
      for (std::size_t j = 0; j < inner.size(); ++j) plate.stiffness(inner[i], inner[j]) = left(i, j);
  }
  return plate;
}

class Bending final : public EdgeDensities {
 public:
  Bending(const Body& body, double rigidity, double nu) : patches_(patches_of(body.triangles)) {
    std::map<Pair, int> connections;
    for (int c = 0; c < body.connections.size(); ++c) {
      const auto& [a, b] = body.connections.ends[c];
      connections.emplace(ordered(a, b), c);
    }
    const Vector3 normal = normal_of(body), first = normal.unitOrthogonal();
    Eigen::Matrix<double, 2, 3> frame;
    frame << first.transpose(), normal.cross(first).transpose();
    const Eigen::Matrix2Xd positions = frame * body.rest;
    force_densities_ = VectorX::Zero(body.connections.size());
    for (const Patch& patch : patches_) {
      plates_.push_back(plate_of(patch, positions, rigidity, nu));
      const Eigen::Matrix<double, 6, 6> Q =
          plates_.back().weights.transpose() * plates_.back().stiffness * plates_.back().weights;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < i; ++j) {
          const int a = patch.molecules[i], b = patch.molecules[j];
          if (a < 0 || b < 0 || a == b || Q(i, j) == 0) continue;
          const auto found = connections.find(ordered(a, b));
          if (found == connections.end())
            throw InputError("bending needs a connection between molecules " + std::to_string(a) + " and " +
                             std::to_string(b));
          force_densities_[found->second] -= Q(i, j);
        }
    }
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<Bending>(*this); }
  double energy(const Positions& positions) const override {
    return ordered_sum(static_cast<int>(patches_.size()), [&](int cell) {
      const auto& [weights, stiffness] = plates_[cell];
      Eigen::Matrix<double, 3, 6> relative = Eigen::Matrix<double, 3, 6>::Zero();
      const Vector3 origin = positions.col(patches_[cell].molecules[0]);
      for (int i = 0; i < 6; ++i)
        if (const int molecule = patches_[cell].molecules[i]; molecule >= 0)
          relative.col(i) = positions.col(molecule) - origin;
      const Matrix3 hinges = relative * weights.transpose();
      return (hinges * stiffness).cwiseProduct(hinges).sum() / 2;
    });
  }
  void add_force_densities(const Positions&, VectorX& force_densities, Workspace&) const override {
    force_densities += force_densities_;
  }
  /// Moments, not tensions.
  void add_triangle_force_densities(const Positions&, Eigen::Ref<Eigen::Matrix3Xd>, VectorX&,
                                    Workspace&) const override {}
  /// The force densities do not change.
  std::unique_ptr<EdgeSlopes> slopes() const override {
    return std::make_unique<OwnSlopes>(0, [](const Positions&, VectorX&) {});
  }

 private:
  std::vector<Patch> patches_;
  std::vector<Plate> plates_;
  VectorX force_densities_;
};

}  // namespace

std::vector<std::array<int, 2>> bending_pairs(const Body& body) {
  std::vector<Pair> pairs;
  for (const Patch& patch : patches_of(body.triangles))
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const int a = patch.molecules[i], b = patch.molecules[j];
        if (a >= 0 && b >= 0 && a != b) pairs.push_back(ordered(a, b));
      }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

double bending_excess(const Body& body, double poissons_ratio) {
  const Vector3 normal = normal_of(body), first = normal.unitOrthogonal();
  Eigen::Matrix<double, 2, 3> frame;
  frame << first.transpose(), normal.cross(first).transpose();
  const Eigen::Matrix2Xd positions = frame * body.rest;
  // Bent along four directions and twisted about two: by the curvatures κ_xx, κ_yy, κ_xy.
  const Vector3 curvatures[] = {{1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 0.5}, {0.5, 0.5, -0.5}, {0, 0, 1}, {1, -1, 0}};
  std::array<double, std::size(curvatures)> energies{};
  double whole = 0;
  for (const Patch& patch : patches_of(body.triangles)) {
    if (std::any_of(patch.molecules.begin(), patch.molecules.end(), [](int molecule) { return molecule < 0; }))
      continue;
    const auto [weights, stiffness] = plate_of(patch, positions, 1, poissons_ratio);
    Eigen::Matrix<double, 2, 6> places;
    for (int i = 0; i < 6; ++i) places.col(i) = positions.col(patch.molecules[i]) - positions.col(patch.molecules[0]);
    const Eigen::Matrix2d sides = places.middleCols<2>(1);
    whole += std::abs(sides.determinant()) / 2;
    for (std::size_t k = 0; k < energies.size(); ++k) {
      const Vector3& c = curvatures[k];
      const VectorX heights = (c[0] / 2 * places.row(0).array().square() + c[1] / 2 * places.row(1).array().square() +
                               c[2] * places.row(0).array() * places.row(1).array())
                                  .transpose();
      const Vector3 hinges = weights * heights;
      energies[k] += hinges.dot(stiffness * hinges) / 2;
    }
  }
  double most = whole > 0 ? 0 : 1;
  for (std::size_t k = 0; whole > 0 && k < energies.size(); ++k) {
    const Vector3& c = curvatures[k];
    const double squares = c[0] * c[0] + c[1] * c[1] + 2 * c[2] * c[2], trace = c[0] + c[1];
    most =
        std::max(most, energies[k] / (whole / 2 * ((1 - poissons_ratio) * squares + poissons_ratio * trace * trace)));
  }
  return most;
}

std::string unsuited_for_bending(const Body& body) {
  if (body.triangles.empty()) return "needs triangles";
  constexpr double flat = 1e-6;  // of the size: places in single precision are so far from any plane that is not level
  const VectorX heights = normal_of(body).transpose() * body.rest;
  const double size = (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm();
  if (const double depth = heights.maxCoeff() - heights.minCoeff(); depth > flat * size)
    return "needs a sheet that is flat at rest: this one is " + number(1e3 * depth, 3) + " mm deep, " +
           number(100 * depth / size, 3) + " % of its size";
  std::map<Pair, int> triangles;
  for (const auto& cell : body.triangles)
    for (std::size_t e = 0; e < 3; ++e)
      if (++triangles[ordered(cell[e], cell[(e + 1) % 3])] > 2) return "needs at most two triangles at each side";
  return "";
}

std::unique_ptr<Elasticity> make_bending(const Body& body, double rigidity, double poissons_ratio) {
  return std::make_unique<Bending>(body, rigidity, poissons_ratio);
}

}  // namespace elastin
