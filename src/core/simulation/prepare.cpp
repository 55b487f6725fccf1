#include "elastin/core/simulation/prepare.h"

#include <algorithm>

#include "core/forces/bending.h"
#include "core/model/check_indices.h"
#include "core/simulation/fibres.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"

namespace elastin {
namespace {

const Material& material_of(const std::vector<Material>& materials, int number, const std::string& whose) {
  if (number < 0 || static_cast<std::size_t>(number) >= materials.size())
    throw InputError(whose + " has material " + std::to_string(number) + "; there are " +
                     std::to_string(materials.size()) + ", from 0");
  return materials[number];
}

bool lacks_voronoi(const Body& whole, const Strategy& strategy, const Material& material) {
  return !whole.voronoi && (strategy.needs_voronoi(whole) || fibres_need_voronoi(strategy, whole, material));
}

bool lacks_voronoi(const Body& whole, const Part& part, const Strategy& strategy,
                   const std::vector<Material>& materials) {
  if (part.rigid || part.voronoi) return false;
  if (strategy.by_parts) return strategy.needs_voronoi(whole);
  return lacks_voronoi(part_alone(whole, part).body, strategy,
                       material_of(materials, part.material, "part '" + part.name + "'"));
}

/// Adds those of the pairs that are no connections yet; without such pairs, nothing at all is changed.
void add_missing(Body& body, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<std::array<int, 2>> known;
  known.reserve(body.connections.ends.size());
  for (const auto& [a, b] : body.connections.ends) known.push_back({std::min(a, b), std::max(a, b)});
  std::sort(known.begin(), known.end());
  if (!std::includes(known.begin(), known.end(), pairs.begin(), pairs.end())) add_cell_sides(body, pairs);
}

void prepare_cell_sides(Body& body, const Strategy& strategy) {
  if (strategy.kind != StrategyKind::cell_law && !strategy.volume_modulus) return;
  const bool of_sheets = strategy.kind == StrategyKind::cell_law && strategy.dimensions == 2;
  add_missing(body, connections_of_cells(body.rest, of_sheets ? body.triangles : Cells<3>{},
                                         of_sheets ? Cells<4>{} : body.tetrahedra)
                        .ends);
}

}  // namespace

bool lacks_voronoi(const Body& body, const Strategy& strategy, const std::vector<Material>& materials) {
  if (body.parts.empty()) return lacks_voronoi(body, strategy, material_of(materials, 0, "the body"));
  return std::any_of(body.parts.begin(), body.parts.end(),
                     [&](const Part& part) { return lacks_voronoi(body, part, strategy, materials); });
}

void take_density(Body& body, const std::vector<Material>& materials) {
  if (!(body.assumed_density > 0)) return;
  if (body.parts.empty()) body.mass *= material_of(materials, 0, "the body").density / body.assumed_density;
  for (const Part& part : body.parts)
    body.mass.segment(part.first, part.count) *=
        material_of(materials, part.material, "part '" + part.name + "'").density / body.assumed_density;
  body.assumed_density = 0;
}

void prepare_bending(Body& body, const Material& material) {
  if (!(material.bending_rigidity > 0)) return;
  const std::string why = unsuited_for_bending(body);
  if (!why.empty()) throw InputError("bending " + why);
  add_missing(body, bending_pairs(body));
}

void prepare(Body& body, const Strategy& strategy, const std::vector<Material>& materials,
             const MakeVoronoi& make_voronoi) {
  check_indices(body);
  if (!strategy.by_parts) take_density(body, materials);
  prepare_bending(body, material_of(materials, 0, "the body"));
  prepare_cell_sides(body, strategy);
  if (!make_voronoi) return;
  if (body.parts.empty() && lacks_voronoi(body, strategy, materials.front())) body.voronoi = make_voronoi(body);
  for (Part& part : body.parts)
    if (lacks_voronoi(body, part, strategy, materials)) part.voronoi = make_voronoi(part_alone(body, part).body);
}

VectorX spring_constants(const Strategy& strategy, Body body, const Material& material, const ParameterValues& values,
                         const MakeVoronoi& make_voronoi) {
  if (!strategy.constants)
    throw InputError("'" + strategy.name + "' is a " + name_of(strategy.kind) + ": only a spring rule has constants");
  prepare(body, strategy, {material}, make_voronoi);
  const std::string why = strategy.unsuited(body);
  if (!why.empty()) throw InputError("strategy '" + strategy.name + "' cannot run on this body: " + why);
  return strategy.constants(body, material, values);
}

}  // namespace elastin
