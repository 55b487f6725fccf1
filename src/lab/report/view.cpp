#include "lab/report/view.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/geometry/boundary.h"
#include "lab/report/pack.h"
#include "lab/report/study.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the page reads little-endian arrays");

constexpr std::size_t kMostConnections = 60'000, kMostFrames = 25;

template <class Value>
std::string bytes_text(const std::vector<Value>& values) {
  return base64(values.data(), values.size() * sizeof(Value));
}

/// Triangles of the body, or the sides of its tetrahedra that belong to one alone.
std::vector<std::array<int, 3>> surface_of(const Body& body) {
  Cells<3> surface = body.triangles;
  const Cells<3> boundary = boundary_of(body.tetrahedra);
  surface.insert(surface.end(), boundary.begin(), boundary.end());
  return surface;
}

/// What of a body is shown: by number.
struct Shown {
  std::vector<int> molecules, connections;
  std::vector<std::array<int, 3>> surface;
  std::string note;
};

/// On the surface: its corners, or where there is none, molecules with fewer connections than most have.
std::vector<char> on_surface(const Body& body, const std::vector<std::array<int, 3>>& surface) {
  std::vector<char> outer(static_cast<std::size_t>(body.size()), 0);
  for (const auto& side : surface)
    for (const int molecule : side) outer[static_cast<std::size_t>(molecule)] = 1;
  if (!surface.empty()) return outer;
  std::vector<int> count(outer.size());
  for (const auto& ends : body.connections.ends)
    for (const int molecule : ends) ++count[static_cast<std::size_t>(molecule)];
  std::vector<int> sorted = count;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  for (std::size_t i = 0; i < outer.size(); ++i) outer[i] = count[i] < sorted[sorted.size() / 2];
  return outer;
}

Shown shown_of(const Body& body) {
  Shown shown;
  shown.surface = surface_of(body);
  const int proper = body.connections.proper() > 0 ? body.connections.proper() : body.connections.size();
  const bool all = static_cast<std::size_t>(proper) <= kMostConnections;
  const std::vector<char> outer =
      all ? std::vector<char>(static_cast<std::size_t>(body.size()), 1) : on_surface(body, shown.surface);
  std::vector<int> index(outer.size(), -1);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (outer[static_cast<std::size_t>(molecule)]) {
      index[static_cast<std::size_t>(molecule)] = static_cast<int>(shown.molecules.size());
      shown.molecules.push_back(molecule);
    }
  for (int c = 0; c < proper; ++c) {
    const auto& [a, b] = body.connections.ends[static_cast<std::size_t>(c)];
    if (outer[static_cast<std::size_t>(a)] && outer[static_cast<std::size_t>(b)]) shown.connections.push_back(c);
  }
  if (!all) shown.note = "the surface alone";
  if (const std::size_t every = shown.connections.size() / kMostConnections + 1; every > 1) {
    std::vector<int> some;
    for (std::size_t i = 0; i < shown.connections.size(); i += every) some.push_back(shown.connections[i]);
    shown.connections = std::move(some);
    shown.note += ", one connection of " + std::to_string(every);
  }
  for (auto& side : shown.surface)
    for (int& molecule : side) molecule = index[static_cast<std::size_t>(molecule)];
  std::erase_if(shown.surface, [](const auto& side) { return side[0] < 0 || side[1] < 0 || side[2] < 0; });
  return shown;
}

Json head_of(const char* kind, const Record& record) {
  return {{"kind", kind}, {"scene", record.scene}, {"variant", variant_text(record)}, {"molecules", record.molecules}};
}

std::string line_of(const Json& json) {
  std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = line.find('<', at)) != std::string::npos; at += 6) line.replace(at, 1, "\\u003c");
  return line;
}

/// Tensions as shares of the largest, in 16 bits.
void add_tensions(Json& frame, const Shown& shown, const Body& body, const Snapshot& snapshot) {
  double most = 0;
  std::vector<double> tensions;
  for (const int c : shown.connections) {
    const auto& [a, b] = body.connections.ends[static_cast<std::size_t>(c)];
    const double tension =
        snapshot.force_densities.size()
            ? snapshot.force_densities[c] * (snapshot.positions.col(b) - snapshot.positions.col(a)).norm()
            : 0;
    tensions.push_back(std::isfinite(tension) ? tension : 0);
    most = std::max(most, std::abs(tensions.back()));
  }
  std::vector<std::int16_t> shares;
  for (const double tension : tensions)
    shares.push_back(static_cast<std::int16_t>(most > 0 ? std::lround(32767 * tension / most) : 0));
  frame["most"] = most;
  frame["tensions"] = bytes_text(shares);
}

}  // namespace

std::string body_view(const Scene& scene, const Record& record) {
  const Body& body = scene.specimen.body;
  const Shown shown = shown_of(body);
  std::vector<float> rest, radius;
  for (const int molecule : shown.molecules) {
    for (int k = 0; k < 3; ++k) rest.push_back(static_cast<float>(body.rest(k, molecule)));
    radius.push_back(static_cast<float>(body.radius[molecule]));
  }
  std::vector<std::uint32_t> ends, surface;
  std::vector<int> index(static_cast<std::size_t>(body.size()), 0);
  for (std::size_t i = 0; i < shown.molecules.size(); ++i)
    index[static_cast<std::size_t>(shown.molecules[i])] = static_cast<int>(i);
  for (const int c : shown.connections)
    for (const int end : body.connections.ends[static_cast<std::size_t>(c)])
      ends.push_back(static_cast<std::uint32_t>(index[static_cast<std::size_t>(end)]));
  for (const auto& side : shown.surface)
    for (const int molecule : side) surface.push_back(static_cast<std::uint32_t>(molecule));
  Json json = head_of("body", record);
  json["membrane"] = !body.triangles.empty();
  json["shown"] = shown.note;
  json["rest"] = bytes_text(rest);
  json["radius"] = bytes_text(radius);
  json["ends"] = bytes_text(ends);
  json["surface"] = bytes_text(surface);
  return line_of(json);
}

std::string states_view(const Scene& scene, const Record& record) {
  const std::vector<Snapshot>& snapshots = record.run.snapshots;
  if (snapshots.empty()) return "";
  const Body& body = scene.specimen.body;
  const Shown shown = shown_of(body);
  Json json = head_of("states", record);
  json["strategy"] = record.run.strategy;
  json["in_time"] = record.run.time.has_value();
  json["frames"] = Json::array();
  const std::size_t count = std::min(kMostFrames, snapshots.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Snapshot& snapshot = snapshots[count > 1 ? i * (snapshots.size() - 1) / (count - 1) : snapshots.size() - 1];
    std::vector<float> displacements;
    for (const int molecule : shown.molecules)
      for (int k = 0; k < 3; ++k) {
        const auto displacement = static_cast<float>(snapshot.positions(k, molecule) - body.rest(k, molecule));
        displacements.push_back(std::isfinite(displacement) ? displacement : 0);
      }
    Json frame{{"at", snapshot.at}, {"displacements", bytes_text(displacements)}};
    add_tensions(frame, shown, body, snapshot);
    json["frames"].push_back(std::move(frame));
  }
  return line_of(json);
}

}  // namespace elastin::lab
