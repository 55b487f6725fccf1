#include "elastin/core/model/stress_strain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "elastin/core/base/error.h"

namespace elastin {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_positive(double value, const char* name) {
  if (!(value > 0 && std::isfinite(value)))
    throw InputError(std::string(name) + " " + std::to_string(value) + ": a stress-strain curve needs more than 0");
}

/// Slope at the end of a table: of the parabola through three points, `first` and `second` the slopes between them.
double end_slope(double first_step, double first, double second_step, double second) {
  const double parabola = first + (first - second) * first_step / (first_step + second_step);
  return std::clamp(parabola, 0.1 * first, 2 * first);
}

}  // namespace

StressStrain::StressStrain() : StressStrain(std::vector<Knot>{{0, 0, 0}}) {}

StressStrain::StressStrain(const std::vector<Knot>& knots) {
  std::vector<Piece> pieces;
  const auto straight = [](const Knot& knot, double end) {
    return Piece{end, knot.strain, knot.stress, knot.slope, 0, 0, 0};
  };
  pieces.push_back(straight(knots.front(), knots.front().strain));
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const bool tension = knots[k].strain >= 0;
    const Knot &near = knots[tension ? k : k + 1], &far = knots[tension ? k + 1 : k];
    const double step = far.strain - near.strain, mean = (far.stress - near.stress) / step;
    pieces.push_back({knots[k + 1].strain, near.strain, near.stress, near.slope,
                      (3 * mean - 2 * near.slope - far.slope) / step,
                      (near.slope + far.slope - 2 * mean) / (step * step), 0});
  }
  pieces.push_back(straight(knots.back(), kInfinity));
  // The energy at each piece's knot is the integral over the pieces before it, from the origin outwards.
  const auto add_energies = [&](auto begin, auto end) {
    for (auto at = begin + 1; at < end; ++at) {
      const Piece& nearer = *(at - 1);
      at->energy = nearer.energy_density(at->strain);
    }
  };
  const auto zero = std::find_if(pieces.begin(), pieces.end(), [](const Piece& p) { return p.end > 0; });
  add_energies(zero, pieces.end());
  add_energies(std::make_reverse_iterator(zero), pieces.rend());
  pieces_ = std::make_shared<const std::vector<Piece>>(std::move(pieces));
}

StressStrain StressStrain::linear(double modulus) {
  check_positive(modulus, "modulus");
  return StressStrain(std::vector<Knot>{{0, 0, modulus}});
}

StressStrain StressStrain::toe(double toe_strain, double toe_modulus, double modulus) {
  check_positive(toe_strain, "toe_strain");
  check_positive(toe_modulus, "toe_modulus");
  check_positive(modulus, "modulus");
  return StressStrain(
      std::vector<Knot>{{0, 0, toe_modulus}, {toe_strain, (toe_modulus + modulus) / 2 * toe_strain, modulus}});
}

StressStrain StressStrain::bilinear(double tension, double compression, double smoothing) {
  check_positive(tension, "tension");
  check_positive(compression, "compression");
  check_positive(smoothing, "smoothing");
  return StressStrain(std::vector<Knot>{{-smoothing, -smoothing * (tension + 3 * compression) / 4, compression},
                                        {0, 0, (tension + compression) / 2},
                                        {smoothing, smoothing * (3 * tension + compression) / 4, tension}});
}

std::optional<std::pair<std::size_t, std::string>> StressStrain::fault(const std::vector<Point>& points) {
  using Fault = std::pair<std::size_t, std::string>;
  bool origin = false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [strain, stress] = points[i];
    if (!std::isfinite(strain) || !std::isfinite(stress)) return Fault{i, "is not a finite number"};
    if (!(strain > -1)) return Fault{i, "a strain of -100 % or less leaves no length"};
    if (i > 0 && !(strain > points[i - 1].strain))
      return Fault{i, "the strain must be greater than the point's before"};
    if (i > 0 && !(stress > points[i - 1].stress))
      return Fault{i, "the stress must be greater than the point's before"};
    if (strain == 0 && stress != 0) return Fault{i, "at no strain there must be no stress"};
    origin |= strain == 0;
  }
  if (points.size() < 2) return Fault{0, "a curve needs at least two points"};
  if (!origin) return Fault{0, "the origin [0, 0] must be one of the points"};
  return std::nullopt;
}

StressStrain StressStrain::through(const std::vector<Point>& points) {
  if (const auto wrong = fault(points))
    throw InputError("stress-strain curve, point " + std::to_string(wrong->first) + ": " + wrong->second);
  const std::size_t last = points.size() - 1;
  std::vector<double> step(last), slope(last);
  for (std::size_t k = 0; k < last; ++k) {
    step[k] = points[k + 1].strain - points[k].strain;
    slope[k] = (points[k + 1].stress - points[k].stress) / step[k];
  }
  std::vector<Knot> knots;
  for (const auto& [strain, stress] : points) knots.push_back({strain, stress, slope[0]});
  for (std::size_t k = 1; k < last; ++k) {
    const double before = step[k - 1] + 2 * step[k], after = 2 * step[k - 1] + step[k];
    knots[k].slope = (before + after) / (before / slope[k - 1] + after / slope[k]);
  }
  if (last > 1) {
    knots[0].slope = end_slope(step[0], slope[0], step[1], slope[1]);
    knots[last].slope = end_slope(step[last - 1], slope[last - 1], step[last - 2], slope[last - 2]);
  }
  return StressStrain(knots);
}

StressStrain StressStrain::without_compression() const {
  std::vector<Piece> pieces{{0, 0, 0, 0, 0, 0, 0}};
  for (const Piece& p : *pieces_)
    if (p.end > 0) pieces.push_back(p);
  StressStrain result = *this;
  result.pieces_ = std::make_shared<const std::vector<Piece>>(std::move(pieces));
  return result;
}

double StressStrain::Piece::energy_density(double at) const {
  const double d = at - strain;
  return energy + d * (stress + d * (c1 / 2 + d * (c2 / 3 + d * c3 / 4)));
}

const StressStrain::Piece& StressStrain::piece(double strain) const {
  return *std::upper_bound(pieces_->begin(), pieces_->end() - 1, strain,
                           [](double value, const Piece& piece) { return value < piece.end; });
}

double StressStrain::stress(double strain) const {
  const Piece& p = piece(strain);
  const double d = strain - p.strain;
  return p.stress + d * (p.c1 + d * (p.c2 + d * p.c3));
}

double StressStrain::modulus(double strain) const {
  const Piece& p = piece(strain);
  const double d = strain - p.strain;
  return p.c1 + d * (2 * p.c2 + 3 * d * p.c3);
}

double StressStrain::secant(double strain) const {
  const Piece& p = piece(strain);
  return p.strain == 0 ? p.c1 + strain * (p.c2 + strain * p.c3) : stress(strain) / strain;
}

StressStrain::Response StressStrain::response(double strain) const {
  const Piece& p = piece(strain);
  const double d = strain - p.strain, stress = p.stress + d * (p.c1 + d * (p.c2 + d * p.c3));
  return {p.strain == 0 ? p.c1 + strain * (p.c2 + strain * p.c3) : stress / strain,
          p.c1 + d * (2 * p.c2 + 3 * d * p.c3), p.energy_density(strain)};
}

double StressStrain::energy_density(double strain) const { return piece(strain).energy_density(strain); }

}  // namespace elastin
