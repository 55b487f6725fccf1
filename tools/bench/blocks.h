#pragma once
#include <memory>
#include <string>

#include "elastin/forces/model.h"
#include "elastin/model/shapes.h"
#include "elastin/solve/statics.h"
#include "experiment/experiment.h"

/// The clamped blocks of which converged solutions are known: one end wholly held, the other under a uniform dead
/// traction and else free; elongation is the mean of the loaded end.
namespace bench {

struct Block {
  const char* name;
  elastin::Vector3 size;  ///< [m], pulled along z
  double modulus, force;  ///< E [Pa], F [N]
  /// Cubes along each side; `level` of them along the shortest.
  std::array<int, 3> cubes(int level) const;
};
extern const Block kBlock1, kBlock2;

/// A converged solution by other programs: elongation [m] under the block's force.
struct BlockReference {
  const Block* block;
  const char* law;  ///< "linear", or a cell law at large displacements
  double poissons_ratio, elongation, error;
};
extern const std::vector<BlockReference> kBlockReferences;

/// A block of tetrahedra, held and loaded; `part` of the block's force.
struct BlockProblem {
  BlockProblem(const Block& block, elastin::BlockKind kind, int level, const std::string& law, double poissons_ratio,
               double part = 1);
  /// Solves from rest and returns the elongation [m]; throws std::runtime_error if it fails.
  double elongation(bool linear, double tolerance, elastin::StaticResult* result = nullptr);

  elastin::Body body;
  elastin::Model model;
  std::unique_ptr<elastin::Experiment> experiment;
};

}  // namespace bench
