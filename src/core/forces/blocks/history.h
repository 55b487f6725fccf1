#pragma once
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/forces/blocks/points.h"
#include "core/forces/blocks/sums.h"
#include "core/forces/relaxing.h"
#include "elastin/core/forces/mullins.h"

namespace elastin::blocks {

/// A law at the points of a block's cells with their history: stresses that relax, energies that soften, and both
/// transposed. Knows no shape and no solver.
template <int d>
class PointHistory : public LawHistory, public TransposedHistory, public Softens {
 public:
  explicit PointHistory(ElasticPoints<d> elastic) : elastic_(std::move(elastic)) {}
  void set_rest(double part) { elastic_.set_rest(part); }
  const ElasticPoints<d>& elastic() const { return elastic_; }
  const CellsAtRest<d>& rest() const { return elastic_.rest(); }
  const CellVolumes<d>& volumes() const { return elastic_.volumes(); }

  bool soften(const Softening& softening) override {
    if (elastic_.has_energy()) softened_ = SoftenedElements(softening, rest().size() * points());
    return elastic_.has_energy();
  }
  bool softened() const override { return static_cast<bool>(softened_); }
  void relax(const Relaxation& relaxation) {
    relaxing_ = Relaxing(relaxation, static_cast<Eigen::Index>(rest().size()) * points() * kComponents);
  }
  bool relaxes() const { return static_cast<bool>(relaxing_); }
  /// Energy [J] stored where it relaxes, of the sum of elastic_cell_energy() over all cells.
  double stored_energy(double elastic) const { return relaxing_.stored_energy(elastic); }

  /// W [J] of a cell; +infinity where it is inverted.
  double cell_energy(const Positions& positions, int cell) const {
    Strains<d> now;
    double sum = elastic_cell_energy(positions, cell, now);
    if (!relaxing_ || std::isinf(sum)) return sum;
    sum *= relaxing_.factor();
    for (int g = 0; g < points(); ++g)
      sum += rest().weight(cell, g) / 2 * left_stress(cell, g).cwiseProduct(now.A[g]).sum();
    return sum;
  }
  /// The same without relaxation.
  double elastic_cell_energy(const Positions& positions, int cell) const {
    Strains<d> now;
    return elastic_cell_energy(positions, cell, now);
  }
  void set_stresses(const Positions& positions, int cell, Stresses<d>& now) const {
    set_strains(rest(), positions, cell, now);
    set_stresses(cell, now);
  }
  /// The same of the strains.
  void set_stresses(int cell, Stresses<d>& now) const {
    set_elastic_stresses(cell, now);
    if (!relaxing_) return;
    for (int g = 0; g < points(); ++g) {
      now.S[g] = relaxing_.factor() * now.S[g] + left_stress(cell, g);
      if (volumes()) now.p[g] *= relaxing_.factor();
    }
  }
  /// ∂S/∂C, and S, with the pressures' part. Where it softens, D = η ∂S/∂C + ½ η′ S S, S that of the law.
  void set_moduli(int cell, Stresses<d>& now, AtPoints<TangentModuli<d>>& D) const {
    elastic_.set_tangents(cell, now, D);
    if (softened_) {
      AtPoints<Tensor<d>> S;
      elastic_.set_stresses(cell, now, S);
      for (int g = 0; g < points(); ++g) {
        const SoftenedEnergy softened = softened_at(cell, g, now);
        const Components<d> own = components_of<d>(S[g]);
        D[g] = softened.factor * D[g] + softened.slope / 2 * own * own.transpose();
      }
    }
    if (relaxing_)
      for (int g = 0; g < points(); ++g) D[g] *= relaxing_.factor();
    elastic_.add_pressures(now, D);
  }
  /// Q in δp = Q ∫ φ δJ, or a part of it.
  PressureMatrix stiffness_of_pressures(int cell, const Strains<d>& now, double part = 1) const {
    return volumes().stiffness(rest(), cell, now, part * (relaxing_ ? relaxing_.factor() : 1));
  }

  std::vector<HistoryBlock> history(const std::string& name) const override {
    std::vector<HistoryBlock> all = softened_.history(name + ".most");
    if (relaxing_) all.push_back(relaxing_.history(name).front());
    return all;
  }
  void begin_step(const std::string& name, const State& from, double time) override {
    if (softened_) softened_.begin_step(name + ".most", from);
    if (relaxing_) relaxing_.begin_step(name, from, time);
  }
  void commit_step(const std::string& name, State& state) override {
    if (relaxing_) {
      set_relaxing_stresses(state.positions);
      relaxing_.commit_step(name, state);
    }
    if (softened_)
      softened_.commit_step(name + ".most", state, [&, cell_of = -1, now = Strains<d>()](int element) mutable {
        if (const int cell = element / points(); cell != cell_of)
          set_strains(rest(), state.positions, cell_of = cell, now);
        return elastic_.density(cell_of, element % points(), now);
      });
  }
  void transpose_commit(const HistoryBlock& from, double time, const Positions& positions, std::vector<double>& slopes,
                        Positions& of_positions) const override {
    VectorX of_stresses;
    if (relaxing_) of_stresses = relaxing_.transpose_commit(time - from.values[0], slopes);
    for (int cell = 0; cell < rest().size(); ++cell) {
      PointGradients<d> P;
      if (relaxing_)
        transpose_relaxing_stresses(positions, cell, of_stresses, P);
      else
        visit_unsoftened(positions, cell, [&](int g, double energy, const Gradient<d>& of_energy) {
          P[g] = softened_.transpose_commit(from, cell * points() + g, energy, slopes) * of_energy;
        });
      NodeVectors own = NodeVectors::Zero(3, rest().nodes());
      rest().spread(cell, P, own);
      for (int a = 0; a < rest().nodes(); ++a) of_positions.col(rest().block().cell(cell)[a]) += own.col(a);
    }
  }
  void transpose_forces(const HistoryBlock& from, double time, const Positions& positions, const Positions& lambda,
                        std::vector<double>& slopes) const override {
    VectorX of_left = VectorX::Zero(relaxing_.fixed().size());
    for (int cell = 0; cell < rest().size(); ++cell) {
      PointGradients<d> motion;
      rest().set_gradients(cell, rest().gathered(lambda, cell), motion);
      if (relaxing_) {
        Strains<d> now;
        set_strains(rest(), positions, cell, now);
        for (int g = 0; g < points(); ++g) {
          const Tensor<d> change = now.F[g].transpose() * motion[g];
          of_stress(of_left, cell, g) =
              -rest().weight(cell, g) / 2 * doubled_components<d>(change + change.transpose());
        }
      } else {
        visit_unsoftened(positions, cell, [&](int g, double energy, const Gradient<d>& of_energy) {
          softened_.transpose_forces(from, cell * points() + g, energy,
                                     -rest().weight(cell, g) * of_energy.cwiseProduct(motion[g]).sum(), slopes);
        });
      }
    }
    if (relaxing_) relaxing_.transpose_fixed(time - from.values[0], of_left, slopes);
  }

