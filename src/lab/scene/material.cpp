#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "elastin/core/base/text.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/forces/prony.h"
#include "lab/run/config_names.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// [[0, 0 Pa], [2 %, 1 kPa], …]
void read_points(const Reader& reader, CurveNumbers& stated) {
  std::vector<StressStrain::Point> points;
  const std::vector<Reader> items = reader.items();
  for (const Reader& item : items) {
    const auto pair = item.items(2);
    points.push_back({pair[0].quantity(dimension::none), pair[1].quantity(dimension::pressure)});
    stated.strains.push_back(points.back().strain);
    if (points.back().strain != 0)
      stated.numbers.push_back(
          {"stress_" + std::to_string(stated.numbers.size() + 1), dimension::pressure, points.back().stress});
  }
  if (const auto wrong = StressStrain::fault(points))
    (wrong->first < items.size() ? items[wrong->first] : reader).fail(wrong->second);
}

/// [[ε, E], …]
void read_secant_points(const Reader& reader, CurveNumbers& stated) {
  stated.form = CurveNumbers::Form::secant_table;
  for (const Reader& item : reader.items()) {
    const auto pair = item.items(2);
    stated.strains.push_back(pair[0].quantity(dimension::none, kNotNegative));
    stated.numbers.push_back({"modulus_" + std::to_string(stated.numbers.size() + 1), dimension::pressure,
                              pair[1].quantity(dimension::pressure, kPositive)});
  }
}

/// One of the numbers by which a form of curve is stated.
Key<CurveNumbers> number_key(CurveNumbers::Form form, const std::string& name, const Dimension& unit,
                             const std::string& needed, const std::string& text) {
  return Key<CurveNumbers>({name, unit == dimension::none ? "number" : "quantity", si_unit(unit), "> 0", "", text},
                           [=](const Reader& value, CurveNumbers& stated) {
                             stated.form = form;
                             stated.numbers.push_back({name, unit, value.quantity(unit, kPositive)});
                           })
      .needed(needed);
}

/// The strain of a form that has one.
Key<CurveNumbers> strain_key(SceneKey row, const Range& range) {
  row.type = "number", row.range = range_text(range.low, range.high, range.open_low);
  return {std::move(row), [=](const Reader& value, CurveNumbers& stated) {
            stated.strains = {value.quantity(dimension::none, range)};
          }};
}

const Forms<CurveNumbers>& curve_forms() {
  using C = CurveNumbers;
  using enum CurveNumbers::Form;
  static const Forms<C> forms{
      {Key<C>({"points", "list of pairs", "Pa", "", "none", "`[strain, stress]`, ascending, through the origin"},
              read_points)},
      {number_key(two_moduli, "tension", dimension::pressure, "none", "modulus in tension, of a curve with two moduli"),
       number_key(two_moduli, "compression", dimension::pressure, "needed with `tension`", "modulus in compression"),
       strain_key({.name = "smoothing", .fallback = "1e-4", .text = "strain over which these two are joined"},
                  {1e-9, 1, false})},
      {number_key(toe, "toe_strain", dimension::none, "none",
                  "end of the toe region, beyond which the curve is straight"),
       number_key(toe, "toe_modulus", dimension::pressure, "needed with `toe_strain`", "slope at strain 0"),
       number_key(toe, "modulus", dimension::pressure, "needed with `toe_strain`", "slope beyond the toe region")}};
  return forms;
}

CurveNumbers read_curve(Reader reader) {
  reader.set_section("material.curve");
  std::vector<std::string> names;
  for (const SceneKey& row : curve_forms().rows()) names.push_back(row.name);
  const auto is_known = [&](const std::string& key) {
    return std::find(names.begin(), names.end(), key) != names.end();
  };
  const std::vector<std::string> given = reader.is_map() ? reader.keys() : std::vector<std::string>{};
  if (std::none_of(given.begin(), given.end(), is_known))
    reader.fail(
        "write {points: [[strain, stress], ...]}, {toe_strain, toe_modulus, modulus} or {tension, compression}; "
        "the values of a file are copied into `points`");
  CurveNumbers stated = curve_forms().read(reader);
  if (stated.form == CurveNumbers::Form::two_moduli && stated.strains.empty()) stated.strains = {1e-4};
  return stated;
}

