#pragma once
#include <string>

#include "elastin/core/laws/material_law.h"
#include "lab/report/plot.h"

namespace elastin::lab {

/// Nominal stress over nominal strain, or amount of shear, of a material with a law: in uniaxial, planar and
/// equibiaxial tension and compression and in simple shear. Dashed where the law is unstable [Drucker]; curves end
/// where there is no equilibrium.
/// Axis 1 is along the law's own direction, if it has one.
/// @param stretch the largest one, > 1; the largest shear is stretch − 1. Compression goes to its inverse, or to where
/// the stress is as large as that of tension.
Plot material_plot(const std::string& title, const MaterialLaw& law, const Material& material, double stretch);

}  // namespace elastin::lab
