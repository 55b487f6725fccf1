#include "lab/identify/identify.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include "config/scene_text.h"
#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/report/table.h"
#include "lab/run/config_names.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;

std::unordered_map<std::string, SearchEnd> read_ends(const std::string& path) {
  std::unordered_map<std::string, SearchEnd> ends;
  int line = 0;
  for (const std::string& text : lines_of(path)) {
    ++line;
    try {
      const Json json = Json::parse(text);
      SearchEnd end;
      const auto values = json.at("values").get<std::vector<double>>();
      end.values = Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
      end.converged = json.at("converged"), end.message = json.at("message");
      end.starts = json.at("searches"), end.agreeing = json.at("searches_at_the_least");
      end.iterations = json.at("iterations"), end.evaluations = json.at("evaluations");
      end.seconds = json.at("seconds");
      ends.insert_or_assign(json.at("key"), std::move(end));
    } catch (const Json::exception& error) {
      throw InputError(SourceLocation{path, line},
                       std::string("this line is not a search of `identify`: ") + error.what());
    }
  }
  return ends;
}

}  // namespace

FitJournal::FitJournal(const std::string& folder, bool resume)
    : ends_(resume ? read_ends(folder + "/fits.jsonl") : std::unordered_map<std::string, SearchEnd>{}),
      file_(folder + "/fits.jsonl", resume) {}

std::optional<SearchEnd> FitJournal::find(const std::string& key) const {
  const auto found = ends_.find(key);
  return found == ends_.end() ? std::nullopt : std::optional(found->second);
}

void FitJournal::add(const std::string& key, const std::string& label, const SearchEnd& end) {
  const Json json{{"key", key},
                  {"of", label},
                  {"values", std::vector<double>(end.values.begin(), end.values.end())},
                  {"converged", end.converged},
                  {"message", end.message},
                  {"searches", end.starts},
                  {"searches_at_the_least", end.agreeing},
                  {"iterations", end.iterations},
                  {"evaluations", end.evaluations},
                  {"seconds", end.seconds}};
  file_.add(json.dump(-1, ' ', false, Json::error_handler_t::replace));
  ends_.insert_or_assign(key, end);
}

namespace {

constexpr const char* kBulkModulus = "bulk_modulus";  // of a law; data of shape alone do not determine it
constexpr int kMostTerms = 3;                         // of laws with terms, where all are compared

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    if (to > from) words.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return words;
}

/// Puts in what the command line says instead of the scene.
void apply(const IdentifyRequest& request, IdentifyTask& task) {
  for (const std::string& given : request.data) {
    const std::size_t equals = given.find('=');
    const std::string name = equals == std::string::npos ? "" : given.substr(0, equals);
    bool used = false;
    for (DataTest& test : task.tests)
      if (name.empty() || test.name == name)
        test.file = given.substr(equals == std::string::npos ? 0 : equals + 1), used = true;
    if (!used)
      throw InputError("--data " + given + ": " + task.source.path() + " has no test '" + name + "'" +
                       suggestion(name, names_of(task.tests)));
  }
  for (const std::string& name : request.tests)
    named(task.tests, name, "--tests " + name + ": " + task.source.path() + " has no such test");
  if (!request.tests.empty())
    for (DataTest& test : task.tests)
      if (std::find(request.tests.begin(), request.tests.end(), test.name) == request.tests.end()) test.weight = 0;
  if (!request.laws.empty()) task.laws = words_of(request.laws);
}

bool has_specimen(const IdentifyTask& task) {
  return std::any_of(task.tests.begin(), task.tests.end(),
                     [](const auto& test) { return !test.kind->homogeneous && test.scene; });
}

const MaterialLaw* row_of(const Catalog& catalog, const Material& material) {
  return material.law ? catalog.material_laws.find(material.law->law).get() : nullptr;
}

std::string label_of(const MaterialLaw* row, const Material& material) {
  if (!row) return material.curve ? "curve" : "E and nu";
  return row->columns.empty() ? row->name : row->name + "/" + std::to_string(material.law->terms.size());
}

