#pragma once
#include <optional>

#include "elastin/core/simulation/catalog.h"
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// What a law on cells measures in a test on a small block of few cells, in which every point is alike: the value that
/// the law itself has at this strain, for a specimen's to be compared with. A membrane's block lies in the plane of the
/// specimen's first triangle. Nothing where the law does not suit or does not come that far.
std::optional<Measures> measured_on_block(const UniformTest& test, const Body& specimen, const Strategy& law,
                                          const Material& material, const ParameterValues& values);

}  // namespace elastin::lab
