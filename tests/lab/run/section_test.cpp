#include "lab/run/section.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/model/solid_cells.h"
#include "elastin/core/shapes/arrays.h"
#include "lab/experiment/bending/bending.h"
#include "lab/experiment/shear/shear.h"
#include "lab/experiment/tension/tension.h"
#include "lab/experiment/torsion/torsion.h"
#include "lab/run/specimen.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();

/// A wall of triangles that stands on a line in the plane of x and y, in equal layers along z; closed: the line's last
/// point is joined to the first.
Body wall_on(const std::vector<Eigen::Vector2d>& line, bool closed, int layers, double height) {
  const int along = static_cast<int>(line.size());
  BodyArrays arrays;
  arrays.positions.resize(3, along * (layers + 1));
  for (int molecule = 0; molecule < arrays.positions.cols(); ++molecule)
    arrays.positions.col(molecule) << line[molecule % along], molecule / along * height / layers;
  for (int layer = 0; layer < layers; ++layer)
    for (int i = 0; i + (closed ? 0 : 1) < along; ++i) {
      const int a = layer * along + i, b = layer * along + (i + 1) % along;
      const bool even = (i + layer) % 2 == 0;
      arrays.triangles.push_back({a, b, even ? b + along : a + along});
      arrays.triangles.push_back({even ? a : b, b + along, a + along});
    }
  arrays.density = 1000, arrays.thickness = 1e-3;
  return make_body(arrays);
}

/// `count` points on a part of a circle, from its right, 1: all of it, closed.
std::vector<Eigen::Vector2d> circle(double radius, int count, double part = 1) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * part * i / (part < 1 ? count - 1 : count);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return points;
}

/// A bar of 3 × 3 × 6 mm without its core of 1 mm²: a section of 8 mm² in a hull of 9 mm².
Body hollow_bar() {
  Body body = tetrahedral_block(BlockKind::kuhn, {3, 3, 6}, {0.003, 0.003, 0.006});
  std::erase_if(body.tetrahedra, [&](const std::array<int, 4>& cell) {
    Vector3 middle = Vector3::Zero();
    for (const int corner : cell) middle += body.rest.col(corner) / 4;
    return (middle.head<2>() - Eigen::Vector2d(0.0015, 0.0015)).cwiseAbs().maxCoeff() < 0.0005;
  });
  body.connections = connections_of_cells(body.rest, {}, body.tetrahedra);
  set_matter(body, 0.0005, 1000, 0, 0);
  return body;
}

/// A block of 10 × 10 × 20 mm whose width grows to twice as much along z: A(z) = A₀ (1 + z/L).
Body wedge() {
  Body body = tetrahedral_block(BlockKind::kuhn, {3, 3, 5}, {0.01, 0.01, 0.02});
  for (int molecule = 0; molecule < body.size(); ++molecule)
    body.rest(0, molecule) *= 1 + body.rest(2, molecule) / 0.02;
  set_present_lengths(body);
  set_matter(body, 0.001, 1000, 0, 0);
  return body;
}

/// A ball of radius 10 mm: a cube whose grid is bent so that its sides lie on the sphere.
Body ball() {
  Body body = tetrahedral_block(BlockKind::kuhn, {6, 6, 6}, {2, 2, 2});
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 u = body.rest.col(molecule) - Vector3::Ones(), s = u.cwiseAbs2();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = s[(axis + 1) % 3], b = s[(axis + 2) % 3];
      body.rest(axis, molecule) = 0.01 * u[axis] * std::sqrt(1 - a / 2 - b / 2 + a * b / 3);
    }
  }
  set_present_lengths(body);
  set_matter(body, 0.001, 1000, 0, 0);
  return body;
}

Section along_z(const Body& body, double thickness = 0) {
  const VectorX z = body.rest.row(2);
  return find_section(body, Vector3::UnitZ(), z.minCoeff(), z.maxCoeff(), thickness);
}

TensionSetup pull(double displacement) {
  TensionSetup setup;
  setup.displacement = displacement;
  return setup;
}

}  // namespace

