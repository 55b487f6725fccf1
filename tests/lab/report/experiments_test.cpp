// What the tables and files say of experiments that are not tension.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/shapes/surfaces.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/report/table.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

const std::string kLatticeBody =
    "{lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 1 cm, connections: [axis, face]}}";

std::vector<Record> records_of(const std::string& experiment, const std::string& strategies,
                               const std::string& more = "", const std::string& body = kLatticeBody,
                               const std::string& material = "{youngs_modulus: 10 kPa}") {
  const TemporaryFolder folder;
  const Catalog catalog = built_in_catalog();
  const auto scene =
      load_scene(folder.write("block.yaml", "title: A block\nbody: " + body +
                                                "\n"
                                                "material: " +
                                                material + "\nstiffness: lattice\nstrategies: [" + strategies +
                                                "]\nexperiment: {" + experiment + "}\n" + more),
                 catalog);
  std::vector<Record> records;
  for (const StrategyChoice& choice : scene->strategies)
    records.push_back(make_record(*scene, run_strategy(scene->specimen, *scene->experiment, choice,
                                                       {.statics = scene->statics, .time = scene->time})));
  return records;
}

}  // namespace

TEST_CASE("a comparison has the columns of its experiment", "[texts]") {
  const std::string material = comparison_text(records_of("kind: material", "standard, lattice"), false);
  CHECK_THAT(material, Contains("E measured  error of E  Poisson's ratio  error of G  error of K  anisotropy"));
  CHECK_THAT(material,
             Contains("recommended: lattice: E 0.0000 %, Poisson's ratio 0.2500, G 0.0000 %, K 0.0000 % (target: "));
  const std::string shear =
      comparison_text(records_of("kind: shear, direction: x, strain: 1e-6, sides: affine", "standard, lattice"), false);
  CHECK_THAT(shear, Contains("G measured  error of G") && Contains("axial force") && !Contains("Poisson"));
  CHECK_THAT(shear, Contains("recommended: lattice: G "));
  const std::string torsion = comparison_text(records_of("kind: torsion, angle: 1 deg", "lattice"), false);
  CHECK_THAT(torsion, Contains("torque") && Contains("µN m  "));
  const std::string tension = comparison_text(records_of("kind: tension, force: 1 uN", "standard, lattice"), false);
  CHECK_THAT(tension, Contains("E measured  error of E  Poisson's ratio  elongation  iterations"));
}

TEST_CASE("strategies are ranked by the reference where the scene names one", "[texts]") {
  // Twice too stiff a strategy is right if the reference, the same problem solved elsewhere, says so.
  const std::string experiment = "kind: hydrostatic, strain: -1e-6";
  const std::vector<Record> plain = records_of(experiment, "standard, lattice");
  CHECK_THAT(comparison_text(plain, false), Contains("recommended: lattice: K "));
  const double stiff = plain[0].run.measures.get("pressure");
  const std::vector<Record> referenced =
      records_of(experiment, "standard, lattice",
                 "reference: [{measure: pressure, value: " + std::to_string(stiff) + " Pa, source: me}]\n");
  CHECK_THAT(comparison_text(referenced, false),
             Contains("recommended: standard: pressure ") && Contains("to the reference"));
  CHECK(rank_strategies(referenced).best == &referenced[0]);
  // Of two references the worse one counts: a strategy that hits one of them by luck is not taken.
  std::vector<Record> two = referenced;
  two[0].errors.emplace_back("bulk_modulus_to_reference", 3.);
  two[1].errors.emplace_back("bulk_modulus_to_reference", 0.);
  const Ranking ranking = rank_strategies(two);
  CHECK(ranking.error(two[0]) == 3);
  CHECK(ranking.best == &two[1]);
  two[1].run.warnings.push_back("something is wrong");
  CHECK(rank_strategies(two).best == &two[0]);
  two[0].run.outcome = Outcome::diverged;
  CHECK(rank_strategies(two).best == nullptr);
}

