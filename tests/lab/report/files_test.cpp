#include "lab/report/files.h"
#include "lab/report/records.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/report/page.h"
#include "lab/report/table.h"
#include "lab/run/cell_stress.h"
#include "lab/run/contact_measures.h"
#include "lab/study/request.h"
#include "support/temporary_folder.h"
#include "support/vtu_arrays.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

// A bar of one connection: k = E A / L by hand, with the molecule's cross-section A = (2 r)² = 9 cm².
const std::string kBar = R"(title: "A bar, \"quoted\", with commas"
body:
  molecules: [[0, 0, 0], [0, 0, 15 mm]]
  connections: [[0, 1]]
  radius: 15 mm
material: {youngs_modulus: 5 kPa}
stiffness: standard
experiment: {kind: tension, axis: z, force: 0.2 N, fixed_grip: clamped, loaded_grip: clamped, cross_section: 8.9 cm2, load_steps: 4}
loads: [{damping: 1 N s/m}]
expect:
  - {measure: effective_modulus, value: 5 kPa, tolerance: 2 %, source: pen and paper}
  - {strategy: standard, measure: poissons_ratio, value: 0, absolute: 0.1, source: nobody, not_reproduced: no section}
)";

struct Runs {
  std::unique_ptr<Scene> scene;
  std::vector<Record> records;
};

/// With all its states.
Run run_of(const Scene& scene) {
  const RunOptions options{scene.statics, true, {}};
  Run run = run_strategy(scene.specimen, *scene.experiment, scene.stiffness, options);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

Runs run(const std::string& text, const std::string& strategies, const std::vector<std::string>& overrides = {}) {
  const TemporaryFolder folder;
  const Catalog catalog = built_in_catalog();
  Runs runs{load_scene(folder.write("bar.yaml", text), catalog, overrides), {}};
  Scene& scene = *runs.scene;
  std::istringstream names(strategies);
  for (std::string name; names >> name;) {
    const StrategyChoice choice = scene.stiffness.label == name ? scene.stiffness : choose_strategy(catalog, name);
    const RunOptions options{scene.statics, true, {}};
    runs.records.push_back(make_record(scene, run_strategy(scene.specimen, *scene.experiment, choice, options)));
  }
  return runs;
}

/// One connection shows E in clamps too: compares a record with the material.
void compare_with_material(Record& record) {
  record.no_reference.clear();
  record.main_measures.front().prescribed = 5000;
  if (const double modulus = record.run.measures.get("effective_modulus"); std::isfinite(modulus))
    record.errors = {{"effective_modulus", modulus / 5000 - 1}};
}

/// Runs that came out in every way: converged, not suited, stopped, failed in calibration; and one that is all NaN.
std::vector<Record> all_outcomes() {
  std::vector<Record> records = run(kBar, "standard van_gelder").records;
  for (Record& record : run(kBar, "standard", {"solver.newton_limit=1", "experiment.force=5"}).records)
    records.push_back(record);
  for (Record& record :
       run(kBar, "calibrated:uniform", {"stiffness={strategy: calibrated:uniform, constant: 0}"}).records)
    records.push_back(record);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Record odd = records.front();
  odd.run.residual = odd.run.solve_seconds = odd.run.curve.front().residual = nan;
  odd.run.measures.set("energy", nan);
  odd.errors = {{"effective_modulus", std::numeric_limits<double>::infinity()}};
  odd.verdicts.front().measured = odd.verdicts.front().difference = nan;
  odd.verdicts.front().passed = false;
  odd.run.cause = "no \xff UTF-8, \"quotes\",\nand lines";
  records.push_back(odd);
  return records;
}

/// No word of a text is NaN or infinite.
bool all_finite(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::isalnum(c) ? std::tolower(c) : ' '; });
  std::istringstream words(text);
  for (std::string word; words >> word;)
    if (word == "nan" || word == "inf" || word == "infinity") return false;
  return true;
}

/// Rows of fields of a CSV text, quotes undone.
std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const char c = csv[i];
    if (quoted && c == '"' && i + 1 < csv.size() && csv[i + 1] == '"')
      rows.back().back() += csv[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      rows.back().emplace_back();
    else if (c == '\n' && !quoted)
      rows.push_back({""});
    else
      rows.back().back() += c;
  }
  CHECK(rows.back() == std::vector<std::string>{""});  // the last line ends
  rows.pop_back();
  return rows;
}

