#pragma once
#include <concepts>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/base/types.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"
#include "elastin/core/model/state.h"
#include "elastin/core/model/subdomain.h"

namespace elastin {

class Graph;
class LocalElasticity;

/// Memory for intermediate results of a force pass. It belongs to the caller and only grows: passes over one model
/// allocate nothing after the first.
class Workspace {
 public:
  enum Use { slots, cells, groups, changes, diagonals };
  /// Memory for `size` numbers, with whatever was left there.
  Eigen::Map<VectorX> buffer(Use use, Eigen::Index size) { return grown(numbers_[use], size); }
  /// The same for each part of a parallel pass.
  void reserve_ranges(int ranges) {
    if (static_cast<int>(range_buffers_.size()) < ranges) range_buffers_.resize(ranges);
  }
  Eigen::Map<VectorX> range_buffer(int range, Eigen::Index size) { return grown(range_buffers_[range], size); }

  VectorX force_densities;         ///< [N/m], one a connection
  VectorX squared_lengths, rates;  ///< of its length [m²], [m²/s]
  VectorX scaled;                  ///< one a connection, what one law hands on to another
  VectorX relaxing;                ///< the same, of a law that relaxes

 private:
  static Eigen::Map<VectorX> grown(VectorX& numbers, Eigen::Index size) {
    if (numbers.size() < size) numbers.resize(size);
    return {numbers.data(), size};
  }
  VectorX numbers_[5];
  std::vector<VectorX> range_buffers_;
};

/// Triangles or tetrahedra whose connections influence each other, one after the other, with their slopes ∂q/∂s [N/m³].
struct CellSlopes {
  int sides;                         ///< connections of each: all pairs of its nodes, order 01 02 … 12 …
  std::span<const int> nodes;        ///< of all cells
  std::span<const int> connections;  ///< of all cells
  const double* slopes;              ///< sides × sides a cell, row by row, rows = whose q
  double factor = 1;                 ///< of all slopes

