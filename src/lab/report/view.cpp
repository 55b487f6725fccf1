#include "lab/report/page.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "contact/search.h"
#include "elastin/core/geometry/cell_kind.h"
#include "lab/format/vtu.h"
#include "lab/report/comparison.h"
#include "lab/run/body_image.h"
#include "lab/run/cell_stress.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the page reads little-endian arrays");

constexpr std::size_t kMostConnections = 60'000, kMostFrames = 25;
/// Of the largest number of a frame: displacements are written in steps of 2⁻²⁰ of it, as strains follow from their
/// differences; what is only coloured and read, in steps of 2⁻¹².
constexpr double kFine = 1 << 20, kCoarse = 1 << 12;

template <class Value>
std::string bytes_text(const std::vector<Value>& values) {
  return base64(values.data(), values.size() * sizeof(Value));
}

/// Numbers as whole shares of the largest: "most", and "planes", all first bytes of 32-bit integers, then all second
/// ones …, which pack better than the numbers one after another.
Json planes_of(const std::vector<double>& values, double steps) {
  double most = 0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  std::vector<std::uint8_t> planes(4 * values.size(), 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double share = most > 0 && std::isfinite(values[i]) ? values[i] / most : 0;
    const long whole = std::lround(share * steps);
    const auto bits = static_cast<std::uint32_t>(2 * std::abs(whole) - (whole < 0 ? 1 : 0));  // the sign lies lowest
    for (std::size_t plane = 0; plane < 4; ++plane)
      planes[plane * values.size() + i] = static_cast<std::uint8_t>(bits >> (8 * plane));
  }
  while (planes.size() > values.size() && std::all_of(planes.end() - static_cast<std::ptrdiff_t>(values.size()),
                                                      planes.end(), [](std::uint8_t byte) { return byte == 0; }))
    planes.resize(planes.size() - values.size());
  return {{"most", most}, {"steps", steps}, {"planes", bytes_text(planes)}};
}

std::array<int, 3> sorted(std::array<int, 3> side) {
  std::sort(side.begin(), side.end());
  return side;
}

/// The cell behind each side of the surface, counted as cell_states does. −1 without one.
std::vector<int> cells_behind(const Body& body, const std::vector<std::array<int, 3>>& surface) {
  std::map<std::array<int, 3>, int> behind;
  std::vector<char> outer(static_cast<std::size_t>(body.size()), 0);
  for (const auto& side : surface) {
    behind[sorted(side)] = -1;
    for (const int molecule : side) outer[molecule] = 1;
  }
  const auto is_outer = [&](int molecule) { return outer[molecule] != 0; };
  const auto note = [&](int a, int b, int c, int cell) {
    if (!is_outer(a) || !is_outer(b) || !is_outer(c)) return;
    if (const auto at = behind.find(sorted({a, b, c})); at != behind.end()) at->second = cell;
  };
  const auto note_all = [&](const std::array<int, 4>& t, int cell) {
    note(t[0], t[1], t[2], cell);
    note(t[0], t[1], t[3], cell);
    note(t[0], t[2], t[3], cell);
    note(t[1], t[2], t[3], cell);
  };
  int cell = 0;
  const OwnSimplices simplices(body);
  for (std::size_t i = 0; i < simplices.triangles; ++i)
    note(body.triangles[i][0], body.triangles[i][1], body.triangles[i][2], cell++);
  for (std::size_t i = 0; i < simplices.tetrahedra; ++i) note_all(body.tetrahedra[i], cell++);
  std::size_t triangle = 0, tetrahedron = 0;
  for (const CellBlock& block : body.blocks)
    for (int own = 0; own < block.size(); ++own, ++cell)
      for (std::size_t i = simplices_of(*block.kind, block.cell(own)).size(); i > 0; --i)
        if (block.kind->dimensions == 3) {
          note_all(body.tetrahedra[tetrahedron++], cell);
        } else {
          const auto& [a, b, c] = body.triangles[triangle++];
          note(a, b, c, cell);
        }
  std::vector<int> cells;
  for (const auto& side : surface) cells.push_back(behind[sorted(side)]);
  return cells;
}

/// What of a body is shown: by number.
struct Shown {
  std::vector<int> molecules, connections;
  std::vector<std::array<int, 3>> surface;
  std::vector<int> cells;  ///< behind each side of the surface
  std::string note;
};

/// On the surface: its corners, or without one, molecules with fewer connections than most have.
std::vector<char> on_surface(const Body& body, const std::vector<std::array<int, 3>>& surface) {
  std::vector<char> outer(static_cast<std::size_t>(body.size()), 0);
  for (const auto& side : surface)
    for (const int molecule : side) outer[molecule] = 1;
  if (!surface.empty()) return outer;
  std::vector<int> count(outer.size());
  for (const auto& ends : body.connections.ends)
    for (const int molecule : ends) ++count[molecule];
  std::vector<int> sorted = count;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  for (std::size_t i = 0; i < outer.size(); ++i) outer[i] = count[i] < sorted[sorted.size() / 2];
  return outer;
}

