#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "elastin/core/geometry/cell_kind.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// A body with the constants of one strategy, in SI units and without anything of Elastin's in it: what engines take.
struct ExportedBody {
  struct Connection {
    int a = 0, b = 0;
    double rest_length = 0, stiffness = 0;  ///< [m]; [N/m], not 0
  };
  struct Cell {
    const CellKind* kind = nullptr;
    std::vector<int> nodes;
    double youngs_modulus = 0, poissons_ratio = 0, density = 0;  ///< [Pa], –, [kg/m³]
    int material = 0;                                            ///< of those of the scene's bodies
  };
  std::string name, title, strategy;
  Positions positions;    ///< at rest [m]
  Positions start;        ///< where the body begins [m]; empty: at rest
  VectorX masses, radii;  ///< [kg], [m]
  /// Those with a constant; none where the strategy is a law of cells.
  std::vector<Connection> connections;
  double explicit_step = INFINITY;  ///< the longest that is stable without supports, by these connections [s]
  std::vector<Cell> cells;          ///< as the body has them
  std::vector<Cell>
      tetrahedra;        ///< of four nodes, that fill the same; none of a body without cells of three dimensions
  double thickness = 0;  ///< of triangles and quadrilaterals [m]
  double load = 1;       ///< part of the experiment's load that supports and forces are
  std::vector<Support> supports;   ///< of the experiment under that load; each axis is held or free
  int askew = 0;                   ///< supports that are left out of these, as far as they slide askew to x, y and z
  Positions forces;                ///< of all loads on the molecules at rest [N]
  std::vector<std::string> notes;  ///< what of the scene is not here, a sentence each
};

/// Whether a support holds x, y or z.
bool is_held(const Support& support, int axis);

/// The supports and the forces of a scene's experiment under its whole load; none of an experiment that runs in time.
void set_test(const Scene& scene, ExportedBody& body);

/// The scene's body with the constants of a strategy. Throws InputError where the strategy does not suit the body, or
/// its calibration fails.
ExportedBody exported_body(const Scene& scene, const StrategyChoice& choice);

}  // namespace elastin::lab
