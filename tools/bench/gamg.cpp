// The tension cube of elastin_bench's case "static" by PETSc: conjugate gradients with its algebraic multigrid (GAMG,
// smoothed aggregation with the six rigid motions), on as many MPI ranks as it is started with.
//   mpirun -n 2 elastin_bench_gamg <side> <repeats>
// prints "seconds iterations residual peak_bytes" of each repeat, preconditioner included, matrix not; peak over ranks.
#include <petscksp.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "elastin/core/parallel/threads.h"
#include "tension_cube.h"

namespace {

struct System {
  Mat matrix;
  Vec loads, motion;
  int first, last;  ///< rows of this rank
};

/// Each rank takes the rows of whole molecules.
System distributed(bench::TensionCube& cube) {
  System system{};
  const Eigen::SparseMatrix<double> all = bench::assembled(cube);
  const elastin::VectorX loads = bench::free_loads(cube);
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const int molecules = cube.body.size();
  const int begin = static_cast<int>(static_cast<long long>(molecules) * rank / ranks) * 3;
  const int end = static_cast<int>(static_cast<long long>(molecules) * (rank + 1) / ranks) * 3;
  std::vector<int> rows{0}, columns;
  std::vector<double> values;
  for (int row = begin; row < end; ++row) {  // symmetric: a column is a row
    for (Eigen::SparseMatrix<double>::InnerIterator entry(all, row); entry; ++entry) {
      columns.push_back(static_cast<int>(entry.row()));
      values.push_back(entry.value());
    }
    rows.push_back(static_cast<int>(columns.size()));
  }
  MatCreateMPIAIJWithArrays(PETSC_COMM_WORLD, end - begin, end - begin, 3 * molecules, 3 * molecules, rows.data(),
                            columns.data(), values.data(), &system.matrix);
  MatSetBlockSize(system.matrix, 3);
  MatSetOption(system.matrix, MAT_SPD, PETSC_TRUE);
  MatCreateVecs(system.matrix, &system.motion, &system.loads);
  for (int row = begin; row < end; ++row) VecSetValue(system.loads, row, loads[row], INSERT_VALUES);
  VecAssemblyBegin(system.loads);
  VecAssemblyEnd(system.loads);
  system.first = begin;
  system.last = end;
  // The rigid motions, which its aggregates have to carry.
  Vec positions;
  VecDuplicate(system.loads, &positions);
  VecSetBlockSize(positions, 3);
  for (int row = begin; row < end; ++row) VecSetValue(positions, row, cube.body.rest(row % 3, row / 3), INSERT_VALUES);
  VecAssemblyBegin(positions);
  VecAssemblyEnd(positions);
  MatNullSpace motions;
  MatNullSpaceCreateRigidBody(positions, &motions);
  MatSetNearNullSpace(system.matrix, motions);
  MatNullSpaceDestroy(&motions);
  VecDestroy(&positions);
  return system;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const int side = std::atoi(argv[1]), repeats = std::atoi(argv[2]);
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  elastin::set_threads(1);
  bench::TensionCube cube(side);
  System system = distributed(cube);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    MPI_Barrier(PETSC_COMM_WORLD);
    const auto start = std::chrono::steady_clock::now();
    KSP solver;
    PC preconditioner;
    KSPCreate(PETSC_COMM_WORLD, &solver);
    KSPSetOperators(solver, system.matrix, system.matrix);
    KSPSetType(solver, KSPCG);
    KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED);
    KSPSetTolerances(solver, bench::kTolerance, PETSC_DEFAULT, PETSC_DEFAULT, 10000);
    KSPGetPC(solver, &preconditioner);
    PCSetType(preconditioner, PCGAMG);
    // The sliding grips leave rigid motions, which its last grid's own factorisation cannot take.
    PetscOptionsSetValue(nullptr, "-mg_coarse_sub_pc_type", "svd");
    KSPSetFromOptions(solver);
    KSPSolve(solver, system.loads, system.motion);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    PetscInt iterations = 0;
    KSPGetIterationNumber(solver, &iterations);
    Vec left;
    VecDuplicate(system.loads, &left);
    MatMult(system.matrix, system.motion, left);
    VecAYPX(left, -1, system.loads);
    double residual = 0, size = 1;
    VecNorm(left, NORM_2, &residual);
    VecNorm(system.loads, NORM_2, &size);
    VecDestroy(&left);
    KSPDestroy(&solver);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    double own = 1024. * static_cast<double>(usage.ru_maxrss), peak = 0;
    MPI_Reduce(&own, &peak, 1, MPI_DOUBLE, MPI_SUM, 0, PETSC_COMM_WORLD);
    if (rank == 0) std::printf("%.6f %d %.3e %.0f\n", seconds, static_cast<int>(iterations), residual / size, peak);
  }
  VecDestroy(&system.loads);
  VecDestroy(&system.motion);
  MatDestroy(&system.matrix);
  PetscFinalize();
  return 0;
}