TEST_CASE("volumes of tetrahedra in slabs are those of closed forms", "[section]") {
  // Corners at heights 0 0 0 1: below z lies 1 − (1 − z)³; at 0 0 1 1: 3z² − 2z³. Volume 1/6, so the mean section too.
  Body body;
  body.tetrahedra = {{0, 1, 2, 3}};
  body.rest.resize(3, 4);
  body.rest << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  CHECK(along_z(body).area == Approx(1. / 6));
  CHECK(along_z(body).variation == Approx(10 * (1 - 0.9 * 0.9 * 0.9) - 1));
  body.rest << 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1;
  CHECK(along_z(body).area == Approx(1. / 6));
  CHECK(along_z(body).variation == Approx(1 - 10 * (3 * 0.01 - 2 * 0.001)));
  // Between two heights alone: 0.4 to 0.6 holds 0.648 − 0.352 of the volume.
  CHECK(find_section(body, Vector3::UnitZ(), 0.4, 0.6, 0).area == Approx((0.648 - 0.352) / 6 / 0.2));
}

TEST_CASE("a round bar of few curved cells has the section of its own sides", "[section]") {
  // A square grid bent to a disc of radius 10 mm: nodes of second order lie on the circle, chords within it.
  for (const char* kind : {"hexahedron20", "hexahedron27", "tetrahedron10"}) {
    Body body = cell_box(cell_kind(kind), {2, 2, 2}, {2, 2, 2}, 0);
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      const double x = body.rest(0, molecule) - 1, y = body.rest(1, molecule) - 1;
      body.rest(0, molecule) = 0.01 * x * std::sqrt(1 - y * y / 2);
      body.rest(1, molecule) = 0.01 * y * std::sqrt(1 - x * x / 2);
      body.rest(2, molecule) *= 0.01;
    }
    set_simplices(body);
    const Section section = along_z(body);
    INFO(kind << ": " << section.area / (M_PI * 1e-4));
    // The error of parabolas through eight arcs of 45° halves: far below the 2.6 % of 16 chords.
    CHECK(section.area == Approx(M_PI * 1e-4).epsilon(2e-3));
    CHECK(section.prism());
  }
}

TEST_CASE("cells that curve so far that simplices within are inverted have their own section", "[section]") {
  Body body = cell_box(cell_kind("tetrahedron10"), {1, 1, 2}, {1, 1, 1}, 0);
  for (int molecule = 0; molecule < body.size(); ++molecule) {  // a quarter of a ring of radii 2 and 6 mm
    const double radius = 2e-3 + 4e-3 * body.rest(0, molecule), angle = M_PI / 2 * body.rest(1, molecule);
    body.rest.col(molecule) << radius * std::cos(angle), radius * std::sin(angle), 0.01 * body.rest(2, molecule);
  }
  set_simplices(body);
  CHECK(along_z(body).area == Approx(volume_of_cells(body, body.rest) / 0.01).epsilon(1e-12));
  CHECK(along_z(body).area == Approx(M_PI / 4 * 32e-6).epsilon(0.02));
}

TEST_CASE("the volume of curved cells is that of their map", "[section]") {
  // x + y²/2, y + z²/4 keeps the volume.
  for (const char* kind : {"hexahedron27", "hexahedron20", "tetrahedron10"}) {
    Body body = cell_box(cell_kind(kind), {1, 1, 1}, {1, 1, 1}, 0);
    const Positions cube = body.rest;
    body.rest.row(0) += 0.5 * cube.row(1).cwiseAbs2();
    body.rest.row(1) += 0.25 * cube.row(2).cwiseAbs2();
    INFO(kind);
    CHECK(volume_of_cells(body, body.rest) == Approx(1).epsilon(1e-12));
    body.rest.row(2) += 0.5 * cube.row(2).cwiseAbs2();  // the determinant is 1 + z
    CHECK(volume_of_cells(body, body.rest) == Approx(1.5).epsilon(1e-12));
  }
}

