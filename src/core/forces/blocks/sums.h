#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/base/rows.h"
#include "core/geometry/reference_slopes.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/elasticity.h"

namespace elastin::blocks {

/// A pass over cells costs enough that few cells are worth another thread.
inline constexpr int kCellThreshold = 200;

/// Sums over the cells of a block, bitwise identical on any number of threads. Knows which molecules cells have, and
/// not what it adds.
class CellSums {
 public:
  /// The block must outlive it.
  CellSums(int molecules, const CellBlock& block)
      : block_(block), slots_(rows_by_target(molecules, block.nodes)), cells_of_(molecules) {
    for (int molecule = 0; molecule < molecules; ++molecule)
      if (const auto own = slots_[molecule]; !own.empty())
        cells_of_[molecule] = {own.front() / block.kind->nodes, own.back() / block.kind->nodes};
  }

  template <class Term>
  double sum(Term&& term) const {
    return ordered_sum(block_.size(), std::forward<Term>(term), 0., kCellThreshold);
  }

  /// Adds work(cell, own) of each cell to its nodes. Each molecule meets its cells in ascending order, whoever adds.
  template <class Work>
  void add(Positions& values, Workspace& workspace, Work&& work) const {
    const int n = block_.kind->nodes;
    if (threads() == 1 || block_.size() < kCellThreshold) {
      NodeVectors own(3, n);
      for (int cell = 0; cell < block_.size(); ++cell) {
        own.setZero();
        work(cell, own);
        const int* nodes = block_.cell(cell).data();
        for (int a = 0; a < n; ++a) values.col(nodes[a]) += own.col(a);
      }
      return;
    }
    // Each thread has a range of cells, and adds to the molecules that no other's cells have. What the others get waits
    // in slots, most of which nothing ever touches.
    const int range = (block_.size() + threads() - 1) / threads();
    auto slots = workspace.buffer(Workspace::slots, static_cast<Eigen::Index>(block_.nodes.size()) * 3);
    parallel_for(
        threads(),
        [&](int number) {
          const int begin = number * range, end = std::min(block_.size(), begin + range);
          NodeVectors own(3, n);
          for (int cell = begin; cell < end; ++cell) {
            own.setZero();
            work(cell, own);
            for (int a = 0; a < n; ++a) {
              const int slot = cell * n + a, molecule = block_.nodes[slot];
              const auto& [first, last] = cells_of_[molecule];
              if (first >= begin && last < end)
                values.col(molecule) += own.col(a);
              else
                slots.segment<3>(3 * static_cast<Eigen::Index>(slot)) = own.col(a);
            }
          }
        },
        1);
    parallel_for(
        static_cast<int>(cells_of_.size()),
        [&](int molecule) {
          const auto& [first, last] = cells_of_[molecule];
          if (first / range != last / range)
            for (const int slot : slots_[molecule])
              values.col(molecule) += slots.segment<3>(3 * static_cast<Eigen::Index>(slot));
        },
        kMoleculeThreshold);
  }

 private:
  const CellBlock& block_;
  Rows slots_;                                ///< of each molecule among the nodes of all cells
  std::vector<std::array<int, 2>> cells_of_;  ///< of each molecule, the first and the last
};

}  // namespace elastin::blocks
