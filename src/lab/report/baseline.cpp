#include "lab/report/baseline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "elastin/core/base/error.h"
#include "lab/report/comparison.h"
#include "lab/report/json.h"
#include "lab/report/study.h"

namespace elastin::lab {
namespace {

/// Smaller changes are of the last digits that the solver's tolerance leaves open.
constexpr double kSame = 1e-9, kClose = 1e-3;

const Record* same_run(const std::vector<Record>& records, const Record& wanted) {
  const auto found = std::find_if(records.begin(), records.end(), [&](const Record& r) {
    return r.scene == wanted.scene && r.run.strategy == wanted.run.strategy && r.variant == wanted.variant;
  });
  return found == records.end() ? nullptr : &*found;
}

std::string outcome_change(const Record& then, const Record& now) {
  const std::string was = outcome_text(then.run), is = outcome_text(now.run);
  return was == is ? "" : was + " → " + is;
}

}  // namespace

std::vector<Record> load_baseline(const std::string& folder) {
  const std::string path = folder + "/runs.jsonl";
  std::ifstream stream(path);
  if (!stream)
    throw InputError("--baseline: " + path +
                     " cannot be read; a folder that `compare --out` or `run --out` wrote has it");
  std::vector<Record> records;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    try {
      const auto entry = nlohmann::ordered_json::parse(line, nullptr, false);  // what a journal writes
      if (!entry.is_object() || !entry.contains("run")) throw InputError("not an Elastin run record");
      Record record = record_of_json(entry["run"].dump());
      if (const Record* known = same_run(records, record))
        records[known - records.data()].add_repeat(record);
      else
        records.push_back(std::move(record));
    } catch (const InputError& error) {
      throw InputError(SourceLocation{path, number}, error.what());
    }
  }
  return records;
}

Table change_table(const std::vector<Record>& records, const std::vector<Record>& baseline) {
  Table table({"strategy", "measure", "then", "now", "change", "time then", "time now", "ratio", ""});
  for (const Record& record : records) {
    const Record* then = same_run(baseline, record);
    if (!then) continue;
    const double before = then->least_seconds(), seconds = record.least_seconds();
    for (const auto& [name, prescribed] : record.main_measures) {
      const MeasureInfo& info = record.measure(name);
      const double was = then->run.measures.get(info.name), is = record.run.measures.get(info.name);
      if (!std::isfinite(was) && !std::isfinite(is) && outcome_change(*then, record).empty()) continue;
      const double change = was == is ? 0 : (is - was) / std::abs(was);
      const Tone tone = std::abs(change) <= kSame ? Tone::faint : std::abs(change) <= kClose ? Tone::plain : Tone::poor;
      table.add({{run_name(record)},
                 {info.label()},
                 number_cell(value_text(was, info), was),
                 number_cell(value_text(is, info), is),
                 number_cell(std::abs(change) <= kSame ? "none" : percent(change), std::abs(change), tone),
                 number_cell(readable_seconds(before), before),
                 number_cell(readable_seconds(seconds), seconds),
                 number_cell(before > 0 ? fmt::format("{:.2f}", seconds / before) : "", seconds / before),
                 {outcome_change(*then, record), Tone::bad}});
    }
  }
  return table;
}

}  // namespace elastin::lab