const Forms<CurveNumbers>& secant_forms() {
  using C = CurveNumbers;
  static const Forms<C> forms{
      {Key<C>({"polynomial", "list of quantities", "Pa", "", "", "c₀, c₁ … of c₀ + c₁ ε + …"},
              [](const Reader& value, C& stated) {
                stated.form = C::Form::secant_polynomial;
                for (const Reader& item : value.items())
                  stated.numbers.push_back({"c_" + std::to_string(stated.numbers.size()), dimension::pressure,
                                            item.quantity(dimension::pressure)});
              })
           .needed("this, or `points`"),
       strain_key({.name = "up_to", .text = "strain up to which the polynomial counts"}, kPositive)
           .needed("needed with `polynomial`")},
      {Key<C>({"points", "list of pairs", "Pa", "≥ 0, > 0", "", "`[strain, E]`"}, read_secant_points)
           .needed("this, or `polynomial`")}};
  return forms;
}

CurveNumbers read_secant_modulus(Reader reader) {
  if (!reader.is_map()) reader.fail("write {polynomial: [c0, c1, ...], up_to: strain} or {points: [[strain, E], ...]}");
  if (reader.has("polynomial") == reader.has("points")) reader.fail("give one of polynomial and points");
  const CurveNumbers stated = secant_forms().read(reader);
  const auto list = reader.find("polynomial");
  (list ? *list : reader.at("points")).located([&] { return stated.curve(); });
  return stated;
}

/// {direction: z, curve: …}
struct FibreSetup {
  Vector3 direction = Vector3::UnitZ();
  StressStrain curve;
  bool compression = true;
};

const Keys<FibreSetup>& fibre_keys() {
  using S = FibreSetup;
  static const Keys<S> keys{
      key::direction("direction", &S::direction, "direction of the fibres at rest").needed(),
      KeyGroup<S>{{Key<S>({"youngs_modulus", "quantity", "Pa", "> 0", "needed, or `curve`",
                           "modulus of the fibres; their stress adds to that of the matrix"},
                          [](const Reader& value, S& fibre) {
                            fibre.curve = StressStrain::linear(value.quantity(dimension::pressure, kPositive));
                          }),
                   Key<S>({"curve", "map", "", "", "none", "stress–strain curve of the fibres, as `curve` above"},
                          [](const Reader& value, S& fibre) { fibre.curve = read_curve(value).curve(); })},
                  "key 'youngs_modulus' is missing",
                  true,
                  ""},
      key::flag("compression", &S::compression, "whether the fibres resist compression")};
  return keys;
}

enum class RelaxationModel { prony, standard_linear_solid, kelvin_voigt };

struct RelaxationSetup {
  RelaxationModel model = RelaxationModel::prony;
  std::vector<Relaxation::Term> terms;
  double share = 0, time = 0;
  bool instantaneous = false;
};

/// {terms: [[0.5, 1 s], [0.2, 10 s]], moduli: long_term} | {model: kelvin_voigt, time: 1 s} | …
const Keys<RelaxationSetup>& relaxation_keys() {
  using S = RelaxationSetup;
  using enum RelaxationModel;
  const auto is = [](RelaxationModel a, RelaxationModel b) {
    return [=](const S& setup) { return setup.model == a || setup.model == b; };
  };
  static const Keys<S> keys{
      key::choice("model", &S::model,
                  {{"prony", prony}, {"standard_linear_solid", standard_linear_solid}, {"kelvin_voigt", kelvin_voigt}},
                  "terms of G, one term, or a dashpot in parallel with the law: σ + time dσ/dt"),
      key::list({"terms", "list of pairs", "s", "> 0", "none",
                 "`[share, time]`: G(t) = g₀ + Σ share e^(−t/time) times the law, for `prony:` strategies"},
                &S::terms,
                [](const Reader& item) {
                  const auto pair = item.items(2);
                  return Relaxation::Term{pair[0].quantity(dimension::none, kPositive),
                                          pair[1].quantity(dimension::time, kPositive)};
                })
          .needed_when(is(prony, prony), "needed of `prony`"),
      key::quantity("share", &S::share, dimension::none, "share of its one term", kPositive)
          .needed_when(is(standard_linear_solid, standard_linear_solid), "needed of `standard_linear_solid`"),
      key::quantity("time", &S::time, dimension::time,
                    "relaxation time of the one term, or retardation time of the dashpot", kPositive)
          .needed_when(is(standard_linear_solid, kelvin_voigt), "needed of these two"),
      key::choice("moduli", &S::instantaneous, {{"long_term", false}, {"instantaneous", true}},
                  "which moduli the law has: g₀ = 1, or 1 − Σ share; not of `kelvin_voigt`")
          .when(is(prony, standard_linear_solid))};
  return keys;
}

