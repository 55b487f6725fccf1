#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/linear/block_inverse.h"
#include "core/parallel/parallel.h"
#include "core/solve/colours.h"
#include "core/solve/implicit.h"
#include "core/solve/outer_forces.h"
#include "core/solve/steppers.h"
#include "elastin/core/laws/local.h"
#include "elastin/core/shapes/cell_shape.h"

namespace elastin {
namespace {

/// Constraints of one colour below these numbers stay on one thread.
constexpr int kSpringThreshold = 10000, kTetrahedronThreshold = 2000;
/// Below this J the volume's energy goes on as a parabola: an inverted tetrahedron comes back.
constexpr double kLeastSwelling = 0.2;

/// What a tetrahedron's two measures are and how its corners change them: c = (√(tr C), J).
struct Measures {
  Eigen::Vector2d value, slope, curvature;  ///< c; of their energies E′ [J], E″ [J]
  Eigen::Matrix<double, 3, 4> gradient[2];  ///< [1/m]
  double turn[2];                           ///< bounds of a corner's part in the gradients' change [1/m²]

  Measures(const NeoHookeanConstraint& cell, const Positions& positions) {
    static constexpr auto pairs = node_pairs<4>();
    Eigen::Matrix<double, 3, 4> x;
    for (int corner = 0; corner < 4; ++corner) x.col(corner) = positions.col(cell.molecules[corner]);
    gradient[0].setZero();
    double trace = 0, most_product = 0;
    for (std::size_t pair = 0; pair < 6; ++pair) {
      const auto [a, b] = pairs[pair];
      const Vector3 d = x.col(a) - x.col(b);
      trace -= cell.rest_products[pair] * d.squaredNorm();
      most_product = std::max(most_product, 2 * std::abs(cell.rest_products[pair]));
      gradient[0].col(a) -= cell.rest_products[pair] * d;
      gradient[0].col(b) += cell.rest_products[pair] * d;
    }
    const double root = std::sqrt(std::max(trace, 1e-12));
    gradient[0] /= root;
    const Vector3 a = x.col(1) - x.col(0), b = x.col(2) - x.col(0), c = x.col(3) - x.col(0);
    gradient[1].col(1) = b.cross(c);
    gradient[1].col(2) = c.cross(a);
    gradient[1].col(3) = a.cross(b);
    gradient[1].col(0) = -(gradient[1].col(1) + gradient[1].col(2) + gradient[1].col(3));
    gradient[1] /= 6 * cell.volume;
    value << root, a.dot(gradient[1].col(1));
    const double J = std::max(value[1], kLeastSwelling), stiffness = cell.lambda + cell.mu / (J * J);
    slope << cell.mu * root, cell.lambda * (J - 1) - cell.mu / J + stiffness * (value[1] - J);
    curvature << cell.mu, stiffness;
    slope *= cell.volume, curvature *= cell.volume;
    double longest = 0;
    for (int corner = 0; corner < 4; ++corner)
      for (int other = 0; other < corner; ++other) longest = std::max(longest, (x.col(corner) - x.col(other)).norm());
    turn[0] = most_product / root, turn[1] = longest / (2 * cell.volume);  // three others, an edge over 6 V each
  }
};

std::string unsuited_for_xpbd(const Model& model) {
  if (!has_local_terms(model))
    return "xpbd projects springs and neo_hookean tetrahedra; a law of this strategy is neither";
  Constraints all;
  for (const auto& law : model.elasticity())
    if (!law->local()->add_constraints(all))
      return "xpbd projects springs with constants ≥ 0 and neo_hookean tetrahedra of first order; other cell laws, "
             "curves and negative constants have no compliance";
  return "";
}

struct XpbdOptions {
  int iterations, substeps;
  bool balanced, in_order;
};

/// Position-based dynamics with compliance: constraint after constraint is projected by what its multiplier lacks,
///   Δλ = −(λ + E′(c)/w_a) / (1 + E″(c)/w_a ∇c·M⁻¹∇c),  x += M⁻¹ ∇c Δλ,  w_a = 1/Δ²,
/// E = ½ k c² for a spring c = l − L, α̃ = w_a/k. Multipliers begin at 0 in each step and are kept through its
/// iterations.                                          [Macklin, Müller & Chentanez 2016; Macklin et al. 2019]
class Xpbd final : public Implicit {
 public:
  explicit Xpbd(const XpbdOptions& options) : Implicit({}, 0, 0), options_(options) {}
  void set_effort(int effort) override { options_.iterations = effort; }

