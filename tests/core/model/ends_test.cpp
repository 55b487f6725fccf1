// The end of a body whose cells do not end in one plane.

#include "core/model/ends.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "core/model/faces.h"
#include "core/shapes/orders.h"
#include "core/shapes/refinement.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/model/share.h"
#include "elastin/core/shapes/shapes.h"
#include "support/processes.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// A bar of 20 × 5 × 5 whose ends are the molecules at x = 0 and x = 20.
Body bar(BlockKind kind) { return tetrahedral_block(kind, {8, 2, 2}, {20, 5, 5}); }

/// The same with every molecule of its ends moved along x by up to `amount`.
Body rough(Body body, double amount, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> moved(-amount, amount);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (const double x = body.rest(0, molecule); x < 1e-9 || x > 20 - 1e-9) body.rest(0, molecule) += moved(generator);
  set_present_lengths(body);
  return body;
}

Body turned(Body body, double degrees) {
  body.rest = Eigen::AngleAxisd(degrees * M_PI / 180, Vector3(0, 0.6, 0.8)).toRotationMatrix() * body.rest;
  return body;
}

}  // namespace

TEST_CASE("a rough or tilted end is held whole, on cells of every kind", "[ends]") {
  for (const BlockKind kind : {BlockKind::kuhn, BlockKind::alternating, BlockKind::body_centred})
    for (const auto& shaped : std::vector<std::function<Body(const Body&)>>{
             [](const Body& body) { return body; }, [](const Body& body) { return with_order(body, 2); },
             [](const Body& body) { return refined(body); }})
      for (const Vector3& direction : {Vector3(Vector3::UnitX()), Vector3(-Vector3::UnitX())}) {
        const Face plane = end_face(shaped(bar(kind)), direction, 0);
        CHECK(plane.area == Approx(25));
        CHECK(plane.tilted == Vector3::Zero());
        for (unsigned seed = 1; seed <= 3; ++seed) {
          const Face face = end_face(shaped(rough(bar(kind), 0.2, seed)), direction, 0);
          CHECK(face.molecules == plane.molecules);
          CHECK(face.area == Approx(25));  // a surface over the section has the section's area, seen along the axis
          CHECK(face.tilted.dot(direction) > 0.99);
        }
        for (const double angle : {0.01, 2., 20., 40.}) {
          const Body body = turned(shaped(bar(kind)), angle);
          const Face face = end_face(body, direction, 0);
          CHECK(face.molecules == plane.molecules);
          CHECK(face.area == Approx(25 * std::cos(angle * M_PI / 180)));
          CHECK(std::acos(face.tilted.dot(direction)) * 180 / M_PI == Approx(angle).margin(1e-3));
        }
      }
}

TEST_CASE("a rounded end is its cap of 45 degrees; a small plane one with an edge stays what it is", "[ends]") {
  Body ball = sphere(1, SphereMesh::icosahedron, 12);
  // Its triangles with the middle make cells.
  ball.rest.conservativeResize(3, ball.size() + 1);
  ball.rest.rightCols<1>().setZero();
  for (const auto& [a, b, c] : ball.triangles) ball.tetrahedra.push_back({ball.size() - 1, a, b, c});
  const Face cap = end_face(ball, Vector3(0.3, 0.5, 0.81).normalized(), 0);
  CHECK(cap.area == Approx(M_PI / 2).epsilon(0.1));
  // A frustum whose sides lie 12° off the axis, with a top of a hundredth of its base.
  Body frustum = tetrahedral_block(BlockKind::kuhn, {3, 3, 6}, {1, 1, 2});
  for (int molecule = 0; molecule < frustum.size(); ++molecule)
    frustum.rest.col(molecule).head<2>() *= 1 - 0.9 * frustum.rest(2, molecule) / 2;
  const Face top = end_face(frustum, Vector3::UnitZ(), 0);
  CHECK(top.area == Approx(0.01));
  CHECK(top.tilted == Vector3::Zero());
}

TEST_CASE("two legs that end nearly at one height are one end", "[ends]") {
  Body legs = rough(bar(BlockKind::kuhn), 0.1, 4);
  const int count = legs.size();
  legs.rest.conservativeResize(3, 2 * count);
  legs.rest.rightCols(count) = legs.rest.leftCols(count).colwise() + Vector3(0.05, 20, 0);
  const std::size_t cells = legs.tetrahedra.size();
  for (std::size_t cell = 0; cell < cells; ++cell) {
    legs.tetrahedra.push_back(legs.tetrahedra[cell]);
    for (int& corner : legs.tetrahedra.back()) corner += count;
  }
  CHECK(end_face(legs, Vector3::UnitX(), 0).area == Approx(50));
}

