#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "mesh/image_file.h"

namespace elastin::lab {

/// The image of which a body was made.
struct BodyImage : mesh::ImageGrid {
  double length_unit = 1;                              ///< of the grid's coordinates [m]
  std::function<double(const Vector3& place)> number;  ///< of the label at a place of the grid
  std::array<int, 3> shown{};                          ///< voxels along each axis of the image as pages show it
  /// `spacing` [m] with which the body has about half as large boxes; 0 where boxes are voxels, or without boxes.
  double finer_spacing = 0;
  std::vector<std::uint8_t> shades;  ///< of these, from the lowest value to the highest, x fastest
};

}  // namespace elastin::lab
