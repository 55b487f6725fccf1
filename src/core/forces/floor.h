#pragma once
#include <memory>

#include "elastin/core/forces/loads.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// A plane that molecules, as spheres, do not pass without resistance: a penalty, not a contact. It has no friction.
struct Floor {
  Vector3 point = Vector3::Zero();    ///< on the plane [m]
  Vector3 normal = Vector3::UnitZ();  ///< towards the free side
  double stiffness = 0;               ///< k of each molecule that is pressed in [N/m]
  double damping = 0;                 ///< of each molecule that is pressed in [N s/m]
};

/// Default stiffness of a floor for each molecule pressed in: E times the mean molecule's
/// diameter, as a cube of that size has [N/m].
double default_floor_stiffness(const Body& body, const Material& material);

/// The force grows with the square of the depth d over the first tenth of a radius r, then with the stiffness, as
/// k (d − r/20): a smooth force with an energy.
std::unique_ptr<Load> make_floor(const Body& body, const Floor& floor);

/// The floor that make_floor made this load of, with a unit normal; null: of none.
const Floor* floor_of(const Load& load);

/// Resists the speed along the normal of the molecules that are pressed in; it holds back those that leave, too.
std::unique_ptr<Load> make_floor_damping(const Body& body, const Floor& floor);

}  // namespace elastin