/// All numbers of the law but its bulk modulus; of E and ν, E. Of relaxation only where a test relaxes.
bool unknown_by_itself(const MaterialNumber& number, const IdentifyTask& task) {
  using Kind = MaterialNumber::Kind;
  const bool relaxes =
      std::any_of(task.tests.begin(), task.tests.end(), [](const auto& test) { return test.kind->in_time; });
  if (number.kind == Kind::share || number.kind == Kind::relaxation_time) return relaxes;
  if (number.kind == Kind::poissons_ratio || number.name == kBulkModulus) return false;
  return std::find(task.fixed.begin(), task.fixed.end(), number.name) == task.fixed.end();
}

/// The material that the scene states, where the search begins.
Trial trial_of(const IdentifyTask& task) {
  Trial trial = task.material;
  trial.curve = task.curve;
  return trial;
}

void add_always_unknown(const std::vector<WeightedTest>& tests, UnknownMaterial& unknown) {
  for (const WeightedTest& test : tests)
    if (test.stated->weight > 0)
      for (const MaterialNumber& number : test.test->always_unknown())
        if (!find_named(unknown.unknowns, number.name)) unknown.unknowns.push_back(number);
}

/// The numbers that the scene leaves unknown, of its own law; of spring rules and contact those that it names.
UnknownMaterial stated_unknowns(const IdentifyTask& task, const Catalog& catalog,
                                const std::vector<WeightedTest>& tests, const std::vector<std::string>& overrides) {
  const MaterialLaw* row = row_of(catalog, task.material);
  UnknownMaterial unknown{label_of(row, task.material), row, trial_of(task), {}, task.kept, task.plain};
  std::vector<MaterialNumber> all = material_numbers(row, unknown.trial);
  for (const std::string& name : task.fixed)
    named(all, name, task.source.path() + ": identify.fixed: the material has no number '" + name + "'");
  if (task.unknowns.empty()) {
    for (const MaterialNumber& number : all)
      if (unknown_by_itself(number, task)) unknown.unknowns.push_back(number);
    add_always_unknown(tests, unknown);
    return unknown;
  }
  for (const WeightedTest& test : tests)
    for (const MaterialNumber& number : test.test->own_numbers())
      if (!find_named(all, number.name)) all.push_back(number);
  const bool whole_scene = std::any_of(task.tests.begin(), task.tests.end(),
                                       [&](const DataTest& test) { return test.scene == task.source; });
  for (const UnknownChoice& choice : task.unknowns) {
    if (whole_scene && choice.name.find('.') != std::string::npos && !find_named(all, choice.name)) {
      constexpr double infinite = std::numeric_limits<double>::infinity();
      const config::StatedNumber stated = config::stated_number(task.source, overrides, choice.name);
      all.push_back({choice.name, stated.unit, stated.value > 0 ? 0 : -infinite, infinite, stated.value > 0,
                     stated.value, MaterialNumber::Kind::scene_key});
    }
    const MaterialNumber* found = find_named(all, choice.name);
    if (!found) choice.fail("there is no number '" + choice.name + "' here" + suggestion(choice.name, names_of(all)));
    MaterialNumber number = *found;
    if (choice.low)
      number.low = std::max(number.low, choice.low(number.unit)),
      number.above_low = number.above_low && number.low == found->low;
    if (choice.high) number.high = std::min(number.high, choice.high(number.unit));
    if (choice.start) number.value = choice.start(number.unit);
    const auto text = [&](double value) { return readable(value, number.unit); };
    if (!(number.low < number.high))
      choice.fail("low, " + text(number.low) + ", is not below high, " + text(number.high));
    if (number.value < number.low || number.value > number.high)
      choice.fail("the search would begin at " + text(number.value) +
                  (choice.start ? "" : ", the material's own value") + ", outside of its bounds " + text(number.low) +
                  " … " + text(number.high) + ": write a start between them");
    unknown.unknowns.push_back(number);
  }
  add_always_unknown(tests, unknown);
  return unknown;
}

/// A guess of the shear modulus: of the neo-Hookean solid with the least squares in the first homogeneous test; without
/// one that of the scene's material.
double guessed_shear_modulus(const std::vector<WeightedTest>& tests, const Catalog& catalog, const Material& like) {
  const auto row = catalog.material_laws.find("yeoh");
  const Material unit = with_law(*row, {.law = row->name, .terms = {{0.5}}});
  for (const WeightedTest& test : tests) {
    if (!test.stated->kind->homogeneous || !(test.stated->weight > 0)) continue;
    const auto found = homogeneous_stresses(*row, unit, *test.stated->kind->homogeneous, test.test->data().x);
    if (!found) continue;
    const VectorX scale = test.scale(), shown = found->stresses.cwiseQuotient(scale);
    const double guess = shown.dot(test.test->data().y.cwiseQuotient(scale)) / shown.squaredNorm();
    if (guess > 0) return guess;
  }
  return like.youngs_modulus / (2 * (1 + like.poissons_ratio));
}

