#pragma once

namespace elastin {

/// What the body should behave like. A strategy turns it into the stiffness of each connection.
struct Material {
  double youngs_modulus = 0;     ///< E [Pa], > 0
  double poissons_ratio = 0.25;  ///< ν, −1 < ν < ½. Springs alone give ¼ in an isotropic body, whatever is asked.
  double density = 1000;         ///< ρ [kg/m³], > 0
  double thickness = 0;          ///< t [m] of a membrane; only triangles use it
};

}  // namespace elastin
