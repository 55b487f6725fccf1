#include "core/solve/last_solve.h"

#include <cmath>
#include <utility>

#include "core/base/dense.h"

namespace elastin {
namespace {

constexpr std::size_t kMostMotions = 4;
/// Part of their energy by which motions have to differ.
constexpr double kApart = 1e-10;

}  // namespace

void LastSolve::begin(const Model& model) {
  model_ = &model;
  motions_.clear();
  solver = {};
}

LastSolve LastSolve::taken_for(const Model& model) {
  LastSolve own = std::exchange(*this, {});
  const bool fits = own.model_ == &model && (own.motions_.empty() || own.motions_[0].cols() == model.body().size());
  return fits ? std::move(own) : LastSolve();
}

void LastSolve::note(Positions motion, const std::vector<Support>& supports) {
  keep_free(supports, motion);
  if (!motion.allFinite()) return;
  if (motions_.size() < kMostMotions)
    motions_.push_back(std::move(motion));
  else
    motions_.back() += motion;
}

Positions LastSolve::nearest(const Tangent& tangent, const std::vector<Support>& supports, Positions& rhs) const {
  Positions sum = Positions::Zero(3, rhs.cols()), forces(3, rhs.cols());
  if (motions_.empty()) return sum;
  const auto count = static_cast<Eigen::Index>(motions_.size());
  Tangent::ApplyWorkspace workspace;
  MatrixX energies(count, count);
  VectorX works(count), size(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    tangent.apply(motions_[j], forces, workspace);
    for (Eigen::Index i = 0; i < count; ++i) energies(i, j) = ordered_dot(motions_[i], forces);
    works[j] = ordered_dot(motions_[j], rhs);
    size[j] = energies(j, j) > 0 ? 1 / std::sqrt(energies(j, j)) : 0;
  }
  const SymmetricEigen modes = symmetric_eigen(size.asDiagonal() * energies * size.asDiagonal());
  VectorX factors = VectorX::Zero(count);
  for (Eigen::Index i = 0; i < count; ++i)
    if (modes.values[i] > kApart)
      factors += modes.vectors.col(i).dot(size.cwiseProduct(works)) / modes.values[i] * modes.vectors.col(i);
  for (Eigen::Index i = 0; i < count; ++i) sum += factors[i] * size[i] * motions_[i];
  tangent.apply(sum, forces, workspace);
  keep_free(supports, forces);
  forces = rhs - forces;
  if (!(ordered_norm(forces) < ordered_norm(rhs))) return Positions::Zero(3, rhs.cols());
  rhs = std::move(forces);
  return sum;
}

std::shared_ptr<LastSolve> make_last_solve() { return std::make_shared<LastSolve>(); }

}  // namespace elastin
