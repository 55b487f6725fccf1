#pragma once
#include <functional>
#include <memory>
#include <utility>

#include "elastin/core/laws/law.h"

namespace elastin {

/// Any law at work at one point, its type forgotten: a driver is compiled once for all of them. Copies share the law.
template <int dimensions>
class AnyPoint {
 public:
  /// That it is another type is asked first: whether AnyPoint is a law asks for its constructors again.
  template <class Law>
  requires(!std::same_as<Law, AnyPoint>) &&
      PointLaw<Law, dimensions>&& HasEnergyDensity<Law, dimensions> explicit AnyPoint(Law law)
      : law_(std::make_shared<const Held<Law>>(std::move(law))) {}

  Tensor<dimensions> stress(const Tensor<dimensions>& A) const { return law_->stress(A); }
  TangentModuli<dimensions> tangent(const Tensor<dimensions>& A) const { return law_->tangent(A); }
  double energy(const Tensor<dimensions>& A) const { return law_->energy(A); }

 private:
  struct Base {
    virtual ~Base() = default;
    virtual Tensor<dimensions> stress(const Tensor<dimensions>& A) const = 0;
    virtual TangentModuli<dimensions> tangent(const Tensor<dimensions>& A) const = 0;
    virtual double energy(const Tensor<dimensions>& A) const = 0;
  };
  template <class Law>
  struct Held final : Base {
    explicit Held(Law given) : law(std::move(given)) {}
    Tensor<dimensions> stress(const Tensor<dimensions>& A) const override { return law.stress(A); }
    TangentModuli<dimensions> tangent(const Tensor<dimensions>& A) const override { return law.tangent(A); }
    double energy(const Tensor<dimensions>& A) const override { return law.energy(A); }
    Law law;
  };
  std::shared_ptr<const Base> law_;
};

/// A law of solids whose type is forgotten, as the cell driver runs it.
struct AnySolid {
  static constexpr std::string_view name = "solid", summary = "any solid law", source = "";

  std::function<AnyPoint<3>(const Material&)> make;

  AnyPoint<3> solid(const Material& material) const { return make(material); }
};

/// A law of membranes whose type is forgotten.
struct AnyMembrane {
  static constexpr std::string_view name = "membrane", summary = "any membrane law", source = "";

  std::function<AnyPoint<2>(const Material&)> make;

  AnyPoint<2> membrane(const Material& material) const { return make(material); }
};

}  // namespace elastin
