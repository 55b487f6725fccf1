#pragma once
#include <map>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::lab {

/// Molecules that are held, with the projector on the directions in which each stays free.
using FixedMolecules = std::map<int, Matrix3>;

/// Holds the molecules that lie in planes of symmetry through the origin in the directions across these; `normals` are
/// unit and across each other. Throws InputError where the body lies on both sides of a plane, or none of it in one.
void fix_in_planes(const Body& body, const std::vector<Vector3>& normals, FixedMolecules& fixed);

}  // namespace elastin::lab