std::string field(const std::vector<std::vector<std::string>>& rows, std::size_t row, const std::string& column) {
  const auto found = std::find(rows[0].begin(), rows[0].end(), column);
  REQUIRE(found != rows[0].end());
  return rows[row][found - rows[0].begin()];
}

std::vector<double> numbers(const pugi::xml_node& parent, const char* name, int components) {
  const pugi::xml_node array = parent.find_child_by_attribute("DataArray", "Name", name);
  INFO(name);
  REQUIRE(array);
  CHECK(array.attribute("NumberOfComponents").as_int() == components);
  return numbers_of(array);
}

struct Vtu {
  pugi::xml_document document;
  pugi::xml_node piece;
  explicit Vtu(const std::string& text) {
    REQUIRE(document.load_string(text.c_str()));
    piece = document.child("VTKFile").child("UnstructuredGrid").child("Piece");
    REQUIRE(piece);
  }
};

}  // namespace

TEST_CASE("JSON of runs has the shape that is promised", "[files]") {
  const Json json = Json::parse(json_text(run(kBar, "standard van_gelder").records));
  REQUIRE(json.size() == 2);
  CHECK(json["references"].empty());
  REQUIRE(json["runs"].size() == 2);
  for (const Json& object : json["runs"]) {
    for (const char* text : {"scene", "title", "strategy", "solver", "outcome", "cause"})
      CHECK(object.at(text).is_string());
    for (const char* count :
         {"molecules", "connections", "cells", "threads", "iterations", "linear_iterations", "zero_energy_modes"})
      CHECK(object.at(count).is_number_integer());
    for (const char* values : {"measures", "errors", "seconds"}) {
      CHECK(object.at(values).is_object());
      for (const Json& value : object.at(values)) CHECK(value.is_number());
    }
    CHECK(object.at("residual").is_number());
    CHECK(object.at("seconds").size() == 2);
    CHECK(object.at("seconds").at("build") >= 0);
    CHECK(object.at("seconds").at("solve") >= 0);
    CHECK(object.at("warnings").is_array());
    CHECK(object.at("curve").is_array());
    CHECK(object.at("expectations").is_array());
  }
  const Json& good = json["runs"][0];
  CHECK(good["scene"] == "bar");
  CHECK(good["title"] == "A bar, \"quoted\", with commas");
  CHECK(good["strategy"] == "standard");
  CHECK(good["outcome"] == "converged");
  CHECK(good["molecules"] == 2);
  CHECK(good["connections"] == 1);
  CHECK(good["cells"] == 0);
  CHECK(good["measures"]["force"] == Approx(0.2));
  // k = E (2r)² / L; F l0 / (A Δl) with Δl = F / k.
  const double k = 5000 * 0.03 * 0.03 / 0.015;
  CHECK(good["measures"]["elongation"].get<double>() == Approx(0.2 / k).epsilon(1e-9));
  const double modulus = k * 0.015 / 8.9e-4;
  CHECK(good["measures"]["effective_modulus"].get<double>() == Approx(modulus).epsilon(1e-9));
  CHECK(good["errors"].empty());                             // between clamps nothing is compared with the material
  CHECK_FALSE(good["measures"].contains("poissons_ratio"));  // two molecules have none
  REQUIRE(good["curve"].size() == 4);
  CHECK(good["curve"][1]["load_factor"] == 0.5);
  CHECK(good["curve"][1]["force"] == Approx(0.1));
  REQUIRE(good["warnings"].size() == 1);  // what the scene as a whole is warned of stands in every run
  CHECK_THAT(good["warnings"][0].get<std::string>(), Contains("loads[0]"));
  REQUIRE(good["expectations"].size() == 2);
  CHECK(good["expectations"][0]["holds"] == true);  // 1.1 % off, 2 % allowed
  CHECK(good["expectations"][0]["judged"] == true);
  CHECK(good["expectations"][1]["judged"] == false);
  CHECK(good["expectations"][1]["not_reproduced"] == "no section");
  CHECK_FALSE(good["expectations"][1].contains("measured"));

  const Json& unsuited = json["runs"][1];
  CHECK(unsuited["outcome"] == "unsuited");
  CHECK_THAT(unsuited["cause"].get<std::string>(), Contains("needs tetrahedra or triangles"));
  CHECK(unsuited["measures"].empty());
  CHECK(unsuited["curve"].empty());
  CHECK(unsuited["expectations"].empty());  // it names no strategy, so it is about those that run
}

