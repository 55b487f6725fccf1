#pragma once
#include <string>

#include "lab/export/problem.h"

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

}  // namespace elastin::lab