TEST_CASE("the uneven edge of a sheet of triangles is held whole", "[ends]") {
  Body sheet = rectangular_sheet({20, 5}, {16, 4}, SheetPattern::crossed);
  const Face plane = end_face(sheet, Vector3::UnitX(), 0);
  CHECK(plane.molecules.size() == 5);
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> moved(-0.1, 0.1);
  for (const int molecule : plane.molecules) sheet.rest(0, molecule) += moved(generator);
  CHECK(end_face(sheet, Vector3::UnitX(), 0).molecules == plane.molecules);
}

TEST_CASE("the end of a sheet shares a force as a uniform load along it does", "[ends]") {
  Body sheet = rectangular_sheet({20, 5}, {8, 4}, SheetPattern::one_way);
  const double across[] = {0, 0.7, 2, 3.1, 5};  // uneven
  std::vector<int> end = end_face(sheet, Vector3::UnitX(), 0).molecules;
  std::sort(end.begin(), end.end(), [&](int a, int b) { return sheet.rest(1, a) < sheet.rest(1, b); });
  REQUIRE(end.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) sheet.rest(1, end[i]) = across[i];
  const double halves[] = {0.35, 1, 1.2, 1.5, 0.95};
  const auto check = [&](const Body& body, const Vector3& direction) {
    const Face face = end_face(body, direction, 0);
    CHECK(face.share.sum() == Approx(1));
    for (std::size_t i = 0; i < 5; ++i) {
      const auto at = std::find(face.molecules.begin(), face.molecules.end(), end[i]);
      REQUIRE(at != face.molecules.end());
      CHECK(face.share[at - face.molecules.begin()] == Approx(halves[i] / 5));
    }
  };
  const Body tilted = turned(sheet, 40);
  const Vector3 direction = Eigen::AngleAxisd(40 * M_PI / 180, Vector3(0, 0.6, 0.8)) * Vector3::UnitX();
  check(sheet, Vector3::UnitX());
  check(tilted, direction);
  Body net = tilted;  // of molecules and connections alone
  net.triangles.clear();
  check(net, direction);
  // A grip of two layers: molecules behind each other share their place.
  const Face deep = face_of(net, end_face(net, direction, 2.5).molecules, direction);
  CHECK(deep.molecules.size() == 10);
  CHECK(deep.share.sum() == Approx(1));
  // Of second order: 1/6, 4/6, 1/6 of each side.
  const Body second = with_order(rectangular_sheet({20, 5}, {8, 4}, SheetPattern::one_way), 2);
  const Face quadratic = end_face(second, Vector3::UnitX(), 0);
  REQUIRE(quadratic.molecules.size() == 9);
  for (std::size_t i = 0; i < 9; ++i) {
    const double y = second.rest(1, quadratic.molecules[i]) / 1.25, off = std::abs(y - std::round(y));
    const double expected = off > 0.25 ? 4. / 6 : y < 0.1 || y > 3.9 ? 1. / 6 : 2. / 6;
    CHECK(quadratic.share[static_cast<Eigen::Index>(i)] == Approx(expected / 4));
  }
}

TEST_CASE("the end of a body in shares is that of the whole", "[ends][share]") {
  const Body whole = turned(rough(bar(BlockKind::body_centred), 0.1, 6), 3);
  const Face end = end_face(whole, Vector3::UnitX(), 0);
  const auto wrong = on_processes(3, [&](const auto& processes) {
    std::string why;
    const Body share = share_out([&] { return whole; }, processes, why);
    const Face face = end_face(share, Vector3::UnitX(), 0);
    int differing = std::abs(face.area / end.area - 1) > 1e-12 || (face.tilted - end.tilted).norm() > 1e-12;
    for (int molecule = 0; molecule < share.size(); ++molecule) {
      const bool held = std::binary_search(face.molecules.begin(), face.molecules.end(), molecule);
      const int number = static_cast<int>(number_in_whole(share, molecule));
      differing += held != std::binary_search(end.molecules.begin(), end.molecules.end(), number);
    }
    return differing;
  });
  CHECK(wrong == std::vector{0, 0, 0});
}
