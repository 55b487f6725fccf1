#pragma once
#include <string>

#include "elastin/core/base/error.h"

namespace elastin::config {

/// Refuses a text that is not UTF-8, is indented by tabs or leaves a quote open. Throws InputError: file:line:column,
/// and the line as it should be.
void check_scene_text(const std::string& path, const std::string& text);

/// What is wrong with a text that YAML refuses at a location (line and column from 1) for the `reason` of its parser:
/// the line that is odd, and as it should be. Of what it cannot tell, the reason.
InputError explain_yaml(const std::string& path, const std::string& text, const SourceLocation& refused,
                        const std::string& reason);

}  // namespace elastin::config
