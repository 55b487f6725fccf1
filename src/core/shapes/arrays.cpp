#include "elastin/core/shapes/arrays.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "core/base/dense.h"
#include "core/geometry/hull_volume.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/material.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/model/share.h"
#include "elastin/core/shapes/shapes.h"

namespace elastin {
namespace {

std::string row(const char* array, std::size_t index) { return std::string(array) + "[" + std::to_string(index) + "]"; }

template <std::size_t corners>
void check_numbers(const char* array, const std::vector<std::array<int, corners>>& rows, int molecules) {
  for (std::size_t index = 0; index < rows.size(); ++index)
    for (std::size_t a = 0; a < corners; ++a) {
      const int molecule = rows[index][a];
      if (molecule < 0 || molecule >= molecules)
        throw InputError(row(array, index) + ": there is no molecule " + std::to_string(molecule) + "; allowed: 0 to " +
                         std::to_string(molecules - 1));
      for (std::size_t b = 0; b < a; ++b)
        if (rows[index][b] == molecule)
          throw InputError(row(array, index) + ": names molecule " + std::to_string(molecule) + " twice");
    }
}

/// Nothing given is fine.
void check_array(const char* array, const VectorX& values, std::size_t count, const char* each, const char* unit) {
  if (values.size() == 0) return;
  if (static_cast<std::size_t>(values.size()) != count)
    throw InputError(std::string(array) + ": has " + std::to_string(values.size()) +
                     " numbers; allowed: " + std::to_string(count) + ", one a " + each);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (!(values[i] > 0) || !std::isfinite(values[i]))
      throw InputError(row(array, i) + ": is " + number(values[i]) + "; allowed: finite numbers above 0 " + unit);
}

void check_positions(const Positions& positions) {
  if (positions.cols() == 0) throw InputError("positions: a body needs at least one molecule");
  for (Eigen::Index molecule = 0; molecule < positions.cols(); ++molecule)
    if (!positions.col(molecule).allFinite()) throw InputError(row("positions", molecule) + ": is not finite");
}

void set_blocks(const BodyArrays& arrays, Body& body) {
  if (!arrays.triangles.empty() || !arrays.tetrahedra.empty())
    throw InputError("cells: a body of these has all its cells among them; leave out triangles and tetrahedra");
  for (const CellBlock& block : arrays.blocks) {
    const std::string name(block.kind->name);
    for (int cell = 0; cell < block.size(); ++cell)
      for (const int molecule : block.cell(cell))
        if (molecule < 0 || molecule >= body.size())
          throw InputError("cells: " + row(name.c_str(), cell) + ": there is no molecule " + std::to_string(molecule) +
                           "; allowed: 0 to " + std::to_string(body.size() - 1));
  }
  body.blocks = arrays.blocks;
  set_simplices(body);
  const std::vector<int> flat = flat_or_inverted_cells(body, body.rest);
  if (!flat.empty()) throw InputError("cells: " + flat_or_inverted_text(flat, solid_cells(body)));
}

void set_cells(const BodyArrays& arrays, Body& body) {
  if (!arrays.blocks.empty()) return set_blocks(arrays, body);
  body.triangles = arrays.triangles;
  body.tetrahedra = arrays.tetrahedra;
  for (auto& cell : body.tetrahedra)
    if (signed_volume(body.rest, cell) < 0) std::swap(cell[2], cell[3]);
  const auto refuse_flat = [](const char* array, const std::vector<int>& flat) {
    if (!flat.empty()) throw InputError(row(array, flat.front()) + ": is flat");
  };
  refuse_flat("tetrahedra", flat_or_inverted_cells(body, body.rest));
  refuse_flat("triangles", flat_triangles(body, body.rest));
}

void set_connections(const BodyArrays& arrays, Body& body) {
  const Connections sides = connections_of_cells(body.rest, body.triangles, body.tetrahedra);
  if (arrays.connections.empty()) {
    body.connections = sides;
  } else {
    body.connections.ends = arrays.connections;
    set_present_lengths(body);
    add_cell_sides(body, sides.ends);
  }
  auto& lengths = body.connections.rest_length;
  const auto proper = static_cast<std::size_t>(body.connections.proper());
  check_array("rest_lengths", arrays.rest_lengths, proper, "connection", "m");
  std::copy(arrays.rest_lengths.begin(), arrays.rest_lengths.end(), lengths.begin());
  const auto none = std::find_if(lengths.begin(), lengths.end(), [](double length) { return !(length > 0); });
  if (none != lengths.end())
    throw InputError(row("connections", none - lengths.begin()) + ": has no length: its molecules lie at one position");
}

void set_growth(const BodyArrays& arrays, Body& body) {
  if (arrays.growth.empty()) return;
  std::vector<RestPoint> points;
  const auto add = [&](const auto& members) {
    Vector3 middle = Vector3::Zero();
    for (const int molecule : members) middle += body.rest.col(molecule) / static_cast<double>(members.size());
    if (points.size() < arrays.growth.size()) points.push_back({middle, middle, arrays.growth[points.size()]});
    return 1;
  };
  std::size_t cells = 0;
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) cells += add(block.cell(cell));
  if (body.blocks.empty())
    for (const auto& cell : body.tetrahedra) cells += add(cell);
  if (cells == 0)
    for (const auto& cell : body.triangles) cells += add(cell);
  if (cells != arrays.growth.size())
    throw InputError("growth: has " + std::to_string(arrays.growth.size()) +
                     " matrices; allowed: " + std::to_string(cells) + ", one a cell");
  Rest rest = rest_at(std::move(points));
  rest.part = [](double) { return 1; };
  body.unstressed = std::make_shared<const Rest>(std::move(rest));
}

}  // namespace

