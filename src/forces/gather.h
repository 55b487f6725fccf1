#pragma once
#include "base/parallel.h"
#include "elastin/base/types.h"
#include "model/incidence.h"

namespace elastin {

/// Adds ± flow(c) of each connection to its two molecules: forces.col(a) += flow, forces.col(b) −= flow. One thread
/// scatters, several gather; both add a molecule's connections in ascending order, so the bits are the same.
/// `incident` may be null: then one thread does it.
template <class Flow>
void add_flows(const Connections& connections, const Rows* incident, Positions& forces, Flow&& flow) {
  if (!incident || threads() == 1) {
    for (int c = 0; c < connections.size(); ++c) {
      const auto& [a, b] = connections.ends[c];
      const Vector3 f = flow(c, a, b);
      forces.col(a) += f;
      forces.col(b) -= f;
    }
    return;
  }
  parallel_for(
      static_cast<int>(forces.cols()),
      [&](int molecule) {
        Vector3 sum = forces.col(molecule);
        for (const int c : (*incident)[molecule]) {
          const auto& [a, b] = connections.ends[c];
          if (a == molecule)
            sum += flow(c, a, b);
          else
            sum -= flow(c, a, b);
        }
        forces.col(molecule) = sum;
      },
      1);
}

}  // namespace elastin