TEST_CASE("errors are in units of the scatter where a reference is measured", "[texts]") {
  // G = 4 kPa: 4, 6 and 8 mPa at these strains, the second one between two load steps.
  const std::string experiment = "kind: shear, direction: x, strain: 2e-6, sides: affine, load_steps: 2";
  const auto measured = [&](const std::string& reference) {
    return records_of(experiment, "standard, lattice", "reference: [{source: me, " + reference + "}]\n");
  };
  const std::vector<Record> curve =
      measured("measure: stress, points: [[1e-6, 4.4 mPa, 0.2 mPa], [1.5e-6, 6 mPa, 1 mPa], [2e-6, 7.6 mPa, 0.4 mPa]]");
  CHECK(curve[1].error("stress_over_scatter") == Approx(std::sqrt((4 + 0 + 1) / 3.)).epsilon(1e-4));
  CHECK_THAT(comparison_text(curve, false),
             Contains("error of shear stress / scatter") || Contains("error of stress / scatter"));
  CHECK_FALSE(rank_strategies(curve).recommends());
  const std::vector<Record> value = measured("measure: shear_modulus, value: 4.4 kPa, scatter: 10 %");
  CHECK(value[1].error("shear_modulus_over_scatter") == Approx(0.4 / 0.44).epsilon(1e-4));
  CHECK(rank_strategies(value).best == &value[1]);
  CHECK_THAT(comparison_text(value, false), Contains("recommended: lattice: G 0.91 × the scatter of the specimens"));
  CHECK_THAT(scatter_table(value).text(false), Contains("nearest") && Contains("lattice") && Contains("0.91"));
  // A run that ends before the last point has no error.
  CHECK(std::isnan(measured("measure: stress, points: [[3e-6, 12 mPa, 1 mPa]]")[1].error("stress_over_scatter")));
  CHECK_THROWS_WITH(measured("measure: stress, points: [[2e-6, 8 mPa, 1 mPa], [1e-6, 4 mPa, 1 mPa]]"),
                    Contains("each further from 0 than the one before"));
}

TEST_CASE("clamped and tapered specimens recommend nothing by the material's E", "[texts]") {
  const std::string clamped = "kind: tension, displacement: 1 um, fixed_grip: clamped";
  const std::vector<Record> records = records_of(clamped, "standard, lattice");
  CHECK(rank_strategies(records).best == nullptr);
  const std::string text = comparison_text(records, false);
  CHECK_THAT(text, Contains("no reference: the grips clamp, so no specimen shows the material's E") &&
                       !Contains("recommended"));
  const double solid = records[0].run.measures.get("effective_modulus");
  CHECK_THAT(comparison_text(records_of(clamped, "standard, lattice",
                                        "reference: [{measure: effective_modulus, value: " + std::to_string(solid) +
                                            " Pa, source: me}]\n"),
                             false),
             Contains("recommended: standard: E ") && Contains("to the reference"));
  const std::vector<Record> tapered =
      records_of("kind: compression, displacement: 1 um", "standard, van_gelder, neo_hookean", "",
                 "{molecules: [[0 cm, 0 cm, 0 cm], [1 cm, 0 cm, 0 cm], [0 cm, 1 cm, 0 cm], [0 cm, 0 cm, 1 cm], "
                 "[1 cm, 0 cm, 1 cm], [0 cm, 3 cm, 1 cm]], cells: delaunay, radius: 5 mm}");
  REQUIRE(tapered[0].apparent);
  CHECK(std::isnan(tapered[0].error("effective_modulus")));
  const std::string said = comparison_text(tapered, false);
  CHECK_THAT(said, Contains("apparent E") && !Contains("error of E") &&
                       Contains("no reference: the body is no prism") &&
                       Contains("note: effective_modulus is apparent: the section varies by "));
  CHECK_THAT(run_text(tapered[0], false), Contains("effective_modulus is apparent") && Contains("apparent: "));
  CHECK(Json::parse(json_text(tapered))["runs"][0]["apparent"] == true);
  CHECK_FALSE(Json::parse(json_text(records))["runs"][0].contains("apparent"));
  // What the modulus differs by, the whole curve does.
  const Record curve =
      records_of("kind: tension, displacement: 1 mm, load_steps: 2", "neo_hookean_log", "",
                 "{molecules: [[0 cm, 0 cm, 0 cm], [1 cm, 0 cm, 0 cm], [0 cm, 1 cm, 0 cm], [0 cm, 0 cm, "
                 "1 cm], [1 cm, 0 cm, 1 cm], [0 cm, 3 cm, 1 cm]], cells: delaunay, radius: 5 mm}",
                 "{law: neo_hookean_log, youngs_modulus: 10 kPa, poissons_ratio: 0.3}")
          .front();
  REQUIRE(curve.apparent);
  CHECK_THAT(run_text(curve, false), Contains("apparent: largest |stress - the material's at that strain|"));
}