/// Numbers of a law for a material of about this shear modulus; none where it needs directions.
/// @param solid whether it is that of a body, which has a bulk modulus: that of `like`
std::optional<Material> usual_material(const MaterialLaw& row, int terms, double modulus, const Material& like,
                                       bool solid) {
  LawConstants constants{.law = row.name};
  double share = 1;
  const auto value = [&](const ParameterInfo& info, int term) {
    if (info.unit == dimension::pressure) {
      const double size = modulus * share / 2;
      share *= 0.1;
      return std::clamp(size, info.low, info.high);
    }
    constexpr double exponents[] = {1.5, 5, -2};
    if (term >= 0) return exponents[term % 3];
    return std::isnan(info.fallback)
               ? std::clamp(std::isfinite(info.low) && info.low >= 1 ? 10 * info.low : 1., info.low, info.high)
               : info.fallback;
  };
  for (const ParameterInfo& info : row.parameters) {
    if (info.kind == ValueKind::direction) return std::nullopt;
    if (info.name != kBulkModulus) constants.numbers[info.name] = value(info, -1);
  }
  const auto bulk = like.law ? like.law->numbers.find(kBulkModulus) : ParameterValues::const_iterator{};
  if (like.law && bulk != like.law->numbers.end())
    constants.numbers.insert(*bulk);
  else if (solid && like.poissons_ratio < 0.5)
    constants.numbers[kBulkModulus] = like.youngs_modulus / (3 * (1 - 2 * like.poissons_ratio));
  for (int term = 0; term < terms; ++term) {
    constants.terms.emplace_back();
    for (const ParameterInfo& column : row.columns) constants.terms.back().push_back(value(column, term));
    if (constants.terms.back().size() > 1 && constants.terms.back()[1] < 0) constants.terms.back()[0] *= -1;
  }
  try {
    return with_law(row, constants, like);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// "yeoh/2", or a law without terms.
UnknownMaterial named_unknowns(const std::string& label, const IdentifyTask& task, const Catalog& catalog,
                               double modulus) {
  const std::size_t slash = label.find('/');
  const auto row = catalog.material_laws.find(label.substr(0, slash));
  if (slash != std::string::npos && row->columns.empty())
    throw InputError("law '" + label + "': " + row->name + " has no terms");
  int terms = row->columns.empty() ? 0 : kMostTerms;
  if (slash != std::string::npos) {
    const std::string count = label.substr(slash + 1);
    terms = count.size() == 1 && count[0] > '0' && count[0] <= '0' + row->most_terms ? count[0] - '0' : 0;
    if (terms == 0)
      throw InputError("law '" + label + "': write 1 to " + std::to_string(row->most_terms) + " terms behind the /");
  }
  const auto material =
      row->from_moduli ? std::nullopt : usual_material(*row, terms, modulus, task.material, has_specimen(task));
  if (!material)
    throw InputError("law '" + label + "' cannot be compared here: it has directions, or follows from E and nu");
  UnknownMaterial unknown{label_of(row.get(), *material), row.get(), *material, {}, task.kept, task.plain};
  for (const MaterialNumber& number : material_numbers(row.get(), *material))
    if (number.name != kBulkModulus && unknown_by_itself(number, task)) unknown.unknowns.push_back(number);
  return unknown;
}

std::vector<std::string> labels_of_all(const Catalog& catalog, const IdentifyTask& task, double modulus) {
  std::vector<std::string> labels;
  for (const auto& row : catalog.material_laws) {
    const int most = row->columns.empty() ? 1 : std::min(kMostTerms, row->most_terms);
    for (int terms = 1; terms <= most && !row->from_moduli; ++terms)
      if (usual_material(*row, row->columns.empty() ? 0 : terms, modulus, task.material, has_specimen(task)))
        labels.push_back(row->columns.empty() ? row->name : row->name + "/" + std::to_string(terms));
  }
  return labels;
}

/// No value that differences are over may be 0, and few may be noise.
void check_scale(const WeightedTest& test) {
  const MeasuredData& data = test.test->data();
  const VectorX scale = test.scale();
  Eigen::Index first = 0, within = 0;
  for (Eigen::Index i = 0; i < data.y.size(); ++i) {
    if (scale[i] == 0)
      throw InputError(
          SourceLocation{data.file, data.lines[i]},
          data.up->name + " is 0, and relative residuals are over it: leave the row out, or write residuals: absolute");
    if (test.stated->residuals == ResidualScale::relative && std::abs(data.y[i]) < 3 * data.noise && within++ == 0)
      first = i;
  }
  if (50 * within > data.y.size())
    throw InputError(SourceLocation{data.file, data.lines[first]},
                     fmt::format("{} from here on lie within the noise, {:.3g} {}, and would rule relative residuals: "
                                 "write residuals: automatic, or absolute",
                                 counted(within, "reading"), data.noise, si_unit(data.up->unit)));
}

std::vector<WeightedTest> make_tests(const IdentifyTask& task, const Catalog& catalog, const IdentifyRequest& request,
                                     const std::string& strategy) {
  const MaterialLaw* row = row_of(catalog, task.material);
  std::vector<WeightedTest> tests;
  Eigen::Index points = 0;
  for (const DataTest& stated : task.tests) {
    tests.push_back({&stated, make_measured_test(stated, catalog, row, task.material, request.overrides, strategy)});
    const MeasuredData& data = tests.back().test->data();
    if (stated.weight > 0) points += data.y.size();
    check_scale(tests.back());
    if (!stated.moduli.empty()) tests.back().moduli = window_moduli(stated, data);
  }
  if (points == 0) throw InputError(task.source.path() + ": no test has a weight above 0");
  return tests;
}

void check_count(const UnknownMaterial& unknown, const std::vector<WeightedTest>& tests, const IdentifyTask& task) {
  Eigen::Index points = 0;
  for (const WeightedTest& test : tests)
    if (test.stated->weight > 0) points += test.test->data().y.size();
  if (unknown.unknowns.empty())
    throw InputError(task.source.path() + ": identify: no number of the material is unknown");
  if (points < static_cast<Eigen::Index>(unknown.unknowns.size()))
    throw InputError(SourceLocation{tests.front().test->data().file},
                     counted(points, "measured point") + " cannot settle the " +
                         std::to_string(unknown.unknowns.size()) + " unknowns of " + unknown.label +
                         ": measure more, or fix some by identify.fixed");
}

/// All that the searches of a task follow from: its scenes with what they name, its data, and what counts.
std::string content_of(const IdentifyTask& task, const IdentifyRequest& request) {
  std::vector<std::string> parts = request.overrides;
  const auto add = [&](const SceneSource& source) {
    parts.push_back(open_scene(source, request.overrides, kMostMolecules).content());
  };
  add(task.source);
  for (const DataTest& test : task.tests) {
    if (test.scene && test.scene != task.source) add(*test.scene);
    std::ifstream data(test.file, std::ios::binary);
    parts.emplace_back(std::istreambuf_iterator<char>(data), std::istreambuf_iterator<char>());
    parts.push_back(test.weight > 0 ? test.name : "");
  }
  return key_of(parts);
}

bool has_points(const std::vector<WeightedTest>& tests) {
  return std::any_of(tests.begin(), tests.end(),
                     [](const WeightedTest& test) { return test.stated->kind->points && test.stated->weight > 0; });
}

/// What a fit leaves of the readings of each test, over its scale, which is their noise; infinite of those that do not
/// count.
std::vector<double> noise_left(const std::vector<WeightedTest>& tests, const Fit& fit) {
  constexpr double of_curve = 1e-3, of_points = 1e-4;  // less noise than that nothing has
  std::vector<double> left(tests.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const WeightedTest& test = tests[i];
    const VectorX& measured = test.test->data().y;
    if (!(test.stated->weight > 0) || fit.predictions[i].values.size() != measured.size()) continue;
    const double squares =
        ((fit.predictions[i].values - measured).cwiseProduct(test.factor()) * test.noise).squaredNorm();
    left[i] = std::max(std::sqrt(squares / test.stated->weight / test.freedom(fit.values.size())),
                       test.stated->kind->points ? of_points : of_curve);
  }
  return left;
}

/// Makes tests count by the noise that the last fit leaves: the least of them as before, the others less. Whether that
/// changed anything.
bool weigh_by_noise(std::vector<WeightedTest>& tests, const Fit& fit) {
  constexpr double little = 0.1;
  const std::vector<double> left = noise_left(tests, fit);
  const double least = *std::min_element(left.begin(), left.end());
  if (!std::isfinite(least)) return false;
  bool changed = false;
  for (std::size_t i = 0; i < tests.size(); ++i)
    changed |= std::isfinite(left[i]) && std::abs(std::log(left[i] / least / tests[i].noise)) > little;
  for (std::size_t i = 0; i < tests.size() && changed; ++i)
    if (std::isfinite(left[i])) tests[i].noise = left[i] / least;
  return changed;
}

/// A search from where another one ended; its name among those of the same task.
using SearchAgain = std::function<Fit(const Fit& from, const std::string& name)>;

/// The fit with automatic residuals over what their scatter shows, so that intervals hold what they state whether
/// readings scatter by a constant or in proportion. The scatter is seen from a fit over the largest values, which no
/// small reading rules. Where the differences of a test have a shape, what is left is no scatter: all stays as it was.
Fit fit_by_scatter(std::vector<WeightedTest>& tests, const Fit& before, const SearchAgain& search) {
  constexpr int most = 6;
  const double least = before.rough ? 1e-3 : kRounding;  // rms; of expensive equilibria less noise than nothing has
  std::vector<std::size_t> seen;
  const auto differences = [&](const Fit& fit, std::size_t i) -> VectorX {
    return fit.predictions[i].values - tests[i].test->data().y;
  };
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const DataTest& stated = *tests[i].stated;
    const MeasuredData& data = tests[i].test->data();
    if (stated.kind->points) return before;  // those are weighed by their noise
    if (stated.weight > 0 && stated.residuals == ResidualScale::automatic && data.y.size() >= kFewest &&
        data.deviations.size() == 0 &&
        differences(before, i).cwiseQuotient(tests[i].scale()).norm() >
            least * std::sqrt(static_cast<double>(data.y.size())))
      seen.push_back(i);
  }
  Fit fit = before;
  bool scatters = !seen.empty();
  for (int again = 0; again < most && scatters; ++again) {
    bool changed = false;
    for (const std::size_t i : seen) {
      const MeasuredData& data = tests[i].test->data();
      const double constant = again == 0 ? std::numeric_limits<double>::infinity()
                                         : scatter_constant(data.y, differences(fit, i), data.least_scale());
      changed |= std::exchange(tests[i].constant, constant) != constant;
    }
    if (!changed) break;
    fit = search(fit, "scatter " + std::to_string(again));
    scatters = fit.converged && std::all_of(seen.begin(), seen.end(), [&](std::size_t i) {
                 return fit.predictions[i].values.size() == tests[i].test->data().y.size() &&
                        !sign_changes(differences(fit, i)).too_few();
               });
  }
  const bool as_before = std::all_of(seen.begin(), seen.end(), [&](std::size_t i) { return tests[i].constant == 0; });
  if (scatters && !as_before) return fit;
  for (const std::size_t i : seen) tests[i].constant = 0;
  return before;
}

/// Whether the tests that count scatter, each by itself and not all alike. What has a shape is no scatter, of few
/// readings it is not known, and who states weights has weighed the tests.                            [Bartlett 1937]
bool scatter_unlike(const std::vector<WeightedTest>& tests, const Fit& fit) {
  const std::vector<double> left = noise_left(tests, fit);
  double all = 0, squares = 0, logarithms = 0, inverses = 0, count = 0, weight = 0;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const WeightedTest& test = tests[i];
    if (!(test.stated->weight > 0)) continue;
    const VectorX& measured = test.test->data().y;
    if (!std::isfinite(left[i]) || measured.size() < kFewest || (weight > 0 && test.stated->weight != weight) ||
        sign_changes(fit.predictions[i].values - measured).too_few())
      return false;
    const double freedom = test.freedom(fit.values.size());
    weight = test.stated->weight, count += 1, all += freedom, squares += freedom * left[i] * left[i];
    logarithms += 2 * freedom * std::log(left[i]), inverses += 1 / freedom;
  }
  if (count < 2) return false;
  const double found = (all * std::log(squares / all) - logarithms) / (1 + (inverses - 1 / all) / (3 * (count - 1)));
  // Of χ², beyond which 5 % lie.                                                        [Wilson & Hilferty 1931]
  const double spread = 2 / (9 * (count - 1)),
               limit = (count - 1) * std::pow(1 - spread + 1.645 * std::sqrt(spread), 3);
  return found > limit;
}

