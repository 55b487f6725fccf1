#pragma once
#include <functional>
#include <vector>

#include "elastin/core/model/stress_strain.h"

namespace elastin::lab {

/// Runs the body with springs that follow a curve; gives the nominal strain and stress that it shows at each load step,
/// ascending in size; fewer than there are load steps if a step failed.
using MeasureCurve = std::function<std::vector<StressStrain::Point>(const StressStrain&)>;

struct CurveFit {
  StressStrain springs;  ///< what each spring must follow
  double error;          ///< largest |stress shown − given| over the largest given; 1 if nothing could be measured
};

/// The curve of the springs with which the whole body shows the given one: a spring along the load has the strain of
/// the whole, so its stress there is multiplied by given/shown until they agree to 1e-4, or for 25 runs. On the side
/// that is not loaded the springs keep the given curve. The best of all runs is returned.
CurveFit fit_curve(const StressStrain& given, const MeasureCurve& measure);

}  // namespace elastin::lab