  int size() const { return static_cast<int>(connections.size()) / sides; }
  std::span<const int> connections_of(int cell) const {
    return connections.subspan(static_cast<std::size_t>(cell) * static_cast<std::size_t>(sides),
                               static_cast<std::size_t>(sides));
  }
  const double* slopes_of(int cell) const { return slopes + static_cast<std::ptrdiff_t>(cell) * sides * sides; }
};

/// Quadrature points with what a linearisation stores there. May be called by several threads at once.
class StiffPoints {
 public:
  /// A motion whose gradient in the frame's axes is H, column after column, has the energy ½ Hᵀ stiffness H [J].
  struct Stiffness {
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3> frame;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 9, 9> stiffness;
  };
  virtual ~StiffPoints() = default;
  virtual int stiff_points() const = 0;
  virtual Vector3 place_of(int point) const = 0;               ///< at rest [m]
  virtual std::span<const int> nodes_of(int point) const = 0;  ///< molecules of its cell
  virtual Stiffness stiffness_at(int point) const = 0;
};

/// What one cell of a body feels in one state: means over it. Zero where the cell is flat, at rest or now.
struct CellState {
  Matrix3 strain = Matrix3::Zero();  ///< Green–Lagrange E = (Fᵀ F − I) / 2; of a membrane, in the plane of its rest
  Matrix3 stress = Matrix3::Zero();  ///< Cauchy's [Pa]; of a membrane, force over width [N/m]
};

/// What a solid feels at one quadrature point of a cell.
struct PointState {
  Vector3 position = Vector3::Zero();  ///< present [m]
  double volume = 0;                   ///< the part of the cell's present volume that the point stands for [m³]
  Matrix3 stress = Matrix3::Zero();    ///< Cauchy's [Pa]
};

/// Of a triangle or tetrahedron that is strained uniformly: its corners without stress and now [m], a column each, and
/// the force densities [N/m] of its own sides, in the order 01 02 …; none: no stress.
CellState simplex_state(const Eigen::Ref<const Positions>& unstressed, const Eigen::Ref<const Positions>& now,
                        std::span<const double> force_densities);

/// The tangent of one elastic law at one state. With s = |d|² and d = x_b − x_a, the change of a connection's force is
/// δq d + q δd, δq = Σ (∂q/∂s) δs, δs = 2 d·δd; forces at nodes have a stiffness of their own.
class Linearisation {
 public:
  virtual ~Linearisation() = default;
  /// Stores what the other functions need. Allocates nothing after the first call.
  virtual void linearise_at(const Positions& positions) = 0;
  /// Whether it has the following, see Tangent::linearise_onward.
  virtual bool predicts() const { return false; }
  /// The same at `to`, but by the strains that are linear in the motion from `from`; by those that are there, where no
  /// body could have these.
  virtual void linearise_onward(const Positions& /*from*/, const Positions& to) { linearise_at(to); }
  /// Calls visit(a, b, part) for parts of the 3×3 blocks of the stiffness [N/m]: of nodal forces for all of it, of edge
  /// densities for what neither the densities, nor own slopes, nor visit_cells give.
  using BlockVisitor = std::function<void(int a, int b, const Matrix3& block)>;
  virtual void visit_blocks(const BlockVisitor&) const {}
  /// Calls visit(a, part) for parts of the diagonal ones of those blocks.
  using DiagonalVisitor = std::function<void(int a, const Matrix3& block)>;
  virtual void visit_diagonal(const DiagonalVisitor&, Workspace&) const {}
  /// Of those blocks, what a coarser grid over the body can use: calls visit(g, factor) for parts factor · (Σ g_a·x_a)²
  /// / 2 of the energy, g a list of molecules and vectors whose sum is zero. False where visit_blocks has more terms
  /// than these and the quadrature points.
  using GradientVisitor = std::function<void(std::span<const std::pair<int, Vector3>> gradient, double factor)>;
  virtual bool visit_gradients(const GradientVisitor&) const { return true; }
};

/// The slopes ∂q/∂s [N/m³] of force densities.
class EdgeSlopes : public Linearisation {
 public:
  /// Adds the slope of each connection with respect to its own s.
  virtual void add_own_slopes(VectorX& slopes) const = 0;
  /// Adds the coupled part of δq from δs. Allocates nothing once `workspace` has served.
  virtual void add_change(const VectorX& /*change_of_squared_lengths*/, VectorX& /*change_of_force_densities*/,
                          Workspace&) const {}
  /// After linearise_onward: adds the densities by those strains, and those that a law which is linear about them has
  /// at `to`.
  virtual void add_onward(const Positions& /*from*/, const Positions& /*to*/, VectorX& /*predicted*/,
                          VectorX& /*linear*/, Workspace&) const {}
  /// Calls visit(cells) for all cells of each law and shape at once; couplings too wide for dense slopes have
  /// visit_blocks instead.
  using CellVisitor = std::function<void(const CellSlopes& cells)>;
  virtual void visit_cells(const CellVisitor&) const {}
};

/// The stiffness of nodal forces.
class NodalStiffness : public Linearisation {
 public:
  /// Adds K motion [N].
  virtual void add_stiffness(const Positions& motion, Positions& result, Workspace& workspace) const = 0;
  /// After linearise_onward: adds the forces [N] at `to` of a law that is linear about those strains.
  virtual void add_onward_forces(const Positions& /*from*/, const Positions& /*to*/, Positions& /*forces*/,
                                 Workspace&) const {}
  /// Calls visit(points) for the quadrature points of each law and shape.
  using PointsVisitor = std::function<void(const StiffPoints& points)>;
  virtual void visit_points(const PointsVisitor&) const {}
};

/// An elastic law on one body: an energy and forces. A law of force densities is an EdgeDensities, one of cells of
/// other shapes a NodalForces; one with a history is a LawHistory, too.
class Elasticity {
 public:
  virtual ~Elasticity() = default;
  virtual std::unique_ptr<Elasticity> clone() const = 0;
  /// The same law on a subdomain of the body that it was made for: those of its elements that the subdomain computes.
  /// The subdomain must outlive it. Null where the law cannot be shared out: it has a history, or no elements.
  virtual std::unique_ptr<Elasticity> on_subdomain(const Subdomain&) const { return nullptr; }

