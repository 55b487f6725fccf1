#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/shapes/shapes.h"
#include "lab/run/specimen.h"

/// Boxes of tetrahedra whose converged solutions are known from other programs (dolfinx, CalculiX, GetFEM).
namespace bench {

struct BlockCase {
  std::string name;
  elastin::Vector3 size;  ///< [m]
  double modulus;         ///< E [Pa]
  double poissons_ratio;
  const char* law;  ///< "linear", or a cell law at large displacements
  std::function<std::unique_ptr<elastin::lab::Experiment>(const elastin::Body&, const elastin::Material&)> experiment;
  const char* measure;
  double reference;  ///< of the measure, SI
  double error;      ///< of the reference, relative
  int finest;        ///< cubes along the shortest side that make some 1e5 cells

  /// A run on a grid with `level` cubes along the shortest side; throws std::runtime_error if it fails.
  elastin::lab::Run run(elastin::BlockKind kind, int level, double tolerance) const;
  std::array<int, 3> cubes(int level) const;
};

/// Blocks of tension: T1 = 30 × 30 × 15 mm, 5 kPa, 1 N; T2 = 1 × 1 × 0.86 m, 100 kPa, 1 kN. One end is wholly held, the
/// other under a uniform dead traction and else free; the elongation is the mean of the loaded end. `part` of the
/// force.
BlockCase tension_block1(const char* law, double poissons_ratio, double elongation, double error, double part = 1);
BlockCase tension_block2(const char* law, double poissons_ratio, double elongation, double error);

/// The cases of `convergence`.
std::vector<BlockCase> block_cases();

}  // namespace bench
