#pragma once
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// What softening makes of an energy density W: φ, η = φ′ and η′ = φ″.
struct SoftenedEnergy {
  double energy;  ///< φ [J/m³]: what can still be had back
  double factor;  ///< η, of the stress
  double slope;   ///< η′ [1/Pa]
};

/// Below the largest energy density W_max that there was,
///   η = 1 − (1/r) erf((W_max − W)/(m + β W_max));  at W_max and beyond η = 1.        [Ogden & Roxburgh 1999]
/// φ is its integral from 0. W and W_max [J/m³], ≥ 0.
SoftenedEnergy softened_energy(const Softening& softening, double energy, double most);

/// ∂η/∂W_max [1/Pa]; 0 at W_max and beyond.
double softened_factor_by_most(const Softening& softening, double energy, double most);

/// Throws InputError unless r > 1, m ≥ 0, β ≥ 0 and one of m and β is above 0.
void check_softening(const Softening& softening);

/// A law that softens where it has been strained before: stress η S, with W and W_max of each element by itself: of
/// each cell of first order or quadrature point, and of each spring as a rod of the material. Where a law keeps its
/// volume by pressures of its own, W and η are those of the rest. On the way up the law is as it was. W_max is part of
/// the state: it grows where a step is accepted. Takes the energy ∫(1 − η) dW of each cycle.
/// The softening's m is in the unit of the elements' energy: [J/m²] of membranes.
/// Throws InputError where the law has no energy, or on a fault.
ElasticTerms make_mullins(ElasticTerms elastic, const Softening& softening);

/// The history of what softens: W_max of each element. Without elements, of what does not.
class SoftenedElements {
 public:
  SoftenedElements() = default;
  SoftenedElements(const Softening& softening, int elements) : softening_(softening), most_(elements, 0) {}

  explicit operator bool() const { return !most_.empty(); }
  SoftenedEnergy at(int element, double energy) const { return softened_energy(softening_, energy, most_[element]); }

  std::vector<HistoryBlock> history(const std::string& name) const {
    if (most_.empty()) return {};
    return {{name, std::vector<double>(most_.size(), 0)}};
  }
  void begin_step(const std::string& name, const State& from) {
    if (const HistoryBlock* block = from.find_history(name))
      std::copy(block->values.begin(), block->values.end(), most_.begin());
  }
  /// @param energy of an element [J/m³] in the state that was reached.
  template <class Energy>
  void commit_step(const std::string& name, State& state, Energy&& energy) {
    HistoryBlock* block = most_.empty() ? nullptr : state.find_history(name);
    if (!block) return;
    for (std::size_t element = 0; element < most_.size(); ++element)
      block->values[element] = most_[element] = std::max(block->values[element], energy(static_cast<int>(element)));
  }
  /// As TransposedHistory::transpose_commit, of one element with this energy at the end: gives the slope by it.
  double transpose_commit(const HistoryBlock& from, int element, double energy, std::vector<double>& slopes) const {
    return energy > from.values[element] ? std::exchange(slopes[element], 0) : 0;
  }
  /// As TransposedHistory::transpose_forces, of one element. @param work λ·f of its forces without softening
  void transpose_forces(const HistoryBlock& from, int element, double energy, double work,
                        std::vector<double>& slopes) const {
    slopes[element] += softened_factor_by_most(softening_, energy, from.values[element]) * work;
  }

 private:
  Softening softening_;
  std::vector<double> most_;
};

}  // namespace elastin
