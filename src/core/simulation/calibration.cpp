#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/dense.h"
#include "core/forces/volume.h"
#include "core/geometry/boundary.h"
#include "core/model/faces.h"
#include "core/simulation/volume_fit.h"
#include "core/solve/responses.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/homogenisation.h"

namespace elastin {
namespace {

std::string calibrated_unsuited(const Strategy& rule, const Body& body) {
  std::string why = rule.unsuited(body);
  if (why.empty() && !body.parts.empty()) why = "several bodies are calibrated together in a scene's experiment alone";
  if (why.empty() && body.connection_stiffness.size())
    why = "a body with regions, or with boxes that are filled in part, has no one modulus to calibrate to";
  return why;
}

/// Where molecules of a box lie behind its sides, as in a packing, those within half a mean connection belong to them.
Surface outer_surface(const Body& body) {
  const Matrix3 axes = body.tetrahedra.empty() ? box_axes(body).value_or(Matrix3::Identity()) : Matrix3::Identity();
  try {
    return find_surface(body, axes, 0);
  } catch (const InputError&) {
    const auto begin = body.connections.rest_length.begin();
    const int count = body.connections.proper();
    if (!body.tetrahedra.empty() || !body.triangles.empty() || count == 0) throw;
    return find_surface(body, axes, std::accumulate(begin, begin + count, 0.) / (2 * count));
  }
}

/// Fits springs and volume term to the material by the moduli that the body's surface shows.
FittedSprings scaled(const std::string& word, const Strategy& rule, const Body& body, const Material& material,
                     const ParameterValues& values) {
  const auto fail = [&](const std::string& cause) {
    throw InputError("'" + word + ":" + rule.name + "' on this body: " + cause);
  };
  FittedSprings found{rule.constants(body, material, values), 0};
  if (!found.constants.allFinite()) fail("a spring constant is not finite");
  Surface surface;
  try {
    surface = outer_surface(body);
  } catch (const InputError& error) {
    fail(std::string("there is no solid to measure: ") + error.what());
  }
  std::string trouble = "its stiffness is singular or not positive: there is no modulus to calibrate to";
  const auto measured = [&](double volume_modulus) -> std::optional<std::pair<double, double>> {
    Model model(body);
    model.add(make_springs(body, found.constants));
    if (rule.volume_modulus) model.add(make_volume(body, volume_modulus));
    model.set_rest(0);
    for (const int molecule : surface.molecules) model.supports.push_back({molecule});
    const Homogenised of_body =
        homogenise(model, surface.molecules, surface.volume, body.rest, Matrix3::Identity(), {.linear = true});
    if (of_body.result.outcome != Outcome::converged) trouble = of_body.result.cause;
    const auto compliance = compliance_of(of_body.stiffness);
    if (!compliance) return std::nullopt;
    const Stiffness6 symmetric = (of_body.stiffness + of_body.stiffness.transpose()) / 2;
    const IsotropicMeans means = isotropic_means(symmetric, *compliance);
    return std::pair{means.youngs(), means.poissons_ratio()};
  };
  double factor = 0;
  if (!rule.volume_modulus) {
    const auto moduli = measured(0);
    if (moduli) factor = material.youngs_modulus / moduli->first;
  } else if (const auto fit = fit_volume(material, measured)) {
    factor = fit->spring_factor;
    found.volume_modulus = fit->volume_modulus;
  }
  if (!(factor > 0)) fail(trouble);
  found.constants *= factor;
  return found;
}

constexpr int kMostSteps = 40;
constexpr double kMet = 1e-3;     ///< relative, of all moduli together: fitted
constexpr double kSaid = 0.01;    ///< what is further off is said
constexpr double kNear = 1e-6;    ///< weight of |ln k/k₀|², over that of the moduli
constexpr double kBounds = 0.01;  ///< weight of the moduli under uniform stress, where tension is measured as well

/// Small loads on a body, each of displacements on the same supports and forces.
struct LoadCases {
  std::vector<Support> supports;
  std::vector<Positions> displacements, forces;  ///< [m], [N], 3 × n; one of either a load
};

/// A body whose moduli are energies under small loads: their changes with the spring constants are known with them.
class ModuliOfBody {
 public:
  ModuliOfBody(const Body& body, const Strategy& rule, const Material& target);
  /// Moduli over those of the target, less 1, those that are to be met first; and their derivatives by ln k, one row
  /// each.
  struct Misses {
    VectorX values;
    MatrixX slopes;
  };
  Misses misses(const VectorX& constants, double volume_modulus) const;
  /// The number of moduli that are to be met.
  int wanted() const { return tension_.empty() ? 21 : 21 + 3 * static_cast<int>(tension_[0].forces.size()); }
  /// Leaves out what loads the surface, which cannot be where a molecule of it hangs on connections that bear no force
  /// across them.
  void leave_out_loads() {
    stress_ = {};
    for (LoadCases& tension : tension_) tension.forces.resize(1);
  }
  /// Those that are off, in words, or "".
  std::string remains(const VectorX& constants, double volume_modulus) const;

