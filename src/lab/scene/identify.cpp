#include "lab/scene/identify.h"

#include <cctype>
#include <filesystem>

#include "lab/scene/parts.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

LaterQuantity later(const std::optional<Reader>& reader) {
  if (!reader) return {};
  return [reader = *reader](const Dimension& unit) { return reader.quantity(unit); };
}

/// Whether a value, or one below it, is a number with its unit.
bool has_units(const Reader& reader) {
  if (reader.is_map()) {
    for (const auto& [key, value] : reader.entries())
      if (key != "title" && has_units(value)) return true;
    return false;
  }
  if (!reader.is_text()) {
    for (const Reader& item : reader.items())
      if (has_units(item)) return true;
    return false;
  }
  const std::string text = reader.text();
  const auto starts = [](unsigned char c) { return std::isdigit(c) || c == '-' || c == '+' || c == '.'; };
  return !text.empty() && starts(text.front()) && std::isalpha(static_cast<unsigned char>(text.back()));
}

std::function<void(const std::string&)> failure_at(const Reader& reader) {
  return [reader](const std::string& message) { reader.fail(message); };
}

std::vector<std::pair<std::string, std::string>> read_texts(const std::optional<Reader>& reader) {
  std::vector<std::pair<std::string, std::string>> texts;
  if (!reader) return texts;
  for (const auto& [key, value] : reader->entries()) texts.emplace_back(key, value.text());
  return texts;
}

std::string beside(const Reader& reader) {
  return (std::filesystem::path(reader.file_path()).parent_path() / reader.text()).lexically_normal().string();
}

std::vector<std::pair<std::string, HomogeneousTest>> homogeneous_names() {
  std::vector<std::pair<std::string, HomogeneousTest>> names;
  for (const HomogeneousTest test : kHomogeneousTests) names.emplace_back(name_of(test), test);
  return names;
}

bool read_residuals(const Reader& reader) { return reader.choice<bool>({{"relative", true}, {"absolute", false}}); }

DataTest read_test(Reader reader, bool relative) {
  DataTest test;
  test.fail = failure_at(reader);
  std::vector<std::pair<std::string, const DataTestKind*>> kinds;
  for (const DataTestKind& kind : data_test_kinds()) kinds.emplace_back(kind.name, &kind);
  test.kind = reader.at("kind").choice<const DataTestKind*>(kinds);
  const auto name = reader.find("name");
  test.name = name ? name->text() : test.kind->name;
  test.file = beside(reader.at("file"));
  test.rows = read_texts(reader.find("rows"));
  test.columns = read_texts(reader.find("columns"));
  test.from = later(reader.find("from"));
  test.to = later(reader.find("to"));
  if (auto weight = reader.find("weight")) test.weight = weight->quantity(dimension::none, kNotNegative);
  const auto residuals = reader.find("residuals");
  test.relative = residuals ? read_residuals(*residuals) : relative;
  if (auto area = reader.find("cross_section")) test.cross_section = area->quantity(dimension::area, kPositive);
  if (auto length = reader.find("length")) test.length = length->quantity(dimension::length, kPositive);
  if (const auto scene = test.kind->homogeneous ? std::nullopt : reader.find("scene"))
    test.scene = reader.source().other(beside(*scene));
  if (test.kind->in_time && test.scene) {
    if (auto ramp = reader.find("ramp")) test.ramp = ramp->quantity(dimension::time, kNotNegative);
  } else if (test.kind->in_time) {
    if (auto held = reader.find("held")) test.held = held->choice<HomogeneousTest>(homogeneous_names());
    test.strain = reader.at("strain").quantity(dimension::none);
    if (auto ramp = reader.find("ramp")) test.ramp = ramp->quantity(dimension::time, kNotNegative);
  } else if (!test.kind->homogeneous) {
    if (!test.scene) test.scene = reader.source();
  }
  reader.finish();
  return test;
}

std::vector<UnknownChoice> read_unknowns(const Reader& reader) {
  std::vector<UnknownChoice> unknowns;
  if (!reader.is_map()) {
    for (const Reader& item : reader.items()) unknowns.push_back({item.text(), {}, {}, {}, failure_at(item)});
    return unknowns;
  }
  for (auto& [name, value] : reader.entries()) {
    value.set_section("identify.unknowns");
    UnknownChoice unknown{name, {}, {}, {}, failure_at(value)};
    if (!value.is_map()) value.fail("write {low: …, high: …, start: …}, or {} for all values that the law admits");
    unknown.low = later(value.find("low")), unknown.high = later(value.find("high"));
    unknown.start = later(value.find("start"));
    value.finish();
    unknowns.push_back(std::move(unknown));
  }
  return unknowns;
}

