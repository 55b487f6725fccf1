#include "contact/contact_force.h"

#include <algorithm>
#include <cmath>

namespace elastin::contact {
namespace {

/// Of the onset: what just touches has stiffness though it has no force yet, or Newton would not see it.
constexpr double kNearness = 1e-6;

/// Of the depth to which an undamped impact leads: over it damping sets in.
constexpr double kOnset = 0.02;

/// e of a damping ratio: the touch ends when the force has fallen to zero, before the spring is at rest.
double restitution_of(double ratio) {
  if (ratio < 1) {
    const double frequency = std::sqrt(1 - ratio * ratio);
    const double phase = M_PI - std::atan2(2 * ratio * frequency, frequency * frequency - ratio * ratio);
    return std::exp(-ratio / frequency * phase);
  }
  const double root = std::sqrt(std::max(ratio * ratio - 1, 1e-12));
  return std::exp(-ratio / root * std::log((ratio + root) / (ratio - root)));
}

void set_friction(const ContactPoint& geometry, const ContactSetting& setting, ContactResponse& response) {
  const Vector3& n = geometry.normal;
  const Matrix3 across = Matrix3::Identity() - n * n.transpose();
  const double k = setting.stiffness, most = setting.friction * response.pressing;
  const double c = 2 * kSlipDampingRatio * std::sqrt(k * setting.mass);
  const double held = setting.anchored ? k : 0;  // what has no anchor resists a speed alone
  const Vector3 slip = across * setting.slip, rate = across * setting.velocity;
  const Vector3 trial = -held * slip - c * rate;
  const double size = trial.norm();
  // What just touches sticks: whether rounding has left it a force decides nothing.
  if (size <= most + 1e-3 * kNearness * k * setting.onset) {
    response.friction = trial;
    response.slip = slip;
    response.friction_stiffness = held * across;
    response.friction_damping = c * across;
    return;
  }
  const Vector3 direction = trial / size;
  response.friction = most * direction;
  response.slip = -response.friction / k;
  const Matrix3 turning = most / size * (across - direction * direction.transpose());
  response.friction_stiffness = held * turning;
  response.friction_damping = c * turning;
  response.friction_gap_slope = setting.friction * k * direction;
  response.friction_gap_rate_slope = setting.friction * direction * (response.damping * n).transpose();
}

/// Beyond touch: the penalty's line goes on to the traction's peak, then it falls to nothing at the range. Together
/// they are a triangle over the range whose area is the work of adhesion.
void set_pull(const ContactPoint& geometry, const ContactSetting& setting, ContactResponse& response) {
  const double gap = geometry.gap, range = setting.range;
  if (gap >= range) return;
  const double peak = 2 * setting.adhesion / range, at_peak = peak / setting.stiffness;
  const bool rising = gap <= at_peak;
  const double slope = rising ? setting.stiffness : -peak / (range - at_peak);
  response.elastic = response.pressing = rising ? -slope * gap : slope * (range - gap);
  response.energy = rising ? slope * gap * gap / 2 - setting.adhesion : slope * (range - gap) * (range - gap) / 2;
  response.stiffness = slope * geometry.normal * geometry.normal.transpose() - response.pressing * geometry.turning;
}

}  // namespace

void set_response(const ContactPoint& geometry, const ContactSetting& setting, ContactResponse& response) {
  const Vector3& n = geometry.normal;
  const double k = setting.stiffness, depth = -geometry.gap;
  response.gap = geometry.gap;
  response.normal = n;
  if (setting.adhesion > 0 && depth < 0) return set_pull(geometry, setting, response);
  response.elastic = std::max(0., setting.multiplier + k * depth);
  // Of the augmented Lagrangian: zero at no force.
  response.energy =
      (response.elastic * response.elastic - setting.multiplier * setting.multiplier) / (2 * k) - setting.adhesion;
  response.pressing = response.elastic;
  if (!(setting.multiplier + k * depth >= -kNearness * k * setting.onset)) return;
  const double full = 2 * setting.damping_ratio * std::sqrt(k * setting.mass), speed = n.dot(setting.velocity);
  // The damping sets in over no more than a part of the depth to which this speed leads, or slow impacts would have
  // none.
  const double of_speed = kOnset * std::abs(speed) * std::sqrt(setting.mass / k),
               over = std::min(setting.onset, of_speed);
  const bool inside = depth > 0 && depth < over;
  const double onset = inside ? depth / over : depth > 0 ? 1 : 0;
  response.pressing = response.elastic - full * onset * speed;
  if (response.pressing <= 0 && full * onset > 0) {  // it leaves faster than the spring pushes
    response.pressing = 0;
    return;
  }
  // How the onset grows with the depth while the sample comes in.
  const double growth = inside && speed < 0 ? -full * speed / over : 0;
  response.stiffness = (k + growth) * n * n.transpose() - response.pressing * geometry.turning;
  response.damping = (inside && over == of_speed ? 0 : full * onset) * n * n.transpose();
  if (setting.friction > 0) set_friction(geometry, setting, response);
}

double damping_ratio_of(double restitution) {
  if (restitution >= 1) return 0;
  double low = 0, high = 100;
  for (int halving = 0; halving < 200; ++halving) {
    const double middle = (low + high) / 2;
    (restitution_of(middle) > restitution ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace elastin::contact
