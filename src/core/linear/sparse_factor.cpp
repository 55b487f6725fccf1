#include "core/linear/sparse_factor.h"

#include <Eigen/SparseCholesky>

namespace elastin {

struct SparseFactor::Ldlt : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
  using SimplicialLDLT::SimplicialLDLT;
};

SparseFactor::SparseFactor() : ldlt_(std::make_unique<Ldlt>()) {}
SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& matrix) : ldlt_(std::make_unique<Ldlt>(matrix)) {}
SparseFactor::~SparseFactor() = default;

void SparseFactor::compute(const Eigen::SparseMatrix<double>& matrix) { ldlt_->compute(matrix); }
bool SparseFactor::usable() const { return ldlt_->info() == Eigen::Success; }
int SparseFactor::negative_pivots() const { return static_cast<int>((ldlt_->vectorD().array() < 0).count()); }
bool SparseFactor::positive() const { return usable() && (ldlt_->vectorD().array() > 0).all(); }
VectorX SparseFactor::solve(const Eigen::Ref<const VectorX>& right) const { return ldlt_->solve(right); }

}  // namespace elastin
