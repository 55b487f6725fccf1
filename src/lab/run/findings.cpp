#include "lab/run/specimen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/thickness.h"
#include "core/solve/trial.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"
#include "lab/run/contact_measures.h"

namespace elastin::lab {
namespace {

using contact::Obstacle;
namespace shape = contact::shape;

/// Depth at the start above which something overlaps, in molecules' diameters.
constexpr double kOverlap = 1e-3;
/// Of a rebound's speed to that of the impact: what explicit steps near the longest stable one may do.
constexpr double kRebound = 1.02;

int count_doubles(std::vector<std::vector<int>> cells) {
  for (std::vector<int>& cell : cells) std::sort(cell.begin(), cell.end());
  std::sort(cells.begin(), cells.end());
  int count = 0;
  for (std::size_t cell = 1; cell < cells.size(); ++cell) count += cells[cell] == cells[cell - 1];
  return count;
}

/// Cells whose nodes are another's.
int cells_given_twice(const Body& body) {
  std::vector<std::vector<int>> cells;
  const auto add = [&](const auto& all) {
    for (const auto& cell : all)
      if (lowest_in_whole(body, cell) < owned_molecules(body)) cells.emplace_back(cell.begin(), cell.end());
  };
  if (body.blocks.empty()) add(body.tetrahedra), add(body.triangles);

  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      cells.emplace_back(nodes.begin(), nodes.end());
    }
  return count_doubles(std::move(cells));
}

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

}  // namespace

std::vector<std::string> findings_at_start(const Specimen& specimen, const Model& model, bool uses_cells) {
  std::vector<std::string> found;
  const Body& body = specimen.body;
  if (const int doubles = static_cast<int>(sum_over(body, cells_given_twice(body))); doubles > 0)
    found.push_back(counted(doubles, "cell") + (doubles == 1 ? " is" : " are") + " given twice" +
                    (uses_cells ? ": there the body is twice as stiff" : ""));
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

double largest_poissons_ratio(const Material& material, const Body& body) {
  double most = material.poissons_ratio;
  for (int molecule = 0; material.field && molecule < body.size(); ++molecule)
    most = std::max(most, local_material(material, body.rest.col(molecule)).poissons_ratio);
  return most;
}

namespace {

double largest_in(const Specimen& specimen) {
  double most = largest_poissons_ratio(specimen.material, specimen.body);
  for (const Material& material : specimen.materials)
    most = std::max(most, largest_poissons_ratio(material, specimen.body));
  return most;
}

}  // namespace

bool may_lock(const Specimen& specimen, const Strategy& strategy) {
  return strategy.kind == StrategyKind::cell_law && strategy.dimensions == 3 && !strategy.volume_modulus &&
         largest_in(specimen) > kLocking;
}

std::string locking_finding(const Specimen& specimen, const Strategy& strategy) {
  const bool can = strategy.make_without_volume || strategy.make_mixed, blocks = has_blocks(specimen.body, 3);
  if (!may_lock(specimen, strategy) || (!can && blocks)) return "";
  StrategyName with_volume(strategy.name);
  with_volume.volume = true;
  const std::string with = "stiffness: " + with_volume.text(),
                    found = "nu = " + number(largest_in(specimen), 4) +
                            ": cells without a volume term may lock, and are then too stiff; ";
  if (strategy.make_without_volume || (strategy.make_mixed && blocks)) return found + "write " + with;
  if (strategy.make_mixed) return found + "write `order: 2` in the body and " + with;
  return found + (strategy.has_history ? "give the law behind the colon one: neo_hookean+volume"
                                       : "neo_hookean+volume has one");
}

std::vector<std::string> findings_at_end(const Specimen& specimen, const Run& run) {
  std::vector<std::string> found;
  if (const double restitution = run.measures.get("restitution"); restitution > kRebound)
    found.push_back("it rebounds " + number(restitution, 3) +
                    " times as fast as it came: the steps are too long for the contact");
  if (!specimen.contact) return found;
  double deepest = 0, speed = 0;
  for (const CurvePoint& row : run.curve) {
    if (const double depth = row.measures.get("largest_penetration"); depth > deepest) deepest = depth;
    if (const double now = row.measures.get("speed"); now > speed) speed = now;
  }
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
