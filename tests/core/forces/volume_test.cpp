#include "core/forces/volume.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "elastin/core/base/error.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/parallel/threads.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kModulus = 3e4;

Model volume_model(const Body& body) {
  Model model(body);
  model.add(make_volume(body, kModulus));
  return model;
}

double box_volume(const Body& body) { return (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).prod(); }

/// Volume of the trilinear hexahedron by 2 × 2 × 2 Gauss points, which integrate its Jacobian exactly.
double hexahedron_volume(const Positions& positions, const std::array<int, 8>& cube) {
  const double g = 1 / std::sqrt(3.);
  double volume = 0;
  for (int point = 0; point < 8; ++point) {
    const Vector3 xi(point & 1 ? g : -g, point & 2 ? g : -g, point & 4 ? g : -g);
    Matrix3 jacobian = Matrix3::Zero();
    for (int c = 0; c < 8; ++c) {
      const Vector3 s(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1), f = Vector3::Ones() + s.cwiseProduct(xi);
      const Vector3 slope(s.x() * f.y() * f.z(), f.x() * s.y() * f.z(), f.x() * f.y() * s.z());
      jacobian += positions.col(cube[c]) * slope.transpose() / 8;
    }
    volume += jacobian.determinant();
  }
  return volume;
}

}  // namespace

TEST_CASE("volume term: the energy of a lattice is that of its trilinear hexahedra", "[volume]") {
  const Body body = jittered_lattice(0.2);
  const Positions positions = deformed(body, 1e-3);
  double energy = 0;
  for (const auto& cube : body.cubes) {
    const double rest = hexahedron_volume(body.rest, cube), J = hexahedron_volume(positions, cube) / rest;
    energy += kModulus / 2 * (J - 1) * (J - 1) * rest;
  }
  CHECK(volume_model(body).elastic_energy(positions) == Approx(energy).epsilon(1e-12));
}

TEST_CASE("volume term: the energy of a tetrahedral body is that of its molecules' mean dilatation", "[volume]") {
  const Body body = jittered_block();
  const Positions positions = deformed(body, 5e-4);
  double energy = 0;
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    double rest = 0, now = 0;
    for (const auto& cell : body.tetrahedra)
      if (std::find(cell.begin(), cell.end(), molecule) != cell.end()) {
        rest += signed_volume(body.rest, cell) / 4;
        now += signed_volume(positions, cell) / 4;
      }
    energy += kModulus / 2 * (now / rest - 1) * (now / rest - 1) * rest;
  }
  CHECK(volume_model(body).elastic_energy(positions) == Approx(energy).epsilon(1e-12));
}

TEST_CASE("volume term: uniform strain leaves no force inside, and its pressure on the faces: the patch test",
          "[volume]") {
  Matrix3 F;
  F << 1.05, 0.02, -0.01, 0.03, 0.9, 0.04, 0, -0.02, 1.1;
  const double J = F.determinant(), pressure = kModulus * (J - 1);
  for (const Body& body : {jittered_lattice(), jittered_block()}) {
    const Model model = volume_model(body);
    const Positions positions = F * body.rest, forces = model.elastic_forces(positions);
    const Vector3 low = body.rest.rowwise().minCoeff(), high = body.rest.rowwise().maxCoeff();
    const double size = std::abs(pressure) * 1e-4;  // of a connection's length squared
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      const Vector3 position = body.rest.col(molecule);
      const bool inside =
          (position.array() > low.array() + 1e-9).all() && (position.array() < high.array() - 1e-9).all();
      if (inside) CHECK(forces.col(molecule).norm() <= 1e-12 * size);
    }
    CHECK(model.elastic_energy(positions) ==
          Approx(kModulus / 2 * (J - 1) * (J - 1) * box_volume(body)).epsilon(1e-12));
    // Virtual work of a uniform strain of the deformed body: −Σ f·x = 3 p V.
    CHECK(-forces.cwiseProduct(positions).sum() == Approx(3 * pressure * J * box_volume(body)).epsilon(1e-12));
  }
}

TEST_CASE("volume term: tetrahedra may invert inside a group, a group may not", "[volume]") {
  // Pulled through the base by its tip, one tetrahedron of a cube inverts while the cube keeps volume.
  Body body = cubic_lattice({2, 2, 2}, 1, {true, true, false});
  const Model model = volume_model(body);
  Positions positions = body.rest;
  positions.col(0) = Vector3(0.5, 0.5, 0.5);
  REQUIRE(signed_volume(positions, {0, 1, 2, 4}) < 0);
  CHECK(std::isfinite(model.elastic_energy(positions)));
  const Positions motion = random_motion(body, 3), forces = model.elastic_forces(positions);
  const double h = 1e-5;
  CHECK((model.elastic_energy(positions + h * motion) - model.elastic_energy(positions - h * motion)) / (2 * h) ==
        Approx(-forces.cwiseProduct(motion).sum()).epsilon(1e-8));
  positions = body.rest;
  positions.row(2) *= -1;
  CHECK(model.elastic_energy(positions) == std::numeric_limits<double>::infinity());
}

TEST_CASE("volume term: a flat tetrahedron gives finite forces", "[volume]") {
  const Body body = cubic_lattice({2, 2, 2}, 1, {true, true, false});
  Positions positions = body.rest;
  positions.col(0) = Vector3(1, 1, 1) / 3;  // in the plane of 1, 2 and 4
  const Model model = volume_model(body);
  CHECK(model.elastic_forces(positions).allFinite());
  CHECK(model.elastic_forces(positions).norm() < 10 * kModulus);
}

TEST_CASE("volume term: bitwise identical on 1, 2 and 3 threads", "[volume][threads]") {
  const Body body = cubic_lattice({19, 19, 19}, 0.01, {true, true, false});  // 58 320 tetrahedra: several threads
  const Positions positions = deformed(body, 2e-4);
  std::vector<Positions> forces;
  for (const int count : {1, 2, 3}) {
    set_threads(count);
    forces.push_back(volume_model(body).elastic_forces(positions));
  }
  set_threads(0);
  CHECK(forces[0] == forces[1]);
  CHECK(forces[0] == forces[2]);
}

TEST_CASE("volume term: bodies without volumes are refused with what they need", "[volume]") {
  CHECK_THROWS_WITH(make_volume(listed_body({{0, 0, 0}, {1, 0, 0}}, {{0, 1}}), 1), Catch::Contains("delaunay"));
  CHECK_THROWS_WITH(make_volume(cubic_lattice({2, 2, 2}, 1, {true, false, true}), 1),
                    Catch::Contains("face diagonals"));
  CHECK(unsuited_for_volumes(jittered_block()).empty());
}
