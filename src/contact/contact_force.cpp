#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>

#include "contact/distance.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin::contact {
namespace {

std::vector<Sample> samples_of(const Body& body, ContactSurface surface, const SurfaceSides& sides) {
  if (surface == ContactSurface::spheres) return sphere_samples(body, surface_molecules(body));
  return side_samples(body, sides);
}

void add(const ContactResponse& response, const Vector3& normal, const Vector3& tangential, Positions& forces) {
  for (int i = 0; i < response.count; ++i) {
    const Side& side = response.sides[i];
    forces.col(side.molecule) += side.normal * normal + side.tangential * tangential;
  }
}

}  // namespace

ContactForce::ContactForce(const Body& body, const ContactOptions& options, const SurfaceSides& sides)
    : body_(body),
      options_(options),
      spheres_(options.surface == ContactSurface::spheres),
      damping_ratio_(damping_ratio_of(options.restitution)),
      search_(body, samples_of(body, options.surface, sides), sides, spheres_, options.obstacles, options.self) {
  BodyFindings findings = inspect(body);
  pieces_ = findings.pieces;
  for (const Obstacle& obstacle : options_.obstacles) {
    if (!obstacle.motion) pose_of(obstacle, 0);
    half_thickness_.push_back(half_thickness(obstacle.shape));
    moves_ |= static_cast<bool>(obstacle.motion);
    has_friction_ |= friction_of(obstacle) > 0;
  }
  has_friction_ |= options_.friction > 0;
  std::vector<char> seen(body.size(), 0);
  for (const Sample& sample : search_.samples())
    for (int i = 0; i < sample.count; ++i) seen[sample.molecules[i]] = 1;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (seen[molecule]) watched_.push_back(molecule);
  area_ = VectorX::Zero(body.size());
  for (const Sample& sample : search_.samples()) {
    mean_size_ += std::sqrt(sample.area) / static_cast<double>(search_.samples().size());
    for (int i = 0; i < sample.count; ++i) area_[sample.molecules[i]] += sample.weights[i] * sample.area;
  }
  const bool pairs = options_.self || pieces_ > 1;
  const double zeta = std::max(damping_ratio_, has_friction_ ? kSlipDampingRatio : 0);
  const double damped = std::sqrt(1 + zeta * zeta) + zeta;
  for (const int molecule : watched_)
    largest_square_frequency_ =
        std::max(largest_square_frequency_,
                 options_.stiffness * area_[molecule] / body_.mass[molecule] * (pairs ? 4 : 1) * damped * damped);
}

Pose ContactForce::pose_of(const Obstacle& obstacle, double time) const {
  const Pose pose = obstacle.at(moment_.value_or(time));
  if (!std::isfinite(pose.turn.sum() + pose.position.sum() + pose.velocity.sum() + pose.spin.sum()))
    throw InputError("obstacle '" + obstacle.name + "' is nowhere: a number of its pose is not finite");
  return pose;
}

void ContactForce::add_forces(const State& state, Positions& forces) const {
  for (const ContactResponse& response : responses(state))
    add(response, response.pressing * response.normal, response.friction, forces);
}
void ContactForce::add_resistance(const State& state, Positions& forces) const {
  for (const ContactResponse& response : responses(state))
    add(response, (response.pressing - response.elastic) * response.normal, response.friction, forces);
}
double ContactForce::energy(const State& state) const {
  double sum = 0;
  for (const ContactResponse& response : responses(state)) sum += response.energy;
  return sum;
}

void ContactForce::add_change(const State& state, const Positions& moved, const Positions& sped,
                              Positions& forces) const {
  for (const ContactResponse& response : responses(state)) {
    Vector3 closing = Vector3::Zero(), closing_rate = Vector3::Zero(), slipping = Vector3::Zero(),
            slipping_rate = Vector3::Zero(), turned = Vector3::Zero();
    for (int i = 0; i < response.count; ++i) {
      const Side& side = response.sides[i];
      closing += side.normal * moved.col(side.molecule);
      slipping += side.tangential * moved.col(side.molecule);
      closing_rate += side.normal * sped.col(side.molecule);
      slipping_rate += side.tangential * sped.col(side.molecule);
      turned += side.slope * response.normal.dot(moved.col(side.molecule));
    }
    const Vector3 normal = response.stiffness * closing + response.damping * closing_rate + response.pressing * turned;
    const Vector3 tangential = response.friction_stiffness * slipping + response.friction_damping * slipping_rate +
                               response.friction_gap_slope * response.normal.dot(closing) +
                               response.friction_gap_rate_slope * closing_rate;
    for (int i = 0; i < response.count; ++i) {
      const Side& side = response.sides[i];
      forces.col(side.molecule) -=
          side.normal * normal + side.tangential * tangential +
          response.pressing * side.slope.dot(closing + response.gap * turned) * response.normal;
    }
  }
}

void ContactForce::visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const {
  for (const ContactResponse& response : responses(state)) {
    const Vector3& n = response.normal;
    const Matrix3 normal = response.stiffness + velocity_weight * response.damping;
    const Matrix3 tangential = response.friction_stiffness + velocity_weight * response.friction_damping;
    const Matrix3 friction_gap_slope =
        response.friction_gap_slope * n.transpose() + velocity_weight * response.friction_gap_rate_slope;
    for (int i = 0; i < response.count; ++i)
      for (int j = 0; j < response.count; ++j) {
        const Side &a = response.sides[i], &b = response.sides[j];
        visit(a.molecule, b.molecule,
              a.normal * b.normal * normal + a.tangential * b.tangential * tangential +
                  a.tangential * b.normal * friction_gap_slope +
                  response.pressing * (a.normal * b.slope * n.transpose() + b.normal * n * a.slope.transpose() +
                                       response.gap * a.slope.dot(b.slope) * n * n.transpose()));
      }
  }
}

double default_contact_stiffness(const Body& body, double youngs_modulus) {
  return 10 * youngs_modulus / (2 * body.radius.mean());
}

std::unique_ptr<Contact> make_contact(const Body& body, const ContactOptions& options) {
  if (!(options.stiffness > 0) || !std::isfinite(options.stiffness))
    throw InputError("the contact's stiffness must be above 0");
  if (!(options.friction >= 0) || !std::isfinite(options.friction))
    throw InputError("the coefficient of friction must not be negative");
  if (!(options.restitution >= 0.01 && options.restitution <= 1))
    throw InputError("the restitution must be from 0.01 to 1");
  if (!(options.penetration >= 0)) throw InputError("the penetration must not be negative");
  const double w = options.adhesion, range = options.adhesion_range;
  if (!(w >= 0) || (w > 0 && !(range > 0)) || !std::isfinite(w + range))
    throw InputError("the adhesion must not be negative, and needs a range above 0");
  if (w > 0 && !(options.stiffness * range * range > 2 * w))
    throw InputError("the adhesion's range must be above " + number(std::sqrt(2 * w / options.stiffness)) +
                     " m, or the contact stiffer: at its stiffness the traction has no peak below the range");
  if (w > 0 && options.penetration > 0) throw InputError("adhesion has no bound of the penetration: leave one out");
  SurfaceSides sides;
  if (options.surface == ContactSurface::triangles) {
    sides = surface_sides(body);
    if (sides.empty())
      throw InputError("the body has no surface of triangles (no cells, cubes or triangles); take its spheres");
  }
  return std::make_unique<ContactForce>(body, options, sides);
}

}  // namespace elastin::contact
