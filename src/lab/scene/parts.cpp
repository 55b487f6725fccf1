#include "lab/scene/parts.h"

#include <filesystem>

namespace elastin::lab {

double read_parameter(const Reader& reader, const ParameterInfo& info) {
  if (info.kind == ValueKind::whole) return reader.whole(static_cast<int>(info.low), static_cast<int>(info.high));
  return reader.quantity(info.unit, {info.low, info.high, info.above_low});
}

namespace {

/// A strategy with a volume term that is unsuited for cells which keep their volume by another method than by
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

/// How the volume is kept near ν = ½.
enum class VolumeTerm { none, automatic, mean_dilatation, linear_pressure };

/// The choice with one more property in its name.
StrategyChoice chosen_with(const Catalog& catalog, const StrategyChoice& choice, bool StrategyName::*property) {
  StrategyName name = choice.name;
  name.*property = true;
  StrategyChoice chosen = choose_strategy(catalog, name);
  chosen.values = choice.values;
  return chosen;
}

void add_volume(const Reader& volume, const Catalog& catalog, StrategyChoice& choice) {
  if (choice.strategy.volume_modulus) volume.fail("'" + choice.label + "' has a volume term already");
  const bool springs = choice.strategy.kind != StrategyKind::cell_law;
  std::vector<std::pair<std::string, VolumeTerm>> words{{springs ? "true" : "averaged", VolumeTerm::automatic},
                                                        {springs ? "false" : "cells", VolumeTerm::none},
                                                        {"automatic", VolumeTerm::automatic},
                                                        {"none", VolumeTerm::none}};
  if (!springs) {
    words.emplace_back("mean_dilatation", VolumeTerm::mean_dilatation);
    words.emplace_back("linear_pressure", VolumeTerm::linear_pressure);
  }
  const VolumeTerm term = volume.choice(words);
  if (term != VolumeTerm::none)
    choice = volume.located([&] { return chosen_with(catalog, choice, &StrategyName::volume); });
  if (term == VolumeTerm::mean_dilatation) choice.strategy = with_pressures(std::move(choice.strategy), 1);
  if (term == VolumeTerm::linear_pressure) choice.strategy = with_pressures(std::move(choice.strategy), 4);
}

Keys<StrategyChoice> strategy_map_keys(const Catalog& catalog) {
  using S = StrategyChoice;
  std::vector<const Strategy*> strategies;
  for (const Strategy& strategy : catalog.strategies()) strategies.push_back(&strategy);
  return {
      Key<S>({"strategy", "word", "", "", "none", "name of the strategy; `elastin list` prints all"},
             [&catalog](const Reader& value, S& choice) {
               choice = value.located([&] { return choose_strategy(catalog, value.text()); });
             })
          .needed(),
      Key<S>({"volume",
              "`none`, `automatic`; of laws `mean_dilatation`, `linear_pressure`, `cells`, `averaged`; of springs "
              "`false`, `true`",
              "", "", "`none`; of a law in `stiffness` where ν > 0.4: `automatic`",
              "how the volume is kept near ν = ½: `automatic` (`true`, `averaged`) as `+volume`, by what the body's "
              "cells have: `linear_pressure` in hexahedra of 27 nodes, `mean_dilatation` in other hexahedra, prisms "
              "and tetrahedra of second order, else volumes around molecules or in cubes; `none` (`false`, `cells`) "
              "at each point alone"},
             [&catalog](const Reader& value, S& choice) { add_volume(value, catalog, choice); }),
      Key<S>({"wrinkling", "`drop`, `keep`", "", "", "`keep`",
              "`drop`: a membrane law without compressive stress, as `+wrinkling`"},
             [&catalog](const Reader& value, S& choice) {
               if (value.choice<bool>({{"drop", true}, {"keep", false}}))
                 choice = value.located([&] { return chosen_with(catalog, choice, &StrategyName::wrinkling); });
             }),
      key::text("label", &S::label, "name in tables").otherwise("the name"),
      parameter_keys(strategies, &S::values, [](const S& choice) { return &choice.strategy; })};
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
                ("strategies: [" + names) + "] next to it or --strategies");
  }
  reader.set_section("stiffness");
  return strategy_map_keys(catalog).read(reader);
}

void read_preamble(Reader& reader) {
  reader.find("extends");
  reader.find("values");
}

namespace {

struct SolverSetup : StaticOptions {
  std::optional<std::shared_ptr<const StaticEngineKind>> kind;
};

Keys<SolverSetup> solver_map_keys(const Catalog& catalog) {
  using S = SolverSetup;
  return {
      key::choice("displacements", &S::linear, {{"large", false}, {"small", true}},
                  "`small`: one linear solve about rest, with pressures on the surface at rest, without contact"),
      key::row("engine", &S::kind, catalog.engines,
               "what solves: this process, or [several](#several-processes) that `mpiexec` starts; equilibria alone")
          .otherwise("`threads`"),
      key::row("linear_solver", &S::method, catalog.linear_solvers,
               "method for the linear equations; `elastin list` describes each"),
      key::choice("method", &S::static_method,
                  {{"newton", StaticMethod::newton},
                   {"explicit", StaticMethod::explicit_steps},
                   {"implicit", StaticMethod::implicit_steps}},
                  "how an equilibrium is found: by Newton's method, or by time steps until the body rests"),
      key::quantity("tolerance", &S::tolerance, dimension::none, "unbalanced force over loads and reactions",
                    {1e-14, 0.1, false}),
      key::whole("newton_limit", &S::newton_limit, 1, 100000, "iterations in one solve")};
}

/// What the rest of `solver` must be with an engine that is not this process alone.
std::shared_ptr<StaticEngine> make_engine(Reader& solver, const StaticEngineKind& kind) {
  if (!kind.missing.empty()) solver.at("engine").fail("'" + kind.name + "': " + kind.missing);
  if (!kind.make) return nullptr;
  const std::string with = "does not go with engine: " + kind.name;
  if (const auto method = solver.find("method"); method && method->text() != "newton")
    method->fail("'" + method->text() + "' " + with + ", which goes by Newton's method");
  if (const auto linear = solver.find("linear_solver"))
    if (const std::string name = linear->text(); name == "direct" || name == "bicgstab")
      linear->fail("'" + name + "' " + with + "; allowed: automatic, pcg, multigrid");
  return kind.make();
}

}  // namespace

std::string path_next_to(const Reader& reader) {
  return (std::filesystem::path(reader.file_path()).parent_path() / reader.text()).lexically_normal().string();
}

StaticOptions read_solver(Reader reader, const Catalog& catalog) {
  SolverSetup setup = solver_map_keys(catalog).read(reader);
  if (setup.kind) setup.engine = make_engine(reader, **setup.kind);
  return setup;
}

std::vector<KeySection> strategy_keys(const Catalog& catalog) {
  return {{"stiffness", "Stiffness",
           "A word is a strategy's name: `lattice`, `\"calibrated:patch+volume\"`, `hencky_energy_membrane+wrinkling`. "
           "A map has the name and parameters:",
           strategy_map_keys(catalog).rows()}};
}

std::vector<KeySection> solver_keys(const Catalog& catalog) {
  return {{"solver", "Solver", "", solver_map_keys(catalog).rows()}};
}

}  // namespace elastin::lab