/// The fit in which tests that scatter unlike count by their noise, so that intervals hold what they state: else the
/// readings of the better tests make those of the others seem surer than they are.
Fit fit_by_noise(std::vector<WeightedTest>& tests, const Fit& before, const SearchAgain& search) {
  constexpr int most = 6;
  if (has_points(tests)) return before;  // weighed already
  Fit fit = before;
  for (int again = 0; again < most && fit.converged && scatter_unlike(tests, fit) && weigh_by_noise(tests, fit);
       ++again)
    fit = search(fit, "noise " + std::to_string(again));
  if (fit.converged && scatter_unlike(tests, fit)) return fit;
  for (WeightedTest& test : tests) test.noise = 1;
  return before;
}

struct Fitted {
  UnknownMaterial unknown;
  Fit fit;
  LawAnswer law;
};

/// Keys of the task's own scene with the best fit put in, except its material.
std::vector<std::pair<std::string, std::string>> scene_keys(const IdentifyTask& task, const IdentifyRequest& request,
                                                            const std::vector<WeightedTest>& tests,
                                                            const Fitted& best) {
  std::vector<std::pair<std::string, std::string>> keys;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (!request.data.empty()) keys.emplace_back("identify.tests." + std::to_string(i) + ".file", task.tests[i].file);
    if (task.tests[i].scene != task.source) continue;
    for (auto& key : tests[i].test->scene_keys(best.fit.trial, task.plain)) keys.push_back(std::move(key));
  }
  return keys;
}

