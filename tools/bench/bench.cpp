// Benchmarks: how long Elastin takes and what it needs, compared with peers that run in the same process in turn.
//   elastin_bench                                    every case, some minutes
//   elastin_bench forces --sizes 22,47 --csv out.csv
//   elastin_bench --list

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "command/memory.h"
#include "command/options.h"
#include "elastin/core/base/error.h"
#include "elastin/openmp/openmp.h"
#include "measure.h"

namespace {

struct Case {
  const char* name;
  const char* summary;
  std::vector<bench::Row> (*run)(const bench::Settings&);
};

constexpr Case kCases[] = {
    {"static", "tension cube to a relative residual of 1e-8; peer: Eigen's conjugate gradients on the assembled matrix",
     bench::run_static},
    {"derivatives",
     "an equilibrium with the derivatives of a measure by the stiffness of every spring or cell; peer: without, by "
     "processor time",
     bench::run_derivatives},
    {"forces", "elastic force pass; peer: a plain loop over the connections, each thread with its own forces",
     bench::run_forces},
    {"steps",
     "explicit steps (velocity Verlet) of the cube's springs; peers: the same by hand, LAMMPS (package lammps), Bullet",
     bench::run_steps},
    {"cut", "a block of 20 250 cells that is cut while it moves: its steps, and the longest one", bench::run_cut},
    {"laws",
     "force and tangent pass of springs and of every cell law on some 1e5 cells; peer: a plain loop over springs",
     bench::run_laws},
    {"identify",
     "a material of measured curves: homogeneous tests, and a specimen of ten thousand molecules; peer: slopes by "
     "differences of whole curves",
     bench::run_identify},
    {"embed",
     "the largest soft cube (10 cm, 10 kPa) that a host steps 1000 times a second on one core, and how steadily; "
     "limit: "
     "its force passes alone, peer: Bullet",
     bench::run_embed}};

}  // namespace

int main(int argc, char** argv) {
  namespace command = elastin::command;
  elastin::openmp::let_threads_sleep(argv);  // as the command does: what is measured is what its user gets
  command::keep_memory();
  elastin::openmp::use_openmp();
  std::vector<std::string> names, chosen;
  for (const Case& one : kCases) names.emplace_back(one.name);
  bench::Settings settings;
  std::vector<int> sides, counts;
  std::string csv;
  bool list = false;
  command::Options options;
  options.argument("CASE", command::one_of(names, command::into(chosen)), "What to run; all if none is named", false,
                   true);
  options.add("--repeats", "NUMBER", command::into(settings.repeats, 1, 1000),
              "Measured runs of each, after one to warm up");
  options.add("--sizes", "NUMBERS", command::each_of(command::into(sides, 3, 200)),
              "Molecules along the cube's side: 10,22,47");
  options.add("--threads", "NUMBERS", command::each_of(command::into(counts, 1, 256)), "Numbers of threads: 1,2");
  options.add("--seconds", "NUMBER", command::into(settings.seconds, 0.1, 86400.), "How long embed steps steadily");
  options.add("--only", "TEXT", command::into(settings.only),
              "Of embed and derivatives, the rows that have this text in their name");
  options.add("--csv", "FILE", command::into(csv), "File for all rows, SI units");
  options.flag("--list", list, "Name the cases and stop");
  try {
    if (options.read({argv + 1, argv + argc}, "elastin_bench")) {
      fmt::print(
          "Benchmarks of Elastin. Ratios are of minima, against the peer at its best on no more threads: above 1 is "
          "faster.\n{}",
          options.help("elastin_bench"));
      return 0;
    }
  } catch (const elastin::InputError& error) {
    fmt::print(stderr, "elastin_bench: {}\n", error.what());
    return 2;
  }
  if (chosen.empty()) chosen = names;
  if (!sides.empty()) settings.sides = sides;
  if (!counts.empty()) settings.threads = counts;
  if (list) {
    for (const Case& one : kCases) fmt::print("{:11} {}\n", one.name, one.summary);
    return 0;
  }
  try {
    const std::string machine = bench::machine();  // now: later the load is our own
    fmt::print("{}; threads {}; repeats {}\n", machine, fmt::join(settings.threads, ", "), settings.repeats);
    std::fflush(stdout);
    std::vector<bench::Row> all;
    for (const Case& one : kCases) {
      if (std::find(chosen.begin(), chosen.end(), one.name) == chosen.end()) continue;
      const std::vector<bench::Row> rows = one.run(settings);
      fmt::print("\n{}: {}\n", one.name, one.summary);
      bench::print_rows(rows);
      all.insert(all.end(), rows.begin(), rows.end());
      if (!csv.empty()) bench::write_csv(csv, machine, all);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "elastin_bench: {}\n", error.what());
    return 1;
  }
  return 0;
}
