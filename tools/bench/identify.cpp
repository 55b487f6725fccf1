#include "lab/identify/identify.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "elastin/core/parallel/threads.h"
#include "lab/identify/fit.h"
#include "measure.h"
#include "support/temporary_folder.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;
namespace fs = std::filesystem;

const std::string kScenes = ELASTIN_SOURCE_DIR "/scenes/identify/";
constexpr double kTruth[] = {2000, 1000, 30000};  // c₁, c₂ and κ [Pa] that the data are made with

/// A block of 36 × 16 × 15 mm, clamped at both ends and stretched by a quarter: 37 · 17 · 16 molecules, 51 840
/// tetrahedra. Poisson's ratio begins at 0.41 and ends at 0.452.
constexpr const char* kSpecimen = R"(title: A specimen of ten thousand molecules
body: {tetrahedra: {kind: kuhn, cubes: [36, 16, 15], size: [36 mm, 16 mm, 15 mm]}}
material: {law: mooney_rivlin, c1: 1.5 kPa, c2: 1.5 kPa, bulk_modulus: 15 kPa}
stiffness: mooney_rivlin
experiment: {kind: tension, axis: x, displacement: 9 mm, fixed_grip: clamped, loaded_grip: clamped}
reference: none
identify:
  unknowns: [c1, c2, bulk_modulus]
  tests: [{kind: specimen, file: data.csv}]
)";

/// The specimen with forces that are those of `kTruth`.
class Specimen {
 public:
  Specimen() {
    const IdentifyTask task = write({1, 2, 3, 4, 5});
    const auto test = make(task);
    const auto truth =
        test->predict({row_, with_numbers(row_, task.material, numbers_, Eigen::Map<const VectorX>(kTruth, 3)), {}});
    if (!truth) throw std::runtime_error("the specimen has no equilibrium: " + test->why());
    write({truth->values.data(), truth->values.data() + truth->values.size()});
  }

  const std::string& path() const { return path_; }
  const MaterialLaw* row() const { return row_; }
  const std::vector<MaterialNumber>& numbers() const { return numbers_; }
  IdentifyTask task() const { return load_identify_task(path_, catalog_); }
  std::unique_ptr<MeasuredTest> make(const IdentifyTask& task) const {
    return make_measured_test(task.tests.front(), catalog_, row_, task.material, {});
  }
  const Catalog& catalog() const { return catalog_; }

 private:
  IdentifyTask write(const std::vector<double>& forces) {
    std::string data = "displacement [mm],force [N]\n";
    for (std::size_t i = 0; i < forces.size(); ++i)
      data += fmt::format("{:.9g},{:.12g}\n", 9 * static_cast<double>(i + 1) / static_cast<double>(forces.size()),
                          forces[i]);
    folder_.write("data.csv", data);
    path_ = folder_.write("scene.yaml", kSpecimen);
    IdentifyTask read = task();
    holder_ = catalog_.material_laws.find("mooney_rivlin");
    row_ = holder_.get();
    numbers_ = material_numbers(row_, read.material);
    return read;
  }

  TemporaryFolder folder_;
  Catalog catalog_ = built_in_catalog();
  std::string path_;
  std::shared_ptr<const MaterialLaw> holder_;
  const MaterialLaw* row_ = nullptr;
  std::vector<MaterialNumber> numbers_;
};

Figures figures_of(std::vector<double> seconds, double molecules, double error) {
  const Sample sample = summary(std::move(seconds));
  Figures figures;
  figures.molecules = molecules, figures.minimum = sample.minimum, figures.median = sample.median,
  figures.error = error;
  return figures;
}

constexpr double kMolecules = 37 * 17 * 16;