void read_published(Reader reader, IdentifyTask& task) {
  task.published_source = reader.at("source").text();
  for (auto& [name, value] : reader.entries())
    if (name != "source") task.published.push_back({name, later(value), failure_at(value)});
  if (task.published.empty()) reader.fail("names no number; write for example {source: …, mu_1: 1.4 kPa}");
}

void read_identify(Reader reader, IdentifyTask& task) {
  const auto residuals = reader.find("residuals");
  const bool relative = !residuals || read_residuals(*residuals);
  for (const Reader& item : reader.at("tests").items()) {
    DataTest test = read_test(item, relative);
    for (const DataTest& other : task.tests)
      if (other.name == test.name) item.fail("there is a test '" + test.name + "' already; give this one a name");
    task.tests.push_back(std::move(test));
  }
  if (task.tests.empty()) reader.at("tests").fail("names no test");
  if (auto unknowns = reader.find("unknowns")) task.unknowns = read_unknowns(*unknowns);
  if (auto fixed = reader.find("fixed"))
    for (const Reader& item : fixed->items()) task.fixed.push_back(item.text());
  if (auto published = reader.find("published")) read_published(*published, task);
  if (auto starts = reader.find("starts")) task.starts = starts->whole(1, 1000);
  if (auto laws = reader.find("laws")) {
    if (laws->is_text())
      task.laws = {laws->choice<std::string>({{"all", "all"}})};
    else
      for (const Reader& item : laws->items()) task.laws.push_back(item.text());
  }
  reader.finish();
}

}  // namespace

const std::vector<DataQuantity>& data_quantities() {
  static const std::vector<DataQuantity> quantities{
      {"stretch", dimension::none, "length over length at rest", true},
      {"nominal_strain", dimension::none, "elongation over length at rest", true, {"strain"}},
      {"true_strain", dimension::none, "logarithm of the stretch", true},
      {"shear", dimension::none, "amount of simple shear", true, {"strain"}},
      {"displacement", dimension::length, "of what pulls or presses", false, {"elongation", "depth", "tip_deflection"}},
      {"angle", dimension::none, "of torsion", false, {"angle"}},
      {"time", dimension::time, "since the strain began to grow", false},
      {"nominal_stress", dimension::pressure, "force over section at rest", false, {"stress"}},
      {"true_stress", dimension::pressure, "force over present section", false},
      {"force", dimension::force, "of what pulls or presses", false, {"force"}},
      {"torque", dimension::energy, "of torsion", false, {"torque"}},
      {"pressure", dimension::pressure, "of a gas or liquid", false, {"pressure"}},
      {"height", dimension::length, "of a bubble's pole", false, {"height"}}};
  return quantities;
}

const std::vector<DataTestKind>& data_test_kinds() {
  static const std::vector<DataTestKind> kinds = [] {
    const std::vector<std::string> strains{"stretch", "nominal_strain", "true_strain", "displacement"};
    const std::vector<std::string> stresses{"nominal_stress", "true_stress", "force"};
    std::vector<DataTestKind> all;
    for (const HomogeneousTest test : kHomogeneousTests) {
      const bool shear = test == HomogeneousTest::shear;
      all.push_back({name_of(test), "every point in the same state",
                     shear ? std::vector<std::string>{"shear", "displacement"} : strains,
                     shear ? std::vector<std::string>{"nominal_stress", "force"} : stresses, test});
    }
    all.push_back(
        {"relaxation", "stress over time at a strain that is kept", {"time"}, {"nominal_stress", "force"}, {}, true});
    all.push_back({"specimen",
                   "the whole specimen in its grips, of a scene",
                   {"displacement", "angle", "pressure", "force", "nominal_strain", "shear"},
                   {"force", "torque", "height", "displacement", "nominal_stress", "pressure"}});
    return all;
  }();
  return kinds;
}

