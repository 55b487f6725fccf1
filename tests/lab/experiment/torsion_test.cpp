#include "lab/experiment/torsion/torsion.h"

#include <numbers>

#include "core/model/block_geometry.h"
#include "lab/run/section.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

Run turn(const Specimen& specimen, double angle, int load_steps, const std::string& strategy,
         const StaticOptions& statics = {}) {
  TorsionSetup setup;
  setup.angle = angle;
  setup.straight = statics.linear;
  setup.load_steps = load_steps;
  const auto experiment = make_torsion(specimen.body, setup);
  return solve(specimen, *experiment, strategy, statics);
}

}  // namespace

TEST_CASE("torsion constants of rectangles", "[torsion]") {
  // [Timoshenko & Goodier, Theory of Elasticity, table of k1 in J = k1 a b³]
  for (const auto& [ratio, k] : {std::pair{1., 0.1406}, {1.5, 0.196}, {2., 0.229}, {3., 0.263}, {10., 0.312}}) {
    CHECK(torsion_constant(ratio * 2, 2) == Approx(k * ratio * 16).epsilon(2e-3));
    CHECK(torsion_constant(2, ratio * 2) == torsion_constant(ratio * 2, 2));
  }
}

TEST_CASE("a turned cube tends to the converged finite elements", "[torsion][reference][slow]") {
  // Q2-Q4 hexahedra, neo-Hookean; torque to 5e-4. What the extrapolation leaves is another 1e-3: from 24 and 32 cubes
  // it hits 2930.7 at 30 degrees. The small axial force shows an order between 1.3 and 2, so its limit lies between
  // two.
  const OneThread alone;
  std::array<Run, 3> runs;
  for (const std::size_t i : {0u, 1u, 2u})
    runs[i] = turn(reference_cube(3 << i), 90 * kDegree, 3, "neo_hookean", {.tolerance = 1e-6});
  const std::array<double, 3> torques{2930.2, 5835, 8541}, axials{-79.8, -459, -1273};
  for (const std::size_t row : {0u, 1u, 2u}) {
    Refinement torque{}, axial{};
    for (const std::size_t i : {0u, 1u, 2u}) {
      torque[i] = runs[i].curve[row].measures.get("torque");
      axial[i] = runs[i].curve[row].measures.get("axial_force");
    }
    INFO(30 * (row + 1) << " degrees: order " << order_of(torque) << ", " << order_of(axial));
    CHECK(runs[2].curve[row].measures.get("angle") == Approx(30 * (static_cast<double>(row) + 1) * kDegree));
    CHECK(order_of(torque) == Approx(2).margin(0.3));
    CHECK(second_order_limit(torque[1], torque[2]) == Approx(torques[row]).epsilon(1.5e-3));
    CHECK(order_of(axial) > 1.2);
    CHECK(limit_of(axial) > axials[row]);
    CHECK(second_order_limit(axial[1], axial[2]) < axials[row]);
  }
}

TEST_CASE("a long bar twists as Saint-Venant says", "[torsion][slow]") {
  // Clamped ends cannot warp; that stiffens both bars alike, so the difference of their twists is that of a free
  // length.
  const OneThread alone;
  std::array<double, 2> modulus{};
  for (const std::size_t refined : {0u, 1u}) {
    std::array<double, 2> twist{};
    for (const std::size_t longer : {0u, 1u}) {
      const int length = longer ? 4 : 2, cubes = refined ? 8 : 4;
      Specimen specimen;
      specimen.material = {.youngs_modulus = 1e5, .poissons_ratio = 0.3};
      specimen.body = tetrahedral_block(BlockKind::body_centred, {cubes, cubes, cubes * length},
                                        {1, 1, static_cast<double>(length)});
      twist[longer] = 1 / turn(specimen, 0.1, 1, "neo_hookean", {.linear = true, .tolerance = 1e-8})
                              .measures.get("torsional_stiffness");
    }
    modulus[refined] = 2 / ((twist[1] - twist[0]) * 0.140577);
  }
  CHECK(second_order_limit(modulus[0], modulus[1]) == Approx(1e5 / 2.6).epsilon(5e-3));
}

TEST_CASE("the torque is the slope of the energy over the angle, in any number of load steps", "[torsion]") {
  const Specimen specimen = jittered_specimen(BlockKind::alternating, 0.3);
  const StaticOptions exact{.tolerance = 1e-13};
  const auto at = [&](double angle, int steps) { return turn(specimen, angle, steps, "neo_hookean", exact).measures; };
  const double step = 1e-4;
  const double slope = (at(0.7 + step, 1).get("energy") - at(0.7 - step, 1).get("energy")) / (2 * step);
  CHECK(at(0.7, 1).get("torque") == Approx(slope).epsilon(1e-6));
  CHECK(at(0.7, 3).get("torque") == Approx(at(0.7, 1).get("torque")).epsilon(1e-8));
  CHECK(at(0.7, 3).get("torsional_stiffness") == Approx(at(0.7, 1).get("torque") / 0.7).epsilon(1e-8));
}

TEST_CASE("a turn that would invert cells is bisected", "[torsion][slow]") {
  const Specimen specimen = reference_cube(6);
  const Run run = turn(specimen, 90 * kDegree, 1, "neo_hookean");
  CHECK(run.bisected_load_steps > 0);
  CHECK(run.curve.size() == 1);
  const Run slowly = turn(specimen, 90 * kDegree, 6, "neo_hookean");
  CHECK(slowly.bisected_load_steps == 0);
  CHECK(run.measures.get("torque") == Approx(slowly.measures.get("torque")).epsilon(1e-8));
}