Shown shown_of(const Body& body) {
  Shown shown;
  shown.surface = contact::surface_triangles(body);
  const int proper = body.connections.proper() > 0 ? body.connections.proper() : body.connections.size();
  const bool all = static_cast<std::size_t>(proper) <= kMostConnections;
  const std::vector<char> outer =
      all ? std::vector<char>(static_cast<std::size_t>(body.size()), 1) : on_surface(body, shown.surface);
  std::vector<int> index(outer.size(), -1);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (outer[molecule]) {
      index[molecule] = static_cast<int>(shown.molecules.size());
      shown.molecules.push_back(molecule);
    }
  for (int c = 0; c < proper; ++c) {
    const auto& [a, b] = body.connections.ends[c];
    if (outer[a] && outer[b]) shown.connections.push_back(c);
  }
  if (!all) shown.note = "the surface alone";
  if (const std::size_t every = shown.connections.size() / kMostConnections + 1; every > 1) {
    std::vector<int> some;
    for (std::size_t i = 0; i < shown.connections.size(); i += every) some.push_back(shown.connections[i]);
    shown.connections = std::move(some);
    shown.note += ", one connection of " + std::to_string(every);
  }
  shown.cells = cells_behind(body, shown.surface);
  for (auto& side : shown.surface)
    for (int& molecule : side) molecule = index[molecule];
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

std::vector<double> tensions_of(const Shown& shown, const Body& body, const Snapshot& snapshot) {
  std::vector<double> tensions;
  for (const int c : shown.connections) {
    const auto& [a, b] = body.connections.ends[c];
    tensions.push_back(snapshot.force_densities.size()
                           ? snapshot.force_densities[c] *
                                 (snapshot.positions.col(b) - snapshot.positions.col(a)).norm()
                           : 0);
  }
  return tensions;
}

/// Equivalent stress of the cell behind each side of the surface.
std::vector<double> stresses_of(const Shown& shown, const Body& body, const Snapshot& snapshot) {
  const std::vector<CellState> states = cell_states(body, snapshot);
  std::vector<double> stresses;
  for (const int cell : shown.cells)
    stresses.push_back(cell >= 0 && static_cast<std::size_t>(cell) < states.size() ? von_mises(states[cell]) : 0);
  return stresses;
}

/// What supports, loads and contact do to each molecule: as much as all elastic forces on it, against them [N].
std::vector<double> outer_forces_of(const Shown& shown, const Body& body, const Snapshot& snapshot) {
  Positions elastic = Positions::Zero(3, body.size());
  if (snapshot.elastic_forces.size())
    elastic = snapshot.elastic_forces;
  else
    for (int c = 0; c < body.connections.size() && c < snapshot.force_densities.size(); ++c) {
      const auto& [a, b] = body.connections.ends[c];
      const Vector3 force = snapshot.force_densities[c] * (snapshot.positions.col(b) - snapshot.positions.col(a));
      elastic.col(a) += force;
      elastic.col(b) -= force;
    }
  std::vector<double> forces;
  for (const int molecule : shown.molecules) forces.push_back(elastic.col(molecule).norm());
  return forces;
}

/// Of each obstacle the twelve numbers that take its own frame to space: the axes, one after the other, and the place.
Json poses_of(const std::vector<contact::Obstacle>& obstacles, const Snapshot& snapshot) {
  const Vector3 middle = (snapshot.positions.rowwise().minCoeff() + snapshot.positions.rowwise().maxCoeff()) / 2;
  Json poses = Json::array();
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const contact::Pose pose = drawn_pose(obstacles[i], snapshot.obstacles[i], middle);
    Eigen::Matrix<float, 3, 4> numbers;
    numbers << pose.turn.cast<float>(), pose.position.cast<float>();
    poses.push_back(std::vector<float>(numbers.data(), numbers.data() + 12));
  }
  return poses;
}

