#include "elastin/core/forces/block_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/dense.h"
#include "core/base/rows.h"
#include "core/forces/cell_pressures.h"
#include "core/forces/element_forces.h"
#include "core/forces/relaxing.h"
#include "core/geometry/reference_slopes.h"
#include "core/model/block_geometry.h"
#include "core/model/incidence.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/laws/local.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

constexpr int kMostPressures = 4;
/// A symmetric tensor's independent components, order 11 22 33 12 13 23, or 11 22 12.
template <int d>
using Components = Eigen::Matrix<double, d*(d + 1) / 2, 1>;

template <int d>
constexpr auto components() {
  if constexpr (d == 3)
    return std::array<std::array<int, 2>, 6>{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  else
    return std::array<std::array<int, 2>, 3>{{{0, 0}, {1, 1}, {0, 1}}};
}

/// The cofactors of F: ∂ det F/∂F.
Matrix3 cofactors(const Matrix3& F) {
  Matrix3 result;
  result << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return result;
}

/// det(I + H) − 1, without cancellation near H = 0.
double swelling_of(const Matrix3& H) {
  const double trace = H.trace(), minors = (trace * trace - (H * H).trace()) / 2;
  return trace + minors + H.determinant();
}

template <int d>
class BlockStiffness;

template <int d>
class BlockCells final : public NodalForces,
                         public LocalElasticity,
                         public ElementForces,
                         public LawHistory,
                         public TransposedHistory,
                         public Softens {
  using Gradient = Eigen::Matrix<double, 3, d>;  ///< F, δF, F S
  using Square = Eigen::Matrix<double, d, d>;
  using Direction = Eigen::Matrix<double, d, 1>;
  using Moduli = TangentModuli<d>;
  /// The change of C's components, those off the diagonal twice, for δF = e_i ⊗ B, a column for each i.
  using Changes = Eigen::Matrix<double, d*(d + 1) / 2, 3>;

 public:
  BlockCells(const Body& body, const CellBlock& block, std::shared_ptr<const PointLaws<d>> laws,
             std::vector<Volumetric> volume)
      : body_(body),
        block_(block),
        kind_(*block.kind),
        points_(static_cast<int>(kind_.slopes.size())),
        slopes_(kind_),
        laws_(std::move(laws)),
        volume_(std::move(volume)),
        slots_(rows_by_target(body.size(), block.nodes)),
        cells_of_(body.size()) {
    for (int molecule = 0; molecule < body.size(); ++molecule)
      if (const auto own = slots_[molecule]; !own.empty())
        cells_of_[molecule] = {own.front() / kind_.nodes, own.back() / kind_.nodes};
    set_rest(1);
  }
  void set_rest(double part) override {
    if (!rest_.empty() && !body_.unstressed) return;
    rest_.clear(), offsets_.clear(), frames_.clear(), inverse_mass_.clear(), shape_.clear(), first_of_shape_.clear();
    for (int cell = 0; cell < block_.size(); ++cell) set_rest(cell, part);
    if (!volume_.empty()) set_pressure_functions();
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<BlockCells>(*this); }
  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    if (dissipates() || body_.unstressed || &body_ != own.whole || own.body->blocks.size() != body_.blocks.size())
      return nullptr;
    const auto place = static_cast<std::size_t>(&block_ - body_.blocks.data());
    auto result = std::make_unique<BlockCells>(*own.body, own.body->blocks[place], laws_, volume_);
    for (int cell = 0; cell < block_.size(); ++cell)
      if (own.owns(lowest_in_whole(body_, block_.cell(cell)))) result->numbers_.push_back(cell);
    return result;
  }
  bool has_energy() const override { return laws_->has_energy(); }

  const LocalElasticity* local() const override { return has_energy() && !dissipates() ? this : nullptr; }
  int elements() const override { return block_.size(); }
  std::span<const int> molecules_of(int cell) const override { return block_.cell(cell); }
  double element_energy(const Positions& positions, int cell) const override { return energy_of(positions, cell); }
  void add_blocks(const Positions& positions, std::span<const LocalSlot> slots, LocalBlock& block) const override {
    for (const auto& [cell, node] : slots) add_block(positions, cell, node, block);
  }
  /// J at a point is linear in the position of one node.
  double relative_change(const Positions& positions, std::span<const LocalSlot> slots,
                         const Vector3& motion) const override {
    double most = 0;
    for (const auto& [cell, node] : slots) {
      Strains now;
      set_strains(positions, cell, now);
      for (int g = 0; g < points_; ++g) {
        const Direction B = slope(cell, g, node);
        most = std::max(most, motion.norm() * B.norm());
        if constexpr (d == 3) {
          const double before = 1 + now.swelling[g], after = before + motion.dot(cofactors(now.F[g]) * B);
          if (!(before > 0) || !(after > 0)) return std::numeric_limits<double>::infinity();
          most = std::max(most, std::abs(after - before) / std::min(before, after));
        }
      }
    }
    return most;
  }

  bool admissible(const Positions& positions) const override {
    if (d == 2) return true;
    return sum_over_cells([&](int cell) { return is_inverted(positions, cell) ? 1. : 0.; }) == 0;
  }

  double energy(const Positions& positions) const override {
    if (!has_energy()) return 0;
    return sum_over_cells([&](int cell) { return energy_of(positions, cell); });
  }

  double stored_energy(const Positions& positions) const override {
    if (!has_energy() || !relaxing_) return energy(positions);
    return relaxing_.stored_energy(sum_over_cells([&](int cell) { return elastic_energy_of(positions, cell); }));
  }

  void add_forces(const Positions& positions, const Graph&, Positions& forces, Workspace& workspace) const override {
    add_cells(forces, workspace, [&](int cell, NodeVectors& own) { add_cell_forces(positions, cell, own); });
  }
  void set_element_forces(const Positions& positions, int cell, Eigen::Ref<Positions> forces) const override {
    NodeVectors own = NodeVectors::Zero(3, kind_.nodes);
    add_cell_forces(positions, cell, own);
    forces = own;
  }

  double internal_force(const Positions& positions) const override {
    return sum_over_cells([&](int cell) {
      Stresses now;
      set_stresses(positions, cell, now);
      double sum = 0;
      for (int g = 0; g < points_; ++g) {
        double stress = (now.F[g] * now.S[g]).norm();
        if constexpr (d == 3)
          if (!volume_.empty()) stress += std::abs(now.p[g]);
        sum += rest(cell, g).weight * stress * rest(cell, g).inverse.norm();
      }
      return sum;
    });
  }

  void show(const Positions& positions, VectorX& force_densities, const StateVisitor& visit) const override {
    const std::vector<int> connections = connections_of_some_pairs(body_.connections, block_.nodes, kind_.nodes);
    for (int cell = 0; cell < block_.size(); ++cell) {
      Stresses now;
      set_stresses(positions, cell, now);
      CellState state;
      double rest_size = 0, size = 0;
      for (int g = 0; g < points_; ++g) {
        const double weight = rest(cell, g).weight;
        const Square C = Square::Identity() + now.A[g];
        if constexpr (d == 3)
          if (!volume_.empty()) now.S[g] += now.p[g] * std::max(0., 1 + now.swelling[g]) * C.inverse();
        const Gradient E = frame(cell, g);
        state.strain += weight / 2 * E * now.A[g] * E.transpose();
        state.stress += weight * now.F[g] * now.S[g] * now.F[g].transpose();
        rest_size += weight, size += weight * std::sqrt(std::max(0., C.determinant()));
        std::array<Direction, kMostNodes> B, SB;
        for (int a = 0; a < kind_.nodes; ++a) {
          const auto own = static_cast<std::size_t>(a);
          B[own] = slope(cell, g, a), SB[own] = now.S[g] * B[own];
        }
        std::size_t pair =
            static_cast<std::size_t>(cell) * static_cast<std::size_t>(kind_.nodes * (kind_.nodes - 1) / 2);
        for (int a = 0; a < kind_.nodes; ++a)
          for (int b = a + 1; b < kind_.nodes; ++b, ++pair)
            if (connections[pair] >= 0) force_densities[connections[pair]] -= weight * B[a].dot(SB[b]);
      }
      state.strain /= rest_size;
      if (size > 0) state.stress /= size;
      if (!state.stress.allFinite()) state.stress.setZero();
      visit(block_, cell, state);
    }
  }

  std::unique_ptr<NodalStiffness> stiffness() const override { return std::make_unique<BlockStiffness<d>>(*this); }

  bool soften(const Softening& softening) override {
    if (has_energy()) softened_ = SoftenedElements(softening, block_.size() * points_);
    return has_energy();
  }
  bool relax(const Relaxation& relaxation) override {
    relaxing_ = Relaxing(relaxation, static_cast<Eigen::Index>(block_.size()) * points_ * kComponents);
    return true;
  }
  bool softened() const override { return static_cast<bool>(softened_); }
  bool dissipates() const override { return softened_ || relaxing_; }
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
      softened_.commit_step(name + ".most", state, [&, cell_of = -1, now = Strains()](int element) mutable {
        if (const int cell = element / points_; cell != cell_of) set_strains(state.positions, cell_of = cell, now);
        return density(cell_of, element % points_, now);
      });
  }
  void transpose_commit(const HistoryBlock& from, double time, const Positions& positions, std::vector<double>& slopes,
                        Positions& of_positions) const override {
    VectorX of_stresses;
    if (relaxing_) of_stresses = relaxing_.transpose_commit(time - from.values[0], slopes);
    for (int cell = 0; cell < block_.size(); ++cell) {
      PointGradients<d> P;
      if (relaxing_)
        transpose_relaxing_stresses(positions, cell, of_stresses, P);
      else
        visit_unsoftened(positions, cell, [&](int g, double energy, const Gradient& of_energy) {
          P[g] = softened_.transpose_commit(from, cell * points_ + g, energy, slopes) * of_energy;
        });
      NodeVectors own = NodeVectors::Zero(3, kind_.nodes);
      spread(cell, P, own);
      for (int a = 0; a < kind_.nodes; ++a) of_positions.col(block_.cell(cell)[a]) += own.col(a);
    }
  }
  void transpose_forces(const HistoryBlock& from, double time, const Positions& positions, const Positions& lambda,
                        std::vector<double>& slopes) const override {
    VectorX of_left = VectorX::Zero(relaxing_.fixed().size());
    for (int cell = 0; cell < block_.size(); ++cell) {
      PointGradients<d> motion;
      set_gradients(cell, gathered(lambda, cell), motion);
      if (relaxing_) {
        Strains now;
        set_strains(positions, cell, now);
        for (int g = 0; g < points_; ++g) {
          const Square change = now.F[g].transpose() * motion[g];
          of_stress(of_left, cell, g) = -rest(cell, g).weight / 2 * doubled_components(change + change.transpose());
        }
      } else {
        visit_unsoftened(positions, cell, [&](int g, double energy, const Gradient& of_energy) {
          softened_.transpose_forces(from, cell * points_ + g, energy,
                                     -rest(cell, g).weight * of_energy.cwiseProduct(motion[g]).sum(), slopes);
        });
      }
    }
    if (relaxing_) relaxing_.transpose_fixed(time - from.values[0], of_left, slopes);
  }

 private:
  friend class BlockStiffness<d>;
  static constexpr int kComponents = d * (d + 1) / 2;
  /// A pass over cells costs enough that few cells are worth another thread.
  static constexpr int kCellThreshold = 200;
  using Pressures = Eigen::Matrix<double, kMostPressures, 1>;
  using PressureMatrix = Eigen::Matrix<double, kMostPressures, kMostPressures>;
  using PressureGradient = Eigen::Matrix<double, 3, kMostPressures>;  ///< ∂(∫ φ_k J)/∂x of one node
  using UpperTriangle = Eigen::Matrix<double, 6, 1>;                  ///< xx xy xz yy yz zz
  using UpperTriangles = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  struct Rest {
    Square inverse;  ///< of ∂X/∂ξ, in the frame of the point
    double weight;   ///< w_g [m³], [m²]
  };
  struct Now {
    Gradient F;
    Square S;  ///< times the weight, pressure included
    Moduli D;
  };
  struct Strains {
    PointGradients<d> F;
    std::array<Square, kMostPoints> A;
    std::array<double, kMostPoints> swelling;  ///< det F − 1, of solids
    bool inverted = false;
  };
  struct Stresses : Strains {
    std::array<Square, kMostPoints> S;  ///< without the cell's own pressures
    std::array<double, kMostPoints> p;  ///< these, where it has them
  };

  template <class T>
  std::span<const T> span(const std::array<T, kMostPoints>& all) const {
    return {all.data(), static_cast<std::size_t>(points_)};
  }
  template <class T>
  std::span<T> span(std::array<T, kMostPoints>& all) const {
    return {all.data(), static_cast<std::size_t>(points_)};
  }

  template <class Term>
  double sum_over_cells(Term&& term) const {
    return ordered_sum(block_.size(), std::forward<Term>(term), 0., kCellThreshold);
  }

  double energy_of(const Positions& positions, int cell) const {
    Strains now;
    double sum = elastic_energy_of(positions, cell, now);
    if (!relaxing_ || std::isinf(sum)) return sum;
    sum *= relaxing_.factor();
    for (int g = 0; g < points_; ++g)
      sum += rest(cell, g).weight / 2 * left_stress(cell, g).cwiseProduct(now.A[g]).sum();
    return sum;
  }
  double elastic_energy_of(const Positions& positions, int cell) const {
    Strains now;
    return elastic_energy_of(positions, cell, now);
  }
  /// Without relaxation.
  double elastic_energy_of(const Positions& positions, int cell, Strains& now) const {
    set_strains(positions, cell, now);
    if (d == 3 && now.inverted) return std::numeric_limits<double>::infinity();
    std::array<double, kMostPoints> weights;
    for (int g = 0; g < points_; ++g) weights[g] = rest(cell, g).weight;
    double sum = softened_
                     ? softened_energy_of(cell, now)
                     : laws_->energy(number(cell), span(now.A), {weights.data(), static_cast<std::size_t>(points_)});
    if constexpr (d == 3)
      if (!volume_.empty()) {
        const Pressures theta = projected_swelling(cell, now);
        for (int g = 0; g < points_; ++g) sum += rest(cell, g).weight * volume_of(cell).energy(at_point(theta, g));
      }
    return sum;
  }

  void add_cell_forces(const Positions& positions, int cell, NodeVectors& own) const {
    Stresses now;
    set_stresses(positions, cell, now);
    PointGradients<d> P;
    for (int g = 0; g < points_; ++g) {
      P[g] = now.F[g] * now.S[g];
      if constexpr (d == 3)
        if (!volume_.empty()) P[g] += now.p[g] * cofactors(now.F[g]);
      P[g] *= -rest(cell, g).weight;
    }
    spread(cell, P, own);
  }

  /// What one cell makes of the position of one of its nodes: the diagonal block of visit_diagonal, of one node alone.
  void add_block(const Positions& positions, int cell, int node, LocalBlock& block) const {
    Stresses now;
    set_stresses(positions, cell, now);
    std::array<Moduli, kMostPoints> D;
    laws_->tangents(number(cell), span(now.A), {D.data(), static_cast<std::size_t>(points_)});
    PressureGradient G = PressureGradient::Zero();
    for (int g = 0; g < points_; ++g) {
      const double weight = rest(cell, g).weight;
      const Direction B = slope(cell, g, node);
      if constexpr (d == 3)
        if (!volume_.empty()) {
          const Vector3 of_volume = weight * cofactors(now.F[g]) * B;
          G += of_volume * functions_[g].transpose();
          add_pressure(now.p[g], now.A[g], now.S[g], D[g]);
        }
      const Acting here = acting({now.F[g], weight * now.S[g], weight * D[g]}, B);
      block.gradient += now.F[g] * here.SB;
      add_pair(here, here, block.hessian);
    }
    if constexpr (d == 3)
      if (!volume_.empty()) add_pressures(G, stiffness_of_pressures(cell, now), G, block.hessian);
  }

  const Rest& rest(int cell, int g) const { return rest_[shape_[cell] * points_ + g]; }
  /// Of a cell where laws and volumes have theirs.
  int number(int cell) const { return numbers_.empty() ? cell : numbers_[cell]; }
  const Volumetric& volume_of(int cell) const {
    return volume_[volume_.size() == 1 ? 0 : static_cast<std::size_t>(number(cell))];
  }

  /// The frame of a point at rest, orthonormal: space itself in a solid, else first along ∂X/∂ξ₁, second in the cell.
  Gradient frame(int cell, int g) const {
    if constexpr (d == 3)
      return Matrix3::Identity();
    else
      return frames_[shape_[cell] * points_ + g];
  }

  /// Of a share of a body from the first node, and rounded: whichever cells a process has, a cell is the same there as
  /// on any other, and those of a grid are alike to the last digit.
  NodeVectors nodes_at_rest(int cell) const {
    NodeVectors nodes = gathered(body_.rest, cell);
    if (!body_.share) return nodes;
    nodes.colwise() -= Vector3(nodes.col(0));
    constexpr int digits = 40;  // binary; less than the rounding of positions leaves
    const double unit = std::ldexp(1, std::ilogb(nodes.col(1).norm()) - digits);
    return (nodes / unit).array().round() * unit;
  }
  /// Cells of one shape share what is known of them at rest: those of a grid are like one of the last few new ones.
  bool is_like_another(const NodeVectors& nodes) {
    constexpr std::size_t last = 8;
    const double rounding = body_.share ? 0 : 1e-11 * (nodes.col(1) - nodes.col(0)).norm();
    if (body_.unstressed) return false;
    for (std::size_t shape = first_of_shape_.size(), end = shape - std::min(shape, last); shape-- > end;) {
      const NodeVectors other = nodes_at_rest(first_of_shape_[shape]);
      bool same = true;
      for (int a = 1; a < kind_.nodes && same; ++a)
        same = (nodes.col(a) - nodes.col(0) - other.col(a) + other.col(0)).cwiseAbs().maxCoeff() <= rounding;
      if (!same) continue;
      shape_.push_back(static_cast<int>(shape));
      return true;
    }
    return false;
  }
  void set_rest(int cell, double part) {
    const NodeVectors nodes = nodes_at_rest(cell);
    if (is_like_another(nodes)) return;
    shape_.push_back(static_cast<int>(first_of_shape_.size()));
    first_of_shape_.push_back(cell);
    PointGradients<d> all;
    slopes_.gradients(nodes, all);
    for (int g = 0; g < points_; ++g) {
      Gradient edges = all[g];
      if (body_.unstressed) edges = body_.unstressed->at(place_of(nodes, g), nodes.rowwise().mean(), part) * edges;
      Square in_frame;
      if constexpr (d == 3) {
        in_frame = edges;
      } else {
        const Vector3 first = edges.col(0).normalized(),
                      normal = Vector3(edges.col(0)).cross(Vector3(edges.col(1))).normalized();
        Gradient axes;
        axes << first, normal.cross(first);
        frames_.push_back(axes);
        in_frame = axes.transpose() * edges;
      }
      rest_.push_back({in_frame.inverse(), kind_.weights[g] * std::abs(in_frame.determinant())});
      if (body_.unstressed) offsets_.push_back(all[g] * rest_.back().inverse - frame(cell, g));
    }
  }
  Vector3 place_of(const NodeVectors& nodes, int g) const {
    Vector3 place = Vector3::Zero();
    for (int a = 0; a < kind_.nodes; ++a) place += kind_.values(a, g) * nodes.col(a);
    return place;
  }

  NodeVectors gathered(const Positions& values, int cell) const {
    NodeVectors own(3, kind_.nodes);
    const int* nodes = block_.cell(cell).data();
    for (int a = 0; a < kind_.nodes; ++a) own.col(a) = values.col(nodes[a]);
    return own;
  }

  Direction reference_slope(int g, int a) const { return Eigen::Map<const Direction>(kind_.slopes[g].data() + d * a); }
  /// B_a at a point.
  Direction slope(int cell, int g, int a) const { return rest(cell, g).inverse.transpose() * reference_slope(g, a); }

  /// Σ v_a ⊗ B_a at each point.
  void set_gradients(int cell, const NodeVectors& values, PointGradients<d>& at_points) const {
    slopes_.gradients(values, at_points);
    for (int g = 0; g < points_; ++g) {
      Gradient& own = at_points[g];
      own = (own * rest(cell, g).inverse).eval();
    }
  }
  /// own.col(a) += Σ_g P_g B_a; P becomes what its reference slopes multiply.
  void spread(int cell, PointGradients<d>& P, NodeVectors& own) const {
    for (int g = 0; g < points_; ++g) {
      Gradient& at = P[g];
      at = (at * rest(cell, g).inverse.transpose()).eval();
    }
    slopes_.spread(P, own);
  }

  void set_strains(const Positions& positions, int cell, Strains& now) const {
    NodeVectors displacement(3, kind_.nodes);
    const int* nodes = block_.cell(cell).data();
    for (int a = 0; a < kind_.nodes; ++a) displacement.col(a) = positions.col(nodes[a]) - body_.rest.col(nodes[a]);
    now.inverted = false;
    set_gradients(cell, displacement, now.F);
    for (int g = 0; g < points_; ++g) {
      const Gradient E = frame(cell, g);
      Gradient H = now.F[g];
      if (!offsets_.empty()) H += offsets_[shape_[cell] * points_ + g];
      now.F[g] = E + H;
      const Square linear = E.transpose() * H;
      now.A[g] = linear + linear.transpose() + H.transpose() * H;
      if constexpr (d == 3) {
        now.swelling[g] = swelling_of(H);
        now.inverted |= !(1 + now.swelling[g] > 0);
      }
    }
  }
  /// Of the strains, without relaxation.
  void set_elastic_stresses(int cell, Stresses& now) const {
    laws_->stresses(number(cell), span(now.A), span(now.S));
    if (softened_)
      for (int g = 0; g < points_; ++g) now.S[g] *= softened_at(cell, g, now).factor;
    set_pressures(cell, now, now.p);
  }
  void set_elastic_stresses(const Positions& positions, int cell, Stresses& now) const {
    set_strains(positions, cell, now);
    set_elastic_stresses(cell, now);
  }
  void set_stresses(const Positions& positions, int cell, Stresses& now) const {
    set_strains(positions, cell, now);
    set_stresses(cell, now);
  }
  void set_stresses(int cell, Stresses& now) const {
    set_elastic_stresses(cell, now);
    if (!relaxing_) return;
    for (int g = 0; g < points_; ++g) {
      now.S[g] = relaxing_.factor() * now.S[g] + left_stress(cell, g);
      if (!volume_.empty()) now.p[g] *= relaxing_.factor();
    }
  }

  // --------------------------------------------------------------------------------------------- history at the points

  /// W of the laws at one point [J/m³], [J/m²].
  double density(int cell, int g, const Strains& now) const {
    const double one = 1;
    return laws_->energy(number(cell), {&now.A[g], 1}, {&one, 1});
  }
  SoftenedEnergy softened_at(int cell, int g, const Strains& now) const {
    return softened_.at(cell * points_ + g, density(cell, g, now));
  }
  double softened_energy_of(int cell, const Strains& now) const {
    double sum = 0;
    for (int g = 0; g < points_; ++g) sum += rest(cell, g).weight * softened_at(cell, g, now).energy;
    return sum;
  }
  /// D = η ∂S/∂C + ½ η′ S S, S that of the law.
  void soften_tangents(int cell, const Strains& now, std::array<Moduli, kMostPoints>& D) const {
    std::array<Square, kMostPoints> S;
    laws_->stresses(number(cell), span(now.A), span(S));
    for (int g = 0; g < points_; ++g) {
      const SoftenedEnergy softened = softened_at(cell, g, now);
      const Components<d> own = components_of(S[g]);
      D[g] = softened.factor * D[g] + softened.slope / 2 * own * own.transpose();
    }
  }
  /// Calls visit(g, W, ∂W/∂F) of the laws at each point of a cell.
  template <class Visit>
  void visit_unsoftened(const Positions& positions, int cell, Visit visit) const {
    Stresses now;
    set_strains(positions, cell, now);
    laws_->stresses(number(cell), span(now.A), span(now.S));
    for (int g = 0; g < points_; ++g) visit(g, density(cell, g, now), now.F[g] * now.S[g]);
  }
  /// P = ∂(w·S)/∂F at each point of a cell, of the stresses of set_relaxing_stresses and numbers w by which m has them.
  void transpose_relaxing_stresses(const Positions& positions, int cell, const VectorX& weights,
                                   PointGradients<d>& P) const {
    Stresses now;
    set_elastic_stresses(positions, cell, now);
    std::array<Moduli, kMostPoints> D;
    laws_->tangents(number(cell), span(now.A), {D.data(), static_cast<std::size_t>(points_)});
    Pressures of_pressures = Pressures::Zero();
    for (int g = 0; g < points_; ++g) {
      const Components<d> own = of_stress(weights, cell, g);
      if constexpr (d == 3)
        if (!volume_.empty()) {
          const Dilatation shape(now.A[g]);
          of_pressures += shape.J() * components_of(shape.inverse).dot(own) * functions_[g];
          add_pressure(now.p[g], now.A[g], now.S[g], D[g]);
        }
      P[g] = 2 * now.F[g] * tensor_of(D[g].transpose() * own);
    }
    if constexpr (d == 3)
      if (!volume_.empty()) {
        const Pressures of_swelling = stiffness_of_pressures(cell, now, 1 / relaxing_.factor()) * of_pressures;
        for (int g = 0; g < points_; ++g) P[g] += rest(cell, g).weight * at_point(of_swelling, g) * cofactors(now.F[g]);
      }
  }
  template <class Numbers>
  static auto of_stress_in(Numbers& all, std::ptrdiff_t first) {
    return all.template segment<kComponents>(first * kComponents);
  }
  auto of_stress(VectorX& all, int cell, int g) const { return of_stress_in(all, cell * points_ + g); }
  auto of_stress(const VectorX& all, int cell, int g) const { return of_stress_in(all, cell * points_ + g); }
  /// Those off the diagonal twice: both of their places in a product.
  static Components<d> doubled_components(const Square& tensor) {
    return components_of(2 * tensor - Square(tensor.diagonal().asDiagonal()));
  }
  static Square tensor_of(const Components<d>& own) {
    Square tensor;
    constexpr auto order = components<d>();
    for (int k = 0; k < kComponents; ++k) {
      const auto [i, j] = order[k];
      tensor(i, j) = tensor(j, i) = own[k];
    }
    return tensor;
  }
  static Components<d> components_of(const Square& tensor) {
    Components<d> own;
    constexpr auto order = components<d>();
    for (int k = 0; k < own.size(); ++k) {
      const auto [i, j] = order[k];
      own[k] = tensor(i, j);
    }
    return own;
  }
  /// What the past has left of the stress at a point.
  Square left_stress(int cell, int g) const { return tensor_of(of_stress(relaxing_.fixed(), cell, g)); }
  /// S of all points, with the cells' pressures, without relaxation, and their strains.
  void set_relaxing_stresses(const Positions& positions) {
    parallel_for(
        block_.size(),
        [&](int cell) {
          Stresses now;
          set_elastic_stresses(positions, cell, now);
          for (int g = 0; g < points_; ++g) {
            if constexpr (d == 3)
              if (!volume_.empty()) {
                const Dilatation shape(now.A[g]);
                now.S[g] += now.p[g] * shape.J() * shape.inverse;
              }
            of_stress(relaxing_.now(), cell, g) = components_of(now.S[g]);
            of_stress(relaxing_.strain(), cell, g) = rest(cell, g).weight * doubled_components(now.A[g]);  // 2E
          }
        },
        kCellThreshold);
  }
  bool is_inverted(const Positions& positions, int cell) const {
    Strains now;
    set_strains(positions, cell, now);
    return now.inverted;
  }

  static Changes changes_of(const Gradient& F, const Direction& B) {
    Changes V;
    constexpr auto order = components<d>();
    for (int k = 0; k < V.rows(); ++k) {
      const auto [p, q] = order[k];
      for (int i = 0; i < 3; ++i) V(k, i) = (F(i, p) * B[q] + F(i, q) * B[p]) * (p == q ? 1 : 2);
    }
    return V;
  }

  /// What a motion e_i ⊗ B of the point meets: the change of C, its stress, and S B.
  struct Acting {
    Direction B, SB;
    Changes V, DV;
  };
  static Acting acting(const Now& now, const Direction& B) {
    const Changes V = changes_of(now.F, B);
    return {B, now.S * B, V, now.D * V};
  }
  /// The stiffness between the motions a and b.
  static void add_pair(const Acting& a, const Acting& b, Matrix3& block) {
    block.noalias() += 0.5 * (a.V.transpose() * b.DV);
    block.diagonal().array() += a.B.dot(b.SB);
  }
  /// Where C_ij is among the components.
  static constexpr int component(int i, int j) { return i == j ? i : i + j + d - 1; }
  static UpperTriangle upper_triangle(const Matrix3& block) {
    return {block(0, 0), block(0, 1), block(0, 2), block(1, 1), block(1, 2), block(2, 2)};
  }
  static void add_pressures(const PressureGradient& a, const PressureMatrix& Q, const PressureGradient& b,
                            Matrix3& block) {
    const PressureGradient aQ = a * Q;
    block.noalias() += aQ * b.transpose();
  }

  // ------------------------------------------------------------------------------------- pressures of the whole cell

  /// φ at each point, and M⁻¹ of each cell, M = ∫ φ φᵀ.
  void set_pressure_functions() {
    functions_.assign(points_, Pressures::Zero());
    for (int g = 0; g < points_; ++g) {
      Pressures& own = functions_[g];
      own[0] = 1;
      for (int k = 1; k < kind_.pressures; ++k) own[k] = kind_.points(k - 1, g);
    }
    const int m = kind_.pressures;
    for (const int cell : first_of_shape_) {
      PressureMatrix M = PressureMatrix::Zero();
      for (int g = 0; g < points_; ++g) {
        const Pressures& own = functions_[g];
        M += rest(cell, g).weight * own * own.transpose();
      }
      PressureMatrix inverted = PressureMatrix::Zero();
      inverted.topLeftCorner(m, m) = inverse(M.topLeftCorner(m, m));
      inverse_mass_.push_back(inverted);
    }
  }
  double at_point(const Pressures& values, int g) const { return functions_[g].dot(values); }
  /// M⁻¹ ∫ φ v.
  template <class Value>
  Pressures projected(int cell, Value value) const {
    Pressures sum = Pressures::Zero();
    for (int g = 0; g < points_; ++g) sum += rest(cell, g).weight * value(g) * functions_[g];
    return inverse_mass_[shape_[cell]] * sum;
  }
  /// θ − 1.
  Pressures projected_swelling(int cell, const Strains& now) const {
    return projected(cell, [&](int g) { return now.swelling[g]; });
  }
  /// p at the points: the projection of U′(θ) [Pa].
  void set_pressures(int cell, const Strains& now, std::array<double, kMostPoints>& p) const {
    if (volume_.empty()) return;
    const Pressures theta = projected_swelling(cell, now);
    const Pressures own = projected(cell, [&](int g) { return volume_of(cell).slope(at_point(theta, g)); });
    for (int g = 0; g < points_; ++g) p[g] = at_point(own, g);
  }
  /// S += p J C⁻¹ and D += ½ p J (G_ij G_kl − G_ik G_jl − G_il G_jk), G = C⁻¹.
  static void add_pressure(double p, const Matrix3& A, Matrix3& S, TangentModuli<3>& D) {
    const Dilatation now(A);
    const Matrix3& G = now.inverse;
    const double pJ = p * now.J();
    S += pJ * G;
    constexpr auto order = components<3>();
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) {
        const auto [i, j] = order[row];
        const auto [k, l] = order[column];
        D(row, column) += pJ / 2 * (G(i, j) * G(k, l) - G(i, k) * G(j, l) - G(i, l) * G(j, k));
      }
  }
  /// Q in δp = Q ∫ φ δJ: M⁻¹ ∫ U″ φ φᵀ M⁻¹, or a part of it.
  PressureMatrix stiffness_of_pressures(int cell, const Strains& now, double part = 1) const {
    const Pressures theta = projected_swelling(cell, now);
    PressureMatrix sum = PressureMatrix::Zero();
    for (int g = 0; g < points_; ++g) {
      const Pressures& own = functions_[g];
      sum += rest(cell, g).weight * volume_of(cell).curvature(at_point(theta, g)) * own * own.transpose();
    }
    const PressureMatrix& M = inverse_mass_[shape_[cell]];
    return part * (relaxing_ ? relaxing_.factor() : 1) * M * sum * M;
  }
  // ------------------------------------------------------------------------------------------------------------------

  /// Adds work(cell, own) of each cell to its nodes. Each molecule meets its cells in ascending order, whoever adds.
  template <class Work>
  void add_cells(Positions& values, Workspace& workspace, Work&& work) const {
    const int n = kind_.nodes;
    if (threads() == 1 || block_.size() < kCellThreshold) {
      NodeVectors own(3, n);
      for (int cell = 0; cell < block_.size(); ++cell) {
        own.setZero();
        work(cell, own);
        const int* nodes = block_.cell(cell).data();
        for (int a = 0; a < n; ++a) values.col(nodes[a]) += own.col(a);
      }
      return;
    }
    // Each thread has a range of cells, and adds to the molecules that no other's cells have. What the others get waits
    // in slots, most of which nothing ever touches.
    const int range = (block_.size() + threads() - 1) / threads();
    auto slots = workspace.buffer(Workspace::slots, static_cast<Eigen::Index>(block_.nodes.size()) * 3);
    parallel_for(
        threads(),
        [&](int number) {
          const int begin = number * range, end = std::min(block_.size(), begin + range);
          NodeVectors own(3, n);
          for (int cell = begin; cell < end; ++cell) {
            own.setZero();
            work(cell, own);
            for (int a = 0; a < n; ++a) {
              const int slot = cell * n + a, molecule = block_.nodes[slot];
              const auto& [first, last] = cells_of_[molecule];
              if (first >= begin && last < end)
                values.col(molecule) += own.col(a);
              else
                slots.segment<3>(3 * static_cast<Eigen::Index>(slot)) = own.col(a);
            }
          }
        },
        1);
    parallel_for(
        body_.size(),
        [&](int molecule) {
          const auto& [first, last] = cells_of_[molecule];
          if (first / range != last / range)
            for (const int slot : slots_[molecule])
              values.col(molecule) += slots.segment<3>(3 * static_cast<Eigen::Index>(slot));
        },
        kMoleculeThreshold);
  }

  const Body& body_;
  const CellBlock& block_;
  const CellKind& kind_;
  int points_;
  ReferenceSlopes<d> slopes_;
  std::shared_ptr<const PointLaws<d>> laws_;
  std::vector<Volumetric> volume_;            ///< empty: the laws' own
  std::vector<int> numbers_;                  ///< on a subdomain of the whole's cells; empty: the same
  SoftenedElements softened_;                 ///< a point each
  Relaxing relaxing_;                         ///< the stress at each point
  Rows slots_;                                ///< of each molecule among the nodes of all cells
  std::vector<std::array<int, 2>> cells_of_;  ///< of each molecule, the first and the last
  std::vector<int> shape_;                    ///< of each cell; what follows is of each shape, at each point
  std::vector<int> first_of_shape_;           ///< the cell that has it first
  std::vector<Rest> rest_;
  std::vector<Gradient> frames_;   ///< of membranes
  std::vector<Gradient> offsets_;  ///< F without displacement, beyond the frame, of a body that is stressed then
  std::vector<Pressures> functions_;
  std::vector<PressureMatrix> inverse_mass_;
};

