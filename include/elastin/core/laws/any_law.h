#pragma once
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "elastin/core/laws/law.h"

namespace elastin {

/// Any law at work at one point, its type forgotten: drivers are compiled once for all of them. It is called once for
/// many points, so that the call costs little. Copies share the law.
template <int dimensions>
class AnyPoint {
 public:
  /// That it is another type is asked first: whether AnyPoint is a law needs its constructors again.
  template <class Law>
  requires(!std::same_as<Law, AnyPoint>) && PointLaw<Law, dimensions> explicit AnyPoint(Law law)
      : law_(std::make_shared<const Held<Law>>(std::move(law))) {}

  /// Whether it has an energy density; where it has none, energy() is 0.
  bool has_energy() const { return law_->has_energy; }

  void stresses(std::span<const Tensor<dimensions>> A, std::span<Tensor<dimensions>> S) const { law_->stresses(A, S); }
  void tangents(std::span<const Tensor<dimensions>> A, std::span<TangentModuli<dimensions>> D) const {
    law_->tangents(A, D);
  }
  /// Σ w W over the points.
  double energy(std::span<const Tensor<dimensions>> A, std::span<const double> weights) const {
    return law_->energy(A, weights);
  }

  Tensor<dimensions> stress(const Tensor<dimensions>& A) const {
    Tensor<dimensions> S;
    law_->stresses({&A, 1}, {&S, 1});
    return S;
  }
  TangentModuli<dimensions> tangent(const Tensor<dimensions>& A) const {
    TangentModuli<dimensions> D;
    law_->tangents({&A, 1}, {&D, 1});
    return D;
  }
  double energy(const Tensor<dimensions>& A) const {
    static constexpr double one = 1;
    return law_->energy({&A, 1}, {&one, 1});
  }

 private:
  struct Base {
    explicit Base(bool with_energy) : has_energy(with_energy) {}
    virtual ~Base() = default;
    virtual void stresses(std::span<const Tensor<dimensions>> A, std::span<Tensor<dimensions>> S) const = 0;
    virtual void tangents(std::span<const Tensor<dimensions>> A, std::span<TangentModuli<dimensions>> D) const = 0;
    virtual double energy(std::span<const Tensor<dimensions>> A, std::span<const double> weights) const = 0;
    const bool has_energy;
  };
  /// With all that the law calls compiled into one function (flatten): how many of a source's small functions the
  /// compiler takes in otherwise depends on how large that source is, and of one left out the linker takes any copy.
  template <class Law>
  struct Held final : Base {
    explicit Held(Law given) : Base(HasEnergyDensity<Law, dimensions>), law(std::move(given)) {}
    [[gnu::flatten]] void stresses(std::span<const Tensor<dimensions>> A,
                                   std::span<Tensor<dimensions>> S) const override {
      for (std::size_t g = 0; g < A.size(); ++g) S[g] = law.stress(A[g]);
    }
    [[gnu::flatten]] void tangents(std::span<const Tensor<dimensions>> A,
                                   std::span<TangentModuli<dimensions>> D) const override {
      for (std::size_t g = 0; g < A.size(); ++g) D[g] = law.tangent(A[g]);
    }
    [[gnu::flatten]] double energy(std::span<const Tensor<dimensions>> A,
                                   std::span<const double> weights) const override {
      double sum = 0;
      if constexpr (HasEnergyDensity<Law, dimensions>)
        for (std::size_t g = 0; g < A.size(); ++g) sum += weights[g] * law.energy(A[g]);
      return sum;
    }
    Law law;
  };
  std::shared_ptr<const Base> law_;
};

/// The law at work at a point of a material.
template <int dimensions>
using AnyAtWork = std::function<AnyPoint<dimensions>(const Material&)>;

/// A law of solids whose type is forgotten, as the cell driver runs it.
struct AnySolid {
  static constexpr std::string_view name = "solid", summary = "any solid law", source = "";

  AnyAtWork<3> make;

  AnyPoint<3> solid(const Material& material) const { return make(material); }
};

/// A law of membranes whose type is forgotten.
struct AnyMembrane {
  static constexpr std::string_view name = "membrane", summary = "any membrane law", source = "";

  AnyAtWork<2> make;

  AnyPoint<2> membrane(const Material& material) const { return make(material); }
};

}  // namespace elastin
