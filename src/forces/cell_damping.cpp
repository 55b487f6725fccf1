#include <memory>
#include <vector>

#include "elastin/forces/loads.h"
#include "stiffness/st_venant_kirchhoff.h"

namespace elastin {
namespace {

class CellDamping final : public Load {
  using Sides = Eigen::Matrix<double, 3, 6>;
  static constexpr auto pairs = corner_pairs<4>();

 public:
  CellDamping(const Body& body, double bulk, double shear) : cells_(body.tetrahedra) {
    resistance_.reserve(cells_.size());
    for (const auto& cell : cells_) {
      Eigen::Matrix<double, 3, 4> rest;
      for (int corner = 0; corner < 4; ++corner) rest.col(corner) = body.rest.col(cell[corner]);
      const Simplex<4> simplex(rest);
      resistance_.push_back(StVenantKirchhoff::stiffness(simplex, simplex.measure, bulk, shear));
    }
  }

  void add_forces(const State& state, Positions& forces) const override {
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const Sides d = sides(state.positions, cells_[cell]), v = sides(state.velocities, cells_[cell]);
      const CellVector<4> q = resistance_[cell] * rates(d, v);
      add_flows(cells_[cell], d * q.asDiagonal(), forces);
    }
  }

  void add_change(const State& state, const Positions& dx, const Positions& dv, Positions& forces) const override {
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const Sides d = sides(state.positions, cells_[cell]), v = sides(state.velocities, cells_[cell]);
      const Sides delta_d = sides(dx, cells_[cell]), delta_v = sides(dv, cells_[cell]);
      const CellVector<4> q = resistance_[cell] * rates(d, v);
      const CellVector<4> delta_q = resistance_[cell] * (rates(delta_d, v) + rates(d, delta_v));
      add_flows(cells_[cell], d * delta_q.asDiagonal() + delta_d * q.asDiagonal(), forces);
    }
  }
  bool acts_at_rest() const override { return false; }

 private:
  static Sides sides(const Positions& vectors, const std::array<int, 4>& cell) {
    Sides d;
    for (int c = 0; c < 6; ++c) d.col(c) = vectors.col(cell[pairs[c][1]]) - vectors.col(cell[pairs[c][0]]);
    return d;
  }
  /// ṡ = 2 d·v
  static CellVector<4> rates(const Sides& d, const Sides& v) {
    return 2 * d.cwiseProduct(v).colwise().sum().transpose();
  }
  static void add_flows(const std::array<int, 4>& cell, const Sides& flows, Positions& forces) {
    for (int c = 0; c < 6; ++c) {
      forces.col(cell[pairs[c][0]]) += flows.col(c);
      forces.col(cell[pairs[c][1]]) -= flows.col(c);
    }
  }

  const Cells<4>& cells_;
  std::vector<CellMatrix<4>> resistance_;  ///< K(φ, ψ) [N s/m³]
};

}  // namespace

std::unique_ptr<Load> make_cell_damping(const Body& body, double bulk, double shear) {
  return std::make_unique<CellDamping>(body, bulk, shear);
}

}  // namespace elastin
