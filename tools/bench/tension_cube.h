#pragma once
#include <Eigen/SparseCore>
#include <memory>

#include "elastin/core/forces/model.h"
#include "elastin/lab/run/experiment.h"

namespace bench {

inline constexpr double kTolerance = 1e-8;  ///< of the residual, over the loads

/// How a body's molecules and connections are numbered.
enum class Numbering { lattice, at_random, in_space };

/// The tension cube under the load that stretches it by 1e-5, ready to be solved.
struct TensionCube {
  explicit TensionCube(int side, Numbering numbering = Numbering::lattice);
  elastin::Body body;
  elastin::Model model;
  std::unique_ptr<elastin::lab::StaticExperiment> experiment;
  elastin::Positions loads;
  double renumbering;  ///< what numbered_in_space took of it [s]

 private:
  struct Cube {
    elastin::Body body;
    elastin::VectorX constants;
    double renumbering = 0;
  };
  static Cube numbered(int side, Numbering numbering);
  explicit TensionCube(Cube cube);
};

/// K about rest without a shift; the sliding grips leave three rigid motions, on which the load does no work.
Eigen::SparseMatrix<double> assembled(TensionCube& cube);

/// The right-hand side that every linear contender gets.
elastin::VectorX free_loads(const TensionCube& cube);

}  // namespace bench
