#pragma once
#include <algorithm>

#include "base/parallel.h"
#include "elastin/forces/elasticity.h"
#include "model/incidence.h"

namespace elastin {

/// Who adds the connections' forces to the molecules. One thread goes through the connections and adds each to both its
/// ends; several share out the molecules, and each adds to its own alone. A molecule meets its connections in ascending
/// order either way, so the bits are the same.
class Graph {
 public:
  explicit Graph(const Body& body);

  /// Adds ± flow(c, a, b) of each connection to its two molecules: forces.col(a) += flow, forces.col(b) −= flow.
  template <class Flow>
  void add_flows(Positions& forces, Flow&& flow) const {
    if (size() < kParallelThreshold || threads() == 1)
      scatter(forces, flow);
    else if (band_ > 0)
      scatter_in_parts(forces, flow);
    else
      gather(forces, flow);
  }

  /// Adds Σ_b q_ab (x_b − x_a) to each molecule.
  void add_forces(const Positions& positions, const VectorX& densities, Positions& forces) const;

  int size() const { return connections_.size(); }

 private:
  template <class Flow>
  void scatter(Positions& forces, Flow& flow) const {
    for (int c = 0; c < size(); ++c) {
      const auto& [a, b] = connections_.ends[c];
      const Vector3 f = flow(c, a, b);
      forces.col(a) += f;
      forces.col(b) -= f;
    }
  }

  /// Each part of the molecules takes the connections that start in it, and before them those that end in it.
  template <class Flow>
  void scatter_in_parts(Positions& forces, Flow& flow) const {
    const auto& ends = connections_.ends;
    const int parts = std::min(threads(), molecules_ / band_);
    const auto start = [&](int part) { return static_cast<int>(static_cast<long long>(molecules_) * part / parts); };
    parallel_for(
        parts,
        [&](int part) {
          const int begin = start(part), end = start(part + 1), own = first_of(begin), stop = first_of(end);
          for (int c = first_of(begin - band_); c < own; ++c) {
            const auto& [a, b] = ends[c];
            if (b >= begin && b < end) forces.col(b) -= flow(c, a, b);
          }
          for (int c = own; c < stop; ++c) {
            const auto& [a, b] = ends[c];
            const Vector3 f = flow(c, a, b);
            forces.col(a) += f;
            if (b < end) forces.col(b) -= f;
          }
        },
        1);
  }

  template <class Flow>
  void gather(Positions& forces, Flow& flow) const {
    parallel_for(
        molecules_,
        [&](int molecule) {
          Vector3 sum = forces.col(molecule);
          for (const int c : incident_[molecule]) {
            const auto& [a, b] = connections_.ends[c];
            if (a == molecule)
              sum += flow(c, a, b);
            else
              sum -= flow(c, a, b);
          }
          forces.col(molecule) = sum;
        },
        1);
  }

  /// The first connection that starts at this molecule or after it.
  int first_of(int molecule) const;

  const Connections& connections_;
  int molecules_;
  /// > 0 where connections ascend by their first end, which is their lower one: the farthest that one reaches.
  int band_ = 0;
  Rows incident_;  ///< connections of each molecule, only for large bodies without a narrow band
};

}  // namespace elastin