/// The stiffness of a block's cells at one state.
template <int d>
class BlockStiffness final : public NodalStiffness, public StiffPoints, public CellPressures {
  using Cells = BlockCells<d>;
  using Acting = typename Cells::Acting;
  using Direction = typename Cells::Direction;
  using Gradient = typename Cells::Gradient;
  using Moduli = typename Cells::Moduli;
  using Now = typename Cells::Now;
  using Square = typename Cells::Square;
  using Strains = typename Cells::Strains;
  using Stresses = typename Cells::Stresses;
  using PressureGradient = typename Cells::PressureGradient;
  using PressureMatrix = typename Cells::PressureMatrix;
  using Pressures = typename Cells::Pressures;
  using UpperTriangle = typename Cells::UpperTriangle;
  using UpperTriangles = typename Cells::UpperTriangles;
  static constexpr int kCellThreshold = Cells::kCellThreshold, kComponents = Cells::kComponents;

 public:
  explicit BlockStiffness(const Cells& cells) : cells_(cells) {}

  void linearise_at(const Positions& positions) override {
    if (!share(positions)) linearise_each([&](int cell) { set_now(positions, cell, cell); });
  }
  bool predicts() const override { return true; }
  void linearise_onward(const Positions& from, const Positions& to) override {
    linearise_each([&](int cell) {
      Strains there;
      Stresses predicted;
      predict(from, to, cell, there, predicted);
      cells_.set_stresses(cell, predicted);
      set_now(predicted, cell, cell);
    });
  }
  void add_onward_forces(const Positions& from, const Positions& to, Positions& forces,
                         Workspace& workspace) const override {
    cells_.add_cells(forces, workspace, [&](int cell, NodeVectors& own) {
      Strains there, predicted;
      predict(from, to, cell, there, predicted);
      PointGradients<d> P;
      for (int g = 0; g < cells_.points_; ++g) {
        const Now& now = this->now(cell, g);
        const Square more = there.A[g] - predicted.A[g];
        P[g] = -now.F * (now.S + Cells::tensor_of(now.D * Cells::doubled_components(more)));
      }
      if constexpr (d == 3)
        if (!cells_.volume_.empty()) {
          Pressures swelling = Pressures::Zero();
          for (int g = 0; g < cells_.points_; ++g)
            swelling +=
                cells_.rest(cell, g).weight * (there.swelling[g] - predicted.swelling[g]) * cells_.functions_[g];
          const Pressures p = stiffness_of_pressures_[cell] * swelling;
          for (int g = 0; g < cells_.points_; ++g)
            P[g] -= cells_.rest(cell, g).weight * cells_.at_point(p, g) * cofactors(now(cell, g).F);
        }
      cells_.spread(cell, P, own);
    });
  }

