#pragma once
#include <algorithm>
#include <concepts>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "elastin/core/forces/block_cells.h"
#include "elastin/core/forces/elasticity.h"
#include "elastin/core/forces/mullins.h"
#include "elastin/core/laws/cell_kernel.h"
#include "elastin/core/laws/local.h"
#include "elastin/core/model/material.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/shapes/cell_shapes.h"

namespace elastin {

/// What the cell driver needs of a body's graph, kept apart from the law so that it is compiled once.
struct CellGraph {
  /// @param nodes molecules of all cells, `of_each` a cell. Throws InputError if two of a cell are not connected.
  CellGraph(const Connections& connections, std::span<const int> nodes, int of_each);
  template <std::size_t nodes>
  CellGraph(const Connections& connections, const std::vector<std::array<int, nodes>>& cells)
      : CellGraph(connections, {cells.empty() ? nullptr : cells.front().data(), cells.size() * nodes},
                  static_cast<int>(nodes)) {}

  int cells() const { return static_cast<int>(slot_connection.size()) / sides; }
  /// Adds each connection's slots in ascending cell order: one owner a connection, bitwise identical on any number of
  /// threads.
  void gather(Eigen::Ref<const VectorX> slots, VectorX& force_densities) const;

  /// A term of one thread's work: it adds to the connections begin … end−1 alone, and of the cells those that have one
  /// of these are among first … last−1.
  struct Range {
    int first, last, begin, end;
  };
  /// Into how many ranges a pass is split: 1 where one thread is as fast; 0 where cells reach everywhere, so that
  /// ranges would compute most cells again and slots are cheaper.
  int ranges() const;
  Range range(int number, int of) const;

  int sides;                         ///< connections of one cell
  std::vector<int> slot_connection;  ///< connection of slot cell · sides + side
  std::vector<int> start, slots_of;  ///< slots of each connection, ascending

