#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "elastin/core/model/material.h"
#include "elastin/core/model/state.h"

namespace elastin {

/// Numbers that relax, v(t) = ∫ G(t − s) dvᵉ(s) + θ dvᵉ/dt: force densities, or stresses at points. Within a step
/// v = factor vᵉ + fixed; see make_prony.
///
/// What is stored: a term is a spring behind a dashpot. Its spring is strained by eᵢ, which relaxes as its force does,
/// eᵢ(t) = ∫ e^(−(t−s)/τᵢ) dε(s), and holds ¼ gᵢ Qᵢ eᵢ [J] where ε is a squared length beyond that at rest, or 2E at a
/// point times its weight. Of a law that is linear in ε that is exact; of others ¼ vᵉ ε is not quite W, and the terms'
/// sum is taken as many times larger as W is.
class Relaxing {
 public:
  Relaxing() = default;
  Relaxing(const Relaxation& relaxation, Eigen::Index size)
      : long_term_(relaxation.long_term()),
        fixed_(VectorX::Zero(size)),
        now_(VectorX::Zero(size)),
        strain_(VectorX::Zero(size)) {
    for (const auto& [share, time] : relaxation.terms) terms_.push_back({share, time});
    if (relaxation.retardation > 0) terms_.push_back({relaxation.retardation, 0});
    factor_ = long_term_;  // until a step begins: what is at rest has relaxed
  }

  explicit operator bool() const { return !terms_.empty(); }
  double factor() const { return factor_; }        ///< g₀ + Σ gᵢ hᵢ + θ/Δ
  const VectorX& fixed() const { return fixed_; }  ///< what the past has left
  /// Memory for vᵉ and ε in the state that was reached.
  VectorX& now() { return now_; }
  VectorX& strain() { return strain_; }

  /// The time, vᵉ then and each term's own, ε then and each term's own.
  std::vector<HistoryBlock> history(const std::string& name) const {
    return {{name, std::vector<double>(1 + 2 * (1 + terms_.size()) * static_cast<std::size_t>(fixed_.size()), 0)}};
  }

  /// Energy [J] stored in the state that was reached, whose elastic energy is W.
  double stored_energy(double elastic) const {
    const double larger = linear_ > 0 && elastic > 0 ? std::clamp(elastic / linear_, 0.5, 2.) : 1;
    return long_term_ * elastic + larger * in_terms_;
  }

  void begin_step(const std::string& name, const State& from, double time) {
    const HistoryBlock* block = from.find_history(name);
    const double step = time - (block ? block->values[0] : from.time);
    if (!(step > 0)) note_stored(block);
    factor_ = long_term_;
    fixed_.setZero();
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const Part own = part(i, step);
      factor_ += own.of_change;
      if (block && !std::isinf(step)) fixed_ += own.left * values(*block, 1 + i) - own.of_change * values(*block, 0);
    }
  }

  /// now() and strain() are those of the state.
  void commit_step(const std::string& name, State& state) {
    HistoryBlock* block = state.find_history(name);
    if (!block) return;
    const double step = state.time - block->values[0];
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      auto own = values(*block, 1 + i), strained = values(*block, strain_row() + 1 + i);
      const Part now = part(i, step);
      if (step > 0) {
        own = now.left * own + now.of_change * (now_ - values(*block, 0));
        strained = now.left * strained + now.of_change / terms_[i].share * (strain_ - values(*block, strain_row()));
      } else {
        own.setZero(), strained.setZero();
      }
    }
    values(*block, 0) = now_;
    values(*block, strain_row()) = strain_;
    block->values[0] = state.time;
    begin_step(name, state, state.time);
  }

  /// As TransposedHistory::transpose_commit; gives the slopes by now().
  VectorX transpose_commit(double step, std::vector<double>& slopes) const {
    VectorX of_now = row(slopes, 0);
    row(slopes, 0).setZero();
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const Part own = step > 0 ? part(i, step) : Part{0, 0};
      auto of_own = row(slopes, 1 + i);
      of_now += own.of_change * of_own;
      row(slopes, 0) -= own.of_change * of_own;
      of_own *= own.left;
    }
    return of_now;
  }
  /// Adds what a function has by the history through fixed(), by which it has `of_fixed`.
  void transpose_fixed(double step, const VectorX& of_fixed, std::vector<double>& slopes) const {
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const Part own = part(i, step);
      row(slopes, 1 + i) += own.left * of_fixed;
      row(slopes, 0) -= own.of_change * of_fixed;
    }
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
  std::size_t strain_row() const { return 1 + terms_.size(); }
  Eigen::Map<const VectorX> values(const HistoryBlock& block, std::size_t row) const {
    return {block.values.data() + 1 + static_cast<Eigen::Index>(row) * fixed_.size(), fixed_.size()};
  }
  Eigen::Map<VectorX> values(HistoryBlock& block, std::size_t number) const { return row(block.values, number); }
  Eigen::Map<VectorX> row(std::vector<double>& values, std::size_t number) const {
    return {values.data() + 1 + static_cast<Eigen::Index>(number) * fixed_.size(), fixed_.size()};
  }
  void note_stored(const HistoryBlock* block) {
    in_terms_ = linear_ = 0;
    if (!block) return;
    linear_ = values(*block, 0).dot(values(*block, strain_row())) / 4;
    for (std::size_t i = 0; i < terms_.size(); ++i)
      if (terms_[i].time > 0) in_terms_ += values(*block, 1 + i).dot(values(*block, strain_row() + 1 + i)) / 4;
  }

  double long_term_ = 1, factor_ = 0;
  double in_terms_ = 0, linear_ = 0;  ///< Σ ¼ gᵢ Qᵢ eᵢ and ¼ vᵉ ε, in the state that was reached [J]
  std::vector<Term> terms_;
  VectorX fixed_, now_, strain_;
};

}  // namespace elastin
