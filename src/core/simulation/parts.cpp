#include "elastin/core/simulation/parts.h"

#include <utility>

#include "core/forces/bending.h"
#include "core/forces/volume.h"
#include "core/laws/springs/patch.h"
#include "core/simulation/fibres.h"
#include "elastin/core/forces/ties.h"
#include "elastin/core/model/parts.h"

namespace elastin {
namespace {

/// A part at work: by itself, as spring rules see it, and as what its cells are in the whole.
struct PartAtWork {
  const Material& material;
  const Strategy& law;  ///< of its cells
  CellRange triangles;  ///< of the whole that are the part's
  PartAlone alone;
  Body in_whole;  ///< with the part's cells only
};

/// What parts are made of, by Part::material, and the strategy that the cells of each part have.
struct Matter {
  std::vector<Material> materials;
  std::vector<Strategy> laws;
};

/// What the elasticities of the parts work on.
struct Works {
  Matter matter;
  std::vector<std::unique_ptr<const PartAtWork>> soft;
};

std::shared_ptr<const Works> works_of(const Body& whole, const Matter& matter) {
  auto works = std::make_shared<Works>();
  works->matter = matter;
  for (std::size_t number = 0; number < whole.parts.size(); ++number)
    if (const Part& part = whole.parts[number]; !part.rigid)
      works->soft.push_back(std::make_unique<const PartAtWork>(
          PartAtWork{works->matter.materials.at(part.material), works->matter.laws.at(number), part.triangles,
                     part_alone(whole, part), with_cells_of(whole, part)}));
  return works;
}

/// Of the kind of cells that the part has: a solid's law is its membrane's on a skin, and the other way round.
Strategy law_of(const Strategy& strategy, const Body& whole, const Part& part, const std::vector<Material>& materials,
                const Catalog* laws) {
  const Material& material = materials.at(part.material);
  if (!laws || part.rigid || strategy.kind != StrategyKind::cell_law) return strategy;
  const int dimensions = part.tetrahedra.count > 0 ? 3 : part.triangles.count > 0 ? 2 : strategy.dimensions;
  const bool own_law = states_own_law(material, materials);
  if (!own_law && dimensions == strategy.dimensions) return strategy;
  StrategyName name(strategy.name);
  name.rule = StrategyName::of_law(own_law ? material.law->law : name.law(), dimensions).rule;
  name.volume &= dimensions == 3;
  name.wrinkling &= dimensions == 2;
  try {
    Strategy own = laws->find(name.text());
    if (!name.volume || own.unsuited(part_alone(whole, part).body).empty()) return own;
  } catch (const InputError&) {
    if (!own_law) return strategy;  // which says what cells it needs
    if (!name.volume) throw;
  }
  name.volume = false;
  return laws->find(name.text());
}

/// Adds what a part has for its connections to those of the whole.
void spread(const PartAlone& alone, const VectorX& own, VectorX& whole) {
  for (std::size_t c = 0; c < alone.connections.size(); ++c)
    whole[alone.connections[c]] += own[static_cast<Eigen::Index>(c)];
}

VectorX spread(const PartAlone& alone, const VectorX& own, int connections) {
  VectorX whole = VectorX::Zero(connections);
  spread(alone, own, whole);
  return whole;
}

/// The springs of all parts: those without a curve in one.
void add_springs(const Strategy& strategy, const Body& whole, const Works& works, const ParameterValues& values,
                 ElasticTerms& terms) {
  VectorX straight = VectorX::Zero(whole.connections.size());
  for (const auto& part : works.soft) {
    const VectorX own = strategy.constants(part->alone.body, part->material, values);
    if (part->material.curve)
      terms.add(make_springs(whole, spread(part->alone, own, whole.connections.size()), part->material));
    else
      spread(part->alone, own, straight);
  }
  terms.add(make_springs(whole, std::move(straight)));
}

void add_updated_springs(const Strategy& strategy, const Body& whole, const std::shared_ptr<const Works>& works,
                         const ParameterValues& values, ElasticTerms& terms) {
  std::vector<ConstantsAt> rules;
  for (const auto& part : works->soft) rules.push_back(strategy.constants_at(part->alone.body, part->material, values));
  const int connections = whole.connections.size();
  terms.add(make_updated_springs(whole, [works, rules = std::move(rules), connections](const Positions& positions) {
    VectorX constants = VectorX::Zero(connections);
    for (std::size_t p = 0; p < rules.size(); ++p) {
      const PartAlone& alone = works->soft[p]->alone;
      spread(alone, rules[p](positions(Eigen::all, alone.molecules)), constants);
    }
    return constants;
  }));
}

/// The part's fibres, in addition to its law or its springs.
ElasticTerms fibres_of(const Strategy& strategy, const Body& whole, const PartAtWork& part) {
  if (!part.material.fibre || strategy.kind == StrategyKind::cell_law)
    return make_fibres(strategy, part.in_whole, part.material);
  const Body& body = part.alone.body;
  const VectorX sections = fibre_sections(*detail::proper_part(body), part.material.fibre->direction);
  return make_curve_springs(whole,
                            spread(part.alone, detail::with_cell_sides(sections, body), whole.connections.size()),
                            part.material.fibre->curve);
}

ElasticTerms make_in_parts(const Strategy& strategy, const Matter& matter, const Body& whole,
                           const ParameterValues& values) {
  const std::shared_ptr<const Works> works = works_of(whole, matter);
  ElasticTerms terms;
  terms.owners = {works};
  if (strategy.constants)
    add_springs(strategy, whole, *works, values, terms);
  else if (strategy.constants_at)
    add_updated_springs(strategy, whole, works, values, terms);
  terms.triangles.resize(terms.terms.size(), CellRange{0, static_cast<int>(whole.triangles.size())});
  for (const auto& part : works->soft) {
    if (strategy.kind == StrategyKind::cell_law)
      terms.add(part->law.make(part->in_whole, part->material, values));
    else if (strategy.volume_modulus)
      terms.add(make_volume(part->in_whole, strategy.volume_modulus(part->material)));
    terms.add(fibres_of(strategy, whole, *part));
    terms.triangles.resize(terms.terms.size(), part->triangles);
  }
  return terms;
}

/// Why the strategy cannot run on the first part on which it cannot, or "".
std::string unsuited_part(const Matter& matter, const Body& whole) {
  for (std::size_t number = 0; number < whole.parts.size(); ++number) {
    const Part& part = whole.parts[number];
    if (part.rigid) continue;
    const Strategy& strategy = matter.laws.at(number);
    const Body body = part_alone(whole, part).body;
    if (strategy.has_history && strategy.kind != StrategyKind::cell_law)
      return "springs that relax or soften take one body, not several";
    std::string why = strategy.calibrates ? strategy.unsuited(whole) : strategy.unsuited(body);
    if (why.empty()) why = material_unsuited(strategy, body, matter.materials.at(part.material));
    if (!why.empty()) return "body '" + part.name + "': " + why;
  }
  return "";
}

bool part_needs_voronoi(const Strategy& strategy, const std::vector<Material>& materials, const Body& whole) {
  for (const Part& part : whole.parts) {
    if (part.rigid || part.voronoi) continue;
    const Body body = part_alone(whole, part).body;
    if (strategy.needs_voronoi(body) || fibres_need_voronoi(strategy, body, materials.at(part.material))) return true;
  }
  return false;
}

}  // namespace

bool states_own_law(const Material& material, const std::vector<Material>& materials) {
  const auto& first = materials.front().law;
  return material.law && (!first || first->law != material.law->law);
}

Strategy in_parts(const Strategy& strategy, const Body& body, std::vector<Material> materials, const Catalog* laws) {
  if (body.parts.empty() || strategy.by_parts || strategy.kind == StrategyKind::wrapper) return strategy;
  Matter matter{materials, {}};
  for (const Part& part : body.parts) matter.laws.push_back(law_of(strategy, body, part, materials, laws));
  Strategy result = strategy;
  result.by_parts = true;
  result.make_without_volume = nullptr, result.make_without_compression = nullptr, result.constants_at = nullptr;
  result.unsuited = [matter](const Body& whole) { return unsuited_part(matter, whole); };
  result.needs_voronoi = [strategy, materials](const Body& whole) {
    return part_needs_voronoi(strategy, materials, whole);
  };
  if (strategy.constants)
    result.constants = [strategy, matter](const Body& whole, const Material&, const ParameterValues& values) {
      VectorX constants = VectorX::Zero(whole.connections.size());
      const std::shared_ptr<const Works> works = works_of(whole, matter);  // outlives the loop
      for (const auto& part : works->soft)
        spread(part->alone, strategy.constants(part->alone.body, part->material, values), constants);
      return constants;
    };
  result.make = [strategy, matter](const Body& whole, const Material&, const ParameterValues& values) {
    return make_in_parts(strategy, matter, whole, values);
  };
  return result;
}

void add_companions(Model& model, const Strategy& strategy, const Material& material) {
  const Body& body = model.body();
  if (!strategy.by_parts) model.add(make_fibres(strategy, body, material));
  if (material.bending_rigidity > 0) model.add(make_bending(body, material.bending_rigidity, material.poissons_ratio));
  if (!body.cables.empty()) model.add(make_cables(body));
  if (!body.ties.empty()) model.add(make_ties(body));
}

void fix_rigid_parts(Model& model) {
  std::vector<char> rigid(model.body().size(), 0);
  for (const Part& part : model.body().parts)
    if (part.rigid)
      for (const int molecule : molecules_of(part)) rigid[molecule] = 1;
  for (Support& support : model.supports)
    if (std::exchange(rigid[support.molecule], 0)) support.free.setZero();
  for (int molecule = 0; molecule < model.body().size(); ++molecule)
    if (rigid[molecule]) model.supports.push_back({molecule});
}

}  // namespace elastin