TEST_CASE("no file holds a number that is not finite, whatever came out", "[files]") {
  const std::vector<Record> records = all_outcomes();
  REQUIRE(records.size() == 5);
  CHECK(records[1].run.suited == false);
  CHECK(records[2].run.outcome == Outcome::limit_reached);
  CHECK(records[3].run.outcome != Outcome::converged);
  const std::string json = json_text(records), csv = csv_text(records);
  CHECK(all_finite(json));
  REQUIRE_NOTHROW(Json::parse(json));
  CHECK(Json::parse(json)["runs"][4]["residual"].is_null());
  CHECK(all_finite(csv));
  for (const auto& row : rows_of(csv)) CHECK(row.size() == rows_of(csv)[0].size());
  for (const Record& record : records) CHECK(all_finite(curve_csv_text(record)));
  CHECK(all_finite(comparison_text(records, false)));
}

TEST_CASE("CSV of runs has a row a run and a column a quantity, with its unit", "[files]") {
  const std::vector<Record> records = all_outcomes();
  const auto rows = rows_of(csv_text(records));
  REQUIRE(rows.size() == 6);
  CHECK(std::vector<std::string>(rows[0].begin(), rows[0].begin() + 8) ==
        std::vector<std::string>{"scene", "strategy", "solver", "outcome", "molecules", "connections", "cells",
                                 "threads"});
  for (const char* column : {"effective_modulus [Pa]", "elongation [m]", "poissons_ratio", "energy [J]",
                             "error effective_modulus", "build [s]", "solve [s]", "iterations", "residual", "warnings"})
    CHECK(std::count(rows[0].begin(), rows[0].end(), column) == 1);
  CHECK(field(rows, 1, "strategy") == "standard");
  CHECK(field(rows, 1, "outcome") == "converged");
  CHECK(std::stod(field(rows, 1, "force [N]")) == 0.2);
  CHECK(std::stod(field(rows, 1, "effective_modulus [Pa]")) == records[0].run.measures.get("effective_modulus"));
  CHECK(field(rows, 2, "outcome") == "unsuited");
  CHECK(field(rows, 2, "effective_modulus [Pa]").empty());
  CHECK(field(rows, 3, "outcome") == "limit_reached");
  CHECK_THAT(field(rows, 5, "warnings"), Contains("\"quotes\",\nand lines"));
  // What a study changes has columns of its own, in SI units.
  std::vector<Record> study = records;
  study[0].variant = {{"material.youngs_modulus", "12 kPa"}, {"experiment.axis", "x"}};
  study[1].variant = {{"material.youngs_modulus", "0.5 MPa"}, {"experiment.axis", "z"}};
  const auto varied = rows_of(csv_text(study));
  for (const auto& row : varied) CHECK(row.size() == rows[0].size() + 2);
  CHECK(field(varied, 1, "material.youngs_modulus [Pa]") == "12000");
  CHECK(field(varied, 2, "material.youngs_modulus [Pa]") == "500000");
  CHECK(field(varied, 2, "experiment.axis") == "z");
  CHECK(field(varied, 3, "experiment.axis").empty());
}

TEST_CASE("a name that a spreadsheet would take for a formula is text", "[files]") {
  std::vector<Record> records = all_outcomes();
  records[0].scene = "=1+1";
  records[1].scene = "@sum";
  const auto rows = rows_of(csv_text(records));
  CHECK(field(rows, 1, "scene") == "'=1+1");
  CHECK(field(rows, 2, "scene") == "'@sum");
}

TEST_CASE("no two labels write the same file", "[files]") {
  std::set<std::string> names;
  for (const char* label : {"a/b", "a-b", "a\\b", "a~2fb", "a<b", "a%2fb"}) names.insert(file_name("scene", label));
  CHECK(names.size() == 6);
  CHECK(file_name("cube", "calibrated:standard") == "cube-calibrated-standard");
  std::vector<Record> records = run(kBar, "standard").records;
  for (Record& record : records) record.scene = "a b/c~";
  const auto plots = plot_files(records, {});
  CHECK_FALSE(plots.empty());
  for (const auto& [name, text] : plots) CHECK(name.starts_with("a~20b~2fc~7e-"));
}

