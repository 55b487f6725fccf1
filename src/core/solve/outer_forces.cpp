#include "core/solve/outer_forces.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace elastin {
namespace {

Matrix3 positive_part(const Matrix3& block) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> parts(block);
  return parts.eigenvectors() * parts.eigenvalues().cwiseMax(0).asDiagonal() * parts.eigenvectors().transpose();
}

}  // namespace

void OuterForces::begin(const Model& model, const State& state, const Weights& weights) {
  const auto& loads = model.loads();
  const bool vary = !model.viscosity().empty() ||
                    std::any_of(loads.begin(), loads.end(), [](const auto& load) { return load->changes(); });
  viscous_.assign(model.body().size(), Matrix3::Zero());
  loaded_.assign(model.body().size(), Matrix3::Zero());
  if (!model.viscosity().empty()) add_viscous_blocks(model, state, weights);
  vary_ = true;
  update(model, state, weights);
  vary_ = vary;
}

void OuterForces::update(const Model& model, const State& state, const Weights& weights) {
  if (!vary_) return;
  std::swap(kept_, loaded_);
  loaded_.assign(model.body().size(), Matrix3::Zero());
  const auto add = [this](int a, int b, const Matrix3& block) {
    Matrix3& own = loaded_[a];
    if (a == b) {
      // What has no symmetric stiffness, as sliding friction that grows with the pressure, is bounded from above.
      const Matrix3 whole = (block + block.transpose()) / 2, turning = (block - block.transpose()) / 2;
      own += whole + turning.norm() / std::sqrt(2) * Matrix3::Identity();
    } else {
      own.diagonal().array() += block.norm();
    }
  };
  const Load::BlockVisitor visit = std::ref(add);
  for (const auto& load : model.loads()) load->visit_blocks(state, weights.velocity, visit);
  blocks_ = viscous_;
  for (std::size_t a = 0; a < loaded_.size(); ++a) {
    if (kept_[a] != loaded_[a]) loaded_[a] += positive_part(kept_[a] - loaded_[a]);
    blocks_[a] += loaded_[a];
  }
  positions_ = state.positions;
  forces_.setZero(3, model.body().size());
  model.add_other_forces(state, forces_, workspace_);
}

/// Of a connection with the slope s its stiffness 2 s d dᵀ between two molecules is at most twice that at each; of
/// cells the slopes between their connections are at most the sums of their sizes at each.
void OuterForces::add_viscous_blocks(const Model& model, const State& state, const Weights& weights) {
  const Connections& connections = model.body().connections;
  slopes_.setZero(connections.size());
  squared_lengths_.resize(connections.size()), rates_.resize(connections.size());
  for (int c = 0; c < connections.size(); ++c) {
    const auto& [a, b] = connections.ends[c];
    const Vector3 d = state.positions.col(b) - state.positions.col(a);
    squared_lengths_[c] = d.squaredNorm();
    rates_[c] = 2 * d.dot(state.velocities.col(b) - state.velocities.col(a));
  }
  const auto add_cells = [&](const CellSlopes& cells) {
    for (int cell = 0; cell < cells.size(); ++cell) {
      const auto sides = cells.connections_of(cell);
      const double* slopes = cells.slopes_of(cell);
      for (const int own : sides)
        for (std::size_t other = 0; other < sides.size(); ++other)
          slopes_[own] += weights.velocity * cells.factor * std::abs(*slopes++);
    }
  };
  const EdgeSlopes::CellVisitor visit = std::ref(add_cells);
  for (const auto& term : model.viscosity()) {
    term->add_own_slopes(squared_lengths_, rates_, weights.velocity, slopes_);
    term->visit_cells(visit);
  }
  for (int c = 0; c < connections.size(); ++c) {
    const auto& [a, b] = connections.ends[c];
    const Vector3 d = state.positions.col(b) - state.positions.col(a);
    const Matrix3 block = 4 * std::max(0., slopes_[c]) * d * d.transpose();
    viscous_[a] += block;
    viscous_[b] += block;
  }
}

}  // namespace elastin
