#include "elastin/core/forces/muscle.h"

#include <cmath>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/cells.h"

namespace elastin {
namespace {

/// W = T ∫ f/r dr, S = (T f/λ²) a aᵀ, ∂S/∂C = (T f′/(λ_opt λ) − 2 T f/λ²)/(2 λ²) a aᵀ a aᵀ.
struct ActiveLaw {
  static constexpr std::string_view name = "muscle";
  static constexpr std::string_view summary = "the material's active fibres, added to the law of the matrix; solids";
  static constexpr std::string_view source = "[Blemker, Pinsky & Delp 2005]";

  struct Solid {
    Vector3 direction;  ///< a, unit
    double largest, optimal_stretch;
    std::shared_ptr<const double> activation;

    Matrix3 stress(const Matrix3& A) const {
      const double square = squared_stretch(A);
      return tension() * now(square).value / square * direction * direction.transpose();
    }
    TangentModuli<3> tangent(const Matrix3& A) const {
      const double square = squared_stretch(A), stretch = std::sqrt(square);
      const auto [value, slope, work] = now(square);
      const double change = tension() * (slope / (optimal_stretch * stretch) - 2 * value / square) / (2 * square);
      const Vector3& a = direction;
      Eigen::Matrix<double, 6, 1> along;
      along << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[0] * a[1], a[0] * a[2], a[1] * a[2];
      return change * along * along.transpose();
    }
    double energy(const Matrix3& A) const { return tension() * now(squared_stretch(A)).work; }

   private:
    double tension() const { return largest * *activation; }
    double squared_stretch(const Matrix3& A) const { return std::max(1 + direction.dot(A * direction), 1e-14); }
    ForceLength now(double square) const { return force_length(std::sqrt(square) / optimal_stretch); }
  };

  std::shared_ptr<const double> activation;
  Solid solid(const Material& material) const {
    return {material.active->direction, material.active->stress, material.active->optimal_stretch, activation};
  }
};

/// Sets the activation at the end of each step; has no forces of its own.
class Activation final : public Elasticity, public LawHistory {
 public:
  Activation(std::shared_ptr<double> level, std::function<double(double)> function)
      : level_(std::move(level)), function_(std::move(function)) {
    set(0);
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<Activation>(*this); }
  double energy(const Positions&) const override { return 0; }
  void add_forces(const Positions&, const Graph&, Positions&, Workspace&) const override {}
  bool dissipates() const override { return true; }
  std::vector<HistoryBlock> history(const std::string&) const override { return {}; }
  void begin_step(const std::string&, const State& from, double time) override {
    set(std::isfinite(time) ? time : from.time);
  }
  void commit_step(const std::string&, State& state) override { set(state.time); }

 private:
  void set(double time) {
    const double level = function_ ? function_(time) : 1;
    if (!std::isfinite(level))
      throw InputError("the activation of the muscle at t = " + number(time) + " s is not finite");
    *level_ = std::max(0., level);
  }

  std::shared_ptr<double> level_;
  std::function<double(double)> function_;
};

}  // namespace

ForceLength force_length(double stretch) {
  const auto below = [](double r) { return 9 * (r * r / 2 - 0.8 * r + 0.16 * std::log(r)); };
  const auto middle = [](double r) { return 8 * r - 2 * r * r - 3 * std::log(r); };
  const auto above = [](double r) { return 9 * (r * r / 2 - 3.2 * r + 2.56 * std::log(r)); };
  static const double to_middle = below(0.6) - below(0.4), to_above = to_middle + middle(1.4) - middle(0.6);
  const double r = stretch;
  if (!(r > 0.4)) return {0, 0, 0};
  if (r <= 0.6) return {9 * (r - 0.4) * (r - 0.4), 18 * (r - 0.4), below(r) - below(0.4)};
  if (r < 1.4) return {1 - 4 * (1 - r) * (1 - r), 8 * (1 - r), to_middle + middle(r) - middle(0.6)};
  if (r < 1.6) return {9 * (r - 1.6) * (r - 1.6), 18 * (r - 1.6), to_above + above(r) - above(1.4)};
  return {0, 0, to_above + above(1.6) - above(1.4)};
}

void check_active_fibre(const ActiveFibre& active) {
  if (!(active.stress > 0) || !std::isfinite(active.stress))
    throw InputError("active: a stress of " + number(active.stress) + " Pa must be above 0");
  if (!(active.optimal_stretch > 0) || !std::isfinite(active.optimal_stretch))
    throw InputError("active: an optimal_stretch of " + number(active.optimal_stretch) + " must be above 0");
}

ElasticTerms make_muscle(const Body& body, const Material& material) {
  check_active_fibre(*material.active);
  const auto level = std::make_shared<double>(1);
  ElasticTerms both = std::make_unique<Activation>(level, material.active->activation);
  both.add(make_cells<3>(body, material, ActiveLaw{level}));
  return both;
}

}  // namespace elastin
