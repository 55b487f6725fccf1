#include "core/linear/assembled.h"

#include <algorithm>

#include "core/parallel/parallel.h"

namespace elastin {
namespace {

/// Above this many molecules the rows come from memory, and take as long as the cells.
constexpr int kMostRows = 20000;

/// The rows take the time of about as many products by cells of 8 nodes; by cells of 27 nodes that of hundreds.
constexpr double kFewProducts = 15;
constexpr int kMostCorners = 8;

}  // namespace

void BlockRow::add(int molecule, const Matrix3& block) {
  const auto place =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.molecule >= molecule; });
  if (place == entries_.end() || place->molecule != molecule)
    entries_.insert(place, {molecule, block});
  else
    place->block += block;
}

bool AssembledStiffness::pays(const Tangent& tangent, const std::function<double()>& products) {
  const Model& model = tangent.model();
  const auto& blocks = model.body().blocks;
  return tangent.weights().acceleration == 0 && !model.nodal_laws().empty() && model.body().size() <= kMostRows &&
         !model.body().share && products() > kFewProducts && tangent.wide_terms().empty() &&
         std::all_of(blocks.begin(), blocks.end(), [](const auto& block) { return block.kind->nodes <= kMostCorners; });
}

void AssembledStiffness::assemble(const Tangent& tangent) {
  rows_.resize(tangent.model().body().size());
  for (auto& row : rows_) row.clear();
  tangent.visit_blocks([&](int a, int b, const Matrix3& block) { rows_[a].add(b, block); });
}

void AssembledStiffness::apply(const Positions& motion, Positions& result) const {
  parallel_for(
      static_cast<int>(rows_.size()),
      [&](int a) {
        Vector3 sum = Vector3::Zero();
        for (const auto& [molecule, block] : rows_[a]) sum += block * motion.col(molecule);
        result.col(a) = sum;
      },
      kMoleculeThreshold);
}

}  // namespace elastin