  void add_stiffness(const Positions& motion, Positions& result, Workspace& workspace) const override {
    if (!shared_.empty())
      return cells_.add_cells(result, workspace, [&](int cell, NodeVectors& own) {
        const int* nodes = cells_.block_.cell(cell).data();
        Eigen::Matrix<double, 3, kCorners> change;
        for (int a = 0; a < kCorners; ++a) change.col(a) = motion.col(nodes[a]) - motion.col(nodes[0]);
        const auto& [number, factor] = of_cell_[cell];
        multiply24(shared_[number].matrix.data(), change.data(), factor, own.data());
      });
    cells_.add_cells(result, workspace, [&](int cell, NodeVectors& own) {
      PointGradients<d> change, P;
      cells_.set_gradients(cell, cells_.gathered(motion, cell), change);
      for (int g = 0; g < cells_.points_; ++g) {
        const Now& now = this->now(cell, g);
        P[g].noalias() = change[g] * now.S;
        P[g].noalias() += now.F * change_of_stress(now, change[g]);
      }
      if constexpr (d == 3)
        if (!cells_.volume_.empty()) {
          const Pressures p = stiffness_of_pressures_[cell] * swelling_by(cell, change);
          for (int g = 0; g < cells_.points_; ++g)
            P[g] += cells_.rest(cell, g).weight * cells_.at_point(p, g) * cofactors(now(cell, g).F);
        }
      cells_.spread(cell, P, own);
    });
  }