Json outlines_of(const std::vector<contact::Obstacle>& obstacles, const Body& body) {
  const double wide =
      (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm() / 2 + body.radius.maxCoeff();
  Json outlines = Json::array();
  for (const contact::Obstacle& obstacle : obstacles) {
    std::vector<float> numbers;
    for (const auto& line : outline_of(obstacle.shape, wide))
      for (const Vector3& end : line) numbers.insert(numbers.end(), {float(end.x()), float(end.y()), float(end.z())});
    outlines.push_back({{"name", obstacle.name}, {"lines", bytes_text(numbers)}});
  }
  return outlines;
}

/// What is less is rounding: of stresses, or of membranes' tensions, and of forces.
struct Noise {
  double stress, force;
};
Noise noise_of(const Specimen& specimen) {
  constexpr double rounding = 1e-12;  // of strains
  const Material& material = specimen.material;
  const double wide = 2 * specimen.body.radius.mean(), thick = specimen.body.triangles.empty() ? 1 : material.thickness;
  return {rounding * material.youngs_modulus * thick, rounding * material.youngs_modulus * wide * wide};
}

Json frame_of(const Shown& shown, const Body& body, const Snapshot& snapshot, const Noise& noise) {
  std::vector<double> displacements, pressures;
  for (const int molecule : shown.molecules) {
    for (int k = 0; k < 3; ++k) displacements.push_back(snapshot.positions(k, molecule) - body.rest(k, molecule));
    if (snapshot.contact_pressure.size()) pressures.push_back(snapshot.contact_pressure[molecule]);
  }
  const auto clear_of = [](std::vector<double> values, double least) {
    for (double& value : values)
      if (std::abs(value) <= least) value = 0;
    return values;
  };
  Json frame{{"at", snapshot.at},
             {"displacements", planes_of(displacements, kFine)},
             {"tensions", planes_of(clear_of(tensions_of(shown, body, snapshot), noise.force), kCoarse)},
             {"forces", planes_of(clear_of(outer_forces_of(shown, body, snapshot), noise.force), kCoarse)}};
  const std::vector<double> stresses = clear_of(stresses_of(shown, body, snapshot), noise.stress);
  if (std::any_of(stresses.begin(), stresses.end(), [](double stress) { return stress > 0; }))
    frame["stresses"] = planes_of(stresses, kCoarse);
  if (!pressures.empty()) frame["pressures"] = planes_of(pressures, kCoarse);
  return frame;
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
  for (std::size_t i = 0; i < shown.molecules.size(); ++i) index[shown.molecules[i]] = static_cast<int>(i);
  for (const int c : shown.connections)
    for (const int end : body.connections.ends[c]) ends.push_back(static_cast<std::uint32_t>(index[end]));
  for (const auto& side : shown.surface)
    for (const int molecule : side) surface.push_back(static_cast<std::uint32_t>(molecule));
  Json json = head_of("body", record);
  json["membrane"] = !body.triangles.empty();
  json["shown"] = shown.note;
  json["rest"] = bytes_text(rest);
  json["radius"] = bytes_text(radius);
  json["ends"] = bytes_text(ends);
  json["surface"] = bytes_text(surface);
  json["cells"] = bytes_text(shown.cells);
  json["numbers"] = shown.note.empty() ? "" : bytes_text(shown.molecules);
  if (const BodyImage* image = scene.specimen.image.get()) {
    Matrix3 to_voxel = (image->length_unit * image->steps).inverse();
    Vector3 first = -to_voxel * (image->length_unit * image->origin);
    for (int axis = 0; axis < 3; ++axis) {  // one voxel that is shown stands for several
      const int step = (image->size[axis] + image->shown[axis] - 1) / image->shown[axis];
      to_voxel.row(axis) /= step, first[axis] /= step;
    }
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows;
    rows << to_voxel * scene.rotation.transpose(), first;
    json["image"] = {{"size", image->shown},
                     {"to_voxel", std::vector<double>(rows.data(), rows.data() + 12)},
                     {"values", bytes_text(image->shades)}};
  }
  if (!record.run.obstacles.empty())
    json["obstacles"] = outlines_of(record.run.obstacles, body);
  else if (scene.specimen.contact)  // of a run that ended before it had a state
    json["obstacles"] = outlines_of(scene.specimen.contact->obstacles, body);
  return line_of(json);
}

std::string states_view(const Scene& scene, const Record& record) {
  const Body& body = scene.specimen.body;
  std::vector<Snapshot> at_rest;  // of a run that ended before it had a state
  if (record.run.suited && record.run.shown().empty()) at_rest.push_back({0, body.rest, {}});
  const std::vector<Snapshot>& snapshots = at_rest.empty() ? record.run.shown() : at_rest;
  if (snapshots.empty()) return "";
  const Shown shown = shown_of(body);
  Json json = head_of("states", record);
  json["strategy"] = record.run.strategy;
  json["in_time"] = record.run.time.has_value();
  json["frames"] = Json::array();
  const Noise noise = noise_of(scene.specimen);
  const std::size_t count = std::min(kMostFrames, snapshots.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Snapshot& snapshot = snapshots[count > 1 ? i * (snapshots.size() - 1) / (count - 1) : snapshots.size() - 1];
    json["frames"].push_back(frame_of(shown, body, snapshot, noise));
    if (std::isfinite(snapshot.frequency)) json["frames"].back()["frequency"] = snapshot.frequency;
    if (!snapshot.obstacles.empty()) json["frames"].back()["poses"] = poses_of(record.run.obstacles, snapshot);
  }
  return line_of(json);
}

}  // namespace elastin::lab
