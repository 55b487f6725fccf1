#pragma once
#include <functional>
#include <vector>

#include "elastin/core/model/body.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// The molecules that a scene picks: their numbers as a list, or a map of places, of which all must hold. `rotation`
/// is that of the scene, which the body has had. Throws InputError where none is picked.
std::vector<int> read_molecules(const Reader& reader, const Body& body, const Matrix3& rotation);

/// The molecules on the free edge of a body of triangles, ascending.
std::vector<int> rim_of(const Body& body);

std::vector<KeySection> pick_keys();

}  // namespace elastin::lab
