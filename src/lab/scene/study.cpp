#include "lab/scene/parts.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <sstream>

#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

/// Keys of one axis go through their values side by side: so each has as many.
StudyAxis axis_of(const Reader& reader) {
  StudyAxis axis;
  std::vector<std::vector<Reader>> rows;  // by value, as `axis.values`
  const auto entries = reader.entries();
  for (const auto& [key, values] : entries) {
    if (values.is_text()) values.fail("expected a list, found a single value; write [" + values.text() + "]");
    const std::vector<Reader> items = values.items();
    if (items.empty()) values.fail("names no value; write a list of them");
    if (axis.values.empty()) axis.values.resize(items.size());
    if (items.size() != axis.values.size())
      values.fail("keys that change together have equally many values: " + std::to_string(items.size()) + " here, " +
                  std::to_string(axis.values.size()) + " of the one before");
    rows.resize(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      axis.values[i].emplace_back(key, items[i].line());
      rows[i].push_back(items[i]);
    }
  }
  const auto line = [&](std::size_t row) {
    return joined(axis.values[row], [](const auto& value) -> const std::string& { return value.second; });
  };
  constexpr std::size_t most = 200;  // values; more of them a program has written, and each pair would be compared
  for (std::size_t i = 0; i < rows.size() && rows.size() <= most; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::equal(rows[i].begin(), rows[i].end(), rows[j].begin(),
                     [](const Reader& a, const Reader& b) { return a.same_as(b); }))
        entries.front().second.fail("values " + std::to_string(j + 1) + " and " + std::to_string(i + 1) +
                                    " are the same, " + line(j) + (line(i) == line(j) ? "" : " and " + line(i)) +
                                    "; leave one of them out (`repeats` runs everything again)");
  if (axis.values.empty())
    reader.fail("write keys with their values, for example {solver.linear_solver: [pcg, direct]}");
  return axis;
}

/// Throws before more runs are allocated than anyone compares.
void check_runs(const std::vector<StudyAxis>& axes) {
  constexpr double most = 1e5;
  double rows = 1;
  for (const StudyAxis& axis : axes) rows *= static_cast<double>(axis.values.size());
  char text[80];
  std::snprintf(text, sizeof text, "that is %.3g combinations; at most %g are allowed", rows, most);
  if (rows > most) throw InputError(text);
}

/// Throws where a row would be named by values that it does not have, since those of a later key replace them, and
/// where such a key replaces what --set has set.
void check_keys(const std::vector<StudyAxis>& axes, const std::vector<std::string>& overrides) {
  std::vector<std::string> before;
  for (const StudyAxis& axis : axes)
    for (const auto& [key, value] : axis.values.front()) {
      for (const std::string& assignment : overrides)
        if (config::replaces(key, assignment.substr(0, assignment.find('='))))
          throw InputError("--set " + assignment + " changes nothing, because --vary or `study` changes '" + key +
                           "'; leave one of them out");
      for (const std::string& other : before)
        if (config::replaces(key, other))
          throw InputError(config::replaces(other, key)
                               ? "two of --vary and `study` change '" + key + "': write all its values in one list"
                               : "'" + key + "' would replace '" + other +
                                     "', which --vary or `study` changes "
                                     "before it: let it come first");
      before.push_back(key);
    }
}

}  // namespace

StudyAxis read_axis(const std::string& text) {
  const std::string what = "--vary " + text;
  YAML::Node node;
  try {
    const std::size_t equals = text.find_first_of("={:");
    if (equals != std::string::npos && text[equals] == '=') {
      node = YAML::Node(YAML::NodeType::Map);
      node[text.substr(0, equals)] = YAML::Load(text.substr(equals + 1));
    } else {
      node = YAML::Load(text);
    }
  } catch (const YAML::Exception& error) {
    throw InputError(SourceLocation{what}, "not valid YAML: " + error.msg);
  }
  if (!node.IsMap()) throw InputError(SourceLocation{what}, "write KEY.PATH=[value, …] or {KEY.PATH: [value, …], …}");
  return axis_of(Reader(std::make_shared<SceneFile>(SceneFile{what, {}, {}}), node, ""));
}

