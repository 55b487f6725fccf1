#include "lab/study/study.h"

#include "command/row.h"

namespace elastin::command {
namespace {

struct MergeCommand {
  std::vector<std::string> folders;
  lab::Output output;

  void add_to(Options& options) {
    options.argument("FOLDER", into(folders), "Folders of `compare --shard N/M --out FOLDER`, of one study", true,
                     true);
    options.add("--out", "FOLDER", into(output.out),
                "Folder for the page, CSV, JSON, curves and ParaView files of all runs");
    options.add("--json", "FILE", into(output.json), "JSON file; - for standard output, and nothing else there");
    options.flag("--quiet", output.quiet, "Print nothing but errors and missing runs");
    add_baseline_option(options, output);
    add_table_options(options, output);
  }

  int run(const Call& call) {
    output.command = call.line;
    return lab::merge_studies(folders, output) ? 0 : 1;
  }
};

}  // namespace

const CommandRow kMerge{
    "merge", "Put the runs of a study together that several `compare --shard` have made",
    R"(merge study/* --out out                               the table and page of the runs of all jobs
)",
    &declare<MergeCommand>};

}  // namespace elastin::command
