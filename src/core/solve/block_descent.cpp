#include <algorithm>
#include <cmath>
#include <limits>

#include "core/linear/block_inverse.h"
#include "core/parallel/parallel.h"
#include "core/solve/colours.h"
#include "core/solve/implicit.h"
#include "core/solve/mixing.h"
#include "core/solve/outer_forces.h"
#include "core/solve/steppers.h"
#include "elastin/core/laws/local.h"

namespace elastin {
namespace {

/// Molecules of one colour below this number stay on one thread: each costs as much as some 30 connections.
constexpr int kColourThreshold = 1500;
/// A motion that changes an element by more than this part goes only as far as the energy falls.
constexpr double kLargeChange = 0.2;
constexpr int kHalvings = 20;
/// So few sweeps are not worth what mixing them takes.
constexpr int kBeforeMixing = 4;

constexpr const char* kUnsuited =
    "block_descent takes energies of connections and cells one by one: springs with constants or curves, cell laws "
    "with "
    "an energy; not springs whose constants are updated, prony, bending, nor +volume of springs and first-order cells";

/// The elements of one law at each molecule.
struct TermSlots {
  const LocalElasticity* term;
  std::vector<int> start;
  std::vector<LocalSlot> slots;
  std::span<const LocalSlot> of(int molecule) const {
    return {slots.data() + start[molecule], static_cast<std::size_t>(start[molecule + 1] - start[molecule])};
  }
};

TermSlots slots_of(const LocalElasticity& term, int molecules) {
  TermSlots result{&term, std::vector<int>(static_cast<std::size_t>(molecules) + 1, 0), {}};
  for (int element = 0; element < term.elements(); ++element)
    for (const int molecule : term.molecules_of(element)) ++result.start[molecule + 1];
  for (int molecule = 0; molecule < molecules; ++molecule) result.start[molecule + 1] += result.start[molecule];
  result.slots.resize(result.start.back());
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  for (int element = 0; element < term.elements(); ++element) {
    int node = 0;
    for (const int molecule : term.molecules_of(element)) result.slots[next[molecule]++] = {element, node++};
  }
  return result;
}

struct DescentOptions {
  int sweeps;
  double tolerance, spectral_radius;
  int mixing;
};

/// Vertex block descent: Φ(x) = w_a/2 |x − y|²_M + W(x) + loads is lowered one molecule after the other, by Newton's
/// step of its own three coordinates. Pairs of sweeps, there and back, are mixed as far as that lowers Φ.
///                                                                                                 [Chen et al. 2024]
class BlockDescent final : public Implicit {
 public:
  explicit BlockDescent(const DescentOptions& options)
      : Implicit({}, 0, 0), options_(options), mixing_(options.mixing) {}
  void set_effort(int effort) override { options_.sweeps = effort; }

 private:
  StaticResult balance(Model& model, State& next, const Kinematics& kinematics) override {
    StaticResult result;
    if (!prepare(model)) {
      result.outcome = Outcome::limit_reached;
      result.cause = kUnsuited;
      return result;
    }
    set_velocities(model, kinematics, next);
    outer_.begin(model, next, kinematics.weights);
    inertia_.noalias() = kinematics.start - kinematics.accelerations / kinematics.weights.acceleration;  // y
    choose_start(model, next, kinematics);
    balance_with_multipliers(model, next, kinematics.cut_short, result,
                             [&] { descend(model, next, kinematics, result); });
    end_sweeps(model, kinematics, next, result);
    return result;
  }

  /// The first guess, as if nothing changed, may be strained more than the body can pay for: sweeps that are too few
  /// would leave that. It is shortened, down to where the body was, until Φ is not above Φ there.
  void choose_start(const Model& model, State& next, const Kinematics& kinematics) {
    before_ = next.positions;
    trial_ = kinematics.start;
    for (const Support& support : model.supports) trial_.col(support.molecule) = before_.col(support.molecule);
    const double limit = potential(model, trial_, kinematics.weights.acceleration);
    for (const double part : {1., 0.5, 0.25, 0.125}) {
      next.positions = trial_ + part * (before_ - trial_);
      if (potential(model, next.positions, kinematics.weights.acceleration) <= limit) return;
    }
    next.positions = trial_;
  }

  double potential(const Model& model, const Positions& positions, double weight) const {
    const double outer = ordered_sum(
        static_cast<int>(positions.cols()),
        [&](int i) {
          const Vector3 off = positions.col(i) - outer_.positions().col(i);
          return weight / 2 * (*mass_)[i] * (positions.col(i) - inertia_.col(i)).squaredNorm() -
                 outer_.forces().col(i).dot(positions.col(i)) +
                 (outer_.vary() ? off.dot(outer_.block(i) * off) / 2 : 0);
        },
        0., kMoleculeThreshold);
    return outer + model.elastic_energy(positions);
  }

