#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "elastin/core/base/text.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/forces/prony.h"
#include "lab/run/config_names.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// points: [[0, 0 Pa], [2 %, 1 kPa], …]
CurveNumbers read_points(const Reader& reader) {
  CurveNumbers stated;
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
  return stated;
}

/// {points: …} | {toe_strain, toe_modulus, modulus} | {tension, compression, smoothing}
CurveNumbers read_curve(Reader reader) {
  reader.set_section("material.curve");
  if (!reader.is_map())
    reader.fail(
        "write {points: [[strain, stress], ...]}, {toe_strain, toe_modulus, modulus} or {tension, compression}");
  const auto points = reader.find("points");
  CurveNumbers stated = points ? read_points(*points) : CurveNumbers{};
  const auto add = [&](const char* name, const Dimension& unit) {
    stated.numbers.push_back({name, unit, reader.at(name).quantity(unit, kPositive)});
  };
  if (!points && reader.find("tension")) {
    stated.form = CurveNumbers::Form::two_moduli;
    add("tension", dimension::pressure), add("compression", dimension::pressure);
    const auto smoothing = reader.find("smoothing");
    stated.strains = {smoothing ? smoothing->quantity(dimension::none, {1e-9, 1, false}) : 1e-4};
  } else if (!points) {
    stated.form = CurveNumbers::Form::toe;
    add("toe_strain", dimension::none), add("toe_modulus", dimension::pressure), add("modulus", dimension::pressure);
  }
  reader.finish();
  return stated;
}

/// {polynomial: [c0, c1, …], up_to: 80 %} | {points: [[ε, E], …]}
CurveNumbers read_secant_modulus(Reader reader) {
  if (!reader.is_map()) reader.fail("write {polynomial: [c0, c1, ...], up_to: strain} or {points: [[strain, E], ...]}");
  const auto polynomial = reader.find("polynomial"), points = reader.find("points");
  if (polynomial.has_value() == points.has_value()) {
    reader.finish();
    reader.fail("give one of polynomial and points");
  }
  CurveNumbers stated;
  const auto add = [&](const std::string& name, int from, double value) {
    const std::string number = std::to_string(static_cast<int>(stated.numbers.size()) + from);
    stated.numbers.push_back({name + number, dimension::pressure, value});
  };
  if (polynomial) {
    stated.form = CurveNumbers::Form::secant_polynomial;
    for (const Reader& item : polynomial->items()) add("c_", 0, item.quantity(dimension::pressure));
    stated.strains = {reader.at("up_to").quantity(dimension::none, kPositive)};
  } else {
    stated.form = CurveNumbers::Form::secant_table;
    for (const Reader& item : points->items()) {
      const auto pair = item.items(2);
      stated.strains.push_back(pair[0].quantity(dimension::none, kNotNegative));
      add("modulus_", 1, pair[1].quantity(dimension::pressure, kPositive));
    }
  }
  reader.finish();
  (polynomial ? polynomial : points)->located([&] { return stated.curve(); });
  return stated;
}