Body make_body(const BodyArrays& arrays) {
  check_positions(arrays.positions);
  const auto molecules = static_cast<int>(arrays.positions.cols());
  check_numbers("connections", arrays.connections, molecules);
  check_numbers("triangles", arrays.triangles, molecules);
  check_numbers("tetrahedra", arrays.tetrahedra, molecules);
  check_array("masses", arrays.masses, molecules, "molecule", "kg");
  check_array("radii", arrays.radii, molecules, "molecule", "m");
  Body body;
  body.rest = arrays.positions;
  set_cells(arrays, body);
  set_connections(arrays, body);
  if (arrays.radii.size() == 0 && shortest_connection(body) == 0)
    throw InputError("radii: are needed, because there is no connection of which to take half the length");
  if (arrays.masses.size() == 0 || arrays.radii.size() == 0)
    set_matter(body, arrays.density.value_or(Material{}.density), arrays.thickness,
               arrays.radii.size() ? std::optional(arrays.radii.mean()) : std::nullopt);
  if (arrays.masses.size())
    body.mass = arrays.masses;
  else if (!arrays.density)
    body.assumed_density = Material{}.density;
  if (arrays.radii.size()) body.radius = arrays.radii;
  check_array("masses", body.mass, molecules, "molecule",
              "kg (from density, thickness and the cells that the molecule belongs to)");
  set_growth(arrays, body);
  return body;
}

double shortest_connection(const Body& body) {
  double shortest = 0;
  for (int c = 0; c < body.connections.proper(); ++c) {
    const double length = body.connections.rest_length[c];
    if (length > 0 && (shortest == 0 || length < shortest)) shortest = length;
  }
  return shortest;
}

namespace {

/// Along the principal axis in which the molecules' places spread least [m].
double thinnest_extent(const Positions& places) {
  const Positions arms = places.colwise() - places.rowwise().mean();
  const VectorX heights = arms.transpose() * symmetric_eigen3(arms * arms.transpose()).vectors.col(0);
  return heights.maxCoeff() - heights.minCoeff();
}

}  // namespace

void set_matter(Body& body, double density, double thickness, std::optional<double> radius) {
  body.assumed_density = 0;
  double shortest = shortest_connection(body);
  if (body.share) {  // 0 where it has none
    constexpr double none = std::numeric_limits<double>::infinity();
    shortest = least_over(body, shortest > 0 ? shortest : none);
    if (shortest == none) shortest = 0;
  }
  if (!radius && shortest == 0)
    throw InputError("give a radius: there is no connection of which to take half the length");
  const double r = radius.value_or(shortest / 2);
  const auto [low, high] = outline_of_whole(body);
  double volume = (high - low).prod();
  const bool bare = body.triangles.empty() && body.tetrahedra.empty() && body.blocks.empty();
  if (bare && !body.share) {  // shares are made of lattices along the axes alone, which fill their outline
    const double hull = hull_volume(body.rest);
    if (!(std::abs(hull - volume) <= 1e-9 * volume)) volume = hull;
    if (thinnest_extent(body.rest) < r) volume = 0;  // a rope or a net, whose hull says nothing of it
  }
  if (!(volume > 0)) volume = static_cast<double>(molecules_of_whole(body)) * std::pow(2 * r, 3);
  set_matter(body, r, density, thickness, volume);
}

}  // namespace elastin
