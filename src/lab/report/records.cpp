#include "lab/report/records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/solve/modes.h"
#include "elastin/core/model/share.h"
#include "elastin/core/parallel/threads.h"
#include "lab/report/comparison.h"
#include "lab/report/table.h"
#include "lab/run/load_path.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

double angle_to_fibres(const Scene& scene) {
  const double cosine = std::abs(scene.experiment->axis()->dot(scene.specimen.material.fibre->direction));
  return std::acos(std::min(1., cosine)) * 180 / 3.14159265358979323846;
}

/// ", stress-strain curve"; " at rest of ogden"
std::string law_text(const Material& material) {
  if (material.law)
    return " at rest of " + material.law->law +
           (material.law->directions.empty()
                ? ""
                : ", means over all directions (errors are against its own modulus along the load)");
  return material.curve ? ", stress-strain curve" : "";
}

/// "skin: E = 5 kPa, nu = 0.3; bone: rigid"
std::string prescribed_of_parts(const Specimen& specimen) {
  std::string text;
  for (const Part& part : specimen.body.parts) {
    const Material& material = specimen.materials[part.material];
    text += fmt::format("{}{}: ", text.empty() ? "" : "; ", part.name);
    text += part.rigid ? "rigid"
                       : fmt::format("E = {}, nu = {:g}{}{}", readable(material.youngs_modulus, dimension::pressure),
                                     material.poissons_ratio, law_text(material), material.fibre ? ", fibres" : "");
  }
  return text;
}

/// What at rest a material bears of its moduli, g₀: less than 1 where these are instantaneous.
double part_at_rest(const Scene& scene) {
  const auto& relaxation = scene.specimen.material.relaxation;
  return relaxation && scene.experiment->at_rest() ? relaxation->long_term() : 1;
}

std::string prescribed_text(const Scene& scene) {
  if (!scene.specimen.body.parts.empty()) return prescribed_of_parts(scene.specimen);
  const Material& material = scene.specimen.material;
  std::string text =
      fmt::format("E = {}, nu = {:g}", readable(material.youngs_modulus, dimension::pressure), material.poissons_ratio);
  if (const double part = part_at_rest(scene); part < 1)
    text += fmt::format(" (at rest {:.4g} of it, E = {})", part,
                        readable(part * material.youngs_modulus, dimension::pressure));
  text += law_text(material);
  if (material.fibre)
    text +=
        fmt::format(", fibres of {}{}", readable(material.fibre->curve.modulus(0), dimension::pressure),
                    scene.experiment->axis() ? fmt::format(" at {:.3g} deg to the load", angle_to_fibres(scene)) : "");
  return text;
}

}  // namespace

Neighbours neighbours_inside(const Body& body) {
  const int proper = body.connections.proper();
  if (!any_over(body, proper > 0)) return {};
  const auto& lengths = body.connections.rest_length;
  std::vector<int> count(static_cast<std::size_t>(body.size()));
  for (int c = 0; c < proper; ++c)
    for (const int end : body.connections.ends[c]) ++count[end];
  const double longest =
      largest_over(body, proper > 0 ? *std::max_element(lengths.begin(), lengths.begin() + proper) : 0);
  const auto [low, high] = outline_of_whole(body);
  count.resize(static_cast<std::size_t>(owned_molecules(body)));
  std::vector<int> inside;
  for (int molecule = 0; molecule < owned_molecules(body); ++molecule) {
    const auto position = body.rest.col(molecule);
    if ((position - low).minCoeff() > longest && (high - position).minCoeff() > longest)
      inside.push_back(count[molecule]);
  }
  const std::vector<int>& counted = any_over(body, !inside.empty()) ? inside : count;
  const auto least = std::min_element(counted.begin(), counted.end());
  return {sum_over(body, std::accumulate(counted.begin(), counted.end(), 0.)) /
              sum_over(body, static_cast<double>(counted.size())),
          static_cast<int>(least_over(body, least == counted.end() ? INFINITY : *least))};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double Record::least_seconds() const { return run.build_seconds + run.solve_seconds; }

void Record::add_repeat(const Record& again) {
  const auto converged = [](const Record& r) { return r.run.suited && r.run.outcome == Outcome::converged; };
  if (repeats.empty() || again.repeats.empty() || !converged(*this) || !converged(again)) return;
  repeats.push_back(again.repeats.front());
  if (again.least_seconds() >= least_seconds()) return;
  run.build_seconds = again.run.build_seconds;
  run.solve_seconds = again.run.solve_seconds;
}

double Record::median_seconds() const {
  if (repeats.empty()) return least_seconds();
  std::vector<double> seconds;
  for (const auto& [build, solve] : repeats) seconds.push_back(build + solve);
  return median(std::move(seconds));
}

bool Record::stopped_as_expected() const {
  return std::any_of(verdicts.begin(), verdicts.end(),
                     [](const Verdict& v) { return !v.expectation.outcome.empty() && v.passed; });
}

bool Record::good() const {
  return (!run.suited || run.outcome == Outcome::converged || stopped_as_expected()) &&
         std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.passed || !v.judged; });
}

