#pragma once
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// The points in the order of a curve that fills space, so that points whose numbers are near lie near each other: a
/// body numbered like this is passed over without waiting for the memory, at random several times as long from some 10⁵
/// molecules on. Element i is the number of the point that comes i-th. Points at one position keep their order.
///                                                                                                       [Morton 1966]
/// @param positions [m], any number of columns, finite
std::vector<int> order_in_space(const Positions& positions);

}  // namespace elastin
