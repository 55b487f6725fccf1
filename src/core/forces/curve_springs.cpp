#include <utility>

#include "core/parallel/parallel.h"
#include "elastin/core/forces/elasticity.h"

namespace elastin {
namespace {

/// Tension w L P(ε), ε = l/L − 1: q = w L P/l, ∂q/∂s = w (P′ − P L/l)/(2 l²), energy w L² ∫P dε.
class CurveSprings final : public Elasticity {
 public:
  CurveSprings(const Body& body, VectorX sections, StressStrain curve)
      : connections_(body.connections), sections_(std::move(sections)), curve_(std::move(curve)) {}

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<CurveSprings>(*this); }
  double energy(const Positions& positions) const override {
    return ordered_sum(connections_.size(), [&](int c) {
      const double rest = connections_.rest_length[c];
      return sections_[c] == 0 ? 0 : sections_[c] * rest * rest * curve_.energy_density(strain(positions, c));
    });
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace&) const override {
    parallel_for(connections_.size(), [&](int c) {
      const double at = strain(positions, c);
      if (sections_[c] != 0 && at > -1) force_densities[c] += sections_[c] * curve_.stress(at) / (1 + at);
    });
  }
  void linearise(const Positions& positions) override {
    slopes_ = VectorX::Zero(connections_.size());
    parallel_for(connections_.size(), [&](int c) {
      const double at = strain(positions, c), stretch = 1 + at, length = stretch * connections_.rest_length[c];
      if (sections_[c] != 0 && at > -1)
        slopes_[c] = sections_[c] * (curve_.modulus(at) - curve_.stress(at) / stretch) / (2 * length * length);
    });
  }
  void add_own_slopes(VectorX& slopes) const override { slopes += slopes_; }

 private:
  double strain(const Positions& positions, int c) const {
    const auto& [a, b] = connections_.ends[c];
    const double rest = connections_.rest_length[c];
    return ((positions.col(b) - positions.col(a)).norm() - rest) / rest;
  }

  const Connections& connections_;
  VectorX sections_, slopes_;
  StressStrain curve_;
};

}  // namespace

std::unique_ptr<Elasticity> make_curve_springs(const Body& body, VectorX sections, const StressStrain& curve) {
  return std::make_unique<CurveSprings>(body, std::move(sections), curve);
}

std::unique_ptr<Elasticity> make_springs(const Body& body, VectorX constants, const Material& material) {
  if (!material.curve) return make_springs(body, std::move(constants));
  return make_curve_springs(body, constants / material.youngs_modulus, *material.curve);
}

std::unique_ptr<Elasticity> make_cables(const Body& body) {
  VectorX sections = VectorX::Zero(body.connections.size());  // w L P(ε) = EA ε with a modulus of 1 Pa
  for (const Cable& cable : body.cables)
    sections[cable.connection] =
        cable.stiffness / body.connections.rest_length[static_cast<std::size_t>(cable.connection)];
  return make_curve_springs(body, std::move(sections), StressStrain::linear(1).without_compression());
}

}  // namespace elastin
