#include "lab/run/contact_measures.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

#include "contact/distance.h"
#include "core/base/named.h"
#include "core/forces/floor.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"
#include "elastin/core/solve/engine.h"
#include "lab/run/cell_stress.h"

namespace elastin::lab {
namespace {

/// A prescribed force counts as met when it is this near.
constexpr double kForceTolerance = 1e-7;

}  // namespace

contact::Contact* contact_of(const Model& model) {
  for (const auto& load : model.loads())
    if (auto* contact = dynamic_cast<contact::Contact*>(load.get())) return contact;
  return nullptr;
}

std::string gap_text(const contact::Contact& contact, const Body& body, const State& state) {
  const std::vector<contact::Obstacle>& obstacles = contact.obstacles();
  const std::vector<contact::Pose> poses = contact.poses(state.time);
  double least = std::numeric_limits<double>::infinity();
  std::string nearest;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const contact::SignedDistance shape(obstacles[i].shape);
    double gap = std::numeric_limits<double>::infinity();
    for (int molecule = 0; molecule < body.size(); ++molecule)
      gap = std::min(gap,
                     shape.at(poses[i].turn.transpose() * (state.positions.col(molecule) - poses[i].position)).value);
    gap = least_over(body, gap);
    if (gap < least) least = gap, nearest = obstacles[i].name;
  }
  if (nearest.empty()) return "";
  return "the obstacle '" + nearest + "' " +
         (least < 0 ? "lies between the points at which touch is felt" : "is " + number(1e3 * least, 3) + " mm away");
}

int find_obstacle(const std::vector<contact::Obstacle>& obstacles, const std::string& name) {
  const contact::Obstacle* found = find_named(obstacles, name);
  return found ? static_cast<int>(found - obstacles.data()) : -1;
}

double largest_force(const contact::ContactReport& report) {
  double largest = 0;
  for (const Vector3& force : report.on_obstacles) largest = std::max(largest, force.norm());
  return largest > 0 ? largest : report.between_pieces.norm();
}

void note_contact(const contact::ContactReport& report, double copies, Measures& measures) {
  // Parts of a whole have forces across, too; those of a piece on itself have no sum that is the force of one on
  // another.
  const double force = largest_force(report);
  if (copies == 1 && (force > 0 || report.pairs == 0)) measures.set("contact_force", force);
  measures.set("contact_area", copies * report.area);
  measures.set("largest_pressure", report.largest_pressure);
  measures.set("largest_penetration", report.largest_penetration);
  measures.set("contacts", report.pairs);
  measures.set("sticking", report.sticking);
}

namespace {

/// Floors that are loads, as planes.
std::vector<contact::Obstacle> floors_of(const Model& model) {
  std::vector<contact::Obstacle> planes;
  for (const auto& load : model.loads())
    if (const Floor* floor = floor_of(*load)) {
      const auto turn = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), floor->normal);
      planes.push_back({"floor", contact::shape::Plane{}, {turn.toRotationMatrix(), floor->point}});
    }
  return planes;
}

}  // namespace

Snapshot snapshot_of(const Model& model, const State& state, double at, int number) {
  Snapshot shot{at, state.positions, {}, number};
  shot.force_densities = model.force_densities(state.positions);
  const CellNodes cells(model.body());
  std::vector<CellState> states(cells.size());
  std::size_t shown = 0, at_cell = 0;
  VectorX others = model.show_cells(state.positions, [&](std::span<const int> molecules, const CellState& own) {
    // Each law shows its cells in their order here.
    for (std::size_t seen = 0; seen < cells.size(); ++seen, at_cell = (at_cell + 1) % cells.size()) {
      if (!std::ranges::equal(cells.of(at_cell), molecules)) continue;
      CellState& sum = states[at_cell];  // fibres add theirs
      if (!own.strain.isZero(0)) sum.strain = own.strain;
      sum.stress += own.stress;
      ++shown;
      at_cell = (at_cell + 1) % cells.size();
      return;
    }
  });
  if (shown > 0) {
    shot.states_of_laws = std::move(states);
    if (!others.isZero(0)) shot.other_force_densities = std::move(others);
  }
  if (!model.nodal_laws().empty()) shot.elastic_forces = model.elastic_forces(state.positions);
  if (const contact::Contact* contact = contact_of(model)) {
    contact::ContactReport report = contact->report(state);
    shot.contact_forces = std::move(report.forces);
    shot.contact_pressure = std::move(report.pressure);
    shot.obstacles = contact->poses(at);
  }
  for (const contact::Obstacle& plane : floors_of(model)) shot.obstacles.push_back(plane.pose);
  return shot;
}

void keep_snapshot(const Model& model, const State& state, double at, int number, const RunOptions& options, Run& run) {
  if (!options.keep_snapshots) return;
  if (options.last_snapshot) run.snapshots.clear();
  run.snapshots.push_back(snapshot_of(model, state, at, number));
  if (!options.last_snapshot) keep_states(run.snapshots.back());
  if (run.obstacles.empty()) {  // contact's first, as in snapshot_of
    if (const contact::Contact* contact = contact_of(model)) run.obstacles = contact->obstacles();
    std::ranges::move(floors_of(model), std::back_inserter(run.obstacles));
  }
  if (!model.body().share) return;
  Positions& forces = run.snapshots.back().elastic_forces;
  forces = model.elastic_forces(state.positions);
  options.statics.engine->complete(model, forces);
}

void ForceControl::aim(double fraction) {
  fraction_ = fraction;
  if (fraction == 0) {
    before_displacement_ = before_force_ = last_displacement_ = last_force_ = 0;
  } else if (last_force_ > 0) {
    displacement_ = towards(fraction * wanted_);
  }
}

bool ForceControl::adjust(double force) {
  // Two points that are almost one would say little of the slope.
  if (std::abs(displacement_ - last_displacement_) > 1e-3 * std::abs(displacement_))
    before_displacement_ = last_displacement_, before_force_ = last_force_;
  last_displacement_ = displacement_, last_force_ = force;
  const double wanted = fraction_ * wanted_;
  if (std::abs(force - wanted) <= kForceTolerance * wanted_) return false;
  displacement_ = towards(wanted);
  return true;
}

/// Along the secant, but to no less than half and no more than twice the displacement; where nothing resists yet,
/// twice.
double ForceControl::towards(double force) const {
  const double slope = (last_force_ - before_force_) / (last_displacement_ - before_displacement_),
               now = std::abs(last_displacement_);
  if (!(slope > 0)) return last_displacement_ + now;
  return last_displacement_ + std::clamp((force - last_force_) / slope, -0.5 * now, now);
}

}  // namespace elastin::lab