  void visit_blocks(const BlockVisitor& visit) const override {
    const int n = cells_.kind_.nodes;
    std::vector<Matrix3> K(n * n);
    for (int cell = 0; cell < cells_.block_.size(); ++cell) {
      set_blocks(cell, K);
      const auto nodes = cells_.block_.cell(cell);
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) visit(nodes[a], nodes[b], factor(cell) * K[a * n + b]);
    }
  }

  void visit_diagonal(const DiagonalVisitor& visit, Workspace& workspace) const override {
    constexpr int most_cells = 512;  // at once
    const int n = cells_.kind_.nodes;
    auto blocks = workspace.buffer(Workspace::diagonals, 6 * n * std::min(most_cells, cells_.block_.size()))
                      .reshaped(6, Eigen::AutoSize);
    for (int first = 0; first < cells_.block_.size(); first += most_cells) {
      const int count = std::min(most_cells, cells_.block_.size() - first);
      parallel_for(
          count, [&](int i) { set_diagonal(first + i, blocks.middleCols(i * n, n)); }, 1);
      for (int i = 0; i < count * n; ++i) {
        const UpperTriangle own = blocks.col(i);
        Matrix3 block;
        block << own[0], own[1], own[2], own[1], own[3], own[4], own[2], own[4], own[5];
        visit(cells_.block_.nodes[first * n + i], block);
      }
    }
  }

  /// The pressures' part; the rest is in visit_points.
  bool visit_gradients(const GradientVisitor& visit) const override {
    if constexpr (d == 3) {
      std::vector<std::pair<int, Vector3>> gradient;
      for (int cell = 0; cell < (cells_.volume_.empty() ? 0 : cells_.block_.size()); ++cell) {
        const int m = cells_.kind_.pressures;
        const std::vector<PressureGradient> G = pressure_gradients(cell);
        const SymmetricEigen eigen = symmetric_eigen(stiffness_of_pressures(cell).topLeftCorner(m, m));
        for (int k = 0; k < m; ++k) {
          if (!(eigen.values[k] > 0)) continue;
          Pressures along = Pressures::Zero();
          for (int j = 0; j < m; ++j) along[j] = eigen.vectors(j, k);
          gradient.clear();
          const auto nodes = cells_.block_.cell(cell);
          for (int a = 0; a < cells_.kind_.nodes; ++a) gradient.emplace_back(nodes[a], G[a] * along);
          visit(gradient, factor(cell) * eigen.values[k]);
        }
      }
    }
    return true;
  }

  void visit_points(const PointsVisitor& visit) const override { visit(*this); }

  Eigen::Index pressures() const override {
    return cells_.volume_.empty() ? 0 : static_cast<Eigen::Index>(cells_.block_.size()) * cells_.kind_.pressures;
  }
  int of_each_cell() const override { return cells_.kind_.pressures; }
  double stiffness_ratio() const override {
    double most = 0;
    if constexpr (d == 3)
      for (int cell = 0; cell < (cells_.volume_.empty() ? 0 : cells_.block_.size()); ++cell) {
        constexpr int shear = Cells::component(0, 1);
        const double modulus = 2 * factor(cell) * now(cell, 0).D(shear, shear) / cells_.rest(cell, 0).weight;
        if (modulus > 0) most = std::max(most, cells_.volume_of(cell).curvature(0) / modulus);
      }
    return most;
  }
  void swell(const Positions& motion, Eigen::Ref<VectorX> swelling) const override {
    const int m = cells_.kind_.pressures;
    if constexpr (d == 3)
      parallel_for(
          cells_.block_.size(),
          [&](int cell) {
            PointGradients<d> change;
            cells_.set_gradients(cell, cells_.gathered(motion, cell), change);
            swelling.segment(static_cast<Eigen::Index>(cell) * m, m) = swelling_by(cell, change).head(m);
          },
          kCellThreshold);
  }
  void add_forces_of(const Eigen::Ref<const VectorX>& pressures, Positions& forces,
                     Workspace& workspace) const override {
    const int m = cells_.kind_.pressures;
    if constexpr (d == 3)
      cells_.add_cells(forces, workspace, [&](int cell, NodeVectors& own) {
        Pressures all = Pressures::Zero();
        all.head(m) = pressures.segment(static_cast<Eigen::Index>(cell) * m, m);
        PointGradients<d> P;
        for (int g = 0; g < cells_.points_; ++g)
          P[g] = cells_.rest(cell, g).weight * cells_.at_point(all, g) * cofactors(now(cell, g).F);
        cells_.spread(cell, P, own);
      });
  }
  void resist(const Eigen::Ref<const VectorX>& swelling, Eigen::Ref<VectorX> pressures) const override {
    const int m = cells_.kind_.pressures;
    parallel_for(
        cells_.block_.size(),
        [&](int cell) {
          const auto at = static_cast<Eigen::Index>(cell) * m;
          pressures.segment(at, m).noalias() =
              factor(cell) * stiffness_of_pressures(cell).topLeftCorner(m, m) * swelling.segment(at, m);
        },
        kCellThreshold);
  }
  void take_part(double part) override { pressure_part_ = part; }
  int stiff_points() const override { return cells_.block_.size() * places(); }
  std::span<const int> nodes_of(int point) const override { return cells_.block_.cell(point / places()); }
  Vector3 place_of(int point) const override {
    const NodeVectors nodes = cells_.gathered(cells_.body_.rest, point / places());
    return places() == 1 ? Vector3(nodes.rowwise().mean()) : cells_.place_of(nodes, point % places());
  }
  Stiffness stiffness_at(int point) const override {
    const int cell = point / places(), g = point % places();
    const auto frame = cells_.frame(cell, g);
    if (!shared_.empty()) return {frame, factor(cell) * shared_[known(cell)].of_gradient};
    return {frame, stiffness_at(cell, g, places() == 1 ? cells_.points_ : g + 1)};
  }

 private:
  static constexpr int kCorners = 8;
  static constexpr int kManyCells = 4096;  ///< of fewer the rows are assembled, AssembledStiffness
  /// The stiffness of hexahedra at rest that have one shape and one material up to a factor.
  struct Shared {
    int cell;  ///< the first of them
    Moduli D;
    double curvature;  ///< U″ at rest
    Eigen::Matrix<double, 3 * kCorners, 3 * kCorners> matrix = {};
    Eigen::Matrix<double, 3 * d, 3 * d> of_gradient = {};  ///< StiffPoints::stiffness_at
  };
  struct SharedBy {
    int number;
    double factor;
  };

  /// Where a cell's stiffness stands for boxes that are larger than it is: of a solid one of first order in its middle.
  int places() const { return d == 3 && cells_.kind_.order == 1 ? 1 : cells_.points_; }

  /// What is known at each point: by the cell, or by what it shares; then times the cell's factor.
  const Now& now(int cell, int g) const { return now_[known(cell) * cells_.points_ + g]; }
  const PressureMatrix& stiffness_of_pressures(int cell) const { return stiffness_of_pressures_[known(cell)]; }
  int known(int cell) const { return of_cell_.empty() ? cell : of_cell_[cell].number; }
  double factor(int cell) const { return of_cell_.empty() ? 1 : of_cell_[cell].factor; }

  void set_count(int count) {
    now_.resize(count * cells_.points_);
    now_.shrink_to_fit();
    if (!cells_.volume_.empty()) stiffness_of_pressures_.resize(count);
  }
  template <class Set>
  void linearise_each(Set set) {
    shared_.clear(), of_cell_.clear();
    set_count(cells_.block_.size());
    parallel_for(cells_.block_.size(), set, kCellThreshold);
  }
  /// δS of a point by δF.
  static Square change_of_stress(const Now& now, const Gradient& change) {
    Components<d> of_C;
    const Square half = now.F.transpose() * change;
    constexpr auto order = components<d>();
    for (int k = 0; k < of_C.size(); ++k) {
      const auto [i, j] = order[k];
      of_C[k] = (half(i, j) + half(j, i)) * (i == j ? 1 : 2);
    }
    return Cells::tensor_of(now.D * of_C);
  }
  /// ∫ φ δJ of a cell.
  Pressures swelling_by(int cell, const PointGradients<d>& change) const {
    Pressures sum = Pressures::Zero();
    if constexpr (d == 3)
      for (int g = 0; g < cells_.points_; ++g)
        sum += cells_.rest(cell, g).weight * cofactors(now(cell, g).F).cwiseProduct(change[g]).sum() *
               cells_.functions_[g];
    return sum;
  }

  void set_now(const Positions& positions, int cell, int number) {
    Stresses now;
    cells_.set_stresses(positions, cell, now);
    set_now(now, cell, number);
  }
  /// By strains, pressures and, without these, stresses.
  void set_now(Stresses& now, int cell, int number) {
    std::array<Moduli, kMostPoints> D;
    cells_.laws_->tangents(cells_.number(cell), cells_.span(now.A),
                           {D.data(), static_cast<std::size_t>(cells_.points_)});
    if (cells_.softened_) cells_.soften_tangents(cell, now, D);
    for (int g = 0; g < cells_.points_; ++g) {
      if (cells_.relaxing_) D[g] *= cells_.relaxing_.factor();
      if constexpr (d == 3)
        if (!cells_.volume_.empty()) Cells::add_pressure(now.p[g], now.A[g], now.S[g], D[g]);
      const double weight = cells_.rest(cell, g).weight;
      now_[number * cells_.points_ + g] = {now.F[g], weight * now.S[g], weight * D[g]};
    }
    if constexpr (d == 3)
      if (!cells_.volume_.empty())
        stiffness_of_pressures_[number] = cells_.stiffness_of_pressures(cell, now, pressure_part_);
  }
  /// Sets the strains at `to`, and those with what is linear in the motion from `from` in place of the rest of it.
  void predict(const Positions& from, const Positions& to, int cell, Strains& there, Strains& predicted) const {
    Strains before;
    cells_.set_strains(from, cell, before);
    cells_.set_strains(to, cell, there);
    predicted = there;
    for (int g = 0; g < cells_.points_; ++g) {
      const Gradient change = there.F[g] - before.F[g];
      const Square half = before.F[g].transpose() * change, A = before.A[g] + half + half.transpose();
      bool possible = is_stretch(Square::Identity() + A);
      if constexpr (d == 3) {
        const double swelling = before.swelling[g] + cofactors(before.F[g]).cwiseProduct(change).sum();
        possible &= swelling > -1;
        if (possible) predicted.swelling[g] = swelling;
      }
      if (possible) predicted.A[g] = A;
    }
  }
  /// Whether C is positive definite.
  static bool is_stretch(const Square& C) {
    return C(0, 0) > 0 && C(0, 0) * C(1, 1) > C(0, 1) * C(0, 1) && C.determinant() > 0;
  }

  /// Of a body at rest, without stress, whose hexahedra are few kinds of one: a segmented image has a million of one.
  bool share(const Positions& positions) {
    constexpr std::size_t few = 64;
    constexpr double rounding = 1e-12;
    shared_.clear(), of_cell_.clear();
    if (d != 3 || cells_.kind_.nodes != kCorners || cells_.block_.size() < kManyCells || cells_.dissipates() ||
        cells_.body_.unstressed || cells_.first_of_shape_.size() > few || positions != cells_.body_.rest)
      return false;
    for (int cell = 0; cell < cells_.block_.size(); ++cell) {
      const Square none = Square::Zero();
      Square S;
      Moduli D;
      cells_.laws_->stresses(cells_.number(cell), {&none, 1}, {&S, 1});
      cells_.laws_->tangents(cells_.number(cell), {&none, 1}, {&D, 1});
      const double curvature = cells_.volume_.empty() ? 0 : cells_.volume_of(cell).curvature(0);
      const double pressure = cells_.volume_.empty() ? 0 : cells_.volume_of(cell).slope(0);
      const auto found = std::find_if(shared_.begin(), shared_.end(), [&](const Shared& other) {
        const double factor = D(0, 0) / other.D(0, 0);
        return cells_.shape_[cell] == cells_.shape_[other.cell] && factor > 0 &&
               (D - factor * other.D).cwiseAbs().maxCoeff() <= rounding * D(0, 0) &&
               std::abs(curvature - factor * other.curvature) <= rounding * curvature;
      });
      const auto kind = static_cast<int>(found - shared_.begin());
      if (!S.isZero(0) || pressure != 0 || (found == shared_.end() && shared_.size() == few)) return false;
      if (found == shared_.end()) shared_.push_back({cell, D, curvature});
      of_cell_.push_back({kind, D(0, 0) / shared_[kind].D(0, 0)});
    }
    set_count(static_cast<int>(shared_.size()));
    std::vector<Matrix3> K(kCorners * kCorners);
    int number = 0;
    for (Shared& own : shared_) {
      set_now(positions, own.cell, number++);
      set_blocks(own.cell, K);
      own.of_gradient = stiffness_at(own.cell, 0, cells_.points_);
      for (int a = 0; a < kCorners; ++a)
        for (int b = 0; b < kCorners; ++b) own.matrix.template block<3, 3>(3 * a, 3 * b) = K[a * kCorners + b];
    }
    return true;
  }

  /// The sum over points of a cell of what a gradient in the frame's axes meets, StiffPoints::Stiffness.
  Eigen::Matrix<double, 3 * d, 3 * d> stiffness_at(int cell, int first, int end) const {
    Eigen::Matrix<double, 3 * d, 3 * d> sum = Eigen::Matrix<double, 3 * d, 3 * d>::Zero();
    for (int g = first; g < end; ++g) {
      std::array<Acting, d> at;
      for (int p = 0; p < d; ++p) at[p] = Cells::acting(now(cell, g), Direction::Unit(p));
      for (int p = 0; p < d; ++p)
        for (int q = 0; q < d; ++q) {
          Matrix3 block = Matrix3::Zero();
          Cells::add_pair(at[p], at[q], block);
          sum.template block<3, 3>(3 * p, 3 * q) += block;
        }
    }
    return sum;
  }
  /// Between the nodes of a cell, a · nodes + b, without its factor.
  void set_blocks(int cell, std::vector<Matrix3>& K) const {
    const int n = cells_.kind_.nodes;
    std::fill(K.begin(), K.end(), Matrix3::Zero());
    for (int g = 0; g < cells_.points_; ++g) {
      std::array<Acting, kMostNodes> at;
      for (int a = 0; a < n; ++a) at[a] = Cells::acting(now(cell, g), cells_.slope(cell, g, a));
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) Cells::add_pair(at[a], at[b], K[a * n + b]);
    }
    if constexpr (d == 3)
      if (!cells_.volume_.empty()) {
        const std::vector<PressureGradient> G = pressure_gradients(cell);
        for (int a = 0; a < n; ++a)
          for (int b = 0; b < n; ++b) Cells::add_pressures(G[a], stiffness_of_pressures(cell), G[b], K[a * n + b]);
      }
  }
  /// The upper triangles of the diagonal blocks of a cell's nodes, a column each. Those of one point are
  /// Σ_pq B_p B_q A_pq, A_pq = 2 Σ_rs F_r D_pr,qs F_sᵀ + S_pq: A_pq + A_qp is found once for all nodes.
  void set_diagonal(int cell, Eigen::Ref<UpperTriangles> blocks) const {
    blocks.setZero();
    if (!shared_.empty()) {
      for (int a = 0; a < kCorners; ++a)
        blocks.col(a) =
            factor(cell) * Cells::upper_triangle(shared_[known(cell)].matrix.template block<3, 3>(3 * a, 3 * a));
      return;
    }
    constexpr auto order = components<d>();
    for (int g = 0; g < cells_.points_; ++g) {
      const Now& now = this->now(cell, g);
      std::array<UpperTriangle, kComponents> A;
      for (std::size_t k = 0; k < order.size(); ++k) {
        const auto [p, q] = order[k];
        Square between;
        for (int r = 0; r < d; ++r)
          for (int s = 0; s < d; ++s) {
            between(r, s) = now.D(Cells::component(p, r), Cells::component(q, s));
            if (p != q) between(r, s) += now.D(Cells::component(q, r), Cells::component(p, s));
          }
        const double along = p == q ? now.S(p, p) : now.S(p, q) + now.S(q, p);
        const Matrix3 block = 2 * now.F * between * now.F.transpose() + along * Matrix3::Identity();
        A[k] = Cells::upper_triangle(block);
      }
      for (int a = 0; a < cells_.kind_.nodes; ++a) {
        const Direction B = cells_.slope(cell, g, a);
        for (std::size_t k = 0; k < order.size(); ++k) blocks.col(a) += B[order[k][0]] * B[order[k][1]] * A[k];
      }
    }
    if constexpr (d == 3)
      if (!cells_.volume_.empty()) {
        const std::vector<PressureGradient> G = pressure_gradients(cell);
        for (int a = 0; a < cells_.kind_.nodes; ++a) {
          Matrix3 block = Matrix3::Zero();
          Cells::add_pressures(G[a], stiffness_of_pressures(cell), G[a], block);
          blocks.col(a) += Cells::upper_triangle(block);
        }
      }
  }
  /// Of each node.
  std::vector<PressureGradient> pressure_gradients(int cell) const {
    std::vector<PressureGradient> G(cells_.kind_.nodes, PressureGradient::Zero());
    if constexpr (d == 3)
      for (int g = 0; g < cells_.points_; ++g) {
        const Matrix3 to_node = cells_.rest(cell, g).weight * cofactors(now(cell, g).F);
        for (int a = 0; a < cells_.kind_.nodes; ++a)
          G[a] += (to_node * cells_.slope(cell, g, a)) * cells_.functions_[g].transpose();
      }
    return G;
  }

  const Cells& cells_;
  // At the positions of linearise_at().
  std::vector<Shared, Eigen::aligned_allocator<Shared>> shared_;
  std::vector<SharedBy> of_cell_;
  std::vector<Now> now_;
  std::vector<PressureMatrix> stiffness_of_pressures_;
  double pressure_part_ = 1;  ///< of them that counts, see CellPressures
};

}  // namespace

