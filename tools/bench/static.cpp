#include <fmt/format.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#ifdef ELASTIN_BENCH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "core/linear/sparse_stiffness.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "lab/experiment/tension/tension.h"
#include "measure.h"
#include "tension_cube.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;
using Sparse = Eigen::SparseMatrix<double>;

struct Solved {
  VectorX motion;  ///< empty for large displacements
  double newton = kNone, iterations = kNone, residual = kNone;
};

Solved elastin_linear(TensionCube& problem, const LinearMethod& method) {
  const Positions no_displacement = Positions::Zero(3, problem.body.size());
  const StaticOptions options{.linear = true, .method = method, .tolerance = kTolerance};
  const StaticResponse response =
      static_response(problem.model, problem.body.rest, problem.loads, no_displacement, options);
  if (response.result.outcome != Outcome::converged) throw std::runtime_error(response.result.cause);
  return {Eigen::Map<const VectorX>(response.motion.data(), response.motion.size()), kNone,
          static_cast<double>(response.result.linear_iterations)};
}

Solved elastin_pcg(TensionCube& problem, const Sparse&) { return elastin_linear(problem, "pcg"); }
Solved elastin_multigrid(TensionCube& problem, const Sparse&) { return elastin_linear(problem, "multigrid"); }

Solved elastin_newton(TensionCube& problem, const Sparse&) {
  State state = state_at_rest(problem.body);
  const StaticOptions options{.tolerance = kTolerance};
  const StaticResult result = solve_static(problem.model, state, options);
  if (result.outcome != Outcome::converged) throw std::runtime_error(result.cause);
  return {{},
          static_cast<double>(result.newton_iterations),
          static_cast<double>(result.linear_iterations),
          result.residual};
}

Solved eigen_cg(TensionCube& problem, const Sparse& matrix) {
  Eigen::setNbThreads(threads());
  Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper, Eigen::DiagonalPreconditioner<double>> solver(matrix);
  solver.setTolerance(kTolerance);
  const VectorX motion = solver.solve(free_loads(problem));
  return {motion, kNone, static_cast<double>(solver.iterations())};
}

/// A shift lets the factorisation pass the rigid motions; refinement takes its effect away again.
template <class Factorisation>
Solved factorised(TensionCube& problem, const Sparse& matrix) {
  const VectorX loads = free_loads(problem);
  Sparse shifted = matrix;
  shifted.diagonal().array() += 1e-9 * matrix.diagonal().mean();
  const Factorisation factor(shifted);
  VectorX motion = factor.solve(loads);
  for (int step = 0; step < 10; ++step) {
    const VectorX left = loads - matrix * motion;
    if (left.norm() <= kTolerance * loads.norm()) break;
    motion += factor.solve(left);
  }
  return {motion};
}

/// Of a body for which no matrix is made: what is left is found with the stiffness itself.
Solved elastin_scattered(TensionCube& problem, const Sparse&) {
  Solved solved = elastin_linear(problem, "multigrid");
  const State rest = state_at_rest(problem.body);
  Positions left(3, problem.body.size()), loads = problem.loads;
  Tangent(problem.model, rest).apply(Eigen::Map<const Positions>(solved.motion.data(), 3, left.cols()), left);
  left = loads - left;
  keep_free(problem.model.supports, left);
  keep_free(problem.model.supports, loads);
  solved.residual = left.norm() / loads.norm();
  solved.motion.resize(0);
  return solved;
}

struct Contender {
  const char* name;
  Solved (*solve)(TensionCube&, const Sparse&);
  bool assembles, compared;  ///< `compared`: solves the same linear problem as the peer
  int most_threads, largest_side;
  int slow_side = 1 << 20;  ///< from here on it takes so long that it runs once, alone
  Numbering numbering = Numbering::lattice;
};

// Eigen's factorisation takes minutes where iterations take a tenth of a second: small bodies only.
constexpr Contender kContenders[] = {
    {"elastin multigrid, small displacements", elastin_multigrid, false, true, 1 << 10, 1 << 20},
    {"elastin multigrid, molecules and connections numbered at random", elastin_scattered, false, false, 1 << 10,
     1 << 20, 0, Numbering::at_random},
    {"elastin multigrid, the same numbered in space first", elastin_scattered, false, false, 1 << 10, 1 << 20, 0,
     Numbering::in_space},
    {"Eigen ConjugateGradient", eigen_cg, true, true, 1 << 10, 47},
    {"elastin pcg, small displacements", elastin_pcg, false, true, 1 << 10, 1 << 20},
    {"Eigen SimplicialLDLT", &factorised<Eigen::SimplicialLDLT<Sparse>>, true, true, 1, 10},
#ifdef ELASTIN_BENCH_CHOLMOD
    {"CHOLMOD (supernodal), by BLAS on its own threads", &factorised<Eigen::CholmodSupernodalLLT<Sparse>>, true, true,
     1 << 10, 47, 30},
#endif
    {"elastin, large displacements", elastin_newton, false, false, 1 << 10, 1 << 20},
};
constexpr const Contender& kPeer = kContenders[3];

struct Entry {
  const Contender* contender;
  int threads;
};

