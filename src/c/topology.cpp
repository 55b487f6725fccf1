#include "elastin/core/model/topology.h"
#include "c/handles.h"

namespace elastin::c {
namespace {

std::array<Vector3, 2> ends_of(const double numbers[6], const char* name) {
  given(numbers, name);
  return {position_of(numbers, name), position_of(numbers + 3, name)};
}

std::vector<int> numbers_of(const int* numbers, std::size_t count, const char* name) {
  if (count > 0) given(numbers, name);
  return {numbers, numbers + count};
}

/// Does it, and fills the caller's report.
template <class Change>
elastin_status changed(elastin_simulation* simulation, elastin_topology_report* out, const Change& change) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    if (out) checked_copy(out, "elastin_topology_report");
    const TopologyReport report = change(handle.simulation);
    if (!out) return;
    const elastin_topology_report values{0,
                                         report.changed,
                                         report.split_molecules,
                                         report.removed_connections,
                                         report.removed_cells,
                                         report.molecule_from.size(),
                                         report.connection_from.size()};
    put(values, out, "elastin_topology_report");
  });
}

}  // namespace
}  // namespace elastin::c

using elastin::CutSurface;
using elastin::Simulation;
using elastin::c::given;
using elastin::c::guarded;

extern "C" {

elastin_status elastin_cut_plane(elastin_simulation* simulation, const double point[3], const double normal[3],
                                 elastin_topology_report* report) {
  return elastin::c::changed(simulation, report, [&](Simulation& tissue) {
    return tissue.cut(
        CutSurface::plane(elastin::c::position_of(point, "point"), elastin::c::position_of(normal, "normal")));
  });
}

elastin_status elastin_cut_blade(elastin_simulation* simulation, const double from[6], const double to[6],
                                 elastin_topology_report* report) {
  return elastin::c::changed(simulation, report, [&](Simulation& tissue) {
    return tissue.cut(CutSurface::blade(elastin::c::ends_of(from, "from"), elastin::c::ends_of(to, "to")));
  });
}

elastin_status elastin_cut_triangles(elastin_simulation* simulation, const double* points, size_t point_count,
                                     const int* triangles, size_t triangle_count, elastin_topology_report* report) {
  return elastin::c::changed(simulation, report, [&](Simulation& tissue) {
    elastin::Positions corners(3, static_cast<Eigen::Index>(point_count));
    for (std::size_t point = 0; point < point_count; ++point)
      corners.col(static_cast<Eigen::Index>(point)) =
          elastin::c::position_of(&given(points, "points") + 3 * point, "points");
    elastin::Cells<3> cells(triangle_count);
    const std::vector<int> numbers = elastin::c::numbers_of(triangles, 3 * triangle_count, "triangles");
    for (std::size_t i = 0; i < numbers.size(); ++i) cells[i / 3][i % 3] = numbers[i];
    return tissue.cut(CutSurface::triangles(corners, cells));
  });
}

elastin_status elastin_tear(elastin_simulation* simulation, double strain, elastin_topology_report* report) {
  return elastin::c::changed(simulation, report, [&](Simulation& tissue) { return tissue.tear(strain); });
}

elastin_status elastin_remove(elastin_simulation* simulation, const int* connections, size_t connection_count,
                              const int* cells, size_t cell_count, elastin_topology_report* report) {
  return elastin::c::changed(simulation, report, [&](Simulation& tissue) {
    return tissue.remove(elastin::c::numbers_of(connections, connection_count, "connections"),
                         elastin::c::numbers_of(cells, cell_count, "cells"));
  });
}

elastin_status elastin_origin(const elastin_simulation* simulation, const int** molecules, size_t* count) {
  return guarded([&] {
    const std::vector<int>& origin = given(simulation, "simulation").simulation.origin();
    given(molecules, "molecules") = origin.data();
    if (count) *count = origin.size();
  });
}

elastin_status elastin_current_body(const elastin_simulation* simulation, elastin_body** body) {
  return guarded([&] {
    given(body, "body");
    *body = new elastin_body{given(simulation, "simulation").simulation.body()};
  });
}
}