Relaxation relaxation_of(const Reader& reader, const RelaxationSetup& setup) {
  Relaxation relaxation{setup.terms, setup.instantaneous};
  if (setup.model == RelaxationModel::standard_linear_solid) relaxation.terms = {{setup.share, setup.time}};
  if (setup.model == RelaxationModel::kelvin_voigt) relaxation.retardation = setup.time;
  reader.located([&] { check_relaxation(relaxation); });
  return relaxation;
}

/// {r: 1.5, m: 0.1 MPa, beta: 0.1}
Keys<Softening> softening_keys() {
  using S = Softening;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {key::quantity("r", &S::r, dimension::none,
                        "η = 1 − (1/r) erf((W_max − W)/(m + beta W_max)) times the stress, for `mullins:` strategies",
                        {1, infinity, true})
              .needed(),
          key::quantity("m", &S::m, dimension::pressure, "energy density over which stress is lost; this or `beta`",
                        kNotNegative),
          key::quantity("beta", &S::beta, dimension::none, "the same over the largest energy density that there was",
                        kNotNegative)};
}

/// {direction: z, stress: 300 kPa, activation: {ramp: 1 s}, optimal_stretch: 1}
Keys<ActiveFibre> active_keys() {
  using S = ActiveFibre;
  return {key::direction("direction", &S::direction, "direction of active fibres (muscle) at rest").needed(),
          key::quantity("stress", &S::stress, dimension::pressure,
                        "largest stress of the fibres, over the present section", kPositive)
              .needed(),
          key::quantity("optimal_stretch", &S::optimal_stretch, dimension::none, "stretch at which they have it",
                        kPositive),
          Key<S>({"activation", "time function", "", "", "1", "which part is at work; below 0 counts as 0"},
                 [](const Reader& value, S& active) {
                   active.activation = [function = read_time_function(value)](double time) {
                     return function.value(time);
                   };
                 })};
}

/// "list of pairs": the terms of a law.
SceneKey key_of_terms(const MaterialLaw& law) {
  SceneKey key{"terms", "", "", "", "needed", ""};
  key.type = law.columns.size() == 1 ? "list of quantities" : "list of pairs";
  for (const ParameterInfo& column : law.columns) {
    const SceneKey own = key_of(column);
    key.unit += own.unit;
    key.range += own.range;
    key.text += (key.text.empty() ? "1 to " + std::to_string(law.most_terms) + " of them: " : "; ") + own.text;
  }
  return key;
}

/// {terms: [[0.63 MPa, 1.3], …], bulk_modulus: 1 GPa}
Keys<LawConstants> constants_keys(const MaterialLaw& law) {
  using C = LawConstants;
  std::vector<Key<C>> keys;
  if (!law.columns.empty())
    keys.push_back(Key<C>(key_of_terms(law), [&law](const Reader& value, C& constants) {
                     for (const Reader& item : value.items()) constants.terms.push_back(read_term(item, law.columns));
                   }).needed());
  for (const ParameterInfo& info : law.parameters) {
    Key<C> key(key_of(info), [&info](const Reader& value, C& constants) {
      if (info.kind == ValueKind::direction)
        constants.directions[info.name] = value.direction();
      else
        constants.numbers[info.name] = read_parameter(value, info);
    });
    keys.push_back(info.required ? std::move(key).needed() : std::move(key));
  }
  for (const WordInfo& info : law.words)
    keys.push_back({{info.name, words_text(info.words), "", "", "`" + info.words.front() + "`", info.text},
                    [&info](const Reader& value, C& constants) {
                      std::vector<std::pair<std::string, std::string>> words;
                      for (const std::string& word : info.words) words.emplace_back(word, word);
                      constants.words[info.name] = value.choice(words);
                    }});
  return Keys<C>({keys});
}

