#include "elastin/core/simulation/catalog.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/base/named.h"
#include "core/forces/volume.h"
#include "core/laws/membranes/hencky_energy_membrane.h"
#include "core/laws/membranes/hencky_membrane.h"
#include "core/laws/membranes/two_parameter.h"
#include "core/laws/solids/arruda_boyce.h"
#include "core/laws/solids/curve.h"
#include "core/laws/solids/fung_orthotropic.h"
#include "core/laws/solids/holzapfel_gasser_ogden.h"
#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/neo_hookean.h"
#include "core/laws/solids/neo_hookean_log.h"
#include "core/laws/solids/ogden.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "core/laws/solids/transversely_isotropic.h"
#include "core/laws/solids/veronda_westmann.h"
#include "core/laws/solids/yeoh.h"
#include "core/laws/springs/angles.h"
#include "core/laws/springs/angles_update.h"
#include "core/laws/springs/divided.h"
#include "core/laws/springs/lattice.h"
#include "core/laws/springs/lloyd.h"
#include "core/laws/springs/patch.h"
#include "core/laws/springs/standard.h"
#include "core/laws/springs/statistical.h"
#include "core/laws/springs/uniform.h"
#include "core/laws/springs/van_gelder.h"
#include "core/laws/springs/van_gelder_simplified.h"
#include "core/laws/springs/voronoi.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/forces/prony.h"

namespace elastin {

Catalog built_in_catalog() {
  Catalog catalog;
  catalog.add<Standard>();
  catalog.add<Divided>();
  catalog.add<Angles>();
  catalog.add<AnglesUpdate>();
  catalog.add<Statistical>();
  catalog.add<VanGelder>();
  catalog.add<VanGelderSimplified>();
  catalog.add<Lloyd>();
  catalog.add<Lattice>();
  catalog.add<Voronoi>();
  catalog.add<Patch>();
  catalog.add<Uniform>();
  catalog.add<StVenantKirchhoff>();
  catalog.add<NeoHookean>();
  catalog.add<Curve>();
  catalog.add<Hencky>();
  catalog.add<HenckyEnergy>();
  catalog.add<TwoParameter>();
  catalog.add<NeoHookeanLog>();
  catalog.add<MooneyRivlin>();
  catalog.add<Yeoh>();
  catalog.add<Ogden>();
  catalog.add<ArrudaBoyce>();
  catalog.add<VerondaWestmann>();
  catalog.add<FungOrthotropic>();
  catalog.add<TransverselyIsotropic>();
  catalog.add<HolzapfelGasserOgden>();
  const auto add_wrapper = [&](const char* name, const char* summary, const char* source) {
    Strategy wrapper;
    wrapper.name = name;
    wrapper.summary = summary;
    wrapper.source = source;
    wrapper.kind = StrategyKind::wrapper;
    catalog.add(std::move(wrapper));
  };
  add_wrapper("calibrated", "any spring rule, times E / E measured by one linear solve of the scene: calibrated:RULE",
              "[M03]'s divisor found by hand, made automatic");
  add_wrapper("fitted", "any spring rule, every constant fitted by itself: E, G and nu in all directions: fitted:RULE",
              "Gauss-Newton on energies under uniform strains, stresses [Huet 1990] and tension");
  add_wrapper("prony", "any strategy on springs or cells of any shape, with the material's relaxation: prony:NAME",
              "quasi-linear viscoelasticity [Fung 1981], recursion of [Taylor, Pister & Goudreau 1970]");
  add_wrapper("mullins", "any strategy with an energy, softer where it has been strained before: mullins:NAME",
              "[Ogden & Roxburgh 1999]");
  add_wrapper("volume",
              "any spring rule or neo_hookean on a solid, with a volume term: nu from 0 to 0.4999: RULE+volume",
              "Bonet & Burton 1998, averaged nodal volumes");
  add_wrapper("wrinkling", "a membrane law without compressive stress (tension field): LAW+wrinkling",
              "[Pipkin 1986] relaxed energy");
  return catalog;
}

namespace {

double volume_modulus(const Material& material, bool of_springs) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  if (!(nu >= 0 && nu <= 0.4999)) {
    char text[300];
    if (material.law) {
      // K/G = 2 (1 + ν) / (3 (1 − 2 ν)), of the law at rest.
      const double shear = E / (2 * (1 + nu)), bulk = E / (3 * (1 - 2 * nu));
      std::snprintf(text, sizeof text,
                    "a bulk modulus of %.6g Pa is out of range: the volume term (+volume) takes %.6g to %.6g Pa with "
                    "the shear modulus of this law at rest, %.6g Pa (Poisson's ratios 0 to 0.4999)",
                    bulk, 2 * shear / 3, 2 * shear * 1.4999 / (3 * 0.0002), shear);
    } else {
      std::snprintf(text, sizeof text, "poissons_ratio %.9g is out of range: a volume term takes 0 to 0.4999", nu);
    }
    throw InputError(text);
  }
  return E / ((1 + nu) * (1 - 2 * nu)) * (of_springs ? (4 * nu - 1) / 2 : nu);
}

/// The material whose springs have the prescribed material's shear modulus.
Material shear_material(Material material) {
  material.youngs_modulus *= 1.25 / (1 + material.poissons_ratio);
  return material;
}

/// The strategy's name with one more property.
std::string renamed(const Strategy& strategy, bool StrategyName::*property) {
  StrategyName name(strategy.name);
  name.*property = true;
  return name.text();
}

}  // namespace