TEST_CASE("strategies that the measures do not tell apart are tied, the simplest first", "[texts]") {
  std::vector<Record> records = records_of("kind: tension, force: 1 uN", "patch, lattice, calibrated");
  double error = 1e-6, seconds = 1;  // patch is the fastest
  for (Record& record : records) {
    record.run.warnings.clear();
    record.run.build_seconds = 0;
    record.run.solve_seconds = seconds++;
    record.errors = {{"effective_modulus", error *= -1}, {"poissons_ratio", record.run.order > 1000 ? 0.1 : 0}};
  }
  const Ranking ranking = rank_strategies(records);
  CHECK(ranking.best == &records[1]);
  CHECK(ranking.tied == std::vector<const Record*>{&records[0]});  // calibrated:standard has another Poisson's ratio
  CHECK_THAT(comparison_text(records, false), Contains("recommended: lattice (tied with patch): E +0.0001 %"));
  // An error of 0.05 % is near enough, and is no tie: the fastest.
  records[0].errors.front().second = 5e-4;
  CHECK(rank_strategies(records).best == &records[0]);
  CHECK(rank_strategies(records).tied.empty());
  // Errors of E within a tenth of each other say less than those of Poisson's ratio; others do.
  std::vector<Record> far = records;
  far[0].errors.front().second = 4.2e-3, far[1].errors.front().second = 2e-2, far[2].errors.front().second = 3.96e-3;
  CHECK(rank_strategies(far).best == &far[0]);
  far[0].errors.front().second = 4.4e-3;
  CHECK(rank_strategies(far).best == &far[2]);
  // A reference that is known to 0.1 % does not tell them apart.
  for (Record& record : records) {
    record.references = {{"effective_modulus", 1e4, "elsewhere", 1e-3}};
    record.errors.emplace_back("effective_modulus_to_reference", record.errors.front().second);
  }
  CHECK(rank_strategies(records).best == &records[1]);
  CHECK(rank_strategies(records).tied == std::vector<const Record*>{&records[0]});
}