/// Slopes of the specimen's five forces by three numbers, at its equilibria: by one linear solve a number, and by
/// differences of whole curves, each started from the last; the error is the largest difference of the two.
std::vector<Figures> time_slopes(const Settings& settings) {
  const Specimen specimen;
  const IdentifyTask task = specimen.task();
  const auto test = specimen.make(task);
  const Trial start = task.material;
  VectorX values(3);
  for (Eigen::Index i = 0; i < 3; ++i) values[i] = specimen.numbers()[i].value;
  const auto curve = [&](const VectorX& at) {
    return test->predict({specimen.row(), with_numbers(specimen.row(), start, specimen.numbers(), at), {}})->values;
  };
  const auto changes = trial_changes(specimen.row(), start, specimen.numbers(), values, 1e-5 * values);
  MatrixX solved, differences(5, 3);
  std::vector<double> by_solves, by_differences;
  for (int repeat = 0; repeat <= settings.repeats; ++repeat) {
    curve(values);
    const double solves = seconds_of([&] { solved = test->predict({specimen.row(), start, changes})->slopes; });
    const double whole = seconds_of([&] {
      for (Eigen::Index i = 0; i < 3; ++i) {
        const double step = 1e-3 * values[i];
        VectorX above = values, below = values;
        above[i] += step, below[i] -= step;
        differences.col(i) = (curve(above) - curve(below)) / (2 * step);
      }
    });
    if (repeat > 0) by_solves.push_back(solves), by_differences.push_back(whole);
  }
  double error = 0;
  for (Eigen::Index i = 0; i < 3; ++i)
    error = std::max(error, (solved.col(i) - differences.col(i)).norm() / solved.col(i).norm());
  return {figures_of(by_solves, kMolecules, error), figures_of(by_differences, kMolecules, error)};
}

std::vector<Figures> time_specimen(const Settings& settings) {
  const Specimen specimen;
  std::vector<double> seconds;
  double error = 0;
  for (int repeat = 0; repeat < settings.repeats; ++repeat)
    seconds.push_back(seconds_of([&] {
      const Answer answer = identify(specimen.path(), specimen.catalog(), {}).front();
      if (answer.outcome != FitOutcome::converged)
        throw std::runtime_error("the fit did not converge: " + answer.cause);
      for (std::size_t i = 0; i < 3; ++i) error = std::max(error, std::abs(answer.numbers[i].value / kTruth[i] - 1));
    }));
  return {figures_of(seconds, kMolecules, error)};
}

std::vector<Figures> time_treloar(const Settings& settings, const std::string& laws) {
  const Catalog catalog = built_in_catalog();
  std::vector<double> seconds;
  for (int repeat = 0; repeat < settings.repeats; ++repeat)
    seconds.push_back(seconds_of([&] { identify(kScenes + "treloar-ogden.yaml", catalog, {.laws = laws}); }));
  return {figures_of(seconds, kNone, kNone)};
}

}  // namespace

std::vector<Row> run_identify(const Settings& settings) {
  std::vector<Row> rows;
  const int threads = settings.threads.back();
  const auto add = [&](const std::string& method, int repeats, const auto& work, const char* note) {
    say("identify, " + method);
    Settings own = settings;
    own.repeats = repeats;
    const auto found = in_child([&] {
      set_threads(threads);
      return work(own);
    });
    for (std::size_t i = 0; i < found.size(); ++i)
      rows.push_back(
          {"identify", i == 0 ? method : "differences of whole curves", 0, threads, repeats, found[i], note});
  };
  add(
      "Treloar's three tests, Ogden's three terms", settings.repeats,
      [](const Settings& own) { return time_treloar(own, ""); }, "8 searches, profiles of 2 numbers");
  add(
      "Treloar's three tests, Yeoh's three terms", settings.repeats,
      [](const Settings& own) { return time_treloar(own, "yeoh/3"); }, "8 searches");
  add("one linear solve a number", 2, time_slopes, "slopes of 5 forces by 3 numbers");
  add("specimen, three numbers", 1, time_specimen, "5 forces; from 25, 50 and 50 % off");
  return rows;
}

}  // namespace bench