namespace {

Keys<Study> comparison_keys(const std::vector<StrategyChoice>& known) {
  return {Key<Study>({"vary", "list of maps", "", "", "none",
                      "`KEY.PATH: [value, …]`; keys of one item change together, items multiply to at most 1e5 "
                      "combinations"},
                     [](const Reader& value, Study& study) {
                       for (const Reader& item : value.items()) study.axes.push_back(axis_of(item));
                       value.located([&] { check_runs(study.axes); });
                     }),
          key::whole("repeats", &Study::repeats, 1, 1000, "how often everything runs, in turn"),
          key::wholes("threads", &Study::threads, 1, 4096, "numbers of threads: everything runs with each")
              .otherwise("the command's")
              .then([](const Reader& value, const Study&) { value.refuse_repeated_items(); }),
          Key<Study>({"own_reference", "word", "", "", "none",
                      "a strategy whose own values under refinement are extrapolated to the reference"},
                     [&known](const Reader& value, Study& study) {
                       study.own_reference = value.text();
                       if (!find_strategy(known, study.own_reference))
                         value.fail("'" + study.own_reference + "' is no strategy of this scene");
                     })};
}

Keys<StepperStudy> stepper_study_keys(const elastin::Table<StepperKind>& steppers) {
  using S = StepperStudy;
  const auto read_methods = [&steppers](const Reader& value, S& study) {
    if (value.is_text()) {
      study.methods = value.located([&] { return read_steppers(value.text(), steppers); });
      return;
    }
    for (Reader item : value.items()) {
      item.set_section("time.stepper");
      TimeOptions options;
      read_stepper(item, steppers, options);
      study.methods.push_back({*options.stepper, options.parameters});
    }
    if (study.methods.empty()) value.fail("names no stepper; write a list of them, or all");
  };
  return {Key<S>({"methods", "`all`, or list of words or maps", "", "", "`all`",
                  "steppers, each as `time.stepper` has them; what a map gives is not varied"},
                 read_methods, [&steppers](S& study, const Frame&) { study.methods = read_steppers("all", steppers); }),
          key::wholes("iterations", &S::iterations, 1, 1000,
                      "sweeps, iterations or solves of each step; Newton's method has 1 and as many as it takes")
              .otherwise("1, 4, 16, 64")
              .then([](const Reader& value, const S& study) {
                if (study.iterations.empty()) value.fail("names no number of iterations");
                value.refuse_repeated_items();
              }),
          key::quantities("steps", &S::steps, dimension::time,
                          "time steps; the period is that of the loaded shape, by Rayleigh's quotient", kPositive)
              .otherwise("1/25 and 1/100 of the period")
              .then([](const Reader& value, const S&) { value.refuse_repeated_items(); })};
}

const Keys<EngineStudy>& engine_study_keys() {
  using S = EngineStudy;
  static const Keys<S> keys{
      key::list({"names", "list of words", "", "", "none",
                 "[engines](#engines-as-rows-of-a-comparison), and steppers of Elastin, run to rest as engines are"},
                &S::names, [](const Reader& item) { return item; }),
      key::quantity("dt", &S::time_step, dimension::time, "time step", kPositive),
      key::whole("iterations", &S::iterations, 1, 1000000, "of each step").otherwise("each engine's own number"),
      key::quantity("seconds", &S::seconds, dimension::time, "when an engine that has not answered is ended",
                    kPositive),
      key::flag("calibrate", &S::calibrate,
                "multiply an engine's constants by one factor until it shows the modulus that they have in Elastin")};
  return keys;
}

}  // namespace

EngineStudy read_engine_study(const Reader& reader) { return engine_study_keys().read(reader); }

Study read_study(const Reader& reader, const std::vector<StrategyChoice>& known) {
  return comparison_keys(known).read(reader);
}

std::vector<std::vector<std::pair<std::string, std::string>>> combinations(const std::vector<StudyAxis>& axes,
                                                                           const std::vector<std::string>& overrides) {
  check_runs(axes);
  check_keys(axes, overrides);
  std::vector<std::vector<std::pair<std::string, std::string>>> all{{}};
  for (const StudyAxis& axis : axes) {
    std::vector<std::vector<std::pair<std::string, std::string>>> longer;
    for (const auto& before : all)
      for (const auto& value : axis.values) {
        longer.push_back(before);
        longer.back().insert(longer.back().end(), value.begin(), value.end());
      }
    all = std::move(longer);
  }
  return all;
}

std::vector<StepperChoice> read_steppers(const std::string& names, const elastin::Table<StepperKind>& steppers) {
  std::vector<StepperChoice> choices;
  std::istringstream words(names);
  for (std::string word; std::getline(words, word, ',');) {
    word.erase(0, word.find_first_not_of(' ')), word.erase(word.find_last_not_of(' ') + 1);
    if (word == "all")
      for (const auto& stepper : steppers) choices.push_back({stepper});
    else
      choices.push_back({steppers.find(word)});
  }
  if (choices.empty()) throw InputError("names no stepper");
  return choices;
}

StepperStudy read_stepper_study(const Reader& reader, const elastin::Table<StepperKind>& steppers) {
  return stepper_study_keys(steppers).read(reader);
}

std::vector<KeySection> study_keys(const Catalog& catalog) {
  return {{"engines", "Engines",
           "Other programs that `elastin compare` runs on the scene's own strategy too, see "
           "[Engines](#engines-as-rows-of-a-comparison). `--engines NAMES` and `--engine-dt TIME` are `--set "
           "engines.names=[NAMES]` and `--set engines.dt=TIME`.",
           engine_study_keys().rows()},
          {"steppers", "Steppers",
           "What `elastin compare` runs in place of strategies: the scene's own strategy by several steppers.",
           stepper_study_keys(catalog.steppers).rows()},
          {"study", "Study", "", comparison_keys({}).rows()}};
}

}  // namespace elastin::lab
