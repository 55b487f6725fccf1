#include "elastin/simulation/fibres.h"

#include "stiffness/fibre.h"
#include "stiffness/patch.h"

namespace elastin {

std::string fibres_unsuited(const Strategy& strategy, const Body& body, const Material& material) {
  if (!material.fibre) return "";
  if (strategy.kind == StrategyKind::cell_law)
    return strategy.corners == 4 ? "" : "the material's fibres join laws of tetrahedra, not of triangles";
  const std::string reason = Patch::unsuited(body);
  return reason.empty() ? "" : "the material's fibres as springs: " + reason;
}

std::unique_ptr<Elasticity> make_fibres(const Strategy& strategy, const Body& body, const Material& material) {
  if (!material.fibre) return nullptr;
  if (strategy.kind == StrategyKind::cell_law)
    return std::make_unique<CellElasticity<FibreLaw>>(body, material, FibreLaw{});
  return make_curve_springs(body, fibre_sections(body, material.fibre->direction), material.fibre->curve);
}

}  // namespace elastin
