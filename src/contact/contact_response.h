#pragma once
#include <array>

#include "contact/search.h"
#include "elastin/core/model/state.h"

namespace elastin::contact {

/// A relative motion of a sample against its target, as weights of molecules: u = Σ weight · δx.
struct Side {
  int molecule = -1;
  double normal = 0;                ///< weight in the motion that closes the gap
  double tangential = 0;            ///< in the motion away from the anchor
  Vector3 slope = Vector3::Zero();  ///< Touch::slopes, of the target's molecules
};

/// What a touch answers with: forces, and how they change. Everything on the sample; the target gets the opposite.
struct ContactResponse {
  int sample = 0, target = 0;
  double gap = 0;  ///< [m]
  Vector3 normal = Vector3::UnitZ(), position = Vector3::Zero();
  std::array<Side, 9> sides;  ///< of sample, target, and anchor where that lies elsewhere
  int count = 0;
  double pressing = 0;                 ///< N ≥ 0, damping included [N]
  double elastic = 0;                  ///< of it, from penalty and multiplier [N]
  double energy = 0;                   ///< of the elastic part [J]
  Vector3 friction = Vector3::Zero();  ///< [N]
  Vector3 slip = Vector3::Zero();      ///< elastic, after its return to the cone [m]
  bool sticks = false;
  Matrix3 stiffness = Matrix3::Zero();           ///< −∂(normal force)/∂u, but for the target's turning [N/m]
  Matrix3 damping = Matrix3::Zero();             ///< −∂(normal force)/∂u̇ [N s/m]
  Matrix3 friction_stiffness = Matrix3::Zero();  ///< −∂friction/∂(motion from the anchor) [N/m]
  Matrix3 friction_damping = Matrix3::Zero();    ///< −∂friction/∂(its rate) [N s/m]
  Vector3 friction_gap_slope = Vector3::Zero();  ///< −∂friction/∂gap: what is lost of it as the gap opens [N/m]
  Matrix3 friction_gap_rate_slope = Matrix3::Zero();  ///< the same of the damping part of N, by ġ [N s/m]
};

/// What decides about a contact point in addition to its geometry.
struct ContactSetting {
  double stiffness = 0;                ///< [N/m]
  double mass = 0;                     ///< reduced, of the two that touch [kg]
  double damping_ratio = 0;            ///< of the normal motion, from the restitution
  double friction = 0;                 ///< μ
  double onset = 0;                    ///< depth over which damping sets in [m]
  double multiplier = 0;               ///< [N]
  Vector3 slip = Vector3::Zero();      ///< from the anchor, tangential or not [m]
  Vector3 velocity = Vector3::Zero();  ///< of the sample against the target [m/s]
};

/// Of the elastic slip: it settles, it does not rebound.
inline constexpr double kSlipDampingRatio = 0.2;

/// Penalty, damping and friction of one touch. The normal force is N = max(0, λ − k g − c w ġ), w growing from 0 to 1
/// over the onset's depth; friction is −k s − c ṡ of the elastic slip s while that is within μN, else μN against it.
/// Sets everything but sample, target, position and sides. @param geometry normal, gap and turning
void set_response(const ContactPoint& geometry, const ContactSetting& setting, ContactResponse& response);

/// Damping ratio ζ ≥ 0 at which a mass on a linear spring and dashpot that only press leaves as fast as `restitution`
/// times the speed it came with, 0.01 ≤ e ≤ 1. [Schwager & Pöschel 2007]
double damping_ratio_of(double restitution);

}  // namespace elastin::contact
