#include "petsc/boxes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/linear/box_assembly.h"

namespace elastin::petsc {
namespace {

/// Steps of the polynomial that smooths before and after each coarser grid.
constexpr int kSmoothing = 1;

/// A grid is the last one where it is small, or so thin that larger boxes would be thicker than the body; as Multigrid.
bool is_last(const BoxGrid& grid) {
  constexpr int small = 64, most = 4000;
  return grid.points() <= small || (grid.points() <= most && 4 * grid.coarser().grid.boxes() >= grid.boxes());
}

/// Rows of numbers that each process has of its own, three for each row here (MAIJ).
class Interpolation {
 public:
  Interpolation(MPI_Comm communicator, PetscInt rows, PetscInt all_columns, int most) : most_(most) {
    check(MatCreateAIJ(communicator, rows, PETSC_DECIDE, PETSC_DETERMINE, all_columns, most, nullptr, most, nullptr,
                       weights_.out()));
    check(MatSetOption(weights_, MAT_IGNORE_ZERO_ENTRIES, PETSC_TRUE));
  }
  void add(PetscInt row, PetscInt column, double weight) {
    check(MatSetValue(weights_, row, column, weight, INSERT_VALUES));
  }
  Matrix finished() {
    check(MatAssemblyBegin(weights_, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(weights_, MAT_FINAL_ASSEMBLY));
    Matrix result;
    check(MatCreateMAIJ(weights_, 3, result.out()));
    return result;
  }

 private:
  int most_;
  Matrix weights_;
};

/// Rows of a layout that PETSc decides: first, and how many.
std::pair<PetscInt, PetscInt> own_rows(MPI_Comm communicator, PetscInt all) {
  PetscInt count = PETSC_DECIDE, rows = all;
  check(PetscSplitOwnership(communicator, &count, &rows));
  PetscInt last = 0;
  MPI_Scan(&count, &last, 1, MPIU_INT, MPI_SUM, communicator);
  return {last - count, count};
}

/// The sum over all processes of their parts of a level, on the points of the whole grid: its upper half, or, to be
/// factorised, all of it.
Matrix summed(const BoxLevel& part, const BoxGrid& grid, bool upper, MPI_Comm communicator) {
  const PetscInt points = grid.points();
  const auto [first, count] = own_rows(communicator, points);
  std::vector<PetscInt> here(count, 0), elsewhere = here;
  std::vector<int> others;
  for (PetscInt row = 0; row < count; ++row) {
    others.clear();
    for (const int corner : grid.around(static_cast<int>(first + row)))
      for (const int other : grid.corners(corner / BoxGrid::kCorners)) others.push_back(other);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (const int other : others)
      if (!upper || other >= first + row) ++(other >= first && other < first + count ? here : elsewhere)[row];
  }
  Matrix matrix;
  check((upper ? MatCreateSBAIJ : MatCreateBAIJ)(communicator, 3, 3 * count, 3 * count, 3 * points, 3 * points, 0,
                                                 here.data(), 0, elsewhere.data(), matrix.out()));
  std::vector<PetscInt> columns;
  std::vector<double> values;
  double size = 0;
  for (int point = 0; point < part.points(); ++point) {
    const PetscInt row = grid.point_at(part.grid().at(point));
    columns.clear();
    std::vector<Matrix3> blocks;
    for (int n = 0; const int other : part.neighbours(point)) {
      const int number = n++;
      if (other == point && number > 0) continue;
      const PetscInt column = grid.point_at(part.grid().at(other));
      if (upper && column < row) continue;
      blocks.push_back(part.block_to(point, number));
      if (other == point) size += blocks.back().trace();
      columns.push_back(column);
    }
    values.clear();
    for (int r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < columns.size(); ++c)
        for (int k = 0; k < 3; ++k) values.push_back(blocks[c](r, k));
    check(MatSetValuesBlocked(matrix, 1, &row, static_cast<PetscInt>(columns.size()), columns.data(), values.data(),
                              ADD_VALUES));
  }
  // What moves as a whole may be free to; a point in the air certainly is.
  MPI_Allreduce(MPI_IN_PLACE, &size, 1, MPI_DOUBLE, MPI_SUM, communicator);
  const double least = 1e-9 * size / (3. * static_cast<double>(points));
  const std::array<double, 9> little{least, 0, 0, 0, least, 0, 0, 0, least};
  for (PetscInt row = first; row < first + count; ++row)
    check(MatSetValuesBlocked(matrix, 1, &row, 1, &row, little.data(), ADD_VALUES));
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  check(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  return matrix;
}

/// The largest eigenvalue of D⁻¹ A, by powers from a motion that is the same on any number of processes.
double largest_eigenvalue(Mat matrix, PC blocks) {
  Vector x, y, z;
  check(MatCreateVecs(matrix, x.out(), y.out()));
  check(VecDuplicate(x, z.out()));
  PetscInt first = 0, last = 0;
  check(VecGetOwnershipRange(x, &first, &last));
  PetscScalar* values = nullptr;
  check(VecGetArrayWrite(x, &values));
  for (PetscInt i = first; i < last; ++i)
    values[i - first] =
        std::sin(1. + 12.9898 * static_cast<double>(i / 3 % 4099) + 78.233 * static_cast<double>(i % 3));
  check(VecRestoreArrayWrite(x, &values));
  double largest = 1, before = 0, size = 0;
  check(VecNorm(x, NORM_2, &before));
  for (int step = 0; step < 10; ++step) {
    check(MatMult(matrix, x, y));
    check(PCApply(blocks, y, z));
    check(VecNorm(z, NORM_2, &size));
    if (!(before > 0) || !std::isfinite(size)) break;
    largest = std::max(1., size / before);
    check(VecCopy(z, x));
    check(VecScale(x, 1 / size));
    before = 1;
  }
  return largest;
}

PetscErrorCode apply_blocks(PC pc, Vec x, Vec y) {
  const std::vector<Matrix3>* blocks = nullptr;
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(PCShellGetContext(pc, &blocks));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  for (std::size_t i = 0; i < blocks->size(); ++i)
    Eigen::Map<Vector3>(to + 3 * i) = (*blocks)[i] * Eigen::Map<const Vector3>(from + 3 * i);
  PetscCall(VecRestoreArrayWrite(y, &to));
  return VecRestoreArrayRead(x, &from);
}

/// The inverses of the diagonal blocks of this process's points: of symmetric matrices PETSc has none.
std::vector<Matrix3> inverse_blocks(Mat matrix) {
  Mat own = nullptr;
  check(MatGetDiagonalBlock(matrix, &own));
  PetscInt rows = 0;
  check(MatGetLocalSize(matrix, &rows, nullptr));
  std::vector<Matrix3> inverses;
  for (PetscInt row = 0; row < rows; row += 3) {
    const std::array<PetscInt, 3> at{row, row + 1, row + 2};
    Matrix3 block;
    check(MatGetValues(own, 3, at.data(), 3, at.data(), block.data()));
    inverses.push_back(block.inverse());
  }
  return inverses;
}

void set_smoother(KSP smoother, Mat matrix, std::vector<Matrix3>& inverses) {
  check(KSPSetOperators(smoother, matrix, matrix));
  check(KSPSetType(smoother, KSPCHEBYSHEV));
  check(KSPSetNormType(smoother, KSP_NORM_NONE));
  check(KSPSetConvergenceTest(smoother, KSPConvergedSkip, nullptr, nullptr));
  check(KSPSetTolerances(smoother, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, kSmoothing));
  PC blocks = nullptr;
  check(KSPGetPC(smoother, &blocks));
  inverses = inverse_blocks(matrix);
  check(PCSetType(blocks, PCSHELL));
  check(PCShellSetContext(blocks, &inverses));
  check(PCShellSetApply(blocks, apply_blocks));
  check(PCSetOperators(blocks, matrix, matrix));
  check(PCSetUp(blocks));
  const double largest = 1.1 * largest_eigenvalue(matrix, blocks);
  check(KSPChebyshevSetEigenvalues(smoother, largest, 0.5 * largest));
}

}  // namespace

BoxHierarchy::BoxHierarchy(const Tangent& local, const SharedBody& body) : frame_(frame_of(body.given())), body_(body) {
  const Body& own = body.local();
  BoxGrid finest(frame_);
  const auto use = [&](const Vector3& position) { finest.used()[finest.outline_box(position)] = 1; };
  for (int a = 0; a < own.size(); ++a) use(own.rest.col(a));
  for (const auto& [a, b] : own.connections.ends) use((own.rest.col(a) + own.rest.col(b)) / 2);
  for (const auto& cell : own.tetrahedra) use(own.rest(Eigen::all, cell).rowwise().mean());
  for (const auto& cell : own.triangles) use(own.rest(Eigen::all, cell).rowwise().mean());
  local.visit_points([&](const StiffPoints& points) {
    for (int point = 0; point < points.stiff_points(); ++point) use(points.place_of(point));
  });
  MPI_Allreduce(MPI_IN_PLACE, finest.used().data(), static_cast<int>(finest.used().size()), MPI_CHAR, MPI_BOR,
                body.communicator());
  finest.number();
  grids_.push_back(std::move(finest));
  while (!is_last(grids_.back())) grids_.push_back(grids_.back().coarser().grid);

  const MPI_Comm communicator = body.communicator();
  Interpolation molecules(communicator, body.owned(), grids_.front().points(), BoxGrid::kCorners);
  for (int a = 0; a < body.owned(); ++a) {
    const BoxGrid& grid = grids_.front();
    const int box = grid.number_of(grid.outline_box(own.rest.col(a)));
    const auto values = BoxGrid::values_at(grid.at_in(box, own.rest.col(a)));
    for (int c = 0; c < BoxGrid::kCorners; ++c) molecules.add(body.numbers()[a], grid.corners(box)[c], values[c]);
  }
  to_molecules_ = molecules.finished();
  for (std::size_t level = 0; level + 1 < grids_.size(); ++level) {
    const BoxGrid &fine = grids_[level], &coarse = grids_[level + 1];
    const auto [first, count] = own_rows(communicator, fine.points());
    Interpolation weights(communicator, count, coarse.points(), BoxGrid::kCorners);
    for (PetscInt point = first; point < first + count; ++point) {
      const auto& [x, y, z] = fine.at(static_cast<int>(point));
      const double weight = 1. / static_cast<double>(1 << (x % 2 + y % 2 + z % 2));
      for (int corner = 0; corner < BoxGrid::kCorners; ++corner) {
        const int dx = corner % 2, dy = corner / 2 % 2, dz = corner / 4;
        if ((dx && x % 2 == 0) || (dy && y % 2 == 0) || (dz && z % 2 == 0)) continue;
        const int from = coarse.point_at({x / 2 + dx, y / 2 + dy, z / 2 + dz});
        if (from >= 0) weights.add(point, from, weight);
      }
    }
    interpolations_.push_back(weights.finished());
  }
}

BoxCycle::BoxCycle(const BoxHierarchy& hierarchy, const Tangent& local, const std::vector<Support>& supports)
    : hierarchy_(hierarchy) {
  const MPI_Comm communicator = hierarchy.body().communicator();
  std::unique_ptr<BoxLevel> part = assemble_part(local, supports, hierarchy.frame()).level;
  for (std::size_t level = 0; level < hierarchy.grids().size(); ++level) {
    if (level > 0) part = part->coarser(part->grid().coarser(), true);
    const bool last = level + 1 == hierarchy.grids().size();
    stiffness_.push_back(summed(*part, hierarchy.grids()[level], !last, communicator));
  }
  part.reset();
  inverses_.resize(stiffness_.size());
  const auto levels = static_cast<PetscInt>(stiffness_.size());
  check(KSPCreate(communicator, cycle_.out()));
  check(KSPSetType(cycle_, KSPPREONLY));
  check(KSPSetOperators(cycle_, stiffness_.front(), stiffness_.front()));
  PC multigrid = nullptr;
  check(KSPGetPC(cycle_, &multigrid));
  check(PCSetType(multigrid, PCMG));
  check(PCMGSetLevels(multigrid, levels, nullptr));
  for (PetscInt level = 0; level < levels; ++level) {  // PETSc's first level is the coarsest
    const auto grid = static_cast<std::size_t>(levels - 1 - level);
    KSP smoother = nullptr;
    if (level == 0) {
      Matrix single;  // numbers and no blocks, as all factorisations take them
      check(MatConvert(stiffness_[grid], MATAIJ, MAT_INITIAL_MATRIX, single.out()));
      stiffness_[grid] = std::move(single);
      check(PCMGGetCoarseSolve(multigrid, &smoother));
      check(KSPSetOperators(smoother, stiffness_[grid], stiffness_[grid]));
      check(KSPSetType(smoother, KSPPREONLY));
      PC redundant = nullptr;
      check(KSPGetPC(smoother, &redundant));
      check(PCSetType(redundant, PCREDUNDANT));
      continue;
    }
    check(PCMGSetInterpolation(multigrid, level, hierarchy.interpolation(grid)));
    check(PCMGGetSmoother(multigrid, level, &smoother));
    set_smoother(smoother, stiffness_[grid], inverses_[grid]);
  }
  check(KSPSetUp(cycle_));
  check(MatCreateVecs(stiffness_.front(), motion_.out(), force_.out()));
}

void BoxCycle::add(Vec force, Vec motion) const {
  check(MatMultTranspose(hierarchy_.to_molecules(), force, force_));
  check(KSPSolve(cycle_, force_, motion_));
  check(MatMultAdd(hierarchy_.to_molecules(), motion_, motion, motion));
}

}  // namespace elastin::petsc
