#include "core/linear/sparse_factor.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {

/// Minimum degree of 3 × 3 blocks, a ninth of the pattern; of single rows where there are no such blocks.
struct BlockOrdering {
  using PermutationType = Eigen::AMDOrdering<int>::PermutationType;
  template <class Matrix>
  void operator()(const Matrix& matrix, PermutationType& order) const {
    const auto blocks = static_cast<int>(matrix.cols() / 3);
    if (3 * blocks != matrix.cols()) return Eigen::AMDOrdering<int>()(matrix, order);
    std::vector<Eigen::Triplet<float>> entries;
    std::vector<int> seen(blocks, -1);
    for (int column = 0; column < 3 * blocks; ++column)
      for (typename Matrix::InnerIterator entry(matrix, column); entry; ++entry)
        if (const auto row = static_cast<int>(entry.row() / 3); std::exchange(seen[row], column / 3) != column / 3)
          entries.emplace_back(row, column / 3, 1.F);
    Eigen::SparseMatrix<float> pattern(blocks, blocks);
    pattern.setFromTriplets(entries.begin(), entries.end());
    PermutationType of_blocks;
    Eigen::AMDOrdering<int>()(pattern, of_blocks);
    order.resize(3 * blocks);
    for (int row = 0; row < 3 * blocks; ++row) order.indices()[row] = 3 * of_blocks.indices()[row / 3] + row % 3;
  }
};

struct SparseFactor::Ldlt : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, BlockOrdering> {
  void factorise(const Eigen::SparseMatrix<double>& matrix) {
    try {
      analyzePattern(matrix);
    } catch (const std::bad_alloc&) {  // the count of L's entries that it asks memory for may have overflowed
      check_size();
      throw;
    }
    check_size();
    factorize(matrix);
  }

 private:
  /// Eigen counts the entries of L by an int, and writes beyond them where there are more.
  void check_size() const {
    const double numbers = m_nonZerosPerCol.cast<double>().sum(), most = std::numeric_limits<int>::max();
    if (numbers <= most) return;
    throw InputError("a factor of this stiffness would hold " + number(numbers, 2) + " numbers (" +
                     number(numbers * (sizeof(double) + sizeof(int)) * 1e-9, 2) + " GB), more than the " +
                     number(most, 2) + " that it can: choose an iterative linear solver, such as multigrid");
  }
};

namespace {

/// Entries of each column of L below its diagonal, without L: each row's columns are those of the elimination tree from
/// its entries up to it. [Liu 1990]
Eigen::ArrayXd column_counts(const Eigen::SparseMatrix<double>& lower) {
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), order);
  Eigen::SparseMatrix<double> upper(lower.rows(), lower.cols());
  upper.selfadjointView<Eigen::Upper>() = lower.selfadjointView<Eigen::Lower>().twistedBy(order.inverse());
  std::vector<int> parent(lower.cols(), -1), seen_in(lower.cols(), -1);
  Eigen::ArrayXd counts = Eigen::ArrayXd::Zero(lower.cols());
  for (int row = 0; row < upper.cols(); ++row) {
    seen_in[row] = row;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(upper, row); entry; ++entry)
      for (auto column = static_cast<int>(entry.row()); seen_in[column] != row; column = parent[column]) {
        if (parent[column] < 0) parent[column] = row;
        seen_in[column] = row, ++counts[column];
      }
  }
  return counts;
}

}  // namespace

FactorCost factor_cost(int blocks, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int block = 0; block < blocks; ++block) entries.emplace_back(block, block, 1);
  for (const auto& [a, b] : pairs) entries.emplace_back(std::max(a, b), std::min(a, b), 1);
  Eigen::SparseMatrix<double> matrix(blocks, blocks);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::ArrayXd counts = column_counts(matrix);
  return {9 * counts.sum(), 27. / 2 * counts.square().sum()};
}

SparseFactor::SparseFactor() : ldlt_(std::make_unique<Ldlt>()) {}
SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& matrix) : SparseFactor() { compute(matrix); }
SparseFactor::~SparseFactor() = default;

void SparseFactor::compute(const Eigen::SparseMatrix<double>& matrix) {
  ldlt_->factorise(matrix);
  if (usable()) pivots_ = ldlt_->vectorD();
}
bool SparseFactor::usable() const { return ldlt_->info() == Eigen::Success; }
int SparseFactor::negative_pivots() const { return static_cast<int>((pivots_.array() < 0).count()); }
bool SparseFactor::positive() const { return usable() && (pivots_.array() > 0).all(); }
VectorX SparseFactor::solve(const Eigen::Ref<const VectorX>& right) const { return ldlt_->solve(right); }

void SparseFactor::solve(const Eigen::Ref<const VectorX>& right, VectorX& spare, VectorX& solution) const {
  const auto& order = ldlt_->permutationP().indices();
  spare.resize(right.size()), solution.resize(right.size());
  for (Eigen::Index i = 0; i < right.size(); ++i) spare[order[i]] = right[i];
  ldlt_->matrixL().solveInPlace(spare);
  spare.array() /= pivots_.array();
  ldlt_->matrixU().solveInPlace(spare);
  for (Eigen::Index i = 0; i < right.size(); ++i) solution[i] = spare[order[i]];
}

}  // namespace elastin
