#pragma once
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lab/report/directions.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// A solution by another program, to be compared with Elastin's.
struct Peer {
  std::string scene;  ///< whose problem it solves; empty = of every scene
  std::string name;
  double seconds = 0, error = 0;  ///< error relative to the same reference
};

/// Reads the columns method, minimum_s, error, and scene if there is one, of a CSV file; rows without both numbers are
/// left out. Throws InputError: file:line.
std::vector<Peer> load_peers(const std::string& path);

/// The first item of a list for which `same` holds; without any `item`, which is added.
template <class Item, class Same>
Item& found_or_added(std::vector<Item>& list, const Same& same, Item item) {
  const auto at = std::find_if(list.begin(), list.end(), same);
  return at == list.end() ? list.emplace_back(std::move(item)) : *at;
}

/// The middle value, or the mean of the two in the middle; NaN of none.
double median(std::vector<double> values);

/// How one expectation of a scene came out.
struct Verdict {
  Expectation expectation;
  std::string strategy;   ///< the run it is compared with
  double measured = 0;    ///< NaN if the run has no such measure
  double difference = 0;  ///< relative to the expected value; both NaN where an outcome is expected
  bool passed = false;
  bool judged = true;  ///< false: the scene says that it is not reproduced
};

/// Compares a run with one expectation, whatever strategy that is about.
Verdict judge(const Expectation& expectation, const Run& run);

/// Connections a molecule has away from the body's surface: of those further from the bounding box's faces than the
/// longest connection, or of all if there is no such molecule.
struct Neighbours {
  double mean = 0;
  int least = 0;
};
Neighbours neighbours_inside(const Body& body);

/// One run with what the scene states about it: a row of every table and file.
struct Record {
  std::string scene, path, title;
  Run run;
  int molecules = 0, connections = 0, cells = 0, threads = 1;
  Neighbours neighbours;
  int cell_sides = 0;                           ///< in addition to the connections: those that are sides of cells only
  std::string prescribed;                       ///< "E = 5000 Pa, nu = 0.25"
  std::shared_ptr<const MeasureList> measures;  ///< of the experiment's runs; null: of an experiment unknown here
  std::vector<MainMeasure> main_measures;       ///< of the experiment, with the targets of the material
  /// The target of a measure where it is a law's at a strain that shows; else null.
  const MainMeasure* law_target(std::string_view measure) const;
  /// `prescribed`, and the targets at a strain: "E = 5000 Pa, nu = 0.25; at a strain of 20.00 %: E 4404.2 Pa".
  std::string target_text() const;
  /// The description of a measure here; of another experiment's measure, the one there. Throws InputError if there is
  /// no such measure.
  const MeasureInfo& measure(const std::string& name) const;
  /// Name of the measure with this role; "" if no measure has it.
  std::string measure(MeasureRole role) const;
  /// By measure, compared with the target of the material: relative, or a difference where the measure is a ratio;
  /// MEASURE_to_reference against the scene's reference, relative; MEASURE_over_scatter as over_scatter.
  std::vector<std::pair<std::string, double>> errors;
  /// NaN if there is no such error.
  double error(std::string_view name) const;
  /// Whether a measure depends on the body's shape, and not on the material alone.
  bool is_apparent(const MeasureInfo& info) const;
  /// Where the scene has uncertain numbers, of each measure its "deviation", and the share of each in its square.
  Gradients spreads;
  std::vector<Verdict> verdicts;
  std::vector<std::string> warnings;   ///< of the scene and of the run
  std::vector<std::string> notes;      ///< of the scene
  std::vector<std::string> obstacles;  ///< of its contact, by name
  std::vector<Reference> references;   ///< stated by the scene, computed, or found by the study itself
  /// What a study changes from row to row: "body.lattice.molecules" = "[5, 5, 5]"; empty where nothing is.
  std::vector<std::pair<std::string, std::string>> variant;
  bool apparent = false;  ///< `effective_modulus` depends on the body's shape: no error against the material's E
  std::optional<DirectionErrors> directions;  ///< of a strategy that comes near; empty: not requested
  std::string no_reference;                   ///< why the material's values rank no strategy here; empty where they do
  double spacing = 0;  ///< of the body's molecules, up to a factor that refinement leaves alone; see relative_spacing
  std::vector<double> extent;  ///< of the body along x, y, z, spheres included [m]; empty: not known
  /// Build and solve of every repeat [s]; `run` has those of the fastest. Empty: one run, not repeated.
  std::vector<std::array<double, 2>> repeats;
  /// Takes a repeat of the same row in: the fastest counts.
  void add_repeat(const Record& again);
  /// The least and the middle of build + solve [s].
  double least_seconds() const;
  double median_seconds() const;
  /// Whether it stopped as the scene says that it must.
  bool stopped_as_expected() const;
  /// Not failed: converged, or stopped as expected, or the body does not suit the strategy; and every judged
  /// expectation holds.
  bool good() const;
};

/// "20 %"
std::string strain_text(double strain);

Record make_record(const Scene& scene, Run run);
/// Whether all have the same `prescribed`; a study may change it from row to row.
bool have_one_target(const std::vector<Record>& records);

/// Of a measure, of the time or of the share of the load, by name.
double along(const CurvePoint& point, const std::string& name);

/// How far a run is from what was measured, in standard deviations of the specimens: root of the mean of squares over
/// the points of a curve, between whose load steps it is straight. NaN where no scatter is stated, or it ends before.
double over_scatter(const Run& run, const Reference& reference);

/// Those that the scene states, and the computed ones of other measures.
std::vector<Reference> references_of(const Scene& scene);

/// What falls as 1/n where each side of a body is cut into n times as many parts: cells^(−1/3) of tetrahedra or cubes,
/// triangles^(−1/2), molecules^(−1/3) of a body without cells.
double relative_spacing(const Body& body);

/// Relative errors of the measured values against these references, as MEASURE_to_reference, in place of older ones.
void set_references(Record& record, const std::vector<Reference>& references);

/// The JSON of README: {"runs": [...]}, SI units. Numbers that are not finite become null.
std::string json_text(const std::vector<Record>& records);

/// Another form of a record's line, or another meaning of a number in it, takes another version.
inline constexpr int kRecordVersion = 2;

/// One run as one line of JSON, without a line break: what json_text has of it, and what else the record holds.
std::string json_line(const Record& record);

/// The record that such a line came from, equal but for its states and spring constants, the forces and pressures of
/// contact on each molecule, and numbers that were not finite, which are NaN. Throws InputError if it is no such line.
Record record_of_json(const std::string& line);

/// What two records of the same run disagree about: "measures/effective_modulus: 5000.1 and 5000.2", the first of them;
/// "" if they agree. Times, threads and the scene's path do not count.
std::string disagreement(const Record& one, const Record& other);

}  // namespace elastin::lab