template <int dimensions>
std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::shared_ptr<const PointLaws<dimensions>> laws) {
  return std::make_unique<BlockCells<dimensions>>(body, block, std::move(laws), std::vector<Volumetric>{});
}
template std::unique_ptr<NodalForces> make_block_cells<2>(const Body&, const CellBlock&,
                                                          std::shared_ptr<const PointLaws<2>>);
template std::unique_ptr<NodalForces> make_block_cells<3>(const Body&, const CellBlock&,
                                                          std::shared_ptr<const PointLaws<3>>);

std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::shared_ptr<const PointLaws<3>> laws,
                                              std::vector<Volumetric> volume) {
  return std::make_unique<BlockCells<3>>(body, block, std::move(laws), std::move(volume));
}

namespace {

/// The law at work in each cell of a block, or once where all cells have the same.
template <class AtWork>
auto laws_of(const Body& body, const CellBlock& block, const Material& material, const AtWork& at_work) {
  std::vector<decltype(at_work(material))> laws;
  Material own = material;
  for (int cell = 0; cell < (block.stiffness.size() || material.varies() ? block.size() : 1); ++cell) {
    if (material.varies()) own = local_material(material, middle_of(body, block, cell));
    if (block.stiffness.size()) own.youngs_modulus = material.youngs_modulus * block.stiffness[cell];
    laws.push_back(at_work(own));
  }
  return laws;
}

/// Of all points of a cell one law: one for all cells, or one a cell.
template <int dimensions>
class CellLaws final : public PointLaws<dimensions> {
 public:
  explicit CellLaws(std::vector<AnyPoint<dimensions>> laws) : laws_(std::move(laws)) {}

