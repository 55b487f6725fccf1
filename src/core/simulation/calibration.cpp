#include <algorithm>
#include <numeric>
#include <utility>

#include "core/model/faces.h"
#include "core/simulation/volume_fit.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/volume.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/homogenisation.h"

namespace elastin {
namespace {

/// Spring constants [N/m], and κ [Pa] of a volume term where the rule has one.
struct SpringsAndVolume {
  VectorX constants;
  double volume_modulus = 0;
};

std::string calibrated_unsuited(const Strategy& rule, const Body& body) {
  std::string why = rule.unsuited(body);
  if (why.empty() && !body.parts.empty()) why = "several bodies are calibrated together in a scene's experiment alone";
  if (why.empty() && body.connection_stiffness.size()) why = "a body with regions has no one modulus to calibrate to";
  return why;
}

/// Where molecules of a box lie behind its sides, as in a packing, those within half a mean connection belong to them.
Surface outer_surface(const Body& body) {
  const Matrix3 axes = Matrix3::Identity();
  try {
    return find_surface(body, axes, 0);
  } catch (const InputError&) {
    const auto begin = body.connections.rest_length.begin();
    const int count = body.connections.proper();
    if (!body.tetrahedra.empty() || !body.triangles.empty() || count == 0) throw;
    return find_surface(body, axes, std::accumulate(begin, begin + count, 0.) / (2 * count));
  }
}

/// Fits springs and volume term to the material by the moduli that the body's surface shows.
SpringsAndVolume fitted(const Strategy& rule, const Body& body, const Material& material,
                        const ParameterValues& values) {
  const auto fail = [&](const std::string& cause) {
    throw InputError("'calibrated:" + rule.name + "' on this body: " + cause);
  };
  SpringsAndVolume found{rule.constants(body, material, values), 0};
  if (!found.constants.allFinite()) fail("a spring constant is not finite");
  Surface surface;
  try {
    surface = outer_surface(body);
  } catch (const InputError& error) {
    fail(std::string("there is no solid to measure: ") + error.what());
  }
  std::string trouble = "its stiffness is singular or not positive: there is no modulus to calibrate to";
  const auto measured = [&](double volume_modulus) -> std::optional<std::pair<double, double>> {
    Model model(body);
    model.add(make_springs(body, found.constants));
    if (rule.volume_modulus) model.add(make_volume(body, volume_modulus));
    model.set_rest(0);
    for (const int molecule : surface.molecules) model.supports.push_back({molecule});
    const Homogenised of_body =
        homogenise(model, surface.molecules, surface.volume, body.rest, Matrix3::Identity(), {.linear = true});
    if (of_body.result.outcome != Outcome::converged) trouble = of_body.result.cause;
    const auto compliance = compliance_of(of_body.stiffness);
    if (!compliance) return std::nullopt;
    const Stiffness6 symmetric = (of_body.stiffness + of_body.stiffness.transpose()) / 2;
    const IsotropicMeans means = isotropic_means(symmetric, *compliance);
    return std::pair{means.youngs(), means.poissons_ratio()};
  };
  double factor = 0;
  if (!rule.volume_modulus) {
    const auto moduli = measured(0);
    if (moduli) factor = material.youngs_modulus / moduli->first;
  } else if (const auto fit = fit_volume(material, measured)) {
    factor = fit->spring_factor;
    found.volume_modulus = fit->volume_modulus;
  }
  if (!(factor > 0)) fail(trouble);
  found.constants *= factor;
  return found;
}

}  // namespace

Strategy calibrated(const Strategy& rule) {
  StrategyName parsed(rule.name);
  parsed.calibrated = true;
  const std::string name = parsed.text();
  if (rule.calibrates) throw InputError("'" + name + "': the rule is calibrated already");
  if (rule.has_history) throw InputError("'" + name + "': write prony:calibrated:RULE or mullins:calibrated:RULE");
  if (rule.kind != StrategyKind::spring_rule)
    throw InputError("'" + name + "': only a spring rule can be calibrated, and " + rule.name + " is a " +
                     name_of(rule.kind));
  Strategy result = rule;
  result.name = name;
  result.summary += "; calibrated";
  result.calibrates = std::make_shared<const Strategy>(rule);
  result.unsuited = [rule](const Body& body) { return calibrated_unsuited(rule, body); };
  result.constants = [rule](const Body& body, const Material& material, const ParameterValues& values) {
    return fitted(rule, body, material, values).constants;
  };
  result.make = [rule](const Body& body, const Material& material, const ParameterValues& values) {
    SpringsAndVolume found = fitted(rule, body, material, values);
    ElasticTerms terms = make_springs(body, std::move(found.constants), material);
    if (rule.volume_modulus) terms.add(make_volume(body, found.volume_modulus));
    return terms;
  };
  return result;
}

}  // namespace elastin
