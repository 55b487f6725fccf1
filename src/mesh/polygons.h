#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin::mesh::format {

/// Corners and faces of a surface file as they come: a corner once for each face or normal that it has.
struct Polygons {
  struct Piece {
    std::vector<Vector3> corners;
    std::vector<std::vector<int>> faces;
  };
  std::vector<Piece> pieces;
  std::string trouble;  ///< why nothing was read, or ""
};

/// By Assimp, which keeps places in single precision: 6e-8 of their size. Polygons become triangles.
/// @param ending of the file's name, without the dot
Polygons read_polygons(std::string_view bytes, const std::string& ending);

}  // namespace elastin::mesh::format
