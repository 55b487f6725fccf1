#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lab/export/problem.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// How a problem is written for CalculiX.
struct CalculixOptions {
  /// Whether its own neo-Hookean law, κ/2 (J − 1)² in addition to the isochoric part, may stand for neo_hookean and
  /// neo_hookean_log, which are others beyond small strain; else they are refused.
  bool nearest_law = false;
  bool result_files = true;  ///< stresses and displacements for viewers, in addition to the printed displacements
};

/// The input of CalculiX. It prints the displacements of all molecules (set ALL) and the forces on the held ones (HELD)
/// at the end of each step. Throws InputError; adds to problem.notes what CalculiX does differently.
std::string calculix_deck(StaticProblem& problem, const CalculixOptions& options);

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