TEST_CASE("motions out of the plane of a flat sheet are a note where all acts within it, and else a mechanism",
          "[texts]") {
  const std::string sheet = "{sheet: {size: [3 cm, 2 cm], squares: [6, 4]}}",
                    material = "{youngs_modulus: 10 kPa, poissons_ratio: 0.25, thickness: 1 mm}",
                    law = "neo_hookean_membrane", tension = "kind: tension, axis: x, strain: 1 %";
  const std::string note = "motions out of the plane are not counted as zero-energy modes";
  for (const std::string turn : {"", "rotate: {axis: [1, 2, 3], angle: 40 deg}\n"})
    for (const std::string& experiment :
         {tension, std::string("kind: planar, strain: 1 %"), std::string("kind: biaxial, strain: [1 %, 0.5 %]")}) {
      INFO(experiment << ", " << turn);
      const std::vector<Record> records = records_of(experiment, law + ", uniform", turn, sheet, material);
      const Record& exact = records.front();
      CHECK(exact.run.zero_energy_modes == 0);
      CHECK(exact.run.warnings.empty());
      CHECK(exact.error("effective_modulus") == Approx(0).margin(1e-6));
      CHECK(exact.error("poissons_ratio") == Approx(0).margin(1e-6));
      const std::string text = comparison_text(records, false);
      CHECK_THAT(text, Contains("recommended: " + law + ": E 0.0000 %") && !Contains("mechanism"));
      const Json run = Json::parse(json_text(records))["runs"][0];
      CHECK(run["zero_energy_modes"] == 0);
      CHECK_THAT(run["notes"].dump(), Contains(note));
      CHECK_THAT(run_text(exact, false), Contains(note));
    }
  // In time, too.
  const std::string heavy = "{youngs_modulus: 10 kPa, poissons_ratio: 0.25, thickness: 1 mm, density: 1000 kg/m3}",
                    time = "time: {duration: 0.1 s, frames: 5}\n";
  for (const std::string experiment :
       {"kind: creep, fixture: {kind: tension, axis: x, force: 1 mN}",
        "kind: relaxation, ramp: 10 ms, fixture: {kind: tension, axis: x, strain: 1 %}",
        "kind: motion, fixture: {kind: tension, axis: x, strain: 1 %}, in_time: {ramp: {duration: 0.1 s}}"}) {
    const Record flat = records_of(experiment, law, time, sheet, heavy).front(),
                 bent = records_of(experiment, law,
                                   time + "loads: [{gravity: [0, 0, -1 m/s2], in_time: {step: {at: 50 ms}}}]\n", sheet,
                                   heavy)
                            .front();
    INFO(experiment);
    CHECK(flat.run.zero_energy_modes == 0);
    CHECK_THAT(run_text(flat, false), Contains(note) && !Contains("mechanism"));
    CHECK(bent.run.zero_energy_modes > 0);
    CHECK_THAT(run_text(bent, false), !Contains(note) && Contains("mechanism"));
  }
  // Squares without diagonals: columns of molecules slide along each other, but one with the whole.
  const Record squares =
      records_of(tension + ", cross_section: 2 cm2", "uniform", "",
                 "{lattice: {kind: cubic, molecules: [4, 3, 1], spacing: 1 cm, connections: [axis]}}")
          .front();
  CHECK(squares.run.zero_energy_modes == 3);
  CHECK_THAT(run_text(squares, false), Contains(note) && Contains("warning: mechanism: 3 zero-energy modes;"));
  // What leaves the plane works on them, and vibrations are nothing else.
  for (const auto& [experiment, loads] :
       {std::pair<std::string, std::string>{tension, "loads: [{gravity: [0, 0, -1 m/s2]}]\n"},
        {"kind: vibration", ""}}) {
    const Record bent =
        records_of(experiment, law, loads, sheet, "{youngs_modulus: 10 kPa, thickness: 1 mm, density: 1000 kg/m3}")
            .front();
    CHECK(bent.run.zero_energy_modes == 32);
    CHECK_THAT(run_text(bent, false),
               !Contains(note) &&
                   Contains("warning: mechanism: 32 zero-energy modes, 32 of them out of the plane of the flat body"));
  }
}

TEST_CASE("a strip that wrinkles has no target of its width, and one that does not has the law's", "[texts]") {
  const auto pulled = [](const std::string& law, const std::string& strain) {
    return records_of("kind: tension, axis: x, strain: " + strain, law, "",
                      "{sheet: {size: [20 mm, 15 mm], squares: [4, 3], pattern: crossed}}",
                      "{youngs_modulus: 60 kPa, poissons_ratio: 0.5, thickness: 0.4 mm}")
        .front();
  };
  for (const char* strain : {"20 %", "1e-6"}) {
    const Record taut = pulled("neo_hookean_membrane", strain),
                 folds = pulled("neo_hookean_membrane+wrinkling", strain);
    CHECK(taut.error("poissons_ratio") == Approx(0).margin(1e-6));
    CHECK_THAT(run_text(taut, false), !Contains("width is indeterminate"));
    CHECK(folds.error("effective_modulus") == Approx(0).margin(1e-6));
    CHECK_FALSE(std::isfinite(folds.error("poissons_ratio")));
    CHECK(folds.law_target("poissons_ratio") == nullptr);
    CHECK_THAT(run_text(folds, false), Contains("there is no target of Poisson's ratio"));
  }
}

