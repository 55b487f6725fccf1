#include "lab/study/request.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "lab/report/files.h"
#include "lab/report/json.h"

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

void write_report(const Request& request, PageMatter matter) {
  if (!request.peers.empty()) matter.peers = load_peers(request.peers);
  for (const auto& [name, text] : plot_files(matter.records, matter.peers)) write_whole(request.out + "/" + name, text);
  write_whole(request.out + "/report.html", page_text(matter));
}

bool colours_on(int stream) { return std::getenv("CLICOLOR_FORCE") || (isatty(stream) && !std::getenv("NO_COLOR")); }

void write_tables(const Request& request, const std::vector<Record>& records) {
  if (!request.out.empty()) {
    write_whole(request.out + "/runs.csv", csv_text(records));
    write_whole(request.out + "/runs.json", json_text(records));
  }
  if (!request.json.empty() && request.json != "-") write_whole(request.json, json_text(records));
}

void write_run(const Request& request, const Scene& scene, Record& record) {
  const Body& body = scene.specimen.body;
  const std::string& folder = request.out.empty() ? request.pieces : request.out;
  if (folder.empty() || record.run.curve.empty()) return;
  const std::string name = file_name(record.scene, record.run.strategy);
  if (body.share) write_pieces(folder, name, body, record.run);
  if (body.share || request.out.empty()) record.run.snapshots.clear();
  if (request.out.empty()) return;
  write_whole(request.out + "/" + name + "-curve.csv", curve_csv_text(record));
  if (body.share) return;
  const auto& contact = scene.specimen.contact;
  write_states(request.out, name, body, record.run, contact ? contact->obstacles : std::vector<contact::Obstacle>{});
  record.run.snapshots.clear();
}

}  // namespace elastin::lab
