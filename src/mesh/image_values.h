#pragma once
#include <cstddef>
#include <map>

#include "mesh/image_file.h"

namespace elastin::mesh {

/// What the values of an image are.
struct ImageValues {
  /// Whether they are labels of a segmentation: few, or whole numbers that most voxels share with their neighbours.
  bool labels = true;
  std::map<double, std::size_t> counts;  ///< of voxels with each label but 0
  double threshold = 0;  ///< of grey values: the least of the brighter class by [Otsu 1979, eq. 17–19]
};

ImageValues values_of(const Image& image);

}  // namespace elastin::mesh
