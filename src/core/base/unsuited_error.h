#pragma once
#include "elastin/core/base/error.h"

namespace elastin {

/// What the model's strategy cannot do, and others can: a comparison says so in its row, and goes on.
class UnsuitedError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace elastin