 private:
  int connections_ = 0;
  std::vector<int> highest_until_;  ///< connection of cells 0 … cell
  std::vector<int> lowest_from_;    ///< connection of cells cell …
};

namespace detail {
/// Whether a pass over this number of cells stays on one thread.
bool on_one_thread(int cells);
void run_cells(int count, void* context, void (*range)(void*, int begin, int end));
/// Calls range(begin, end) over disjoint ranges that cover 0 … count−1.
template <class Range>
void for_each_cell(int count, Range&& range) {
  run_cells(count, &range, [](void* context, int begin, int end) {
    (*static_cast<std::remove_reference_t<Range>*>(context))(begin, end);
  });
}
void run_each(int count, void* context, void (*work)(void*, int number));
double sum_over_cells(int count, const std::function<double(int)>& term);

/// Adds share(cell), one number a side, to the connections of each cell. Each connection meets its cells in ascending
/// order, whoever adds.
template <int sides, class Share>
void add_shares(const CellGraph& graph, const Share& share, VectorX& values, Workspace& workspace) {
  const int* connections = graph.slot_connection.data();
  const int ranges = graph.ranges();
  if (ranges == 1) {
    for (int cell = 0; cell < graph.cells(); ++cell) {
      const Eigen::Matrix<double, sides, 1> own = share(cell);
      for (int side = 0; side < sides; ++side) values[connections[cell * sides + side]] += own[side];
    }
  } else if (ranges > 1) {
    const auto work = [&](int number) {
      const auto [first, last, begin, end] = graph.range(number, ranges);
      for (int cell = first; cell < last; ++cell) {
        const int* c = connections + static_cast<std::ptrdiff_t>(cell) * sides;
        if (std::none_of(c, c + sides, [from = begin, to = end](int at) { return from <= at && at < to; })) continue;
        const Eigen::Matrix<double, sides, 1> own = share(cell);
        for (int side = 0; side < sides; ++side)
          if (begin <= c[side] && c[side] < end) values[c[side]] += own[side];
      }
    };
    run_each(ranges, const_cast<void*>(static_cast<const void*>(&work)),
             [](void* context, int number) { (*static_cast<decltype(work)*>(context))(number); });
  } else {
    auto slots = workspace.buffer(Workspace::slots, graph.cells() * sides);
    for_each_cell(graph.cells(), [&](int begin, int end) {
      for (int cell = begin; cell < end; ++cell) slots.template segment<sides>(cell * sides) = share(cell);
    });
    graph.gather(slots, values);
  }
}
}  // namespace detail

/// The simplices of one shape: where their nodes are, their sides, what they make of slopes once a law has given them,
/// how they soften. Nothing here knows a law.
template <CellShape Shape>
class SimplexCells : public EdgeDensities,
                     public LocalElasticity,
                     public LawHistory,
                     public TransposedHistory,
                     public Softens {
 public:
  int elements() const override { return graph_.cells(); }
  std::span<const int> molecules_of(int cell) const override { return Shape::in(body_)[cell]; }
  /// A cell's volume is linear in the position of one corner.
  double relative_change(const Positions& positions, std::span<const LocalSlot> slots,
                         const Vector3& motion) const override {
    double most = 0;
    for (const auto& [cell, node] : slots) {
      NodePositions<nodes> own = positions_of(positions, cell);
      const double before = size_of(own);
      double edge = std::numeric_limits<double>::infinity();
      for (int other = 0; other < nodes; ++other)
        if (other != node) edge = std::min(edge, (own.col(other) - own.col(node)).squaredNorm());
      own.col(node) += motion;
      const double after = size_of(own);
      if (!(before > 0) || !(after > 0) || !(edge > 0)) return std::numeric_limits<double>::infinity();
      most = std::max({most, std::abs(after - before) / std::min(before, after), motion.norm() / std::sqrt(edge)});
    }
    return most;
  }

  bool admissible(const Positions& positions) const override {
    return detail::sum_over_cells(graph_.cells(), [&](int cell) { return is_inverted(positions, cell) ? 1. : 0.; }) ==
           0;
  }
  bool coupled() const override { return true; }
  std::unique_ptr<EdgeSlopes> slopes() const override { return std::make_unique<Slopes>(*this); }
  void show(const Positions& positions, VectorX&, const StateVisitor& visit) const override {
    for (int cell = 0; cell < graph_.cells(); ++cell) {
      const SquaredLengths q = densities(cell, squared_lengths(positions, cell));
      visit(Shape::in(body_)[cell], simplex_state(unstressed(cell), positions_of(positions, cell), {q.data(), sides}));
    }
  }

  bool soften(const Softening& softening) override {
    if (!has_energy()) return false;
    softened_ = SoftenedElements(softening, graph_.cells());
    set_sizes();
    return true;
  }
  bool softened() const override { return static_cast<bool>(softened_); }
  bool dissipates() const override { return softened(); }
  std::vector<HistoryBlock> history(const std::string& name) const override { return softened_.history(name); }
  void begin_step(const std::string& name, const State& from, double) override { softened_.begin_step(name, from); }
  void commit_step(const std::string& name, State& state) override {
    softened_.commit_step(name, state, [&](int cell) { return density(cell, squared_lengths(state.positions, cell)); });
  }
  /// ∂W/∂s = q/(2V).
  void transpose_commit(const HistoryBlock& from, double, const Positions& positions, std::vector<double>& slopes,
                        Positions& of_positions) const override {
    visit_unsoftened(positions, [&](int cell, double energy, const NodePositions<nodes>& pull) {
      const double slope = softened_.transpose_commit(from, cell, energy, slopes) / sizes_[cell];
      for (int node = 0; node < nodes; ++node) of_positions.col(Shape::in(body_)[cell][node]) -= slope * pull.col(node);
    });
  }
  void transpose_forces(const HistoryBlock& from, double, const Positions& positions, const Positions& lambda,
                        std::vector<double>& slopes) const override {
    visit_unsoftened(positions, [&](int cell, double energy, const NodePositions<nodes>& pull) {
      softened_.transpose_forces(from, cell, energy, positions_of(lambda, cell).cwiseProduct(pull).sum(), slopes);
    });
  }

 protected:
  static constexpr int nodes = Shape::nodes, sides = pairs_of(nodes);
  using SquaredLengths = CellVector<nodes>;
  using Slope = Eigen::Matrix<double, sides, sides, Eigen::RowMajor>;

  explicit SimplexCells(const Body& body) : body_(body), graph_(body.connections, Shape::in(body)) {}

  NodePositions<nodes> positions_of(const Positions& positions, int cell) const {
    const auto& at = Shape::in(body_)[cell];
    NodePositions<nodes> own;
    for (int node = 0; node < nodes; ++node) own.col(node) = positions.col(at[node]);
    return own;
  }
  /// A cell's nodes where it is unstressed, but for a rigid motion.
  NodePositions<nodes> unstressed(int cell) const {
    const NodePositions<nodes> rest = positions_of(body_.rest, cell);
    if (!body_.unstressed) return rest;
    const Vector3 middle = rest.rowwise().mean();
    return body_.unstressed->at(middle, middle, rest_part_) * (rest.colwise() - middle);
  }
  /// Six times the signed volume; 1 of a triangle, which has none.
  static double size_of(const NodePositions<nodes>& own) {
    if constexpr (Shape::dimensions == 3)
      return (own.col(1) - own.col(0)).cross(own.col(2) - own.col(0)).dot(own.col(3) - own.col(0));
    else
      return 1;
  }
  /// Lengths cannot tell a cell from its mirror image; volumes can.
  bool is_inverted(const Positions& positions, int cell) const {
    if constexpr (Shape::dimensions == 3)
      return flat_or_inverted<Shape>(positions_of(positions, cell));
    else
      return false;
  }
  SquaredLengths squared_lengths(const Positions& positions, int cell) const {
    const auto& at = Shape::in(body_)[cell];
    SquaredLengths s;
    int side = 0;
    for (std::size_t i = 0; i < nodes; ++i)
      for (std::size_t j = i + 1; j < nodes; ++j)
        s[side++] = (positions.col(at[j]) - positions.col(at[i])).squaredNorm();
    return s;
  }

  /// With changes that are linear in the motion from `from`; as they are, where no cell could have these lengths.
  SquaredLengths squared_lengths_onward(const Positions& from, const Positions& to, int cell) const {
    const auto& at = Shape::in(body_)[cell];
    SquaredLengths s;
    int side = 0;
    for (std::size_t i = 0; i < nodes; ++i)
      for (std::size_t j = i + 1; j < nodes; ++j) {
        const Vector3 d = from.col(at[j]) - from.col(at[i]);
        s[side++] = d.dot(2 * (to.col(at[j]) - to.col(at[i])) - d);
      }
    return is_shape(s) ? s : squared_lengths(to, cell);
  }
  /// Whether there is a cell with these: its edges from node 0 have a positive definite Gram matrix.
  static bool is_shape(const SquaredLengths& s) {
    const double g00 = s[0], g11 = s[1], g01 = (s[0] + s[1] - s[nodes - 1]) / 2;
    bool possible = g00 > 0 && g00 * g11 > g01 * g01;
    if constexpr (nodes == 4) {
      const double g22 = s[2], g02 = (s[0] + s[2] - s[4]) / 2, g12 = (s[1] + s[2] - s[5]) / 2;
      possible =
          possible && g00 * (g11 * g22 - g12 * g12) - g01 * (g01 * g22 - g12 * g02) + g02 * (g01 * g12 - g11 * g02) > 0;
    }
    return possible;
  }

  /// @param from null, or where the motion to these positions begins: then by squared_lengths_onward
  virtual void set_slopes(const Positions* from, const Positions& positions, std::vector<Slope>& slopes) const = 0;
  virtual SquaredLengths densities(int cell, const SquaredLengths& s) const = 0;
  /// Without softening: energy [J], [J] and force densities of a cell.
  virtual std::pair<double, SquaredLengths> unsoftened(int cell, const SquaredLengths& s) const = 0;

  /// W [J/m³], [J/m²].
  double density(int cell, const SquaredLengths& s) const { return unsoftened(cell, s).first / sizes_[cell]; }
  void set_sizes() {
    sizes_.clear();
    for (int cell = 0; cell < graph_.cells(); ++cell) sizes_.push_back(RestCell<Shape>(unstressed(cell)).measure());
  }

  const Body& body_;
  CellGraph graph_;
  double rest_part_ = 1;  ///< of Body::unstressed
  SoftenedElements softened_;
  std::vector<double> sizes_;  ///< V [m³], [m²] of what softens

 private:
  /// Calls visit(cell, W, forces on its nodes), without softening.
  template <class Visit>
  void visit_unsoftened(const Positions& positions, Visit visit) const {
    static constexpr auto pairs = node_pairs<nodes>();
    for (int cell = 0; cell < graph_.cells(); ++cell) {
      const auto [energy, q] = unsoftened(cell, squared_lengths(positions, cell));
      const NodePositions<nodes> own = positions_of(positions, cell);
      NodePositions<nodes> pull = NodePositions<nodes>::Zero();
      for (int side = 0; side < sides; ++side) {
        const auto [a, b] = pairs[side];
        const Vector3 force = q[side] * (own.col(b) - own.col(a));
        pull.col(a) += force, pull.col(b) -= force;
      }
      visit(cell, energy / sizes_[cell], pull);
    }
  }

  class Slopes final : public EdgeSlopes {
   public:
    explicit Slopes(const SimplexCells& cells) : cells_(cells) {}

    void linearise_at(const Positions& positions) override { linearise(nullptr, positions); }
    bool predicts() const override { return true; }
    void linearise_onward(const Positions& from, const Positions& to) override { linearise(&from, to); }
    void add_onward(const Positions& from, const Positions& to, VectorX& predicted, VectorX& linear,
                    Workspace& workspace) const override {
      const auto of_predicted = [&](int cell) { return cells_.squared_lengths_onward(from, to, cell); };
      detail::add_shares<sides>(
          cells_.graph_, [&](int cell) -> SquaredLengths { return cells_.densities(cell, of_predicted(cell)); },
          predicted, workspace);
      detail::add_shares<sides>(
          cells_.graph_,
          [&](int cell) -> SquaredLengths {
            const SquaredLengths s = of_predicted(cell);
            return cells_.densities(cell, s) + slopes_[cell] * (cells_.squared_lengths(to, cell) - s);
          },
          linear, workspace);
    }
    void add_own_slopes(VectorX&) const override {}
    void add_change(const VectorX& change_of_squared_lengths, VectorX& change_of_force_densities,
                    Workspace& workspace) const override {
      const CellGraph& graph = cells_.graph_;
      detail::add_shares<sides>(
          graph,
          [&](int cell) -> SquaredLengths {
            SquaredLengths all;
            for (int side = 0; side < sides; ++side)
              all[side] = change_of_squared_lengths[graph.slot_connection[cell * sides + side]];
            return slopes_[cell] * all;
          },
          change_of_force_densities, workspace);
    }
    void visit_cells(const CellVisitor& visit) const override {
      if (slopes_.empty()) return;
      const auto& cells = Shape::in(cells_.body_);
      visit(
          {sides, {cells.front().data(), cells.size() * nodes}, cells_.graph_.slot_connection, slopes_.front().data()});
    }

   private:
    void linearise(const Positions* from, const Positions& positions) {
      slopes_.resize(cells_.graph_.cells());
      cells_.set_slopes(from, positions, slopes_);
    }

    const SimplexCells& cells_;
    std::vector<Slope> slopes_;
  };
};

/// The one driver of every cell law. It owns the loops over the cells of one shape, what is written where and by which
/// thread; the kernel (see CellKernel) is the law on one cell.
template <LengthKernel Kernel>
class CellElasticity final : public SimplexCells<typename Kernel::Shape> {
  using Shape = typename Kernel::Shape;
  using Block = SimplexCells<Shape>;
  using Block::graph_, Block::squared_lengths, Block::sides, Block::softened_, Block::sizes_, Block::density;
  using typename Block::SquaredLengths;

