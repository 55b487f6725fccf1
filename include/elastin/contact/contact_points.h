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

}  // namespace elastin::contact
