#pragma once
#include <map>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::mesh {

/// The body's cells, or its connections if it has none, as a mesh of Gmsh in the format 2.2, in metres, with named
/// groups of molecules as physical points. load_mesh reads it back. Throws InputError for quadrilaterals of second
/// order.
std::string gmsh_text(const Body& body, const std::map<std::string, std::vector<int>>& groups = {});

}  // namespace elastin::mesh
