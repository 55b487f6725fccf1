#pragma once
#include <algorithm>

#include "core/model/incidence.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// Adds the connections' forces to the molecules. One thread goes through the connections and adds each to both its
/// ends; several share out the molecules, and each adds to its own alone. A molecule meets its connections in ascending
/// order either way, so the results are bitwise identical.
class Graph {
 public:
  explicit Graph(const Body& body);

  /// Adds ± flow(c, a, b) of each connection to its two molecules: forces.col(a) += flow, forces.col(b) −= flow.
  template <class Flow>
  void add_flows(Positions& forces, Flow&& flow) const {
    if (gathers()) return gather(forces, flow);
    for_each_range([&](const Range& range) {
      for (int c = range.first; c < range.last; ++c) {
        const auto& [a, b] = connections_.ends[c];
        if (b < range.begin) continue;
        const Vector3 f = flow(c, a, b);
        if (a >= range.begin) forces.col(a) += f;
        if (b < range.end) forces.col(b) -= f;
      }
    });
  }

  /// Adds value(c) of each connection to both its molecules, in the same order.
  template <class Value, class Values>
  void add_to_ends(Values& values, Value&& value) const {
    if (gathers())
      return parallel_for(
          molecules_,
          [&](int molecule) {
            for (const int c : incident_[molecule]) values[molecule] += value(c);
          },
          1);
    for_each_range([&](const Range& range) {
      for (int c = range.first; c < range.last; ++c) {
        const auto& [a, b] = connections_.ends[c];
        if (b < range.begin) continue;
        const auto own = value(c);
        if (a >= range.begin) values[a] += own;
        if (b < range.end) values[b] += own;
      }
    });
  }

  /// Adds Σ_b q_ab (x_b − x_a) to each molecule.
  void add_forces(const Positions& positions, const VectorX& force_densities, Positions& forces) const;

  /// What one thread adds: the connections first … last−1, to the molecules begin … end−1 alone. They start at a
  /// molecule before `end`, and end at any; a part that is everything has all molecules.
  struct Range {
    int first, last, begin, end;
  };
  /// Whether there are no parts, because connections reach everywhere: then each molecule gathers its own.
  bool gathers() const { return size() >= kParallelThreshold && threads() > 1 && band_ == 0; }
  /// Calls work(part) for each part, each on a thread of its own.
  template <class Work>
  void for_each_range(Work&& work) const {
    const int ranges = size() < kParallelThreshold || band_ == 0 ? 1 : std::min(threads(), molecules_ / band_);
    if (ranges == 1) return work(Range{0, size(), 0, molecules_});
    const auto start = [&](int range) { return static_cast<int>(static_cast<long long>(molecules_) * range / ranges); };
    parallel_for(
        ranges,
        [&](int range) {
          const int begin = start(range), end = start(range + 1);
          work(Range{first_of(begin - band_), first_of(end), begin, end});
        },
        1);
  }
  /// Each molecule adds up ± flow(c, a, b) of its connections.
  template <class Flow>
  void gather(Positions& forces, Flow&& flow) const {
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

  int size() const { return connections_.size(); }

 private:
  /// The first connection that starts at this molecule or after it.
  int first_of(int molecule) const;

  const Connections& connections_;
  int molecules_;
  /// > 0 where connections ascend by their first end, which is their lower one: the farthest that one reaches.
  int band_ = 0;
  Rows incident_;  ///< connections of each molecule, only for large bodies without a narrow band
};

}  // namespace elastin