TEST_CASE("CSV of a curve has a row a load step", "[files]") {
  const Record record = run(kBar, "standard").records.front();
  const auto rows = rows_of(curve_csv_text(record));
  REQUIRE(rows.size() == 5);
  for (const auto& row : rows) CHECK(row.size() == rows[0].size());
  for (std::size_t step = 1; step <= 4; ++step) {
    CHECK(std::stod(field(rows, step, "load_factor")) == Approx(0.25 * static_cast<double>(step)));
    CHECK(std::stod(field(rows, step, "force [N]")) == Approx(0.05 * static_cast<double>(step)));
  }
  // A column for each measure that some row has, and no other.
  for (std::size_t column = 0; column < rows[0].size(); ++column)
    CHECK(std::any_of(rows.begin() + 1, rows.end(), [&](const auto& row) { return !row[column].empty(); }));
}

TEST_CASE("a VTU file holds molecules as points and connections as lines", "[files]") {
  Runs runs = run(kBar, "standard");
  const Body& body = runs.scene->specimen.body;
  const Run& last = runs.records.front().run;
  REQUIRE(last.snapshots.size() == 5);
  const Snapshot& end = last.snapshots.back();
  const std::string text = vtu_text(body, end, last.constants);
  CHECK(finite_arrays(text));
  const Vtu vtu(text);
  CHECK(vtu.piece.attribute("NumberOfPoints").as_int() == 2);
  CHECK(vtu.piece.attribute("NumberOfCells").as_int() == 1);
  const auto points = vtu.piece.child("PointData"), cells = vtu.piece.child("CellData");
  const double stretch = last.measures.get("elongation");
  CHECK(numbers(vtu.piece.child("Points"), "positions", 3)[5] == Approx(0.015 + stretch));
  CHECK(numbers(points, "displacement", 3)[5] == Approx(stretch));
  CHECK(numbers(points, "radius", 1) == std::vector<double>{0.015, 0.015});
  CHECK(numbers(points, "mass", 1).size() == 2);
  // In equilibrium the connection carries the load, and pulls its two molecules together.
  CHECK(numbers(cells, "tension", 1)[0] == Approx(0.2).epsilon(1e-9));
  CHECK(numbers(cells, "strain", 1)[0] == Approx(stretch / 0.015));
  CHECK(numbers(cells, "constant", 1)[0] == last.constants[0]);
  const auto force = numbers(points, "elastic_force", 3);
  REQUIRE(force.size() == 6);
  CHECK(force[2] == Approx(0.2).epsilon(1e-9));
  CHECK(force[5] == Approx(-0.2).epsilon(1e-9));
}

TEST_CASE("arrays of a VTU file that are longer than a block are packed in several, whose last may be full",
          "[files]") {
  // 2^17 numbers of 8 bytes are a block: of as many molecules the places are three full ones, and the ends of the
  // connections one or more that are not.
  const Body body = [] {
    Body made = cubic_lattice({64, 64, 32}, 0.001, {true, false, false});
    set_matter(made, 0.0005, 1000, 0, 0.063 * 0.063 * 0.031);
    return made;
  }();
  const int n = 64 * 64 * 32, m = body.connections.size();
  REQUIRE(body.size() == n);
  const Vtu vtu(vtu_text(body, {0, 1.1 * body.rest, VectorX::Constant(m, 2)}, {}));
  const auto positions = numbers(vtu.piece.child("Points"), "positions", 3);
  REQUIRE(static_cast<int>(positions.size()) == 3 * n);
  for (int i = 0; i < 3 * n; ++i)
    if (positions[i] != 1.1 * body.rest(i % 3, i / 3)) FAIL_CHECK("number " << i << " of the places");
  const auto ends = numbers(vtu.piece.child("Cells"), "connectivity", 1),
             offsets = numbers(vtu.piece.child("Cells"), "offsets", 1);
  REQUIRE(static_cast<int>(ends.size()) == 2 * m);
  REQUIRE(static_cast<int>(offsets.size()) == m);
  for (int c = 0; c < m; ++c) {
    const auto at = static_cast<std::size_t>(c);
    if (ends[2 * at] != body.connections.ends[at][0] || ends[2 * at + 1] != body.connections.ends[at][1] ||
        offsets[at] != 2 * c + 2)
      FAIL_CHECK("connection " << c);
  }
}