 public:
  CellElasticity(const Body& body, const Material& material, Kernel kernel) : Block(body), kernel_(std::move(kernel)) {
    set_constants(material);
    if (body.unstressed) material_ = std::make_shared<const Material>(material);
  }
  void set_rest(double part) override {
    if (!material_) return;
    this->rest_part_ = part;
    set_constants(*material_);
    if (softened_) this->set_sizes();
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<CellElasticity>(*this); }
  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    if (softened_ || material_ || &this->body_ != own.whole) return nullptr;
    return std::unique_ptr<Elasticity>(new CellElasticity(*this, own));
  }
  bool has_energy() const override { return HasEnergy<Kernel>; }

  double energy(const Positions& positions) const override {
    if constexpr (HasEnergy<Kernel>)
      return detail::sum_over_cells(graph_.cells(), [&](int cell) {
        if (this->is_inverted(positions, cell)) return std::numeric_limits<double>::infinity();
        const SquaredLengths s = squared_lengths(positions, cell);
        return softened_ ? sizes_[cell] * softened_at(cell, s).energy : kernel_.energy(constants_[cell], s);
      });
    else
      return 0;
  }

  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    detail::add_shares<sides>(
        graph_, [&](int cell) -> SquaredLengths { return densities(cell, squared_lengths(positions, cell)); },
        force_densities, workspace);
  }

  void add_triangle_force_densities(const Positions& positions, Eigen::Ref<Eigen::Matrix3Xd> of_triangles,
                                    VectorX& of_connections, Workspace& workspace) const override {
    if constexpr (std::is_same_v<Shape, Triangle3>)
      for (int cell = 0; cell < graph_.cells(); ++cell)
        of_triangles.col(cell) += densities(cell, squared_lengths(positions, cell));
    else
      add_force_densities(positions, of_connections, workspace);
  }

  const LocalElasticity* local() const override { return HasEnergy<Kernel> && !softened_ ? this : nullptr; }
  double element_energy(const Positions& positions, int cell) const override {
    if constexpr (HasEnergy<Kernel>)
      return this->is_inverted(positions, cell) ? std::numeric_limits<double>::infinity()
                                                : kernel_.energy(constants_[cell], squared_lengths(positions, cell));
    else
      return 0;
  }
  /// ∂W/∂x_a = Σ_b q_ab d_ab, ∂²W/∂x_a² = Σ_b q_ab I + 2 Σ_bc ∂q_ab/∂s_ac d_ab d_acᵀ, d_ab = x_a − x_b; or the law's
  /// own of its shape, if it has one that is shorter.
  void add_blocks(const Positions& positions, std::span<const LocalSlot> slots, LocalBlock& block) const override {
    static constexpr auto pairs = node_pairs<Shape::nodes>();
    for (const LocalSlot& slot : slots) {
      const int cell = slot.element, node = slot.node;
      if constexpr (requires { kernel_.add_block(constants_[cell], this->positions_of(positions, cell), 0, block); }) {
        kernel_.add_block(constants_[cell], this->positions_of(positions, cell), node, block);
      } else {
        const auto own = this->positions_of(positions, cell);
        const SquaredLengths s = squared_lengths(positions, cell), q = kernel_.force_densities(constants_[cell], s);
        const typename Block::Slope slope = kernel_.slope(constants_[cell], s);
        for (int c = 0; c < sides; ++c) {
          if (pairs[c][0] != node && pairs[c][1] != node) continue;
          const Vector3 d = own.col(node) - own.col(pairs[c][pairs[c][0] == node ? 1 : 0]);
          block.gradient += q[c] * d;
          block.hessian.diagonal().array() += q[c];
          for (int e = 0; e < sides; ++e) {
            if (pairs[e][0] != node && pairs[e][1] != node) continue;
            block.hessian +=
                2 * slope(c, e) * d * (own.col(node) - own.col(pairs[e][pairs[e][0] == node ? 1 : 0])).transpose();
          }
        }
      }
    }
  }
  bool add_constraints(Constraints& all) const override {
    if constexpr (requires { kernel_.constraint(constants_.front()); }) {
      for (int cell = 0; cell < graph_.cells(); ++cell) {
        all.tetrahedra.push_back(kernel_.constraint(constants_[cell]));
        all.tetrahedra.back().molecules = Shape::in(this->body_)[cell];
      }
      return true;
    }
    return false;
  }

 private:
  using typename Block::Slope;

  void set_constants(const Material& material) {
    const Body& body = this->body_;
    constants_.clear();
    constants_.reserve(graph_.cells());
    if constexpr (requires { kernel_.point(material); })
      if (!material.varies() && body.cell_stiffness.size() == 0 && graph_.cells() > 0) {
        const auto shared = kernel_.point(material);
        for (int cell = 0; cell < graph_.cells(); ++cell)
          constants_.push_back(kernel_.constants(this->unstressed(cell), shared));
        return;
      }
    Material own = material;
    for (int cell = 0; cell < graph_.cells(); ++cell) {
      if (material.varies()) own = local_material(material, this->positions_of(body.rest, cell).rowwise().mean());
      if (body.cell_stiffness.size()) own.youngs_modulus = material.youngs_modulus * body.cell_stiffness[cell];
      constants_.push_back(kernel_.constants(this->unstressed(cell), own));
    }
  }

  void set_slopes(const Positions* from, const Positions& positions, std::vector<Slope>& slopes) const override {
    detail::for_each_cell(graph_.cells(), [&](int begin, int end) {
      for (int cell = begin; cell < end; ++cell)
        slopes[cell] =
            slope(cell, from ? this->squared_lengths_onward(*from, positions, cell) : squared_lengths(positions, cell));
    });
  }

  CellElasticity(const CellElasticity& whole, const Subdomain& own) : Block(*own.body), kernel_(whole.kernel_) {
    for (const int cell : Shape::dimensions == 3 ? own.tetrahedra : own.triangles)
      constants_.push_back(whole.constants_[cell]);
  }

  std::pair<double, SquaredLengths> unsoftened(int cell, const SquaredLengths& s) const override {
    if constexpr (HasEnergy<Kernel>)
      return {kernel_.energy(constants_[cell], s), kernel_.force_densities(constants_[cell], s)};
    else
      return {0, SquaredLengths::Zero()};
  }
  SoftenedEnergy softened_at(int cell, const SquaredLengths& s) const { return softened_.at(cell, density(cell, s)); }

  SquaredLengths densities(int cell, const SquaredLengths& s) const override {
    if (!softened_) return kernel_.force_densities(constants_[cell], s);
    const auto [energy, q] = unsoftened(cell, s);
    return softened_.at(cell, energy / sizes_[cell]).factor * q;
  }
  /// ∂(η q)/∂s = η ∂q/∂s + η′ q qᵀ/(2 V), for q = 2 V ∂W/∂s.
  auto slope(int cell, const SquaredLengths& s) const {
    CellMatrix<Shape::nodes> result = kernel_.slope(constants_[cell], s);
    if (softened_) {
      const SoftenedEnergy now = softened_at(cell, s);
      const SquaredLengths q = kernel_.force_densities(constants_[cell], s);
      result = now.factor * result + now.slope / (2 * sizes_[cell]) * q * q.transpose();
    }
    return result;
  }

  Kernel kernel_;
  std::vector<typename Kernel::Constants> constants_;
  std::shared_ptr<const Material> material_;  ///< where constants change with the rest
};

