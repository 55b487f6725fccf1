#pragma once
#include <vector>

#include "elastin/contact/contact.h"

namespace elastin::contact {

/// Where a body is pressed.
struct PressedPoint {
  Vector3 position, force;  ///< [m]; on the body [N], with friction
  int obstacle;             ///< its number; −1: another piece, or the piece itself
};

/// All of them in one state, as Contact::report finds them.
std::vector<PressedPoint> pressed_points(const Contact& contact, const State& state);

/// Whether on the straight path between two states some of the body's surface may go through that of another piece, or
/// its own, so deep that the way out is no longer the way in.
bool bodies_may_pass(const Contact& contact, const State& from, const State& to);

}  // namespace elastin::contact
