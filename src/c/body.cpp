#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#ifdef ELASTIN_C_LAB
#include "elastin/mesh/mesh_file.h"
#endif
#include "c/handles.h"
#include "elastin/core/model/surface.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"

namespace elastin::c {
namespace {

void require_positive(double value, const std::string& name) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(name + " is " + std::to_string(value) + "; it must be above 0");
}

/// Rows of a caller's array; throws before anybody makes room for more than Elastin can count.
template <class Number>
Number* rows_of(Number* array, std::size_t count, const char* name) {
  if (count > 0) given(array, name);
  if (count > static_cast<std::size_t>(std::numeric_limits<int>::max() / 8))
    throw InputError(std::string(name) + " has " + std::to_string(count) + " rows: too many");
  return array;
}

template <std::size_t corners>
std::vector<std::array<int, corners>> groups_of(const int* numbers, std::size_t count, const char* name) {
  std::vector<std::array<int, corners>> groups;
  if (!rows_of(numbers, count, name)) return groups;
  groups.resize(count);
  for (std::size_t group = 0; group < count; ++group)
    std::copy_n(numbers + corners * group, corners, groups[group].begin());
  return groups;
}

VectorX numbers_of(const double* numbers, std::size_t count) {
  return numbers ? VectorX(Eigen::Map<const VectorX>(numbers, static_cast<Eigen::Index>(count))) : VectorX();
}

Body body_of(const elastin_arrays& from) {
  BodyArrays arrays;
  const std::size_t molecules = from.molecule_count;
  rows_of(from.positions, molecules, "positions");
  arrays.positions = Eigen::Map<const Positions>(from.positions, 3, static_cast<Eigen::Index>(molecules));
  arrays.connections = groups_of<2>(from.connections, from.connection_count, "connections");
  arrays.triangles = groups_of<3>(from.triangles, from.triangle_count, "triangles");
  arrays.tetrahedra = groups_of<4>(from.tetrahedra, from.tetrahedron_count, "tetrahedra");
  arrays.masses = numbers_of(from.masses, molecules);
  arrays.radii = numbers_of(from.radii, molecules);
  rows_of(from.growth, from.growth_count, "growth");
  if (from.growth && from.growth_count == 0)
    throw InputError("growth is given and growth_count is 0; it must be the number of cells");
  for (std::size_t cell = 0; cell < from.growth_count; ++cell)
    arrays.growth.emplace_back(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from.growth + 9 * cell));
  if (!from.masses) require_positive(from.density, "density");
  if (!from.masses && !arrays.triangles.empty()) require_positive(from.thickness, "thickness");
  arrays.density = from.masses ? 1 : from.density;  // the masses replace those that follow from it
  arrays.thickness = from.masses ? 1 : from.thickness;
  if (from.rest_lengths) {  // without connections one for each edge of the cells, whose number the body knows
    const std::size_t connections = arrays.connections.empty()
                                        ? static_cast<std::size_t>(make_body(arrays).connections.proper())
                                        : from.connection_count;
    arrays.rest_lengths = numbers_of(from.rest_lengths, connections);
  }
  return make_body(arrays);
}

Body lattice_of(const int counts[3], const double spacing[3], int pattern, double density) {
  given(counts, "counts");
  given(spacing, "spacing");
  double molecules = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (counts[axis] < 1)
      throw InputError("counts[" + std::to_string(axis) + "] is " + std::to_string(counts[axis]) +
                       "; it must be at least 1");
    require_positive(spacing[axis], "spacing[" + std::to_string(axis) + "]");
    molecules *= counts[axis];
  }
  if (molecules > 5e7)
    throw InputError("counts make " + std::to_string(molecules) + " molecules; at most 5e7 are taken");
  if (pattern < 1 || pattern > (ELASTIN_AXIS | ELASTIN_FACE | ELASTIN_SPACE))
    throw InputError("pattern is " + std::to_string(pattern) +
                     "; it must be one or more of ELASTIN_AXIS, ELASTIN_FACE, ELASTIN_SPACE");
  const auto has = [&](int bit) { return (pattern & bit) != 0; };
  Body body =
      cubic_lattice({counts[0], counts[1], counts[2]}, 1, {has(ELASTIN_AXIS), has(ELASTIN_FACE), has(ELASTIN_SPACE)});
  stretch(body, {spacing[0], spacing[1], spacing[2]});
  require_positive(density, "density");
  set_matter(body, density, 0);
  return body;
}

