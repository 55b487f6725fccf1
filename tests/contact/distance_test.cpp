#include "contact/distance.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"

using namespace elastin;
using namespace elastin::contact;

namespace {

/// A spike of four sides on a square: at its tip the side that is nearest can look away from the point that asks.
shape::Mesh spike() {
  shape::Mesh mesh;
  mesh.points.resize(3, 5);
  mesh.points << -0.1, 0.1, 0.1, -0.1, 0.3,  //
      -0.1, -0.1, 0.1, 0.1, 0.02,            //
      0, 0, 0, 0, 1;
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

/// An L from above: a corner that goes in.
shape::Mesh bracket() {
  shape::Mesh mesh;
  mesh.points.resize(3, 12);
  const double xy[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (int i = 0; i < 6; ++i) {
    mesh.points.col(i) << xy[i][0], xy[i][1], 0;
    mesh.points.col(i + 6) << xy[i][0], xy[i][1], 0.7;
    const int next = (i + 1) % 6;
    mesh.triangles.push_back({i, next, next + 6});
    mesh.triangles.push_back({i, next + 6, i + 6});
  }
  for (const auto& [a, b, c] : Cells<3>{{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + 6, b + 6, c + 6});
  }
  return mesh;
}

/// Points in and around a box from −size to size.
std::vector<Vector3> points_around(double size, int count, unsigned seed) {
  std::mt19937_64 generator(seed);
  const auto number = [&] { return size * (2 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1); };
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const double x = number(), y = number();
    points.emplace_back(x, y, number());
  }
  return points;
}

const std::vector<std::pair<const char*, ObstacleShape>> shapes{
    {"plane", shape::Plane{}},
    {"box", shape::Box{{1, 0.6, 1.4}}},
    {"sphere", shape::Sphere{0.7}},
    {"cylinder", shape::Cylinder{0.5, 1.2}},
    {"capsule", shape::Capsule{0.4, 0.9}},
    {"convex", shape::Convex{spike().points}},
    {"mesh", bracket()},
};

std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Box& s) { return std::make_shared<fcl::Boxd>(s.size); }
std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Sphere& s) {
  return std::make_shared<fcl::Sphered>(s.radius);
}
std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Cylinder& s) {
  return std::make_shared<fcl::Cylinderd>(s.radius, s.length);
}
std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Capsule& s) {
  return std::make_shared<fcl::Capsuled>(s.radius, s.length);
}
std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Mesh& s) {
  auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  model->beginModel();
  for (const auto& [a, b, c] : s.triangles) model->addTriangle(s.points.col(a), s.points.col(b), s.points.col(c));
  model->endModel();
  return model;
}
std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Convex&) { return as_fcl(spike()); }
std::shared_ptr<fcl::CollisionGeometryd> as_fcl(const shape::Plane&) { return nullptr; }

}  // namespace

TEST_CASE("distances to shapes have the values that geometry gives", "[contact]") {
  struct Known {
    ObstacleShape shape;
    Vector3 point;
    double value;
    Vector3 normal;
    double curvature;  // trace of the turning: the sum of both principal curvatures of the level surface
  };
  const double diagonal = std::sqrt(0.5);
  const std::vector<Known> known{
      {shape::Plane{}, {3, 4, -2}, -2, {0, 0, 1}, 0},
      {shape::Box{{2, 2, 2}}, {0.5, 0.2, 1.5}, 0.5, {0, 0, 1}, 0},
      {shape::Box{{2, 2, 2}}, {-0.9, 0.2, 0.1}, -0.1, {-1, 0, 0}, 0},
      {shape::Box{{2, 2, 2}}, {2, 0, -2}, std::sqrt(2), {diagonal, 0, -diagonal}, 1 / std::sqrt(2)},
      {shape::Box{{2, 2, 2}}, {3, 3, 2}, 3, {2. / 3, 2. / 3, 1. / 3}, 2. / 3},
      {shape::Sphere{2}, {0, 3, 0}, 1, {0, 1, 0}, 2. / 3},
      {shape::Sphere{2}, {0, 0, -1.5}, -0.5, {0, 0, -1}, 2 / 1.5},
      {shape::Cylinder{1, 2}, {0, 1.5, 0.3}, 0.5, {0, 1, 0}, 1 / 1.5},
      {shape::Cylinder{1, 2}, {0.3, 0.2, -1.5}, 0.5, {0, 0, -1}, 0},
      {shape::Cylinder{1, 2}, {0.8, 0, 0}, -0.2, {1, 0, 0}, 1 / 0.8},
      {shape::Cylinder{1, 2}, {2, 0, 2}, std::sqrt(2), {diagonal, 0, diagonal}, 1 / std::sqrt(2) + diagonal / 2},
      {shape::Capsule{1, 2}, {0, -3, 0.5}, 2, {0, -1, 0}, 1. / 3},
      {shape::Capsule{1, 2}, {0, 0, 4}, 2, {0, 0, 1}, 2. / 3},
      {shape::Capsule{1, 2}, {0.5, 0, 0}, -0.5, {1, 0, 0}, 2},
  };
  for (const Known& one : known) {
    const Distance distance = SignedDistance(one.shape).at(one.point);
    CAPTURE(one.shape.index(), one.point.transpose());
    CHECK(distance.value == Approx(one.value).epsilon(1e-14));
    CHECK((distance.normal - one.normal).norm() < 1e-14);
    CHECK(distance.turning.trace() == Approx(one.curvature).epsilon(1e-13).margin(1e-14));
  }
}

