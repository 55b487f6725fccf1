#include "lab/scene/identify.h"

#include <cctype>
#include <filesystem>

#include "lab/scene/parts.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

/// A quantity whose unit is known when the data are read.
template <class Setup>
Key<Setup> later_key(const std::string& name, LaterQuantity Setup::*member, const std::string& unit,
                     const std::string& fallback, const std::string& text) {
  return {{name, "quantity", unit, "", fallback, text}, [member](const Reader& value, Setup& setup) {
            setup.*member = [value](const Dimension& dimension) { return value.quantity(dimension); };
          }};
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

template <class Setup>
Key<Setup> texts_by_name_key(const std::string& name, std::vector<std::pair<std::string, std::string>> Setup::*member,
                             const std::string& fallback, const std::string& text) {
  return {{name, "map", "", "", fallback, text}, [member](const Reader& value, Setup& setup) {
            for (const auto& [key, entry] : value.entries()) (setup.*member).emplace_back(key, entry.text());
          }};
}

std::vector<std::pair<std::string, HomogeneousTest>> homogeneous_names() {
  std::vector<std::pair<std::string, HomogeneousTest>> names;
  for (const HomogeneousTest test : kHomogeneousTests) names.emplace_back(name_of(test), test);
  return names;
}

template <class Setup>
Key<Setup> residuals_key(ResidualScale Setup::*member, const std::string& text) {
  using enum ResidualScale;
  return key::choice("residuals", member, {{"automatic", automatic}, {"relative", relative}, {"absolute", absolute}},
                     text);
}

Key<ModulusWindow> bound_key(const std::string& name, WindowBound ModulusWindow::*member, bool of_chord,
                             const std::string& text) {
  return Key<ModulusWindow>({name, "number, or quantity", "Pa", "", "", text},
                            [member](const Reader& value, ModulusWindow& window) {
                              const std::string given = value.text();
                              const bool is_stress = given.ends_with("Pa");
                              window.*member = {
                                  value.quantity(is_stress ? dimension::pressure : dimension::none, kNotNegative),
                                  is_stress};
                            })
      .needed_when(
          [of_chord](const ModulusWindow& window) { return (window.kind == ModulusWindow::Kind::chord) == of_chord; },
          of_chord ? "needed for `chord`" : "needed for `tangent` and `secant`");
}

const Keys<ModulusWindow>& modulus_keys() {
  using enum ModulusWindow::Kind;
  static const Keys<ModulusWindow> keys{
      key::choice("kind", &ModulusWindow::kind, {{"chord", chord}, {"tangent", tangent}, {"secant", secant}},
                  "stress over strain between two points, the slope at one, or stress over strain from rest to one")
          .needed(),
      bound_key("from", &ModulusWindow::from, true,
                "where the window begins: a strain (`5 %`) or a stress (`2 kPa`), without sign"),
      bound_key("to", &ModulusWindow::to, true, "where it ends"),
      bound_key("at", &ModulusWindow::at, false, "the point")};
  return keys;
}

void read_indenter(Reader reader, DataTest& test) {
  struct Form {
    const char *name, *size;
    Indenter indenter;
    Dimension unit;
    Range range;
  };
  const Form forms[] = {{"sphere", "radius", Indenter::sphere, dimension::length, kPositive},
                        {"cone", "half_angle", Indenter::cone, dimension::none, {0.01, 1.57}},
                        {"flat", "radius", Indenter::flat, dimension::length, kPositive}};
  for (const auto& [name, size, indenter, unit, range] : forms)
    if (reader.has(name)) {
      test.indenter = indenter;
      Reader own = reader.at(name);
      test.indenter_size = own.at(size).quantity(unit, range);
      return own.finish(), reader.finish();
    }
  reader.fail("write {sphere: {radius: 10 um}}, {cone: {half_angle: 35 deg}} or {flat: {radius: 1 mm}}");
}

const Keys<DataTest>& data_test_keys() {
  using S = DataTest;
  const auto is_relaxation = [](const S& test) { return test.kind->in_time && !test.kind->oscillates; };
  const auto of_pressing = [](const S& test) { return test.kind->layer && !test.kind->in_time; };
  const auto of_depth = [](const S& test) { return test.kind->in_time && test.kind->layer; };
  const auto curved = [](const S& test) { return !test.kind->in_time && !test.kind->points; };
  const auto a_curve = [](const S& test) { return !test.kind->points; };
  const auto of_layer = [](const S& test) { return test.kind->layer; };
  const auto with_zero = [](const S& test) { return !test.kind->in_time && !test.kind->points && !test.kind->layer; };
  const auto of_points = [](const S& test) { return test.kind->points; };
  const auto of_strain = [=](const S& test) { return is_relaxation(test) && !test.scene && !test.kind->layer; };
  std::vector<std::pair<std::string, const DataTestKind*>> kinds;
  for (const DataTestKind& kind : data_test_kinds()) kinds.emplace_back(kind.name, &kind);
  static const Keys<S> keys{
      key::choice("kind", &S::kind, kinds, "which test it is").needed(),
      key::text("name", &S::name, "how tables call it").otherwise("its kind"),
      Key<S>({"file", "text", "", "", "", "the CSV file, relative to the scene"},
             [](const Reader& value, S& test) { test.file = path_next_to(value); })
          .needed(),
      texts_by_name_key("rows", &S::rows, "all", "only the rows with this text in this column: `{region: cortex}`"),
      texts_by_name_key("columns", &S::columns, "as recognised",
                        "what a column means, by its name or its number: `{Load: 'force [N]'}`"),
      key::choice("decimal", &S::decimal, {{"point", '.'}, {"comma", ','}}, "mark of decimals in the file")
          .otherwise("as recognised"),
      key::whole("block", &S::block, 1,
                 "which of several blocks of the file, each with names of its own or of rows that begin again, counts")
          .otherwise("the only one with the columns"),
      later_key("from", &S::from, "the column's", "none",
                "least of what is prescribed that counts, as the file has it; no other row is looked at")
          .when(a_curve),
      later_key("to", &S::to, "the column's", "none", "largest of it").when(a_curve),
      key::choice("frame", &S::fixed_frame, {{"moving", false}, {"fixed", true}},
                  "of points: whether the specimen as a whole may have moved and turned before what sees it, at each "
                  "load; six unknowns more")
          .when(of_points),
      key::choice("signs", &S::pressing, {{"pulling", false}, {"pressing", true}}, "what the columns count positive")
          .when([=](const S& test) { return curved(test) || (is_relaxation(test) && !test.kind->layer); })
          .otherwise(
              "`pulling`; of `compression`, of `indentation` and of a strain below 0 that is kept either, by each "
              "column's own sign"),
      key::choice("branch", &S::branch, {{"loading", BranchChoice::loading}, {"unloading", BranchChoice::unloading}},
                  "which rows of a curve that goes to and fro count; those in which the strain is held, in neither")
          .when(curved)
          .otherwise("all, of a curve that does not"),
      key::whole("cycle", &S::cycle, -1000, 1000, "which of several such branches: 1 is the first, -1 the last")
          .when(curved)
          .otherwise("1"),
      key::choice(
          "torn", &S::keep_torn, {{"left_out", false}, {"keep", true}},
          "rows behind a tear or slip: a fall of the reading by a fifth within three rows, or by half of the largest")
          .when(curved),
      key::choice("zero", &S::zero,
                  {{"as_given", ZeroChoice::as_given},
                   {"first", ZeroChoice::first},
                   {"found", ZeroChoice::found},
                   {"toe", ZeroChoice::toe}},
                  "where what is prescribed counts from: as the file has it; `first`: the first row, where the "
                  "specimen has its `length`, as of a crosshead's position; `found`: where the load begins, behind "
                  "slack or before a preload; `toe`: where the tangent of the steepest fifth of the range crosses "
                  "zero. Of `found` and `toe` `length` and strains are then over the length there")
          .when(with_zero)
          .otherwise("`as_given`; `found` where it begins behind slack that no smooth curve explains"),
      key::whole("points", &S::points, 2, "more rows than these are averaged in groups")
          .when(curved)
          .otherwise("500; of `specimen` 50"),
      key::list({"moduli", "list of maps", "", "", "none", "moduli by windows of the measured curve, below"},
                &S::moduli,
                [](Reader item) { return item.set_section("identify.tests.moduli"), modulus_keys().read(item); })
          .when([](const S& test) { return test.kind->homogeneous.has_value(); }),
      key::quantity("weight", &S::weight, dimension::none, "of its squares; 0: predicted and not fitted", kNotNegative),
      later_key("sigma", &S::deviation, "the response's", "none",
                "standard deviation of each reading of a body in a scene, where the file has no such column")
          .when([](const S& test) { return test.kind->of_scene(); }),
      residuals_key(&S::residuals, "of this test").when(a_curve).otherwise("as above"),
      key::quantity("cross_section", &S::cross_section, dimension::area, "of a homogeneous test", kPositive)
          .otherwise("needed with `force`"),
      key::quantity("length", &S::length, dimension::length, "of a homogeneous test", kPositive)
          .otherwise("needed with `displacement`"),
      Key<S>(
          {"scene", "text", "", "", "this scene",
           "of `specimen`: body, grips and load; the material is the fitted one. Of `relaxation`: the specimen whose "
           "load is kept, in the place of `held` and `strain`"},
          [](const Reader& value, S& test) { test.scene = value.source().other(path_next_to(value)); })
          .when([](const S& test) { return !test.kind->homogeneous && !test.kind->layer && !test.kind->oscillates; }),
      Key<S>(
          {"indenter", "map", "", "", "needed",
           "of `indentation`: `{sphere: {radius: 10 um}}`, `{cone: {half_angle: 35 deg}}` or `{flat: {radius: 1 mm}}`"},
          [](const Reader& value, S& test) { read_indenter(value, test); })
          .needed_when(of_layer, "needed for `indentation`"),
      key::quantity("thickness", &S::thickness, dimension::length, "of the layer", kPositive)
          .when(of_layer)
          .otherwise("a half-space"),
      key::choice("bottom", &S::bottom, {{"bonded", LayerBottom::bonded}, {"free", LayerBottom::free}},
                  "whether the layer sticks to its bed, or slides on it")
          .when(of_layer),
      key::quantity(
          "adhesion", &S::adhesion, dimension::stiffness,
          "work of adhesion of a sphere on a half-space, with which the search for `NAME_adhesion` begins, by "
          "Johnson, Kendall and Roberts; of `branch: unloading` down to where it snaps off",
          kPositive)
          .when(of_pressing)
          .otherwise("none"),
      key::choice("contact_point", &S::contact_given, {{"found", false}, {"as_given", true}},
                  "where the indenter touches: an unknown, `NAME_contact_point`, or depth 0 of the file")
          .when(of_pressing),
      key::text("measure", &S::measure,
                "of `specimen`: which of the scene's measures the response is, such as `arm_reaction_x`")
          .when([](const S& test) { return test.kind->of_scene() && !test.kind->points; })
          .otherwise("the first one of this quantity"),
      key::choice("held", &S::held, homogeneous_names(),
                  "of `relaxation`: the state that is kept; of a modulus over the frequency: in which it oscillates")
          .when([](const S& test) { return test.kind->in_time && !test.kind->layer && !test.scene; }),
      key::quantity("strain", &S::strain, dimension::none, "of `relaxation`: that is kept")
          .needed_when(of_strain, "needed for `relaxation` without `scene`"),
      key::quantity("ramp", &S::ramp, dimension::time, "of `relaxation`: time in which the strain grows, or the depth",
                    kNotNegative)
          .when(is_relaxation),
      key::quantity("begins", &S::begins, dimension::time,
                    "of `relaxation`: time on the file's clock at which the strain begins to grow, or the depth")
          .when(is_relaxation)
          .otherwise("0; behind readings without a load the last of these"),
      key::quantity("depth", &S::depth, dimension::length,
                    "of `indentation_relaxation`: that is reached after the ramp and kept", kPositive)
          .needed_when(of_depth, "needed for `indentation_relaxation`"),
      key::quantity("hold", &S::hold, dimension::time, "how long it is kept", kNotNegative)
          .when(of_depth)
          .otherwise("to the end"),
      key::quantity("back", &S::back, dimension::time, "time in which the indenter is then drawn back", kPositive)
          .when(of_depth)
          .otherwise("that of the ramp")};
  return keys;
}

DataTest read_test(const Reader& reader, ResidualScale residuals) {
  DataTest test;
  test.residuals = residuals;
  test = data_test_keys().read(reader, {}, std::move(test));
  test.fail = failure_at(reader);
  if (test.name.empty()) test.name = test.kind->name;
  if (test.kind->points) test.residuals = ResidualScale::absolute;
  if (test.kind->of_scene() && !test.scene) test.scene = reader.source();
  if (test.kind->layer) test.zero = ZeroChoice::as_given;
  if (test.kind->layer && test.kind->in_time && !(test.ramp > 0))
    test.fail("ramp: an indenter takes time to its depth");
  return test;
}

Keys<UnknownChoice> unknown_keys() {
  return {later_key("low", &UnknownChoice::low, "its own", "the law's", "least value"),
          later_key("high", &UnknownChoice::high, "its own", "the law's", "largest value"),
          later_key("start", &UnknownChoice::start, "its own", "the material's", "where the search begins")};
}

std::vector<UnknownChoice> read_unknowns(const Reader& reader) {
  std::vector<UnknownChoice> unknowns;
  if (!reader.is_map()) {
    for (const Reader& item : reader.items()) unknowns.push_back({item.text(), {}, {}, {}, failure_at(item)});
    return unknowns;
  }
  for (auto& [name, value] : reader.entries()) {
    value.set_section("identify.unknowns");
    if (!value.is_map()) value.fail("write {low: …, high: …, start: …}, or {} for all values that the law admits");
    unknowns.push_back(unknown_keys().read(value, {}, {name, {}, {}, {}, failure_at(value)}));
  }
  return unknowns;
}

const Keys<FieldChoice>& field_keys_of_identify() {
  using S = FieldChoice;
  static const Keys<S> keys{
      key::quantity("smoothness", &S::smoothness, dimension::none,
                    "weight α of ∫ |∇ ln E|² dV / V^(1/3) in addition to Σ (difference / sigma)²", kPositive)
          .otherwise("the largest at which the differences are no more than sigma; without sigma that of the "
                     "least generalised cross-validation"),
      key::quantity("low", &S::low, dimension::none, "least factor of the material's stiffness", {1e-12, 1, false}),
      key::quantity("high", &S::high, dimension::none, "largest factor", {1, 1e12, false})};
  return keys;
}

struct IdentifySetup : IdentifyTask {
  ResidualScale residuals = ResidualScale::automatic;  ///< of tests that do not state it
};

void read_published(Reader reader, IdentifySetup& task) {
  task.published_source = reader.at("source").text();
  for (const auto& [name, value] : reader.entries())
    if (name != "source")
      task.published.push_back(
          {name, [value = value](const Dimension& unit) { return value.quantity(unit); }, failure_at(value)});
  if (task.published.empty()) reader.fail("names no number; write for example {source: …, mu_1: 1.4 kPa}");
}

void read_tests(const Reader& reader, IdentifySetup& task) {
  for (const Reader& item : reader.items()) {
    DataTest test = read_test(item, task.residuals);
    for (const DataTest& other : task.tests)
      if (other.name == test.name) item.fail("there is a test '" + test.name + "' already; give this one a name");
    task.tests.push_back(std::move(test));
  }
  if (task.tests.empty()) reader.fail("names no test");
}

const Keys<IdentifySetup>& identify_map_keys() {
  using S = IdentifySetup;
  static const Keys<S> keys{
      residuals_key(
          &S::residuals,
          "differences are over each measured value (`relative`), over the largest one of the test (`absolute`), or "
          "over each value and 1 % of the largest, or a hundred times the noise of readings near zero, together "
          "(`automatic`); of 8 readings or more over as much more of the largest as their scatter shows"),
      Key<S>({"tests", "list of maps", "", "", "", "the tests, below"}, read_tests).needed(),
      Key<S>(
          {"unknowns", "list, or map", "", "", "all numbers of the law but `bulk_modulus`; of E and ν, E",
           "names of the numbers that are to be found, or a map with their bounds, below: of a law, a term (`mu_1`), "
           "a curve (`stress_1`, `c_0` …) or relaxation (`g_1`, `tau_1`), of a spring rule its parameters, of contact "
           "`friction`"},
          [](const Reader& value, S& task) { task.unknowns = read_unknowns(value); }),
      key::texts("fixed", &S::fixed, "names of numbers that stay as the material states them"),
      Key<S>({"field", "map", "", "", "none",
              "in the place of numbers: how many times as stiff as the material each cell is, below; `{}` for all as "
              "it is without a word"},
             [](const Reader& value, S& task) {
               Reader own = value;
               own.set_section("identify.field");
               task.field = field_keys_of_identify().read(own);
               task.field->fail = failure_at(value);
             }),
      Key<S>("published",
             {{"published", "map", "", "", "none",
               "numbers of the material that others found, by name, and the `source`: shown next to those found"},
              {"published.source", "text", "", "", "needed in `published`", "who found them"}},
             read_published),
      key::whole("starts", &S::starts, 1, 1000, "searches from the material's own numbers and from others around them")
          .otherwise("8"),
      Key<S>({"laws", "list, or `all`", "", "", "the material's",
              "laws that are compared; `yeoh/2` is yeoh with two terms"},
             [](const Reader& value, S& task) {
               if (value.is_text())
                 task.laws = {value.choice<std::string>({{"all", "all"}})};
               else
                 for (const Reader& item : value.items()) task.laws.push_back(item.text());
             })};
  return keys;
}

void read_identify(const Reader& reader, IdentifyTask& task) {
  task = identify_map_keys().read(reader, {}, IdentifySetup{std::move(task)});
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
      {"height", dimension::length, "of a bubble's pole", false, {"height"}},
      {"frequency", Dimension{0, 0, -1}, "of an oscillation, in Hz or rad/s", false},
      {"storage_modulus", dimension::pressure, "E′ or G′, stress in phase over strain", false},
      {"loss_modulus", dimension::pressure, "E″ or G″, stress a quarter of a period ahead over strain", false},
      {"loss_tangent", dimension::none, "loss modulus over storage modulus", true},
      {"load_factor", dimension::none, "part of the scene's load, 0 to 1", true}};
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
    all.insert(all.begin() + 1,
               {"compression", "uniaxial, pressed", strains, stresses, HomogeneousTest::uniaxial, false, true});
    all.push_back(
        {"relaxation", "stress over time at a strain that is kept", {"time"}, {"nominal_stress", "force"}, {}, true});
    for (const char* name : {"storage_modulus", "loss_modulus", "loss_tangent"})
      all.push_back({name, "of a small oscillation, over its frequency", {"frequency"}, {name}, {}, true, false, true});
    all.push_back({"specimen",
                   "the whole specimen in its grips, of a scene",
                   {"displacement", "angle", "pressure", "force", "nominal_strain", "shear", "load_factor"},
                   {"force", "torque", "height", "displacement", "nominal_stress", "pressure"}});
    all.push_back({"points",
                   "displacements of points of the whole specimen, as a camera or a scan sees them",
                   {"load_factor", "displacement", "angle", "pressure", "force", "nominal_strain", "shear"},
                   {"displacement"}});
    all.back().points = true;
    all.push_back({"indentation",
                   "depth and force of a rigid indenter in a flat layer, in small strains, without friction",
                   {"displacement"},
                   {"force"}});
    all.back().layer = true;
    all.push_back({"indentation_relaxation",
                   "force over time of such an indenter that goes to a depth, stays and is drawn back",
                   {"time"},
                   {"force"},
                   {},
                   true});
    all.back().layer = true;
    return all;
  }();
  return kinds;
}

IdentifyTask load_identify_task(const SceneSource& source, const Catalog& catalog,
                                const std::vector<std::string>& overrides) {
  Reader reader = open_scene(source, overrides, kMostMolecules);
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
  std::vector<std::string> quantities;
  for (const DataQuantity& quantity : data_quantities()) quantities.push_back(quantity.name);
  return {
      {"identify", "Identification",
       "The section `identify` says which measured tests `elastin identify` fits the material to. A scene of "
       "homogeneous tests alone needs no body, stiffness and experiment.",
       identify_map_keys().rows()},
      {"identify.unknowns", "", "Each of `unknowns` may have:", unknown_keys().rows()},
      {"identify.field", "", "`field` may have:", field_keys_of_identify().rows()},
      {"identify.tests", "",
       "Each of `tests` is a file with two columns, whose names, or a row below them, state what they hold with its "
       "unit, such as `force [N]`, of " +
           words_text(quantities) + ":",
       data_test_keys().rows()},
      {"identify.tests.moduli", "", "Each of `moduli` has:", modulus_keys().rows()}};
}

}  // namespace elastin::lab