 private:
  void try_step(Model& model, State& state, double dt, StepResult& result) override {
    if (options_.substeps == 1) return Implicit::try_step(model, state, dt, result);
    begin_ = state;
    for (int substep = 0; substep < options_.substeps; ++substep) {
      Implicit::try_step(model, state, dt / options_.substeps, result);
      if (result.outcome == Outcome::converged) continue;
      state = begin_;
      return;
    }
    state.time = begin_.time + dt;
  }

  StaticResult balance(Model& model, State& next, const Kinematics& kinematics) override {
    StaticResult result;
    if (!prepare(model)) {
      result.outcome = Outcome::limit_reached;
      result.cause = unsuited_for_xpbd(model);
      return result;
    }
    const double weight = kinematics.weights.acceleration;
    set_velocities(model, kinematics, next);
    outer_.begin(model, next, kinematics.weights);
    target_.noalias() = kinematics.start - kinematics.accelerations / weight;
    set_inverses(model, weight);
    spring_multipliers_.setZero(static_cast<Eigen::Index>(constraints_.springs.size()));
    cell_multipliers_.setZero(2, static_cast<Eigen::Index>(constraints_.tetrahedra.size()));
    balance_with_multipliers(model, next, kinematics.cut_short, result,
                             [&] { iterate(model, kinematics, next, result); });
    end_sweeps(model, kinematics, next, result);
    return result;
  }

  void iterate(const Model& model, const Kinematics& kinematics, State& next, StaticResult& result) {
    const double weight = kinematics.weights.acceleration;
    for (int iteration = 0; iteration < options_.iterations; ++iteration) {
      const bool first = result.newton_iterations == 0;
      if (!first && outer_.vary()) {
        set_velocities(model, kinematics, next);
        if (iteration == 0)  // multipliers are others now
          outer_.begin(model, next, kinematics.weights);
        else
          outer_.update(model, next, kinematics.weights);
        set_inverses(model, weight);
      }
      if (first || outer_.vary() || options_.balanced) balance_molecules(next.positions, weight, !first);
      project_springs(next.positions, weight);
      project_cells(next.positions, weight);
      ++result.newton_iterations;
    }
  }

  /// w_a (w_a m I + D)⁻¹ of each molecule in its free directions.
  void set_inverses(const Model& model, double weight) {
    const VectorX& mass = model.body().mass;
    const int n = model.body().size();
    inverses_.resize(n);
    for (int i = 0; i < n; ++i)
      inverses_[i] = outer_.vary()
                         ? Matrix3(weight * positive_inverse(weight * mass[i] * Matrix3::Identity() + outer_.block(i)))
                         : Matrix3(Matrix3::Identity() / mass[i]);
    for (const Support& support : model.supports) {
      Matrix3 block = weight * mass[support.molecule] * Matrix3::Identity();
      if (outer_.vary()) block += outer_.block(support.molecule);
      const Matrix3 free = support.free;
      inverses_[support.molecule] = weight * positive_inverse(block, free);
    }
    mass_ = &mass;
  }

  /// Moves each molecule to where its inertia balances loads and multipliers, these along the gradients as they are
  /// now: with the first iteration's alone the step would not end where backward Euler's does. Less far where the
  /// gradients turn much on the way, by a bound of what multipliers and turn make of it.
  void balance_molecules(Positions& positions, double weight, bool with_multipliers) {
    const int n = static_cast<int>(positions.cols());
    residual_.setZero(3, n);
    turns_.setZero(n);
    if (with_multipliers) add_multipliers(positions);
    parallel_for(
        n,
        [&](int i) {
          Vector3 force = outer_.forces().col(i);
          if (outer_.vary()) force -= outer_.block(i) * (positions.col(i) - outer_.positions().col(i));
          const Vector3 missing = (*mass_)[i] * (target_.col(i) - positions.col(i)) + force / weight + residual_.col(i);
          positions.col(i) += (inverses_[i] * missing) / (1 + turns_[i] / (*mass_)[i]);
        },
        kMoleculeThreshold);
  }

