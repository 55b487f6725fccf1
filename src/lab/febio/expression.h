#pragma once
#include <functional>

#include "elastin/core/base/types.h"
#include "lab/febio/element.h"

namespace elastin::lab::febio {

/// A formula of a place at rest: numbers, X, Y, Z, + - * / ^ and parentheses. Throws InputError on anything else.
std::function<double(const Vector3& place)> read_expression(const Element& element);

}  // namespace elastin::lab::febio
