#include "petsc/linear.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/dense.h"
#include "core/linear/block_inverse.h"

namespace elastin::petsc {
namespace {

constexpr const char* kPrefix = "elastin_";

/// The stiffness as a matrix, for preconditioners of PETSc: rows of owned molecules, unit blocks in fixed directions.
Matrix assembled(const SharedTangent& tangent) {
  SharedModel& model = tangent.model();
  const SharedBody& body = model.body();
  std::vector<Matrix3> free(body.size(), Matrix3::Identity());
  for (const Support& support : model.local().supports) free[support.molecule] = support.free;
  Matrix matrix;
  check(MatCreate(body.communicator(), matrix.out()));
  check(MatSetSizes(matrix, 3 * body.owned(), 3 * body.owned(), PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix, MATAIJ));
  check(MatSetBlockSize(matrix, 3));
  check(MatSeqAIJSetPreallocation(matrix, 90, nullptr));
  check(MatMPIAIJSetPreallocation(matrix, 90, nullptr, 45, nullptr));
  check(MatSetOption(matrix, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));  // cells may reach further
  const auto add = [&](int a, int b, const Matrix3& block) {
    if (model.of_step() && a >= body.owned()) return;  // another process has the whole row
    const PetscInt row = body.numbers()[a], column = body.numbers()[b];
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> values = free[a] * block * free[b];
    check(MatSetValuesBlocked(matrix, 1, &row, 1, &column, values.data(), ADD_VALUES));
  };
  tangent.local().visit_blocks(add);
  for (const Support& support : model.supports()) {
    const auto molecule = static_cast<std::size_t>(support.molecule);
    const double size = tangent.diagonal()[molecule].trace() / 3;
    const PetscInt row = body.numbers()[molecule];
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> values = size * (Matrix3::Identity() - support.free);
    check(MatSetValuesBlocked(matrix, 1, &row, 1, &row, values.data(), ADD_VALUES));
  }
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

/// Motions as a whole, which algebraic multigrid has to know.
void set_rigid_motions(const SharedTangent& tangent, Mat matrix) {
  const SharedBody& body = tangent.model().body();
  Vector coordinates = body.make_vector();
  body.write(tangent.positions(), coordinates);
  MatNullSpace motions = nullptr;
  check(MatNullSpaceCreateRigidBody(coordinates, &motions));
  check(MatSetNearNullSpace(matrix, motions));
  check(MatNullSpaceDestroy(&motions));
}

/// What multiplies residuals: the inverse blocks of owned molecules, and a cycle over the boxes; or one of PETSc's.
struct Preconditioner {
  const SharedTangent& tangent;
  std::vector<Matrix3> inverses;
  std::unique_ptr<BoxCycle> boxes;
  Matrix matrix;
  PreconditionerHandle asked;

  explicit Preconditioner(const SharedTangent& a_tangent, const BoxHierarchy* hierarchy) : tangent(a_tangent) {
    for (const Matrix3& block : tangent.diagonal()) inverses.push_back(positive_inverse(block));
    SharedModel& model = tangent.model();
    for (const Support& support : model.supports()) {
      const auto molecule = static_cast<std::size_t>(support.molecule);
      inverses[molecule] = positive_inverse(tangent.diagonal()[molecule], support.free);
    }
    if (hierarchy) boxes = std::make_unique<BoxCycle>(*hierarchy, tangent.local(), model.local().supports);
  }

  explicit Preconditioner(const SharedTangent& a_tangent) : tangent(a_tangent), matrix(assembled(a_tangent)) {
    set_rigid_motions(tangent, matrix);
    // What supports leave free as a whole the last grid's own factorisation cannot take.
    PetscBool named = PETSC_FALSE;
    check(PetscOptionsHasName(nullptr, kPrefix, "-mg_coarse_sub_pc_type", &named));
    if (!named) check(PetscOptionsSetValue(nullptr, "-elastin_mg_coarse_sub_pc_type", "svd"));
    check(PCCreate(tangent.model().body().communicator(), asked.out()));
    check(PCSetOptionsPrefix(asked, kPrefix));
    check(PCSetOperators(asked, matrix, matrix));
    check(PCSetFromOptions(asked));
    check(PCSetUp(asked));
  }

  std::string name() const {
    const char* type = nullptr;
    if (asked) check(PCGetType(asked, &type));
    return type ? type : boxes ? "multigrid" : "pcg";
  }

  void apply(Vec force, Vec motion) const {
    if (asked) {
      check(PCApply(asked, force, motion));
      return tangent.model().keep_free(motion);  // aggregates join fixed directions to free ones
    }
    const PetscScalar* f = nullptr;
    PetscScalar* x = nullptr;
    check(VecGetArrayRead(force, &f));
    check(VecGetArrayWrite(motion, &x));
    for (std::size_t i = 0; i < inverses.size(); ++i)
      Eigen::Map<Vector3>(x + 3 * i) = inverses[i] * Eigen::Map<const Vector3>(f + 3 * i);
    check(VecRestoreArrayWrite(motion, &x));
    check(VecRestoreArrayRead(force, &f));
    if (boxes) boxes->add(force, motion);
    tangent.model().keep_free(motion);
  }
};

/// Nothing is thrown through PETSc.
template <class Call>
PetscErrorCode guarded(Call&& call) {
  try {
    call();
    return 0;
  } catch (...) {
    return PETSC_ERR_LIB;
  }
}

PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
  return guarded([&] {
    const SharedTangent* tangent = nullptr;
    check(MatShellGetContext(matrix, &tangent));
    tangent->apply(x, y);
  });
}

PetscErrorCode precondition(PC pc, Vec x, Vec y) {
  return guarded([&] {
    const Preconditioner* preconditioner = nullptr;
    check(PCShellGetContext(pc, &preconditioner));
    preconditioner->apply(x, y);
  });
}

/// Gives the operator the motions as a whole that supports and forces leave to the body: what rounding on the last
/// grid makes of them is then taken out. As elastin::RigidMotions.
void set_free_motions(const SharedTangent& tangent, Mat operation) {
  const SharedModel& model = tangent.model();
  const SharedBody& body = model.body();
  const Positions& x = tangent.positions();
  Vector3 middle;
  double spread = 0, stiffness = 0, supports = body.sum(static_cast<double>(model.supports().size()));
  const double molecules = body.sum(body.owned());
  for (int k = 0; k < 3; ++k) middle[k] = body.sum(x.row(k).head(body.owned()).sum()) / molecules;
  spread = std::sqrt(body.sum((x.leftCols(body.owned()).colwise() - middle).squaredNorm()) / molecules);
  for (const Matrix3& block : tangent.diagonal()) stiffness += block.trace() / 3;
  stiffness = body.sum(stiffness) / molecules;
  if (!(spread > 0)) return;
  using Six = Eigen::Matrix<double, 6, 1>;
  const auto motion = [&](const Six& six, const Vector3& at) -> Vector3 {
    return six.head<3>() + six.tail<3>().cross(Vector3((at - middle) / spread));
  };
  Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Support& support : model.supports()) {
    Eigen::Matrix<double, 3, 6> part;
    for (int k = 0; k < 6; ++k) part.col(k) = motion(Six::Unit(k), x.col(support.molecule));
    part -= (support.free * part).eval();
    held += part.transpose() * part;
  }
  MPI_Allreduce(MPI_IN_PLACE, held.data(), 36, MPI_DOUBLE, MPI_SUM, body.communicator());
  const SymmetricEigen eigen = symmetric_eigen(held);
  std::vector<Vector> motions;
  Vector forces = body.make_vector();
  Positions local(3, body.size());
  for (int k = 0; k < 6; ++k) {
    if (eigen.values[k] > 1e-12 * std::max(1., supports)) continue;
    for (int a = 0; a < body.size(); ++a) local.col(a) = motion(eigen.vectors.col(k), x.col(a));
    Vector one = body.make_vector();
    body.write(local, one);
    tangent.apply(one, forces);
    double force = 0, size = 0;
    check(VecNorm(forces, NORM_2, &force));
    check(VecNorm(one, NORM_2, &size));
    if (force > 1e-9 * stiffness * size) continue;
    for (const Vector& other : motions) {
      double product = 0;
      check(VecDot(one, other, &product));
      check(VecAXPY(one, -product, other));
    }
    double left = 0;
    check(VecNorm(one, NORM_2, &left));
    if (!(left > 1e-9 * size)) continue;  // of molecules on a line the turn about it moves none
    check(VecScale(one, 1 / left));
    motions.push_back(std::move(one));
  }
  if (motions.empty()) return;
  const std::vector<Vec> vectors(motions.begin(), motions.end());
  MatNullSpace free_motions = nullptr;
  check(MatNullSpaceCreate(body.communicator(), PETSC_FALSE, static_cast<PetscInt>(vectors.size()), vectors.data(),
                           &free_motions));
  check(MatSetNullSpace(operation, free_motions));
  check(MatNullSpaceDestroy(&free_motions));
}

LinearStatus status_of(KSPConvergedReason reason) {
  if (reason > 0) return LinearStatus::solved;
  if (reason == KSP_DIVERGED_INDEFINITE_MAT) return LinearStatus::negative_mode;
  if (reason == KSP_DIVERGED_DTOL || reason == KSP_DIVERGED_NANORINF) return LinearStatus::zero_mode;
  return LinearStatus::limit_reached;
}

}  // namespace

