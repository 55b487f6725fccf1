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
#include "elastin/core/laws/material_law.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/simulation/strategy_name.h"
#include "elastin/core/solve/engine.h"
#include "elastin/core/solve/stepper.h"

namespace elastin {

enum class StrategyKind {
  spring_rule,          ///< a constant for each connection, set once
  updated_spring_rule,  ///< constants updated at every evaluation
  cell_law,             ///< force densities from the lengths of each cell
  wrapper,              ///< changes another strategy: `calibrated`
};
const char* name_of(StrategyKind kind);

/// Springs that a rule is fitted to on a body, so that the body shows its material.
struct FittedSprings {
  VectorX constants;          ///< [N/m], one a connection
  double volume_modulus = 0;  ///< κ [Pa] of the rule's volume term, if it has one
  std::string remains = {};   ///< what the body shows otherwise than the material, in words; "" = nothing
};

/// One way to give a body its stiffness: what the catalog knows of a law, without the law's type.
struct Strategy : Descriptor {
  StrategyKind kind = StrategyKind::spring_rule;
  int dimensions = 0;          ///< of the cells of a cell law: 3 of a solid's, 2 of a membrane's
  bool follows_curve = false;  ///< whether it takes the material's stress-strain curve, not its first slope alone
  /// Why it cannot run on a body, or "".
  std::function<std::string(const Body&)> unsuited = [](const Body&) { return std::string(); };
  /// Cell laws with constants of their own: their row among the material laws; else "".
  std::string law;
  /// That row of a law that a program makes as it runs (see make_energy_law), which Catalog::add adds; else null.
  std::shared_ptr<const MaterialLaw> own_law;
  /// Why it cannot take this material, or "": a law whose constants the material lacks. See material_unsuited.
  std::function<std::string(const Material&)> unsuited_material = [](const Material&) { return std::string(); };
  /// Whether it needs the Voronoi cells of this body (Body::voronoi).
  std::function<bool(const Body&)> needs_voronoi = [](const Body&) { return false; };
  bool needs_faces = false;  ///< whether its springs stand for faces between molecules: one without a spring is lost
  bool takes_scale = false;  ///< whether only the ratios of its constants have a meaning, their size being a parameter
  bool joins_molecules = false;  ///< whether a constant depends on all molecules: a share of a body is not enough
  /// Spring rules only: the constants [N/m]. Throws InputError on parameters out of range or unknown.
  std::function<VectorX(const Body&, const Material&, const ParameterValues&)> constants;
  /// Updated spring rules only: the function that gives the constants [N/m]. The body must outlive it.
  std::function<ConstantsAt(const Body&, const Material&, const ParameterValues&)> constants_at;
  /// What the strategy adds to a model, without the material's fibres (see fibres.h). The body must outlive it. Empty
  /// for wrappers.
  using Make = std::function<ElasticTerms(const Body&, const Material&, const ParameterValues&)>;
  Make make;
  /// Cell laws that can leave λ/2 (J − 1)² to a volume term: the law without it.
  Make make_without_volume;
  /// Laws of solids that can be split: on blocks, with the volume kept by pressures of the whole cell.
  Make make_mixed;
  /// Membrane laws whose compression can be dropped: the law without it.
  Make make_without_compression;
  /// With a volume term (see with_volume): its modulus κ [Pa]. Else empty. Throws InputError unless 0 ≤ ν ≤ 0.4999.
  std::function<double(const Material&)> volume_modulus;
  bool relaxes = false;      ///< whether its stress relaxes (see with_relaxation)
  bool has_history = false;  ///< whether its past counts: it relaxes, or softens (see with_softening)
  bool by_parts = false;     ///< whether it works on each part of a body by itself, fibres included; see in_parts
  /// The rule that it fits to the material on each body, and how; else null (see calibrated, fitted).
  std::shared_ptr<const Strategy> calibrates;
  std::function<FittedSprings(const Body&, const Material&, const ParameterValues&)> fit;
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

/// A strategy whose stress relaxes as Material::relaxation says (see make_prony), named "prony:NAME". Fibres next to it
/// do not relax. Throws InputError for one that relaxes already.
Strategy with_relaxation(const Strategy& strategy);

/// A strategy that softens where it has been strained before, as Material::softening says (see make_mullins), named
/// "mullins:NAME". Springs are taken as rods of the material; fibres and volume terms next to it do not soften. Throws
/// InputError for one that has no energy, that softens already, or that relaxes: prony:mullins:NAME.
Strategy with_softening(const Strategy& strategy);

/// A spring rule fitted to the material on each body, named "calibrated:RULE": its constants times E / E of the body;
/// with a volume term both, to E and ν, ν to 0.001 where it can be reached. E and ν of the body are the means over all
/// directions of its homogenised stiffness, six linear solves under small strains of its surface (see homogenise), as
/// the experiment `material` of a scene measures them; a scene calibrates in its own experiment instead.
/// Its make and constants throw InputError on a body that is neither of tetrahedra nor a box along the axes, or is a
/// mechanism; bodies of several parts and bodies with regions are unsuited. Throws InputError for what is no spring
/// rule, or is calibrated already.
Strategy calibrated(const Strategy& rule);

/// A spring rule of which every constant is fitted on each body, named "fitted:RULE": k ≥ 0 with which the body shows
/// E, G and ν of an isotropic material in all directions, in six small strains of its surface (see homogenise) and,
/// where it is a box along the axes, in tension along x, y and z; as near as possible to those of calibrated(rule), by
/// |ln k/k_calibrated|. Six uniform stresses of the surface, whose moduli bound those of every other test from below as
/// the strains' do from above [Huet 1990], are met as far as that leaves it free. Every measure is an energy, so that
/// its derivative by a constant is the product of the connection's own elongations: no more solves. Gauss–Newton,
/// damped; some 12 to 21 linear solves a step. Springs alone are fitted to E and the Cauchy relation's ν = ¼, with a
/// volume term to E and ν. Constants that are 0 or below begin at a hundredth of the mean. Bodies and errors as for
/// calibrated().
Strategy fitted(const Strategy& rule);

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

/// What every law says of itself.
template <class Law>
Strategy described_strategy() {
  Strategy strategy;
  strategy.name = Law::name;
  strategy.summary = Law::summary;
  strategy.source = Law::source;
  strategy.parameters = describe_parameters<Law>();
  if constexpr (requires(const Body& body) { Law::unsuited(body); })
    strategy.unsuited = [](const Body& body) { return Law::unsuited(*seen_by<Law>(body)); };
  if constexpr (requires(const Body& body) { Law::needs_voronoi(body); }) strategy.needs_voronoi = &Law::needs_voronoi;
  if constexpr (requires { Law::follows_curve; }) strategy.follows_curve = Law::follows_curve;
  if constexpr (requires { Law::needs_faces; }) strategy.needs_faces = Law::needs_faces;
  if constexpr (requires { Law::takes_scale; }) strategy.takes_scale = Law::takes_scale;
  if constexpr (requires { Law::joins_molecules; }) strategy.joins_molecules = Law::joins_molecules;
  return strategy;
}

template <class Law>
Strategy spring_strategy() {
  Strategy strategy = described_strategy<Law>();
  const Strategy described = strategy;  // what the functions below need of it, without a pointer to a moving vector
  if constexpr (SpringRule<Law>) {
    strategy.kind = StrategyKind::spring_rule;
    strategy.follows_curve = true;
    strategy.constants = [described](const Body& body, const Material& material,
                                     const ParameterValues& values) -> VectorX {
      const Law law = law_with<Law>(described, values);
      return with_cell_sides(law.constants(*seen_by<Law>(body), material), body);
    };
    strategy.make = [constants = strategy.constants](const Body& body, const Material& material,
                                                     const ParameterValues& values) {
      return make_springs(body, constants(body, material, values), material);
    };
  } else {
    strategy.kind = StrategyKind::updated_spring_rule;
    strategy.constants_at = [described](const Body& body, const Material& material,
                                        const ParameterValues& values) -> ConstantsAt {
      return [law = law_with<Law>(described, values), &body, material,
              seen = seen_by<Law>(body)](const Positions& positions) {
        return with_cell_sides(law.constants(*seen, material, positions), body);
      };
    };
    strategy.make = [at = strategy.constants_at](const Body& body, const Material& material,
                                                 const ParameterValues& values) {
      return make_updated_springs(body, at(body, material, values));
    };
  }
  return strategy;
}

/// make(body, material, law) of the law with its parameters.
template <class Law, class Make>
Strategy::Make made_by(const Strategy& described, Make make) {
  return [described, make](const Body& body, const Material& material, const ParameterValues& values) {
    return ElasticTerms(make(body, material, law_with<Law>(described, values)));
  };
}

/// A law on the cells of these dimensions.
template <int cell_dimensions, class Law>
Strategy cell_strategy() {
  Strategy strategy = described_strategy<Law>();
  strategy.kind = StrategyKind::cell_law;
  strategy.dimensions = cell_dimensions;
  if (!requires(const Body& body) { Law::unsuited(body); }) strategy.unsuited = &no_cells<cell_dimensions>;
  if constexpr (ConstantsLaw<Law>) {
    strategy.law = Law::name;
    if (!Law::constants().from_moduli)
      strategy.unsuited_material = [](const Material& material) {
        return law_unsuited(Law::name, cell_dimensions == 3, material);
      };
  }
  return strategy;
}

/// A law that is a kernel itself, on the one shape whose lengths it knows.
template <class Law>
Strategy length_strategy() {
  Strategy strategy = cell_strategy<Law::Shape::dimensions, Law>();
  strategy.make = made_by<Law>(strategy, [](const Body& body, const Material& material, Law law) {
    return std::make_unique<CellElasticity<Law>>(body, material, std::move(law));
  });
  return strategy;
}

template <class Law>
Strategy solid_strategy() {
  Strategy strategy = cell_strategy<3, Law>();
  strategy.make = made_by<Law>(strategy, &make_cells<3, Law>);
  if constexpr (requires(Law law) { law.volume_apart = true; })
    strategy.make_without_volume = made_by<Law>(strategy, [](const Body& body, const Material& material, Law law) {
      law.volume_apart = true;
      return make_cells<3>(body, material, law);
    });
  if constexpr (SplitLaw<Law>)
    strategy.make_mixed = made_by<Law>(strategy, [](const Body& body, const Material& material, const Law& law) {
      return make_mixed_blocks(body, material, [&](const Material& own) {
        auto [shape, volume] = law.split(own);
        return SplitPoint<AnyPoint<3>>{AnyPoint<3>(std::move(shape)), volume};
      });
    });
  return strategy;
}

template <class Law>
Strategy membrane_strategy() {
  Strategy strategy = cell_strategy<2, Law>();
  strategy.name = StrategyName::of_law(strategy.name, 2).text();
  if constexpr (requires { Law::membrane_summary; }) strategy.summary = Law::membrane_summary;
  if constexpr (requires { Law::membrane_source; }) strategy.source = Law::membrane_source;
  strategy.make = made_by<Law>(strategy, &make_cells<2, Law>);
  if constexpr (requires(const Law& law, const Material& m) { law.membrane(m).without_compression(m); })
    strategy.make_without_compression =
        made_by<Law>(strategy, [](const Body& body, const Material& material, const Law& law) {
          return make_cells<2>(body, material, WithoutCompression<Law>{law});
        });
  return strategy;
}
}  // namespace detail

/// Everything pluggable, by name. Filled explicitly: a program may add its own laws to its own catalog.
class Catalog {
 public:
  /// Adds a spring rule, an updated one or a cell law; its name must be new. Strong guarantee. A law of solids and of
  /// membranes makes a strategy of each, NAME and NAME_membrane; one with constants of its own is a row of
  /// material_laws too.
  template <class Law>
  requires SpringRule<Law> || UpdatedSpringRule<Law> || CellLaw<Law>
  void add();
  /// Adds a strategy that the caller describes in full.
  void add(Strategy strategy);