  bool has_energy() const override { return laws_.front().has_energy(); }
  void stresses(int cell, std::span<const Tensor<dimensions>> A, std::span<Tensor<dimensions>> S) const override {
    of(cell).stresses(A, S);
  }
  void tangents(int cell, std::span<const Tensor<dimensions>> A,
                std::span<TangentModuli<dimensions>> D) const override {
    of(cell).tangents(A, D);
  }
  double energy(int cell, std::span<const Tensor<dimensions>> A, std::span<const double> weights) const override {
    return of(cell).energy(A, weights);
  }

 private:
  const AnyPoint<dimensions>& of(int cell) const {
    return laws_[laws_.size() == 1 ? 0 : static_cast<std::size_t>(cell)];
  }
  std::vector<AnyPoint<dimensions>> laws_;
};

}  // namespace

template <int dimensions>
std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::vector<AnyPoint<dimensions>> laws, std::vector<Volumetric> volume) {
  return std::make_unique<BlockCells<dimensions>>(body, block, std::make_shared<CellLaws<dimensions>>(std::move(laws)),
                                                  std::move(volume));
}
template std::unique_ptr<NodalForces> make_block_cells<2>(const Body&, const CellBlock&, std::vector<AnyPoint<2>>,
                                                          std::vector<Volumetric>);
