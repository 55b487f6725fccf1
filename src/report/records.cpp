#include "report/records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "elastin/base/threads.h"
#include "report/table.h"

namespace elastin {

bool Record::good() const {
  return (!run.suited || run.outcome == Outcome::converged) &&
         std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.holds || !v.judged; });
}

double Record::error(std::string_view name) const {
  for (const auto& [known, value] : errors)
    if (known == name) return value;
  return std::nan("");
}

Record make_record(const Scene& scene, Run run) {
  const Material& material = scene.specimen.material;
  const Body& body = scene.specimen.body;
  Record record;
  record.scene = scene.name;
  record.path = scene.path;
  record.title = scene.title;
  record.molecules = body.size();
  record.connections = body.connections.proper();
  record.cell_sides = body.connections.cell_sides;
  record.cells = static_cast<int>(body.tetrahedra.size() + body.triangles.size());
  record.threads = threads();
  record.prescribed =
      fmt::format("E = {}, nu = {:g}", readable(material.youngs_modulus, dimension::pressure), material.poissons_ratio);
  const auto add_error = [&](const std::string& name, double error) {
    if (std::isfinite(error)) record.errors.emplace_back(name, error);
  };
  record.main_measures = scene.experiment->main_measures(material);
  for (const auto& [name, prescribed] : record.main_measures) {
    const bool ratio = find_measure(std::string(name)).unit == dimension::none;
    const double measured = run.measures.get(name);
    add_error(std::string(name), ratio ? measured - prescribed : measured / prescribed - 1);
  }
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
  if (!run.remark.empty()) record.warnings.push_back(run.remark);
  record.run = std::move(run);
  return record;
}

}  // namespace elastin