/// The law's own curve in uniaxial stress as that of springs, up to a strain and down to half of the length.
StressStrain spring_curve(const Reader& reader, double up_to, const Material& material) {
  constexpr int parts = 40;
  const double down_to = std::min(up_to, 0.5);
  if (!material.law || !material.law->uniaxial_stress) reader.fail("springs can follow a law's curve: give a `law`");
  if (!material.law->directions.empty()) reader.fail("springs of all directions cannot follow a law that has its own");
  std::vector<StressStrain::Point> points;
  for (int i = -parts; i <= parts; ++i) {
    const double strain = i * (i < 0 ? down_to : up_to) / parts;
    const std::optional<double> stress =
        i == 0 ? 0. : material.law->uniaxial_stress(material, Vector3::UnitZ(), strain);
    if (!stress) reader.fail("the law has no equilibrium in uniaxial stress at a strain of " + number(strain));
    points.push_back({strain, *stress});
  }
  if (const auto wrong = StressStrain::fault(points))
    reader.fail("the law's curve in uniaxial stress does not rise up to there: at a strain of " +
                number(points[wrong->first].strain) + " " + wrong->second);
  return StressStrain::through(points);
}

/// bending: plate, or D in N m
double read_bending_rigidity(const Reader& reader, const Material& material) {
  const std::string word = reader.is_text() ? reader.text() : "";
  if (word != "plate") {
    if (!word.empty() && std::isalpha(static_cast<unsigned char>(word.front())))
      reader.choice<int>({{"plate", 0}});  // names the word that there is
    return reader.quantity(dimension::energy, kPositive);
  }
  if (!(material.thickness > 0)) reader.fail("a plate needs a thickness");
  return material.youngs_modulus * std::pow(material.thickness, 3) /
         (12 * (1 - material.poissons_ratio * material.poissons_ratio));
}

/// What a file of materials, a map of names, states under a name; none where the material names no file.
std::optional<Reader> find_named(Reader& reader) {
  const auto file = reader.find("file"), name = reader.find("name");
  if (name && !file) name->fail("names a material of a file: key 'file' is missing");
  if (!file) return std::nullopt;
  if (!name) reader.fail("key 'name' is missing: which material of '" + file->text() + "'?");
  Reader library = file->located([&] { return file->open(file->existing_file()); });
  read_preamble(library);
  std::vector<std::string> names = library.keys();
  std::erase_if(names, [](const std::string& key) { return key == "extends" || key == "values" || key == "title"; });
  if (std::find(names.begin(), names.end(), name->text()) == names.end())
    name->fail("'" + file->text() + "' has no material '" + name->text() + "'" + suggestion(name->text(), names));
  Reader material = library.at(name->text());
  if (material.has("fields")) material.at("fields").fail("places are those of a body: write it in the scene");
  return material;
}

/// Whether a material states elasticity of its own, in the place of what the material of its file has.
bool has_own_law(Reader& reader) {
  return reader.has("law") || reader.has("youngs_modulus") || reader.has("curve") || reader.has("secant_modulus");
}

/// A material as far as its keys are read.
struct MaterialSetup : Material {
  std::string file, name;
  std::shared_ptr<const MaterialLaw> row;  ///< of its law; null where it names none
  bool based = false;                      ///< on another material, of which it keeps the elasticity
  std::optional<Reader> place;
  bool derived() const { return row && !row->from_moduli; }
};

void set_curve(const CurveNumbers& stated, MaterialSetup& material) {
  material.curve = stated.curve();
  material.youngs_modulus = material.curve->modulus(0);
}

void check_slope(const Reader& modulus, MaterialSetup& material) {
  if (!material.curve) return;
  const double first = material.curve->modulus(0);
  if (std::abs(material.youngs_modulus - first) > 1e-3 * first)
    modulus.fail("the curve begins with a slope of " + number(first) + " Pa; give that, or leave this out");
  material.youngs_modulus = first;
}

