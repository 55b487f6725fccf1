#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#ifdef ELASTIN_BENCH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>

#include "core/linear/sparse_stiffness.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/model/renumbered.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "lab/experiment/tension/tension.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kTolerance = 1e-8;  ///< of the residual, over the loads

/// How a body's molecules and connections are numbered.
enum class Numbering { lattice, at_random, in_space };

/// The tension cube under the load that stretches it by 1e-5, ready to be solved.
struct TensionCube {
  explicit TensionCube(int side, Numbering numbering = Numbering::lattice);
  Body body;
  Model model;
  std::unique_ptr<StaticExperiment> experiment;
  Positions loads;
  double renumbering;  ///< what numbered_in_space took of it [s]

 private:
  struct Cube {
    Body body;
    VectorX constants;
    double renumbering = 0;
  };
  static Cube numbered(int side, Numbering numbering);
  explicit TensionCube(Cube cube);
};

/// The cube with its springs; of a cube that was numbered at random nothing says that it is a lattice.
TensionCube::Cube TensionCube::numbered(int side, Numbering numbering) {
  Body cube = make_cube(side);
  VectorX constants = built_in_catalog().find("lattice").constants(cube, kMaterial, {});
  if (numbering == Numbering::lattice) return {std::move(cube), std::move(constants), 0};
  auto shuffled = [generator = std::mt19937(1)](int count) mutable {
    std::vector<int> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), generator);
    return order;
  };
  Body body = cube;
  body.grid.reset();
  body.cubes.clear();
  const std::vector<int> molecules = shuffled(cube.size()), connections = shuffled(cube.connections.size());
  for (int a = 0; a < cube.size(); ++a) body.rest.col(molecules[a]) = cube.rest.col(a);
  VectorX own(constants.size());
  for (int c = 0; c < cube.connections.size(); ++c) {
    const auto& [a, b] = cube.connections.ends[connections[c]];
    body.connections.ends[c] = {molecules[a], molecules[b]};
    body.connections.rest_length[c] = cube.connections.rest_length[connections[c]];
    own[c] = constants[connections[c]];
  }
  if (numbering == Numbering::at_random) return {std::move(body), std::move(own), 0};
  RenumberedBody ordered;
  const double seconds = seconds_of([&] { ordered = numbered_in_space(body); });
  return {std::move(ordered.body), own(ordered.connection_from).eval(), seconds};
}

TensionCube::TensionCube(int side, Numbering numbering) : TensionCube(numbered(side, numbering)) {}

TensionCube::TensionCube(Cube cube) : body(std::move(cube.body)), model(body), renumbering(cube.renumbering) {
  TensionSetup setup;
  setup.force = kMaterial.youngs_modulus * kCubeLength * kCubeLength * 1e-5;
  experiment = make_tension(body, setup);
  model.add(make_springs(body, std::move(cube.constants)));
  experiment->static_rig(model)->set_load(1);
  loads = model.load_forces(state_at_rest(body));
}

/// K about rest without a shift; the sliding grips leave three rigid motions, on which the load does no work.
Sparse assembled(TensionCube& cube) {
  const State rest = state_at_rest(cube.body);
  const Tangent tangent(cube.model, rest);
  return sparse_stiffness(tangent, cube.model.supports, 0, stiffness_scale(tangent)).selfadjointView<Eigen::Lower>();
}

/// The right-hand side that every linear contender gets.
VectorX free_loads(const TensionCube& cube) {
  Positions loads = cube.loads;
  keep_free(cube.model.supports, loads);
  return Eigen::Map<const VectorX>(loads.data(), loads.size());
}

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
  const StaticResult result = solve_static(problem.model, state, {.tolerance = kTolerance});
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
      throw std::runtime_error(std::string(entries[i].contender->name) + ": not solved, the residual is " +
                               std::to_string(found[i].residual));
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
          peer = std::fmin(peer, found[j].minimum);  // fmin takes the number where the other is NaN
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
  }
  return rows;
}

}  // namespace bench
