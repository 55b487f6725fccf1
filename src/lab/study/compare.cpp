#include "lab/study/study.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "core/base/shell_word.h"
#include "core/base/stopwatch.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "lab/export/engine_run.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/image_fields.h"
#include "lab/report/machine.h"
#include "lab/report/page.h"
#include "lab/report/records.h"
#include "lab/report/screen.h"
#include "lab/run/derivatives.h"
#include "lab/study/journal.h"
#include "lab/study/plan.h"
#include "lab/study/reference.h"

namespace elastin::lab {
namespace {

std::string restart_text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || std::filesystem::is_directory(path)) throw InputError("--restart: " + path + ": cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A comparison in progress.
class Comparison {
 public:
  Comparison(const Request& request, const Catalog& catalog)
      : request_(request), catalog_(catalog), progress_(progress_of(request)), store_(request.out), results_(request) {}

  bool run();

 private:
  void run_combination(ScenePlan& plan, const std::vector<std::pair<std::string, std::string>>& combination,
                       std::size_t first_row, int repeat);
  Record run_one(Scene& scene, const StrategyChoice& choice, const PlannedRow& row);
  void add_directions(const Scene& scene, const StrategyChoice& choice, const RunOptions& options, Record& record);
  Record run_elsewhere(const Engine& engine, Scene& scene, const PlannedRow& row);
  Record failed_run(const PlannedRow& row, const std::string& why) const;
  void tell_missing_files(const ScenePlan& plan, const Record& record, int repeat) const;
  void finish_run(const ScenePlan& plan, const std::string& key, Record record, const Scene* scene, int repeat);
  RunSource source_of(const ScenePlan& plan) const { return {plan.name, plan.content, request_.overrides}; }
  bool runs_here(std::size_t row) const { return shards_[row] == request_.shard.number; }
  void add_references(const ScenePlan& plan, const std::vector<std::pair<std::string, std::string>>& combination,
                      const std::vector<StrategyChoice>& choices, Scene& scene);
  void open_journal();
  void finish();
  RunOptions options_of(const ScenePlan& plan, const Scene& scene, const StrategyChoice& choice);
  std::string finished_text(const Record& record) const;

  const Request& request_;
  const Catalog& catalog_;
  Progress progress_;
  ReferenceStore store_;
  std::vector<ScenePlan> plans_;
  std::vector<int> shards_;  ///< of the rows
  std::optional<Journal> journal_;
  Results results_;
  std::size_t rows_ = 0, done_ = 0, run_ = 0;  ///< runs of all repeats: there are, finished, not found finished
  double seconds_ = 0;                         ///< that the runs made here took
  Stopwatch written_;
  const Machine machine_ = this_machine();
  bool good_ = true, suited_ = false, stopped_ = false;
};

/// "  3 of 18  cube, lattice: E +0.02 %, 12.0 ms": a run in one line, before its table is printed.
std::string Comparison::finished_text(const Record& record) const {
  std::string text = fmt::format("  {} of {}  {}, {}", done_, rows_, record.scene, record.run.strategy);
  if (const std::string variant = variant_text(record); !variant.empty()) text += ", " + variant;
  text += ": ";
  if (!solved(record)) return text + outcome_text(record.run);
  for (const MainMeasure& measure : record.main_measures) {
    const std::string& name = measure.name;
    if (record.measure(name).unit == dimension::none) continue;
    const double to_reference = record.error(name + "_to_reference");
    const double error = std::isfinite(to_reference) ? to_reference : record.error(name);
    if (std::isfinite(error))
      return text + record.measure(name).label() + " " + percent(error) +
             (std::isfinite(to_reference) ? " to the reference, " : ", ") + readable_seconds(record.least_seconds());
  }
  return text + readable_seconds(record.least_seconds());
}

RunOptions Comparison::options_of(const ScenePlan& plan, const Scene& scene, const StrategyChoice& choice) {
  RunOptions result;
  result.statics = scene.statics;
  result.time = scene.time;
  result.problem = scene.problem;
  result.live = request_.live;
  if (!request_.image.empty()) check_image(request_.image, request_.image_spacing, scene);
  result.last_snapshot = request_.out.empty() && !request_.image.empty();
  result.keep_snapshots =
      !request_.out.empty() || result.last_snapshot || (!request_.pieces.empty() && scene.specimen.body.share);
  result.progress = [this, name = scene.name + ", " + choice.label + ": "](const std::string& doing) {
    progress_.set_count({rows_, done_, run_, seconds_});
    progress_.set(name + doing);
  };
  result.stop = [this] { return request_.interrupted && request_.interrupted(); };
  if (!request_.restart.empty()) result.restart = restart_text_of(result.restart_path = request_.restart);
  if (!request_.out.empty() && !plan.varied())
    result.checkpoint = [path = request_.out + "/" + file_name(scene.name, choice.label) +
                                ".restart"](const std::string& text) { write_whole(path, text); };
  return result;
}

/// Gives the scene its computed references. `run`, which ranks nothing, computes them only where the scene or the
/// command requests it, or where there is nothing else to calibrate to.
void Comparison::add_references(const ScenePlan& plan,
                                const std::vector<std::pair<std::string, std::string>>& combination,
                                const std::vector<StrategyChoice>& choices, Scene& scene) {
  if (!wants_computed_references(scene, request_.reference) || !plan.own_reference.empty()) return;
  const bool calibration = calibration_of(*scene.experiment, scene.specimen) != nullptr;
  if (!calibration && std::all_of(choices.begin(), choices.end(), [](const auto& c) { return c.name.calibrated; }))
    return;  // none of them runs, whatever the reference is
  const bool calibrates = scene.experiment->apparent() &&
                          std::any_of(choices.begin(), choices.end(), [](const auto& c) { return c.name.calibrated; });
  const bool requested =
      request_.reference == "computed" || scene.computed.when == ComputedReference::When::always || calibrates;
  if (!request_.compare && !requested) return;
  ComputedReferences found = compute_references(
      scene, catalog_, overrides_of(request_.overrides, combination), store_,
      [this, name = scene.name + ": "](const std::string& doing) {
        progress_.set_count({rows_, done_, run_, seconds_});
        progress_.set(name + doing);
      },
      request_.interrupted);
  progress_.pause();
  scene.specimen.references = std::move(found.references);
  scene.no_computed_reference = std::move(found.trouble);
}

Record Comparison::failed_run(const PlannedRow& row, const std::string& why) const {
  Record record;
  record.scene = row.plan->name;
  record.title = row.plan->title;
  record.variant = *row.combination;
  record.threads = row.threads > 0 ? row.threads : threads();
  record.run.strategy = row.strategy;
  record.run.outcome = Outcome::diverged;
  record.run.cause = why;
  return record;
}

/// A run whose numbers were kept when the disk was full, or the command was ended, has no files for ParaView.
void Comparison::tell_missing_files(const ScenePlan& plan, const Record& record, int repeat) const {
  if (repeat > 0 || plan.varied() || record.run.curve.empty() || !request_.to_screen()) return;
  if (std::filesystem::exists(request_.out + "/" + file_name(record.scene, record.run.strategy) + ".pvd")) return;
  fmt::print("  {}, {}: its numbers are here, but not its states; run it into another folder for them\n", record.scene,
             record.run.strategy);
}

Record Comparison::run_one(Scene& scene, const StrategyChoice& choice, const PlannedRow& row) {
  const Stopwatch watch;
  prepare(scene.specimen, choice.strategy);
  const double prepared = watch.seconds();
  RunOptions options = options_of(*row.plan, scene, choice);
  options.derivatives =
      derivatives_by(request_.gradient, scene, choice, catalog_, overrides_of(request_.overrides, *row.combination));
  Run run = run_strategy(scene.specimen, *scene.experiment, choice, options);
  run.build_seconds += prepared;  // once a body: the first strategy that needs it pays
  check_deviations(scene, options, run);
  Record record = make_record(scene, std::move(run));
  record.variant = *row.combination;
  if (!record.variant.empty()) record.verdicts.clear();  // the scene speaks of the body that it describes
  if (row.plan->repeats > 1) record.repeats = {{record.run.build_seconds, record.run.solve_seconds}};
  if (request_.compare && !row.plan->varied()) add_directions(scene, choice, options, record);
  return record;
}

/// Of a strategy that may be recommended: whether that is true elsewhere too.
void Comparison::add_directions(const Scene& scene, const StrategyChoice& choice, const RunOptions& options,
                                Record& record) {
  if (!has_own_error(record)) return;
  std::vector<Record> alone;
  alone.push_back(std::move(record));  // with its states, which are large
  const Ranking ranking = rank_strategies(alone);
  record = std::move(alone.front());
  if (ranking.measures.empty() || ranking.by_scatter || !(ranking.error(record) <= kNear)) return;
  progress_.set(scene.name + ", " + choice.label + ": in other directions");
  record.directions = measure_directions(scene, choice, options, record.run);
  if (!record.directions->measured() && options.stop()) interrupt(record.run);
}

/// The one that runs a row; null: a strategy does.
const Engine* engine_of(const PlannedRow& row) {
  for (const Engine& engine : row.plan->engines)
    if (engine.name == row.strategy) return &engine;
  return nullptr;
}

Record Comparison::run_elsewhere(const Engine& engine, Scene& scene, const PlannedRow& row) {
  progress_.set(scene.name + ", " + row.strategy);
  OtherRun other =
      run_engine(engine, scene, catalog_, overrides_of(request_.overrides, *row.combination), request_.interrupted);
  const Scene& solved = other.scene ? *other.scene : scene;
  measure_law(solved.specimen, *solved.experiment, solved.stiffness, {.statics = solved.statics}, other.run);
  Record record = make_record(solved, std::move(other.run));
  record.variant = *row.combination;
  record.verdicts.clear();  // they are about Elastin
  if (row.plan->repeats > 1) record.repeats = {{record.run.build_seconds, record.run.solve_seconds}};
  return record;
}

void Comparison::run_combination(ScenePlan& plan, const std::vector<std::pair<std::string, std::string>>& combination,
                                 std::size_t first_row, int repeat) {
  std::unique_ptr<Scene> scene;
  if (combination.empty() && plan.scene) scene = std::move(plan.scene);
  std::vector<StrategyChoice> choices;
  std::string trouble;
  const auto load = [&] {  // only where a row is missing
    try {
      if (!scene) {
        scene = load_scene(plan.source, catalog_, overrides_of(request_.overrides, combination));
        scene->name = plan.name;
      }
      choices = chosen_strategies(request_, catalog_, *scene);
      add_references(plan, combination, choices, *scene);
    } catch (const std::exception& error) {
      trouble = error.what();
    }
  };
  std::size_t number = first_row;
  for (const int count : plan.threads)
    for (const std::string& strategy : plan.strategies) {
      if (!runs_here(number++)) continue;
      if (stopped_) return;
      const PlannedRow row{&plan, &combination, count, strategy};
      const std::string key = key_of(row, repeat, request_.overrides, machine_);
      const Record* known = journal_ ? journal_->find(key) : nullptr;
      if (known) {
        tell_missing_files(plan, *known, repeat);
        finish_run(plan, "", *known, nullptr, repeat);
        continue;
      }
      if (choices.empty() && trouble.empty()) load();
      stopped_ = request_.interrupted && request_.interrupted();  // without references a rule would be unsuited
      if (stopped_) return;
      const Stopwatch watch;
      if (count > 0) set_threads(count);
      Record record;
      const StrategyChoice* choice = find_strategy(choices, strategy);
      const Engine* engine = choice ? nullptr : engine_of(row);
      if (scene && engine) {
        record = run_elsewhere(*engine, *scene, row);
      } else if (!choice) {
        record = failed_run(row, trouble.empty() ? "the changed scene has no such strategy" : trouble);
      } else if (plan.varied()) {
        try {
          record = run_one(*scene, *choice, row);
        } catch (const std::exception& error) {  // a row of a study that cannot run is a row
          record = failed_run(row, error.what());
        }
      } else {
        record = run_one(*scene, *choice, row);
      }
      progress_.pause();
      seconds_ += watch.seconds();
      ++run_;
      finish_run(plan, key, std::move(record), scene.get(), repeat);
      stopped_ = request_.interrupted && request_.interrupted();
    }
  if (combination.empty() && plan.repeats > repeat + 1) plan.scene = std::move(scene);
}

void Comparison::finish_run(const ScenePlan& plan, const std::string& key, Record record, const Scene* scene,
                            int repeat) {
  // `run` names its one strategy: that it cannot run is a failure; in a comparison it is a row.
  // A comparison in which nothing could run has not compared.
  suited_ |= record.run.suited || record.stopped_as_expected();
  good_ &= record.good() && (request_.compare || record.run.suited || record.stopped_as_expected());
  // The numbers first: a disk that is full with states does not lose them.
  if (journal_ && !key.empty() && record.run.outcome != Outcome::interrupted)
    journal_->add(key, source_of(plan), record);
  if (scene && repeat == 0) {
    const bool shown = journal_ && !request_.out.empty() && !scene->specimen.body.share;  // a share is not the body
    if (shown && !results_.has_body(record)) journal_->add_view(body_view(*scene, record));
    if (const std::string states = shown ? states_view(*scene, record) : ""; !states.empty())
      journal_->add_view(states);
    if (!plan.varied() && !record.run.snapshots.empty()) write_run(request_, *scene, record);
  }
  record.run.snapshots.clear(), record.run.modes.clear();
  if (record.run.constants.size() > 1)  // of many rows; the summary needs the least
    record.run.constants.setConstant(1, double{record.run.constants.minCoeff()});
  if (request_.to_screen() && (!request_.compare || (request_.verbose && !key.empty())))
    fmt::print("{}", run_text(record, colours_on(STDOUT_FILENO), request_.verbose));
  ++done_;
  if (request_.compare && rows_ > 1 && !key.empty()) progress_.note(finished_text(record));
  results_.add(std::move(record), repeat);
  if (written_.seconds() < 1) return;
  write_tables(request_, results_.records(), false);  // so that partial results are visible
  written_ = {};
}

void Comparison::open_journal() {
  std::vector<RunSource> sources;
  for (const ScenePlan& plan : plans_) sources.push_back(source_of(plan));
  journal_.emplace(request_.out, request_.resume, sources);
  if (request_.compare) write_study(request_, plans_);
}

bool Comparison::run() {
  progress_.set("reading scenes");
  plans_ = plan_of(request_, catalog_);
  shards_ = deal_rows(rows_of(plans_).size(), request_.shard.of);
  progress_.pause();
  if (!request_.restart.empty() && (plans_.size() != 1 || plans_[0].runs() != 1 || !plans_[0].scene->time))
    throw InputError("--restart continues one strategy of one scene that runs in time");
  if (!request_.out.empty()) open_journal();
  if (!request_.resume) write_tables(request_, {}, false);  // an unwritable folder is an error before the first run
  int passes = 0;
  std::size_t number = 0;
  for (const ScenePlan& plan : plans_) {
    for (std::size_t row = 0; row < plan.runs(); ++row)
      if (runs_here(number++)) rows_ += static_cast<std::size_t>(plan.repeats);
    passes = std::max(passes, plan.repeats);
  }
  for (int repeat = 0; repeat < passes; ++repeat) {
    std::size_t first_row = 0;
    for (ScenePlan& plan : plans_) {
      for (const auto& combination : plan.combinations) {
        if (repeat < plan.repeats) run_combination(plan, combination, first_row, repeat);
        first_row += plan.threads.size() * plan.strategies.size();
      }
      if (stopped_) break;
      if (repeat == 0 && request_.shard.of == 1) results_.print_scene(plan);
    }
  }
  finish();
  return good_ && (suited_ || rows_ == 0 || request_.shard.of > 1) &&
         done_ == rows_;  // one that was stopped between two runs has not done what was requested
}

void Comparison::finish() {
  if (request_.shard.of > 1) {  // a share of the rows has no tables and recommends nothing
    write_tables(request_, results_.records());
    if (request_.json == "-") fmt::print("{}", json_text(results_.records()));
    if (request_.to_screen())
      fmt::print("  shard {}/{}: {} of {} runs in {}/; elastin merge puts the shards together\n", request_.shard.number,
                 request_.shard.of, done_, rows_, request_.out);
  } else {
    results_.finish(
        plans_, stopped_, journal_.has_value(),
        {machine_.text(), request_.command, journal_ ? lines_of(journal_->views_path()) : std::vector<std::string>{}});
  }
  if (stopped_ && !request_.out.empty() && done_ < rows_ && request_.to_screen())
    fmt::print("  stopped after {} of {} runs; --resume {} continues\n", done_, rows_, shell_word(request_.out));
}

}  // namespace

Progress::Show progress_of(const Output& output) {
  if (output.quiet) return Progress::Show::nothing;
  return isatty(STDERR_FILENO) ? Progress::Show::line : Progress::Show::lines;
}

bool run_scenes(const Request& request, const Catalog& catalog) { return Comparison(request, catalog).run(); }

}  // namespace elastin::lab
