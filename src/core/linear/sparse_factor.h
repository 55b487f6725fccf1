#pragma once
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// What a factorisation would take, from the matrix's places alone.
struct FactorCost {
  double numbers = 0;   ///< in L
  double products = 0;  ///< that make them
};
/// Of a symmetric matrix of 3 × 3 blocks, of which these are the pairs that are not zero.
FactorCost factor_cost(int blocks, const std::vector<std::array<int, 2>>& pairs);

/// L D Lᵀ of a symmetric sparse matrix, compiled once.
class SparseFactor {
 public:
  SparseFactor();
  explicit SparseFactor(const Eigen::SparseMatrix<double>& matrix);
  ~SparseFactor();

  /// Of the lower half. Throws InputError where L has more than 2³¹ − 1 entries.
  void compute(const Eigen::SparseMatrix<double>& matrix);

  bool usable() const;          ///< whether no pivot was zero; nothing else may be asked where one was
  int negative_pivots() const;  ///< as many as there are negative eigenvalues [Sylvester]
  bool positive() const;        ///< whether it is usable and all pivots are
  VectorX solve(const Eigen::Ref<const VectorX>& right) const;
  /// The same without an allocation once both vectors have their size; `spare` is room for one more.
  void solve(const Eigen::Ref<const VectorX>& right, VectorX& spare, VectorX& solution) const;

 private:
  struct Ldlt;
  std::unique_ptr<Ldlt> ldlt_;
  VectorX pivots_;  ///< D
};

}  // namespace elastin