const MeasureInfo& Record::measure(const std::string& name) const {
  const MeasureInfo* own = measures ? measures->find(name) : nullptr;
  return own ? *own : find_measure(name);
}

std::string Record::measure(MeasureRole role) const { return (measures ? *measures : built_in_measures()).named(role); }

std::string strain_text(double strain) { return fmt::format("{:.4g} %", 100 * strain); }

const MainMeasure* Record::law_target(std::string_view measure) const {
  constexpr double shows = 1e-4;
  for (const MainMeasure& main : main_measures)
    if (main.name == measure && std::abs(main.strain) >= shows) return &main;
  return nullptr;
}

std::string Record::target_text() const {
  std::string text = prescribed, at;
  for (const MainMeasure& main : main_measures)
    if (law_target(main.name)) {
      at += fmt::format("{}{} {}", at.empty() ? "; at a strain of " + strain_text(main.strain) + ": " : ", ",
                        this->measure(main.name).label(), value_text(main.prescribed, this->measure(main.name)));
    }
  return text + at;
}

bool Record::is_apparent(const MeasureInfo& info) const {
  return apparent && (info.role == MeasureRole::youngs_modulus || info.name == "curve_error");
}

double Record::error(std::string_view name) const {
  for (const auto& [known, value] : errors)
    if (known == name) return value;
  return std::nan("");
}

Verdict judge(const Expectation& expectation, const Run& run) {
  Verdict verdict{expectation, run.strategy, std::nan(""), std::nan(""), false, expectation.not_reproduced.empty()};
  if (!expectation.outcome.empty()) {
    verdict.passed = expectation.outcome == outcome_name(run) && run.cause.find(expectation.cause) != std::string::npos;
    return verdict;
  }
  verdict.measured = run.measures.get(expectation.measure);
  const double off = verdict.measured - expectation.value;
  verdict.difference = off / std::abs(expectation.value);
  verdict.passed = std::abs(off) <= expectation.absolute + expectation.relative * std::abs(expectation.value);
  return verdict;
}

