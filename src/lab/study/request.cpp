#include "lab/study/request.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "lab/report/files.h"
#include "lab/report/records.h"

namespace elastin::lab {

std::string file_name(const std::string& scene, const std::string& strategy) {
  // No two labels may have one name: of the letters that are written otherwise only ":" becomes "-".
  const auto written = [](const std::string& text, std::string_view escaped) {
    std::string name;
    for (const char c : text)
      if (escaped.find(c) != std::string_view::npos)
        name += fmt::format("~{:02x}", c);
      else
        name += c == ':' ? '-' : c;
    return name;
  };
  constexpr std::string_view everywhere = "/\\\"'<>&|*?~ ";
  return written(scene, everywhere) + "-" + written(strategy, std::string(everywhere) + "-");
}

void write_report(const Output& output, PageMatter matter) {
  if (!output.peers.empty()) matter.peers = load_peers(output.peers);
  for (const auto& [name, text] : plot_files(matter.records, matter.peers)) write_whole(output.out + "/" + name, text);
  write_whole(output.out + "/report.html", page_text(matter));
}

bool colours_on(int stream) { return std::getenv("CLICOLOR_FORCE") || (isatty(stream) && !std::getenv("NO_COLOR")); }

void write_tables(const Output& output, const std::vector<Record>& records) {
  if (!output.out.empty()) {
    write_whole(output.out + "/runs.csv", csv_text(records));
    write_whole(output.out + "/runs.json", json_text(records));
  }
  if (!output.json.empty() && output.json != "-") write_whole(output.json, json_text(records));
}

void write_run(const Output& output, const Scene& scene, Record& record) {
  const Body& body = scene.specimen.body;
  const std::string& folder = output.out.empty() ? output.pieces : output.out;
  if (folder.empty() || record.run.curve.empty()) return;
  const std::string name = file_name(record.scene, record.run.strategy);
  if (body.share) write_pieces(folder, name, body, record.run);
  if (body.share || output.out.empty()) record.run.snapshots.clear();
  if (output.out.empty()) return;
  write_whole(output.out + "/" + name + "-curve.csv", curve_csv_text(record));
  if (body.share) return;
  const auto& contact = scene.specimen.contact;
  write_states(output.out, name, body, record.run, contact ? contact->obstacles : std::vector<contact::Obstacle>{});
  record.run.snapshots.clear();
}

}  // namespace elastin::lab
