#pragma once
#include <Eigen/Core>
#include <concepts>
#include <string>
#include <string_view>

#include "elastin/core/laws/parameters.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// Every stiffness strategy says its name, one line for `elastin list` and its source.
/// It may add `static constexpr std::array parameters` (of Parameter<Law>),
/// `static std::string unsuited(const Body&)`: why it cannot run on a body, or "",
/// `static bool needs_voronoi(const Body&)`: whether it works on Body::voronoi, and, if a spring rule,
/// `static constexpr bool on_cells = true`: its constants come from cells. Other rules are not shown the connections
/// that are sides of cells only (Connections::cell_sides), neither here nor in unsuited(): those get 0. A cell law that
/// takes the material's stress-strain curve has `static constexpr bool follows_curve = true`.
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

/// Connections of a triangle (order 01 02 12) or a tetrahedron (order 01 02 03 12 13 23).
constexpr int connections_of_cell(int corners) { return corners * (corners - 1) / 2; }

/// Force densities q [N/m] of a cell's connections from their squared lengths s [m²]; ∂q/∂s is their slope. A law with
/// an energy W has q = 2 ∂W/∂s.
template <class Law>
concept CellLaw = StiffnessLaw<Law> &&
    requires(const Law& law, const typename Law::Constants& constants,
             const Eigen::Matrix<double, 3, Law::corners>& rest, const Material& material,
             const Eigen::Matrix<double, connections_of_cell(Law::corners), 1>& s) {
  requires Law::corners == 3 || Law::corners == 4;
  { law.constants(rest, material) } -> std::same_as<typename Law::Constants>;
  {
    law.force_densities(constants, s)
    } -> std::convertible_to<Eigen::Matrix<double, connections_of_cell(Law::corners), 1>>;
  {
    law.slope(constants, s)
    }
    -> std::convertible_to<Eigen::Matrix<double, connections_of_cell(Law::corners), connections_of_cell(Law::corners)>>;
};

template <class Law>
concept HasEnergy = requires(const Law& law, const typename Law::Constants& k,
                             const Eigen::Matrix<double, connections_of_cell(Law::corners), 1>& s) {
  { law.energy(k, s) } -> std::convertible_to<double>;
};

}  // namespace elastin
