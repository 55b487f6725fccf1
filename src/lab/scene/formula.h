#pragma once
#include <yaml-cpp/yaml.h>

#include <functional>

#include "elastin/core/base/error.h"

namespace elastin::lab {

/// Puts numbers in the place of formulas, values that are not quoted and begin with "=": "= side / 9" becomes
/// "0.0033 m". A formula has numbers with units, the names of the section `values` of the root, + - * / ^, brackets,
/// pi, and sqrt abs min max round floor ceil sin cos tan exp log. Throws InputError with a location.
void put_in_formulas(const YAML::Node& root, const std::function<SourceLocation(const YAML::Node&)>& location_of);

}  // namespace elastin::lab