  /// Their forces, and twice the sizes of their geometric stiffness on each molecule, both over w_a.
  void add_multipliers(const Positions& positions) {
    for_each_colour(spring_colours_, kSpringThreshold, [&](int c) {
      const SpringConstraint& spring = constraints_.springs[c];
      const auto [a, b] = spring.molecules;
      const Vector3 d = positions.col(b) - positions.col(a);
      const double length = d.norm();
      if (!(length > 0)) return;
      const double density = spring_multipliers_[c] / length;
      residual_.col(b) += density * d;
      residual_.col(a) -= density * d;
      turns_[a] += 2 * std::abs(density);
      turns_[b] += 2 * std::abs(density);
    });
    for_each_colour(cell_colours_, kTetrahedronThreshold, [&](int c) {
      const NeoHookeanConstraint& cell = constraints_.tetrahedra[c];
      const Measures now(cell, positions);
      for (int corner = 0; corner < 4; ++corner) {
        const int molecule = cell.molecules[corner];
        for (int i = 0; i < 2; ++i) residual_.col(molecule) += cell_multipliers_(i, c) * now.gradient[i].col(corner);
        turns_[molecule] += 2 * (std::abs(cell_multipliers_(0, c)) * now.turn[0] +  //
                                 std::abs(cell_multipliers_(1, c)) * now.turn[1]);
      }
    });
  }

  void project_springs(Positions& positions, double weight) {
    for_each_colour(spring_colours_, kSpringThreshold, [&](int c) {
      const SpringConstraint& spring = constraints_.springs[c];
      const auto [a, b] = spring.molecules;
      const Vector3 d = positions.col(b) - positions.col(a);
      const double length = d.norm();
      if (!(length > 0)) return;
      const Vector3 along = d / length;
      const Vector3 of_a = inverses_[a] * along, of_b = inverses_[b] * along;
      const double k = spring.constant / weight;
      const double more =
          -(spring_multipliers_[c] + k * (length - spring.rest_length)) / (1 + k * along.dot(of_a + of_b));
      spring_multipliers_[c] += more;
      positions.col(b) += more * of_b;
      positions.col(a) -= more * of_a;
    });
  }

  /// Both measures of a tetrahedron at once.                                          [Macklin & Müller 2021]
  void project_cells(Positions& positions, double weight) {
    for_each_colour(cell_colours_, kTetrahedronThreshold, [&](int c) {
      const NeoHookeanConstraint& cell = constraints_.tetrahedra[c];
      const Measures now(cell, positions);
      Eigen::Matrix<double, 3, 4> moved[2];
      Eigen::Matrix2d W = Eigen::Matrix2d::Zero();
      for (int corner = 0; corner < 4; ++corner) {
        const Matrix3& inverse = inverses_[cell.molecules[corner]];
        for (int i = 0; i < 2; ++i) {
          moved[i].col(corner) = inverse * now.gradient[i].col(corner);
          for (int j = 0; j < 2; ++j) W(j, i) += now.gradient[j].col(corner).dot(moved[i].col(corner));
        }
      }
      const Eigen::Vector2d lacking = cell_multipliers_.col(c) + now.slope / weight;
      const Eigen::Matrix2d response = Eigen::Matrix2d::Identity() + (now.curvature / weight).asDiagonal() * W;
      const Eigen::Vector2d more = -response.inverse() * lacking;
      cell_multipliers_.col(c) += more;
      for (int corner = 0; corner < 4; ++corner)
        positions.col(cell.molecules[corner]) += more[0] * moved[0].col(corner) + more[1] * moved[1].col(corner);
    });
  }

