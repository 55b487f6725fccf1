#pragma once
#include <string_view>
#include <vector>

namespace elastin::lab {

/// FEBio's name of a shape of the table of shapes.
struct FebioShape {
  const char* febio;
  std::string_view name;
  /// Position of each node of the file among those of the shape, where the orders differ.
  std::vector<int> order = {};
};

/// FEBio's solids, for writing and for reading.
const std::vector<FebioShape>& febio_solids();

}  // namespace elastin::lab
