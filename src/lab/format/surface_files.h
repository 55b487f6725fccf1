#pragma once
#include <string>
#include <vector>

#include "elastin/contact/obstacle.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// A VTU file of a body's surface in one state: triangles; contact pressure [Pa] and force [N] where there is contact,
/// displacement [m], the largest strain of a connection at each molecule, and the number of its piece.
std::string surface_vtu_text(const Body& body, const Cells<3>& triangles, const Snapshot& shot);

/// A VTU file of obstacles as triangles, each with its number; planes as wide as the box from `low` to `high` [m] needs
/// for.
std::string obstacles_vtu_text(const std::vector<contact::Obstacle>& obstacles, const std::vector<contact::Pose>& poses,
                               const Vector3& low, const Vector3& high);

}  // namespace elastin::lab