IdentifyTask load_identify_task(const SceneSource& source, const Catalog& catalog,
                                const std::vector<std::string>& overrides, KeyUses* uses) {
  Reader reader = open_scene(source, overrides, kMostMolecules, uses);
  read_preamble(reader);
  IdentifyTask task;
  task.source = source;
  task.name = std::filesystem::path(source.path()).stem().string();
  const auto title = reader.find("title");
  task.title = title ? title->text() : task.name;
  const bool has_body = reader.has("body") || reader.has("bodies");
  Reader material = reader.at("material");
  task.material = read_material(material, catalog.material_laws);
  if (!task.material.law) task.curve = read_curve_numbers(material);
  task.kept = read_kept(material, std::filesystem::path(source.path()).parent_path().string());
  read_identify(reader.at("identify"), task);
  task.plain = reader.plain() || (has_body && !has_units(reader));
  for (const DataTest& test : task.tests)
    if (!has_body && test.scene == source)
      test.fail(
          "a specimen needs its body, stiffness and experiment: state them in this scene, or name one by `scene`");
  if (has_body)  // the rest is the specimen's
    load_scene(source, catalog, overrides);
  else
    reader.finish();
  return task;
}

void check_identify(const Reader& reader) {
  IdentifyTask unused;
  read_identify(reader, unused);
}

std::vector<KeySection> identify_keys() {
  std::vector<std::string> kinds, tests, quantities;
  for (const DataTestKind& kind : data_test_kinds()) kinds.push_back(kind.name);
  for (const HomogeneousTest test : kHomogeneousTests) tests.push_back(name_of(test));
  for (const DataQuantity& quantity : data_quantities()) quantities.push_back(quantity.name);
  const std::string unknowns = "identify.unknowns";
  return {
      {"identify",
       "Identification",
       "The section `identify` says which measured tests `elastin identify` fits the material to. A scene of "
       "homogeneous tests alone needs no body, stiffness and experiment.",
       {{"tests", "list of maps", "", "", "needed", "the tests, below"},
        {"unknowns", "list, or map", "", "", "all numbers of the law but `bulk_modulus`; of E and ν, E",
         "names of the numbers that are to be found, or a map with their bounds, below: of a law, a term (`mu_1`), a "
         "curve "
         "(`stress_1`, `c_0` …) or relaxation (`g_1`, `tau_1`), of a spring rule its parameters, of contact "
         "`friction`"},
        {"fixed", "list", "", "", "none", "names of numbers that stay as the material states them"},
        {"published", "map", "", "", "none",
         "numbers of the material that others found, by name, and the `source`: shown beside those found"},
        {"published.source", "text", "", "", "needed in `published`", "who found them"},
        {"residuals", "`relative`, `absolute`", "", "", "`relative`",
         "difference over each measured value, or over the largest one of the test"},
        {"starts", "whole", "", "1 … 1000", "8",
         "searches from the material's own numbers and from others around them"},
        {"laws", "list, or `all`", "", "", "the material's",
         "laws that are compared; `yeoh/2` is yeoh with two terms"}}},
      {unknowns,
       "",
       "Each of `unknowns` may have:",
       {{"low", "quantity", "its own", "", "the law's", "least value"},
        {"high", "quantity", "its own", "", "the law's", "largest value"},
        {"start", "quantity", "its own", "", "the material's", "where the search begins"}}},
      {"identify.tests",
       "",
       "Each of `tests` is a CSV file with two columns, whose heads say what they hold with its unit, such as `force "
       "[N]`, of " +
           words_text(quantities) + ":",
       {{"kind", words_text(kinds), "", "", "needed", "which test it is"},
        {"name", "text", "", "", "its kind", "how tables call it"},
        {"file", "text", "", "", "needed", "the CSV file, relative to the scene"},
        {"rows", "map", "", "", "all", "only the rows with this text in this column: `{region: cortex}`"},
        {"columns", "map", "", "", "none", "what a head of the file means: `{Load: force [N]}`"},
        {"from", "quantity", "the column's", "", "none", "least of what is prescribed that counts"},
        {"to", "quantity", "the column's", "", "none", "largest of what is prescribed that counts"},
        {"weight", "number", "", "≥ 0", "1", "of its squares; 0: predicted and not fitted"},
        {"residuals", "`relative`, `absolute`", "", "", "as above", "of this test"},
        {"cross_section", "quantity", "m^2", "> 0", "needed with `force`", "of a homogeneous test"},
        {"length", "quantity", "m", "> 0", "needed with `displacement`", "of a homogeneous test"},
        {"scene", "text", "", "", "this scene",
         "of `specimen`: body, grips and load; the material is the fitted one. Of `relaxation`: the specimen whose "
         "load is kept, in the place of "
         "`held` and `strain`"},
        {"held", words_text(tests), "", "", "`uniaxial`", "of `relaxation`: the state that is kept"},
        {"strain", "number", "", "", "needed for `relaxation` without `scene`", "of `relaxation`: that is kept"},
        {"ramp", "quantity", "s", "≥ 0", "0", "of `relaxation`: time in which the strain grows"}}}};
}

}  // namespace elastin::lab
