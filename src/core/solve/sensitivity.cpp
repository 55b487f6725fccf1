#include "elastin/core/solve/sensitivity.h"

#include <Eigen/SparseLU>
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/solve/full_tangent.h"
#include "core/solve/newton.h"
#include "core/solve/responses.h"
#include "core/solve/stiffness_slopes.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

/// Molecules above which Kᵀ is not factorised.
constexpr int kMostTransposed = 30000;

using Sparse = Eigen::SparseMatrix<double>;

VectorX as_vector(const Positions& columns) { return Eigen::Map<const VectorX>(columns.data(), columns.size()); }
Positions as_columns(const VectorX& vector) { return Eigen::Map<const Positions>(vector.data(), 3, vector.size() / 3); }

/// Of each molecule the directions in which it is fixed, as a projector.
std::vector<Matrix3> fixed_directions(const Model& model) {
  std::vector<Matrix3> fixed(static_cast<std::size_t>(model.body().size()), Matrix3::Zero());
  for (const Support& support : model.supports) fixed[support.molecule] = Matrix3::Identity() - support.free;
  return fixed;
}

Positions projected(const std::vector<Matrix3>& directions, const Positions& vectors) {
  Positions result(3, vectors.cols());
  for (Eigen::Index i = 0; i < vectors.cols(); ++i) result.col(i) = directions[i] * vectors.col(i);
  return result;
}

}  // namespace

/// The transpose of an unsymmetric stiffness: its sparse part, and wide parts by their ranks [Sherman & Morrison 1950].
class TransposedStiffness {
 public:
  TransposedStiffness(const Tangent& tangent, const std::vector<Matrix3>& fixed)
      : wide_(tangent.wide_terms()), fixed_(fixed) {
    std::vector<Eigen::Triplet<double>> all, free;
    const auto add = [](std::vector<Eigen::Triplet<double>>& list, int a, int b, const Matrix3& block) {
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) list.emplace_back(3 * a + row, 3 * b + column, block(row, column));
    };
    tangent.visit_blocks([&](int a, int b, const Matrix3& block) {
      const Matrix3 free_a = Matrix3::Identity() - fixed[a], free_b = Matrix3::Identity() - fixed[b];
      add(all, b, a, block.transpose());
      add(free, b, a, free_b * block.transpose() * free_a);
    });
    const auto size = static_cast<Eigen::Index>(3 * fixed.size());
    matrix_ = Sparse(size, size);
    matrix_.setFromTriplets(all.begin(), all.end());
    const double scale = matrix_.diagonal().cwiseAbs().mean();
    for (std::size_t i = 0; i < fixed.size(); ++i)
      add(free, static_cast<int>(i), static_cast<int>(i), scale * fixed[i]);
    Sparse of_free(size, size);
    of_free.setFromTriplets(free.begin(), free.end());
    factor_.compute(of_free);
    if (!usable()) return;
    for (const WideTerm& term : wide_) {
      const Positions direction = term.direction - projected(fixed_, term.direction);
      solved_.push_back(solve(as_vector(direction), solved_.size()));
    }
  }

  bool usable() const { return factor_.info() == Eigen::Success; }
  Positions apply(const Positions& x) const {
    VectorX result = matrix_ * as_vector(x);
    for (const WideTerm& term : wide_)
      result += term.factor * as_vector(term.direction).dot(as_vector(x)) * as_vector(term.direction);
    return as_columns(result);
  }
  Positions solve(const Positions& rhs) const { return as_columns(solve(as_vector(rhs), solved_.size())); }

 private:
  VectorX solve(const VectorX& rhs, std::size_t terms) const {
    VectorX x = factor_.solve(rhs);
    for (std::size_t i = 0; i < terms; ++i) {
      const VectorX direction = as_vector(wide_[i].direction - projected(fixed_, wide_[i].direction));
      x -= direction.dot(x) / (1 / wide_[i].factor + direction.dot(solved_[i])) * solved_[i];
    }
    return x;
  }

  std::vector<WideTerm> wide_;
  const std::vector<Matrix3>& fixed_;
  Sparse matrix_;
  Eigen::SparseLU<Sparse> factor_;
  std::vector<VectorX> solved_;
};

