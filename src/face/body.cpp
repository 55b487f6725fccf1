#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#ifdef ELASTIN_FACE_LAB
#include "elastin/model/mesh_file.h"
#endif
#include "elastin/model/parts.h"
#include "elastin/model/shapes.h"
#include "face/handles.h"

namespace elastin {
namespace {

using face::given;

std::string numbered(const char* what, std::size_t number) { return std::string(what) + " " + std::to_string(number); }

void require_positive(double value, const std::string& name) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(name + " is " + std::to_string(value) + "; it must be above 0");
}

/// Groups of molecules: connections, cells. Throws InputError on a number that is no molecule, or one that stands
/// twice.
template <std::size_t corners>
std::vector<std::array<int, corners>> groups_of(const int* numbers, std::size_t count, std::size_t molecules,
                                                const char* what) {
  std::vector<std::array<int, corners>> groups(count);
  if (count > 0) given(numbers, what);
  for (std::size_t group = 0; group < count; ++group) {
    auto& corner = groups[group];
    std::copy_n(numbers + corners * group, corners, corner.begin());
    for (std::size_t i = 0; i < corners; ++i) {
      if (corner[i] < 0 || static_cast<std::size_t>(corner[i]) >= molecules)
        throw InputError(numbered(what, group) + " names molecule " + std::to_string(corner[i]) + "; there are " +
                         std::to_string(molecules) + ", from 0");
      if (std::count(corner.begin(), corner.end(), corner[i]) > 1)
        throw InputError(numbered(what, group) + " names molecule " + std::to_string(corner[i]) + " twice");
    }
  }
  return groups;
}

Positions places_of(const elastin_arrays& arrays) {
  if (arrays.molecule_count == 0) throw InputError("molecule_count is 0: a body needs at least one molecule");
  if (arrays.molecule_count > std::numeric_limits<int>::max() / 4)
    throw InputError("molecule_count is " + std::to_string(arrays.molecule_count) + ": too many");
  const auto count = static_cast<Eigen::Index>(arrays.molecule_count);
  const Positions places = Eigen::Map<const Positions>(&given(arrays.positions, "positions"), 3, count);
  for (Eigen::Index molecule = 0; molecule < count; ++molecule)
    if (!places.col(molecule).allFinite())
      throw InputError(numbered("positions of molecule", static_cast<std::size_t>(molecule)) + " are not finite");
  return places;
}

VectorX each_positive(const double* values, Eigen::Index count, const char* name) {
  const VectorX all = Eigen::Map<const VectorX>(values, count);
  for (Eigen::Index molecule = 0; molecule < count; ++molecule)
    require_positive(all[molecule], numbered(name, static_cast<std::size_t>(molecule)));
  return all;
}

double shortest_connection(const Body& body) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const double length : body.connections.rest_length) shortest = std::min(shortest, length);
  return shortest;
}

/// Radius, and masses from a density: as a scene's body has them.
void set_default_matter(Body& body, double density, double thickness) {
  require_positive(density, "density");
  if (!body.triangles.empty()) require_positive(thickness, "thickness");
  if (body.connections.size() == 0) throw InputError("radii is null, and there is no connection of which to take half");
  const double radius = shortest_connection(body) / 2;
  const Vector3 size = body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff();
  set_matter(body, radius, density, thickness, size.prod() > 0 ? size.prod() : body.size() * std::pow(2 * radius, 3));
}

/// Connections have a length, cells a volume or an area.
void check_shape(const Body& body) {
  for (int connection = 0; connection < body.connections.size(); ++connection)
    require_positive(body.connections.rest_length[static_cast<std::size_t>(connection)],
                     "length of connection " + std::to_string(connection));
  if (const auto flat = flat_or_inverted_cells(body, body.rest); !flat.empty())
    throw InputError(flat_or_inverted_text(flat, body.tetrahedra.size()));
}