template std::unique_ptr<NodalForces> make_block_cells<3>(const Body&, const CellBlock&, std::vector<AnyPoint<3>>,
                                                          std::vector<Volumetric>);

namespace {

/// A law for each block of cells of these dimensions.
template <class Make>
ElasticTerms for_each_block(const Body& body, int dimensions, const Make& make) {
  ElasticTerms all;
  for (const CellBlock& block : body.blocks)
    if (block.kind->dimensions == dimensions) all.add(make(block));
  return all;
}

}  // namespace

template <int dimensions>
ElasticTerms make_blocks(const Body& body, const Material& material, const AnyAtWork<dimensions>& at_work) {
  return for_each_block(body, dimensions, [&](const CellBlock& block) {
    return make_block_cells<dimensions>(body, block, laws_of(body, block, material, at_work));
  });
}
template ElasticTerms make_blocks<2>(const Body&, const Material&, const AnyAtWork<2>&);
template ElasticTerms make_blocks<3>(const Body&, const Material&, const AnyAtWork<3>&);

ElasticTerms make_mixed_blocks(const Body& body, const Material& material,
                               const std::function<SplitPoint<AnyPoint<3>>(const Material&)>& at_work) {
  return for_each_block(body, 3, [&](const CellBlock& block) {
    std::vector<AnyPoint<3>> shapes;
    std::vector<Volumetric> volumes;
    for (auto& [shape, volume] : laws_of(body, block, material, at_work))
      shapes.push_back(std::move(shape)), volumes.push_back(volume);
    return make_block_cells<3>(body, block, std::move(shapes), std::move(volumes));
  });
}

}  // namespace elastin
