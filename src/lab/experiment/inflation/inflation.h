#pragma once
#include <optional>
#include <vector>

#include "config/keys.h"
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// Gas inside, of the whole body where planes of symmetry cut it.
struct GasSetup {
  double amount = 0;          ///< absolute pressure × volume when it fills the volume at rest: n R T [J]
  double start_pressure = 0;  ///< or that absolute pressure itself [Pa]; one of the two is 0
  double exponent = 1;        ///< 1: constant temperature; 1.4: air without exchange of heat
  double ambient = 101325;    ///< pressure outside [Pa]
};

/// A closed membrane blown up, from no pressure: by a pressure that grows in equal steps; by volume control, where the
/// pressure is what it takes, rising or falling, and the cube root of the volume grows in equal steps; or by gas let
/// in.
struct InflationSetup {
  std::optional<double> pressure;      ///< [Pa], over that outside
  std::optional<double> volume_ratio;  ///< enclosed volume over that at rest
  std::optional<GasSetup> gas;
  std::vector<Vector3> symmetry;       ///< unit normals of planes through the origin, across each other
  Matrix3 axes = Matrix3::Identity();  ///< columns: the axes on which corners lie
  int load_steps = 1;
};

/// Throws InputError if the body does not suit: no triangles, no thickness, a rim outside the planes of symmetry …
std::unique_ptr<StaticExperiment> make_inflation(const Body& body, const InflationSetup& setup,
                                                 const Material& material);

/// The keys of a gas, of `kind: inflation` and of the load `gas`.
const config::Keys<GasSetup>& gas_keys();

}  // namespace elastin::lab