TEST_CASE("a prism has the section of its cells, a tapered body none of its own", "[section]") {
  const Section tube = along_z(hollow_bar());
  CHECK(tube.area == Approx(8e-6));
  CHECK(tube.variation < 1e-9);
  CHECK((tube.prism() && !tube.of_hull));
  const Section tapered = along_z(wedge());  // the last slab has 1.95 A₀, the mean is 1.5 A₀
  CHECK(tapered.area == Approx(1.5e-4));
  CHECK(tapered.variation == Approx(0.3));
  CHECK_FALSE(tapered.prism());
  const Section of_ball = along_z(ball());
  CHECK_FALSE(of_ball.prism());
  CHECK(of_ball.area == Approx(4. / 3 * 3.14159 * 1e-6 / 0.02).epsilon(0.05));
}

TEST_CASE("cubes and triangles have a section too; a bare graph has its hull's", "[section]") {
  Body lattice = jittered_lattice(0.1);
  CHECK(along_z(lattice).area == Approx(6e-4));
  CHECK_FALSE(along_z(lattice).of_hull);
  lattice.cubes.clear();
  CHECK(along_z(lattice).area == Approx(6e-4));
  CHECK(along_z(lattice).of_hull);
  Body strip = listed_body({{0, 0, 0}, {0.01, 0, 0}, {0, 0, 0.03}, {0.01, 0, 0.03}}, {});
  strip.triangles = {{0, 1, 2}, {1, 3, 2}};
  CHECK(along_z(strip, 0.002).area == Approx(2e-5));
  CHECK(along_z(strip, 0.002).variation < 1e-9);
  CHECK(along_z(strip).area == 0);  // without a thickness
  // Three boxes of molecules in a row, the middle one half as wide.
  Body waist = cubic_lattice({5, 5, 13}, 0.001, {true, true, false});
  waist.cubes.clear();
  CHECK(along_z(waist).prism());
  for (int molecule = 0; molecule < waist.size(); ++molecule)
    if (std::abs(waist.rest(2, molecule) - 0.006) < 0.0035) waist.rest(0, molecule) *= 0.5;
  CHECK_FALSE(along_z(waist).prism());
}

TEST_CASE("a tube shows the material's E", "[section][tension]") {
  Specimen specimen;
  specimen.body = hollow_bar();
  specimen.material.youngs_modulus = 1e4;
  const auto experiment = make_tension(specimen.body, pull(1e-8));
  CHECK_FALSE(experiment->apparent());
  CHECK((experiment->no_reference().empty() && experiment->notes().empty()));
  const Run run = run_strategy(specimen, *experiment, choose_strategy(kCatalog, "neo_hookean"), {});
  CHECK(run.measures.get("effective_modulus") == Approx(1e4).epsilon(1e-5));
  // What the scene states counts, whatever the body is.
  TensionSetup stated = pull(1e-8);
  stated.cross_section = 9e-6;
  const auto nominal = make_tension(specimen.body, stated);
  CHECK(run_strategy(specimen, *nominal, choose_strategy(kCatalog, "neo_hookean"), {})
            .measures.get("effective_modulus") == Approx(8. / 9 * 1e4).epsilon(1e-5));
}

TEST_CASE("the modulus of a body that is no prism is apparent, and nothing is calibrated to it", "[section][tension]") {
  Specimen specimen;
  specimen.body = wedge();
  specimen.material.youngs_modulus = 1e4;
  const auto experiment = make_tension(specimen.body, pull(1e-6));
  CHECK(experiment->apparent());
  CHECK_THAT(experiment->no_reference(), Contains("no prism"));
  CHECK_THAT(experiment->notes().at(0), Contains("varies by 30 %"));
  CHECK(std::isnan(experiment->main_measures(specimen.material, {}).front().prescribed));
  const Run run = run_strategy(specimen, *experiment, choose_strategy(kCatalog, "calibrated:van_gelder"), {});
  CHECK_FALSE(run.suited);
  CHECK_THAT(run.cause, Contains("no modulus to calibrate to: its modulus is apparent"));
  TensionSetup stated = pull(1e-6);
  stated.cross_section = 1.5e-4;
  CHECK(make_tension(specimen.body, stated)->apparent());  // stating an area makes no prism of it
  CHECK_THAT(make_tension(specimen.body, stated)->no_reference(), Contains("no prism"));
}

