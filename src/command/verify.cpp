#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "command/row.h"
#include "elastin/core/base/stop.h"
#include "lab/report/records.h"
#include "lab/report/screen.h"
#include "lab/report/table.h"
#include "lab/scene/scene.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

using namespace lab;

struct VerifyCommand {
  SceneOptions scene;
  Output output;
  bool choices = false, steppers = false, markdown = false;

  void add_to(Options& options) {
    scene.add_to(options);
    add_output_options(options, output,
                       "Print every run in full as it is finished, before the table, with every point of its curve");
    options.flag("--choices", choices,
                 "Also run each case with explicit steps, implicit steps, small displacements, plain springs");
    options.flag("--steppers", steppers, "Also run each case in time with every stepper");
    options.flag("--markdown", markdown, "Print the table as Markdown, with titles");
  }

  int run(const Call& call) {
    const std::vector<SceneSource> sources = scene.open();
    output.quiet = scene.quiet;
    Progress progress(progress_of(output));
    for (const SceneSource& source : sources)
      load_scene(source, call.catalog, scene.overrides);  // errors in scenes come before the first run
    write_tables(output, {});
    VerifyOptions verify{scene.overrides, choices, steppers, !output.out.empty()};
    verify.progress = [&](const std::string& doing) { progress.set(doing); };
    verify.finished = [&](const Scene& verified, Record& record) {
      write_run(output, verified, record);
      if (!output.verbose || !output.to_screen()) return;
      progress.pause();
      fmt::print("{}", run_text(record, colours_on(STDOUT_FILENO), true));
    };
    stop_on_interrupt();
    const StopScope stop(interrupted);
    std::vector<Case> cases;
    std::vector<Record> records;
    std::size_t verified = 0;
    for (; verified < sources.size(); ++verified) {
      std::vector<Case> of_scene;
      try {
        of_scene = verify_scene(sources[verified], call.catalog, verify);
      } catch (const InputError&) {
        if (!interrupted()) throw;
      }
      if (interrupted()) break;
      for (Case& a_case : of_scene) {
        records.push_back(a_case.own);
        cases.push_back(std::move(a_case));
      }
      write_tables(output, records);
    }
    progress.pause();
    if (output.to_screen() && !cases.empty())
      fmt::print("{}", verdicts_text(cases, colours_on(STDOUT_FILENO), markdown));
    if (output.json == "-") fmt::print("{}", json_text(records));
    const auto failed = [](const Case& a_case) { return result_of(a_case) == CaseResult::failed; };
    if (interrupted())
      fmt::print(stderr, "  stopped: {} of {} are verified\n", verified, counted(sources.size(), "scene"));
    return interrupted() || std::any_of(cases.begin(), cases.end(), failed) ? 1 : 0;
  }
};

}  // namespace

const CommandRow kVerify{
    "verify", "Compare scenes with the results that they expect; print verdicts",
    R"(verify scenes/hard/*.yaml --choices                   hard cases compared with their known results
)",
    &declare<VerifyCommand>};

}  // namespace elastin::command
