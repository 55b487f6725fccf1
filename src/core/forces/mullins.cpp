#include "elastin/core/forces/mullins.h"

#include <cmath>
#include <numbers>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

/// ∫ erf from 0.
double integral_of_erf(double x) { return x * std::erf(x) + (std::exp(-x * x) - 1) * std::numbers::inv_sqrtpi; }

}  // namespace

SoftenedEnergy softened_energy(const Softening& softening, double energy, double most) {
  const double width = softening.m + softening.beta * most;
  if (!(most > 0)) return {energy, 1, 0};
  const double below = std::max(most - energy, 0.) / width, whole = most / width;
  const double lost = width / softening.r * (integral_of_erf(whole) - integral_of_erf(below));
  if (energy >= most) return {energy - lost, 1, 0};
  return {energy - lost, 1 - std::erf(below) / softening.r,
          2 * std::numbers::inv_sqrtpi * std::exp(-below * below) / (softening.r * width)};
}

double softened_factor_by_most(const Softening& softening, double energy, double most) {
  if (energy >= most) return 0;
  const double width = softening.m + softening.beta * most, below = (most - energy) / width;
  return -2 * std::numbers::inv_sqrtpi * std::exp(-below * below) / softening.r *
         (softening.m + softening.beta * energy) / (width * width);
}

void check_softening(const Softening& softening) {
  const auto& [r, m, beta] = softening;
  if (!(r > 1) || !std::isfinite(r))
    throw InputError("softening: r is " + number(r) + " and must be above 1, or nothing is left of the stiffness");
  if (!(m >= 0 && beta >= 0) || !std::isfinite(m) || !std::isfinite(beta))
    throw InputError("softening: m is " + number(m) + " Pa and beta " + number(beta) + "; neither may be below 0");
  if (m == 0 && beta == 0) throw InputError("softening: one of m and beta must be above 0");
}

ElasticTerms make_mullins(ElasticTerms elastic, const Softening& softening) {
  check_softening(softening);
  bool any = false;
  for (const auto& term : elastic.terms)
    if (auto* softens = dynamic_cast<Softens*>(term.get())) any |= softens->soften(softening);
  if (!any) throw InputError("softening goes by the energy of a law, and this one has none");
  return elastic;
}

}  // namespace elastin