TEST_CASE("clamps that reach the gauge leave no reference", "[section][tension]") {
  const Body bar = tetrahedral_block(BlockKind::kuhn, {2, 2, 10}, {0.01, 0.01, 0.05});
  TensionSetup setup = pull(1e-6);
  CHECK(make_tension(bar, setup)->no_reference().empty());
  setup.loaded_grip = Grip::clamped;
  CHECK_THAT(make_tension(bar, setup)->no_reference(),
             Contains("the grips clamp, so no specimen shows the material's E; compare with the solid itself"));
  CHECK_FALSE(make_tension(bar, setup)->apparent());
  setup.gauge = {0.015, 0.035};  // more than one width of 10 mm away from either end
  CHECK(make_tension(bar, setup)->no_reference().empty());
  setup.gauge = {0.015, 0.045};
  CHECK_FALSE(make_tension(bar, setup)->no_reference().empty());
}

TEST_CASE("a beam bends under a load across no principal axis as far as it must", "[section][bending]") {
  // A bar of 12 mm x 4 mm: along [cos a, sin a] the deflection is that along each axis times cos² and sin².
  Specimen specimen;
  specimen.body = cell_box(cell_kind("hexahedron20"), {3, 2, 8}, {0.012, 0.004, 0.08}, 0);
  specimen.material = {.youngs_modulus = 12e3, .poissons_ratio = 0.25};
  const auto modulus = [&](const Vector3& direction) {
    BendingSetup setup;
    setup.axis = Vector3::UnitZ(), setup.direction = direction.normalized(), setup.force = 1e-8;
    const auto experiment = make_bending(specimen.body, setup, specimen.material);
    return run_strategy(specimen, *experiment, choose_strategy(kCatalog, "neo_hookean"), {})
        .measures.get("effective_modulus");
  };
  const double wide = modulus(Vector3::UnitX()), flat = modulus(Vector3::UnitY());
  CHECK(wide == Approx(12e3).epsilon(0.03));
  for (const Vector3& direction : {Vector3(1, 1, 0), Vector3(2, 1, 0), Vector3(-1, 3, 0)}) {
    const Vector3 n = direction.normalized();
    const double most = std::max(wide, flat), least = std::min(wide, flat), found = modulus(n);
    CHECK(found <= most * 1.001);
    CHECK(found >= least * 0.999);
  }
}

TEST_CASE("the second moments of curved cells are their own", "[section][bending]") {
  // A square of 2 x 2 cells of 27 molecules bent into a disc, whose moment is π a⁴/4; of the polygon it is 5 % less.
  Body body = cell_box(cell_kind("hexahedron27"), {4, 4, 2}, {2, 2, 3}, 0);
  for (int i = 0; i < body.size(); ++i) {
    Eigen::Ref<Vector3> at = body.rest.col(i);
    const double x = at.x() - 1, y = at.y() - 1;
    at.x() = x * std::sqrt(1 - y * y / 2), at.y() = y * std::sqrt(1 - x * x / 2);
  }
  Eigen::Matrix<double, 3, 2> plane = Eigen::Matrix<double, 3, 2>::Identity();
  const auto moments = second_moments_of_cells(body, plane, M_PI);
  REQUIRE(moments);
  CHECK((*moments)(0, 0) == Approx(M_PI / 4).epsilon(2e-3));
  CHECK((*moments)(1, 1) == Approx(M_PI / 4).epsilon(2e-3));
  CHECK(std::abs((*moments)(0, 1)) < 1e-9);
  // Tetrahedra, one molecule a corner: b h³/12.
  const Body block = tetrahedral_block(BlockKind::body_centred, {2, 3, 2}, {0.2, 0.3, 0.5});
  const auto own = second_moments_of_cells(block, plane, 0.06);
  REQUIRE(own);
  CHECK((*own)(0, 0) == Approx(0.3 * std::pow(0.2, 3) / 12).epsilon(1e-12));
  CHECK((*own)(1, 1) == Approx(0.2 * std::pow(0.3, 3) / 12).epsilon(1e-12));
}