/// Every entry on one problem in one process, in turn.
std::vector<Figures> race(int side, const std::vector<Entry>& entries, int repeats) {
  std::vector<double> build, assembly;
  std::unique_ptr<TensionCube> problem;
  Sparse matrix;
  set_threads(entries.back().threads);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    problem.reset();
    build.push_back(seconds_of([&] { problem = std::make_unique<TensionCube>(side); }));
    // Without a peer of this size the matrix still serves to check the answer.
    if (repeat == 0 || side <= kPeer.largest_side)
      assembly.push_back(seconds_of([&] { matrix = assembled(*problem); }));
  }
  const VectorX loads = free_loads(*problem);
  std::vector<Figures> found(entries.size());
  std::vector<std::function<void()>> works;
  std::vector<Solved> solved(entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i)
    works.push_back([&, i] {
      set_threads(entries[i].threads);
      solved[i] = entries[i].contender->solve(*problem, matrix);
    });
  const std::vector<Sample> samples = interleaved(works, repeats);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double build_all = summary(build).median + (entries[i].contender->assembles ? summary(assembly).median : 0);
    found[i].springs = problem->body.connections.size();
    found[i].build = build_all;
    found[i].minimum = samples[i].minimum;
    found[i].median = samples[i].median;
    found[i].newton = solved[i].newton;
    found[i].iterations = solved[i].iterations;
    const VectorX& motion = solved[i].motion;
    found[i].residual = motion.size() ? (loads - matrix * motion).norm() / loads.norm() : solved[i].residual;
    if (!(found[i].residual <= 2 * kTolerance))
      throw std::runtime_error(std::string(entries[i].contender->name) + ": not solved");
  }
  return found;
}

/// One entry alone in a process, once.
std::vector<Figures> memory(int side, const Entry& entry) {
  const double before = peak_memory();
  set_threads(entry.threads);
  TensionCube problem(side, entry.contender->numbering);
  const Sparse matrix = entry.contender->assembles ? assembled(problem) : Sparse();
  Figures figures;
  Solved solved;
  figures.median = figures.minimum = seconds_of([&] { solved = entry.contender->solve(problem, matrix); });
  figures.peak = peak_memory() - before;
  if (problem.renumbering > 0) figures.build = problem.renumbering;
  figures.iterations = solved.iterations;
  figures.residual = solved.residual;
  if (entry.contender->assembles && solved.motion.size()) {
    const VectorX loads = free_loads(problem);
    figures.residual = (loads - matrix * solved.motion).norm() / loads.norm();
  }
  return {figures};
}

/// PETSc in processes of its own, right after: so many MPI ranks for so many threads. Its time is without the matrix.
std::vector<Row> petsc_rows(int side, const Settings& settings) {
  constexpr int largest = 47;
  std::vector<Row> rows;
  const std::string name = "PETSc GAMG (smoothed aggregation, rigid motions)";
#ifdef ELASTIN_BENCH_GAMG
  if (side > largest) return rows;
  for (const int ranks : settings.threads) {
    const std::string line =
        fmt::format("OMP_NUM_THREADS=1 mpirun --allow-run-as-root --oversubscribe -np {} '{}' {} {}", ranks,
                    ELASTIN_BENCH_GAMG, side, settings.repeats + 1);
    FILE* output = popen(line.c_str(), "r");
    std::vector<double> seconds;
    Figures figures;
    double time = 0, iterations = 0, residual = 0, peak = 0;
    while (output && std::fscanf(output, "%lf %lf %lf %lf", &time, &iterations, &residual, &peak) == 4)
      seconds.push_back(time);
    if (!output || pclose(output) != 0 || seconds.size() < 2 || !(residual < 10 * kTolerance)) {
      rows.push_back({"static", name, side, ranks, 0, {}, "failed: " + line});
      continue;
    }
    seconds.erase(seconds.begin());  // to warm up
    const Sample sample = summary(seconds);
    figures.minimum = sample.minimum;
    figures.median = sample.median;
    figures.iterations = iterations;
    figures.residual = residual;
    figures.peak = peak;
    rows.push_back({"static", name, side, ranks, settings.repeats, figures, "threads: MPI ranks; peak: of all ranks"});
  }
#else
  rows.push_back({"static",
                  name,
                  side,
                  settings.threads.back(),
                  0,
                  {},
                  "skipped: PETSc was not here at build time; apt-get install libpetsc-real-dev"});
  (void)largest;
#endif
  return rows;
}

}  // namespace

std::vector<Row> run_static(const Settings& settings) {
  std::vector<Row> rows;
  for (const int side : settings.sides) {
    say("static, side " + std::to_string(side));
    std::vector<Entry> entries, slow;
    for (const Contender& contender : kContenders)
      for (const int count : settings.threads)
        if (count <= contender.most_threads && side <= contender.largest_side)
          (side < contender.slow_side ? entries : slow).push_back({&contender, count});
    std::vector<Figures> found = in_child([&] { return race(side, entries, settings.repeats); });
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Contender& contender = *entries[i].contender;
      found[i].peak = in_child([&] { return memory(side, entries[i]); }).front().peak;
      double peer = kNone, whole = kNone;
      for (std::size_t j = 0; j < entries.size(); ++j)
        if (entries[j].contender == &kPeer && entries[j].threads <= entries[i].threads) {
          peer = std::fmin(peer, found[j].minimum);  // fmin takes the number where the other is none
          whole = std::fmin(whole, found[j].build + found[j].median);
        }
      if (contender.compared) {
        found[i].ratio = peer / found[i].minimum;
        found[i].whole_ratio = whole / (found[i].build + found[i].median);
      }
      rows.push_back({"static", contender.name, side, entries[i].threads, settings.repeats, found[i],
                      contender.assembles ? "peak: assembly from triplets" : ""});
    }
    for (std::size_t i = 0; i < slow.size(); ++i)
      if (i + 1 == slow.size() || slow[i + 1].contender != slow[i].contender)  // on the most threads
        rows.push_back({"static", slow[i].contender->name, side, slow[i].threads, 1,
                        in_child([&] { return memory(side, slow[i]); }).front(), "once, alone"});
    for (const Row& row : petsc_rows(side, settings)) rows.push_back(row);
  }
  return rows;
}

}  // namespace bench