namespace {

/// σ² = gᵀ Σ g of each measure, g its derivatives and Σ the covariance of the scene's uncertain numbers.
Gradients spreads_of(const Scene& scene, const Gradients& gradients) {
  Gradients spreads;
  for (const auto& [measure, slopes] : gradients) {
    VectorX parts = VectorX::Zero(static_cast<Eigen::Index>(scene.uncertain.size()));
    for (std::size_t i = 0; i < scene.uncertain.size(); ++i)
      for (const auto& [key, slope] : slopes)
        if (key == scene.uncertain[i].key) parts[static_cast<Eigen::Index>(i)] = slope * scene.uncertain[i].deviation;
    if (parts.size() == 0) break;
    const VectorX squares = parts.cwiseProduct(scene.correlation * parts);
    const double square = std::max(0., squares.sum());
    auto& row = spreads.emplace_back(measure, std::vector{std::pair{std::string("deviation"), std::sqrt(square)}});
    for (std::size_t i = 0; square > 0 && i < scene.uncertain.size(); ++i)
      row.second.emplace_back(scene.uncertain[i].key, squares[static_cast<Eigen::Index>(i)] / square);
  }
  return spreads;
}

/// That a material whose directions are askew to the load has one modulus where sections may tilt, as uniaxial stress
/// asks, and another where the ends keep them level; or "".
std::string sheared_by_load(const Scene& scene, const Record& record, const Run& run) {
  constexpr double same = 0.01;
  const Material& material = scene.specimen.material;
  const auto axis = scene.experiment->axis();
  if (!axis || run.law_strain == 0 || no_isotropic_moduli(material).empty()) return "";
  const auto stress = material.law ? uniaxial_stress(material, *axis, run.law_strain) : std::nullopt;
  const double level = run.law.get(record.measure(MeasureRole::youngs_modulus));
  const double free = stress ? *stress / run.law_strain : uniaxial_response(material, *axis).youngs_modulus;
  const double along = material.fibre ? std::abs(material.fibre->direction.dot(*axis)) : 0;
  const bool askew = stress || (std::min(along, std::sqrt(1 - along * along)) > 0.02 && !material.varies());
  if (!askew || !(std::abs(level / free - 1) > same)) return "";
  return "the material's directions are askew to the load and shear the body: its modulus is " + number(level, 4) +
         " Pa where the ends keep its sections level, and " + (stress ? number(free, 4) + " Pa" : "another") +
         " where they may tilt, as in a long bar; compare with its own law on cells, refined (--reference computed)";
}

/// Why the material's moduli are no targets of a body that other loads have strained, or "".
std::string strained_before(const Record& record, const Run& run) {
  constexpr double little = 0.02;
  const double strain = run.measures.get("preload_strain");
  const auto has_target = [](const MainMeasure& one) { return std::isfinite(one.prescribed); };
  if (!(strain > little) || std::none_of(record.main_measures.begin(), record.main_measures.end(), has_target))
    return "";
  return "the scene's own loads strain the body by up to " + strain_text(strain) +
         " before the experiment's, and the material's moduli are those without; compare with a law of cells, refined "
         "(--reference computed)";
}

/// Of a flat body that everything leaves in its plane: what run.zero_energy_modes leaves out; else "".
std::string note_of_plane(const Scene& scene) {
  const Specimen& specimen = scene.specimen;
  if (specimen.body.share || specimen.contact || specimen.material.bending_rigidity > 0 ||
      scene.experiment->stiffened_by_load() || plane_normal(specimen.body).isZero(0))
    return "";
  return stays_in_plane(specimen, *scene.experiment, scene.time ? scene.time->duration : 0)
             ? "the body is flat, and all that acts on it lies in its plane: motions "
               "out of the plane are not counted as zero-energy modes"
             : "";
}

/// A strip that is pulled bears nothing across at any width up to the law's own, which its folds may take.
void leave_out_widths(Record& record) {
  for (MainMeasure& measure : record.main_measures) {
    if (record.measure(measure.name).role != MeasureRole::poissons_ratio || !std::isfinite(measure.prescribed))
      continue;
    measure.prescribed = std::nan("");
    record.notes.emplace_back(
        "there is no target of Poisson's ratio: a sheet that wrinkles bears nothing across the load at any width up to "
        "that of the law without wrinkling, so that its width is indeterminate");
  }
}

}  // namespace

bool have_one_target(const std::vector<Record>& records) {
  return std::all_of(records.begin(), records.end(),
                     [&](const Record& record) { return record.prescribed == records.front().prescribed; });
}

Record make_record(const Scene& scene, Run run) {
  const Body& body = scene.specimen.body;
  Record record;
  record.scene = scene.name;
  record.path = scene.source.path();
  record.title = scene.title;
  record.molecules = static_cast<int>(molecules_of_whole(body));
  record.connections = static_cast<int>(body.share ? body.share->connections : body.connections.proper());
  record.cell_sides = body.connections.cell_sides;
  record.cells = static_cast<int>(body.share ? body.share->cells : count_cells(body));
  record.threads = threads();
  record.neighbours = neighbours_inside(body);
  record.prescribed = prescribed_text(scene);
  const auto add_error = [&](const std::string& name, double error) {
    if (std::isfinite(error)) record.errors.emplace_back(name, error);
  };
  record.measures = scene.measures;
  record.spreads = spreads_of(scene, run.gradients);
  record.main_measures = scene.experiment->main_measures(scene.specimen.material, run.measures);
  // Moduli of the matrix alone are not the body's, nor is that of one material where there are several, or fields, nor
  // any material's where something disturbs what is measured and no reference is next to it.
  record.no_reference = no_reference(scene);
  if (record.no_reference.empty() && !scene.specimen.loads.empty()) record.no_reference = strained_before(record, run);
  if (record.no_reference.empty()) record.no_reference = sheared_by_load(scene, record, run);
  const bool disturbed = !record.no_reference.empty() && references_of(scene).empty();
  if (disturbed ||
      (!no_isotropic_moduli(scene.specimen.material).empty() && !scene.experiment->axis() &&
       (scene.specimen.material.fibre || scene.experiment->in_time())) ||
      !no_one_modulus(scene.specimen).empty())
    for (MainMeasure& measure : record.main_measures) measure.prescribed = std::nan("");
  if (run.wrinkles) leave_out_widths(record);
  for (MainMeasure& measure : record.main_measures)
    if (const double own = run.law.get(measure.name); std::isfinite(own) && std::isfinite(measure.prescribed))
      measure.prescribed = own, measure.strain = run.law_strain;
  if (const double part = part_at_rest(scene); part < 1)
    for (MainMeasure& measure : record.main_measures)
      if (record.measure(measure.name).unit == dimension::pressure)
        measure.prescribed = part > 0 ? part * measure.prescribed : std::nan("");
  for (const auto& [name, prescribed, strain] : record.main_measures) {
    const bool ratio = record.measure(name).unit == dimension::none;
    const double measured = run.measures.get(name);
    add_error(name, ratio ? measured - prescribed : measured / prescribed - 1);
  }
  for (const Expectation& expectation : scene.expectations) {
    const bool silent = expectation.strategy.empty() && !run.suited && expectation.outcome.empty();
    if (silent || (!expectation.strategy.empty() && expectation.strategy != run.strategy)) continue;
    record.verdicts.push_back(judge(expectation, run));
  }
  if (scene.specimen.contact)
    for (const contact::Obstacle& obstacle : scene.specimen.contact->obstacles)
      record.obstacles.push_back(obstacle.name);
  record.notes.insert(record.notes.begin(), scene.notes.begin(), scene.notes.end());
  for (std::string& note : scene.experiment->notes()) record.notes.push_back(std::move(note));
  if (std::string note = note_of_plane(scene); !note.empty()) record.notes.push_back(std::move(note));
  record.apparent = scene.experiment->apparent();
  if (!record.no_reference.empty() && !scene.no_computed_reference.empty())
    record.no_reference += "; no reference was computed: " + scene.no_computed_reference;
  record.warnings = scene.warnings;
  record.warnings.insert(record.warnings.end(), run.warnings.begin(), run.warnings.end());
  if (!run.remark.empty()) record.warnings.push_back(run.remark);
  record.run = std::move(run);
  record.spacing = relative_spacing(body);
  const auto [low, high] = outline_of_whole(body);
  record.extent = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
  set_references(record, references_of(scene));
  return record;
}

