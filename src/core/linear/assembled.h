#pragma once
#include <functional>
#include <vector>

#include "elastin/core/forces/tangent.h"

namespace elastin {

/// A row, or a column, of 3 × 3 blocks: one for each other molecule, ascending.
class BlockRow {
 public:
  struct Entry {
    int molecule;
    Matrix3 block;
  };
  void add(int molecule, const Matrix3& block);
  void clear() { entries_.clear(); }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }

 private:
  std::vector<Entry> entries_;
};

/// The stiffness of cells as rows of 3 × 3 blocks, where many products are needed of one: of a small body they fit into
/// the processor's caches, and a product reads them in a fraction of the time in which the cells compute it again. Each
/// row has one owner and a fixed order, so the bits are the same on any number of threads.
class AssembledStiffness {
 public:
  /// Whether `products` of them are worth the rows: not in steps in time, which allocate nothing, and not where loads
  /// join all molecules with all.
  static bool pays(const Tangent& tangent, const std::function<double()>& products);
  /// Keeps the memory of the last time.
  void assemble(const Tangent& tangent);
  /// result = K motion [N], as Tangent::apply, up to rounding.
  void apply(const Positions& motion, Positions& result) const;

 private:
  std::vector<BlockRow> rows_;
};

}  // namespace elastin