SharedTangent::SharedTangent(SharedModel& model, const Tangent& tangent) : model_(model), tangent_(tangent) {
  const SharedBody& body = model.body();
  diagonal_.resize(body.owned());
  Vector sums = body.make_vector();
  Positions column(3, body.size()), owned;
  for (int k = 0; k < 3; ++k) {
    for (int a = 0; a < body.size(); ++a) column.col(a) = tangent_.diagonal(a).col(k);
    model.collect(column, sums);
    body.read(sums, owned);
    for (int a = 0; a < body.owned(); ++a) diagonal_[a].col(k) = owned.col(a);
  }
  motion_.resize(3, body.size());
  forces_.resize(3, body.size());
}

void SharedTangent::apply(const Positions& local, Vec result) const {
  tangent_.apply(local, forces_, workspace_);
  model_.collect(forces_, result);
}

void SharedTangent::apply(Vec motion, Vec result) const {
  model_.body().spread(motion, motion_);
  apply(motion_, result);
  model_.keep_free(result);
}

double SharedTangent::rounding_floor() const {
  const SharedBody& body = model_.body();
  double sum = 0;
  for (const Matrix3& block : diagonal_) sum += block.squaredNorm();
  const double reach = body.largest(positions().cwiseAbs().maxCoeff());
  return std::numeric_limits<double>::epsilon() * reach * std::sqrt(body.sum(sum));
}

