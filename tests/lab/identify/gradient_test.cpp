// How measured values change with each number of each law: by the tangent, against differences of whole solutions.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/homogeneous.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/identify/identify.h"
#include "lab/identify/measured_test.h"
#include "lab/run/material_numbers.h"
#include "support/law_constants.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();

VectorX values_of(const std::vector<MaterialNumber>& numbers) {
  VectorX values(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) values[static_cast<Eigen::Index>(i)] = numbers[i].value;
  return values;
}

/// Differences of fourth order of f over one number.
template <class Function>
VectorX difference(const VectorX& values, Eigen::Index number, const Function& f) {
  const double step = 1e-3 * std::abs(values[number]);
  const auto at = [&](double steps) {
    VectorX moved = values;
    moved[number] += steps * step;
    return VectorX(f(moved));
  };
  return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step);
}

}  // namespace

TEST_CASE("slopes of homogeneous stresses are those of whole solutions, in every number of every law", "[identify]") {
  VectorX amounts(4);
  amounts << 0.15, 0.35, -0.1, -0.2;
  for (const auto& [name, constants] : elastin::testing::law_constants()) {
    const auto row = kCatalog.material_laws.find(name);
    Material like;
    like.youngs_modulus = 5e3, like.poissons_ratio = 0.3;
    for (const bool incompressible : {false, true}) {
      if (incompressible && row->from_moduli) continue;
      LawConstants own = constants;
      if (incompressible) own.numbers.erase("bulk_modulus");
      const Material material = with_law(*row, own, like);
      const auto numbers = material_numbers(row.get(), material);
      const VectorX values = values_of(numbers);
      const Matrix3 axes = axes_of_law(*row, material);
      for (const HomogeneousTest test : kHomogeneousTests) {
        const auto stresses = [&](const VectorX& at) {
          return homogeneous_stresses(*row, with_numbers(row.get(), material, numbers, at).material, test, amounts, {},
                                      axes)
              ->stresses;
        };
        const auto found = homogeneous_stresses(
            *row, material, test, amounts,
            material_changes(trial_changes(row.get(), material, numbers, values, 1e-5 * values.cwiseAbs())), axes);
        REQUIRE(found.has_value());
        const double size = found->stresses.norm();
        for (Eigen::Index i = 0; i < values.size(); ++i) {
          INFO(name << ", " << name_of(test) << ", " << numbers[i].name);
          const VectorX expected = difference(values, i, stresses);
          // Over what the number makes of the stress; one that makes nothing of it has rounding alone.
          CHECK((found->slopes.col(i) - expected).norm() < 1e-6 * expected.norm() + 1e-9 * size / std::abs(values[i]));
        }
      }
    }
  }
}