namespace detail {
/// The driver with the law's own type in it, on the simplices of a body.
template <int dimensions, class Law>
ElasticTerms make_simplices(const Body& body, const Material& material, const Law& law) {
  ElasticTerms all;
  ShapesOf<dimensions>::for_each([&]<class Shape>() {
    using Kernel = CellKernel<Law, Shape>;
    if (!Shape::in(body).empty()) all.add(std::make_unique<CellElasticity<Kernel>>(body, material, Kernel{law}));
  });
  return all;
}

/// The same of a law whose type is forgotten, compiled once.
template <int dimensions>
ElasticTerms make_any_simplices(const Body& body, const Material& material, const AnyAtWork<dimensions>& at_work);

/// Whether a law has a closed form in the lengths of one of these shapes.
template <int dimensions, class Law>
constexpr bool has_closed_form() {
  bool result = false;
  ShapesOf<dimensions>::for_each(
      [&]<class Shape>() { result |= !std::derived_from<CellKernel<Law, Shape>, PointKernel<Law, Shape>>; });
  return result;
}
}  // namespace detail

/// A law that sees C on all cells of a body that have these dimensions, whatever their shapes. A law with a closed form
/// in lengths, or without an energy, has a driver of its own; all others share one, at the price of a call a cell. The
/// body must outlive it.
template <int dimensions, class Law>
ElasticTerms make_cells(const Body& body, const Material& material, const Law& law) {
  const AnyAtWork<dimensions> any = [law](const Material& own) {  // kept: constants may change with the rest
    return AnyPoint<dimensions>(detail::at_work<dimensions>(law, own));
  };
  if (has_blocks(body, dimensions)) return make_blocks<dimensions>(body, material, any);
  using Point = decltype(detail::at_work<dimensions>(law, material));
  if constexpr (detail::has_closed_form<dimensions, Law>() || !HasEnergyDensity<Point, dimensions>)
    return detail::make_simplices<dimensions>(body, material, law);
  else
    return detail::make_any_simplices<dimensions>(body, material, any);
}

}  // namespace elastin
