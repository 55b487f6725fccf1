#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "elastin/core/model/material.h"
#include "elastin/core/model/state.h"

namespace elastin {

/// Numbers that relax, v(t) = ∫ G(t − s) dvᵉ(s) + θ dvᵉ/dt: force densities, or stresses at points. Within a step
/// v = factor vᵉ + fixed; see make_prony.
class Relaxing {
 public:
  Relaxing() = default;
  Relaxing(const Relaxation& relaxation, Eigen::Index size)
      : long_term_(relaxation.long_term()), fixed_(VectorX::Zero(size)), now_(VectorX::Zero(size)) {
    for (const auto& [share, time] : relaxation.terms) terms_.push_back({share, time});
    if (relaxation.retardation > 0) terms_.push_back({relaxation.retardation, 0});
    for (std::size_t i = 0; i < terms_.size(); ++i) factor_ += part(i, 0).of_change;
    factor_ += long_term_;
  }

  explicit operator bool() const { return !terms_.empty(); }
  double factor() const { return factor_; }        ///< g₀ + Σ gᵢ hᵢ + θ/Δ
  const VectorX& fixed() const { return fixed_; }  ///< what the past has left
  /// Memory for vᵉ in the state that was reached.
  VectorX& now() { return now_; }

  /// The time, vᵉ then, and each term's own.
  std::vector<HistoryBlock> history(const std::string& name) const {
    return {{name, std::vector<double>(1 + (1 + terms_.size()) * static_cast<std::size_t>(fixed_.size()), 0)}};
  }

  void begin_step(const std::string& name, const State& from, double time) {
    const HistoryBlock* block = from.find_history(name);
    const double step = time - (block ? block->values[0] : from.time);
    factor_ = long_term_;
    fixed_.setZero();
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const Part own = part(i, step);
      factor_ += own.of_change;
      if (block && !std::isinf(step)) fixed_ += own.left * values(*block, 1 + i) - own.of_change * values(*block, 0);
    }
  }

  /// now() is vᵉ of the state.
  void commit_step(const std::string& name, State& state) {
    HistoryBlock* block = state.find_history(name);
    if (!block) return;
    const double step = state.time - block->values[0];
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      Eigen::Map<VectorX> own(block->values.data() + 1 + (1 + static_cast<Eigen::Index>(i)) * fixed_.size(),
                              fixed_.size());
      const Part now = part(i, step);
      if (step > 0)
        own = now.left * own + now.of_change * (now_ - values(*block, 0));
      else
        own.setZero();
    }
    std::copy(now_.begin(), now_.end(), block->values.begin() + 1);
    block->values[0] = state.time;
    begin_step(name, state, state.time);
  }

 private:
  struct Term {
    double share, time;  ///< gᵢ, τᵢ [s]; of a dashpot θ [s], 0
  };
  /// Of a term over a step: what is left of its own, and what the change of vᵉ adds.
  struct Part {
    double left, of_change;
  };

  /// gᵢ Qᵢ ← e^(−Δ/τ) gᵢ Qᵢ + gᵢ h Δvᵉ; a dashpot's θ Δvᵉ/Δ. Over no step what was, over all time nothing.
  Part part(std::size_t term, double step) const {
    const auto& [share, time] = terms_[term];
    if (std::isinf(step)) return {0, 0};
    if (time == 0) return step > 0 ? Part{0, share / step} : Part{1, 0};
    const double x = step / time;
    return {std::exp(-x), x > 0 ? -std::expm1(-x) / x * share : share};
  }
  Eigen::Map<const VectorX> values(const HistoryBlock& block, std::size_t row) const {
    return {block.values.data() + 1 + static_cast<Eigen::Index>(row) * fixed_.size(), fixed_.size()};
  }

  double long_term_ = 1, factor_ = 0;
  std::vector<Term> terms_;
  VectorX fixed_, now_;
};

}  // namespace elastin
