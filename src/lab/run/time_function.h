#pragma once
#include <optional>
#include <string>
#include <utility>

#include "elastin/core/forces/time_function.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// {ramp: {duration: 1 s}}, {step: {at: 1 s}}, {sine: …} or {table: [[0 s, 0], …]}.
TimeFunction read_time_function(const Reader& reader);

template <class Setup>
Key<Setup> time_function_key(std::string name, std::optional<TimeFunction> Setup::*member, std::string text) {
  return {{std::move(name), "time function", "", "", "none", std::move(text)},
          [member](const Reader& value, Setup& setup, const Frame&) { setup.*member = read_time_function(value); }};
}

/// Its table in the key reference.
KeySection time_function_section();

}  // namespace elastin::lab