TEST_CASE("a beam that is hollow has an apparent modulus", "[section][bending]") {
  BendingSetup setup;
  setup.axis = Vector3::UnitZ();
  setup.direction = Vector3::UnitX();
  setup.force = 1e-6;
  const Body hollow = hollow_bar();
  Body whole = tetrahedral_block(BlockKind::kuhn, {3, 3, 6}, {0.003, 0.003, 0.006});
  set_matter(whole, 0.0005, 1000, 0, 0);
  CHECK(make_bending(hollow, setup, {})->apparent());
  CHECK_FALSE(make_bending(hollow, setup, {})->no_reference().empty());
  CHECK_FALSE(make_bending(whole, setup, {})->apparent());
}

TEST_CASE("plates shear a tube by the section of its cells", "[section][shear]") {
  Specimen specimen;
  specimen.body = hollow_bar();
  specimen.material.youngs_modulus = 1e4;
  ShearSetup setup;
  setup.direction = Vector3::UnitX();
  setup.strain = 1e-6;
  const auto modulus = [&] {
    const auto experiment = make_shear(specimen.body, setup, Matrix3::Identity());
    return run_strategy(specimen, *experiment, choose_strategy(kCatalog, "neo_hookean"), {})
        .measures.get("shear_modulus");
  };
  const double own = modulus();
  setup.cross_section = 8e-6;
  CHECK(modulus() == Approx(own).epsilon(1e-9));
}

TEST_CASE("a factor of calibration beyond 2 is a warning that names it", "[calibration]") {
  Specimen specimen;
  specimen.body = cubic_lattice({4, 4, 4}, 0.01, {true, true, false});
  set_matter(specimen.body, 0.005, 1000, 0, 2.7e-5);
  specimen.material.youngs_modulus = 1e4;
  const auto experiment = make_tension(specimen.body, pull(1e-6));
  const auto warnings = [&](double times) {  // of a rule that is off by this factor
    const Strategy lattice = kCatalog.find("lattice");
    const Strategy rule = make_spring_rule(
        "mine", [=](const Body& body, const Material& material, const ParameterValues& values) -> VectorX {
          return times * lattice.constants(body, material, values);
        });
    StrategyChoice choice;
    choice.label = "calibrated:mine";
    choice.name.rule = "mine";
    choice.name.calibrated = true;
    choice.strategy = rule;
    const Run run = run_strategy(specimen, *experiment, choice, {});
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.calibration_factor == Approx(1 / times).epsilon(1e-6));
    return run.warnings;
  };
  CHECK(warnings(1 / 1.9).empty());
  CHECK(warnings(1.9).empty());
  REQUIRE(warnings(0.25).size() == 1);
  CHECK_THAT(warnings(0.25).front(), Contains("multiplies the spring constants by 4;"));
  CHECK_THAT(warnings(4).at(0), Contains("by 0.25;"));
}

