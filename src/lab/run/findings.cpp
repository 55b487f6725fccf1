#include "lab/run/specimen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/distance.h"
#include "contact/surface_check.h"
#include "core/base/disjoint_sets.h"
#include "core/geometry/boundary.h"
#include "core/model/block_geometry.h"
#include "core/simulation/warnings.h"
#include "core/solve/trial.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/model/share.h"
#include "lab/run/contact_measures.h"
#include "lab/run/uniform_block.h"

namespace elastin::lab {
namespace {

using contact::Obstacle;
namespace shape = contact::shape;

/// Depth at the start above which something overlaps, in molecules' diameters.
constexpr double kOverlap = 1e-3;
/// Depth above which bodies are far into each other: of molecules' diameters, or of the thinnest body.
constexpr double kDeep = 0.25;
/// Of a rebound's speed to that of the impact: what explicit steps near the longest stable one may do.
constexpr double kRebound = 1.02;
/// Part of a stress that is no isotropic material's.
constexpr double kAnisotropic = 0.05;
/// Of the kinetic to the elastic energy: driven motion errs by as much, an oscillation by its root.
constexpr double kMoving = 2e-3;
/// Of damping to what the laws bear; and of the energy by which a load grows within a frame.
constexpr double kDamped = 0.01, kGrows = 1e-3;

/// Fewest loaded molecules of which one is told from the rest; and how many times as far as most one must have moved.
constexpr std::size_t kFewLoaded = 8;
constexpr double kFarther = 5;

/// The second of an obstacle's extents [m], by size: what must fit between samples for it to pass.
double width_of(const Obstacle& obstacle) {
  struct Visitor {
    double operator()(const shape::Plane&) const { return std::numeric_limits<double>::infinity(); }
    double operator()(const shape::Box& box) const { return middle(box.size); }
    double operator()(const shape::Sphere& sphere) const { return 2 * sphere.radius; }
    double operator()(const shape::Cylinder& c) const { return middle({2 * c.radius, 2 * c.radius, c.length}); }
    double operator()(const shape::Capsule& capsule) const { return 2 * capsule.radius; }
    double operator()(const shape::Convex& convex) const { return of(convex.points); }
    double operator()(const shape::Mesh& mesh) const { return of(mesh.points); }
    static double middle(const Vector3& size) { return size.sum() - size.maxCoeff() - size.minCoeff(); }
    static double of(const Positions& points) {
      return middle(points.rowwise().maxCoeff() - points.rowwise().minCoeff());
    }
  };
  return std::visit(Visitor{}, obstacle.shape);
}

std::string length_text(double meters) { return number(1e3 * meters, 3) + " mm"; }

/// How deep a molecule may get into an obstacle before it leaves it by the other side [m].
double passing_depth(const Specimen& specimen, const Obstacle& obstacle) {
  const bool spheres = specimen.contact->surface == contact::ContactSurface::spheres;
  return contact::half_thickness(obstacle.shape) + (spheres ? specimen.body.radius.mean() : 0);
}

/// The least extent along an axis of any piece that has three of them [m]; the largest number, if none has.
double thinnest_piece(const Body& body) {
  const BodyFindings findings = inspect(body);
  constexpr double most = std::numeric_limits<double>::max();
  std::vector<Vector3> low(findings.pieces, Vector3::Constant(most)), high(findings.pieces, Vector3::Constant(-most));
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const int piece = findings.piece_of[molecule];
    low[piece] = low[piece].cwiseMin(body.rest.col(molecule));
    high[piece] = high[piece].cwiseMax(body.rest.col(molecule));
  }
  double least = most;
  for (int piece = 0; piece < findings.pieces; ++piece)
    if (const double thin = (high[piece] - low[piece]).minCoeff(); thin > 0) least = std::min(least, thin);
  return least;
}

/// That what touches is pressed in further than is right for molecules and bodies of this size, or "".
std::string deep_text(const Body& body, double deepest) {
  if (!(deepest > 0)) return "";
  const double apart = 2 * body.radius.mean(), thinnest = thinnest_piece(body);
  if (!(deepest > kDeep * std::min(apart, thinnest))) return "";
  return "what touches is pressed in by up to " + length_text(deepest) + ", " +
         (thinnest < apart ? "and the thinnest body is " + length_text(thinnest) + " thick"
                           : "and molecules are " + length_text(apart) + " wide") +
         ": a larger `stiffness` of the contact, or a bound of the `penetration`, brings it nearer to the surface";
}

}  // namespace

