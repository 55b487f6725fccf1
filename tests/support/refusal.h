#pragma once
#include <string>

#include "elastin/core/base/error.h"

namespace elastin::testing {

/// What is said when `act` refuses its input; nothing if it takes it.
template <class Act>
std::string refusal(Act act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace elastin::testing
