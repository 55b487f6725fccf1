#pragma once
#include <array>
#include <optional>

#include "lab/run/ends.h"

namespace elastin::lab {

enum class Grip { clamped, sliding };        ///< held sideways, or free to slide sideways
enum class LoadSharing { molecules, area };  ///< equal parts, or by the area nearest to each molecule
enum class Reading { mean, corner };  ///< elongation: mean of the loaded end by load share, or one corner molecule

/// A bar pulled or pressed along an axis: one end's molecules are held along it, the other end's are loaded.
struct TensionSetup : GripSetup {
  Vector3 axis = Vector3::UnitZ();
  std::optional<double> force;         ///< [N] on the loaded end, as dead forces; negative = compression
  std::optional<double> displacement;  ///< [m] of the loaded end, the other way to load; negative = compression
  /// The displacement over the distance of the ends' molecules, in place of it; negative = compression
  std::optional<double> strain;
  /// [m/s²] along the axis, in place of them: the body's own weight is the load; it hangs from its fixed end, or stands
  /// on it where this is negative
  std::optional<double> gravity;
  Grip fixed_grip = Grip::sliding, loaded_grip = Grip::sliding;
  LoadSharing sharing = LoadSharing::area;
  Reading reading = Reading::mean;
  /// A [m²]; 0 = volume over length of the body's cells, between the gauge planes if there are any; see find_section
  double cross_section = 0;
  double density = 0;                          ///< [kg/m³] of the material; 0 = the masses state no volume
  double thickness = 0;                        ///< [m] of the body's triangles; 0 = they have no volume
  double gauge_length = 0;                     ///< l₀ [m]; 0 = distance between the ends' molecules
  std::optional<std::array<double, 2>> gauge;  ///< planes [m] from the fixed end between which elongation is read
  int load_steps = 1;                          ///< up to the load, or from each of these parts to the next
  std::vector<double> cycle;  ///< parts of the load (0 … 1) that are reached one after the other; empty: all of it
};

/// Checks the setup against the body; throws InputError (no molecule at an end, no cross-section, a gauge outside …).
std::unique_ptr<StaticExperiment> make_tension(const Body& body, const TensionSetup& setup);

/// The setup of a tension experiment, its lengths and area those of the scene; null of any other.
const TensionSetup* tension_setup(const Experiment& experiment);

const MeasureList& tension_measures();

}  // namespace elastin::lab