void read_law(const Reader& name, MaterialSetup& material) {
  Reader map = *material.place;
  map.set_section("material." + material.row->name);
  LawConstants constants{.law = material.row->name};
  constants_keys(*material.row).read_into(map, constants);
  static_cast<Material&>(material) = name.located([&] { return with_law(*material.row, constants, material); });
}

Keys<MaterialSetup> all_material_keys(const Table<MaterialLaw>& laws) {
  using S = MaterialSetup;
  const auto no_constant = [](const Reader& value, const S& material) {
    if (material.derived()) value.fail("follows from the constants of the law; leave it out");
  };
  return {
      key::file("file", &S::file, "a YAML file of materials by name; the keys here count before the material's"),
      key::text("name", &S::name, "which of them").otherwise("needed with `file`"),
      KeyGroup<S>{{Key<S>("curve",
                          key::rows_below("curve", "map",
                                          "nominal stress–strain curve in uniaxial stress; replaces `youngs_modulus`",
                                          curve_forms()),
                          [](const Reader& value, S& material) { set_curve(read_curve(value), material); })
                       .then(no_constant),
                   Key<S>("secant_modulus",
                          key::rows_below("secant_modulus", "map",
                                          "E(ε), secant modulus over nominal strain; replaces `youngs_modulus`",
                                          secant_forms()),
                          [](const Reader& value, S& material) { set_curve(read_secant_modulus(value), material); })
                       .then(no_constant)}},
      Key<S>(key::quantity("youngs_modulus", &S::youngs_modulus, dimension::pressure, "Young's modulus E", kPositive))
          .needed_if([](const S& material) { return !material.curve && !material.derived() && !material.based; },
                     "needed, or a curve or law")
          .then(no_constant)
          .then(check_slope),
      Key<S>(key::quantity("poissons_ratio", &S::poissons_ratio, dimension::none,
                           "Poisson's ratio ν: up to 0.4999 of solids, 0.5 of membranes, 0 … 0.4999 with `+volume`",
                           {-0.99, 0.5, false}))
          .then([](const Reader& value, const S& material) {
            if (material.derived() || (!material.row && material.law))
              value.fail("follows from the constants of the law; leave it out");
          }),
      Key<S>({"law", words_text(laws.names()), "", "", "none",
              "a law with constants of its own, listed below; E and ν at rest follow from them"},
             [](const Reader& value, S& material) { read_law(value, material); }),
      Key<S>({"spring_curve", "number", "", "> 0", "none",
              "strain up to which springs follow the law's own curve in uniaxial stress; without it they are straight"},
             [](const Reader& value, S& material) {
               material.curve = spring_curve(value, value.quantity(dimension::none, kPositive), material);
             }),
      key::quantity(
          "density", &S::density, dimension::density,
          "mass over volume ρ: of cells, or without them of the convex hull; of lines, ropes and nets that are "
          "thinner than a molecule's radius of cubes as wide as each",
          kPositive),
      key::quantity("thickness", &S::thickness, dimension::length, "thickness of a membrane at rest", kPositive)
          .otherwise("needed for triangles"),
      Key<S>(
          {"bending", "`plate`, or quantity", "J", "> 0", "none",
           "bending stiffness of a sheet: E t³ / 12 (1 − ν²), or a value in N m; of a scene of one body"},
          [](const Reader& value, S& material) { material.bending_rigidity = read_bending_rigidity(value, material); }),
      key::map_into<S>(
          "fibre", fibre_keys(),
          [](const Reader&, S& material, const FibreSetup& fibre) {
            material.fibre = {fibre.direction, fibre.compression ? fibre.curve : fibre.curve.without_compression()};
          }),
      key::map("active", &S::active, active_keys()),
      key::map("around", &S::around, around_keys("those of fibres and law are")),
      key::map_into<S>("relaxation", relaxation_keys(),
                       [](const Reader& value, S& material, const RelaxationSetup& setup) {
                         material.relaxation = relaxation_of(value, setup);
                       }),
      key::map("softening", &S::softening, softening_keys()).then([](const Reader& value, const Material& material) {
        value.located([&] { check_softening(*material.softening); });
      }),
      Key<S>("fields", rows_of_fields(), [](const Reader&, S&) {})};  // set_fields() reads them, which knows the body
}

}  // namespace