  /// Whether forces come from an energy; if not, the tangent need not be symmetric and energy() is 0.
  virtual bool has_energy() const { return true; }
  /// Whether the linearisation is the whole derivative, or (angles_update) leaves a term out.
  virtual bool has_full_tangent() const { return true; }
  /// Whether it takes energy from a body that moves, so that energy() is not all that became of the work done.
  virtual bool dissipates() const { return false; }
  /// Makes a part of what Body::unstressed says count: all of it, 1, until this is called.
  virtual void set_rest(double /*part*/) {}
  /// Stored energy [J]; +infinity where a cell is flat or inverted.
  virtual double energy(const Positions& positions) const = 0;
  /// Energy that the body has stored [J] in a state that commit_step() has seen last, or begin_step() over no time:
  /// what could still be had back. energy() of a law that relaxes is what the next step minimises.
  virtual double stored_energy(const Positions& positions) const { return energy(positions); }
  /// For visualisation: calls visit(molecules, state) for each cell that the law has a stress in, in the body's order.
  using StateVisitor = std::function<void(std::span<const int> molecules, const CellState& state)>;
  /// Whether no cell is flat or inverted. Energies are +infinity where not; laws without an energy say it here.
  virtual bool admissible(const Positions& /*positions*/) const { return true; }
  /// Adds the force on each molecule [N]. `graph` is that of the body. Bitwise identical on any number of threads.
  virtual void add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                          Workspace& workspace) const = 0;
  /// The law as a sum over elements, see laws/local.h; null where it has no energy, or a history.
  virtual const LocalElasticity* local() const { return nullptr; }
};

/// A law whose force on molecule a is Σ_b q_ab (x_b − x_a): one number per connection, its force density q [N/m].
/// [Schek 1974] Springs have a slope of their own; cells couple the connections of one cell.
class EdgeDensities : public Elasticity {
 public:
  /// Adds each connection's force density [N/m].
  virtual void add_force_densities(const Positions& positions, VectorX& force_densities,
                                   Workspace& workspace) const = 0;
  /// Sets the size of each connection's force density [N/m], of one that is a sum that may cancel the sizes of its
  /// parts together: what rounding is judged by. `sizes` has a number for each connection.
  virtual void set_part_sizes(const Positions& positions, VectorX& sizes, Workspace& workspace) const;
  /// The force densities, separated: laws of triangles add each triangle's own share [N/m] to a column of
  /// `of_triangles`, order 01 02 12, a column for each triangle of the body that they were made for; all others add to
  /// the connections.
  virtual void add_triangle_force_densities(const Positions& positions, Eigen::Ref<Eigen::Matrix3Xd> of_triangles,
                                            VectorX& of_connections, Workspace& workspace) const;
  /// Calls `visit` (see StateVisitor), and adds to `others` [N/m] the force densities that this leaves out: all, of a
  /// law that has no cells.
  virtual void show(const Positions& positions, VectorX& others, const StateVisitor& visit) const;
  /// Through the force densities, unless the law has a shorter way.
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                  Workspace& workspace) const override;
  /// Whether connections influence each other; if not, EdgeSlopes has own slopes alone.
  virtual bool coupled() const { return false; }
  /// To be linearised. The law must outlive it.
  virtual std::unique_ptr<EdgeSlopes> slopes() const = 0;
};

/// A law whose forces are found at the nodes of cells, without force densities.
class NodalForces : public Elasticity {
 public:
  /// Sum of the sizes of the forces within the body [N]: what rounding is judged by.
  virtual double internal_force(const Positions& positions) const = 0;
  /// Calls `visit` (see StateVisitor), and adds the force density q_ab = −Σ_g w_g B_aᵀ S_g B_b [N/m] of those pairs of
  /// a cell's nodes that are connections (other pairs have theirs too).
  virtual void show(const Positions& positions, VectorX& force_densities, const StateVisitor& visit) const = 0;
  /// Calls visit(molecules, state) for each quadrature point of each cell of a solid, cell by cell.
  using PointVisitor = std::function<void(std::span<const int> molecules, const PointState& state)>;
  virtual void show_points(const Positions&, const PointVisitor&) const {}
  /// From now on the stresses at its points relax (see make_prony). False where they cannot.
  virtual bool relax(const Relaxation&) { return false; }
  /// To be linearised. The law must outlive it.
  virtual std::unique_ptr<NodalStiffness> stiffness() const = 0;
};

