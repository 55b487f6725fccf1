#include "lab/study/compare.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "lab/report/baseline.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/json.h"
#include "lab/report/machine.h"
#include "lab/report/page.h"
#include "lab/report/progress.h"
#include "lab/report/ranking.h"
#include "lab/report/study.h"
#include "lab/report/summary.h"
#include "lab/report/view.h"
#include "lab/study/journal.h"
#include "lab/study/plan.h"
#include "lab/study/reference.h"

namespace elastin::lab {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::string restart_text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || std::filesystem::is_directory(path)) throw InputError("--restart: " + path + ": cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A comparison in progress.
class Comparison {
 public:
  Comparison(const Request& request, const Catalog& catalog)
      : request_(request), catalog_(catalog), progress_(progress_of(request)), store_(request.out) {}

  bool run();

 private:
  struct RunKey {
    const std::vector<std::pair<std::string, std::string>>* combination;
    int threads, repeat;
    std::string strategy;
  };
  void run_combination(ScenePlan& plan, const std::vector<std::pair<std::string, std::string>>& combination,
                       int repeat);
  Record run_one(const ScenePlan& plan, Scene& scene, const StrategyChoice& choice, const RunKey& run_key);
  Record failed_run(const ScenePlan& plan, const RunKey& run_key, const std::string& why) const;
  void finish_run(const ScenePlan& plan, const std::string& key, Record record, const Scene* scene,
                  const RunKey& run_key);
  RunSource source_of(const ScenePlan& plan) const {
    return {plan.name, key_of(std::vector{plan.text}), request_.overrides};
  }
  void add_references(const ScenePlan& plan, const std::vector<std::pair<std::string, std::string>>& combination,
                      const std::vector<StrategyChoice>& choices, Scene& scene);
  void open_journal();
  std::string text_of(const ScenePlan& plan, const RunKey& run_key) const;
  RunOptions options_of(const ScenePlan& plan, const Scene& scene, const StrategyChoice& choice);
  std::string finished_text(const Record& record) const;
  void print_scene(const ScenePlan& plan);
  void refer_to_own_values();
  std::vector<Record> records_of(const std::string& scene) const;

  const Request& request_;
  const Catalog& catalog_;
  Progress progress_;
  ReferenceStore store_;
  std::vector<ScenePlan> plans_;
  std::optional<Journal> journal_;
  std::vector<Record> records_;
  std::vector<Peer> peers_;
  std::vector<Record> baseline_;
  std::size_t rows_ = 0, done_ = 0, run_ = 0;  ///< runs of all repeats: there are, finished, not found finished
  double seconds_ = 0;                         ///< that the runs made here took
  Clock::time_point written_ = Clock::now();
  const Machine machine_ = this_machine();
  bool good_ = true, stopped_ = false;
};

/// "  3 of 18  cube, lattice: E +0.02 %, 12.0 ms": a run in one line, before its table is printed.
std::string Comparison::finished_text(const Record& record) const {
  std::string text = fmt::format("  {} of {}  {}, {}", done_, rows_, record.scene, record.run.strategy);
  if (const std::string variant = variant_text(record); !variant.empty()) text += ", " + variant;
  text += ": ";
  if (!solved(record)) return text + outcome_text(record.run);
  for (const MainMeasure& measure : record.main_measures) {
    const std::string name(measure.name);
    if (find_measure(name).unit == dimension::none) continue;
    const double to_reference = record.error(name + "_to_reference");
    const double error = std::isfinite(to_reference) ? to_reference : record.error(name);
    if (std::isfinite(error))
      return text + find_measure(name).label() + " " + percent(error) +
             (std::isfinite(to_reference) ? " to the reference, " : ", ") + readable_seconds(record.least_seconds());
  }
  return text + readable_seconds(record.least_seconds());
}

RunOptions Comparison::options_of(const ScenePlan& plan, const Scene& scene, const StrategyChoice& choice) {
  RunOptions result;
  result.statics = scene.statics;
  result.time = scene.time;
  result.live = request_.live;
  result.keep_snapshots = !request_.out.empty();
  result.progress = [this, name = scene.name + ", " + choice.label + ": "](const std::string& doing) {
    progress_.set_count({rows_, done_, run_, seconds_});
    progress_.set(name + doing);
  };
  result.stop = [this] { return request_.interrupted && request_.interrupted(); };
  if (!request_.restart.empty()) result.restart = restart_text_of(request_.restart);
  if (!request_.out.empty() && !plan.varied())
    result.checkpoint = [path = request_.out + "/" + file_name(scene.name, choice.label) +
                                ".restart"](const std::string& text) { write_whole(path, text); };
  return result;
}

/// A row is the same if its scene, what is changed, its strategy, threads, repeat and the program's flags are.
std::string Comparison::text_of(const ScenePlan& plan, const RunKey& run_key) const {
  std::vector<std::string> parts{plan.name,
                                 plan.text,
                                 run_key.strategy,
                                 std::to_string(run_key.threads),
                                 std::to_string(run_key.repeat),
                                 this_machine().compiler,
                                 this_machine().flags};
  for (const std::string& override : overrides_of(request_, *run_key.combination)) parts.push_back(override);
  return key_of(parts);
}

/// Gives the scene its computed references. `run`, which ranks nothing, computes them only where the scene or the
/// command asks for it, or where there is nothing else to calibrate to.
void Comparison::add_references(const ScenePlan& plan,
                                const std::vector<std::pair<std::string, std::string>>& combination,
                                const std::vector<StrategyChoice>& choices, Scene& scene) {
  if (!wants_computed_references(scene, request_.reference) || !plan.own_reference.empty()) return;
  const bool calibrates = scene.experiment->apparent() &&
                          std::any_of(choices.begin(), choices.end(), [](const auto& c) { return c.calibrated; });
  const bool asked =
      request_.reference == "computed" || scene.computed.when == ComputedReference::When::always || calibrates;
  if (!request_.compare && !asked) return;
  ComputedReferences found = compute_references(
      scene, catalog_, overrides_of(request_, combination), store_,
      [this, name = scene.name + ": "](const std::string& doing) {
        progress_.set_count({rows_, done_, run_, seconds_});
        progress_.set(name + doing);
      },
      request_.interrupted);
  progress_.pause();
  scene.specimen.references = std::move(found.references);
  scene.no_computed_reference = std::move(found.trouble);
}

Record Comparison::failed_run(const ScenePlan& plan, const RunKey& run_key, const std::string& why) const {
  Record record;
  record.scene = plan.name;
  record.title = plan.title;
  record.variant = *run_key.combination;
  record.threads = run_key.threads > 0 ? run_key.threads : threads();
  record.run.strategy = run_key.strategy;
  record.run.outcome = Outcome::diverged;
  record.run.cause = why;
  for (const Record& known : records_)  // so that its row has the others' columns
    if (known.scene == plan.name && !known.main_measures.empty()) record.main_measures = known.main_measures;
  return record;
}

Record Comparison::run_one(const ScenePlan& plan, Scene& scene, const StrategyChoice& choice, const RunKey& run_key) {
  const auto start = Clock::now();
  prepare(scene.specimen, choice.strategy);
  const double prepared = seconds_since(start);
  Run run = run_strategy(scene.specimen, *scene.experiment, choice, options_of(plan, scene, choice));
  run.build_seconds += prepared;  // once a body: the first strategy that needs it pays
  Record record = make_record(scene, std::move(run));
  record.variant = *run_key.combination;
  if (!record.variant.empty()) record.verdicts.clear();  // the scene speaks of the body that it describes
  if (plan.repeats > 1) record.repeats = {{record.run.build_seconds, record.run.solve_seconds}};
  return record;
}

void Comparison::run_combination(ScenePlan& plan, const std::vector<std::pair<std::string, std::string>>& combination,
                                 int repeat) {
  std::unique_ptr<Scene> scene;
  if (combination.empty() && plan.scene) scene = std::move(plan.scene);
  std::vector<StrategyChoice> choices;
  std::string trouble;
  const auto load = [&] {  // only where a row is missing
    try {
      if (!scene) scene = load_scene(plan.path, catalog_, overrides_of(request_, combination));
      choices = chosen_strategies(request_, catalog_, *scene);
      add_references(plan, combination, choices, *scene);
    } catch (const std::exception& error) {
      trouble = error.what();
    }
  };
  for (const int count : plan.threads)
    for (const std::string& strategy : plan.strategies) {
      if (stopped_) return;
      const RunKey run_key{&combination, count, repeat, strategy};
      const std::string key = text_of(plan, run_key);
      const Record* known = journal_ ? journal_->find(key) : nullptr;
      if (known) {
        finish_run(plan, "", *known, nullptr, run_key);
        continue;
      }
      if (choices.empty() && trouble.empty()) load();
      const auto start = Clock::now();
      if (count > 0) set_threads(count);
      Record record;
      const StrategyChoice* choice = find_strategy(choices, strategy);
      if (!choice) {
        record = failed_run(plan, run_key, trouble.empty() ? "the changed scene has no such strategy" : trouble);
      } else if (plan.varied()) {
        try {
          record = run_one(plan, *scene, *choice, run_key);
        } catch (const std::exception& error) {  // a row of a study that cannot run is a row
          record = failed_run(plan, run_key, error.what());
        }
      } else {
        record = run_one(plan, *scene, *choice, run_key);
      }
      progress_.pause();
      seconds_ += seconds_since(start);
      ++run_;
      finish_run(plan, key, std::move(record), scene.get(), run_key);
      stopped_ = request_.interrupted && request_.interrupted();
    }
  if (combination.empty() && plan.repeats > repeat + 1) plan.scene = std::move(scene);
}

void Comparison::finish_run(const ScenePlan& plan, const std::string& key, Record record, const Scene* scene,
                            const RunKey& run_key) {
  // `run` names its one strategy: that it cannot run is a failure; in a comparison it is a row.
  good_ &= record.good() && (request_.compare || record.run.suited || record.stopped_as_expected());
  if (scene && run_key.repeat == 0 && !record.run.snapshots.empty()) {
    const auto same_body = [&](const Record& r) { return r.scene == record.scene && r.variant == record.variant; };
    if (journal_ && std::none_of(records_.begin(), records_.end(), same_body))
      journal_->add_view(body_view(*scene, record));
    if (journal_) journal_->add_view(states_view(*scene, record));
    if (!plan.varied()) write_run(request_, *scene, record);
  }
  record.run.snapshots.clear();
  if (record.run.constants.size() > 1)  // of many rows; the summary asks for the least
    record.run.constants.setConstant(1, double{record.run.constants.minCoeff()});
  if (journal_ && !key.empty() && record.run.outcome != Outcome::interrupted)
    journal_->add(key, source_of(plan), record);
  if (request_.to_screen() && (!request_.compare || (request_.verbose && !key.empty())))
    fmt::print("{}", run_text(record, colours_on(STDOUT_FILENO)));
  ++done_;
  if (request_.compare && rows_ > 1 && !key.empty()) progress_.note(finished_text(record));
  const auto same = [&](const Record& r) {
    return r.scene == record.scene && r.variant == record.variant && r.threads == record.threads &&
           r.run.strategy == record.run.strategy;
  };
  const auto row = std::find_if(records_.begin(), records_.end(), same);
  if (run_key.repeat > 0 && row != records_.end())
    row->add_repeat(record);
  else
    records_.push_back(std::move(record));
  if (seconds_since(written_) < 1) return;
  write_tables(request_, records_);  // who looks in while it runs
  written_ = Clock::now();
}

std::vector<Record> Comparison::records_of(const std::string& scene) const {
  std::vector<Record> found;
  for (const Record& record : records_)
    if (record.scene == scene) found.push_back(record);
  return found;
}

void Comparison::print_scene(const ScenePlan& plan) {
  if (request_.to_screen() && request_.compare && !request_.summary) {
    const std::vector<Record> records = records_of(plan.name);
    fmt::print("{}", plan.varied() || plan.repeats > 1 ? study_text(records, colours_on(STDOUT_FILENO), peers_)
                                                       : comparison_text(records, colours_on(STDOUT_FILENO)));
  }
  std::fflush(stdout);
}

/// Where nothing else says what is right, a study's own strategy does, refined; and where the scene asks for that.
void Comparison::refer_to_own_values() {
  for (const ScenePlan& plan : plans_) {
    std::vector<Record> records = records_of(plan.name);
    if (!plan.varied() || records.empty()) continue;
    const Ranking ranking = rank_strategies(records);
    const bool untold = ranking.measures.empty() && ranking.no_reference.empty();
    if (plan.own_reference.empty() && !untold) continue;
    const std::string strategy = plan.own_reference.empty() ? plan.strategies.front() : plan.own_reference;
    const std::string trouble = refer_to_own(records, strategy);
    if (!trouble.empty()) records.front().warnings.push_back(trouble);
    if (!trouble.empty() && request_.to_screen()) fmt::print("  warning: {}\n", trouble);
    std::size_t next = 0;
    for (Record& record : records_)
      if (record.scene == plan.name) record = std::move(records[next++]);
  }
}

void Comparison::open_journal() {
  std::vector<RunSource> sources;
  for (const ScenePlan& plan : plans_) sources.push_back(source_of(plan));
  journal_.emplace(request_.out, request_.resume, sources);
}

bool Comparison::run() {
  progress_.set("reading scenes");
  plans_ = plan_of(request_, catalog_);
  progress_.pause();
  if (!request_.restart.empty() && (plans_.size() != 1 || plans_[0].runs() != 1 || !plans_[0].scene->time))
    throw InputError("--restart continues one strategy of one scene that runs in time");
  if (!request_.peers.empty()) peers_ = load_peers(request_.peers);
  if (!request_.baseline.empty()) baseline_ = load_baseline(request_.baseline);
  if (!request_.out.empty()) open_journal();
  if (!request_.resume) write_tables(request_, {});  // an unwritable folder is an error before the first run
  int passes = 0;
  for (const ScenePlan& plan : plans_) {
    rows_ += plan.runs() * static_cast<std::size_t>(plan.repeats);
    passes = std::max(passes, plan.repeats);
  }
  for (int repeat = 0; repeat < passes; ++repeat)
    for (ScenePlan& plan : plans_) {
      const std::vector<std::string> warnings = plan.scene ? plan.scene->warnings : std::vector<std::string>{};
      if (repeat < plan.repeats)
        for (const auto& combination : plan.combinations) run_combination(plan, combination, repeat);
      if (stopped_) break;
      if (plan.repeats > 1 || plan.varied()) continue;
      if (repeat == 0) {
        print_scene(plan);
        if (request_.to_screen() && !request_.summary)
          for (const std::string& warning : warnings) fmt::print("  warning: {}\n", warning);
      }
    }
  refer_to_own_values();
  for (const ScenePlan& plan : plans_)
    if (plan.repeats > 1 || plan.varied() || stopped_) print_scene(plan);
  if (request_.to_screen() && request_.compare && (request_.summary || plans_.size() > 1))
    fmt::print("{}", summary_text(records_, colours_on(STDOUT_FILENO)));
  write_tables(request_, records_);
  if (journal_ && !records_.empty())
    write_report(request_, {records_,
                            lines_of(journal_->views_path()),
                            {},
                            machine_.text(),
                            request_.command,
                            baseline_,
                            request_.baseline});
  if (request_.to_screen() && !request_.baseline.empty()) {
    const Table change = change_table(records_, baseline_);
    fmt::print("  change since {}{}\n{}", request_.baseline, change.empty() ? ": no run in common" : "",
               change.empty() ? "" : change.text(colours_on(STDOUT_FILENO)));
  }
  if (request_.json == "-") fmt::print("{}", json_text(records_));
  const bool all_varied =
      std::all_of(plans_.begin(), plans_.end(), [](const ScenePlan& plan) { return plan.varied(); });
  if (request_.to_screen() && !request_.out.empty())
    fmt::print("  files in {}/: report.html, runs.csv, runs.json{}\n", request_.out,
               all_varied ? "" : ", curves, and .pvd for ParaView");
  if (stopped_ && !request_.out.empty() && done_ < rows_ && request_.to_screen())
    fmt::print("  stopped after {} of {} runs; --resume {} continues\n", done_, rows_, request_.out);
  return good_;
}

}  // namespace

Progress::Show progress_of(const Request& request) {
  if (request.quiet) return Progress::Show::nothing;
  return isatty(STDERR_FILENO) ? Progress::Show::line : Progress::Show::lines;
}

bool run_scenes(const Request& request, const Catalog& catalog) { return Comparison(request, catalog).run(); }

}  // namespace elastin::lab
