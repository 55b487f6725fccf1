#include "core/linear/sparse_factor.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <utility>

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
  using SimplicialLDLT::SimplicialLDLT;
};

namespace {

/// Counts the entries of L's columns, and makes none.
struct Counts : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
  explicit Counts(const Eigen::SparseMatrix<double>& matrix) { analyzePattern(matrix); }
  auto of_columns() const { return m_nonZerosPerCol.cast<double>().array(); }
};

}  // namespace

FactorCost factor_cost(int blocks, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int block = 0; block < blocks; ++block) entries.emplace_back(block, block, 1);
  for (const auto& [a, b] : pairs) entries.emplace_back(std::max(a, b), std::min(a, b), 1);
  Eigen::SparseMatrix<double> matrix(blocks, blocks);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Counts counts(matrix);
  return {9 * counts.of_columns().sum(), 27. / 2 * counts.of_columns().square().sum()};
}

SparseFactor::SparseFactor() : ldlt_(std::make_unique<Ldlt>()) {}
SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& matrix) : SparseFactor() { compute(matrix); }
SparseFactor::~SparseFactor() = default;

void SparseFactor::compute(const Eigen::SparseMatrix<double>& matrix) {
  ldlt_->compute(matrix);
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