  /// The size of what the past has left of the stress at a point, where it relaxes.
  double left_size(int cell, int g) const { return relaxing_ ? left_stress(cell, g).norm() : 0; }

 private:
  static constexpr int kComponents = d * (d + 1) / 2;

  int points() const { return rest().points(); }
  template <class Numbers>
  auto of_stress(Numbers& all, int cell, int g) const {
    return all.template segment<kComponents>(static_cast<std::ptrdiff_t>(cell * points() + g) * kComponents);
  }
  /// What the past has left of the stress at a point.
  Tensor<d> left_stress(int cell, int g) const { return tensor_of<d>(of_stress(relaxing_.fixed(), cell, g)); }
  SoftenedEnergy softened_at(int cell, int g, const Strains<d>& now) const {
    return softened_.at(cell * points() + g, elastic_.density(cell, g, now));
  }
  double elastic_cell_energy(const Positions& positions, int cell, Strains<d>& now) const {
    set_strains(rest(), positions, cell, now);
    if (d == 3 && now.inverted) return std::numeric_limits<double>::infinity();
    double sum = 0;
    if (softened_)
      for (int g = 0; g < points(); ++g) sum += rest().weight(cell, g) * softened_at(cell, g, now).energy;
    else
      sum = elastic_.energy(cell, now);
    if (volumes()) volumes().add_energy(rest(), cell, now, sum);
    return sum;
  }
  /// Of the strains, without relaxation.
  void set_elastic_stresses(int cell, Stresses<d>& now) const {
    elastic_.set_stresses(cell, now, now.S);
    if (softened_)
      for (int g = 0; g < points(); ++g) now.S[g] *= softened_at(cell, g, now).factor;
    if (volumes()) volumes().set_pressures(rest(), cell, now, now.p);
  }
  /// S of all points, with the cells' pressures, without relaxation, and their strains.
  void set_relaxing_stresses(const Positions& positions) {
    parallel_for(
        rest().size(),
        [&](int cell) {
          Stresses<d> now;
          set_strains(rest(), positions, cell, now);
          set_elastic_stresses(cell, now);
          for (int g = 0; g < points(); ++g) {
            if (volumes()) add_pressure<d>(now.p[g], now.A[g], now.S[g]);
            of_stress(relaxing_.now(), cell, g) = components_of<d>(now.S[g]);
            of_stress(relaxing_.strain(), cell, g) = rest().weight(cell, g) * doubled_components<d>(now.A[g]);  // 2E
          }
        },
        kCellThreshold);
  }
  /// P = ∂(w·S)/∂F at each point of a cell, of the stresses of set_relaxing_stresses and numbers w by which m has them.
  void transpose_relaxing_stresses(const Positions& positions, int cell, const VectorX& weights,
                                   PointGradients<d>& P) const {
    Stresses<d> now;
    set_strains(rest(), positions, cell, now);
    set_elastic_stresses(cell, now);
    AtPoints<TangentModuli<d>> D;
    elastic_.set_tangents(cell, now, D);
    elastic_.add_pressures(now, D);
    Pressures of_pressures = Pressures::Zero();
    for (int g = 0; g < points(); ++g) {
      const Components<d> own = of_stress(weights, cell, g);
      if (volumes()) volumes().add_slopes(now.A[g], own, g, of_pressures);
      P[g] = 2 * now.F[g] * tensor_of<d>(D[g].transpose() * own);
    }
    if (volumes()) {
      const Pressures of_swelling = stiffness_of_pressures(cell, now, 1 / relaxing_.factor()) * of_pressures;
      volumes().add_stresses(
          rest(), cell, of_swelling, [&](int g) -> const auto& { return now.F[g]; }, P);
    }
  }
  /// Calls visit(g, W, ∂W/∂F) of the laws at each point of a cell.
  template <class Visit>
  void visit_unsoftened(const Positions& positions, int cell, Visit visit) const {
    Stresses<d> now;
    set_strains(rest(), positions, cell, now);
    elastic_.set_stresses(cell, now, now.S);
    for (int g = 0; g < points(); ++g) visit(g, elastic_.density(cell, g, now), now.F[g] * now.S[g]);
  }

  ElasticPoints<d> elastic_;
  SoftenedElements softened_;  ///< a point each
  Relaxing relaxing_;          ///< the stress at each point
};

}  // namespace elastin::blocks
