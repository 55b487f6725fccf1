#include "lab/experiment/restart.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

constexpr const char* kHead = "elastin-restart-2";

void put(std::string& out, double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%a ", value);
  out += text;
}
void put(std::string& out, int value) { out += std::to_string(value) + " "; }
void put(std::string& out, const Positions& values) {
  put(out, static_cast<int>(values.cols()));
  for (const double value : values.reshaped()) put(out, value);
  out += "\n";
}

/// Words of a text, one after the other.
class Words {
 public:
  explicit Words(const std::string& text) : stream_(text) {}
  std::string next() {
    std::string word;
    if (!(stream_ >> word)) throw InputError("the restart file is cut off");
    return word;
  }
  double number() {
    const std::string word = next();
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (*end != 0 || end != word.c_str() + word.size())
      throw InputError("the restart file is damaged: '" + word + "' is no number");
    return value;
  }
  int whole() {
    const std::string word = next();
    int value = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (problem != std::errc() || end != word.data() + word.size())
      throw InputError("the restart file is damaged: '" + word + "' is no whole number");
    return value;
  }
  /// How many things follow: not more than what is left has letters.
  int count() {
    const int given = whole();
    const auto left = stream_.rdbuf()->in_avail();
    if (given < 0 || given > left)
      throw InputError("the restart file is damaged: " + std::to_string(given) + " things");
    return given;
  }
  Positions positions() {
    const int columns = count();
    Positions values(3, columns);
    for (double& value : values.reshaped()) value = number();
    return values;
  }

 private:
  std::istringstream stream_;
};

void put(std::string& out, const std::vector<ContactHistory>& contact_history) {
  put(out, static_cast<int>(contact_history.size()));
  for (const ContactHistory& entry : contact_history) {
    out += "\n";
    for (const int value : {entry.sample, entry.target, entry.count}) put(out, value);
    for (const int molecule : entry.molecules) put(out, molecule);
    for (const double weight : entry.weights) put(out, weight);
    for (const double value : entry.offset) put(out, value);
    put(out, entry.multiplier);
  }
  out += "\n";
}

std::vector<ContactHistory> contact_history_of(Words& words) {
  const int count = words.count();
  std::vector<ContactHistory> found(static_cast<std::size_t>(count));
  for (ContactHistory& entry : found) {
    entry.sample = words.whole();
    entry.target = words.whole();
    entry.count = words.whole();
    for (int& molecule : entry.molecules) molecule = words.whole();
    for (double& weight : entry.weights) weight = words.number();
    for (double& value : entry.offset) value = words.number();
    entry.multiplier = words.number();
  }
  return found;
}

/// All of one size, and touches of molecules that there are.
void check(const State& state) {
  const Eigen::Index molecules = state.positions.cols(), known = state.accelerations.cols();
  if (state.velocities.cols() != molecules || (known != 0 && known != molecules))
    throw InputError("the restart file is damaged: its positions, velocities and accelerations are not equally many");
  for (const ContactHistory& entry : state.contact_history) {
    bool sound = entry.count >= 0 && entry.count <= 3;
    for (int i = 0; sound && i < entry.count; ++i)
      sound =
          entry.molecules[static_cast<std::size_t>(i)] >= 0 && entry.molecules[static_cast<std::size_t>(i)] < molecules;
    if (!sound) throw InputError("the restart file is damaged: a contact point of a molecule that does not exist");
  }
}

}  // namespace

std::string restart_text(const RestartPoint& point, const std::string& identity) {
  std::string out = std::string(kHead) + " " + identity + "\n";
  put(out, point.frame);
  put(out, point.state.time);
  put(out, point.dissipated);
  put(out, point.work);
  const auto& m = point.memory;
  for (const double value : {m.wanted, m.first_bound, m.stable, m.critical, m.frequency, m.shortest, m.last})
    put(out, value);
  for (const int value : {m.steps, m.rejected, point.newton_iterations, point.linear_iterations}) put(out, value);
  out += "\n";
  put(out, point.state.positions);
  put(out, point.state.velocities);
  put(out, point.state.accelerations);
  put(out, point.state.contact_history);
  put(out, static_cast<int>(point.history.size()));
  for (const CurvePoint& row : point.history) {
    out += "\n";
    for (const double value : {row.load_factor, row.residual, row.time, row.step}) put(out, value);
    for (const int value : {row.newton_iterations, row.linear_iterations, row.steps}) put(out, value);
    put(out, static_cast<int>(row.measures.all().size()));
    for (const auto& [name, value] : row.measures.all()) {
      out += name + " ";
      put(out, value);
    }
  }
  return out + "\nend\n";
}

RestartPoint parse_restart(const std::string& text, const std::string& identity) {
  Words words(text);
  if (text.empty() || words.next() != kHead) throw InputError("this is no restart file");
  if (const std::string given = words.next(); given != identity)
    throw InputError("this is the restart file of another run: it is of " + given + ", here runs " + identity);
  RestartPoint point;
  point.frame = words.whole();
  point.state.time = words.number();
  point.dissipated = words.number();
  point.work = words.number();
  auto& m = point.memory;
  for (double* value : {&m.wanted, &m.first_bound, &m.stable, &m.critical, &m.frequency, &m.shortest, &m.last})
    *value = words.number();
  for (int* value : {&m.steps, &m.rejected, &point.newton_iterations, &point.linear_iterations}) *value = words.whole();
  point.state.positions = words.positions();
  point.state.velocities = words.positions();
  point.state.accelerations = words.positions();
  point.state.contact_history = contact_history_of(words);
  check(point.state);
  const int rows = words.count();
  for (int i = 0; i < rows; ++i) {
    CurvePoint row;
    for (double* value : {&row.load_factor, &row.residual, &row.time, &row.step}) *value = words.number();
    for (int* value : {&row.newton_iterations, &row.linear_iterations, &row.steps}) *value = words.whole();
    const int measures = words.count();
    for (int k = 0; k < measures; ++k) {
      const std::string name = words.next();
      row.measures.set(name, words.number());
    }
    point.history.push_back(std::move(row));
  }
  if (words.next() != "end") throw InputError("the restart file is damaged: it does not end where it should");
  return point;
}

std::string restart_identity(const Body& body, const std::string& strategy, const TimeOptions& options,
                             const std::string& scheme) {
  std::uint64_t hash = 14695981039346656037u;  // [FNV-1a]
  const auto add = [&](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211u;
  };
  add(body.rest.data(), sizeof(double) * static_cast<std::size_t>(body.rest.size()));
  add(body.mass.data(), sizeof(double) * static_cast<std::size_t>(body.mass.size()));
  add(body.connections.ends.data(), sizeof(int) * 2 * body.connections.ends.size());
  const double frame = options.duration / options.frames;
  add(&frame, sizeof frame);
  char text[32];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  std::string name = strategy;
  for (char& c : name)
    if (std::strchr(" \t\n", c)) c = '_';
  return name + "," + scheme + "," + text;
}

}  // namespace elastin::lab