 private:
  /// Works [Pa] of the loads of each case on the motions of each, over the volume; elongations [m], a column a case.
  struct Solved {
    MatrixX works, elongations;
  };
  Solved solve(const LoadCases& cases, const VectorX& constants, double volume_modulus) const;

  const Body& body_;
  bool with_volume_;
  Surface surface_;
  MatrixX stiffness_root_, compliance_root_;  ///< C½ and C⁻½ of the target
  double youngs_modulus_, poissons_ratio_;
  LoadCases strain_, stress_;
  std::vector<LoadCases> tension_;  ///< along x, y, z, of a box
};

/// Outward area vectors [m²] of the surface, 3 × n.
Positions area_vectors(const Body& body, const std::optional<BoxSides>& box) {
  Positions areas = Positions::Zero(3, body.size());
  if (body.tetrahedra.empty()) {
    for (int side = 0; box && side < 6; ++side)
      for (std::size_t i = 0; i < box->sides[side].molecules.size(); ++i)
        areas(side / 2, box->sides[side].molecules[i]) +=
            (side % 2 ? 1 : -1) * box->sides[side].area * box->sides[side].share[static_cast<Eigen::Index>(i)];
  }
  for (const auto& [a, b, c] : boundary_of(body.tetrahedra)) {
    const Vector3 corner = body.rest.col(a), area = (body.rest.col(b) - corner).cross(body.rest.col(c) - corner) / 6;
    for (const int molecule : {a, b, c}) areas.col(molecule) += area;
  }
  return areas;
}

ModuliOfBody::ModuliOfBody(const Body& body, const Strategy& rule, const Material& target)
    : body_(body),
      with_volume_(rule.volume_modulus),
      surface_(outer_surface(body)),
      youngs_modulus_(target.youngs_modulus),
      poissons_ratio_(with_volume_ ? target.poissons_ratio : 0.25) {
  const double shear = youngs_modulus_ / (2 * (1 + poissons_ratio_));
  MatrixX stiffness = 2 * shear * MatrixX::Identity(6, 6);
  stiffness.topLeftCorner(3, 3).array() += 2 * shear * poissons_ratio_ / (1 - 2 * poissons_ratio_);
  stiffness.bottomRightCorner(3, 3) /= 2;
  const SymmetricEigen eigen = symmetric_eigen(stiffness);
  const auto power = [&](double exponent) {
    return product(product(eigen.vectors, eigen.values.array().pow(exponent).matrix().asDiagonal()),
                   eigen.vectors.transpose());
  };
  stiffness_root_ = power(0.5), compliance_root_ = power(-0.5);

  std::optional<BoxSides> box;
  try {
    box = find_box(body, Matrix3::Identity(), 0);
  } catch (const InputError&) {
  }
  const Positions areas = area_vectors(body, box), none = Positions::Zero(3, body.size());
  const Matrix3 closed = areas * body.rest.transpose() / surface_.volume - Matrix3::Identity();
  if (!(closed.norm() < 1e-6))
    throw InputError("its surface is not known; write cells: delaunay, for the cells between its molecules");
  for (const int molecule : surface_.molecules) strain_.supports.push_back({molecule});
  for (int load_case = 0; load_case < 6; ++load_case) {
    Positions strained = uniformly_strained(body, load_case);
    stress_.displacements.push_back(none);
    stress_.forces.push_back(none);
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      const Vector3 area = areas.col(molecule);
      const int i = load_case < 3 ? load_case : (load_case - 2) % 3,
                j = load_case < 3 ? load_case : (load_case - 1) % 3;
      stress_.forces.back()(i, molecule) = area[j];
      stress_.forces.back()(j, molecule) = area[i];
    }
    strain_.displacements.push_back(std::move(strained));
    strain_.forces.push_back(none);
  }
  for (int axis = 0; box && axis < 3; ++axis) {
    LoadCases tension{{}, {none, none, none}, {none, none, none}};
    for (const int end : {0, 1})
      for (const int molecule : box->sides[2 * axis + end].molecules) {
        Support support{molecule, Matrix3::Identity()};
        support.free(axis, axis) = 0;
        tension.supports.push_back(support);
        tension.displacements[0](axis, molecule) = end * box->size[axis];
      }
    for (const int other : {1, 2}) tension.forces[other].row((axis + other) % 3) = areas.row((axis + other) % 3);
    tension_.push_back(std::move(tension));
  }
}

ModuliOfBody::Solved ModuliOfBody::solve(const LoadCases& cases, const VectorX& constants,
                                         double volume_modulus) const {
  if (stop_requested()) throw InputError("interrupted");
  Model model(body_);
  model.add(make_springs(body_, constants));
  if (with_volume_) model.add(make_volume(body_, volume_modulus));
  model.set_rest(0);
  model.supports = cases.supports;
  const StaticOptions linear{.linear = true};
  const State rest = state_at_rest(body_);
  Responses responses(model, rest, linear);
  const auto count = static_cast<Eigen::Index>(cases.forces.size());
  Solved solved{MatrixX::Zero(count, count), MatrixX(body_.connections.size(), count)};
  for (Eigen::Index one = 0; one < count; ++one) {
    const StaticResponse response = responses.to(cases.forces[one], cases.displacements[one], 1e-9);
    if (response.result.outcome != Outcome::converged) throw InputError(response.result.cause);
    for (Eigen::Index other = 0; other < count; ++other) {
      double work = cases.forces[other].cwiseProduct(response.motion).sum();
      for (std::size_t i = 0; i < cases.supports.size(); ++i)
        work += response.result.reactions.col(static_cast<Eigen::Index>(i))
                    .dot(cases.displacements[other].col(cases.supports[i].molecule));
      solved.works(other, one) = work / surface_.volume;
    }
    for (int connection = 0; connection < body_.connections.size(); ++connection) {
      const auto& [a, b] = body_.connections.ends[connection];
      solved.elongations(connection, one) =
          (body_.rest.col(b) - body_.rest.col(a)).normalized().dot(response.motion.col(b) - response.motion.col(a));
    }
  }
  return solved;
}

ModuliOfBody::Misses ModuliOfBody::misses(const VectorX& constants, double volume_modulus) const {
  const int rows = wanted() + (stress_.forces.empty() ? 0 : 21);
  Misses found{VectorX(rows), MatrixX(rows, constants.size())};
  int row = 0;
  const VectorX over_volume = constants / surface_.volume;
  const auto add = [&](double value, double weight, const auto& one, const auto& other) {
    found.values[row] = weight * value;
    found.slopes.row(row++) = weight * over_volume.cwiseProduct(one).cwiseProduct(other).transpose();
  };
  /// ± (R M R − 1), M the stiffness or compliance and R the root of the target's other one: symmetric. Where no sides
  /// say which directions are the body's own, what is off the diagonal counts twice: the sum of squares then is the
  /// same in all directions.
  const double off_diagonal = tension_.empty() ? std::sqrt(2) : 1;
  const auto add_matrix = [&](const LoadCases& cases, const MatrixX& root, double sign, double weight) {
    const Solved solved = solve(cases, constants, volume_modulus);
    const MatrixX over_target = product(product(root, solved.works), root),
                  elongations = product(solved.elongations, root);
    for (int i = 0; i < 6; ++i)
      for (int j = i; j < 6; ++j)
        add(sign * ((over_target(i, j) + over_target(j, i)) / 2 - (i == j)), weight * (i == j ? 1 : off_diagonal),
            elongations.col(i), elongations.col(j));
  };
  add_matrix(strain_, compliance_root_, 1, 1);
  for (const LoadCases& tension : tension_) {
    const Solved solved = solve(tension, constants, volume_modulus);
    const VectorX along = solved.elongations.col(0);
    add(solved.works(0, 0) / youngs_modulus_ - 1, 1, along, along / youngs_modulus_);
    for (int other = 1; other < solved.works.rows(); ++other)
      add(-solved.works(other, 0) - poissons_ratio_, 1, along, solved.elongations.col(other));
  }
  if (!stress_.forces.empty()) add_matrix(stress_, stiffness_root_, -1, tension_.empty() ? 1 : kBounds);
  return found;
}

std::string ModuliOfBody::remains(const VectorX& constants, double volume_modulus) const {
  const Solved strained = solve(strain_, constants, volume_modulus);
  const auto compliance = compliance_of(Stiffness6(strained.works));
  if (!compliance) return "the springs show no positive stiffness";
  const double shear = youngs_modulus_ / (2 * (1 + poissons_ratio_));
  // E along x, y, z by strains; G of yz, xz, xy; ν along x, y, z, and E there, in tension where that is measured.
  std::array<double, 12> off{};
  for (int axis = 0; axis < 3; ++axis) {
    const double youngs = 1 / (*compliance)(axis, axis);
    off[axis] = youngs / youngs_modulus_ - 1;
    off[3 + axis] = 1 / (*compliance)(3 + axis, 3 + axis) / shear - 1;
    off[6 + axis] = -youngs * ((*compliance).block<3, 1>(0, axis).sum() - 1 / youngs) / 2 - poissons_ratio_;
    if (tension_.empty()) continue;
    const Solved solved = solve(tension_[axis], constants, volume_modulus);
    off[9 + axis] = solved.works(0, 0) / youngs_modulus_ - 1;
    if (solved.works.rows() > 1) off[6 + axis] = -(solved.works(1, 0) + solved.works(2, 0)) / 2 - poissons_ratio_;
  }
  if (std::all_of(off.begin(), off.end(), [](double one) { return std::abs(one) <= kSaid; })) return "";
  const auto three = [](const char* what, const double* values, double factor, const char* unit) {
    char text[120];
    std::snprintf(text, sizeof text, "%s by %+.2g, %+.2g, %+.2g%s", what, factor * values[0], factor * values[1],
                  factor * values[2], unit);
    return std::string(text);
  };
  return "the fit leaves off: E along x, y, z" +
         (tension_.empty() ? "" : three(" in tension between plane ends", &off[9], 100, " % and")) +
         three(" in small strains of the surface", off.data(), 100, " %") + ", " +
         three("G of yz, xz, xy", &off[3], 100, " %") + ", " + three("nu along x, y, z", &off[6], 1, "");
}

/// What springs alone cannot show, in words, or "".
std::string cauchy_remains(const Strategy& rule, const Material& material) {
  if (rule.volume_modulus || std::abs(material.poissons_ratio - 0.25) < 1e-9) return "";
  char text[240];
  std::snprintf(text, sizeof text,
                "springs alone have Poisson's ratio 0.25 (Cauchy), not %.4g: fitted to E, with G %+.1f %% off; "
                "fitted:%s+volume is fitted to E, G and nu",
                material.poissons_ratio, 100 * ((1 + material.poissons_ratio) / 1.25 - 1),
                StrategyName(rule.name).rule.c_str());
  return text;
}

/// A box with its sides across x, y and z, however it lies; other bodies as they are.
Body laid_straight(const Body& body) {
  const std::optional<Matrix3> axes = box_axes(body);
  Body straight = body;
  if (axes && !axes->isIdentity(0)) rotate(straight, axes->transpose());
  return straight;
}

FittedSprings fitted_to_moduli(const Strategy& rule, const Body& body, const Material& material,
                               const ParameterValues& values) {
  const auto fail = [&](const std::string& cause) {
    throw InputError("'fitted:" + rule.name + "' on this body: " + cause);
  };
  if (material.field) fail("the material changes from place to place: there are no moduli to fit to");
  FittedSprings found = scaled("fitted", rule, body, material, values);
  const int proper = body.connections.proper();
  VectorX& k = found.constants;
  const double least = 0.01 * k.head(proper).cwiseMax(0).mean();
  k.head(proper) = k.head(proper).cwiseMax(least);
  try {
    const Body straight = laid_straight(body);
    ModuliOfBody moduli(straight, rule, material);
    const VectorX start = k;
    VectorX change = VectorX::Zero(k.size());  // ln k/k₀
    ModuliOfBody::Misses now;
    try {
      now = moduli.misses(k, found.volume_modulus);
    } catch (const InputError&) {
      moduli.leave_out_loads();
      now = moduli.misses(k, found.volume_modulus);
    }
    double damping = 1;
    for (int step = 0; step < kMostSteps && now.values.head(moduli.wanted()).norm() > kMet; ++step) {
      // Least |g + J d|² + near |y + d|² + damping |d|²: as many equations as moduli.
      const MatrixX squares = product(now.slopes, now.slopes.transpose());
      const double size = squares.trace() / static_cast<double>(squares.rows()), near = kNear * size,
                   weight = near + damping * size;
      const VectorX slope = now.slopes.transpose() * now.values + near * change;
      const MatrixX solved = inverse(squares + weight * MatrixX::Identity(squares.rows(), squares.rows()));
      const VectorX tried =
          change -
          ((slope - now.slopes.transpose() * (solved * (now.slopes * slope))) / weight).cwiseMax(-1).cwiseMin(1);
      const VectorX trial = start.cwiseProduct(tried.array().exp().matrix());
      ModuliOfBody::Misses next = moduli.misses(trial, found.volume_modulus);
      const auto cost = [&](const ModuliOfBody::Misses& misses, const VectorX& y) {
        return misses.values.squaredNorm() + near * y.squaredNorm();
      };
      if (cost(next, tried) < cost(now, change)) {
        change = tried, k = trial, now = std::move(next), damping = std::max(damping / 5, 1e-9);
      } else {
        damping *= 4;
      }
    }
    found.remains = moduli.remains(k, found.volume_modulus);
    if (!found.remains.empty() && straight.rest != body.rest)
      found.remains += " (x, y, z across the sides of the body)";
  } catch (const InputError& error) {
    fail(error.what());
  }
  const std::string cauchy = cauchy_remains(rule, material);
  // What stands behind a semicolon is left out where there is little space.
  if (!cauchy.empty()) found.remains += (found.remains.empty() ? "" : "; ") + cauchy;
  return found;
}

/// The strategy NAME:rule whose springs `fit` makes.
Strategy fitted_by(const Strategy& rule, bool StrategyName::*property, const std::string& summary,
                   const decltype(Strategy::fit)& fit) {
  StrategyName parsed(rule.name);
  parsed.*property = true;
  const std::string name = parsed.text(), word = property == &StrategyName::fitted ? "fitted" : "calibrated";
  if (rule.calibrates) throw InputError("'" + name + "': the rule is calibrated already");
  if (rule.has_history) throw InputError("'" + name + "': write prony:" + word + ":RULE or mullins:" + word + ":RULE");
  if (rule.kind != StrategyKind::spring_rule)
    throw InputError("'" + name + "': only a spring rule can be " + word + ", and " + rule.name + " is a " +
                     name_of(rule.kind));
  Strategy result = rule;
  result.name = name;
  result.summary += "; " + summary;
  result.calibrates = std::make_shared<const Strategy>(rule);
  result.fit = fit;
  result.joins_molecules = true;
  result.unsuited = [rule](const Body& body) { return calibrated_unsuited(rule, body); };
  result.constants = [fit](const Body& body, const Material& material, const ParameterValues& values) {
    return fit(body, material, values).constants;
  };
  result.make = [fit, with_volume = static_cast<bool>(rule.volume_modulus)](const Body& body, const Material& material,
                                                                            const ParameterValues& values) {
    FittedSprings found = fit(body, material, values);
    ElasticTerms terms = make_springs(body, std::move(found.constants), material);
    if (with_volume) terms.add(make_volume(body, found.volume_modulus));
    return terms;
  };
  return result;
}

}  // namespace

Strategy calibrated(const Strategy& rule) {
  return fitted_by(rule, &StrategyName::calibrated, "calibrated",
                   [rule](const Body& body, const Material& material, const ParameterValues& values) {
                     return scaled("calibrated", rule, body, material, values);
                   });
}

Strategy fitted(const Strategy& rule) {
  return fitted_by(rule, &StrategyName::fitted, "every constant fitted",
                   [rule](const Body& body, const Material& material, const ParameterValues& values) {
                     return fitted_to_moduli(rule, body, material, values);
                   });
}

}  // namespace elastin
