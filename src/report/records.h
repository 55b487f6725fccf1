#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"

namespace elastin {

/// How one expectation of a scene came out.
struct Verdict {
  Expectation expectation;
  std::string strategy;   ///< the run it was held against
  double measured = 0;    ///< NaN if the run has no such measure
  double difference = 0;  ///< relative to the expected value
  bool holds = false;
  bool judged = true;  ///< false: the scene says that it is not reproduced
};

/// One run with what the scene said about it: a row of every table and file.
struct Record {
  std::string scene, path, title;
  Run run;
  int molecules = 0, connections = 0, cells = 0, threads = 1;
  int cell_sides = 0;                      ///< beside the connections: those that are sides of cells only
  std::string prescribed;                  ///< "E = 5000 Pa, nu = 0.25"
  std::vector<MainMeasure> main_measures;  ///< of the experiment, with what the material asks for
  /// By measure, against what the material asks for: relative, or a difference where the measure is a ratio;
  /// MEASURE_to_reference against the scene's reference, relative.
  std::vector<std::pair<std::string, double>> errors;
  /// NaN if there is no such error.
  double error(std::string_view name) const;
  std::vector<Verdict> verdicts;
  std::vector<std::string> warnings;  ///< of the scene and of the run
  /// Not failed: converged, or the body does not suit the strategy; and every judged expectation holds.
  bool good() const;
};

Record make_record(const Scene& scene, Run run);

}  // namespace elastin