  const std::vector<Strategy>& strategies() const { return strategies_; }
  /// A strategy of this catalog with the properties that its name states. Throws InputError with the nearest name and
  /// the list of all, or as with_volume, with_wrinkling, calibrated, fitted, with_softening and with_relaxation do.
  Strategy find(const StrategyName& name) const;
  /// The same of a name as a scene writes it; a row of the catalog may have any name.
  Strategy find(const std::string& name) const;
  std::vector<std::string> names() const;

  /// What scenes may name besides: to begin with what comes with Elastin.
  Table<StepperKind> steppers = built_in_steppers();
  Table<LinearSolverKind> linear_solvers = built_in_linear_solvers();
  Table<LoadKind> loads = built_in_loads();
  Table<StaticEngineKind> engines = built_in_engines();
  /// The laws among the strategies that have constants of their own; add() adds them.
  Table<MaterialLaw> material_laws{"material law"};

 private:
  const Strategy* named(const std::string& name) const;  // null: no such row
  [[noreturn]] void refuse(const StrategyName& name) const;
  std::vector<Strategy> strategies_;
};

/// The strategies that come with Elastin.
Catalog built_in_catalog();

template <class Law>
requires SpringRule<Law> || UpdatedSpringRule<Law> || CellLaw<Law>
void Catalog::add() {
  if constexpr (CellLaw<Law>) {
    if constexpr (LengthLaw<Law>) add(detail::length_strategy<Law>());
    if constexpr (SolidLaw<Law>) add(detail::solid_strategy<Law>());
    if constexpr (MembraneLaw<Law>) add(detail::membrane_strategy<Law>());
    if constexpr (ConstantsLaw<Law>) material_laws.add(material_law<Law>());
  } else {
    add(detail::spring_strategy<Law>());
  }
}

}  // namespace elastin
