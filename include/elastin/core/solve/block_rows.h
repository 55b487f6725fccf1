#pragma once
#include <vector>

#include "elastin/core/forces/model.h"

namespace elastin {

/// A sparse matrix of 3 × 3 blocks by rows, as block sparse libraries take it: the blocks of row a are those from
/// starts[a] up to starts[a + 1], each in the column of its molecule, ascending, with 9 numbers row by row.
struct BlockRows {
  std::vector<double> values;
  std::vector<int> columns, starts;
};

/// The stiffness −∂(all forces)/∂(positions) [N/m] at a state, supports not regarded. Throws InputError where a load
/// joins all molecules with all, so that the matrix would be full.
BlockRows stiffness_blocks(Model& model, const State& state);

}  // namespace elastin
