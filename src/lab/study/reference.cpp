#include "lab/study/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/stopwatch.h"
#include "core/geometry/boundary.h"
#include "core/shapes/orders.h"
#include "core/shapes/refinement.h"
#include "core/simulation/fibres.h"
#include "core/simulation/warnings.h"
#include "core/solve/newton.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/embedded_surface.h"
#include "elastin/core/shapes/arrays.h"
#include "hull/delaunay.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/run/body_image.h"
#include "lab/run/load_path.h"
#include "lab/run/specimen.h"
#include "lab/study/journal.h"

namespace elastin::lab {
namespace {

/// Another method to compute a reference takes another number, so that older files are not read back.
constexpr int kVersion = 6;
/// Of the unbalanced force: far below any uncertainty that a scene may request.
constexpr double kTolerance = 1e-7;
/// How much longer a body takes with twice as many cells along each side.
constexpr double kGrowth = 12;
/// The same of boxes of an image, which begin where the larger ones came to rest: 2 to 8 are measured.
constexpr double kGrowthOfImage = 6;

/// Of the body's cells, "hexahedra of 27 nodes".
std::string kind_of_cells(const Body& body) {
  return body.blocks.size() == 1 ? std::string(body.blocks.front().kind->plural) : "cells";
}

bool is_solid(const Body& body) { return !body.tetrahedra.empty(); }

/// Why a scene has no converged solution that could be computed, or "".
std::string unsuited(const Scene& scene) {
  const Body& body = scene.specimen.body;
  if (!scene.experiment->at_rest()) return "a run in time has no equilibrium to refine";
  if (identification_of(*scene.experiment)) return "the experiment is there to find the material";
  if (!body.parts.empty()) return "several bodies cannot be refined";
  if (!body.cables.empty()) return "a body with cables cannot be refined";
  if (scene.specimen.given != GivenShape::at_rest) return "each strategy finds a rest of its own";
  if (scene.bare_graph)
    return "a list of molecules and connections does not say what it fills (`cells: delaunay` in the body does)";
  if (body.tetrahedra.empty() && body.triangles.empty() && body.connection_stiffness.size())
    return "regions need a body of cells";
  return "";
}

/// The body with cells of second order: its own, those in the boxes of a lattice, or tetrahedra between its molecules.
Body domain_of(const Body& body, const Material& material) {
  const bool has_cells = !body.blocks.empty() || !body.tetrahedra.empty() || !body.triangles.empty();
  if (has_cells || !body.cubes.empty()) {
    const bool prisms = std::any_of(body.blocks.begin(), body.blocks.end(),
                                    [](const CellBlock& block) { return block.kind->name == "prism6"; });
    return prisms || body.blocks.size() > 1 ? body : with_order(body, 2);
  }
  Body domain;
  domain.rest = body.rest;
  domain.tetrahedra = hull::delaunay_tetrahedra(body.rest);
  domain.connections = connections_of_cells(domain.rest, {}, domain.tetrahedra);
  set_matter(domain, material.density, material.thickness, body.radius.mean());
  domain.mass *= body.mass.sum() / domain.mass.sum();
  return with_order(domain, 2);
}

/// Size and moments to a millionth of the body's own.
std::string moments_text(const Body& part, const Body& whole) {
  const auto moments = moments_of_cells(part), scale = moments_of_cells(whole);
  const double length = std::cbrt(std::abs(scale[0]));
  std::string text;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const double unit = scale[0] * std::pow(length, i < 1 ? 0 : i < 4 ? 1 : 2);
    text += fmt::format(" {}", std::llround(1e6 * moments[i] / unit));
  }
  return text;
}

/// The cells, and the triangles on the surface, all of whose molecules the experiment holds or loads: with a grip
/// depth, and at ends that are not plane, they depend on the body's own cells.
std::string held_text(const Scene& scene) {
  const Body& body = scene.specimen.body;
  Model model(body);
  const auto rig = scene.experiment->rig(model);
  std::vector<char> held(static_cast<std::size_t>(body.size()), 0);
  for (const Support& support : model.supports) held[support.molecule] = 1;
  if (!scene.specimen.contact) {
    rig->at_rest()->set_load(1);
    const Positions forces = model.load_forces(state_at_rest(body));
    for (int molecule = 0; molecule < body.size(); ++molecule)
      if (!forces.col(molecule).isZero(0)) held[molecule] = 1;
  }
  const auto is_free = [&](const auto& cell) {
    return std::any_of(cell.begin(), cell.end(), [&](int m) { return held[m] == 0; });
  };
  Body cells, surface;
  cells.rest = surface.rest = body.rest;
  cells.tetrahedra = body.tetrahedra;
  surface.triangles = body.tetrahedra.empty() ? body.triangles : boundary_of(body.tetrahedra);
  std::erase_if(cells.tetrahedra, is_free);
  std::erase_if(surface.triangles, is_free);
  return moments_text(cells, body) + "," + moments_text(surface, body);
}

/// What the references of two scenes have in common if they are the same: the problem, what its body fills, where that
/// is held, and how well it is to be solved.
std::string problem_key(const Scene& scene, const Scene& on_domain, const std::string& strategy) {
  const Body& domain = on_domain.specimen.body;
  const ComputedReference& how = scene.computed;
  return key_of(std::vector{std::to_string(kVersion), scene.problem,
                            fmt::format("{:.6e}", moments_of_cells(domain)[0]) + moments_text(domain, domain),
                            std::string(kind_of_cells(domain)), held_text(on_domain), strategy,
                            fmt::format("{} {} {}", how.uncertainty, how.most_cells, how.seconds)});
}

/// The material's own law.
std::string own_law(const Scene& scene, const Catalog& catalog, const Body& domain) {
  if (!scene.computed.strategy.empty()) return scene.computed.strategy;
  const Material& material = scene.specimen.material;
  const std::string law = material.law ? material.law->law : material.curve ? "curve" : "neo_hookean";
  if (!is_solid(domain)) return StrategyName::of_law(law, 2).text();
  const auto suits = [&](const StrategyName& name) {
    try {
      const StrategyChoice choice = choose_strategy(catalog, name);
      if (choice.strategy.volume_modulus) choice.strategy.volume_modulus(material);
      return choice.strategy.unsuited(domain).empty() && material_unsuited(choice.strategy, domain, material).empty();
    } catch (const InputError&) {
      return false;
    }
  };
  StrategyName with_volume(law);
  with_volume.volume = true;
  return largest_poissons_ratio(material, domain) > kLocking && suits(with_volume) ? with_volume.text() : law;
}

/// One body of the sequence, solved.
struct Level {
  double spacing = 1;
  std::size_t cells = 0;
  Measures measures;
  Positions positions;  ///< where it came to rest; empty where that is no use to the next one
  std::string trouble;
  double seconds = 0;
};

/// Solves for the whole load at once from where a coarser body stands; false where that leads nowhere.
bool solve_from(const Positions& guess, const Scene& scene, const StrategyChoice& choice, const RunOptions& options,
                Level& level) {
  const Specimen& specimen = scene.specimen;
  if (specimen.contact || specimen.start || !specimen.loads.empty() || options.statics.linear) return false;
  Run run;
  const std::optional<HeldModel> held = make_model(specimen, *scene.experiment, choice, options, run);
  if (!held) return false;
  Model& model = *held->model;
  StaticRig& rig = *held->rig->at_rest();
  State state = state_at_rest(specimen.body);
  set_load(model, rig, 0);
  if (!model.load_forces(state).isZero(0)) return false;
  const Start start{state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  set_load(model, rig, 1);
  state.positions = guess;
  apply_supports(model, state.positions);
  StaticOptions statics = options.statics;
  statics.newton_limit = std::min(statics.newton_limit, 30);  // a guess that needs more is useless
  StaticResult solved = solve_static(model, state, statics);
  for (int correction = 0; correction < 10 && solved.outcome == Outcome::converged && rig.adjust(state); ++correction)
    solved = solve_static(model, state, statics);
  if (solved.outcome != Outcome::converged) return false;
  level.measures = rig.measure(start, state, options.statics, solved);
  level.positions = std::move(state.positions);
  return true;
}

/// Where points come to that move with the body as far as they lie in it; nothing where they cannot.
Positions moved_with(const Body& body, const Positions& positions, const Positions& points) {
  if (positions.cols() != body.size()) return {};
  try {
    const EmbeddedSurface surface(body, points, {});
    std::vector<float> moved(static_cast<std::size_t>(points.size()));
    surface.draw(positions, moved, {});
    return Eigen::Map<const Eigen::Matrix3Xf>(moved.data(), 3, points.cols()).cast<double>();
  } catch (const InputError&) {
    return {};
  }
}

/// `stop` is called between iterations; a body that it ends has a trouble.
Level solve_level(Scene& scene, const StrategyChoice& choice, const Positions& guess, double spacing,
                  const std::function<void(const std::string&)>& progress, const std::function<bool()>& stop) {
  const Stopwatch watch;
  Level level;
  level.spacing = spacing;
  level.cells = count_cells(scene.specimen.body);
  prepare(scene.specimen, choice.strategy);
  RunOptions options;
  options.statics = scene.statics;
  options.statics.tolerance = std::max(options.statics.tolerance, kTolerance);
  options.keep_snapshots = options.last_snapshot = true;
  options.progress = progress;
  options.stop = options.statics.stop = stop;
  if (guess.cols() != scene.specimen.body.size() || !solve_from(guess, scene, choice, options, level)) {
    Run run = run_strategy(scene.specimen, *scene.experiment, choice, options);
    if (!run.suited || run.outcome != Outcome::converged)
      level.trouble = run.cause.empty() ? outcome_name(run) : run.cause;
    level.measures = run.measures;
    if (!run.snapshots.empty()) level.positions = std::move(run.snapshots.back().positions);
  }
  // A solve that is stopped between the last load step and the measures leaves these without values.
  if (level.trouble.empty() && stop && stop()) level.trouble = "stopped";
  level.seconds = watch.seconds();
  return level;
}

/// Measures of the sequence that can have a limit: all finite; not those that the load prescribes, which never change,
/// unless nothing does.
std::vector<std::string> measures_of(const Scene& scene, const std::vector<Level>& levels) {
  std::vector<std::string> finite, changing;
  for (const MainMeasure& measure : scene.experiment->main_measures(scene.specimen.material, levels.back().measures)) {
    const std::string name(measure.name);
    if (name == "curve_error" ||
        !std::all_of(levels.begin(), levels.end(), [&](const Level& l) { return std::isfinite(l.measures.get(name)); }))
      continue;
    finite.push_back(name);
    const double first = levels.front().measures.get(name);
    // A ratio of 0 changes by what the solver leaves.
    const double rounding =
        scene.measures->at(name).unit == dimension::none ? 10 * kTolerance : 1e-12 * std::abs(first);
    if (std::any_of(levels.begin(), levels.end(),
                    [&](const Level& l) { return std::abs(l.measures.get(name) - first) > rounding; }))
      changing.push_back(name);
  }
  return changing.empty() ? finite : changing;
}

/// `of_image`: whether the bodies have shapes of their own, each nearer to an image's; they show no order, and the last
/// one is the nearest, by the last change if that is of order 1.
std::vector<Reference> limits_of(const Scene& scene, const std::vector<Level>& levels, const std::string& strategy,
                                 bool of_image) {
  if (levels.size() < 2) return {};
  std::vector<Reference> references;
  const std::vector<std::string> names = measures_of(scene, levels);
  // What a value is large or small against: 1, or the largest one of its unit.
  const auto size_of = [&](const std::string& name) {
    const auto& unit = scene.measures->at(name).unit;
    double largest = unit == dimension::none ? 1 : 0;
    for (const std::string& other : names)
      if (scene.measures->at(other).unit == unit && unit != dimension::none)
        largest = std::max(largest, std::abs(levels.back().measures.get(other)));
    return largest;
  };
  for (const std::string& name : names) {
    std::vector<std::pair<double, double>> rows;
    for (const Level& level : levels) rows.emplace_back(level.spacing, level.measures.get(name));
    const double last = rows.back().second;
    const Extrapolation found =
        of_image ? Extrapolation{last, std::abs(last - rows[rows.size() - 2].second), std::nan("")} : limit_of(rows);
    const double uncertainty = found.uncertainty / std::abs(found.value);
    if (!std::isfinite(uncertainty)) continue;
    // What is next to nothing has no relative error worth telling.
    const bool ratio = scene.measures->at(name).unit == dimension::none;
    if ((ratio && uncertainty > kMostUncertain) || std::abs(found.value) < 1e-3 * size_of(name)) continue;
    references.push_back({name, found.value,
                          fmt::format("computed: {} on {} to {} {}{}", strategy, levels.front().cells,
                                      levels.back().cells, kind_of_cells(scene.specimen.body),
                                      std::isfinite(found.order) ? fmt::format(", order {:.2f}", found.order) : ""),
                          uncertainty, true});
  }
  return references;
}

/// Whether all measures that rank strategies are known well enough: by three bodies, for two show no order, unless they
/// hardly differ.
bool known(const Scene& scene, const std::vector<Reference>& references, const std::vector<Level>& levels,
           double uncertainty) {
  bool any = false;
  for (const Reference& reference : references) {
    if (scene.measures->at(reference.measure).unit == dimension::none) continue;
    any = true;
    if (reference.uncertainty > uncertainty) return false;
    const double change =
        levels.back().measures.get(reference.measure) - levels[levels.size() - 2].measures.get(reference.measure);
    if (levels.size() < 3 && std::abs(change) > uncertainty * std::abs(reference.value)) return false;
  }
  return any;
}

/// The sequence of bodies of one scene.
class Sequence {
 public:
  Sequence(const Scene& scene, const Catalog& catalog, const std::vector<std::string>& overrides)
      : scene_(scene), catalog_(catalog), overrides_(overrides) {
    // A fill without cells of its own is carved as one with them.
    for (const char* change : {"", "body.fill.cells=delaunay"}) {
      if (*change != 0) overrides_.emplace_back(change);
      load();
      if (!filled_) break;
    }
    law_ = own_law(scene, catalog, body_);
    const auto& relaxation = scene.specimen.material.relaxation;
    if (relaxation && relaxation->long_term() < 1 && scene.computed.strategy.empty()) law_ = "prony:" + law_;
  }
  const Scene& first() const { return *first_; }
  const std::string& law() const { return law_; }

  ComputedReferences solve(const std::function<void(const std::string&)>& progress, const std::function<bool()>& stop);

 private:
  /// Reads the scene, and makes its body the first one or, of an image that has voxels for it, a finer one.
  void load();
  std::unique_ptr<Scene> scene_on_body();
  /// Reports the solution on this body, with what is known of it before; says at once that it begins.
  std::function<void(const std::string&)> of_level(const std::function<void(const std::string&)>& progress,
                                                   const std::string& before = {}) const;
  /// Where one body alone is affordable: how far its cells' order moves the measures says how well they are known.
  std::vector<Reference> limits_by_order(const Scene& scene, const StrategyChoice& choice,
                                         const std::function<void(const std::string&)>& progress,
                                         const std::function<bool()>& stop);
  /// Why there is no finer body to solve, or "".
  std::string limit() const;
  /// How long the next body may take [s].
  double seconds_to_come() const { return (finer_spacing_ > 0 ? kGrowthOfImage : kGrowth) * levels_.back().seconds; }
  /// How long the next body may take, and how well the measures are known by those before it: for progress reports.
  std::string outlook(const std::vector<Reference>& references) const;
  void refine();

  const Scene& scene_;
  const Catalog& catalog_;
  std::vector<std::string> overrides_;
  std::unique_ptr<Scene> first_;
  Body body_;  // as the scene describes it: not turned
  bool filled_ = false;
  double finer_spacing_ = 0;  ///< [m] of the boxes of an image, for the next body
  bool of_image_ = false;     ///< whether the bodies after the first are made from the image again
  std::string law_;
  Positions guess_;
  std::vector<Level> levels_;
};

void Sequence::load() {
  first_ = load_scene_on(scene_.source, catalog_, overrides_, [&](Body& body, const Material& material) {
    filled_ = body.voronoi && body.tetrahedra.empty();
    if (!filled_) body_ = body = domain_of(body, material);
  });
  finer_spacing_ = first_->specimen.image ? first_->specimen.image->finer_spacing : 0;
}

std::unique_ptr<Scene> Sequence::scene_on_body() {
  if (first_) return std::move(first_);
  return load_scene_on(scene_.source, catalog_, overrides_, [&](Body& body, const Material&) { body = body_; });
}

std::function<void(const std::string&)> Sequence::of_level(const std::function<void(const std::string&)>& progress,
                                                           const std::string& before) const {
  if (!progress) return {};
  const std::string what =
      fmt::format("reference, {} on {} {}{}", law_, count_cells(body_), kind_of_cells(body_), before);
  progress(what);
  return [progress, what](const std::string& doing) { progress(what + ": " + doing); };
}

std::string Sequence::limit() const {
  if (of_image_ && finer_spacing_ == 0) return "the image's voxels are no smaller";
  const int children = is_solid(body_) ? 8 : 4;
  if (static_cast<double>(count_cells(body_)) * children > scene_.computed.most_cells)
    return fmt::format("at most {} cells (computed.most_cells)", scene_.computed.most_cells);
  if (seconds_to_come() > scene_.computed.seconds)
    return "at most " + readable_seconds(scene_.computed.seconds) + " (computed.seconds)";
  return "";
}

std::string Sequence::outlook(const std::vector<Reference>& references) const {
  if (levels_.empty()) return "";
  double least_known = 0;
  for (const Reference& reference : references)
    if (scene_.measures->at(reference.measure).unit != dimension::none)
      least_known = std::max(least_known, reference.uncertainty);
  return fmt::format(", up to {}{}", readable_seconds(seconds_to_come()),
                     least_known > 0 ? fmt::format(" (known to {:.2g} %, target {:.2g} %)", 100 * least_known,
                                                   100 * scene_.computed.uncertainty)
                                     : "");
}

std::vector<Reference> Sequence::limits_by_order(const Scene& scene, const StrategyChoice& choice,
                                                 const std::function<void(const std::string&)>& progress,
                                                 const std::function<bool()>& stop) {
  // Cells of first order are off by four times as much or more, also at singular edges.
  constexpr double part = 1. / 3;
  const Body second = body_;
  body_ = with_order(second, 1);
  set_matter(body_, scene.specimen.material.density, scene.specimen.material.thickness, second.radius.mean());
  body_.mass *= second.mass.sum() / body_.mass.sum();
  Level coarse = solve_level(*scene_on_body(), choice, {}, 2, of_level(progress), stop);
  body_ = second;
  if (!coarse.trouble.empty()) return {};
  const std::vector<Level> both{std::move(coarse), levels_.front()};
  std::vector<Reference> references;
  for (const std::string& name : measures_of(scene, both)) {
    const double value = both[1].measures.get(name), off = both[0].measures.get(name) - value;
    references.push_back(
        {name, value,
         fmt::format("computed: {} on {} {}, compared with first order", law_, both[1].cells, kind_of_cells(body_)),
         part * std::abs(off / value), true});
  }
  return references;
}

void Sequence::refine() {
  if (finer_spacing_ > 0) {
    const Body coarse = std::move(body_);
    overrides_.push_back(fmt::format("body.image.spacing={:.17g} m", finer_spacing_));
    load();
    of_image_ = true;
    guess_ = moved_with(coarse, levels_.back().positions, body_.rest);
    return;
  }
  Body finer = refined(body_);
  guess_ = Positions();
  if (const Positions& found = levels_.back().positions; found.cols() == body_.size()) {
    guess_ = Positions::Zero(3, finer.size());
    guess_.leftCols(body_.size()) = found;
    for (int molecule = body_.size(); molecule < finer.size(); ++molecule)
      for (const auto& [from, weight] :
           finer.between[finer.between.size() - static_cast<std::size_t>(finer.size() - molecule)])
        guess_.col(molecule) += weight * found.col(from);
  }
  body_ = std::move(finer);
}

ComputedReferences Sequence::solve(const std::function<void(const std::string&)>& progress,
                                   const std::function<bool()>& stop) {
  const Stopwatch watch;
  const StrategyChoice choice = choose_strategy(catalog_, law_);
  ComputedReferences result;
  for (double spacing = 1;; spacing /= 2) {
    const auto report = of_level(progress, outlook(result.references));
    const auto scene = scene_on_body();
    const Stopwatch of_body;
    const auto too_long = [&] { return of_body.seconds() > scene_.computed.seconds; };
    levels_.push_back(
        solve_level(*scene, choice, guess_, spacing, report, [&] { return (stop && stop()) || too_long(); }));
    if (!levels_.back().trouble.empty()) {
      const std::string why =
          too_long() ? fmt::format("given up after {} (computed.seconds)", readable_seconds(scene_.computed.seconds))
                     : levels_.back().trouble;
      result.trouble = fmt::format("{} on {} {}: {}", law_, levels_.back().cells, kind_of_cells(body_), why);
      levels_.pop_back();
      break;
    }
    result.references = limits_of(*scene, levels_, law_, of_image_);
    if (known(scene_, result.references, levels_, scene_.computed.uncertainty)) break;
    if (const std::string why = limit(); !why.empty()) {
      if (levels_.size() == 1) result.references = limits_by_order(*scene, choice, progress, stop);
      result.trouble = why;
      break;
    }
    if (stop && stop()) break;
    refine();
  }
  if (stop && stop())
    result.trouble = "interrupted";
  else if (!result.references.empty())
    result.trouble.clear();
  for (Reference& reference : result.references) {
    reference.seconds = watch.seconds();
    if (finer_spacing_ > 0) reference.source += ", of boxes larger than the image's voxels";
  }
  return result;
}

/// A value that is smaller than its uncertainty is none: it has no limit, or the bodies are far from it.
ComputedReferences without_unlimited(const Scene& scene, ComputedReferences found) {
  const auto has_unit = [&](const Reference& r) { return scene.measures->at(r.measure).unit != dimension::none; };
  const auto unlimited = [&](const Reference& r) { return has_unit(r) && !(r.uncertainty <= 1); };
  std::string names;
  for (const Reference& reference : found.references)
    if (unlimited(reference))
      names += (names.empty() ? "" : ", ") + std::string(scene.measures->at(reference.measure).label());
  if (names.empty()) return found;
  std::erase_if(found.references, unlimited);
  // A ratio alone says nothing of what has a unit.
  if (std::none_of(found.references.begin(), found.references.end(), has_unit)) found.references.clear();
  found.trouble =
      "no limit shows of " + names +
      " as the cells are refined (a grip or load on a point or an edge yields without limit: hold a patch of "
      "the surface)";
  return found;
}

using Json = nlohmann::ordered_json;

/// Checksum of what a problem's entry has before it.
std::string sum_of(const Json& entry) { return key_of(std::vector{entry.dump()}); }

Json json_of(const ComputedReferences& found) {
  Json list = Json::array();
  for (const Reference& reference : found.references)
    list.push_back({{"measure", reference.measure},
                    {"value", reference.value},
                    {"uncertainty", reference.uncertainty},
                    {"source", reference.source},
                    {"seconds", reference.seconds}});
  Json json{{"trouble", found.trouble}, {"references", list}};
  json["sum"] = sum_of(json);
  return json;
}

ComputedReferences references_of_json(const Json& json) {
  ComputedReferences found;
  found.trouble = json.at("trouble");
  for (const Json& one : json.at("references"))
    found.references.push_back(
        {one.at("measure"), one.at("value"), one.at("source"), one.at("uncertainty"), true, one.at("seconds")});
  return found;
}

}  // namespace

ReferenceStore::ReferenceStore(const std::string& folder) {
  if (folder.empty()) return;
  path_ = folder + "/references.json";
  std::ifstream stream(path_, std::ios::binary);
  if (!stream) return;
  try {
    const Json json = Json::parse(std::string(std::istreambuf_iterator<char>(stream), {}));
    if (json.at("version") != kVersion) return;
    for (const auto& [key, found] : json.at("problems").items()) {
      Json entry = found;
      entry.erase("sum");
      // What is damaged is computed again.
      if (found.value("sum", "") == sum_of(entry)) known_[key] = references_of_json(found);
    }
  } catch (const Json::exception&) {
    known_.clear();
  }
}

const ComputedReferences* ReferenceStore::find(const std::string& key) const {
  const auto found = known_.find(key);
  return found == known_.end() ? nullptr : &found->second;
}

void ReferenceStore::add(const std::string& key, ComputedReferences found) {
  known_[key] = std::move(found);
  write();
}

void ReferenceStore::add(const ReferenceStore& other) {
  const std::size_t before = known_.size();
  known_.insert(other.known_.begin(), other.known_.end());
  if (known_.size() > before) write();
}

void ReferenceStore::write() const {
  if (path_.empty()) return;
  Json problems = Json::object();
  for (const auto& [known, references] : known_) problems[known] = json_of(references);
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(path_).parent_path(), ignored);
  write_whole(path_, Json{{"version", kVersion}, {"problems", problems}}.dump(1) + "\n");
}

bool wants_computed_references(const Scene& scene, const std::string& option) {
  using When = ComputedReference::When;
  if (option == "none" || (option.empty() && scene.computed.when == When::never)) return false;
  if (option == "computed" || scene.computed.when == When::always) return true;
  return scene.references.empty() && !no_reference(scene).empty();
}

ComputedReferences compute_references(const Scene& scene, const Catalog& catalog,
                                      const std::vector<std::string>& overrides, ReferenceStore& store,
                                      const std::function<void(const std::string&)>& progress,
                                      const std::function<bool()>& stop) {
  if (std::string why = unsuited(scene); !why.empty()) return {{}, std::move(why)};
  try {
    Sequence sequence(scene, catalog, overrides);
    const std::string key = problem_key(scene, sequence.first(), sequence.law());
    if (const ComputedReferences* known = store.find(key)) {
      ComputedReferences found = *known;
      for (Reference& reference : found.references) reference.read_back = true;
      return without_unlimited(scene, std::move(found));
    }
    ComputedReferences found = sequence.solve(progress, stop);
    if (found.trouble != "interrupted") store.add(key, found);
    return without_unlimited(scene, std::move(found));
  } catch (const InputError& error) {
    return {{}, error.what()};
  }
}

}  // namespace elastin::lab
