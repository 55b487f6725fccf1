#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/forces/cells.h"
#include "elastin/core/forces/elasticity.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/laws/law.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/solve/integrator.h"

namespace elastin {

enum class StrategyKind {
  spring_rule,          ///< a constant for each connection, set once
  updated_spring_rule,  ///< constants set anew at every evaluation
  cell_law,             ///< force densities from the lengths of each cell
  wrapper,              ///< changes another strategy: `calibrated`
};
const char* name_of(StrategyKind kind);

/// One way to give a body its stiffness: what the catalog knows of a law, without the law's type.
struct Strategy : Descriptor {
  StrategyKind kind = StrategyKind::spring_rule;
  int corners = 0;             ///< of the cells of a cell law
  bool follows_curve = false;  ///< whether it takes the material's stress-strain curve, not its first slope alone
  /// Why it cannot run on a body, or "".
  std::function<std::string(const Body&)> unsuited = [](const Body&) { return std::string(); };
  /// Whether it needs the Voronoi cells of this body (Body::voronoi).
  std::function<bool(const Body&)> needs_voronoi = [](const Body&) { return false; };
  /// Spring rules only: the constants [N/m]. Throws InputError on parameters out of range or unknown.
  std::function<VectorX(const Body&, const Material&, const ParameterValues&)> constants;
  /// Updated spring rules only: the function that gives the constants [N/m]. The body must outlive it.
  std::function<ConstantsAt(const Body&, const Material&, const ParameterValues&)> constants_at;
  /// The strategy at work, without the material's fibres (see fibres.h). The body must outlive it. Empty for wrappers.
  using Make = std::function<std::unique_ptr<Elasticity>(const Body&, const Material&, const ParameterValues&)>;
  Make make;
  /// Cell laws that can leave λ/2 (J − 1)² to a volume term: the law without it.
  Make make_without_volume;
  /// Membrane laws whose compression can be dropped: the law without it.
  Make make_without_compression;
  /// With a volume term (see with_volume): its modulus κ [Pa]. Else empty. Throws InputError unless 0 ≤ ν ≤ 0.4999.
  std::function<double(const Material&)> volume_modulus;
  bool by_parts = false;  ///< whether it works on each part of a body by itself, fibres included; see in_parts
};

/// A strategy with a volume term (see make_volume), named "NAME+volume": any Poisson's ratio from 0 to 0.4999, without
/// locking. Throws InputError for a strategy that cannot have one.
///   * Spring rules: springs alone have λ = μ, so theirs are scaled from E to μ = E/(2(1+ν)), by 1.25/(1+ν), and the
///     volume term brings the rest of λ: κ = λ − μ = E (4ν−1)/(2(1+ν)(1−2ν)).
///   * neo_hookean: κ = λ, on the mean volume around each molecule instead of every cell's own.
Strategy with_volume(const Strategy& strategy);

/// A membrane law that bears no compression, named "NAME+wrinkling": where it would be pressed it wrinkles, see
/// TensionField. Throws InputError for a strategy that cannot.
Strategy with_wrinkling(const Strategy& strategy);

/// A spring rule that a program makes as it runs, as Catalog::add makes one of a type: `constants` [N/m], one a
/// connection of the body that it is shown (Connections::proper), with a value for each of the parameters; regions that
/// are stiffer multiply them afterwards. A wrong number of constants throws InputError.
using RuleConstants = std::function<VectorX(const Body&, const Material&, const ParameterValues&)>;
Strategy make_spring_rule(const std::string& name, RuleConstants constants, std::vector<ParameterInfo> parameters = {});

namespace detail {
/// Finds a parameter by name and checks a value against its range; throws InputError naming what is allowed.
const ParameterInfo& checked_parameter(const Strategy& strategy, const std::string& name, double value);

template <class Law>
std::vector<ParameterInfo> describe_parameters() {
  std::vector<ParameterInfo> infos;
  if constexpr (requires { Law::parameters; })
    for (const auto& p : Law::parameters)
      infos.push_back({std::string(p.name), p.unit, p.low, p.high, Law{}.*p.value, std::string(p.text)});
  return infos;
}

/// The body as a rule sees it that does not work on cells: itself, or a copy without the sides of cells. `body` must
/// outlive it.
std::shared_ptr<const Body> proper_part(const Body& body);
/// The constants of the sides of cells only are zero, those in stiffer regions of the body larger.
VectorX with_cell_sides(VectorX constants, const Body& body);

template <class Law>
constexpr bool works_on_cells() {
  if constexpr (requires { Law::on_cells; })
    return Law::on_cells;
  else
    return CellLaw<Law>;
}

/// The body as the law sees it.
template <class Law>
std::shared_ptr<const Body> seen_by(const Body& body) {
  return works_on_cells<Law>() ? std::shared_ptr<const Body>(std::shared_ptr<void>(), &body) : proper_part(body);
}

template <class Law>
Law law_with(const Strategy& strategy, const ParameterValues& values) {
  Law law;
  for (const auto& [name, value] : values) {
    checked_parameter(strategy, name, value);
    if constexpr (requires { Law::parameters; })
      for (const auto& p : Law::parameters)
        if (p.name == name) law.*p.value = value;
  }
  return law;
}
}  // namespace detail

/// Everything pluggable, by name. Filled explicitly: a program may add its own laws to its own catalog.
class Catalog {
 public:
  /// Adds a spring rule, an updated one or a cell law; its name must be new. Strong guarantee.
  template <class Law>
  requires SpringRule<Law> || UpdatedSpringRule<Law> || CellLaw<Law>
  void add();
  /// Adds a strategy that the caller describes in full.
  void add(Strategy strategy);

