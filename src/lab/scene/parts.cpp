#include "lab/scene/parts.h"

#include <algorithm>

namespace elastin::lab {

double read_length(Reader& reader, const char* key) { return reader.at(key).quantity(dimension::length, kPositive); }

double read_parameter(const Reader& reader, const ParameterInfo& info) {
  if (info.kind == ValueKind::whole) return reader.whole(static_cast<int>(info.low), static_cast<int>(info.high));
  return reader.quantity(info.unit, {info.low, info.high, info.above_low});
}

namespace {

/// A strategy with a volume term that is unsuited for cells which keep their volume in another way than by so many
/// pressures each.
Strategy with_pressures(Strategy strategy, int pressures) {
  strategy.unsuited = [before = strategy.unsuited, pressures,
                       mixed = static_cast<bool>(strategy.make_mixed)](const Body& body) -> std::string {
    if (std::string why = before(body); !why.empty()) return why;
    const std::string word = pressures == 1 ? "mean_dilatation" : "linear_pressure";
    if (!mixed || !has_blocks(body, 3))
      return "has no " + word + ", but volumes around molecules or in cubes: write `volume: automatic`";
    for (const CellBlock& block : body.blocks)
      if (block.kind->dimensions == 3 && block.kind->pressures != pressures)
        return std::string(block.kind->plural) + " have no " + word +
               ": write `volume: " + (pressures == 1 ? "linear_pressure`" : "mean_dilatation`");
    return "";
  };
  return strategy;
}

}  // namespace

StrategyChoice read_strategy(Reader reader, const Catalog& catalog) {
  if (reader.is_text() && reader.text().find(", ") != std::string::npos)
    reader.fail("'" + reader.text() + "' are several strategies; write strategies: [" + reader.text() +
                "] for `compare`, and one of them as stiffness");
  if (reader.is_text()) return reader.located([&] { return choose_strategy(catalog, reader.text()); });
  if (!reader.is_map()) {
    std::string names;
    for (const Reader& item : reader.items())
      if (item.is_text()) names += (names.empty() ? "" : ", ") + item.text();
    reader.fail("is a list, and names one strategy: a word, or {strategy: NAME, …}; several are for `compare`, as " +
                ("strategies: [" + names) + "] beside it or --strategies");
  }
  reader.set_section("stiffness");
  const Reader name = reader.at("strategy");
  StrategyChoice choice = name.located([&] { return choose_strategy(catalog, name.text()); });
  for (const ParameterInfo& info : choice.strategy.parameters)
    if (auto value = reader.find(info.name)) choice.values[info.name] = read_parameter(*value, info);
  if (auto volume = reader.find("volume")) {
    if (choice.strategy.volume_modulus) volume->fail("'" + choice.label + "' has a volume term already");
    enum class Term { none, automatic, mean_dilatation, linear_pressure };
    using Words = std::vector<std::pair<std::string, Term>>;
    const bool springs = choice.strategy.kind != StrategyKind::cell_law;
    Words words{{springs ? "true" : "averaged", Term::automatic},
                {springs ? "false" : "cells", Term::none},
                {"automatic", Term::automatic},
                {"none", Term::none}};
    if (!springs) {
      words.emplace_back("mean_dilatation", Term::mean_dilatation);
      words.emplace_back("linear_pressure", Term::linear_pressure);
    }
    const Term term = volume->choice(words);
    if (term != Term::none) choice = volume->located([&] { return with_volume(std::move(choice)); });
    if (term == Term::mean_dilatation) choice.strategy = with_pressures(std::move(choice.strategy), 1);
    if (term == Term::linear_pressure) choice.strategy = with_pressures(std::move(choice.strategy), 4);
  }
  if (auto wrinkling = reader.find("wrinkling");
      wrinkling && wrinkling->choice<bool>({{"drop", true}, {"keep", false}}))
    choice = wrinkling->located([&] { return with_wrinkling(std::move(choice)); });
  if (auto label = reader.find("label")) choice.label = label->text();
  reader.finish();
  return choice;
}

void read_preamble(Reader& reader) {
  reader.find("extends");
  reader.find("values");
}

namespace {

/// What the rest of `solver` asks of an engine that is not this process alone.
std::shared_ptr<StaticEngine> read_engine(const Reader& reader, Reader& solver, const Catalog& catalog) {
  const auto row = reader.located([&] { return catalog.engines.find(reader.text()); });
  if (!row->missing.empty()) reader.fail("'" + row->name + "': " + row->missing);
  if (!row->make) return nullptr;
  const std::string with = "does not go with engine: " + row->name;
  if (const auto method = solver.find("method"); method && method->text() != "newton")
    method->fail("'" + method->text() + "' " + with + ", which goes by Newton's method");
  if (const auto linear = solver.find("linear_solver"))
    if (const std::string name = linear->text(); name == "direct" || name == "bicgstab")
      linear->fail("'" + name + "' " + with + "; allowed: automatic, pcg, multigrid");
  return row->make();
}

}  // namespace

StaticOptions read_solver(Reader reader, const Catalog& catalog) {
  StaticOptions options;
  if (auto value = reader.find("displacements"))
    options.linear = value->choice<bool>({{"large", false}, {"small", true}});
  if (auto value = reader.find("method"))
    options.static_method = value->choice<StaticMethod>({{"newton", StaticMethod::newton},
                                                         {"explicit", StaticMethod::explicit_steps},
                                                         {"implicit", StaticMethod::implicit_steps}});
  if (auto value = reader.find("linear_solver"))
    options.method = value->located([&] { return catalog.linear_solvers.find(value->text()); });
  if (auto value = reader.find("tolerance")) options.tolerance = value->quantity(dimension::none, {1e-14, 0.1, false});
  if (auto value = reader.find("engine")) options.engine = read_engine(*value, reader, catalog);
  if (auto value = reader.find("newton_limit")) options.newton_limit = value->whole(1, 100000);
  reader.finish();
  return options;
}

std::vector<KeySection> strategy_keys(const Catalog& catalog) {
  std::vector<SceneKey> keys{
      {"strategy", "word", "", "", "needed", "name of the strategy; `elastin list` prints all"},
      {"volume",
       "`none`, `automatic`; of laws `mean_dilatation`, `linear_pressure`, `cells`, `averaged`; of springs `false`, "
       "`true`",
       "", "", "`none`; of a law in `stiffness` where ν > 0.4: `automatic`",
       "how the volume is kept near ν = ½: `automatic` (`true`, `averaged`) as `+volume`, by what the body's cells "
       "have: "
       "`linear_pressure` in hexahedra of 27 nodes, `mean_dilatation` in other hexahedra, prisms and tetrahedra of "
       "second "
       "order, else volumes around molecules or in cubes; `none` (`false`, `cells`) at each point alone"},
      {"wrinkling", "`drop`, `keep`", "", "", "`keep`",
       "`drop`: a membrane law without compressive stress, as `+wrinkling`"},
      {"label", "text", "", "", "the name", "name in tables"}};
  for (const Strategy& strategy : catalog.strategies())
    for (const ParameterInfo& info : strategy.parameters) {
      const auto same =
          std::find_if(keys.begin(), keys.end(), [&](const SceneKey& key) { return key.name == info.name; });
      if (same != keys.end()) {  // one parameter of several strategies
        same->text.insert(same->text.find(": "), ", `" + strategy.name + "`");
        continue;
      }
      keys.push_back(key_of(info));
      keys.back().text = "of `" + strategy.name + "`: " + info.text;
    }
  return {{"stiffness", "Stiffness",
           "A word is a strategy's name: `lattice`, `\"calibrated:patch+volume\"`, `hencky_energy_membrane+wrinkling`. "
           "A map "
           "has the name and parameters:",
           std::move(keys)}};
}

std::vector<KeySection> solver_keys(const Catalog& catalog) {
  return {{"solver",
           "Solver",
           "",
           {{"displacements", "`large`, `small`", "", "", "`large`",
             "`small`: one linear solve about rest, without contact"},
            {"engine", words_text(catalog.engines.names()), "", "", "`threads`",
             "who solves: this process, or [several](#several-processes) that `mpiexec` starts; equilibria alone"},
            {"linear_solver", words_text(catalog.linear_solvers.names()), "", "", "`automatic`",
             "method for the linear equations; `elastin list` describes each"},
            {"method", "`newton`, `explicit`, `implicit`", "", "", "`newton`",
             "how an equilibrium is found: by Newton's method, or by time steps until the body rests"},
            {"tolerance", "number", "", "1e-14 … 0.1", "1e-10", "unbalanced force over loads and reactions"},
            {"newton_limit", "whole", "", "1 … 100000", "200", "iterations in one solve"}}}};
}

}  // namespace elastin::lab
