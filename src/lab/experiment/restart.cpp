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

void put(std::string& out, const std::vector<TouchMemory>& touches) {
  put(out, static_cast<int>(touches.size()));
  for (const TouchMemory& touch : touches) {
    out += "\n";
    for (const int value : {touch.sample, touch.target, touch.count}) put(out, value);
    for (const int molecule : touch.molecules) put(out, molecule);
    for (const double weight : touch.weights) put(out, weight);
    for (const double value : touch.offset) put(out, value);
    put(out, touch.multiplier);
  }
  out += "\n";
}

std::vector<TouchMemory> touches_of(Words& words) {
  const int count = words.count();
  std::vector<TouchMemory> found(static_cast<std::size_t>(count));
  for (TouchMemory& touch : found) {
    touch.sample = words.whole();
    touch.target = words.whole();
    touch.count = words.whole();
    for (int& molecule : touch.molecules) molecule = words.whole();
    for (double& weight : touch.weights) weight = words.number();
    for (double& value : touch.offset) value = words.number();
    touch.multiplier = words.number();
  }
  return found;
}

/// All of one size, and touches of molecules that there are.
void check(const State& state) {
  const Eigen::Index molecules = state.positions.cols(), known = state.accelerations.cols();
  if (state.velocities.cols() != molecules || (known != 0 && known != molecules))
    throw InputError("the restart file is damaged: its places, velocities and accelerations are not equally many");
  for (const TouchMemory& touch : state.touches) {
    bool sound = touch.count >= 0 && touch.count <= 3;
    for (int i = 0; sound && i < touch.count; ++i)
      sound =
          touch.molecules[static_cast<std::size_t>(i)] >= 0 && touch.molecules[static_cast<std::size_t>(i)] < molecules;
    if (!sound) throw InputError("the restart file is damaged: a touch of a molecule that there is not");
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
  put(out, point.state.touches);
  put(out, static_cast<int>(point.rows.size()));
  for (const CurvePoint& row : point.rows) {
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
  point.state.touches = touches_of(words);
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
    point.rows.push_back(std::move(row));
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