TEST_CASE("the arrays of a VTU file fit together on any body", "[files]") {
  Body body = cubic_lattice({3, 3, 4}, 0.01, {true, true, true});
  set_matter(body, 0.005, 1000, 0, 0.02 * 0.02 * 0.03);
  body.connections.ends.push_back({0, 0});  // of no length: a strain of none is no strain
  body.connections.rest_length.push_back(0);
  const int n = body.size(), m = body.connections.size();
  const bool springs = GENERATE(true, false);
  const std::string text = vtu_text(body, {0, 1.1 * body.rest, VectorX::Constant(m, 2)},
                                    springs ? VectorX(VectorX::Constant(m, 3)) : VectorX());
  CHECK(finite_arrays(text));
  const Vtu vtu(text);
  CHECK(vtu.piece.attribute("NumberOfPoints").as_int() == n);
  CHECK(vtu.piece.attribute("NumberOfCells").as_int() == m);
  for (const pugi::xml_node array : vtu.piece.child("PointData").children())
    CHECK(static_cast<int>(numbers(vtu.piece.child("PointData"), array.attribute("Name").value(),
                                   array.attribute("NumberOfComponents").as_int())
                               .size()) == n * array.attribute("NumberOfComponents").as_int());
  for (const pugi::xml_node array : vtu.piece.child("CellData").children())
    CHECK(static_cast<int>(numbers(vtu.piece.child("CellData"), array.attribute("Name").value(), 1).size()) == m);
  CHECK(std::string(vtu.piece.child("CellData").attribute("Scalars").value()) == "strain");
  CHECK(static_cast<bool>(vtu.piece.child("CellData").find_child_by_attribute("Name", "constant")) == springs);
  const auto strain = numbers(vtu.piece.child("CellData"), "strain", 1);
  CHECK(strain.front() == Approx(0.1));
  CHECK(strain.back() == 0);
  const auto cells = vtu.piece.child("Cells");
  const auto ends = numbers(cells, "connectivity", 1), offsets = numbers(cells, "offsets", 1);
  REQUIRE(static_cast<int>(ends.size()) == 2 * m);
  REQUIRE(static_cast<int>(offsets.size()) == m);
  for (int c = 0; c < m; ++c) {
    const auto at = static_cast<std::size_t>(c);
    CHECK((ends[2 * at] == body.connections.ends[at][0] && ends[2 * at + 1] == body.connections.ends[at][1]));
    CHECK(offsets[at] == 2 * (c + 1));
  }
  const auto types = numbers(cells, "types", 1);
  CHECK(types == std::vector<double>(static_cast<std::size_t>(m), 3));  // VTK_LINE
}