TEST_CASE("the normal is the distance's gradient and the turning the normal's", "[contact]") {
  for (const auto& [name, shape] : shapes) {
    const SignedDistance solid(shape);
    for (const Vector3& point : points_around(1.3, 400, 3)) {
      const Distance distance = solid.at(point);
      CAPTURE(name, point.transpose(), distance.value);
      CHECK(distance.normal.norm() == Approx(1).epsilon(1e-14));
      CHECK((distance.turning - distance.turning.transpose()).norm() < 1e-14 * (1 + distance.turning.norm()));
      CHECK((distance.turning * distance.normal).norm() < 1e-13 * (1 + distance.turning.norm()));
      constexpr double h = 1e-6;
      Vector3 gradient;
      Matrix3 turning;
      bool smooth = true;  // not where the nearest point jumps to another side between the points of a difference
      for (int axis = 0; axis < 3; ++axis) {
        const Distance ahead = solid.at(point + h * Vector3::Unit(axis));
        const Distance behind = solid.at(point - h * Vector3::Unit(axis));
        gradient[axis] = (ahead.value - behind.value) / (2 * h);
        turning.col(axis) = (ahead.normal - behind.normal) / (2 * h);
        smooth = smooth && (ahead.turning - behind.turning).norm() < 1e-3 * (1 + distance.turning.norm());
        smooth = smooth && (ahead.normal - behind.normal).norm() < 1e-3;
      }
      if (!smooth) continue;
      CHECK((gradient - distance.normal).norm() < 1e-8);
      CHECK((turning - distance.turning).norm() < 1e-7 * std::pow(1 + distance.turning.norm(), 2));
    }
  }
}

TEST_CASE("outside, distances are those of FCL's narrow phase", "[contact]") {
  constexpr double small = 1e-3;
  for (const auto& [name, shape] : shapes) {
    if (std::holds_alternative<shape::Plane>(shape)) continue;
    const SignedDistance solid(shape);
    const auto geometry = std::visit([](const auto& one) { return as_fcl(one); }, shape);
    const fcl::CollisionObjectd object(geometry);
    int compared = 0;
    for (const Vector3& point : points_around(2, 100, 4)) {
      const double value = solid.at(point).value;
      if (value < 2 * small) continue;
      const fcl::CollisionObjectd ball(std::make_shared<fcl::Sphered>(small), Matrix3::Identity(), point);
      fcl::DistanceRequestd request;
      fcl::DistanceResultd result;
      const double distance = fcl::distance(&object, &ball, request, result);
      CAPTURE(name, point.transpose());
      CHECK(value == Approx(distance + small).margin(2e-6));  // FCL's general solver stops at 1e-6
      ++compared;
    }
    CHECK(compared > 50);
  }
}