/// A law with a history from step to step.
class LawHistory {
 public:
  virtual ~LawHistory() = default;
  /// The history at the beginning: blocks whose names begin with `name`.
  virtual std::vector<HistoryBlock> history(const std::string& name) const = 0;
  /// Until the next call forces, energy and tangent are those at the end of a step from a state to a time [s];
  /// infinite: those of a body that has had all time. Allocates nothing.
  virtual void begin_step(const std::string& name, const State& from, double time) = 0;
  /// Called with each state that was reached, at the end of a step: changes State::history, and is ready for what
  /// follows. A state at the time of the one before counts as one that has had all time.
  virtual void commit_step(const std::string& name, State& state) = 0;
};

/// A law with a history of one block that knows what a function m of later states changes with: slopes
/// ∂m/∂(number of the block), in the block's order. Of a step from a state with the block `from` to a time [s].
class TransposedHistory {
 public:
  virtual ~TransposedHistory() = default;
  /// Of LawHistory::commit_step: slopes by the block at the end become those by `from`, and those by the positions at
  /// the end are added.
  virtual void transpose_commit(const HistoryBlock& from, double time, const Positions& positions,
                                std::vector<double>& slopes, Positions& of_positions) const = 0;
  /// Adds what m has by `from` through the forces f within the step, of which it has λ·δf.
  virtual void transpose_forces(const HistoryBlock& from, double time, const Positions& positions,
                                const Positions& lambda, std::vector<double>& slopes) const = 0;
};

/// A law that can soften (see make_mullins).
class Softens {
 public:
  virtual ~Softens() = default;
  /// From now on it softens. False where there is no energy to go by: then nothing changed.
  virtual bool soften(const Softening&) = 0;
  virtual bool softened() const = 0;  ///< whether it does
};

/// Laws that act together on one body, as a strategy makes them: none, one or several.
struct ElasticTerms {
  ElasticTerms() = default;
  template <std::derived_from<Elasticity> Law>
  ElasticTerms(std::unique_ptr<Law> one) {
    if (one) terms.push_back(std::move(one));
  }
  /// Adds those of another strategy, each of which was made for all triangles.
  void add(ElasticTerms more) {
    for (auto& term : more.terms) terms.push_back(std::move(term));
    owners.insert(owners.end(), more.owners.begin(), more.owners.end());
  }
  bool empty() const { return terms.empty(); }

  std::vector<std::unique_ptr<Elasticity>> terms;
  std::vector<CellRange> triangles;  ///< of the body, for which each term was made; empty: all terms for all
  std::vector<std::shared_ptr<const void>> owners;  ///< of what the terms work on
};

/// Springs: q = k (1 − L/l), energy ½ k (l − L)². `constants` [N/m], one a connection, may be negative.
std::unique_ptr<Elasticity> make_springs(const Body& body, VectorX constants);

/// Springs that follow a curve P of their own strain ε: tension w L P(ε). `sections` w [m], one a connection: the
/// spring constant at rest is w P′(0).
std::unique_ptr<Elasticity> make_curve_springs(const Body& body, VectorX sections, const StressStrain& curve);

/// Springs of these constants [N/m] at rest, each following the material's curve of its own strain; linear without one.
std::unique_ptr<Elasticity> make_springs(const Body& body, VectorX constants, const Material& material);

/// Springs whose constants are updated from the present positions; the tangent leaves their change out.
using ConstantsAt = std::function<VectorX(const Positions&)>;
std::unique_ptr<Elasticity> make_updated_springs(const Body& body, ConstantsAt constants);

/// The body's cables: tension EA ε at a strain ε above 0, none below.
std::unique_ptr<Elasticity> make_cables(const Body& body);

}  // namespace elastin
