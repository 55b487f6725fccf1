#pragma once
#include <functional>
#include <string>

#include "elastin/core/model/body.h"

/// Other programs that step the same springs.
namespace bench {

/// One system of springs at the start of a run, SI units.
struct Start {
  const elastin::Body& body;
  const elastin::VectorX& constants;  ///< k [N/m], one a connection
  const elastin::Positions& positions;
  double dt;
};

/// Each `make_…` gives a function: how long a number of steps takes [s]. Each `…_missing` says why it cannot, "" if it
/// can.

/// LAMMPS (lmp): bond_style harmonic, fix nve, no pair style, no neighbour lists, on a number of MPI ranks. Its own
/// loop time, of a process that starts each time.
std::function<double(int steps)> make_lammps(const Start& start, int ranks);
std::string lammps_missing(int ranks);

/// Bullet's soft body: links, one pass of its position solver a step, in Bullet's single precision.
std::function<double(int steps)> make_bullet(const Start& start);
std::string bullet_missing();

}  // namespace bench
