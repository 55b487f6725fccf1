#pragma once
#include <memory>

#include "elastin/core/simulation/catalog.h"

namespace elastin::petsc {

/// What this process is among those that mpiexec has started: known before MPI itself is started.
struct Launch {
  int rank = 0, count = 1;
};
Launch launch();

/// Starts MPI and PETSc, unless they run already; make_engine() does it by itself. PETSc reads its options from
/// PETSC_OPTIONS; those of another preconditioner than Elastin's begin with -elastin_ (-elastin_pc_type gamg).
void start();

/// To be called last, by every process, where start() or make_engine() was: ends PETSc and MPI and returns `code`, the
/// process's exit code. A code other than 0 that not all processes come with ends them all at once, so that none waits
/// for a process that has failed; `last_words` is called before that.
int end(int code, void (*last_words)() = nullptr);

/// An engine (StaticOptions::engine) that shares a model out among all processes of MPI_COMM_WORLD: each owns some
/// molecules, computes the elements that begin at them, and has the rows of vectors that belong to them. Newton's
/// method on PETSc's vectors, conjugate gradients (KSPCG) on a tangent without a matrix (MATSHELL), preconditioned by 3
/// × 3 blocks and, as `linear_solver` says, by a V-cycle (PCMG) on the boxes of multigrid.
///
/// Every process hands over the same whole model and gets the same whole result, or that of its share of a body
/// (Body::share) and gets what belongs to it. Of shares it also balances implicit steps, and explicit ones take from it
/// what gives ghosts what their owners have (Model::complete_rows). Models in equilibrium with loads that change as the
/// body moves, with laws that have a history, and, of a whole body, with cells that are driven at their nodes are not
/// taken; see StaticEngine::unsuited.
std::shared_ptr<StaticEngine> make_engine();

/// Makes the engine `petsc` of a catalog one that works.
void add_to(Catalog& catalog);

}  // namespace elastin::petsc
