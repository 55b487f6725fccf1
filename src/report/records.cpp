#include "report/records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "elastin/base/threads.h"
#include "report/table.h"

namespace elastin {
namespace {

double angle_to_fibres(const Scene& scene) {
  const double cosine = std::abs(scene.experiment->axis()->dot(scene.specimen.material.fibre->direction));
  return std::acos(std::min(1., cosine)) * 180 / 3.14159265358979323846;
}

std::string prescribed_text(const Scene& scene) {
  const Material& material = scene.specimen.material;
  std::string text =
      fmt::format("E = {}, nu = {:g}", readable(material.youngs_modulus, dimension::pressure), material.poissons_ratio);
  if (material.curve) text += ", stress-strain curve";
  if (material.fibre)
    text +=
        fmt::format(", fibres of {}{}", readable(material.fibre->curve.modulus(0), dimension::pressure),
                    scene.experiment->axis() ? fmt::format(" at {:.3g} deg to the load", angle_to_fibres(scene)) : "");
  return text;
}

/// What the material asks of the run: E and ν along the load; where there is a curve, its secant at the run's strain.
UniaxialResponse prescribed_response(const Scene& scene, const Run& run) {
  const Material& material = scene.specimen.material;
  const auto axis = scene.experiment->axis();
  if (!axis) return {material.youngs_modulus, material.poissons_ratio};
  UniaxialResponse response = uniaxial_response(material, *axis);
  const double strain = run.measures.get("strain");
  if (const auto stress = uniaxial_stress(material, *axis, strain)) response.youngs_modulus = *stress / strain;
  return response;
}

}  // namespace

bool Record::good() const {
  return (!run.suited || run.outcome == Outcome::converged) &&
         std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.holds || !v.judged; });
}

Record make_record(const Scene& scene, Run run) {
  const Body& body = scene.specimen.body;
  Record record;
  record.scene = scene.name;
  record.path = scene.path;
  record.title = scene.title;
  record.molecules = body.size();
  record.connections = body.connections.size();
  record.cells = static_cast<int>(body.tetrahedra.size() + body.triangles.size());
  record.threads = threads();
  record.prescribed = prescribed_text(scene);
  const auto add_error = [&](const std::string& name, double error) {
    if (std::isfinite(error)) record.errors.emplace_back(name, error);
  };
  const UniaxialResponse prescribed = prescribed_response(scene, run);
  add_error("effective_modulus", run.measures.get("effective_modulus") / prescribed.youngs_modulus - 1);
  add_error("poissons_ratio", run.measures.get("poissons_ratio") - prescribed.poissons_ratio);
  for (const Reference& reference : scene.references)
    add_error(reference.measure + "_to_reference", run.measures.get(reference.measure) / reference.value - 1);
  for (const Expectation& expectation : scene.expectations) {
    if (expectation.strategy.empty() ? !run.suited : expectation.strategy != run.strategy) continue;
    Verdict verdict{expectation, run.strategy, run.measures.get(expectation.measure),
                    0,           false,        expectation.not_reproduced.empty()};
    const double off = verdict.measured - expectation.value;
    verdict.difference = off / std::abs(expectation.value);
    verdict.holds = std::abs(off) <= expectation.absolute + expectation.relative * std::abs(expectation.value);
    record.verdicts.push_back(std::move(verdict));
  }
  record.warnings = scene.warnings;
  record.warnings.insert(record.warnings.end(), run.warnings.begin(), run.warnings.end());
  record.run = std::move(run);
  return record;
}

}  // namespace elastin
