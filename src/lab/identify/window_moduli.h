#pragma once
#include <string>
#include <vector>

#include "lab/identify/data.h"

namespace elastin::lab {

/// A modulus by a window of a measured curve, with its 95 % interval.
struct WindowModulus {
  std::string window;  ///< "chord from 5 % to 15 %"
  double value, low, high;
  Eigen::Index rows;  ///< that it follows from
};

/// The moduli that a test states, of its strains and stresses: polynomials of least squares over the rows of each
/// window, of the degree that noise and curvature allow. Throws InputError for a window with fewer than two rows, and a
/// stress that is not reached.
std::vector<WindowModulus> window_moduli(const DataTest& test, const MeasuredData& data);

}  // namespace elastin::lab