/// SI, by name.
ParameterValues published_numbers(const IdentifyTask& task, const UnknownMaterial& own) {
  ParameterValues published;
  const std::vector<MaterialNumber> all = material_numbers(own.row, own.trial);
  for (const PublishedNumber& given : task.published) {
    const MaterialNumber* found = find_named(all, given.name);
    if (!found) given.fail("the material has no number '" + given.name + "'" + suggestion(given.name, names_of(all)));
    published[given.name] = given.value(found->unit);
  }
  return published;
}

void put_published(const ParameterValues& published, const IdentifyTask& task, Answer& answer) {
  answer.published_source = task.published_source;
  for (FoundNumber& number : answer.numbers)
    if (const auto found = published.find(number.name); found != published.end()) number.published = found->second;
}

Answer identify_field(const IdentifyTask& task, const Catalog& catalog, const IdentifyRequest& request,
                      const std::string& strategy, std::vector<WeightedTest>& tests) {
  if (!task.laws.empty() || !task.unknowns.empty())
    task.field->fail("a field is found alone: leave out unknowns and laws");
  const MaterialLaw* row = row_of(catalog, task.material);
  const UnknownMaterial unknown{label_of(row, task.material), row, trial_of(task), {}, task.kept, task.plain};
  Answer answer = make_answer(unknown, tests, find_field(*task.field, tests, {request.progress, request.stop}));
  answer.scene = task.name, answer.title = task.title, answer.strategy = strategy;
  return answer;
}

