#pragma once
#include "elastin/forces/model.h"
#include "forces/gather.h"

namespace elastin {

/// What several threads need to know of a body: the connections of each molecule.
struct Model::Graph {
  Rows incident;
};

}  // namespace elastin
