#include <algorithm>
#include <limits>
#include <utility>

#include "core/forces/finite_constants.h"
#include "core/forces/own_slopes.h"
#include "core/forces/unstressed_lengths.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/elasticity.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/laws/local.h"

namespace elastin {
namespace {

/// Tension w L P(ε), ε = l/L − 1: q = w L P/l, ∂q/∂s = w (P′ − P L/l)/(2 l²), energy w L² W, W = ∫P dε. Where they
/// soften, P is η(W) P, and P′ is η P′ + η′ P².
class CurveSprings final : public EdgeDensities,
                           public LocalElasticity,
                           public LawHistory,
                           public TransposedHistory,
                           public Softens {
 public:
  CurveSprings(const Body& body, VectorX sections, StressStrain curve)
      : body_(body),
        connections_(body.connections),
        rest_lengths_(body),
        sections_(std::move(sections)),
        curve_(std::move(curve)) {}

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<CurveSprings>(*this); }
  void set_rest(double part) override { rest_lengths_.set(part); }
  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    return softened_ || body_.unstressed ? nullptr
                                         : std::make_unique<CurveSprings>(*own.body, own.computed(sections_), curve_);
  }
  double energy(const Positions& positions) const override {
    return ordered_sum(connections_.size(), [&](int c) {
      const double rest = rest_lengths_[c];
      if (sections_[c] == 0) return 0.;
      const double energy = curve_.energy_density(strain(positions, c));
      return sections_[c] * rest * rest * (softened_ ? softened_.at(c, energy).energy : energy);
    });
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace&) const override {
    parallel_for(connections_.size(), [&](int c) {
      const double at = strain(positions, c);
      if (sections_[c] != 0 && at > -1) force_densities[c] += sections_[c] * stress_at(c, at).first / (1 + at);
    });
  }
  std::unique_ptr<EdgeSlopes> slopes() const override {
    return std::make_unique<OwnSlopes>(connections_.size(), [this](const Positions& positions, VectorX& slopes) {
      parallel_for(connections_.size(), [&](int c) {
        const double at = strain(positions, c), stretch = 1 + at, length = stretch * rest_lengths_[c];
        if (sections_[c] == 0 || !(at > -1)) return;
        const auto [stress, modulus] = stress_at(c, at);
        slopes[c] += sections_[c] * (modulus - stress / stretch) / (2 * length * length);
      });
    });
  }

  const LocalElasticity* local() const override { return dissipates() ? nullptr : this; }
  int elements() const override { return connections_.size(); }
  std::span<const int> molecules_of(int element) const override { return connections_.ends[element]; }
  double element_energy(const Positions& positions, int element) const override {
    const double rest = rest_lengths_[element];
    return sections_[element] == 0
               ? 0
               : sections_[element] * rest * rest * curve_.energy_density(strain(positions, element));
  }
  void add_blocks(const Positions& positions, std::span<const LocalSlot> slots, LocalBlock& block) const override {
    for (const auto& [element, node] : slots) {
      const double at = strain(positions, element);
      if (sections_[element] == 0 || !(at > -1)) continue;
      const auto& ends = connections_.ends[element];
      const Vector3 d = positions.col(ends[node]) - positions.col(ends[1 - node]);
      const double q = sections_[element] * curve_.stress(at) / (1 + at), stretch = std::max(0., q);
      const double along = (sections_[element] * std::max(0., curve_.modulus(at)) - stretch) / d.squaredNorm();
      block.gradient += q * d;
      block.hessian += along * d * d.transpose() + stretch * Matrix3::Identity();
    }
  }
  double relative_change(const Positions&, std::span<const LocalSlot> slots, const Vector3& motion) const override {
    double shortest = std::numeric_limits<double>::infinity();
    for (const LocalSlot& slot : slots)
      if (sections_[slot.element] != 0) shortest = std::min(shortest, rest_lengths_[slot.element]);
    return motion.norm() / shortest;
  }
  bool soften(const Softening& softening) override {
    softened_ = SoftenedElements(softening, connections_.size());
    return true;
  }
  bool softened() const override { return static_cast<bool>(softened_); }
  bool dissipates() const override { return softened(); }
  std::vector<HistoryBlock> history(const std::string& name) const override { return softened_.history(name); }
  void begin_step(const std::string& name, const State& from, double) override { softened_.begin_step(name, from); }
  void commit_step(const std::string& name, State& state) override {
    softened_.commit_step(name, state, [&](int c) { return curve_.energy_density(strain(state.positions, c)); });
  }
  void transpose_commit(const HistoryBlock& from, double, const Positions& positions, std::vector<double>& slopes,
                        Positions& of_positions) const override {
    for (int c = 0; c < connections_.size(); ++c) {
      const auto& [a, b] = connections_.ends[c];
      const double at = strain(positions, c), rest = rest_lengths_[c],
                   slope = softened_.transpose_commit(from, c, curve_.energy_density(at), slopes);
      if (slope == 0) continue;
      const Vector3 of_end =
          slope * curve_.stress(at) / ((1 + at) * rest * rest) * (positions.col(b) - positions.col(a));
      of_positions.col(b) += of_end;
      of_positions.col(a) -= of_end;
    }
  }
  void transpose_forces(const HistoryBlock& from, double, const Positions& positions, const Positions& lambda,
                        std::vector<double>& slopes) const override {
    for (int c = 0; c < connections_.size(); ++c) {
      const auto& [a, b] = connections_.ends[c];
      const double at = strain(positions, c);
      if (sections_[c] == 0 || !(at > -1)) continue;
      const double work = (positions.col(b) - positions.col(a)).dot(lambda.col(a) - lambda.col(b));
      softened_.transpose_forces(from, c, curve_.energy_density(at), sections_[c] * curve_.stress(at) / (1 + at) * work,
                                 slopes);
    }
  }

 private:
  /// P and P′ [Pa].
  std::pair<double, double> stress_at(int c, double strain) const {
    const double stress = curve_.stress(strain), modulus = curve_.modulus(strain);
    if (!softened_) return {stress, modulus};
    const SoftenedEnergy now = softened_.at(c, curve_.energy_density(strain));
    return {now.factor * stress, now.factor * modulus + now.slope * stress * stress};
  }
  double strain(const Positions& positions, int c) const {
    const auto& [a, b] = connections_.ends[c];
    const double rest = rest_lengths_[c];
    return ((positions.col(b) - positions.col(a)).norm() - rest) / rest;
  }

  const Body& body_;
  const Connections& connections_;
  UnstressedLengths rest_lengths_;
  VectorX sections_;
  StressStrain curve_;
  SoftenedElements softened_;
};

}  // namespace

std::unique_ptr<Elasticity> make_curve_springs(const Body& body, VectorX sections, const StressStrain& curve) {
  check_finite_constants(sections, "section", "m");
  return std::make_unique<CurveSprings>(body, std::move(sections), curve);
}

std::unique_ptr<Elasticity> make_springs(const Body& body, VectorX constants, const Material& material) {
  if (!material.curve) return make_springs(body, std::move(constants));
  return make_curve_springs(body, constants / material.youngs_modulus, *material.curve);
}

std::unique_ptr<Elasticity> make_cables(const Body& body) {
  VectorX sections = VectorX::Zero(body.connections.size());  // w L P(ε) = EA ε with a modulus of 1 Pa
  for (const Cable& cable : body.cables)
    sections[cable.connection] = cable.stiffness / body.connections.rest_length[cable.connection];
  return make_curve_springs(body, std::move(sections), StressStrain::linear(1).without_compression());
}

}  // namespace elastin
