#include "lab/run/moduli.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastin::lab {

double shear_modulus(const Material& material) { return material.youngs_modulus / (2 * (1 + material.poissons_ratio)); }

double bulk_modulus(const Material& material) {
  return material.youngs_modulus / (3 * (1 - 2 * material.poissons_ratio));
}

double torsion_constant(double a, double b) {
  if (a < b) std::swap(a, b);
  double sum = 0;
  for (int n = 1; n < 40; n += 2) sum += std::tanh(n * std::numbers::pi * a / (2 * b)) / std::pow(n, 5);
  return a * b * b * b * (1. / 3 - 64 * b / (std::pow(std::numbers::pi, 5) * a) * sum);
}

}  // namespace elastin::lab
