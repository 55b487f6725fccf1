#include "lab/experiment/moduli.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastin::lab {

double shear_modulus(const Material& material) { return material.youngs_modulus / (2 * (1 + material.poissons_ratio)); }

double bulk_modulus(const Material& material) {
  return material.youngs_modulus / (3 * (1 - 2 * material.poissons_ratio));
}

IsotropicMeans isotropic_means(const Stiffness6& stiffness, const Stiffness6& compliance) {
  const auto sums = [](const Stiffness6& m) {
    struct {
      double axial, across, shear;
    } result{m(0, 0) + m(1, 1) + m(2, 2), m(0, 1) + m(0, 2) + m(1, 2), m(3, 3) + m(4, 4) + m(5, 5)};
    return result;
  };
  const auto c = sums(stiffness), s = sums(compliance);
  return {(c.axial + 2 * c.across) / 9, 1 / (s.axial + 2 * s.across), (c.axial - c.across + 3 * c.shear) / 15,
          15 / (4 * (s.axial - s.across) + 3 * s.shear)};
}

double torsion_constant(double a, double b) {
  if (a < b) std::swap(a, b);
  double sum = 0;
  for (int n = 1; n < 40; n += 2) sum += std::tanh(n * std::numbers::pi * a / (2 * b)) / std::pow(n, 5);
  return a * b * b * b * (1. / 3 - 64 * b / (std::pow(std::numbers::pi, 5) * a) * sum);
}

}  // namespace elastin::lab
