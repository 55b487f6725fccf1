#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lab/scene/scene.h"

namespace elastin::lab {

/// What the row of CalculiX is called in a comparison.
inline constexpr const char* kCalculix = "calculix";

/// Throws InputError unless `ccx` can be started.
void check_calculix();

/// What another program made of a scene.
struct OtherRun {
  std::unique_ptr<Scene> scene;  ///< as it was given to the program: its own body
  Run run;                       ///< measured as a run of Elastin is, off the displacements and forces that it printed
};

/// Solves the scene's problem by CalculiX, on the scene's cells with second order (tetrahedra of 10 nodes; of a lattice
/// the hexahedra of 20 in its boxes), with the material's own law: where CalculiX has none the nearest, which is said.
/// A problem that it cannot take is unsuited, and a process that fails diverges: the run says why. Its process is
/// ended, and the run interrupted, where `stop` gives true.
OtherRun run_calculix(const Scene& scene, const Catalog& catalog, const std::vector<std::string>& overrides,
                      const std::function<bool()>& stop);

}  // namespace elastin::lab