TEST_CASE("the section of a wall is that of its line times the thickness", "[section]") {
  Eigen::Matrix<double, 3, 2> plane;
  plane << Vector3::UnitX(), Vector3::UnitY();
  const auto wall = [&](const Body& body, double thickness = 1e-3) {
    return wall_section(body, Vector3::UnitZ(), plane, 0, 0.04, thickness);
  };
  using Kind = WallSection::Kind;
  constexpr double R = 0.01, t = 1e-3;
  const auto tube = wall(wall_on(circle(R, 60), true, 8, 0.04));
  REQUIRE(tube);
  CHECK(tube->kind == Kind::tube);  // each value of the 60 sides by hand is within 0.5 % of the circle's
  CHECK(tube->section.area == Approx(2 * M_PI * R * t).epsilon(5e-3));
  CHECK(tube->second_moment(0, 0) == Approx(M_PI * R * R * R * t).epsilon(5e-3));
  CHECK(std::abs(tube->second_moment(0, 1)) < 1e-9 * tube->second_moment(0, 0));
  CHECK(tube->torsion == Approx(2 * M_PI * R * R * R * t).epsilon(1e-2));
  const auto strip = wall(wall_on({{0, 0}, {0, 0.004}, {0, 0.01}}, false, 8, 0.04));
  REQUIRE(strip);
  CHECK(strip->kind == Kind::strip);
  CHECK(strip->second_moment(1, 1) == Approx(t * 1e-6 / 12).epsilon(1e-12));
  const auto box = wall(wall_on({{0, 0}, {0.01, 0}, {0.01, 0.01}, {0, 0.01}}, true, 8, 0.04));
  REQUIRE(box);
  CHECK(box->kind == Kind::other);
  CHECK(box->second_moment(0, 0) == Approx(t * 1e-6 * (2. / 12 + 2. / 4)).epsilon(1e-12));
  CHECK(wall(wall_on(circle(R, 60, 0.999), false, 8, 0.04))->kind == Kind::other);  // slit along its length
  CHECK(wall(wall_on(circle(R, 60), true, 8, 0.04), 0)->section.area == 0);
  CHECK_FALSE(wall(hollow_bar()));
}

TEST_CASE("thin tubes show their moduli in torsion and bending, other walls an apparent one or none",
          "[section][bending][torsion]") {
  const Material material{.youngs_modulus = 1e5, .poissons_ratio = 0.3, .thickness = 1e-3};
  const auto specimen_of = [&](Body body) {
    Specimen specimen;
    specimen.material = material;
    specimen.body = std::move(body);
    return specimen;
  };
  const auto run_of = [](const Specimen& specimen, const StaticExperiment& experiment) {
    const Run run = run_strategy(specimen, experiment, choose_strategy(kCatalog, "neo_hookean_membrane"),
                                 {.statics = {.linear = true}});
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    return run.measures;
  };
  BendingSetup bend;
  bend.axis = Vector3::UnitZ(), bend.direction = Vector3::UnitX(), bend.force = 1e-4;
  TorsionSetup turn;
  turn.angle = 0.01, turn.straight = true;
  const Specimen tube = specimen_of(wall_on(circle(0.01, 32), true, 60, 0.1)),
                 box = specimen_of(wall_on({{0, 0}, {0.01, 0}, {0.01, 0.01}, {0, 0.01}}, true, 10, 0.04));
  const auto strip_of = [&](int across) {
    std::vector<Eigen::Vector2d> line;
    for (int i = 0; i <= across; ++i) line.emplace_back(0.01 * i / across, 0);
    return specimen_of(wall_on(line, false, 12 * across, 0.1));
  };
  const auto bent = make_bending(tube.body, bend, material);
  CHECK_FALSE(bent->apparent());
  CHECK(run_of(tube, *bent).get("effective_modulus") == Approx(1e5).epsilon(0.02));
  const auto turned = make_torsion(tube.body, turn, material.thickness);
  CHECK(run_of(tube, *turned).get("shear_modulus") == Approx(1e5 / 2.6).epsilon(0.01));
  CHECK(turned->no_reference().empty());
  std::array<double, 2> strips{};
  for (const int level : {0, 1}) {
    const Specimen strip = strip_of(4 << level);
    const auto in_plane = make_bending(strip.body, bend, material);
    CHECK_FALSE(in_plane->apparent());
    strips[level] = run_of(strip, *in_plane).get("effective_modulus");
  }
  CHECK((4 * strips[1] - strips[0]) / 3 == Approx(1e5).epsilon(0.02));  // the limit of order 2

  CHECK(make_bending(box.body, bend, material)->apparent());
  CHECK(make_bending(tube.body, bend, {.youngs_modulus = 1e5})->apparent());  // by its hull, for want of a thickness
  CHECK(std::isnan(run_of(box, *make_torsion(box.body, turn, material.thickness)).get("shear_modulus")));
  bend.direction = Vector3::UnitY();
  CHECK_THROWS_WITH(make_bending(strip_of(4).body, bend, material), Contains("`kind: loads` bends it"));
}
