#pragma once
#include <string>

#include "elastin/core/base/types.h"
#include "lab/scene/identify.h"

namespace elastin::lab {

/// What was measured in one test.
struct MeasuredData {
  const DataQuantity* along = nullptr;  ///< what is prescribed
  const DataQuantity* up = nullptr;     ///< the response
  VectorX x, y;                         ///< SI, x ascending or descending
  std::vector<int> lines;               ///< of the file
  std::string file;
};

/// Reads the columns that a test takes, in its range. Throws InputError naming file, line and what is needed: no unit,
/// nominal or true not said, a column that is missing, misspelt, twice there or swapped with another, values that are
/// missing, no numbers, out of order or no such quantity, fewer than two, or all alike.
MeasuredData load_data(const DataTest& test);

/// The same as that which a homogeneous test prescribes and answers: nominal strain, or amount of shear, and nominal
/// stress [Pa]; of a relaxation test time and nominal stress. True stress is that of a material that keeps its volume.
MeasuredData as_strain_and_stress(const DataTest& test, MeasuredData data);

}  // namespace elastin::lab