Strategy with_volume(const Strategy& strategy) {
  const bool springs = strategy.kind == StrategyKind::spring_rule || strategy.kind == StrategyKind::updated_spring_rule;
  if (strategy.volume_modulus) throw InputError("'" + strategy.name + "' has a volume term already");
  if (strategy.has_history)
    throw InputError("'" + strategy.name + "': write the volume term behind the rule: prony:RULE+volume");
  if (!springs && !strategy.make_without_volume && !strategy.make_mixed)
    throw InputError("'" + strategy.name +
                     "': a volume term goes with a spring rule, neo_hookean or a law with a bulk_modulus");
  Strategy result = strategy;
  result.name = renamed(strategy, &StrategyName::volume);
  result.summary += "; with a volume term";
  result.make_without_volume = nullptr;
  result.volume_modulus = [springs](const Material& material) { return volume_modulus(material, springs); };
  result.unsuited = [strategy, springs](const Body& body) {
    const std::string why = strategy.unsuited(body);
    if (!why.empty()) return why;
    if (has_blocks(body, 3) && strategy.make_mixed) return std::string();
    if (!springs && !strategy.make_without_volume)
      return std::string("needs hexahedra or cells of second order for the pressures that keep its volume");
    return unsuited_for_volumes(body);
  };
  if (strategy.constants)
    result.constants = [strategy](const Body& body, const Material& material, const ParameterValues& values) {
      return strategy.constants(body, shear_material(material), values);
    };
  if (strategy.constants_at)
    result.constants_at = [strategy](const Body& body, const Material& material, const ParameterValues& values) {
      return strategy.constants_at(body, shear_material(material), values);
    };
  result.make = [strategy, springs, modulus = result.volume_modulus](const Body& body, const Material& material,
                                                                     const ParameterValues& values) {
    if (has_blocks(body, 3) && strategy.make_mixed) return strategy.make_mixed(body, material, values);
    ElasticTerms terms;
    if (strategy.constants)  // softer or stiffer springs, on the material's own curve
      terms = make_springs(body, strategy.constants(body, shear_material(material), values), material);
    else
      terms = springs ? strategy.make(body, shear_material(material), values)
                      : strategy.make_without_volume(body, material, values);
    terms.add(make_volume(body, modulus(material)));
    return terms;
  };
  return result;
}

namespace {

/// A wrapper of a strategy's elasticity, without the strategy's constants and terms.
Strategy wrapped(bool StrategyName::*property, const Strategy& strategy) {
  Strategy result = strategy;
  result.name = renamed(strategy, property);
  result.constants = nullptr, result.constants_at = nullptr, result.calibrates = nullptr;
  result.fit = nullptr;
  result.make_without_compression = nullptr;
  result.has_history = true;
  return result;
}

}  // namespace

Strategy with_relaxation(const Strategy& strategy) {
  if (strategy.relaxes) throw InputError("'" + strategy.name + "' relaxes already");
  Strategy result = wrapped(&StrategyName::relaxed, strategy);
  result.summary += "; its stress relaxes";
  result.relaxes = true;
  result.unsuited_material = [strategy](const Material& material) {
    if (!material.relaxation) return std::string("needs `relaxation` in the material");
    return strategy.unsuited_material(material);
  };
  result.make = [strategy](const Body& body, const Material& material, const ParameterValues& values) {
    if (!material.relaxation) throw InputError("'prony:" + strategy.name + "': the material has no relaxation");
    return make_prony(body, strategy.make(body, material, values), *material.relaxation);
  };
  return result;
}

Strategy with_softening(const Strategy& strategy) {
  if (strategy.relaxes) throw InputError("'mullins:" + strategy.name + "': what softens may relax: prony:mullins:NAME");
  if (strategy.has_history) throw InputError("'" + strategy.name + "' softens already");
  if (strategy.kind == StrategyKind::updated_spring_rule)
    throw InputError("'mullins:" + strategy.name + "': softening goes by the energy of a law, and this one has none");
  Strategy result = wrapped(&StrategyName::softened, strategy);
  result.summary += "; softer where it has been strained before";
  result.unsuited_material = [strategy](const Material& material) {
    if (!material.softening) return std::string("needs `softening` in the material");
    return strategy.unsuited_material(material);
  };
  result.make = [strategy](const Body& body, const Material& material, const ParameterValues& values) {
    if (!material.softening) throw InputError("'mullins:" + strategy.name + "': the material has no softening");
    Material own = material;
    if (strategy.kind == StrategyKind::spring_rule && !own.curve)
      own.curve = StressStrain::linear(own.youngs_modulus);  // springs as rods of the material have an energy density
    if (strategy.dimensions == 2) own.softening->m *= own.thickness;  // energies of membranes are per area
    return make_mullins(strategy.make(body, own, values), *own.softening);
  };
  return result;
}