/// Whether some cell has another E or ν than the material, by its fields.
bool has_other_moduli(const Body& body, const Material& material) {
  if (!material.field) return false;
  const auto differs = [&](const auto& cell) {
    Vector3 middle = Vector3::Zero();
    for (const int molecule : cell) middle += body.rest.col(molecule) / static_cast<double>(std::size(cell));
    const Material own = local_material(material, middle);
    return std::abs(own.youngs_modulus / material.youngs_modulus - 1) > 1e-9 ||
           std::abs(own.poissons_ratio - material.poissons_ratio) > 1e-9;
  };
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell)
      if (differs(block.cell(cell))) return true;
  return std::ranges::any_of(body.tetrahedra, differs) || std::ranges::any_of(body.triangles, differs);
}

std::string no_one_modulus(const Specimen& specimen) {
  if (specimen.materials.size() > 1) return "the bodies are of several materials";
  return has_other_stiffness(specimen.body) || has_other_moduli(specimen.body, specimen.material)
             ? "the body is not everywhere as stiff as the scene's material"
             : "";
}

std::vector<std::string> findings_at_start(const Specimen& specimen, const Model& model, bool uses_cells) {
  std::vector<std::string> found;
  const Body& body = specimen.body;
  if (std::string doubles = warning_of_doubles(body, uses_cells); !doubles.empty()) found.push_back(std::move(doubles));
  const contact::Contact* contact = contact_of(model);
  if (!contact) return found;
  const contact::ContactReport report = contact->report(state_at_rest(body));
  if (report.largest_penetration > kOverlap * 2 * body.radius.mean())
    found.push_back("at the start " + counted(report.pairs, "pair") + " of what touches " +
                    (report.pairs == 1 ? "overlaps" : "overlap") + " by up to " +
                    length_text(report.largest_penetration) + ": it is pushed apart with the energy of that");
  const bool triangles = specimen.contact->surface == contact::ContactSurface::triangles;
  for (const Obstacle& obstacle : specimen.contact->obstacles)
    if (const double width = width_of(obstacle), apart = mean_length(body); triangles && width < apart / 2)
      found.push_back("the obstacle '" + obstacle.name + "' is " + length_text(width) +
                      " wide, and what it meets is felt at points some " + length_text(apart / 2) +
                      " apart: it may pass between them; refine the surface");
  return found;
}

std::shared_ptr<const StrategyChoice> stated_law(const Catalog& catalog, const Material& material, const Body& body) {
  if (!material.law && !material.curve) return nullptr;
  const int dimensions = body.tetrahedra.empty() && !body.triangles.empty() ? 2 : 3;
  try {
    return std::make_shared<StrategyChoice>(
        choose_strategy(catalog, StrategyName::of_law(material.law ? material.law->law : "curve", dimensions)));
  } catch (const InputError&) {
    return nullptr;  // of membranes alone, or of another catalog
  }
}

void measure_law(const Specimen& specimen, const Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options, Run& run) {
  constexpr double no_strain = 1e-6;  // below it a secant is the slope at rest
  const StrategyChoice& law = specimen.law ? *specimen.law : choice;
  const bool one = specimen.body.parts.empty() && !specimen.material.varies();
  if (!experiment.at_rest() || run.outcome != Outcome::converged || options.statics.linear || !one ||
      law.strategy.kind != StrategyKind::cell_law)
    return;
  const std::optional<UniformTest> test = experiment.at_rest()->uniform(run.measures);
  if (!test || !(std::abs(test->strain) > no_strain)) return;
  Material material = specimen.material;
  if (material.relaxation) material.relaxation->instantaneous = false;  // the law itself, whether it relaxes or not
  if (const auto found = measured_on_block(*test, specimen.body, law.strategy, material, law.values))
    run.law = *found, run.law_strain = test->strain;
}

