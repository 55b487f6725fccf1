#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "elastin/base/threads.h"
#include "elastin/simulation/catalog.h"
#include "elastin/solve/statics.h"
#include "experiment/tension.h"
#include "measure.h"
#include "solve/linear_solver.h"
#include "solve/sparse_stiffness.h"

namespace bench {
namespace {

using namespace elastin;
using Sparse = Eigen::SparseMatrix<double>;

struct Solved {
  VectorX motion;  ///< empty for large displacements
  double newton = kNone, iterations = kNone, residual = kNone;
};

Solved elastin_linear(TensionCube& problem, const Sparse&) {
  const Positions no_way = Positions::Zero(3, problem.body.size());
  const StaticOptions options{.linear = true, .method = LinearMethod::pcg, .tolerance = kTolerance};
  const StaticResponse response = static_response(problem.model, problem.body.rest, problem.loads, no_way, options);
  if (response.result.outcome != Outcome::converged) throw std::runtime_error(response.result.cause);
  return {Eigen::Map<const VectorX>(response.motion.data(), response.motion.size()), kNone,
          static_cast<double>(response.result.linear_iterations)};
}

Solved elastin_newton(TensionCube& problem, const Sparse&) {
  State state = state_at_rest(problem.body);
  const StaticOptions options{.method = LinearMethod::pcg, .tolerance = kTolerance};
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
Solved eigen_ldlt(TensionCube& problem, const Sparse& matrix) {
  const VectorX loads = free_loads(problem);
  Sparse shifted = matrix;
  shifted.diagonal().array() += 1e-9 * matrix.diagonal().mean();
  const Eigen::SimplicialLDLT<Sparse> factor(shifted);
  VectorX motion = factor.solve(loads);
  for (int step = 0; step < 10; ++step) {
    const VectorX left = loads - matrix * motion;
    if (left.norm() <= kTolerance * loads.norm()) break;
    motion += factor.solve(left);
  }
  return {motion};
}

struct Contender {
  const char* name;
  Solved (*solve)(TensionCube&, const Sparse&);
  bool assembles, compared;  ///< `compared`: solves the same linear problem as the peer
  int most_threads, largest_side;
};

// Eigen's factorisation takes minutes where iterations take a tenth of a second: small bodies only.
constexpr Contender kContenders[] = {
    {"elastin, small displacements", elastin_linear, false, true, 1 << 10, 1 << 20},
    {"Eigen ConjugateGradient", eigen_cg, true, true, 1 << 10, 47},
    {"Eigen SimplicialLDLT", eigen_ldlt, true, true, 1, 10},
    {"elastin, large displacements", elastin_newton, false, false, 1 << 10, 1 << 20},
};
constexpr const Contender& kPeer = kContenders[1];

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

/// One entry alone in a process.
std::vector<Figures> memory(int side, const Entry& entry) {
  const double before = peak_memory();
  set_threads(entry.threads);
  TensionCube problem(side);
  const Sparse matrix = entry.contender->assembles ? assembled(problem) : Sparse();
  entry.contender->solve(problem, matrix);
  Figures figures;
  figures.peak = peak_memory() - before;
  return {figures};
}

}  // namespace

std::vector<Row> run_static(const Settings& settings) {
  std::vector<Row> rows;
  for (const int side : settings.sides) {
    say("static, side " + std::to_string(side));
    std::vector<Entry> entries;
    for (const Contender& contender : kContenders)
      for (const int count : settings.threads)
        if (count <= contender.most_threads && side <= contender.largest_side) entries.push_back({&contender, count});
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
  }
  return rows;
}

}  // namespace bench