  void descend(Model& model, State& next, const Kinematics& kinematics, StaticResult& result) {
    if (result.newton_iterations > 0) {  // multipliers are others now
      set_velocities(model, kinematics, next);
      outer_.begin(model, next, kinematics.weights);
    }
    double omega = 1, last = std::numeric_limits<double>::infinity();
    int accelerated = 0;
    // A pair begins where the one before it was mixed to.
    const bool mixes = options_.mixing > 0 && options_.sweeps > kBeforeMixing;
    if (mixes) mixing_.begin(next.positions.cols());
    for (int sweep = 0; sweep < options_.sweeps; ++sweep) {
      if (mixes && sweep % 2 == 0) pair_start_ = next.positions;
      if (outer_.vary() && sweep > 0) {
        set_velocities(model, kinematics, next);
        outer_.update(model, next, kinematics.weights);
      }
      const bool chebyshev = options_.spectral_radius > 0;
      if (chebyshev) before_ = next.positions;
      const double most = this->sweep(next.positions, kinematics.weights.acceleration, sweep % 2 == 1);
      ++result.newton_iterations;
      result.residual = most / length_;
      if (!std::isfinite(most) || most <= options_.tolerance * length_) break;
      if (mixes && sweep % 2 == 1 && sweep + 1 < options_.sweeps) mix(model, next, kinematics);
      if (!chebyshev) continue;
      // Restarted where a sweep moves further than the one before it.             [Wang 2015, eq. 14]
      accelerated = most > last ? 0 : accelerated + 1;
      last = most;
      const double square = options_.spectral_radius * options_.spectral_radius;
      omega = accelerated < 2 ? 1 : accelerated == 2 ? 2 / (2 - square) : 4 / (4 - square * omega);
      if (omega > 1) extrapolate(model, omega, next.positions);
      older_ = before_;
    }
  }

  /// Goes to where the last pairs of sweeps point, where Φ is no higher there.
  void mix(const Model& model, State& next, const Kinematics& kinematics) {
    trial_ = next.positions - pair_start_;
    if (!mixing_.mix(pair_start_, trial_)) return;
    trial_ += pair_start_;
    for (const Support& support : model.supports) {
      const Matrix3 held = Matrix3::Identity() - support.free;
      trial_.col(support.molecule) += held * (next.positions.col(support.molecule) - trial_.col(support.molecule));
    }
    const double weight = kinematics.weights.acceleration;
    if (potential(model, trial_, weight) <= potential(model, next.positions, weight)) std::swap(trial_, next.positions);
  }

  /// x ← ω (x − x₋₂) + x₋₂, where that inverts no cell.
  void extrapolate(const Model& model, double omega, Positions& positions) {
    trial_ = positions;
    trial_ += (omega - 1) * (positions - older_);
    for (const Support& support : model.supports) trial_.col(support.molecule) = positions.col(support.molecule);
    if (model.admissible(trial_)) std::swap(trial_, positions);
  }

  /// All molecules once, colour by colour. The largest motion [m].
  double sweep(Positions& positions, double weight, bool backwards) {
    double most = 0;
    const int count = static_cast<int>(colours_.start.size()) - 1;
    for (int number = 0; number < count; ++number) {
      const auto molecules = colours_[backwards ? count - 1 - number : number];
      const double own = largest_of_ranges(
          static_cast<int>(molecules.size()),
          [&](int begin, int end) {
            double largest = 0;
            for (int i = begin; i < end; ++i) largest = std::max(largest, move(positions, weight, molecules[i]));
            return largest;
          },
          kColourThreshold);
      most = std::max(most, own);
    }
    return most;
  }

  /// One molecule to where its own energy is least, nearly; how far [m].
  double move(Positions& positions, double weight, int molecule) const {
    const int support = support_of_[molecule];
    if (support >= 0 && (*supports_)[support].free.isZero(0)) return 0;
    LocalBlock block;
    const double inertia = weight * (*mass_)[molecule];
    const Vector3 position = positions.col(molecule);
    block.gradient = inertia * (position - inertia_.col(molecule)) - outer_.forces().col(molecule);
    if (outer_.vary()) {
      block.gradient += outer_.block(molecule) * (position - outer_.positions().col(molecule));
      block.hessian = outer_.block(molecule);
    }
    block.hessian.diagonal().array() += inertia;
    for (const TermSlots& term : terms_) term.term->add_blocks(positions, term.of(molecule), block);
    if (support >= 0) {
      const Matrix3& free = (*supports_)[support].free;
      block.gradient = (free * block.gradient).eval();
      block.hessian = (free * block.hessian * free).eval();
    }
    Vector3 motion = -(positive_inverse(block.hessian) * block.gradient);
    double change = 0;
    for (const TermSlots& term : terms_)
      change = std::max(change, term.term->relative_change(positions, term.of(molecule), motion));
    if (!(change <= kLargeChange)) limit(positions, weight, molecule, motion);
    positions.col(molecule) = position + motion;
    return motion.norm();
  }