TEST_CASE("a turn of more than a half is no shorter one the other way round", "[torsion]") {
  const Specimen specimen = jittered_specimen(BlockKind::kuhn, 0.3);
  const Run run = turn(specimen, 200 * kDegree, 1, "neo_hookean"),
            slowly = turn(specimen, 200 * kDegree, 12, "neo_hookean");
  CHECK(run.curve.size() == 1);
  CHECK(run.measures.get("torque") > 0);
  CHECK(run.measures.get("torque") == Approx(slowly.measures.get("torque")).epsilon(1e-8));
}

TEST_CASE("only a rectangle's torsion constant is known", "[torsion]") {
  Specimen specimen = reference_cube(2);
  CHECK(std::isfinite(turn(specimen, 0.1, 1, "neo_hookean").measures.get("shear_modulus")));
  for (int i = 0; i < specimen.body.size(); ++i)  // one corner of the section cut off
    if (specimen.body.rest.col(i).head<2>().isZero(1e-9)) specimen.body.rest.col(i) += Vector3(0.1, 0.1, 0);
  TorsionSetup setup;
  setup.angle = 0.1;
  const auto experiment = make_torsion(specimen.body, setup);
  for (const MainMeasure& measure : experiment->main_measures(specimen.material, {}))
    CHECK(measure.name != "shear_modulus");
  const Run run = run_strategy(specimen, *experiment, choose_strategy(built_in_catalog(), "calibrated:standard"), {});
  CHECK_FALSE(run.suited);
  CHECK_THAT(run.cause,
             Catch::StartsWith("the experiment torsion measures on this body no modulus to calibrate to: the "
                               "section is none whose torsion constant is known"));
}

TEST_CASE("between clamps a section that warps shows no G, and asks for a reference", "[torsion]") {
  // Of a cube the ends stiffen the whole: its torque is some 1.07 times that of a free bar.
  const Specimen specimen = reference_cube(8);
  TorsionSetup setup;
  setup.angle = 0.01;
  setup.straight = true;
  const auto experiment = make_torsion(specimen.body, setup);
  CHECK_THAT(experiment->no_reference(), Catch::Contains("the section cannot warp there"));
  CHECK(turn(specimen, 0.01, 1, "neo_hookean", {.linear = true}).measures.get("shear_modulus") > 1.05 * 1e5 / 2.6);
}

TEST_CASE("a rough bar and a round one have a shear modulus", "[torsion][slow]") {
  Specimen bar;
  bar.material = {.youngs_modulus = 1e5, .poissons_ratio = 0.3};
  bar.body = tetrahedral_block(BlockKind::body_centred, {4, 4, 12}, {1, 1, 3});
  const double straight = turn(bar, 0.1, 1, "neo_hookean").measures.get("shear_modulus");
  for (int molecule = 0; molecule < bar.body.size(); ++molecule)  // a 250th of the side
    for (int axis = 0; axis < 2; ++axis) bar.body.rest(axis, molecule) += 0.004 * std::sin(31. * molecule + 7 * axis);
  set_present_lengths(bar.body);
  CHECK(turn(bar, 0.1, 1, "neo_hookean").measures.get("shear_modulus") == Approx(straight).epsilon(0.02));

  // Square shells become round ones.
  // Nothing warps in a round bar: G = E / 2 (1 + nu).
  Specimen rod = bar;
  rod.body = tetrahedral_block(BlockKind::body_centred, {8, 8, 24}, {1, 1, 3});
  for (int molecule = 0; molecule < rod.body.size(); ++molecule) {
    Vector3 at = rod.body.rest.col(molecule) - Vector3(0.5, 0.5, 0);
    const double radius = at.head<2>().cwiseAbs().maxCoeff();
    if (radius > 0) at.head<2>() *= radius / at.head<2>().norm();
    rod.body.rest.col(molecule) = at;
  }
  set_present_lengths(rod.body);
  CHECK(turn(rod, 0.05, 1, "neo_hookean").measures.get("shear_modulus") == Approx(1e5 / 2.6).epsilon(0.05));
}

TEST_CASE("torsion of a section whose constant is not known has no target, and says so", "[torsion]") {
  Body bar = tetrahedral_block(BlockKind::kuhn, {4, 4, 4}, {0.01, 0.01, 0.04});
  std::erase_if(bar.tetrahedra, [&](const auto& cell) {  // an angle
    const Vector3 middle = positions_of(bar.rest, cell).rowwise().mean();
    return middle.x() > 0.005 && middle.y() > 0.005;
  });
  std::vector<int> left;
  for (int i = 0; i < bar.size(); ++i)
    if (bar.rest(0, i) < 0.0051 || bar.rest(1, i) < 0.0051) left.push_back(i);
  std::vector<int> number(static_cast<std::size_t>(bar.size()), -1);
  for (std::size_t i = 0; i < left.size(); ++i) number[left[i]] = static_cast<int>(i);
  for (auto& cell : bar.tetrahedra)
    for (int& molecule : cell) molecule = number[molecule];
  Body angle;
  angle.rest = bar.rest(Eigen::all, left);
  angle.tetrahedra = bar.tetrahedra;
  angle.connections = connections_of_cells(angle.rest, {}, angle.tetrahedra);
  set_matter(angle, 1000, 0, 1e-3);
  TorsionSetup setup;
  setup.axis = Vector3::UnitZ(), setup.angle = 0.01;
  const auto experiment = make_torsion(angle, setup);
  CHECK_THAT(experiment->no_reference(), Catch::Contains("torsion constant"));
  CHECK(experiment->main_measures({}, {}).front().name == "torque");
}