Body body_of(const elastin_arrays& arrays) {
  Body body;
  body.rest = places_of(arrays);
  const std::size_t molecules = arrays.molecule_count;
  body.triangles = groups_of<3>(arrays.triangles, arrays.triangle_count, molecules, "triangle");
  body.tetrahedra = groups_of<4>(arrays.tetrahedra, arrays.tetrahedron_count, molecules, "tetrahedron");
  for (auto& cell : body.tetrahedra)
    if (signed_volume(body.rest, cell) < 0) std::swap(cell[2], cell[3]);
  if (arrays.connections || arrays.connection_count > 0) {
    body.connections.ends = groups_of<2>(arrays.connections, arrays.connection_count, molecules, "connection");
    set_present_lengths(body);
    if (!body.tetrahedra.empty()) add_cell_sides(body, sides_of(body.tetrahedra));
  } else {
    body.connections = connections_of_cells(body.rest, body.triangles, body.tetrahedra);
  }
  if (arrays.triangle_count > 0 && arrays.connections)
    throw InputError("the edges of triangles are the connections: leave connections null");
  check_shape(body);
  if (!arrays.masses || !arrays.radii)
    set_default_matter(body, arrays.masses ? 1 : arrays.density, arrays.masses ? 1 : arrays.thickness);
  if (arrays.masses) body.mass = each_positive(arrays.masses, body.rest.cols(), "masses of molecule");
  if (arrays.radii) body.radius = each_positive(arrays.radii, body.rest.cols(), "radii of molecule");
  return body;
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
  const auto has = [&](int way) { return (pattern & way) != 0; };
  Body body =
      cubic_lattice({counts[0], counts[1], counts[2]}, 1, {has(ELASTIN_AXIS), has(ELASTIN_FACE), has(ELASTIN_SPACE)});
  stretch(body, {spacing[0], spacing[1], spacing[2]});
  set_default_matter(body, density, 0);
  return body;
}

#ifdef ELASTIN_FACE_LAB
Body mesh_body(const char* path, double length_unit, double density, double thickness) {
  require_positive(length_unit, "length_unit");
  Mesh mesh = load_mesh(&given(path, "path"));
  Body body;
  body.rest = mesh.points * length_unit;
  body.triangles = std::move(mesh.triangles);
  body.tetrahedra = std::move(mesh.tetrahedra);
  body.connections = connections_of_cells(body.rest, body.triangles, body.tetrahedra);
  set_default_matter(body, density, thickness);
  return body;
}
#endif

template <class Make>
elastin_status make_body(elastin_body** out, const Make& make) {
  return face::guarded([&] {
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
}  // namespace elastin

using elastin::face::given;
using elastin::face::guarded;

extern "C" {

elastin_status elastin_body_from_arrays(const elastin_arrays* arrays, elastin_body** body) {
  return elastin::make_body(body, [&] { return elastin::body_of(elastin::face::taken(arrays, "elastin_arrays")); });
}

elastin_status elastin_lattice(const int counts[3], const double spacing[3], int pattern, double density,
                               elastin_body** body) {
  return elastin::make_body(body, [&] { return elastin::lattice_of(counts, spacing, pattern, density); });
}

elastin_status elastin_body_from_mesh([[maybe_unused]] const char* path, [[maybe_unused]] double length_unit,
                                      [[maybe_unused]] double density, [[maybe_unused]] double thickness,
                                      [[maybe_unused]] elastin_body** body) {
#ifdef ELASTIN_FACE_LAB
  return elastin::make_body(body, [&] { return elastin::mesh_body(path, length_unit, density, thickness); });
#else
  return elastin::face::failed(ELASTIN_MISSING, "this library was built without mesh files (ELASTIN_LAB)");
#endif
}

void elastin_body_free(elastin_body* body) { delete body; }

elastin_status elastin_body_counts(const elastin_body* body, elastin_counts* counts) {
  return guarded([&] {
    const elastin::Body& from = given(body, "body").body;
    const elastin_counts values{0, static_cast<std::size_t>(from.size()),
                                static_cast<std::size_t>(from.connections.size()), from.triangles.size(),
                                from.tetrahedra.size()};
    elastin::face::put(values, counts, "elastin_counts");
  });
}

elastin_status elastin_body_positions(const elastin_body* body, const double** positions, size_t* count) {
  return guarded([&] { elastin::face::show(given(body, "body").body.rest, positions, count); });
}

elastin_status elastin_body_connections(const elastin_body* body, const int** molecules, size_t* count) {
  return guarded([&] { elastin::show_numbers(given(body, "body").body.connections.ends, molecules, count); });
}

elastin_status elastin_body_triangles(const elastin_body* body, const int** molecules, size_t* count) {
  return guarded([&] { elastin::show_numbers(given(body, "body").body.triangles, molecules, count); });
}
}