struct Sensitivity::Impl {
  Impl(Model& a_model, const State& state, const StaticOptions& some_options, double a_tolerance, LastSolve* last)
      : model(a_model),
        options(some_options),
        tolerance(a_tolerance),
        responses(model, state, options, last),
        fixed(fixed_directions(model)) {
    if (const std::string why = without_full_tangent(model, state.positions); !why.empty())
      throw InputError("no derivatives of this equilibrium: " + why);
  }

  Model& model;
  StaticOptions options;
  double tolerance;
  Responses responses;
  std::vector<Matrix3> fixed;
  std::optional<TransposedStiffness> transposed;  ///< where the stiffness is not symmetric
};

Sensitivity::Sensitivity(Model& model, const State& state, const StaticOptions& options, double tolerance)
    : impl_(std::make_unique<Impl>(model, state, options, tolerance, nullptr)) {}
Sensitivity::Sensitivity(Model& model, const State& state, const StaticOptions& options, double tolerance,
                         LastSolve& last)
    : impl_(std::make_unique<Impl>(model, state, options, tolerance, &last)) {}
Sensitivity::~Sensitivity() = default;

StaticResponse Sensitivity::forward(const Positions& force_change, const Positions& displacement) {
  return impl_->responses.to(force_change, displacement, impl_->tolerance);
}

Adjoint Sensitivity::adjoint(const Positions& of_positions, const Positions& of_reactions) {
  Impl& in = *impl_;
  const Tangent& tangent = in.responses.tangent();
  const bool symmetric = in.model.symmetric();
  Adjoint found;
  if (!symmetric && !in.transposed) {
    if (in.model.body().size() <= kMostTransposed) in.transposed.emplace(tangent, in.fixed);
    if (!in.transposed || !in.transposed->usable()) {
      in.transposed.reset();
      found.result.outcome = Outcome::limit_reached;
      found.result.cause = "the transpose of the unsymmetric stiffness cannot be factorised";
      found.forces = found.displacement = Positions::Zero(3, of_positions.cols());
      return found;
    }
  }
  const auto transposed_times = [&](const Positions& x) {
    if (in.transposed) return in.transposed->apply(x);
    Positions result(3, x.cols());
    tangent.apply(x, result);
    return result;
  };
  const Positions none = Positions::Zero(3, of_positions.cols()), fixed = projected(in.fixed, of_reactions);
  Positions rhs = of_positions + transposed_times(fixed);
  rhs -= projected(in.fixed, rhs);
  if (in.transposed) {
    found.forces = in.transposed->solve(rhs);
    found.result.solver = "linear sparse LU of the transpose";
  } else {
    StaticResponse response = in.responses.to(rhs, none, in.tolerance);
    found.result = std::move(response.result);
    found.forces = std::move(response.motion);
  }
  found.forces -= fixed;
  found.displacement = projected(in.fixed, of_positions - transposed_times(found.forces));
  return found;
}

VectorX Sensitivity::by_stiffness(const Elasticity& law, const Adjoint& adjoint) const {
  const LocalElasticity* local = law.local();
  return local ? work_by_stiffness(*local, impl_->responses.tangent().positions(), adjoint.forces) : VectorX();
}

Positions Sensitivity::forces_by_stiffness(const Elasticity& law, const VectorX& changes) const {
  const LocalElasticity* local = law.local();
  if (!local || changes.size() != local->elements())
    throw InputError("changes of the stiffness are " + std::to_string(changes.size()) + "; the law has " +
                     counted(local ? local->elements() : 0, "element"));
  const Positions& at = impl_->responses.tangent().positions();
  Positions forces = Positions::Zero(3, at.cols());
  StiffnessSlopes(*local, at).add_forces(changes, forces);
  return forces;
}

}  // namespace elastin