  /// Halves the motion until the molecule's own energy falls.
  void limit(Positions& positions, double weight, int molecule, Vector3& motion) const {
    const Vector3 from = positions.col(molecule);
    const double before = energy(positions, weight, molecule);
    for (int halving = 0; halving < kHalvings; ++halving, motion /= 2) {
      positions.col(molecule) = from + motion;
      const double now = energy(positions, weight, molecule);
      positions.col(molecule) = from;
      if (now <= before || !std::isfinite(before)) return;
    }
    motion.setZero();
  }

  double energy(const Positions& positions, double weight, int molecule) const {
    const Vector3 position = positions.col(molecule);
    double sum = weight * (*mass_)[molecule] / 2 * (position - inertia_.col(molecule)).squaredNorm() -
                 outer_.forces().col(molecule).dot(position);
    if (outer_.vary()) {
      const Vector3 off = position - outer_.positions().col(molecule);
      sum += off.dot(outer_.block(molecule) * off) / 2;
    }
    for (const TermSlots& term : terms_)
      for (const LocalSlot& slot : term.of(molecule)) sum += term.term->element_energy(positions, slot.element);
    return sum;
  }

  /// What stays the same from step to step of one model. False where a law is no sum over elements.
  bool prepare(const Model& model) {
    const int n = model.body().size();
    if (model_ != &model || laws_ != model.elasticity().size()) {
      model_ = &model;
      laws_ = model.elasticity().size();
      mass_ = &model.body().mass;
      length_ = mean_length(model.body());
      suited_ = has_local_terms(model);
      if (!suited_) return false;
      terms_.clear();
      std::vector<std::pair<const LocalElasticity*, int>> elements;
      for (const auto& law : model.elasticity()) {
        const LocalElasticity* term = law->local();
        terms_.push_back(slots_of(*term, n));
        for (int element = 0; element < term->elements(); ++element) elements.emplace_back(term, element);
      }
      colours_ = colours_of_molecules(n, static_cast<int>(elements.size()), [&](int element) {
        const auto& [term, own] = elements[element];
        return term->molecules_of(own);
      });
    }
    supports_ = &model.supports;
    support_of_.assign(n, -1);
    for (std::size_t i = 0; i < model.supports.size(); ++i)
      support_of_[model.supports[i].molecule] = static_cast<int>(i);
    return suited_;
  }

  DescentOptions options_;
  const Model* model_ = nullptr;
  std::size_t laws_ = 0;
  bool suited_ = false;
  const VectorX* mass_ = nullptr;
  const std::vector<Support>* supports_ = nullptr;
  double length_ = 0;
  std::vector<TermSlots> terms_;
  Rows colours_;
  std::vector<int> support_of_;
  OuterForces outer_;
  Mixing mixing_;
  Positions inertia_, before_, older_, trial_, pair_start_;
};

}  // namespace

bool has_local_terms(const Model& model) {
  return std::all_of(model.elasticity().begin(), model.elasticity().end(),
                     [](const auto& law) { return law->local() != nullptr; });
}

StepperKind block_descent() {
  return {{"block_descent",
           "backward Euler's step by sweeps over single molecules: stable at any number of them",
           "[Chen et al. 2024]",
           {{"sweeps", dimension::none, 1, 100000, 20, "most sweeps over all molecules in each step", false,
             ValueKind::whole},
            {"tolerance", dimension::none, 0, 1, 0,
             "largest motion of a sweep, over the mean length of connections, at which a step ends; 0: after all "
             "sweeps"},
            {"chebyshev", dimension::none, 0, 0.9999, 0,
             "spectral radius of the sweeps that Chebyshev's acceleration assumes; 0: no acceleration"},
            {"mixing", dimension::none, 0, Mixing::kMost, 5,
             "last pairs of sweeps that are mixed (Anderson), where that lowers the energy; 0: none, and none with "
             "chebyshev",
             false, ValueKind::whole}}},
          false,
          1,
          [](const ParameterValues& values, const StaticOptions&) {
            const double chebyshev = values.at("chebyshev");
            return std::make_unique<BlockDescent>(
                DescentOptions{static_cast<int>(values.at("sweeps")), values.at("tolerance"), chebyshev,
                               chebyshev > 0 ? 0 : static_cast<int>(values.at("mixing"))});
          },
          [](const Model& model) -> std::string { return has_local_terms(model) ? "" : kUnsuited; },
          "sweeps"};
}

}  // namespace elastin