Fibre read_fibre(Reader reader) {
  const Vector3 direction = reader.at("direction").direction();
  const auto curve = reader.find("curve"), pressed = reader.find("compression");
  const auto modulus = curve ? reader.find("youngs_modulus") : std::optional(reader.at("youngs_modulus"));
  if (modulus && curve) curve->fail("there is a youngs_modulus already; give one of them");
  const StressStrain own =
      curve ? read_curve(*curve).curve() : StressStrain::linear(modulus->quantity(dimension::pressure, kPositive));
  const bool compression = !pressed || pressed->choice<bool>({{"true", true}, {"false", false}});
  reader.finish();
  return {direction, compression ? own : own.without_compression()};
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

enum class RelaxationModel { prony, standard_linear_solid, kelvin_voigt };

/// {terms: [[0.5, 1 s], [0.2, 10 s]], moduli: long_term} | {model: kelvin_voigt, time: 1 s} | …
Relaxation read_relaxation(Reader reader) {
  Relaxation relaxation;
  const auto named = reader.find("model");
  const auto model =
      named ? named->choice<RelaxationModel>({{"prony", RelaxationModel::prony},
                                              {"standard_linear_solid", RelaxationModel::standard_linear_solid},
                                              {"kelvin_voigt", RelaxationModel::kelvin_voigt}})
            : RelaxationModel::prony;
  const auto time = [&] { return reader.at("time").quantity(dimension::time, kPositive); };
  if (model == RelaxationModel::kelvin_voigt) {
    relaxation.retardation = time();
    reader.finish();
    return relaxation;
  }
  if (model == RelaxationModel::standard_linear_solid)
    relaxation.terms.push_back({reader.at("share").quantity(dimension::none, kPositive), time()});
  else
    for (const Reader& item : reader.at("terms").items()) {
      const auto pair = item.items(2);
      relaxation.terms.push_back(
          {pair[0].quantity(dimension::none, kPositive), pair[1].quantity(dimension::time, kPositive)});
    }
  if (auto moduli = reader.find("moduli"))
    relaxation.instantaneous = moduli->choice<bool>({{"long_term", false}, {"instantaneous", true}});
  reader.finish();
  reader.located([&] {
    check_relaxation(relaxation);
    return 0;
  });
  return relaxation;
}

/// {r: 1.5, m: 0.1 MPa, beta: 0.1}
Softening read_softening(Reader reader) {
  Softening softening;
  softening.r = reader.at("r").quantity(dimension::none, {1, std::numeric_limits<double>::infinity(), true});
  if (auto m = reader.find("m")) softening.m = m->quantity(dimension::pressure, kNotNegative);
  if (auto beta = reader.find("beta")) softening.beta = beta->quantity(dimension::none, kNotNegative);
  reader.finish();
  reader.located([&] {
    check_softening(softening);
    return 0;
  });
  return softening;
}

/// {direction: z, stress: 300 kPa, activation: {ramp: 1 s}, optimal_stretch: 1}
ActiveFibre read_active(Reader reader) {
  ActiveFibre active;
  active.direction = reader.at("direction").direction();
  active.stress = reader.at("stress").quantity(dimension::pressure, kPositive);
  if (auto stretch = reader.find("optimal_stretch"))
    active.optimal_stretch = stretch->quantity(dimension::none, kPositive);
  if (auto activation = reader.find("activation"))
    active.activation = [function = read_time_function(*activation)](double time) { return function.value(time); };
  reader.finish();
  return active;
}

/// {axis: z, through: [0, 0, 0]}
RoundAxis read_around(Reader reader) {
  RoundAxis around;
  around.direction = reader.at("axis").direction();
  if (auto point = reader.find("through")) around.point = point->vector(dimension::length);
  reader.finish();
  return around;
}

/// A law's term: a number, or a list of them.
std::vector<double> read_term(const Reader& item, const std::vector<ParameterInfo>& columns) {
  if (columns.size() == 1) return {read_parameter(item, columns.front())};
  std::vector<double> term;
  const std::vector<Reader> values = item.items(columns.size());
  for (std::size_t column = 0; column < columns.size(); ++column)
    term.push_back(read_parameter(values[column], columns[column]));
  return term;
}

/// {law: ogden, terms: [[0.63 MPa, 1.3], …], bulk_modulus: 1 GPa}
Material read_law(Reader reader, const Reader& name, const Table<MaterialLaw>& laws, const Material& material) {
  const auto row = name.located([&] { return laws.find(name.text()); });
  reader.set_section("material." + row->name);
  LawConstants constants{.law = row->name};
  for (const ParameterInfo& info : row->parameters) {
    const auto value = info.required ? std::optional(reader.at(info.name)) : reader.find(info.name);
    if (!value) continue;
    if (info.kind == ValueKind::direction)
      constants.directions[info.name] = value->direction();
    else
      constants.numbers[info.name] = read_parameter(*value, info);
  }
  for (const WordInfo& info : row->words)
    if (auto value = reader.find(info.name)) {
      std::vector<std::pair<std::string, std::string>> words;
      for (const std::string& word : info.words) words.emplace_back(word, word);
      constants.words[info.name] = value->choice(words);
    }
  if (!row->columns.empty())
    for (const Reader& item : reader.at("terms").items()) constants.terms.push_back(read_term(item, row->columns));
  return name.located([&] { return with_law(*row, constants, material); });
}

/// The law's own curve in uniaxial stress as that of springs, up to a strain and down to half of the length.
StressStrain spring_curve(const Reader& reader, const Material& material) {
  constexpr int parts = 40;
  const double up_to = reader.quantity(dimension::none, kPositive), down_to = std::min(up_to, 0.5);
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

/// What a file of materials, a map of names, states under a name; none where the material names no file.
std::optional<Reader> find_named(Reader& reader) {
  const auto file = reader.find("file"), name = reader.find("name");
  if (name && !file) name->fail("names a material of a file: key 'file' is missing");
  if (!file) return std::nullopt;
  if (!name) reader.fail("key 'name' is missing: which material of '" + file->text() + "'?");
  const auto path = std::filesystem::path(file->file_path()).parent_path() / file->text();
  Reader library = file->located([&] {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored))
      throw InputError("'" + file->text() + "': " + missing_file(path.string()));
    return open_scene_file(path.string(), {}, file->most_molecules());
  });
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

}  // namespace

