#include "lab/run/decaying_terms.h"

#include <algorithm>
#include <cmath>

namespace elastin::lab {
namespace {

/// Where a continuous function is 0 between two places at which its signs differ.
template <class Function>
double bisect(const Function& f, double low, double high) {
  const bool rises = f(low) < 0;
  for (int i = 0; i < 200 && high - low > 1e-14 * (std::abs(low) + std::abs(high)); ++i) {
    const double middle = (low + high) / 2;
    ((f(middle) < 0) == rises ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// The complex modulus over the law's, g₀ + Σ g s/(s + r) + θ s, and its slope by s; r = 1/τ.
struct Modulus {
  const Relaxation& relaxation;
  double value(double s) const {
    double sum = relaxation.long_term() + relaxation.retardation * s;
    for (const auto& [share, time] : relaxation.terms) sum += share * s / (s + 1 / time);
    return sum;
  }
  double slope(double s) const {
    double sum = relaxation.retardation;
    for (const auto& [share, time] : relaxation.terms) sum += share / time / std::pow(s + 1 / time, 2);
    return sum;
  }
};

}  // namespace

DecayingTerms terms_of_force(const Relaxation& relaxation, double ramp) {
  DecayingTerms terms = relaxation.terms;
  double force = relaxation.long_term();
  for (auto& [share, time] : terms) {
    if (ramp > 0) share *= -std::expm1(-ramp / time) * time / ramp;
    force += share;
  }
  for (auto& term : terms) term.share /= force;
  return terms;
}

DecayingTerms terms_of_displacement(const Relaxation& relaxation) {
  constexpr double near = 1e-12;
  const Modulus modulus{relaxation};
  const auto value = [&](double s) { return modulus.value(s); };
  std::vector<double> poles;
  for (const auto& term : relaxation.terms) poles.push_back(-1 / term.time);
  std::sort(poles.begin(), poles.end());
  poles.erase(std::unique(poles.begin(), poles.end()), poles.end());
  std::vector<double> zeros;
  for (std::size_t i = 0; i < poles.size(); ++i) {
    const double from = poles[i] * (1 - near), to = i + 1 < poles.size() ? poles[i + 1] * (1 + near) : 0;
    if (from < to && value(from) < 0 && value(to) > 0) zeros.push_back(bisect(value, from, to));
  }
  if (relaxation.retardation > 0) {  // before all poles the modulus falls without end
    const double to = poles.empty() ? 0 : poles.front() * (1 + near);
    double from = std::min(2 * to, -2 * relaxation.long_term() / relaxation.retardation);
    while (value(from) > 0) from *= 2;
    zeros.push_back(bisect(value, from, to));
  }
  DecayingTerms terms;
  for (const double s : zeros) terms.push_back({-relaxation.long_term() / (s * modulus.slope(s)), -1 / s});
  return terms;
}

double sum_at(const DecayingTerms& terms, double t) {
  double sum = 0;
  for (const auto& [share, time] : terms) sum += share * std::exp(-t / time);
  return sum;
}

double time_until(const DecayingTerms& terms, double share) {
  const auto above = [&](double t) { return sum_at(terms, t) - share; };
  if (!(above(0) > 0)) return 0;
  double longest = 0;
  for (const auto& term : terms) longest = std::max(longest, term.time);
  double end = longest;
  while (above(end) > 0) end *= 2;
  return bisect(above, 0, end);
}

}  // namespace elastin::lab
