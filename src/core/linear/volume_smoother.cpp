#include "core/linear/volume_smoother.h"

#include <algorithm>
#include <cmath>

#include "core/linear/smoothing.h"
#include "core/linear/sparse_stiffness.h"
#include "core/parallel/parallel.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

/// Molecules around a volume, beyond which it is one of a whole body, and T would have full rows.
constexpr std::size_t kMostAround = 64;
/// T_ii up to which blocks of single molecules do as well: ν = 0.42.
constexpr float kSoft = 4;

}  // namespace

std::optional<VolumeSmoother> VolumeSmoother::of(const Tangent& tangent, const std::vector<Support>& supports) {
  VolumeSmoother result;
  const int molecules = tangent.model().body().size();
  std::vector<Matrix3> blocks;
  result.start_.assign(1, 0);
  tangent.visit_gradients([&](std::span<const std::pair<int, Vector3>> gradient, double factor) {
    if (gradient.size() > kMostAround || !(factor > 0)) return;
    for (int a = static_cast<int>(blocks.size()); a < molecules; ++a) blocks.push_back(tangent.diagonal(a));
    for (const auto& [molecule, g] : gradient) {
      result.parts_.push_back({molecule, (std::sqrt(factor) * g).cast<float>()});
      blocks[molecule] -= factor * g * g.transpose();
    }
    result.start_.push_back(static_cast<int>(result.parts_.size()));
  });
  if (result.parts_.empty()) return {};
  // The blocks times as much as their largest eigenvalue with K̃ over that of one step of smoothing.
  constexpr double enough = 1.3;
  for (Matrix3& block : blocks) block *= enough;
  result.inverse_.compute(stiffness_scale(tangent), blocks, supports);
  result.set_pressures();
  if (result.stiffest_ < kSoft) return {};
  return result;
}

void VolumeSmoother::set_pressures() {
  const int count = static_cast<int>(start_.size()) - 1;
  parts_start_.assign(inverse_.size() + 1, 0);
  for (const Part& part : parts_) ++parts_start_[part.molecule + 1];
  for (int a = 0; a < inverse_.size(); ++a) parts_start_[a + 1] += parts_start_[a];
  of_molecule_.resize(parts_.size());
  std::vector<int> next(parts_start_.begin(), parts_start_.end() - 1), found(count, -1);
  for (int c = 0; c < count; ++c)
    for (int p = start_[c]; p < start_[c + 1]; ++p) of_molecule_[next[parts_[p].molecule]++] = {c, parts_[p].gradient};
  rows_start_.assign(1, 0), rows_.clear();
  weights_.resize(count);
  float largest = 1;  // a bound of the eigenvalues of T over T_ii
  for (int c = 0; c < count; ++c) {
    const int first = rows_start_.back();
    found[c] = first, rows_.push_back({c, 1});
    for (int p = start_[c]; p < start_[c + 1]; ++p) {
      const int a = parts_[p].molecule;
      const Eigen::Vector3f moved = inverse_.times(a, parts_[p].gradient.cast<double>()).cast<float>();
      for (int k = parts_start_[a]; k < parts_start_[a + 1]; ++k) {
        const int other = of_molecule_[k].molecule;
        if (found[other] < first) found[other] = static_cast<int>(rows_.size()), rows_.push_back({other, 0});
        rows_[found[other]].value += moved.dot(of_molecule_[k].gradient);
      }
    }
    rows_start_.push_back(static_cast<int>(rows_.size()));
    float sum = 0;
    for (int k = first; k < rows_start_.back(); ++k) sum += std::abs(rows_[k].value);
    weights_[c] = rows_[first].value;
    largest = std::max(largest, sum / weights_[c]);
  }
  stiffest_ = weights_.maxCoeff();
  weights_ = (largest * weights_).cwiseInverse();
  for (int c = 0; c < count; ++c)
    for (int k = rows_start_[c]; k < rows_start_[c + 1]; ++k) rows_[k].value *= weights_[c];
  // What is left of volumes after twice as many steps, λ / (2 steps + 1)² of a part, meets T_ii.
  constexpr int most = 12;
  steps_ = std::clamp(static_cast<int>(std::sqrt(largest * stiffest_) / 2), 1, most);
  right_ = y_ = better_ = step_ = Eigen::VectorXf::Zero(count);
}

/// y nearer to T⁻¹ right.
void VolumeSmoother::steps() {
  for (int i = 1; i <= steps_; ++i) {
    const auto before = static_cast<float>(smoothing_step(i).before), now = static_cast<float>(smoothing_step(i).now);
    parallel_for(static_cast<int>(y_.size()), [&](int c) {
      float left = right_[c];
      for (int k = rows_start_[c]; k < rows_start_[c + 1]; ++k) left -= rows_[k].value * y_[rows_[k].column];
      step_[c] = before * step_[c] + now * left;
      better_[c] = y_[c] + step_[c];
    });
    std::swap(y_, better_);
  }
}

void VolumeSmoother::apply(Positions& vectors) {
  const int volumes = static_cast<int>(right_.size());
  const double size = ordered_norm(vectors);
  if (!(size > 0)) return;
  parallel_for(
      inverse_.size(), [&](int a) { vectors.col(a) = inverse_.times(a, vectors.col(a) / size); }, kMoleculeThreshold);
  parallel_for(volumes, [&](int c) {
    double sum = 0;
    for (int p = start_[c]; p < start_[c + 1]; ++p)
      sum += parts_[p].gradient.cast<double>().dot(vectors.col(parts_[p].molecule));
    right_[c] = weights_[c] * static_cast<float>(sum);
  });
  y_.setZero();
  steps();
  steps();
  parallel_for(
      inverse_.size(),
      [&](int a) {
        Eigen::Vector3f pushed = Eigen::Vector3f::Zero();
        for (int k = parts_start_[a]; k < parts_start_[a + 1]; ++k)
          pushed += y_[of_molecule_[k].molecule] * of_molecule_[k].gradient;
        vectors.col(a) = size * (vectors.col(a) - inverse_.times(a, pushed.cast<double>()));
      },
      kMoleculeThreshold);
}

}  // namespace elastin