TEST_CASE("a mesh and a hull of a box are the box, inside, outside and beyond its corners", "[contact]") {
  const Vector3 size(1, 0.6, 1.4);
  shape::Mesh mesh;
  mesh.points.resize(3, 8);
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) mesh.points(axis, corner) = (corner >> axis & 1 ? 0.5 : -0.5) * size[axis];
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, up = 1 << axis;
    mesh.triangles.insert(mesh.triangles.end(), {{up, up | u, up | u | v}, {up, up | u | v, up | v}});
    mesh.triangles.insert(mesh.triangles.end(), {{0, v, u | v}, {0, u | v, u}});
  }
  shape::Convex convex{Positions(3, 9)};
  convex.points << mesh.points, Vector3(0.1, 0.1, 0.2);
  const SignedDistance box(shape::Box{size}), as_mesh(mesh), as_hull(convex);
  for (const Vector3& point : points_around(1.2, 1000, 5)) {
    const Distance expected = box.at(point);
    for (const SignedDistance* other : {&as_mesh, &as_hull}) {
      const Distance distance = other->at(point);
      CAPTURE(point.transpose());
      CHECK(distance.value == Approx(expected.value).margin(1e-14));
      CHECK((distance.normal - expected.normal).norm() < 1e-12);
      CHECK((distance.turning - expected.turning).norm() < 1e-10 * (1 + expected.turning.norm()));
    }
  }
}

TEST_CASE("inside and outside of a leaning spike and of a bracket, also next to sides and corners", "[contact]") {
  const SignedDistance tip(spike()), hull(shape::Convex{spike().points}), angle(bracket());
  for (const Vector3& point : points_around(1.2, 2000, 6)) {
    CAPTURE(point.transpose());
    CHECK(tip.at(point).value == Approx(hull.at(point).value).margin(1e-14));
    bool in_spike = true;
    for (const auto& triangle : spike().triangles)
      in_spike = in_spike && area_vector(spike().points, triangle).dot(point - spike().points.col(triangle[0])) < 0;
    CHECK((tip.at(point).value < 0) == in_spike);
    const bool in_bracket =
        point.minCoeff() > 0 && point.z() < 0.7 && point.maxCoeff() < 2 && (point.x() < 1 || point.y() < 1);
    CHECK((angle.at(point).value < 0) == in_bracket);
  }
}

TEST_CASE("where no direction is nearer than another the normal is still a unit vector", "[contact]") {
  for (const auto& [name, shape] : shapes) {
    const SignedDistance solid(shape);
    std::vector<Vector3> points{{0, 0, 0}, {0, 0, 0.3}, {0.1, 0.1, 0}, {0, 0, 0.6}, {0, 0, -0.7}, {0.5, 0, 0}};
    for (const Vector3& corner : {Vector3(0.5, 0.3, 0.7), Vector3(1, 1, 0), Vector3(1, 1, 0.3), Vector3(0.3, 0.02, 1)})
      points.push_back(corner);
    for (const Vector3& point : points) {
      const Distance distance = solid.at(point);
      CAPTURE(name, point.transpose());
      CHECK(std::isfinite(distance.value));
      CHECK(distance.normal.norm() == Approx(1).epsilon(1e-12));
      CHECK(distance.turning.allFinite());
    }
  }
}

TEST_CASE("invalid shapes are named", "[contact]") {
  using Catch::Contains;
  CHECK_THROWS_WITH(SignedDistance(shape::Sphere{0}), Contains("radius") && Contains("above 0"));
  CHECK_THROWS_WITH(SignedDistance(shape::Box{{1, -1, 1}}), Contains("size"));
  CHECK_THROWS_WITH(SignedDistance(shape::Cylinder{1, NAN}), Contains("length"));
  CHECK_THROWS_WITH(SignedDistance(shape::Mesh{Positions::Zero(3, 3), {}}), Contains("no triangles"));
  CHECK_THROWS_WITH(SignedDistance(shape::Mesh{Positions::Zero(3, 3), {{0, 1, 3}}}),
                    Contains("point 3") && Contains("0 to 2"));
  CHECK_THROWS_WITH(SignedDistance(shape::Convex{Positions::Zero(3, 3)}), Contains("fewer than 4 points"));
  Positions flat = Positions::Random(3, 9);
  flat.row(1).setZero();
  CHECK_THROWS_AS(SignedDistance(shape::Convex{flat}), InputError);
}