TEST_CASE("a sheet whose places are in single precision is as flat as an exact one", "[texts]") {
  const TemporaryFolder folder;
  Body sheet = rectangular_sheet({0.06, 0.02}, {12, 4}, SheetPattern::alternating);
  rotate(sheet, Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix());
  std::string mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(sheet.size()) + "\n";
  for (int i = 0; i < sheet.size(); ++i)
    mesh += std::to_string(i + 1) + fmt::format(" {:.7g} {:.7g} {:.7g}\n", 1e3 * sheet.rest(0, i) + 20,
                                                1e3 * sheet.rest(1, i) + 30, 1e3 * sheet.rest(2, i) + 40);
  mesh += "$EndNodes\n$Elements\n" + std::to_string(sheet.triangles.size()) + "\n";
  for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
    const auto& [a, b, c] = sheet.triangles[i];
    mesh += fmt::format("{} 2 0 {} {} {}\n", i + 1, a + 1, b + 1, c + 1);
  }
  const std::string file = folder.write("sheet.msh", mesh + "$EndElements\n");
  const Record record =
      records_of("kind: tension, axis: longest, strain: 1 %", "neo_hookean_membrane", "",
                 "{mesh: {file: " + file + ", length_unit: mm}}", "{youngs_modulus: 10 kPa, thickness: 1 mm}")
          .front();
  const std::string text = run_text(record, false);
  INFO(text);
  CHECK(record.run.zero_energy_modes == 0);
  CHECK(record.run.warnings.empty());
  CHECK_THAT(text, Contains("motions out of the plane are not counted as zero-energy modes"));
}

TEST_CASE("the stiffness matrix stands on the page and in the JSON", "[texts][files]") {
  const std::vector<Record> records = records_of("kind: material", "lattice");
  const std::string page = run_text(records[0], false);
  CHECK_THAT(page, Contains("stiffness          xx          yy          zz          yz          xz          xy\n"));
  CHECK_THAT(page, Contains("  xx         12.000 kPa  4.0000 kPa  4.0000 kPa           0           0           0\n"));
  CHECK_THAT(page, Contains("  xy                  0           0           0           0           0  4.0000 kPa\n"));
  const Json matrix = Json::parse(json_text(records))["runs"][0]["stiffness_matrix"];
  REQUIRE(matrix.size() == 6);
  for (std::size_t row = 0; row < 6; ++row) {
    REQUIRE(matrix[row].size() == 6);
    for (std::size_t column = 0; column < 6; ++column) {
      const bool normal = row < 3 && column < 3;
      const double expected = row == column ? (normal ? 12000 : 4000) : normal ? 4000 : 0;  // E = 10 kPa, nu = 1/4
      CHECK(matrix[row][column].get<double>() == Approx(expected).margin(1e-4));
    }
  }
  CHECK_FALSE(Json::parse(json_text(records_of("kind: hydrostatic, strain: 1 %", "lattice")))["runs"][0].contains(
      "stiffness_matrix"));
  CHECK_THAT(csv_text(records), Contains(",torque [N m],") && Contains(",anisotropy_index,"));
}

TEST_CASE("a curve has the columns of its experiment", "[texts]") {
  const std::vector<Record> records = records_of("kind: torsion, angle: 20 deg, load_steps: 2", "lattice");
  const std::string page = run_text(records[0], false);
  CHECK_THAT(page, Contains("  load") && Contains("torque") && Contains("angle") && Contains("torsional stiffness"));
  CHECK_THAT(page, !Contains("elongation") && !Contains("E secant"));
}