namespace {

/// Kinetic energy over that stored by the load, the largest in the last quarter of a run in time; 0 where a law has no
/// energy.
double liveliness(const Run& run) {
  double kinetic = 0, stored = 0;
  for (std::size_t i = run.curve.size() - (run.curve.size() + 3) / 4; i < run.curve.size(); ++i) {
    const Measures& row = run.curve[i].measures;
    kinetic = std::max(kinetic, row.get("kinetic_energy"));
    stored = std::max(stored, row.get(std::isfinite(row.get("energy_increase")) ? "energy_increase" : "energy"));
  }
  return stored > 0 ? kinetic / stored : 0;
}

/// What drag and damping by mass have taken over the most that was stored, where time constants or moduli were read
/// from the whole history: all of it is in them. Damping of deformation is the material's. 0 without.
double drag_in_history(const Model& model, const Run& run) {
  const bool drags =
      std::any_of(model.loads().begin(), model.loads().end(), [](const auto& load) { return load->resists(); });
  const auto is_read = [&](const char* name) { return std::isfinite(run.measures.get(name)); };
  const char* const read[] = {"loss_modulus", "relaxation_time", "relaxed_ratio"};
  if (!drags || !std::any_of(std::begin(read), std::end(read), is_read)) return 0;
  double stored = 0;
  for (const CurvePoint& row : run.curve)
    if (const double energy = row.measures.get("energy"); energy > stored) stored = energy;
  return stored > 0 ? run.curve.back().measures.get("dissipated_energy") / stored : 0;
}

/// What damping and drag bear over what the laws do while the load still grows at the end of a run in time: by what
/// either took over the last frame. 0 without them, and where nothing grows.
double damped_share(const Model& model, const Run& run) {
  const bool damped = !model.viscosity().empty() || std::any_of(model.loads().begin(), model.loads().end(),
                                                                [](const auto& load) { return load->resists(); });
  if (!damped || model.dissipates() || run.curve.size() < 2) return 0;
  const Measures &before = run.curve[run.curve.size() - 2].measures, &now = run.curve.back().measures;
  const double stored = now.get("energy") - before.get("energy"),
               lost = now.get("dissipated_energy") - before.get("dissipated_energy");
  return stored > kGrows * now.get("energy") ? lost / stored : 0;
}

/// That the surface of a piece, which no contact holds off itself, has come to cross itself, and where; or "". A body
/// none of whose molecules has moved by a connection's length is not looked at.
std::string self_crossing(const Specimen& specimen, const Positions& end) {
  const Body& body = specimen.body;
  if (body.share || end.cols() == 0 || end.cols() != body.size() || (specimen.contact && specimen.contact->self) ||
      !((end - body.rest).colwise().squaredNorm().maxCoeff() > std::pow(mean_length(body), 2)))
    return "";
  const Cells<3> surface = body.tetrahedra.empty() ? body.triangles : boundary_of(body.tetrahedra);
  DisjointSets pieces(static_cast<std::size_t>(body.size()));
  for (const auto& [a, b] : body.connections.ends) pieces.join(a, b);
  const auto in_one_piece = [&](int a, int b) { return pieces.set_of(surface[a][0]) == pieces.set_of(surface[b][0]); };
  const contact::Crossings found = contact::find_crossings(end, surface, in_one_piece);
  if (found.count == 0 || contact::find_crossings(body.rest, surface, in_one_piece).count > 0) return "";
  const Vector3 at = 1e3 * positions_of(end, surface[found.first[0]]).rowwise().mean();
  return "the body goes through itself: " + counted(static_cast<int>(found.count), "pair") +
         " of its surface's triangles cut each other, one near (" + number(at.x(), 4) + ", " + number(at.y(), 4) +
         ", " + number(at.z(), 4) + ") mm; `contact: {self: true}` holds it off itself";
}

/// That some of many molecules which a force loads have moved far further than the rest of them, and which; or "". Of a
/// share of a body, whose loaded molecules are others' too, nothing is said.
std::string weakly_held(const Model& model, const Positions& end) {
  const Body& body = model.body();
  if (body.share || end.cols() != body.size()) return "";
  for (const auto& load : model.loads()) {
    const auto* forces = dynamic_cast<const PointLoads*>(load.get());
    if (!forces || forces->molecules().size() < kFewLoaded) continue;
    std::vector<std::pair<double, int>> motions;
    for (const int molecule : forces->molecules())
      motions.emplace_back((end.col(molecule) - body.rest.col(molecule)).norm(), molecule);
    std::sort(motions.begin(), motions.end());
    const double usual = motions[motions.size() / 2].first;
    const auto [farthest, molecule] = motions.back();
    if (!(farthest > kFarther * usual && motions[motions.size() * 9 / 10].first < kFarther * usual)) continue;
    const Vector3 at = 1e3 * body.rest.col(molecule);
    return "of " + counted(static_cast<int>(motions.size()), "loaded molecule") + " the one at (" + number(at.x(), 4) +
           ", " + number(at.y(), 4) + ", " + number(at.z(), 4) + ") mm, which the body holds weakly, has moved " +
           number(1e3 * farthest, 3) + " mm, most of them " + number(1e3 * usual, 3) +
           " mm: it is part of every mean over them; a displacement in place of the force moves them alike";
  }
  return "";
}

}  // namespace