std::vector<double> read_term(const Reader& item, const std::vector<ParameterInfo>& columns) {
  if (columns.size() == 1) return {read_parameter(item, columns.front())};
  std::vector<double> term;
  const std::vector<Reader> values = item.items(columns.size());
  for (std::size_t column = 0; column < columns.size(); ++column)
    term.push_back(read_parameter(values[column], columns[column]));
  return term;
}

Material read_material(Reader reader, const Table<MaterialLaw>& laws, const Material* base) {
  reader.set_section("material");
  const auto given = reader.given_material("given");
  if (given) base = given.get();
  const std::optional<Reader> named = find_named(reader);
  MaterialSetup setup;
  if (named)
    static_cast<Material&>(setup) = read_material(*named, laws);
  else if (base)
    static_cast<Material&>(setup) = *base;
  const bool own_law = has_own_law(reader);
  setup.based = (named || base) && !own_law;
  if (const auto law = reader.find("law")) setup.row = law->located([&] { return laws.find(law->text()); });
  if (own_law) setup.curve.reset(), setup.law.reset();
  if (setup.curve) setup.youngs_modulus = setup.curve->modulus(0);
  return all_material_keys(laws).read(reader, {}, std::move(setup));
}

std::optional<CurveNumbers> read_curve_numbers(Reader material) {
  if (auto curve = material.find("curve")) return read_curve(*curve);
  if (auto secant = material.find("secant_modulus")) return read_secant_modulus(*secant);
  const std::optional<Reader> named = has_own_law(material) ? std::nullopt : find_named(material);
  return named ? read_curve_numbers(*named) : std::nullopt;
}

std::string read_kept(Reader material, const std::string& folder) {
  namespace fs = std::filesystem;
  std::string kept;
  const auto keep = [&](const std::string& key, const std::string& value) {
    kept += std::string("  ") + key + ": " + value + "\n";
  };
  if (const auto file = material.find("file")) {
    const fs::path path = fs::absolute(fs::path(file->file_path()).parent_path() / file->text());
    keep("file", path_text(path.lexically_normal().lexically_relative(fs::absolute(folder).lexically_normal())));
    keep("name", material.at("name").line());
  }
  for (const char* key : {"spring_curve", "bending", "fibre", "active", "around", "softening", "fields"})
    if (const auto value = material.find(key)) keep(key, value->line());
  // The numbers that are put in take the curve away that springs have in the file.
  while (!has_own_law(material) && !material.has("spring_curve")) {
    const std::optional<Reader> named = find_named(material);
    if (!named) break;
    material = *named;
    if (const auto value = material.find("spring_curve")) keep("spring_curve", value->line());
  }
  return kept;
}

void check_material(Reader reader, const Material& material, const Body& body) {
  reader.set_section("material");
  const bool membrane = !body.triangles.empty();
  if (membrane && material.thickness == 0)
    reader.fail(
        "key 'thickness' is missing: a body of triangles is a membrane (a solid within them: `body: {fill: …}`)");
  const bool solid = !membrane || !body.tetrahedra.empty();
  if (material.law && material.poissons_ratio == 0.5 && solid)
    reader.fail("key 'bulk_modulus' is missing: only membranes, bodies of triangles, are incompressible");
  if (!material.law && material.poissons_ratio > 0.4999 && solid) {
    if (!reader.has("poissons_ratio"))
      reader.fail("Poisson's ratio is above 0.4999: only membranes, bodies of triangles, are incompressible");
    const Reader given = reader.at("poissons_ratio");
    given.fail("'" + given.text() +
               "' is out of range: above 0.4999 only membranes, bodies of triangles, are incompressible");
  }
}

std::vector<KeySection> material_keys(const Catalog& catalog) {
  std::vector<KeySection> sections{{"material", "Material", "", all_material_keys(catalog.material_laws).rows()}};
  for (KeySection& section : field_keys()) sections.push_back(std::move(section));
  for (const auto& law : catalog.material_laws)
    sections.push_back({"material." + law->name, "",
                        "`law: " + law->name + "`: " + law->summary + " " + law->source + ".",
                        constants_keys(*law).rows()});
  return sections;
}

}  // namespace elastin::lab
