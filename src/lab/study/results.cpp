#include "lab/study/plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <utility>

#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/image_fields.h"
#include "lab/report/records.h"
#include "lab/study/request.h"

namespace elastin::lab {

void write_report(const Output& output, PageMatter matter) {
  if (!output.peers.empty()) matter.peers = load_peers(output.peers);
  for (const auto& [name, text] : plot_files(matter.records, matter.peers)) write_whole(output.out + "/" + name, text);
  write_whole(output.out + "/report.html", page_text(matter));
}

bool colours_on(int stream) { return std::getenv("CLICOLOR_FORCE") || (isatty(stream) && !std::getenv("NO_COLOR")); }

void write_tables(const Output& output, const std::vector<Record>& records, bool whole) {
  if (!output.out.empty()) {
    write_whole(output.out + "/runs.csv", csv_text(records));
    write_whole(output.out + "/runs.json", json_text(records));
  }
  if (output.json.empty() || output.json == "-") return;
  std::error_code ignored;
  const auto kind = std::filesystem::status(output.json, ignored).type();
  using enum std::filesystem::file_type;
  const bool goes_on = kind == fifo || kind == character || kind == socket;
  if (whole || !goes_on) write_whole(output.json, json_text(records));
}

void write_run(const Output& output, const Scene& scene, Record& record) {
  const Body& body = scene.specimen.body;
  if (!output.image.empty() && !record.run.snapshots.empty())
    write_image(output.image, output.image_spacing, scene, record.run);
  const std::string& folder = output.out.empty() ? output.pieces : output.out;
  if (folder.empty() || record.run.curve.empty()) return;
  const std::string name = file_name(record.scene, record.run.strategy);
  if (body.share) write_pieces(folder, name, body, record.run);
  if (body.share || output.out.empty()) record.run.snapshots.clear();
  if (output.out.empty()) return;
  write_whole(output.out + "/" + name + "-curve.csv", curve_csv_text(record));
  if (body.share) return;
  write_states(output.out, name, body, record.run);
  record.run.snapshots.clear();
}

Results::Results(const Request& request) : request_(request) {
  if (!request.peers.empty()) peers_ = load_peers(request.peers);
  if (!request.baseline.empty()) baseline_ = load_baseline(request.baseline);
}

void Results::add(Record record, int repeat) {
  const auto same = [&](const Record& r) {
    return r.scene == record.scene && r.variant == record.variant && r.threads == record.threads &&
           r.run.strategy == record.run.strategy;
  };
  const auto row = repeat > 0 ? std::find_if(records_.begin(), records_.end(), same) : records_.end();
  if (row != records_.end())
    row->add_repeat(record);
  else
    records_.push_back(std::move(record));
}

bool Results::has_body(const Record& record) const {
  return std::any_of(records_.begin(), records_.end(),
                     [&](const Record& r) { return r.scene == record.scene && r.variant == record.variant; });
}

std::vector<Record> Results::records_of(const std::string& scene) const {
  std::vector<Record> found;
  for (const Record& record : records_)
    if (record.scene == scene) found.push_back(record);
  return found;
}

void Results::print_table(const ScenePlan& plan) const {
  if (request_.to_screen() && request_.compare && !request_.summary) {
    const std::vector<Record> records = records_of(plan.name);
    fmt::print("{}", plan.varied() || plan.repeats > 1 ? study_text(records, colours_on(STDOUT_FILENO), peers_)
                                                       : comparison_text(records, colours_on(STDOUT_FILENO)));
  }
  std::fflush(stdout);
}

void Results::print_scene(const ScenePlan& plan) const {
  if (plan.repeats > 1 || plan.varied()) return;  // their references are not known before the end
  print_table(plan);
  if (request_.to_screen() && !request_.summary)
    for (const std::string& warning : plan.warnings) fmt::print("  warning: {}\n", warning);
}

/// Without another reference a study's own strategy is the reference, refined; also where the scene requests it.
void Results::refer_to_own_values(const std::vector<ScenePlan>& plans) {
  for (const ScenePlan& plan : plans) {
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

/// A row that could not even begin has the columns of the scene's others.
void Results::complete_failed_rows() {
  std::map<std::string, std::vector<MainMeasure>> measures;
  for (const Record& record : records_)
    if (!record.main_measures.empty()) measures.try_emplace(record.scene, record.main_measures);
  for (Record& record : records_)
    if (record.main_measures.empty() && measures.contains(record.scene)) record.main_measures = measures[record.scene];
}

void Results::finish(const std::vector<ScenePlan>& plans, bool stopped, bool page, Origin origin) {
  complete_failed_rows();
  refer_to_own_values(plans);
  for (const ScenePlan& plan : plans)
    if (plan.repeats > 1 || plan.varied() || stopped) print_table(plan);
  if (request_.to_screen() && request_.compare && (request_.summary || plans.size() > 1))
    fmt::print("{}", summary_text(records_, colours_on(STDOUT_FILENO)));
  write_tables(request_, records_);
  if (page && !records_.empty())
    write_report(request_, {records_,
                            std::move(origin.views),
                            {},
                            std::move(origin.machine),
                            std::move(origin.command),
                            baseline_,
                            request_.baseline});
  if (request_.to_screen() && !request_.baseline.empty()) {
    const Table change = change_table(records_, baseline_);
    fmt::print("  change since {}{}\n{}", request_.baseline, change.empty() ? ": no run in common" : "",
               change.empty() ? "" : change.text(colours_on(STDOUT_FILENO)));
  }
  if (request_.json == "-") fmt::print("{}", json_text(records_));
  const bool all_varied = std::all_of(plans.begin(), plans.end(), [](const ScenePlan& plan) { return plan.varied(); });
  const bool no_curve =
      std::all_of(records_.begin(), records_.end(), [](const Record& record) { return record.run.curve.empty(); });
  if (request_.to_screen() && !request_.out.empty())
    fmt::print("  files in {}/: report.html, runs.csv, runs.json{}\n", request_.out,
               all_varied || no_curve ? "" : ", curves, and .pvd for ParaView");
}

}  // namespace elastin::lab
