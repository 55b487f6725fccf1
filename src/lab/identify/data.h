#pragma once
#include <algorithm>
#include <string>

#include "elastin/core/base/types.h"
#include "lab/identify/curve.h"
#include "lab/identify/machine_file.h"
#include "lab/scene/identify.h"

namespace elastin::lab {

/// What was measured in one test.
struct MeasuredData {
  const DataQuantity* along = nullptr;  ///< what is prescribed
  const DataQuantity* up = nullptr;     ///< the response
  VectorX x, y;                         ///< SI, in the order of the rows
  std::vector<int> lines;               ///< of the file
  std::string file;
  double noise = 0;                        ///< standard deviation of readings near zero, SI; 0: not known
  double zero = 0;                         ///< what was subtracted from x as the point where the load begins
  double zero_half = 0;                    ///< half width of its 95 % interval, as x is
  std::vector<std::string> notes = {};     ///< what was recognised in the file and done with its rows
  std::vector<std::string> warnings = {};  ///< what may change the numbers
  /// Under which readings are too near zero for differences over themselves: 1 % of the largest, or a hundred times the
  /// noise where that is more.
  // Of points, where y are displacements, each of a point in a direction:
  Positions places = {};       ///< where the point is at rest, 3 × readings [m]; z is NaN where the file has none
  std::vector<int> axes = {};  ///< the direction, 0 to 2
  VectorX deviations = {};     ///< standard deviation of each [m], as the file says; empty: it does not
  double least_scale() const { return std::max(100 * noise, 0.01 * y.cwiseAbs().maxCoeff()); }
};

/// The file of a test. Throws InputError at the test without a file.
MachineFile open_data(const DataTest& test);
/// Reads the columns that a test takes, of its rows between `from` and `to`, and of them the branch that the scene
/// chooses, as far as the specimen is whole; many rows are averaged in groups. Throws InputError naming file, line and
/// what is needed: no unit, nominal or true not stated, a column that is missing, misspelt or there twice, values that
/// are missing, no numbers, out of order or no such quantity, fewer than two, or all alike.
MeasuredData load_data(const DataTest& test);

/// Reads the points of a test, all readings of one direction behind each other. Throws InputError naming file, line and
/// what is needed.
MeasuredData load_points(const DataTest& test);
/// The same as that which a homogeneous test prescribes and answers: nominal strain, or amount of shear, and nominal
/// stress [Pa]; of a relaxation test time and nominal stress. True stress is that of a material that keeps its volume.
MeasuredData as_strain_and_stress(const DataTest& test, MeasuredData data);

}  // namespace elastin::lab
