#include "core/simulation/fibres.h"

#include <cmath>

#include "core/laws/solids/fibre.h"
#include "core/laws/springs/patch.h"
#include "elastin/core/forces/cells.h"
#include "elastin/core/forces/muscle.h"

namespace elastin {

bool fibres_need_voronoi(const Strategy& strategy, const Body& body, const Material& material) {
  return material.fibre && strategy.kind != StrategyKind::cell_law && Patch::needs_voronoi(body);
}

std::string fibres_unsuited(const Strategy& strategy, const Body& body, const Material& material) {
  if (material.active && (strategy.kind != StrategyKind::cell_law || strategy.dimensions != 3))
    return "the material's active fibres join laws of solids, not springs or membranes";
  if (!material.fibre) return "";
  if (strategy.kind == StrategyKind::cell_law)
    return strategy.dimensions == 3 ? "" : "the material's fibres join laws of tetrahedra, not of triangles";
  if (material.around) return "the material's fibres turn around an axis, which springs of one direction cannot";
  if (material.field) return "the material's fibres vary over the body, which springs of one direction cannot";
  const std::string reason = Patch::unsuited(*detail::proper_part(body));
  return reason.empty() ? "" : "the material's fibres as springs: " + reason;
}

namespace {

/// Nodal volumes have one modulus; cells that keep their own volume have one each.
std::string volume_unsuited(const Strategy& strategy, const Body& body, const Material& material) {
  if (!strategy.volume_modulus || !material.field || (has_blocks(body, 3) && strategy.make_mixed)) return "";
  const double modulus = strategy.volume_modulus(material);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (std::abs(strategy.volume_modulus(local_material(material, body.rest.col(molecule))) - modulus) >
        1e-9 * std::abs(modulus))
      return "needs one Poisson's ratio for its volumes, and the material has another from place to place; hexahedra "
             "and cells of second order have volumes of their own with neo_hookean+volume";
  return "";
}

}  // namespace

std::string material_unsuited(const Strategy& strategy, const Body& body, const Material& material) {
  std::string reason = strategy.unsuited_material(material);
  if (reason.empty()) reason = volume_unsuited(strategy, body, material);
  return reason.empty() ? fibres_unsuited(strategy, body, material) : reason;
}

ElasticTerms make_fibres(const Strategy& strategy, const Body& body, const Material& material) {
  if (strategy.kind == StrategyKind::cell_law) {
    ElasticTerms terms;
    if (material.fibre) terms.add(make_cells<3>(body, material, FibreLaw{}));
    if (material.active) terms.add(make_muscle(body, material));
    return terms;
  }
  if (!material.fibre) return {};
  const VectorX sections = fibre_sections(*detail::proper_part(body), material.fibre->direction);
  return make_curve_springs(body, detail::with_cell_sides(sections, body), material.fibre->curve);
}

}  // namespace elastin
