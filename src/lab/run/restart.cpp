#include "lab/run/restart.h"

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "core/base/archive.h"
#include "core/model/visit_state.h"
#include "elastin/core/base/error.h"

namespace elastin::lab {

namespace {

constexpr std::string_view kName = "elastin-restart-";
constexpr const char* kHead = "elastin-restart-6";  // another format, or another meaning of a number, counts on
constexpr std::string_view kEnd = "\nend\n";

std::string hex(std::uint64_t value) {
  char text[32];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

template <class Archive>
void visit(Archive& archive, CurvePoint& row) {
  for (double* value : {&row.load_factor, &row.residual, &row.time, &row.step}) visit(archive, *value);
  for (int* value : {&row.newton_iterations, &row.linear_iterations, &row.steps}) archive.whole(*value);
  auto measures = row.measures.all();
  measures.resize(archive.count(measures.size(), 1));
  for (auto& [name, value] : measures) {
    archive.word(name);
    visit(archive, value);
    if constexpr (Archive::reads) row.measures.set(name, value);
  }
}

template <class Archive>
void visit(Archive& archive, RestartPoint& point) {
  auto& m = point.memory;
  for (int* value : {&point.frame, &m.steps, &m.rejected, &point.newton_iterations, &point.linear_iterations})
    archive.whole(*value);
  for (double* value : {&point.dissipated, &point.work, &point.taken, &point.jumps, &m.wanted, &m.first_bound,
                        &m.stable, &m.critical, &m.frequency, &m.shortest, &m.last})
    visit(archive, *value);
  visit(archive, point.state);
  visit_all(archive, point.curve);
  visit_all(archive, point.history);
}

std::string restart_text(const RestartPoint& point, const std::string& identity) {
  TextWriter writer;
  RestartPoint copy = point;
  visit(writer, copy);
  const std::string& body = writer.text();
  return std::string(kHead) + " " + identity + " " + hex(checksum(body.data(), body.size())) + "\n" + body +
         std::string(kEnd);
}

RestartPoint parse_restart(const std::string& text, const std::string& identity, const std::string& path) {
  const std::string what = "the restart file";
  const std::size_t line = text.find('\n');
  std::string head, of, sum;
  TextReader first(text.substr(0, line), what, {path, 1, 1});
  if (!text.starts_with(kName)) first.fail("this is no restart file");
  first.word(head);
  if (head != kHead)
    first.fail("this restart file is of another version of the program ('" + head.substr(0, 40) + "', here '" + kHead +
               "'), whose numbers mean something else: run the scene from its start");
  first.word(of);
  if (of != identity) first.fail("this is the restart file of another run: it is of " + of + ", here runs " + identity);
  first.word(sum);
  if (line == std::string::npos || text.size() < line + 1 + kEnd.size() || !text.ends_with(kEnd)) {
    TextReader whole(text, what, {path, 1, 1});
    for (std::string word; true;) whole.word(word);  // fails at the end
  }
  const std::string body = text.substr(line + 1, text.size() - line - 1 - kEnd.size());
  if (hex(checksum(body.data(), body.size())) != sum) first.fail(what + " is damaged: its checksum does not hold");
  TextReader reader(body, what, {path, 2, 1});
  RestartPoint point;
  visit(reader, point);
  return point;
}

std::string restart_identity(const Body& body, const std::string& strategy, const TimeOptions& options,
                             const std::string& scheme) {
  std::uint64_t hash = checksum(nullptr, 0);
  const auto add = [&](const void* data, std::size_t size) { hash = checksum(data, size, hash); };
  add(body.rest.data(), sizeof(double) * static_cast<std::size_t>(body.rest.size()));
  add(body.mass.data(), sizeof(double) * static_cast<std::size_t>(body.mass.size()));
  add(body.connections.ends.data(), sizeof(int) * 2 * body.connections.ends.size());
  const double frame = options.time_of(1), spread = options.first_frame > 0 ? options.duration : 0;
  add(&frame, sizeof frame);
  add(&spread, sizeof spread);
  std::string name = strategy;
  for (char& c : name)
    if (std::strchr(" \t\n", c)) c = '_';
  return name + "," + scheme + "," + hex(hash);
}

}  // namespace elastin::lab