TEST_CASE("slopes of a specimen in its grips are those of whole solutions, under force and displacement",
          "[identify][slow]") {
  const TemporaryFolder folder;
  struct Case {
    std::string material, stiffness, experiment, data, more = "";
  };
  const std::string law = "{law: mooney_rivlin, c1: 3 kPa, c2: 1 kPa, bulk_modulus: 40 kPa}";
  const std::string pulled = "{kind: tension, axis: z, displacement: 2 mm, fixed_grip: clamped, loaded_grip: clamped}";
  for (const Case& given :
       {Case{law, "mooney_rivlin", pulled, "displacement [mm],force [N]\n1,0.1\n2,0.2\n"},
        Case{law, "mooney_rivlin", "{kind: tension, axis: z, force: 0.5 N, fixed_grip: clamped}",
             "force [N],displacement [mm]\n0.25,0.5\n0.5,1\n"},
        Case{law, "mooney_rivlin", "{kind: torsion, axis: z, angle: 40 deg}",
             "angle [deg],torque [N m]\n20,0.0001\n40,0.0002\n"},
        Case{"{youngs_modulus: 10 kPa, poissons_ratio: 0.3}", "neo_hookean", pulled,
             "displacement [mm],force [N]\n1,0.1\n2,0.2\n"},
        Case{"{youngs_modulus: 10 kPa, poissons_ratio: 0.3}", "van_gelder", pulled,
             "displacement [mm],force [N]\n1,0.1\n2,0.2\n"},
        Case{"{curve: {points: [[-30 %, -5 kPa], [0, 0 kPa], [10 %, 1 kPa], [40 %, 8 kPa]]}}",
             "{strategy: angles, exponent: 0.5}", pulled, "displacement [mm],force [N]\n1,0.1\n2,0.2\n"},
        Case{"{youngs_modulus: 10 kPa, poissons_ratio: 0.3}", "neo_hookean",
             "{kind: indentation, indenter: {sphere: {radius: 8 mm}}, depth: 1 mm}",
             "displacement [mm],force [N]\n0.5,0.1\n1,0.2\n", "contact: {friction: 0}\n"}}) {
    folder.write("data.csv", given.data);
    const std::string path = folder.write(
        "scene.yaml", "body: {tetrahedra: {kind: kuhn, cubes: [2, 2, 3], size: [10 mm, 10 mm, 15 mm]}}\nmaterial: " +
                          given.material + "\nstiffness: " + given.stiffness + "\nexperiment: " + given.experiment +
                          "\n" + given.more + "identify: {tests: [{kind: specimen, file: data.csv}]}\n");
    INFO(given.stiffness << " " << given.experiment);
    const IdentifyTask task = load_identify_task(path, kCatalog);
    const MaterialLaw* row = task.material.law ? kCatalog.material_laws.find(task.material.law->law).get() : nullptr;
    const auto test = make_measured_test(task.tests.front(), kCatalog, row, task.material, {});
    Trial trial = task.material;
    trial.curve = task.curve;
    std::vector<MaterialNumber> numbers = material_numbers(row, trial);
    if (!row && given.stiffness != "neo_hookean") numbers.pop_back();  // springs do not feel nu
    for (const MaterialNumber& number : test->own_numbers())
      if (number.kind == MaterialNumber::Kind::rule_parameter) numbers.push_back(number);
    const VectorX values = values_of(numbers);
    const auto found =
        test->predict({row, trial, trial_changes(row, trial, numbers, values, 1e-5 * values.cwiseAbs())});
    REQUIRE(found.has_value());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      INFO(numbers[i].name);
      const VectorX expected = difference(values, i, [&](const VectorX& at) {
        return test->predict({row, with_numbers(row, trial, numbers, at), {}})->values;
      });
      CHECK((found->slopes.col(i) - expected).norm() < 1e-6 * expected.norm());
    }
  }
}

TEST_CASE("slopes of a specimen in its grips are those of whole solutions, in every number of every law",
          "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "displacement [mm],force [N]\n1,0.1\n2,0.2\n");
  for (const auto& [name, constants] : elastin::testing::law_constants()) {
    const auto row = kCatalog.material_laws.find(name);
    const Material material = elastin::testing::material_with(constants);
    const std::string path =
        folder.write("scene.yaml",
                     "body: {tetrahedra: {kind: kuhn, cubes: [2, 1, 2], size: [8 mm, 5 mm, 10 mm]}}\n" +
                         material_yaml(row.get(), material, false) + "stiffness: " + name +
                         "\nexperiment: {kind: tension, axis: z, displacement: 2 mm, fixed_grip: clamped, loaded_grip: "
                         "clamped}\nidentify: {tests: [{kind: specimen, file: data.csv}]}\n");
    const IdentifyTask task = load_identify_task(path, kCatalog);
    const auto test = make_measured_test(task.tests.front(), kCatalog, row.get(), task.material, {});
    const Trial trial = task.material;
    const std::vector<MaterialNumber> numbers = material_numbers(row.get(), trial);
    const VectorX values = values_of(numbers);
    const auto found =
        test->predict({row.get(), trial, trial_changes(row.get(), trial, numbers, values, 1e-5 * values.cwiseAbs())});
    INFO(name << ": " << test->why());
    REQUIRE(found.has_value());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      INFO(name << ", " << numbers[i].name);
      const VectorX expected = difference(values, i, [&](const VectorX& at) {
        return test->predict({row.get(), with_numbers(row.get(), trial, numbers, at), {}})->values;
      });
      CHECK((found->slopes.col(i) - expected).norm() <
            1e-6 * expected.norm() + 1e-9 * found->values.norm() / std::abs(values[i]));
    }
  }
}
