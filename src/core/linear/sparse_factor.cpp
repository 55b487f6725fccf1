#include "core/linear/sparse_factor.h"

#include <Eigen/SparseCholesky>

namespace elastin {

struct SparseFactor::Ldlt : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
  using SimplicialLDLT::SimplicialLDLT;
};

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