TEST_CASE("a VTU file holds the cells with their strain and stress, and our own reader takes it", "[files]") {
  const TemporaryFolder folder;
  const auto scene =
      load_scene(folder.write("block.yaml",
                              "body: {tetrahedra: {kind: kuhn, cubes: [4, 3, 2], size: [40 mm, 30 mm, 20 mm]}}\n"
                              "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
                              "experiment: {kind: tension, axis: x, displacement: 4 mm}\n"),
                 built_in_catalog());
  const Run run = run_of(*scene);
  const Body& body = scene->specimen.body;
  const Snapshot& end = run.snapshots.back();
  const std::string text = vtu_text(body, end, run.constants);
  const mesh::Mesh mesh = mesh::load_mesh(folder.write("block.vtu", text));
  CHECK(mesh.points == end.positions);  // bit for bit
  CHECK(mesh.tetrahedra == body.tetrahedra);
  const int m = body.connections.size(), cells = m + static_cast<int>(body.tetrahedra.size());
  const Vtu vtu(text);
  CHECK(vtu.piece.attribute("NumberOfCells").as_int() == cells);
  const auto data = vtu.piece.child("CellData");
  const auto stress = numbers(data, "stress", 9), strain = numbers(data, "green_strain", 9),
             mises = numbers(data, "von_mises", 1), tension = numbers(data, "tension", 1);
  REQUIRE(stress.size() == static_cast<std::size_t>(9 * cells));
  // Uniaxial tension without disturbance: Green strain (λ² − 1)/2 along the pull in every cell, λ = 1.1.
  double virial = 0, volume = 0;
  for (int cell = m; cell < cells; ++cell) {
    const auto at = static_cast<std::size_t>(cell);
    CHECK(strain[9 * at] == Approx((1.1 * 1.1 - 1) / 2).epsilon(1e-6));
    CHECK(strain[9 * at + 4] < 0);
    CHECK(mises[at] > 0);
    CHECK(tension[at] == 0);
    const double size = signed_volume(end.positions, body.tetrahedra[at - static_cast<std::size_t>(m)]);
    volume += size;
    virial += size * stress[9 * at];
  }
  for (int connection = 0; connection < m; ++connection) CHECK(stress[9 * static_cast<std::size_t>(connection)] == 0);
  // The mean stress of the body is the force on its grips times its length, over its volume: the virial theorem.
  CHECK(virial / volume == Approx(run.measures.get("force") * 0.044 / volume).epsilon(1e-6));
  CHECK(text.size() < 60'000);
}

TEST_CASE("cells of any shape show the stress that balances the grips, of laws and of springs", "[files]") {
  const auto [body, stiffness] = GENERATE(table<std::string, std::string>(
      {{"tetrahedra: {kind: kuhn, cubes: [2, 3, 4], size: [2 mm, 3 mm, 4 mm]}", "van_gelder"},
       {"lattice: {kind: cubic, molecules: [3, 4, 5], spacing: 1 mm, order: 2}", "standard"},
       {"image: {file: block.nrrd, length_unit: mm}", "standard"},
       {"image: {file: block.nrrd, length_unit: mm}", "standard+volume"},
       {"image: {file: block.nrrd, length_unit: mm}", "neo_hookean"},
       {"lattice: {kind: cubic, molecules: [3, 4, 5], spacing: 1 mm, order: 2}", "neo_hookean"}}));
  INFO(body << ", " << stiffness);
  const TemporaryFolder folder;
  folder.write("block.nrrd",
               "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 4\nspacings: 1 1 1\nencoding: ascii\n\n"
               "1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n");
  const auto scene = load_scene(
      folder.write("block.yaml", "body: {" + body +
                                     "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: \"" +
                                     stiffness + "\"\nexperiment: {kind: tension, axis: z, displacement: 0.4 mm}\n"),
      built_in_catalog());
  const Run run = run_of(*scene);
  const Body& specimen = scene->specimen.body;
  const Snapshot& end = run.snapshots.back();
  const std::vector<CellState> states = cell_states(specimen, end);
  REQUIRE(states.size() == OwnSimplices(specimen).size() + cells_in_blocks(specimen));
  double volume = 0, virial = 0, strain = 0;
  std::vector<std::vector<std::array<int, 4>>> cells;  // each by its tetrahedra
  if (specimen.blocks.empty())
    for (const auto& own : specimen.tetrahedra) cells.push_back({own});
  auto next = specimen.tetrahedra.begin();
  for (const CellBlock& block : specimen.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto count = static_cast<std::ptrdiff_t>(simplices_of(*block.kind, block.cell(cell)).size());
      cells.emplace_back(next, next + count), next += count;
    }
  REQUIRE(cells.size() == states.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    double own = 0;
    for (const auto& simplex : cells[cell]) own += signed_volume(end.positions, simplex);
    volume += own, virial += own * states[cell].stress(2, 2);
    CHECK(von_mises(states[cell]) > 0);
    strain += states[cell].strain(2, 2) / static_cast<double>(cells.size());
  }
  // The virial theorem: force on the grips times the present length, over the present volume.
  CHECK(virial == Approx(run.measures.get("force") * 4.4e-3).epsilon(1e-6));
  CHECK(strain == Approx((1.1 * 1.1 - 1) / 2).epsilon(0.05));
  CHECK_THAT(states_view(*scene, make_record(*scene, run)), Contains("\"stresses\""));
}

TEST_CASE("cells show the stress of springs and of a law together", "[files]") {
  const TemporaryFolder folder;
  const auto scene =
      load_scene(folder.write("block.yaml",
                              "body: {lattice: {kind: cubic, molecules: [3, 4, 5], spacing: 1 mm, order: 2}}\n"
                              "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
                              "experiment: {kind: tension, axis: z, displacement: 0.4 mm}\n"),
                 built_in_catalog());
  const Body& body = scene->specimen.body;
  Model model(body);
  for (const char* strategy : {"neo_hookean", "standard"})
    model.add(built_in_catalog().find(strategy).make(body, scene->specimen.material, {}));
  State state = state_at_rest(body);
  const Matrix3 F = (Matrix3() << 1.1, 0.05, 0, 0, 0.95, 0.02, 0.1, 0, 1.2).finished();
  state.positions = F * body.rest;
  const std::vector<CellState> states = cell_states(body, snapshot_of(model, state, 0, 0));
  const double each = F.determinant() * 24e-9 / static_cast<double>(states.size());
  Matrix3 sum = Matrix3::Zero();
  for (const CellState& cell : states) {
    sum += each * cell.stress;
    CHECK((cell.strain - (F.transpose() * F - Matrix3::Identity()) / 2).norm() < 1e-9);
  }
  // What is uniform has the virial of the forces on the molecules, -f x, as volume times stress.
  const Matrix3 virial = -model.elastic_forces(state.positions) * state.positions.transpose();
  CHECK((sum - virial).norm() < 1e-9 * virial.norm());
  const Matrix3 of_law = -[&] {
    Model alone(body);
    alone.add(built_in_catalog().find("neo_hookean").make(body, scene->specimen.material, {}));
    return Matrix3(alone.elastic_forces(state.positions) * state.positions.transpose());
  }();
  CHECK((virial - of_law).norm() > 0.1 * virial.norm());
}

TEST_CASE("states are written as one file a load step and a collection that names them", "[files]") {
  const TemporaryFolder folder;
  Runs runs = run(kBar, "standard");
  write_states(folder.path(""), "bar", runs.scene->specimen.body, runs.records.front().run);
  pugi::xml_document document;
  REQUIRE(document.load_file(folder.path("bar.pvd").c_str()));
  std::vector<double> times;
  for (const pugi::xml_node set : document.child("VTKFile").child("Collection").children("DataSet")) {
    times.push_back(set.attribute("timestep").as_double());
    const Vtu vtu(text_of_file(folder.path(set.attribute("file").value())));
    const auto displacement = numbers(vtu.piece.child("PointData"), "displacement", 3);
    CHECK(displacement[5] == Approx(times.back() * runs.records.front().run.measures.get("elongation")).margin(1e-12));
  }
  CHECK(times == std::vector<double>{0, 0.25, 0.5, 0.75, 1});
}

TEST_CASE("a file is written whole or not at all", "[files]") {
  const TemporaryFolder folder;
  const auto refusal = [](const std::string& path) -> std::string {
    try {
      write_whole(path, "text");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string path = folder.path("new/folder/file.txt");
  write_whole(path, "one");
  write_whole(path, "two");
  CHECK(text_of_file(path) == "two");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  // A file where a folder should be, a folder where a file should be.
  CHECK(refusal(path + "/x.txt") == path + "/x.txt: cannot make its folder: Not a directory");
  CHECK(refusal(folder.path("new")) == folder.path("new") + ": cannot write: Is a directory");
  CHECK(text_of_file(path) == "two");
  // What is no plain file is written to, not replaced.
  const std::string pipe = folder.path("pipe");
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const int reader = open(pipe.c_str(), O_RDWR | O_NONBLOCK);
  write_whole(pipe, "text");
  char text[8] = {};
  CHECK(read(reader, text, sizeof text) == 4);
  CHECK(std::string(text) == "text");
  close(reader);
}

TEST_CASE("a table is aligned by what a terminal shows", "[files]") {
  lab::Table table({"name", "value", ""});
  table.add({{"µm"}, {"1.5", Tone::good, true}, {"×"}});
  table.add({{"—"}, {"10.25", Tone::plain, true}, {"note", Tone::bad}});
  table.add({{"long name"}, {"", Tone::plain, true}});
  CHECK(table.text(false) ==
        "  name       value\n"
        "  µm           1.5  ×\n"
        "  —          10.25  note\n"
        "  long name\n");
  const std::string coloured = table.text(true);
  CHECK_THAT(coloured, Contains("  \033[32m1.5\033[0m  ×\n") && Contains("\033[31mnote\033[0m"));
}

TEST_CASE("texts have no escape codes unless colours are requested", "[files]") {
  const std::vector<Record> records = all_outcomes();
  CHECK_THAT(comparison_text(records, false), !Contains("\033"));
  CHECK_THAT(comparison_text(records, true), Contains("\033["));
  for (const Record& record : records) {
    CHECK_THAT(run_text(record, false), !Contains("\033"));
    CHECK_THAT(run_text(record, true), Contains("\033["));
  }
}

TEST_CASE("a comparison states the result of each strategy and which is recommended", "[files]") {
  std::vector<Record> all = all_outcomes();
  for (Record& record : all) compare_with_material(record);
  all.back().errors.clear();  // nothing of it is a number
  const std::string text = comparison_text(all, false);
  CHECK_THAT(text, Contains("2 molecules, 1 connection; target: E = 5.0000 kPa, nu = 0.25; "));
  CHECK_THAT(text, Contains("  not suited: needs tetrahedra or triangles\n"));
  CHECK_THAT(text, Contains("  limit reached: no equilibrium within 1 Newton iteration"));
  CHECK_THAT(text, Contains("recommended: standard: E "));
  // What has a warning is not recommended.
  std::vector<Record> warned = run(kBar, "standard divided").records;
  for (Record& record : warned) {
    compare_with_material(record);
    record.run.warnings = {"mechanism: 12 zero-energy modes; the load is solved (somehow)"};
  }
  CHECK_THAT(comparison_text(warned, false),
             Contains("  mechanism: 12 zero-energy modes\n") && Contains("no recommendation") && !Contains("somehow") &&
                 Contains("    standard comes to E +1.12 %, with a warning: mechanism: 12 zero-energy modes\n"));
  CHECK_THAT(run_text(warned.front(), false),
             Contains("warning: mechanism: 12 zero-energy modes; the load is solved (somehow)\n"));
  warned.front().run.warnings.clear();
  CHECK_THAT(comparison_text(warned, false), !Contains("with a warning"));
  // Where nothing is near, what is nearer with a warning is stated as well.
  warned.front().run.warnings = {"mechanism"};
  for (Record& record : warned)
    for (auto& [name, error] : record.errors) error *= 50;
  REQUIRE(warned.back().run.warnings.size() == 1);
  warned.back().run.warnings.clear();
  CHECK_THAT(comparison_text(warned, false),
             Contains("no strategy without a warning is near E; the nearest is divided: ") &&
                 Contains("    standard comes to E +56.18 %, with a warning: mechanism"));
}

TEST_CASE("an expectation can fail", "[files]") {
  const auto good = [](const std::vector<std::string>& overrides, const std::string& strategy) {
    return run(kBar, strategy, overrides).records.front().good();
  };
  const std::string right = "expect=[{measure: elongation, value: 0.00066667, tolerance: 0.1 %, source: me}]";
  CHECK(good({right}, "standard"));
  CHECK_FALSE(good({right}, "uniform"));
  CHECK(good({right}, "van_gelder"));  // it cannot run, and nothing is expected of it by name
  CHECK_FALSE(good({"expect=[{strategy: van_gelder, measure: elongation, value: 1, tolerance: 1 %, source: me}]"},
                   "van_gelder"));
  CHECK(good({"expect=[{measure: elongation, value: 1, not_reproduced: why, source: me}]"}, "standard"));
  // A measure that the run does not have is not as expected.
  CHECK_FALSE(good({"expect=[{measure: poissons_ratio, value: 0, absolute: 9, source: me}]"}, "standard"));
}

TEST_CASE("values are printed with a prefix that keeps them readable", "[files]") {
  using namespace dimension;
  CHECK(readable(4994.5, pressure) == "4.9945 kPa");
  CHECK(readable(0.0033333333, length) == "3.3333 mm");
  CHECK(readable(-8.1351e-5, length) == "-81.351 µm");
  CHECK(readable(9999.999, pressure) == "10.000 kPa");
  CHECK(readable(9.999999999, pressure, 6) == "10.0000 Pa");
  CHECK(readable(0.9999999, force) == "1.0000 N");
  CHECK(readable(999.999999, pressure) == "1.0000 kPa");
  CHECK(readable(5e12, pressure) == "5000.00 GPa");
  CHECK(readable(0, length) == "0 m");
  CHECK(readable(1e-15, energy) == "1e-15 J");
  CHECK(readable(9e-4, area) == "900 mm^2");
  CHECK(readable(0.25, area) == "0.25 m^2");
  CHECK(readable(2.5e-11, area) == "25 µm^2");
  CHECK(readable(0, area) == "0 m^2");
  CHECK(readable(0.011322, dimension::time) == "11.322 ms");
  CHECK(readable(1200, dimension::time) == "1200 s");
  CHECK(readable(0.25, none) == "0.2500");
  CHECK(readable(-1e-17, none) == "0.0000");
  CHECK(readable(std::nan(""), pressure).empty());
  CHECK(percent(0.0008) == "+0.080 %");
  CHECK(percent(-0.00005) == "-0.0050 %");
  CHECK(percent(-0.4188) == "-41.88 %");
  CHECK(percent(2.59) == "+259 %");
  CHECK(percent(0) == "0.0000 %");
  CHECK(percent(-1e-9) == "0.0000 %");
  CHECK(percent(1e20) == "+1.0e+22 %");
  CHECK(percent(INFINITY).empty());
  CHECK(readable_seconds(2.5e-6) == "2 µs");
  CHECK(readable_seconds(1.25e-3) == "1.2 ms");
  CHECK(readable_seconds(1.5) == "1.50 s");
  CHECK(counted(1, "connection") == "1 connection");
  CHECK(counted(0, "connection") == "0 connections");
  CHECK(counted(2, "spring is", "springs are") == "2 springs are");
}