Material read_material(Reader reader, const Table<MaterialLaw>& laws, const Material* base) {
  reader.set_section("material");
  const auto given = reader.given_material("given");
  if (given) base = given.get();
  const std::optional<Reader> named = find_named(reader);
  Material material = named ? read_material(*named, laws) : base ? *base : Material{};
  if (named) base = &material;
  const auto law = reader.find("law");
  const bool derived = law && !law->located([&] { return laws.find(law->text()); })->from_moduli;
  for (const char* key : {"youngs_modulus", "poissons_ratio", "curve", "secant_modulus"})
    if (derived && reader.has(key)) reader.at(key).fail("follows from the constants of the law; leave it out");
  const bool own_law = has_own_law(reader);
  if (own_law) material.curve.reset(), material.law.reset();
  if (!law && material.law && reader.has("poissons_ratio"))
    reader.at("poissons_ratio").fail("follows from the constants of the law; leave it out");
  if (auto curve = reader.find("curve")) material.curve = read_curve(*curve).curve();
  if (auto secant = reader.find("secant_modulus")) {
    if (material.curve) secant->fail("there is a curve already; give one of them");
    material.curve = read_secant_modulus(*secant).curve();
  }
  const bool needed = !material.curve && !derived && !(base && !own_law);
  const auto modulus = needed ? std::optional(reader.at("youngs_modulus")) : reader.find("youngs_modulus");
  if (modulus) material.youngs_modulus = modulus->quantity(dimension::pressure, kPositive);
  if (material.curve) {
    const double first = material.curve->modulus(0);
    char text[120];
    std::snprintf(text, sizeof text, "the curve begins with a slope of %.6g Pa; give that, or leave this out", first);
    if (modulus && std::abs(material.youngs_modulus - first) > 1e-3 * first) modulus->fail(text);
    material.youngs_modulus = first;
  }
  if (auto value = reader.find("poissons_ratio"))
    material.poissons_ratio = value->quantity(dimension::none, {-0.99, 0.5, false});
  if (law) material = read_law(reader, *law, laws, material);
  if (auto value = reader.find("spring_curve")) material.curve = spring_curve(*value, material);
  if (auto value = reader.find("density")) material.density = value->quantity(dimension::density, kPositive);
  if (auto value = reader.find("thickness")) material.thickness = value->quantity(dimension::length, kPositive);
  if (auto bending = reader.find("bending")) material.bending_rigidity = read_bending_rigidity(*bending, material);
  if (auto fibre = reader.find("fibre")) material.fibre = read_fibre(*fibre);
  if (auto active = reader.find("active")) material.active = read_active(*active);
  if (auto around = reader.find("around")) material.around = read_around(*around);
  if (auto relaxation = reader.find("relaxation")) material.relaxation = read_relaxation(*relaxation);
  if (auto softening = reader.find("softening")) material.softening = read_softening(*softening);
  reader.has("fields");  // set_fields() reads them, which knows the body
  reader.finish();
  return material;
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
  if (membrane && material.thickness == 0) reader.fail("key 'thickness' is missing: a body of triangles is a membrane");
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

namespace {

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

KeySection law_keys(const MaterialLaw& law) {
  KeySection section{
      "material." + law.name, "", "`law: " + law.name + "`: " + law.summary + " " + law.source + ".", {}};
  if (!law.columns.empty()) section.keys.push_back(key_of_terms(law));
  for (const ParameterInfo& info : law.parameters) section.keys.push_back(key_of(info));
  for (const WordInfo& info : law.words)
    section.keys.push_back({info.name, words_text(info.words), "", "", "`" + info.words.front() + "`", info.text});
  return section;
}

}  // namespace

std::vector<KeySection> material_keys(const Catalog& catalog) {
  std::vector<KeySection> sections{
      {"material",
       "Material",
       "",
       {{"file", "file beside the scene", "", "", "none",
         "a YAML file of materials by name; the keys here count before the material's"},
        {"name", "text", "", "", "needed with `file`", "which of them"},
        {"law", words_text(catalog.material_laws.names()), "", "", "none",
         "a law with constants of its own, listed below; E and ν at rest follow from them"},
        {"youngs_modulus", "quantity", "Pa", "> 0", "needed, or a curve or law", "Young's modulus E"},
        {"poissons_ratio", "number", "", "−0.99 … 0.5", "0.25",
         "Poisson's ratio ν: up to 0.4999 of solids, 0.5 of membranes, 0 … 0.4999 with `+volume`"},
        {"density", "quantity", "kg/m^3", "> 0", "1000", "mass over volume ρ"},
        {"thickness", "quantity", "m", "> 0", "needed for triangles", "thickness of a membrane at rest"},
        {"bending", "`plate`, or quantity", "J", "> 0", "none",
         "bending stiffness of a sheet: E t³ / 12 (1 − ν²), or a value in N m; of a scene of one body"},
        {"curve", "map", "", "", "none", "nominal stress–strain curve in uniaxial stress; replaces `youngs_modulus`"},
        {"curve.points", "list of pairs", "Pa", "", "none", "`[strain, stress]`, ascending, through the origin"},
        {"curve.toe_strain", "number", "", "> 0", "none", "end of the toe region, beyond which the curve is straight"},
        {"curve.toe_modulus", "quantity", "Pa", "> 0", "needed with `toe_strain`", "slope at strain 0"},
        {"curve.modulus", "quantity", "Pa", "> 0", "needed with `toe_strain`", "slope beyond the toe region"},
        {"curve.tension", "quantity", "Pa", "> 0", "none", "modulus in tension, of a curve with two moduli"},
        {"curve.compression", "quantity", "Pa", "> 0", "needed with `tension`", "modulus in compression"},
        {"curve.smoothing", "number", "", "1e-09 … 1", "1e-4", "strain over which these two are joined"},
        {"spring_curve", "number", "", "> 0", "none",
         "strain up to which springs follow the law's own curve in uniaxial stress; without it they are straight"},
        {"secant_modulus", "map", "", "", "none",
         "E(ε), secant modulus over nominal strain; replaces `youngs_modulus`"},
        {"secant_modulus.polynomial", "list of quantities", "Pa", "", "this, or `points`", "c₀, c₁ … of c₀ + c₁ ε + …"},
        {"secant_modulus.up_to", "number", "", "> 0", "needed with `polynomial`",
         "strain up to which the polynomial counts"},
        {"secant_modulus.points", "list of pairs", "Pa", "≥ 0, > 0", "this, or `polynomial`", "`[strain, E]`"},
        {"relaxation.model", "`prony`, `standard_linear_solid`, `kelvin_voigt`", "", "", "`prony`",
         "terms of G, one term, or a dashpot beside the law: σ + time dσ/dt"},
        {"relaxation.terms", "list of pairs", "s", "> 0", "needed of `prony`",
         "`[share, time]`: G(t) = g₀ + Σ share e^(−t/time) times the law, for `prony:` strategies"},
        {"relaxation.share", "number", "", "> 0", "needed of `standard_linear_solid`", "share of its one term"},
        {"relaxation.time", "quantity", "s", "> 0", "needed of these two",
         "relaxation time of the one term, or retardation time of the dashpot"},
        {"relaxation.moduli", "`long_term`, `instantaneous`", "", "", "`long_term`",
         "which moduli the law has: g₀ = 1, or 1 − Σ share; not of `kelvin_voigt`"},
        {"softening.r", "number", "", "> 1", "needed",
         "η = 1 − (1/r) erf((W_max − W)/(m + beta W_max)) times the stress, for `mullins:` strategies"},
        {"softening.m", "quantity", "Pa", "≥ 0", "0", "energy density over which stress is lost; this or `beta`"},
        {"softening.beta", "number", "", "≥ 0", "0", "the same over the largest energy density that there was"},
        {"fibre.direction", "direction", "", "", "needed", "direction of the fibres at rest"},
        {"fibre.youngs_modulus", "quantity", "Pa", "> 0", "needed, or `curve`",
         "modulus of the fibres; their stress adds to that of the matrix"},
        {"fibre.curve", "map", "", "", "none", "stress–strain curve of the fibres, as `curve` above"},
        {"fibre.compression", "`true`, `false`", "", "", "`true`", "whether the fibres resist compression"},
        {"active.direction", "direction", "", "", "needed", "direction of active fibres (muscle) at rest"},
        {"active.stress", "quantity", "Pa", "> 0", "needed", "largest stress of the fibres, over the present section"},
        {"active.optimal_stretch", "number", "", "> 0", "1", "stretch at which they have it"},
        {"active.activation", "time function", "", "", "1", "which part is at work; below 0 counts as 0"},
        {"around.axis", "direction", "", "", "needed",
         "axis around which directions turn: those of fibres and law are along radius, circumference and axis"},
        {"around.through", "vector", "m", "", "0", "a point of the axis"},
        {"fields.stiffness", "map", "", "", "none", "a factor of all moduli that differs from place to place"},
        {"fields.youngs_modulus", "map", "", "", "none", "the same of E in Pa, of a material without a law"},
        {"fields.density", "map", "", "", "none", "the same of the density in kg/m³"},
        {"fields.poissons_ratio", "map", "", "", "none",
         "the same of ν, of a material without a law; springs ignore it"},
        {"fields.constants", "map of maps", "", "", "none",
         "the same of the law's constants by their names, `c1`, `terms`, `direction`; springs have the E of them"},
        {"fields.fibre_direction", "map", "", "", "none", "a direction of fibres that differs from place to place"},
        {"fields.active_direction", "map", "", "", "none", "the same of active fibres"}}}};
  for (KeySection& section : field_keys()) sections.push_back(std::move(section));
  for (const auto& law : catalog.material_laws) sections.push_back(law_keys(*law));
  return sections;
}

}  // namespace elastin::lab