std::vector<std::string> findings_at_end(const Specimen& specimen, const MeasureList& list, const Model& model,
                                         const Run& run) {
  std::vector<std::string> found;
  const bool reads_stiffness = std::any_of(list.begin(), list.end(), [&](const MeasureInfo& one) {
    return is_property(one.role) && std::isfinite(run.measures.get(one.name));
  });
  const std::vector<Material> materials = materials_of(specimen);
  if (const double restitution = run.measures.get("restitution"); restitution > kRebound)
    found.push_back("it rebounds " + number(restitution, 3) +
                    " times as fast as it came: the steps are too long for the contact");
  if (const double off = run.measures.get("isotropy_error"); off > kAnisotropic)
    found.push_back(
        "the body is stiffer along one direction than along the other: the stresses of an isotropic "
        "material with its modulus and Poisson's ratio differ from its own by up to " +
        number(100 * off, 2) + " %");
  if (const auto& rest = specimen.body.unstressed; reads_stiffness && rest && run.time)
    found.emplace_back(
        "the modulus is of all forces, those of `rest` too; an experiment at rest with `factor: 1` has them before the "
        "load");
  else if (reads_stiffness && rest && (!rest->part || rest->part(0) != rest->part(1)))
    found.emplace_back(
        "the modulus is of all forces, those of `rest` too, which comes with the load: `factor: 1` has it before");
  if (const double lively = reads_stiffness && run.time ? liveliness(run) : 0; lively > kMoving && !run.curve.empty())
    found.push_back("the body moves at the end, with a kinetic energy of " + number(100 * lively, 2) +
                    " % of the elastic one: the modulus includes forces of inertia; a slower load, damping or a longer "
                    "duration leaves less of them");
  const double dragged = run.time ? drag_in_history(model, run) : 0;
  if (dragged > kDamped)
    found.push_back("drag and damping by mass took " + number(100 * dragged, 2) +
                    " % of the most that was stored: moduli, times and ratios that are read from the history are of "
                    "the body in its medium; leave these loads out for those of the material");
  else if (const double damped = reads_stiffness && run.time ? damped_share(model, run) : 0; damped > kDamped)
    found.push_back("damping bears about " + number(100 * damped, 2) +
                    " % of what the material does at the end: the modulus includes it; a slower load, or one that "
                    "ends before the run, leaves less of it");
  if (reads_stiffness && run.time &&
      std::any_of(materials.begin(), materials.end(), [](const Material& one) { return one.active.has_value(); }))
    found.emplace_back(
        "the modulus is of all forces, those of the active fibres too; an experiment at rest has them before the load");
  if (std::string crossing = self_crossing(specimen, run.end); !crossing.empty()) found.push_back(std::move(crossing));
  if (std::string weak = weakly_held(model, run.end); !weak.empty()) found.push_back(std::move(weak));
  if (!specimen.contact) return found;
  double deepest = 0, speed = 0;
  for (const CurvePoint& row : run.curve) {
    if (const double depth = row.measures.get("largest_penetration"); depth > deepest) deepest = depth;
    if (const double now = row.measures.get("speed"); now > speed) speed = now;
  }
  if (std::string deep = deep_text(specimen.body, deepest); !deep.empty()) found.push_back(std::move(deep));
  // A molecule of mass m on an area A comes to rest at a depth of v √(m/(k A)).
  double slowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < specimen.body.size(); ++i)
    slowest = std::min(slowest, std::sqrt(specimen.contact->stiffness * 4 * std::pow(specimen.body.radius[i], 2) /
                                          specimen.body.mass[i]));
  for (const Obstacle& obstacle : specimen.contact->obstacles) {
    const double most = passing_depth(specimen, obstacle);
    const double stopped = run.time ? speed / slowest : 0;
    if (deepest > most || stopped > most)
      found.push_back("something may have passed through the obstacle '" + obstacle.name + "': " +
                      (deepest > most ? "it was pressed in by " + length_text(deepest)
                                      : "at " + number(speed, 3) + " m/s the contact stops a molecule within " +
                                            length_text(stopped)) +
                      ", and it holds " + length_text(most) + "; make the contact stiffer");
  }
  return found;
}

}  // namespace elastin::lab
