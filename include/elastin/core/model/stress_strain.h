#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace elastin {

/// What a material shows in uniaxial stress: nominal stress [Pa] (force over rest section) over nominal strain
/// (elongation over rest length), tension positive. Increasing, through the origin, continuous with its slope; beyond
/// its ends straight on with the slope there. Cheap to copy: copies share the curve.
class StressStrain {
 public:
  struct Point {
    double strain, stress;
  };

  /// No stress at any strain.
  StressStrain();

  /// σ = E ε. @param modulus E [Pa], > 0.
  static StressStrain linear(double modulus);

  /// Toe region, then straight: the modulus [Pa] rises linearly from toe_modulus at no strain to modulus at toe_strain
  /// (> 0), and stays there; in compression it is toe_modulus. Throws InputError unless all are positive.
  static StressStrain toe(double toe_strain, double toe_modulus, double modulus);

  /// Two moduli [Pa], in tension and in compression; between −smoothing and +smoothing (> 0, a strain) one goes over
  /// linearly into the other, so that the modulus at no strain is their mean, and beyond it the stress is off the sharp
  /// corner's by (tension − compression) smoothing / 4. Throws InputError unless all are positive.
  static StressStrain bilinear(double tension, double compression, double smoothing);

  /// Monotone cubic interpolation: harmonic mean slopes [Fritsch & Butland 1984]; at each end the slope of the parabola
  /// through the last three points, kept within 0.1 and 2 times that of the last two. Throws InputError on a fault.
  static StressStrain through(const std::vector<Point>& points);

  /// From a secant modulus E(|ε|) = c₀ + c₁ |ε| + c₂ ε² … [Pa], the same in compression: σ = E ε up to the strain
  /// `up_to`
  /// (> 0). Throws InputError where the stress does not rise up to there, and says at which strain.
  static StressStrain secant_polynomial(const std::vector<double>& coefficients, double up_to);

  /// From a secant modulus given at some strains ≥ 0, ascending, at least two, interpolated by monotone cubics and
  /// constant before the first; the same in compression. Throws InputError as secant_polynomial.
  struct SecantPoint {
    double strain, modulus;
  };
  static StressStrain secant_table(const std::vector<SecantPoint>& points);

  /// The first point that a curve cannot go through, and why: strain and stress must increase from point to point,
  /// strain stay above −1, and one point be the origin; at least two points.
  static std::optional<std::pair<std::size_t, std::string>> fault(const std::vector<Point>& points);

  /// The same in tension, no stress in compression. Its slope jumps at the origin, where modulus() is that of tension.
  StressStrain without_compression() const;

  double stress(double strain) const;          ///< [Pa]
  double modulus(double strain) const;         ///< dσ/dε [Pa]
  double secant(double strain) const;          ///< σ/ε [Pa]; the modulus at no strain
  double energy_density(double strain) const;  ///< ∫ σ dε from 0 [J/m³], ≥ 0
  /// Both at once, since they are needed together.
  struct Response {
    double secant, modulus, energy_density;
  };
  Response response(double strain) const;

 private:
  struct Knot {
    double strain, stress, slope;
  };
  /// σ = stress + d (c1 + d (c2 + d c3)), d = ε − strain, up to the strain `end`. The expansion is about the end that
  /// is nearer to the origin, so that next to the origin σ/ε loses no digit.
  struct Piece {
    double end, strain, stress, c1, c2, c3, energy;
    double energy_density(double at) const;
  };
  explicit StressStrain(const std::vector<Knot>& knots);
  template <class Archive>
  friend void visit(Archive& archive, StressStrain& curve);
  static StressStrain both_ways(const std::vector<Knot>& tension);
  const Piece& piece(double strain) const;

  std::shared_ptr<const std::vector<Piece>> pieces_;
};

}  // namespace elastin