Answer identify_one(const IdentifyTask& task, const Catalog& catalog, const IdentifyRequest& request,
                    const std::string& strategy) {
  std::vector<WeightedTest> tests = make_tests(task, catalog, request, strategy);
  if (task.field) return identify_field(task, catalog, request, strategy, tests);
  const bool slow = has_specimen(task);
  FitOptions options;
  options.starts = task.starts > 0 ? task.starts : slow ? 1 : 8;
  options.rough = slow;
  options.progress = request.progress, options.stop = request.stop;
  const std::string content = request.journal ? content_of(task, request) : "";
  std::vector<Fitted> all;
  const auto add = [&](const UnknownMaterial& unknown) {
    check_count(unknown, tests, task);
    const std::string name = task.name + ", " + unknown.label + (strategy.empty() ? "" : ", " + strategy);
    const auto key = [&](const std::string& which) {
      return request.journal ? key_of(std::vector{content, unknown.label, strategy + which}) : "";
    };
    FitOptions own_options = options;
    if (request.journal) own_options.known = request.journal->find(key(""));
    Fit fit = fit_material(unknown, tests, own_options);
    constexpr int most = 4;
    const bool first = all.empty();  // the laws that are compared with it have the same weights
    const bool points = first && has_points(tests);
    for (int again = 0; points && again < most && !fit.predictions.empty() && weigh_by_noise(tests, fit); ++again) {
      own_options.known = fit, own_options.known->converged = false, own_options.starts = 1;
      fit = fit_material(unknown, tests, own_options);
    }
    const auto add_to_journal = [&](const std::string& which, const Fit& found) {
      if (request.journal && !(own_options.known && own_options.known->converged))
        request.journal->add(key(which), name, found);
    };
    add_to_journal("", fit);
    const SearchAgain again = [&](const Fit& from, const std::string& which) {
      own_options.known = request.journal ? request.journal->find(key(", " + which)) : std::nullopt;
      if (!own_options.known) own_options.known = from, own_options.known->converged = false;
      own_options.starts = 1;
      Fit found = fit_material(unknown, tests, own_options);
      add_to_journal(", " + which, found);
      found.starts = from.starts, found.agreeing = from.agreeing, found.seconds += from.seconds;
      return found;
    };
    if (first && fit.converged) fit = fit_by_noise(tests, fit_by_scatter(tests, fit, again), again);
    LawAnswer law = law_answer(make_answer(unknown, tests, fit, false));
    law.label = unknown.label;
    all.push_back({unknown, std::move(fit), std::move(law)});
  };
  const UnknownMaterial own = stated_unknowns(task, catalog, tests, request.overrides);
  const ParameterValues published = published_numbers(task, own);
  if (task.laws.empty()) {
    add(own);
  } else {
    const double modulus = guessed_shear_modulus(tests, catalog, task.material);
    const bool every = task.laws.size() == 1 && task.laws.front() == "all";
    for (const std::string& label : every ? labels_of_all(catalog, task, modulus) : task.laws) {
      if (request.stop && request.stop() && !all.empty()) break;
      add(label == own.label ? own : named_unknowns(label, task, catalog, modulus));
    }
    // The least criterion among those whose numbers are all found, and that are stable where they were measured.
    std::stable_sort(all.begin(), all.end(), [](const Fitted& a, const Fitted& b) {
      const auto rank = [](const LawAnswer& law) {
        const int worth = law.outcome != FitOutcome::converged ? 2 : law.stable ? 0 : 1;
        return std::pair(worth, law.criterion);
      };
      return rank(a.law) < rank(b.law);
    });
  }
  if (request.progress) request.progress(all.front().unknown.label + ", intervals");
  Answer best = make_answer(all.front().unknown, tests, all.front().fit, true, request.stop);
  if (!task.laws.empty())
    for (const Fitted& fitted : all) best.laws.push_back(fitted.law);
  if (all.front().unknown.label == own.label) put_published(published, task, best);
  best.keys = scene_keys(task, request, tests, all.front());
  best.scene = task.name, best.title = task.title, best.strategy = strategy;
  return best;
}

}  // namespace

std::vector<Answer> identify(const SceneSource& scene, const Catalog& catalog, const IdentifyRequest& request) {
  IdentifyTask task = load_identify_task(scene, catalog, request.overrides);
  apply(request, task);
  std::vector<Answer> answers;
  std::vector<std::string> strategies = words_of(request.strategies);
  if (strategies.empty()) strategies.emplace_back();
  std::optional<InputError> unsuited;  // of several strategies one may be, and its row says so
  bool any = false;
  for (const std::string& strategy : strategies) {
    try {
      answers.push_back(identify_one(task, catalog, request, strategy));
      any = true;
    } catch (const InputError& error) {
      unsuited = error;
      Answer& answer = answers.emplace_back();
      answer.scene = task.name, answer.title = task.title, answer.strategy = strategy, answer.cause = error.what();
    }
  }
  if (unsuited && !any) throw *unsuited;
  return answers;
}

}  // namespace elastin::lab