  const std::vector<Strategy>& strategies() const { return strategies_; }
  /// Throws InputError with the nearest name and the list of what there is.
  const Strategy& find(const std::string& name) const;
  std::vector<std::string> names() const;

  /// What scenes may name besides: to begin with what comes with Elastin.
  Table<Stepper> steppers = built_in_steppers();
  Table<LinearSolverKind> linear_solvers = built_in_linear_solvers();
  Table<LoadKind> loads = built_in_loads();

 private:
  std::vector<Strategy> strategies_;
};

/// The strategies that come with Elastin.
Catalog built_in_catalog();

template <class Law>
requires SpringRule<Law> || UpdatedSpringRule<Law> || CellLaw<Law>
void Catalog::add() {
  Strategy strategy;
  strategy.name = Law::name;
  strategy.summary = Law::summary;
  strategy.source = Law::source;
  strategy.parameters = detail::describe_parameters<Law>();
  if constexpr (requires(const Body& body) { Law::unsuited(body); })
    strategy.unsuited = [](const Body& body) { return Law::unsuited(*detail::seen_by<Law>(body)); };
  if constexpr (requires(const Body& body) { Law::needs_voronoi(body); }) strategy.needs_voronoi = &Law::needs_voronoi;
  const Strategy described = strategy;  // what the two functions below need of it, without a pointer to a moving vector
  if constexpr (SpringRule<Law>) {
    strategy.kind = StrategyKind::spring_rule;
    strategy.follows_curve = true;
    strategy.constants = [described](const Body& body, const Material& material,
                                     const ParameterValues& values) -> VectorX {
      const Law law = detail::law_with<Law>(described, values);
      return detail::with_cell_sides(law.constants(*detail::seen_by<Law>(body), material), body);
    };
    strategy.make = [constants = strategy.constants](const Body& body, const Material& material,
                                                     const ParameterValues& values) {
      return make_springs(body, constants(body, material, values), material);
    };
  } else if constexpr (UpdatedSpringRule<Law>) {
    strategy.kind = StrategyKind::updated_spring_rule;
    strategy.constants_at = [described](const Body& body, const Material& material,
                                        const ParameterValues& values) -> ConstantsAt {
      return [law = detail::law_with<Law>(described, values), &body, material,
              seen = detail::seen_by<Law>(body)](const Positions& positions) {
        return detail::with_cell_sides(law.constants(*seen, material, positions), body);
      };
    };
    strategy.make = [at = strategy.constants_at](const Body& body, const Material& material,
                                                 const ParameterValues& values) {
      return make_updated_springs(body, at(body, material, values));
    };
  } else {
    strategy.kind = StrategyKind::cell_law;
    strategy.corners = Law::corners;
    if constexpr (requires { Law::follows_curve; }) strategy.follows_curve = Law::follows_curve;
    strategy.make = [described](const Body& body, const Material& material,
                                const ParameterValues& values) -> std::unique_ptr<Elasticity> {
      return std::make_unique<CellElasticity<Law>>(body, material, detail::law_with<Law>(described, values));
    };
    if constexpr (requires { typename Law::WithoutCompression; })
      strategy.make_without_compression = [](const Body& body, const Material& material,
                                             const ParameterValues&) -> std::unique_ptr<Elasticity> {
        using Relaxed = typename Law::WithoutCompression;
        return std::make_unique<CellElasticity<Relaxed>>(body, material, Relaxed{});
      };
    if constexpr (requires(Law law) { law.volume_apart = true; })
      strategy.make_without_volume = [described](const Body& body, const Material& material,
                                                 const ParameterValues& values) -> std::unique_ptr<Elasticity> {
        Law law = detail::law_with<Law>(described, values);
        law.volume_apart = true;
        return std::make_unique<CellElasticity<Law>>(body, material, std::move(law));
      };
  }
  add(std::move(strategy));
}

}  // namespace elastin