SharedLinearResult solve_linear(const SharedTangent& tangent, const BoxHierarchy* boxes, Vec rhs, double tolerance,
                                Vec solution) {
  const SharedBody& body = tangent.model().body();
  SharedLinearResult result;
  double size = 0;
  check(VecNorm(rhs, NORM_2, &size));
  check(VecSet(solution, 0));
  PetscBool asked = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, kPrefix, "-pc_type", &asked));
  result.preconditioner = boxes ? "multigrid" : "pcg";
  if (size == 0) return result;
  Matrix operation;
  const PetscInt rows = 3 * body.owned();
  check(MatCreateShell(body.communicator(), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE,
                       const_cast<SharedTangent*>(&tangent), operation.out()));
  check(MatShellSetOperation(operation, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
  check(MatSetOption(operation, MAT_SYMMETRIC, PETSC_TRUE));
  if (boxes || asked) set_free_motions(tangent, operation);
  Solver solver;
  check(KSPCreate(body.communicator(), solver.out()));
  check(KSPSetType(solver, KSPCG));
  check(KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED));
  PetscInt all = 0;
  check(VecGetSize(rhs, &all));
  check(KSPSetTolerances(solver, tolerance, 1e-300, 1e8, 10000 + all / 10));
  PC pc = nullptr;
  check(KSPGetPC(solver, &pc));
  const Preconditioner preconditioner = asked ? Preconditioner(tangent) : Preconditioner(tangent, boxes);
  result.preconditioner = preconditioner.name();
  check(KSPSetOperators(solver, operation, operation));
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetContext(pc, const_cast<Preconditioner*>(&preconditioner)));
  check(PCShellSetApply(pc, precondition));
  check(KSPSolve(solver, rhs, solution));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  double left = 0;
  check(KSPGetConvergedReason(solver, &reason));
  check(KSPGetIterationNumber(solver, &iterations));
  check(KSPGetResidualNorm(solver, &left));
  result.iterations = static_cast<int>(iterations);
  if (reason == KSP_DIVERGED_INDEFINITE_PC && boxes && !asked) {  // the last grid's stiffness is not positive
    SharedLinearResult plain = solve_linear(tangent, nullptr, rhs, tolerance, solution);
    plain.iterations += result.iterations;
    return plain;
  }
  result.status = status_of(reason);
  result.residual = left / size;
  double reached = 0;
  check(VecNorm(solution, NORM_2, &reached));
  if (reason < 0 && !(reached > 0)) preconditioner.apply(rhs, solution);  // the force itself leads downhill
  return result;
}

bool find_negative_direction(const SharedTangent& tangent, Vec direction, int& iterations) {
  constexpr double tolerance = 1e-5;
  const SharedBody& body = tangent.model().body();
  const Preconditioner preconditioner(tangent, nullptr);
  Positions local(3, body.size());
  for (int a = 0; a < body.size(); ++a) local.col(a) = scattered_direction(body.number(a));
  Vector r = body.make_vector(), z = body.make_vector(), kp = body.make_vector();
  const Vec p = direction;
  body.write(local, r);
  tangent.model().keep_free(r);
  const auto dot = [](Vec a, Vec b) {
    double product = 0;
    check(VecDot(a, b, &product));
    return product;
  };
  const double first = dot(r, r);
  preconditioner.apply(r, z);
  check(VecCopy(z, p));
  double now = dot(r, z), size_of_p = now;  // pᵀ M p, M the preconditioner: what pᵀ K p is small or large against
  for (double limit = 10000 + 0.3 * static_cast<double>(body.all_molecules()); first > 0 && limit > 0; --limit) {
    tangent.apply(p, kp);
    const double curvature = dot(p, kp);
    if (!(curvature > 1e-13 * size_of_p)) return curvature < -1e-10 * size_of_p;
    check(VecAXPY(r, -now / curvature, kp));
    ++iterations;
    if (dot(r, r) <= tolerance * tolerance * first) break;
    preconditioner.apply(r, z);
    const double before = std::exchange(now, dot(r, z)), beta = now / before;
    check(VecAYPX(p, beta, z));
    size_of_p = now + beta * beta * size_of_p;
  }
  return false;
}

}  // namespace elastin::petsc
