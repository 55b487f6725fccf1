#pragma once
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "elastin/core/forces/elasticity.h"
#include "elastin/core/laws/law.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// What the cell driver needs of a body's graph, kept apart from the law so that it is compiled once.
struct CellGraph {
  template <int corners>
  using Sides = std::vector<std::array<int, static_cast<std::size_t>(connections_of_cell(corners))>>;

  CellGraph(const Body& body, int corners);
  CellGraph(const Connections& connections, const Cells<4>& tetrahedra);
  /// Adds each connection's slots in ascending cell order: one owner a connection, the same bits on any thread count.
  void gather(Eigen::Ref<const VectorX> slots, VectorX& force_densities) const;
  int cells() const { return static_cast<int>(slot_connection.size()) / sides; }

  int sides;                         ///< connections of one cell
  std::vector<int> slot_connection;  ///< connection of slot cell · sides + side
  std::vector<int> start, slots_of;  ///< slots of each connection, ascending

 private:
  void set_slots(int connections);
  int connections_ = 0;
};

namespace detail {
/// Whether a pass over so many cells stays on one thread.
bool on_one_thread(int cells);
void run_cells(int count, void* context, void (*range)(void*, int begin, int end));
/// Calls range(begin, end) over disjoint ranges that cover 0 … count−1.
template <class Range>
void for_each_cell(int count, Range&& range) {
  run_cells(count, &range, [](void* context, int begin, int end) {
    (*static_cast<std::remove_reference_t<Range>*>(context))(begin, end);
  });
}
double sum_over_cells(int count, const std::function<double(int)>& term);
}  // namespace detail

/// The one driver of every cell law: cells write their own slots, connections gather them.
template <CellLaw Law>
class CellElasticity final : public Elasticity {
  static constexpr int corners = Law::corners, sides = connections_of_cell(corners);
  using SquaredLengths = Eigen::Matrix<double, sides, 1>;
  using Slope = Eigen::Matrix<double, sides, sides, Eigen::RowMajor>;

 public:
  CellElasticity(const Body& body, const Material& material, Law law)
      : body_(body), law_(std::move(law)), graph_(body, corners) {
    constants_.reserve(cells().size());
    for (const auto& cell : cells()) {
      Eigen::Matrix<double, 3, corners> rest;
      for (int corner = 0; corner < corners; ++corner) rest.col(corner) = body.rest.col(cell[corner]);
      Material own = material;
      if (body.cell_stiffness.size())
        own.youngs_modulus *= body.cell_stiffness[static_cast<Eigen::Index>(constants_.size())];
      constants_.push_back(law_.constants(rest, own));
    }
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<CellElasticity>(*this); }
  bool has_energy() const override { return HasEnergy<Law>; }

  /// Lengths cannot tell a cell from its mirror image; volumes can.
  bool admissible(const Positions& positions) const override {
    if constexpr (corners == 4)
      return detail::sum_over_cells(graph_.cells(), [&](int cell) {
               return signed_volume(positions, body_.tetrahedra[cell]) > 0 ? 0. : 1.;
             }) == 0;
    else
      return true;
  }

  double energy(const Positions& positions) const override {
    if constexpr (HasEnergy<Law>)
      return detail::sum_over_cells(graph_.cells(), [&](int cell) {
        if constexpr (corners == 4)
          if (!(signed_volume(positions, body_.tetrahedra[cell]) > 0)) return std::numeric_limits<double>::infinity();
        return law_.energy(constants_[cell], squared_lengths(positions, cell));
      });
    else
      return 0;
  }

  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    if (detail::on_one_thread(graph_.cells())) {  // the same order of additions without the slots
      for (int cell = 0; cell < graph_.cells(); ++cell) {
        const SquaredLengths q = law_.force_densities(constants_[cell], squared_lengths(positions, cell));
        for (int side = 0; side < sides; ++side)
          force_densities[graph_.slot_connection[cell * sides + side]] += q[side];
      }
      return;
    }
    auto slots = workspace.buffer(Workspace::slots, graph_.cells() * sides);
    detail::for_each_cell(graph_.cells(), [&](int begin, int end) {
      for (int cell = begin; cell < end; ++cell)
        slots.template segment<sides>(cell * sides) =
            law_.force_densities(constants_[cell], squared_lengths(positions, cell));
    });
    graph_.gather(slots, force_densities);
  }

  bool add_triangle_force_densities(const Positions& positions, Eigen::Matrix3Xd& force_densities) const override {
    if constexpr (corners == 3)
      for (int cell = 0; cell < graph_.cells(); ++cell)
        force_densities.col(cell) += law_.force_densities(constants_[cell], squared_lengths(positions, cell));
    return corners == 3;
  }

  void linearise(const Positions& positions) override {
    slopes_.resize(constants_.size());
    detail::for_each_cell(graph_.cells(), [&](int begin, int end) {
      for (int cell = begin; cell < end; ++cell)
        slopes_[cell] = law_.slope(constants_[cell], squared_lengths(positions, cell));
    });
  }

  void add_own_slopes(VectorX&) const override {}
  bool coupled() const override { return true; }

  void add_change(const VectorX& change_of_squared_lengths, VectorX& change_of_force_densities,
                  Workspace& workspace) const override {
    const auto change = [&](int cell) {
      SquaredLengths all;
      for (int side = 0; side < sides; ++side)
        all[side] = change_of_squared_lengths[graph_.slot_connection[cell * sides + side]];
      return SquaredLengths(slopes_[cell] * all);
    };
    if (detail::on_one_thread(graph_.cells())) {
      for (int cell = 0; cell < graph_.cells(); ++cell)
        add_to_connections(cell, change(cell), change_of_force_densities);
      return;
    }
    auto slots = workspace.buffer(Workspace::slots, graph_.cells() * sides);
    detail::for_each_cell(graph_.cells(), [&](int begin, int end) {
      for (int cell = begin; cell < end; ++cell) slots.template segment<sides>(cell * sides) = change(cell);
    });
    graph_.gather(slots, change_of_force_densities);
  }

  void visit_cells(const CellVisitor& visit) const override {
    for (int cell = 0; cell < graph_.cells(); ++cell)
      visit({graph_.slot_connection.data() + cell * sides, static_cast<std::size_t>(sides)}, slopes_[cell].data());
  }

 private:
  const auto& cells() const {
    if constexpr (corners == 3)
      return body_.triangles;
    else
      return body_.tetrahedra;
  }

  void add_to_connections(int cell, const SquaredLengths& share, VectorX& force_densities) const {
    for (int side = 0; side < sides; ++side)
      force_densities[graph_.slot_connection[cell * sides + side]] += share[side];
  }

  SquaredLengths squared_lengths(const Positions& positions, int cell) const {
    SquaredLengths s;
    int side = 0;
    for (int i = 0; i < corners; ++i)
      for (int j = i + 1; j < corners; ++j)
        s[side++] = (positions.col(cells()[cell][j]) - positions.col(cells()[cell][i])).squaredNorm();
    return s;
  }

  const Body& body_;
  Law law_;
  CellGraph graph_;
  std::vector<typename Law::Constants> constants_;
  std::vector<Slope> slopes_;
};

}  // namespace elastin
