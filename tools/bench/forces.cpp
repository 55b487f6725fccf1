#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "elastin/core/forces/model.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "measure.h"
#include "plain_loop.h"

namespace bench {
namespace {

using namespace elastin;

constexpr const char* kMethods[] = {"elastin, lattice", "elastin, any graph", "plain loop"};
constexpr std::size_t kCount = std::size(kMethods), kPlain = kCount - 1;

/// The methods in turn, at each number of threads: a figure for each of them.
std::vector<Figures> race(int side, const Settings& settings) {
  const Body body = make_cube(side);
  const VectorX constants = built_in_catalog().find("lattice").constants(body, kMaterial, {});
  Body list = body;
  list.grid.reset();
  Model lattice(body), any_graph(list);
  lattice.add(make_springs(body, constants));
  any_graph.add(make_springs(list, constants));
  // Stretched, sheared and bent a little, so that no spring is at rest.
  Positions positions = body.rest;
  positions.row(2) *= 1.01;
  positions.row(0) += 0.02 * positions.row(1) + 0.01 * positions.row(2).cwiseAbs2();
  const Springs springs{body.connections, constants};
  // A sample of some 4 million springs: long against the clock and one wake-up.
  const int passes = std::max(1, 4000000 / body.connections.size());

  std::vector<std::unique_ptr<Team>> teams;
  std::vector<std::vector<Positions>> plain;
  std::vector<Positions> ours(2 * settings.threads.size(), Positions::Zero(3, body.size()));
  Workspace workspace;
  for (const int count : settings.threads) {
    teams.push_back(std::make_unique<Team>(count));
    plain.emplace_back(count);
  }
  std::vector<std::function<void()>> works;
  for (std::size_t i = 0; i < settings.threads.size(); ++i) {
    for (const std::size_t which : {0, 1})
      works.push_back([&, i, which] {
        set_threads(settings.threads[i]);
        for (int pass = 0; pass < passes; ++pass) {
          ours[2 * i + which].setZero();
          (which == 0 ? lattice : any_graph).add_elastic_forces(positions, ours[2 * i + which], workspace);
        }
      });
    works.push_back([&, i] {
      for (int pass = 0; pass < passes; ++pass) plain_forces(*teams[i], springs, positions, plain[i]);
    });
  }
  const std::vector<Sample> samples = interleaved(works, settings.repeats);
  for (const Positions& forces : ours)
    if (!((forces - plain[0][0]).cwiseAbs().maxCoeff() <= 1e-10 * plain[0][0].cwiseAbs().maxCoeff()))
      throw std::runtime_error("the plain loop and elastin differ");

  std::vector<Figures> found;
  for (std::size_t i = 0; i < works.size(); ++i) {
    Figures figures;
    figures.springs = body.connections.size();
    figures.minimum = samples[i].minimum / passes;
    figures.median = samples[i].median / passes;
    figures.rate = figures.springs / figures.minimum;
    // A plain loop that several threads only slow down is measured by what it does on fewer.
    double peer = samples[i / kCount * kCount + kPlain].minimum;
    for (std::size_t j = kPlain; j < works.size(); j += kCount)
      if (settings.threads[j / kCount] <= settings.threads[i / kCount]) peer = std::min(peer, samples[j].minimum);
    figures.ratio = peer / samples[i].minimum;
    found.push_back(figures);
  }
  return found;
}

/// Bytes a pass moves at least: each connection's ends, L and k once, each molecule's place in and force out.
double least_bytes(double molecules, double springs) { return springs * (2 * 4 + 8 + 8) + molecules * (24 + 24); }

}  // namespace

std::vector<Row> run_forces(const Settings& settings) {
  say("forces, memory bandwidth");
  std::vector<Row> rows;
  const std::vector<Figures> memory = in_child([&] { return triad(settings); });
  for (std::size_t i = 0; i < memory.size(); ++i)
    rows.push_back({"forces", "triad, 240 MB", 0, settings.threads[i], settings.repeats, memory[i], ""});
  for (const int side : settings.sides) {
    say("forces, side " + std::to_string(side));
    std::vector<Figures> found = in_child([&] { return race(side, settings); });
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double bytes = least_bytes(std::pow(side, 3), found[i].springs);
      // Arrays that fit a cache are not bounded by memory.
      const bool cached = bytes < 8e6;
      if (!cached && i % kCount != 0) found[i].allowed = memory[i / kCount].bandwidth / bytes * found[i].springs;
      rows.push_back({"forces", kMethods[i % kCount], side, settings.threads[i / kCount], settings.repeats, found[i],
                      cached ? "in cache" : ""});
    }
  }
  return rows;
}

}  // namespace bench