  /// Constraints stand colour by colour: those of a row follow each other.
  template <class Work>
  static void for_each_colour(const std::vector<int>& starts, int threshold, Work&& work) {
    for (std::size_t colour = 0; colour + 1 < starts.size(); ++colour) {
      const int first = starts[colour];
      parallel_for(
          starts[colour + 1] - first, [&](int i) { work(first + i); }, threshold);
    }
  }

  /// Constraints that may be projected at once: those of a colour, or each alone.
  template <class Molecules>
  Rows rows_of(int constraints, int molecules, const Molecules& molecules_of) const {
    if (!options_.in_order) return colours_of_items(constraints, molecules, molecules_of);
    Rows rows;
    rows.entries.resize(constraints), rows.start.resize(constraints + 1);
    std::iota(rows.entries.begin(), rows.entries.end(), 0);
    std::iota(rows.start.begin(), rows.start.end(), 0);
    return rows;
  }

  /// Colours of the constraints; false where a law has none.
  bool prepare(const Model& model) {
    if (model_ == &model && laws_ == model.elasticity().size() && rest_part_ == model.rest_part()) return suited_;
    model_ = &model;
    rest_part_ = model.rest_part();
    laws_ = model.elasticity().size();
    Constraints all;
    suited_ = unsuited_for_xpbd(model).empty();
    if (!suited_) return false;
    for (const auto& law : model.elasticity()) law->local()->add_constraints(all);
    const int n = model.body().size();
    constraints_ = {};
    const Rows springs = rows_of(static_cast<int>(all.springs.size()), n,
                                 [&](int c) { return std::span<const int>(all.springs[c].molecules); });
    for (const int c : springs.entries) constraints_.springs.push_back(all.springs[c]);
    spring_colours_ = springs.start;
    const Rows cells = rows_of(static_cast<int>(all.tetrahedra.size()), n,
                               [&](int c) { return std::span<const int>(all.tetrahedra[c].molecules); });
    for (const int c : cells.entries) constraints_.tetrahedra.push_back(all.tetrahedra[c]);
    cell_colours_ = cells.start;
    return true;
  }

  XpbdOptions options_;
  const Model* model_ = nullptr;
  std::size_t laws_ = 0;
  double rest_part_ = 1;
  bool suited_ = false;
  const VectorX* mass_ = nullptr;
  Constraints constraints_;
  std::vector<int> spring_colours_, cell_colours_;
  VectorX spring_multipliers_;         ///< λ [kg m]
  Eigen::Matrix2Xd cell_multipliers_;  ///< λ [kg m²]
  std::vector<Matrix3> inverses_;      ///< [1/kg]
  OuterForces outer_;
  Positions target_, residual_;
  VectorX turns_;
  State begin_;
};

}  // namespace

StepperKind xpbd() {
  return {{"xpbd",
           "position-based: springs and neo_hookean tetrahedra as constraints with compliance, in small steps",
           "[Macklin et al. 2016, 2019; Macklin & Müller 2021]",
           {{"iterations", dimension::none, 1, 100000, 1, "iterations over all constraints in each substep", false,
             ValueKind::whole},
            {"substeps", dimension::none, 1, 10000, 10, "substeps of each step; multipliers restart in each", false,
             ValueKind::whole},
            {"balanced", dimension::none, 0, 1, 1,
             "1: each further iteration puts the multipliers back on the gradients of the moment, and converges to "
             "backward Euler's step; 0: as published, without",
             false, ValueKind::whole},
            {"in_order", dimension::none, 0, 1, 0,
             "1: one constraint after another in the body's order, as engines do; 0: colour by colour, on all threads",
             false, ValueKind::whole}}},
          false,
          1,
          [](const ParameterValues& values, const StaticOptions&) {
            return std::make_unique<Xpbd>(XpbdOptions{static_cast<int>(values.at("iterations")),
                                                      static_cast<int>(values.at("substeps")),
                                                      values.at("balanced") != 0, values.at("in_order") != 0});
          },
          unsuited_for_xpbd,
          "iterations"};
}

}  // namespace elastin