#ifdef ELASTIN_C_LAB
Body mesh_body(const char* path, double length_unit, double density, double thickness) {
  require_positive(length_unit, "length_unit");
  require_positive(density, "density");
  mesh::Mesh mesh = mesh::load_mesh(&given(path, "path"));
  if (mesh.tetrahedra.empty()) require_positive(thickness, "thickness");
  BodyArrays arrays;
  arrays.positions = mesh.points * length_unit;
  arrays.triangles = std::move(mesh.triangles);
  arrays.tetrahedra = std::move(mesh.tetrahedra);
  arrays.density = density;
  arrays.thickness = thickness;
  return make_body(arrays);
}
#endif

template <class Make>
elastin_status hand_out(elastin_body** out, const Make& make) {
  return guarded([&] {
    given(out, "body");
    auto made = std::make_unique<elastin_body>(elastin_body{make()});
    *out = made.release();
  });
}

template <std::size_t corners>
void show_numbers(const std::vector<std::array<int, corners>>& groups, const int** numbers, std::size_t* count) {
  static_assert(sizeof(std::array<int, corners>) == corners * sizeof(int));
  given(numbers, "molecules") = groups.empty() ? nullptr : groups.front().data();
  if (count) *count = corners * groups.size();
}

}  // namespace
}  // namespace elastin::c

using elastin::c::given;
using elastin::c::guarded;

extern "C" {

elastin_status elastin_body_from_arrays(const elastin_arrays* arrays, elastin_body** body) {
  return elastin::c::hand_out(body,
                              [&] { return elastin::c::body_of(elastin::c::checked_copy(arrays, "elastin_arrays")); });
}

elastin_status elastin_lattice(const int counts[3], const double spacing[3], int pattern, double density,
                               elastin_body** body) {
  return elastin::c::hand_out(body, [&] { return elastin::c::lattice_of(counts, spacing, pattern, density); });
}

elastin_status elastin_body_from_mesh([[maybe_unused]] const char* path, [[maybe_unused]] double length_unit,
                                      [[maybe_unused]] double density, [[maybe_unused]] double thickness,
                                      [[maybe_unused]] elastin_body** body) {
#ifdef ELASTIN_C_LAB
  return elastin::c::hand_out(body, [&] { return elastin::c::mesh_body(path, length_unit, density, thickness); });
#else
  return elastin::c::failed(ELASTIN_MISSING, "this library was built without mesh files (ELASTIN_LAB)");
#endif
}

void elastin_body_free(elastin_body* body) { delete body; }

elastin_status elastin_body_counts(const elastin_body* body, elastin_counts* counts) {
  return guarded([&] {
    const elastin::Body& from = given(body, "body").body;
    const elastin_counts values{0, static_cast<std::size_t>(from.size()),
                                static_cast<std::size_t>(from.connections.size()), from.triangles.size(),
                                from.tetrahedra.size()};
    elastin::c::put(values, counts, "elastin_counts");
  });
}

elastin_status elastin_body_positions(const elastin_body* body, const double** positions, size_t* count) {
  return guarded([&] { elastin::c::show(given(body, "body").body.rest, positions, count); });
}

elastin_status elastin_body_masses(const elastin_body* body, const double** masses, size_t* count) {
  return guarded([&] { elastin::c::show(given(body, "body").body.mass, masses, count); });
}

elastin_status elastin_body_connections(const elastin_body* body, const int** molecules, size_t* count) {
  return guarded([&] { elastin::c::show_numbers(given(body, "body").body.connections.ends, molecules, count); });
}

elastin_status elastin_body_triangles(const elastin_body* body, const int** molecules, size_t* count) {
  return guarded([&] { elastin::c::show_numbers(given(body, "body").body.triangles, molecules, count); });
}

elastin_status elastin_body_surface(const elastin_body* body, const int** molecules, size_t* count) {
  return guarded([&] {
    const elastin_body& own = given(body, "body");
    own.surface = elastin::surface_of(own.body);
    elastin::c::show_numbers(own.surface, molecules, count);
  });
}
}
