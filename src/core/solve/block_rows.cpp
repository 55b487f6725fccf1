#include "elastin/core/solve/block_rows.h"

#include <cmath>
#include <map>

#include "core/solve/full_tangent.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {

std::string without_full_tangent(const Model& model, const Positions& positions) {
  if (model.has_full_tangent()) return "";
  constexpr double most = 1e-6;
  const Connections& connections = model.body().connections;
  bool strained = model.body().unstressed != nullptr;
  for (int c = 0; c < connections.size() && !strained; ++c) {
    const auto& [a, b] = connections.ends[c];
    const double rest = connections.rest_length[c], length = (positions.col(b) - positions.col(a)).norm();
    strained = !(std::abs(length - rest) <= most * rest);
  }
  return strained ? "the constants of a law change with the shape, as those of angles_update, and the stiffness of a "
                    "strained body leaves their change out; take a rule with fixed constants"
                  : "";
}

BlockRows stiffness_blocks(Model& model, const State& state) {
  if (const std::string why = without_full_tangent(model, state.positions); !why.empty())
    throw InputError("no stiffness matrix of this state: " + why);
  const Tangent tangent(model, state);
  if (!tangent.wide_terms().empty())
    throw InputError(
        "a load that joins all molecules with all has a full matrix: the stiffness is given without such loads");
  std::vector<std::map<int, Matrix3>> rows(static_cast<std::size_t>(model.body().size()));
  tangent.visit_blocks([&](int a, int b, const Matrix3& block) {
    const auto [at, is_new] = rows[a].try_emplace(b, block);
    if (!is_new) at->second += block;
  });
  BlockRows result;
  result.starts.push_back(0);
  for (const auto& row : rows) {
    for (const auto& [column, block] : row) {
      result.columns.push_back(column);
      const Matrix3 by_rows = block.transpose();
      result.values.insert(result.values.end(), by_rows.data(), by_rows.data() + 9);
    }
    result.starts.push_back(static_cast<int>(result.columns.size()));
  }
  return result;
}

}  // namespace elastin
