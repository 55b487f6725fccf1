#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <stdexcept>

#include "measure.h"

namespace bench {
namespace {

struct Program {
  const char *method, *path;
  std::vector<double> build, solve;
  Figures figures;

  void run(int side) {
    FILE* output = popen(fmt::format("'{}' {}", path, side).c_str(), "r");
    double built = 0, solved = 0;
    const int read =
        output ? std::fscanf(output, "%lf %lf %lf %lf", &built, &solved, &figures.iterations, &figures.peak) : 0;
    if (!output || pclose(output) != 0 || read != 4) throw std::runtime_error(fmt::format("failed: {} {}", path, side));
    build.push_back(built);
    solve.push_back(solved);
  }
};

}  // namespace

std::vector<Row> run_core(const Settings& settings) {
  std::vector<Row> rows;
  for (const int side : settings.sides) {
    say("core, side " + std::to_string(side));
    std::array<Program, 2> programs{{{"core alone", ELASTIN_BENCH_CORE_ALONE, {}, {}, {}},
                                     {"everything linked", ELASTIN_BENCH_EVERYTHING, {}, {}, {}}}};
    for (int repeat = -1; repeat < settings.repeats; ++repeat) {  // once to warm up
      for (Program& program : programs) program.run(side);
      if (repeat < 0)
        for (Program& program : programs) program.build.clear(), program.solve.clear();
    }
    const Sample peer = summary(programs.back().solve);
    for (Program& program : programs) {
      const Sample sample = summary(program.solve);
      program.figures.build = summary(program.build).median;
      program.figures.minimum = sample.minimum;
      program.figures.median = sample.median;
      program.figures.ratio = peer.minimum / sample.minimum;
      rows.push_back(
          {"core", program.method, side, 1, settings.repeats, program.figures, "peak: of the whole process"});
    }
  }
  return rows;
}

}  // namespace bench
