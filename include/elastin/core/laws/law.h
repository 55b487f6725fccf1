#pragma once
#include <Eigen/Core>
#include <concepts>
#include <string>
#include <string_view>

#include "elastin/core/laws/parameters.h"
#include "elastin/core/laws/volumetric.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"
#include "elastin/core/shapes/cell_shape.h"

namespace elastin {

/// Every stiffness strategy says its name, one line for `elastin list` and its source.
/// It may add `static constexpr std::array parameters` (of Parameter<Law>),
/// `static std::string unsuited(const Body&)`: why it cannot run on a body, or "",
/// `static bool needs_voronoi(const Body&)`: whether it works on Body::voronoi, and, if a spring rule,
/// `static constexpr bool on_cells = true`: its constants come from cells. Other rules are not shown the connections
/// that are sides of cells only (Connections::cell_sides), neither here nor in unsuited(): those get 0. A cell law that
/// takes the material's stress-strain curve has `static constexpr bool follows_curve = true`. Further properties of
/// this kind are needs_faces, takes_scale and joins_molecules, as in Strategy.
template <class Law>
concept StiffnessLaw = requires {
  { Law::name } -> std::convertible_to<std::string_view>;
  { Law::summary } -> std::convertible_to<std::string_view>;
  { Law::source } -> std::convertible_to<std::string_view>;
};

/// A constant k [N/m] for each connection, set once from the body at rest and the material.
template <class Law>
concept SpringRule = StiffnessLaw<Law> && requires(const Law& law, const Body& body, const Material& material) {
  { law.constants(body, material) } -> std::convertible_to<VectorX>;
};

/// A constant k [N/m] for each connection, set again from the present places at every evaluation. Has no energy.
template <class Law>
concept UpdatedSpringRule = StiffnessLaw<Law> &&
    requires(const Law& law, const Body& body, const Material& material, const Positions& positions) {
  { law.constants(body, material, positions) } -> std::convertible_to<VectorX>;
};

/// A symmetric tensor of the rest frame: 3×3 in a solid, 2×2 in the plane of a membrane.
template <int dimensions>
using Tensor = Eigen::Matrix<double, dimensions, dimensions>;
/// ∂S/∂C of symmetric tensors, row S_ij, column C_kl, order 11 22 33 12 13 23, or 11 22 12 in a plane.
template <int dimensions>
using TangentModuli = Eigen::Matrix<double, dimensions*(dimensions + 1) / 2, dimensions*(dimensions + 1) / 2>;

/// A law at work at one point of a body: a small value that sees the right Cauchy–Green tensor C, as A = C − I so that
/// near rest nothing cancels, and knows no cell. Second Piola–Kirchhoff stress S [Pa], of a membrane times its
/// thickness [N/m]; tangent ∂S/∂C. One with an energy density W [J/m³], [J/m²] has S = 2 ∂W/∂C; W ≥ 0 and W = +∞ where
/// a flat point has no finite one. Stress and tangent stay finite for any A.
template <class Point, int dimensions>
concept PointLaw = std::copy_constructible<Point> && requires(const Point& law, const Tensor<dimensions>& A) {
  { law.stress(A) } -> std::convertible_to<Tensor<dimensions>>;
  { law.tangent(A) } -> std::convertible_to<TangentModuli<dimensions>>;
};
template <class Point, int dimensions>
concept HasEnergyDensity = requires(const Point& law, const Tensor<dimensions>& A) {
  { law.energy(A) } -> std::convertible_to<double>;
};

/// A law of solids: solid(material) is it at work, in cells of any shape of three dimensions.
template <class Law>
concept SolidLaw = StiffnessLaw<Law> && requires(const Law& law, const Material& material) {
  { law.solid(material) } -> PointLaw<3>;
};
/// A law of solids that can be split, W = W_shape(C) + U(J): split(material) is {shape, volume}, as SplitPoint, and
/// together they are solid(material).
template <class Law>
concept SplitLaw = SolidLaw<Law> && requires(const Law& law, const Material& material) {
  requires PointLaw<decltype(law.split(material).shape), 3>;
  { law.split(material).volume } -> std::convertible_to<Volumetric>;
};
/// A law of membranes: membrane(material) is it at work in plane stress, in cells of any shape of two dimensions. In
/// the catalog it is NAME_membrane, with `membrane_summary` and `membrane_source` if the law has them. If it is an
/// IsotropicMembrane its compression can be dropped.
template <class Law>
concept MembraneLaw = StiffnessLaw<Law> && requires(const Law& law, const Material& material) {
  { law.membrane(material) } -> PointLaw<2>;
};

/// A membrane law as one that bears no compression: it wrinkles instead.
template <class Law>
struct WithoutCompression {
  static constexpr std::string_view name = Law::name, summary = Law::summary;
  static constexpr std::string_view source = "[Pipkin 1986] on that law";

  Law law = {};
  auto membrane(const Material& material) const { return law.membrane(material).without_compression(material); }
};

/// What the cell driver runs on each cell of one shape: force densities q [N/m] of the pairs of its nodes from their
/// squared lengths s [m²]; ∂q/∂s is their slope. Made of a law that sees C by CellKernel; a law may also be one itself
/// if it is defined by the lengths of one shape. With an energy W [J] it has q = 2 ∂W/∂s.
template <class Kernel>
concept LengthKernel = CellShape<typename Kernel::Shape> &&
    requires(const Kernel& kernel, const typename Kernel::Constants& constants,
             const NodePositions<Kernel::Shape::nodes>& rest, const Material& material,
             const CellVector<Kernel::Shape::nodes>& s) {
  { kernel.constants(rest, material) } -> std::same_as<typename Kernel::Constants>;
  { kernel.force_densities(constants, s) } -> std::convertible_to<CellVector<Kernel::Shape::nodes>>;
  { kernel.slope(constants, s) } -> std::convertible_to<CellMatrix<Kernel::Shape::nodes>>;
};
template <class Kernel>
concept HasEnergy = requires(const Kernel& kernel, const typename Kernel::Constants& k,
                             const CellVector<Kernel::Shape::nodes>& s) {
  { kernel.energy(k, s) } -> std::convertible_to<double>;
};

template <class Law>
concept LengthLaw = StiffnessLaw<Law> && LengthKernel<Law>;
template <class Law>
concept CellLaw = SolidLaw<Law> || MembraneLaw<Law> || LengthLaw<Law>;

}  // namespace elastin