std::vector<Reference> references_of(const Scene& scene) {
  std::vector<Reference> references = scene.references;
  for (const Reference& computed : scene.specimen.references)
    if (std::none_of(references.begin(), references.end(),
                     [&](const Reference& known) { return known.measure == computed.measure; }))
      references.push_back(computed);
  return references;
}

double relative_spacing(const Body& body) {
  if (body.share) return 1 / std::cbrt(body.share->cells > 0 ? body.share->cells : body.share->molecules);
  if (!body.tetrahedra.empty()) return 1 / std::cbrt(body.tetrahedra.size());
  if (!body.cubes.empty()) return 1 / std::cbrt(body.cubes.size());
  if (!body.triangles.empty()) return 1 / std::sqrt(body.triangles.size());
  return 1 / std::cbrt(body.size());
}

double along(const CurvePoint& point, const std::string& name) {
  return name == "time" ? point.time : name == "load" ? point.load_factor : point.measures.get(name);
}

double over_scatter(const Run& run, const Reference& reference) {
  if (reference.points.empty())
    return std::abs(run.measures.get(reference.measure) / reference.value - 1) / reference.scatter;
  double sum = 0;
  const double slack = 1e-6 * std::abs(reference.points.back()[0]);  // of a last load step that is rounded
  for (const auto& [place, value, deviation] : reference.points) {
    const double at = place;  // clang 14 captures no structured binding
    double from = 0, shown = 0;
    const auto to = std::find_if(run.curve.begin(), run.curve.end(), [&](const CurvePoint& point) {
      const double x = along(point, reference.along), y = along(point, reference.measure);
      const bool reached = std::abs(x) >= std::abs(at) - slack && x * at >= 0;
      shown = reached && x != from ? shown + (y - shown) * (at - from) / (x - from) : y;
      from = x;
      return reached;
    });
    if (to == run.curve.end()) return std::nan("");
    sum += std::pow((shown - value) / deviation, 2);
  }
  return std::sqrt(sum / static_cast<double>(reference.points.size()));
}

void set_references(Record& record, const std::vector<Reference>& references) {
  record.references = references;
  std::erase_if(record.errors, [](const auto& error) {
    return error.first.ends_with("_to_reference") || error.first.ends_with("_over_scatter");
  });
  for (const Reference& reference : references) {
    const double error = record.run.measures.get(reference.measure) / reference.value - 1;
    if (std::isfinite(error)) record.errors.emplace_back(reference.measure + "_to_reference", error);
    const double scattered = reference.scatter > 0 ? over_scatter(record.run, reference) : std::nan("");
    if (std::isfinite(scattered)) record.errors.emplace_back(reference.measure + "_over_scatter", scattered);
  }
}

}  // namespace elastin::lab