Strategy with_wrinkling(const Strategy& strategy) {
  if (StrategyName(strategy.name).wrinkling) throw InputError("'" + strategy.name + "' drops compression already");
  if (!strategy.make_without_compression)
    throw InputError("'" + strategy.name +
                     "': compression can be dropped from st_venant_kirchhoff_membrane, hencky_energy_membrane, "
                     "neo_hookean_membrane and curve_membrane");
  Strategy result = strategy;
  result.name = renamed(strategy, &StrategyName::wrinkling);
  result.summary += "; without compression";
  result.make = strategy.make_without_compression;
  result.make_without_compression = nullptr;
  return result;
}

Strategy make_spring_rule(const std::string& name, RuleConstants constants, std::vector<ParameterInfo> parameters) {
  Strategy rule;
  rule.name = name;
  rule.parameters = std::move(parameters);
  rule.follows_curve = true;
  rule.constants = [described = rule, constants = std::move(constants)](const Body& body, const Material& material,
                                                                        const ParameterValues& given) {
    const ParameterValues values = complete_values(described.name, described.parameters, given);
    std::shared_ptr<const Body> seen = detail::proper_part(body);
    if (seen->connection_stiffness.size()) {  // or a rule that asks another would count it twice
      auto plain = std::make_shared<Body>(*seen);
      plain->connection_stiffness.resize(0);
      seen = std::move(plain);
    }
    const VectorX own = constants(*seen, material, values);
    if (own.size() != seen->connections.size())
      throw InputError("strategy " + described.name + " gives " + std::to_string(own.size()) +
                       " constants; allowed: " + std::to_string(seen->connections.size()) + ", one a connection");
    return detail::with_cell_sides(own, body);
  };
  rule.make = [constants = rule.constants](const Body& body, const Material& material, const ParameterValues& values) {
    return make_springs(body, constants(body, material, values), material);
  };
  return rule;
}

const char* name_of(StrategyKind kind) {
  switch (kind) {
    case StrategyKind::spring_rule:
      return "spring rule";
    case StrategyKind::updated_spring_rule:
      return "spring rule, updated";
    case StrategyKind::cell_law:
      return "cell law";
    case StrategyKind::wrapper:
      return "wrapper";
  }
  return "";
}

void Catalog::add(Strategy strategy) {
  for (const Strategy& other : strategies_)
    if (other.name == strategy.name) throw InputError("the catalog has a strategy '" + strategy.name + "' already");
  if (strategy.own_law) material_laws.add(*strategy.own_law);
  strategies_.push_back(std::move(strategy));
}

Strategy Catalog::find(const std::string& name) const { return named(name) ? *named(name) : find(StrategyName(name)); }

Strategy Catalog::find(const StrategyName& name) const {
  const Strategy* const rule = named(name.rule);
  if (!rule) refuse(name);
  Strategy strategy = *rule;
  if (name.volume) strategy = with_volume(strategy);
  if (name.wrinkling) strategy = with_wrinkling(strategy);
  if (name.fitted) strategy = fitted(strategy);
  if (name.calibrated) strategy = calibrated(strategy);
  if (name.softened) strategy = with_softening(strategy);
  return name.relaxed ? with_relaxation(strategy) : strategy;
}

const Strategy* Catalog::named(const std::string& name) const {
  for (const Strategy& strategy : strategies_)
    if (strategy.name == name && strategy.kind != StrategyKind::wrapper) return &strategy;
  return nullptr;
}

void Catalog::refuse(const StrategyName& name) const {
  name.check();
  const std::string& rule = name.rule;
  if (find_named(strategies_, rule))
    throw InputError("'" + rule + "' goes with a " +
                     (rule == "wrinkling"                    ? "membrane law: hencky_energy_membrane+wrinkling"
                      : rule == "prony" || rule == "mullins" ? "strategy: " + rule + ":lattice"
                                                             : "rule: lattice+" + rule));
  throw InputError("unknown strategy '" + rule + "'" + suggestion(rule, names()));
}

std::vector<std::string> Catalog::names() const { return names_of(strategies_); }

namespace detail {

std::shared_ptr<const Body> proper_part(const Body& body) {
  if (body.connections.cell_sides == 0) return {std::shared_ptr<void>(), &body};
  return std::make_shared<const Body>(without_cell_sides(body));
}

VectorX with_cell_sides(VectorX constants, const Body& body) {
  constants.conservativeResizeLike(VectorX::Zero(body.connections.size()));
  if (body.connection_stiffness.size()) constants = constants.cwiseProduct(body.connection_stiffness).eval();
  return constants;
}

const ParameterInfo& checked_parameter(const Strategy& strategy, const std::string& name, double value) {
  return elastin::checked_parameter(strategy.name, strategy.parameters, name, value);
}

}  // namespace detail
}  // namespace elastin
