#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "elastin/core/base/text.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/orders.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/shapes/surfaces.h"
#include "elastin/hull/delaunay.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/scene/parts.h"
#include "lab/scene/pick.h"

namespace elastin::lab {
namespace {

/// Three counts along the axes, of cells with `per_cell` molecules each.
std::array<int, 3> read_counts(const Reader& reader, double per_cell) {
  const std::vector<Reader> items = reader.items(3);
  const std::array counts{items[0].whole(1), items[1].whole(1), items[2].whole(1)};
  reader.check_size(per_cell * counts[0] * counts[1] * counts[2]);
  return counts;
}

CubicPattern read_pattern(const Reader& reader) {
  CubicPattern pattern{false, false, false};
  for (const Reader& item : reader.items())
    *item.choice<bool*>({{"axis", &pattern.axis}, {"face", &pattern.face}, {"space", &pattern.space}}) = true;
  return pattern;
}

/// connections: {within: 12 mm} on any body.
std::optional<double> read_reach(std::optional<Reader> connections) {
  if (!connections || !connections->is_map()) return std::nullopt;
  const double reach = connections->at("within").quantity(dimension::length, kPositive);
  connections->finish();
  return reach;
}

/// The order that a body's cells are to have: chosen once all its molecules are where they belong.
using Order = std::optional<Reader>;

Body read_lattice(Reader reader, Order& order, const std::shared_ptr<const Processes>& processes) {
  enum class Kind { cubic, body_centred, face_centred };
  const Kind kind = reader.at("kind").choice<Kind>(
      {{"cubic", Kind::cubic}, {"body_centred", Kind::body_centred}, {"face_centred", Kind::face_centred}});
  order = reader.find("order");
  const Reader spacings = reader.at("spacing");  // one for all directions, or [x, y, z]
  const bool equal = spacings.is_text();
  const double spacing = equal ? spacings.quantity(dimension::length, kPositive) : 1;
  const auto connections = reader.find("connections");
  if (order && connections) connections->fail("the sides of its cells are the connections; leave `connections` out");
  const std::optional<double> reach = read_reach(connections);
  Body body;
  if (kind == Kind::cubic) {
    const auto molecules = read_counts(reader.at("molecules"), 1);
    const CubicPattern pattern = connections && !reach ? read_pattern(*connections) : CubicPattern{};
    body = processes ? cubic_lattice_share(molecules, spacing, pattern, processes)
                     : cubic_lattice(molecules, spacing, pattern);
  } else {
    const auto cells = read_counts(reader.at("cells"), kind == Kind::body_centred ? 2 : 4);
    const bool second = connections && !reach && connections->choice<bool>({{"nearest", false}, {"second", true}});
    body = kind == Kind::body_centred ? body_centred_lattice(cells, spacing, second)
                                      : face_centred_lattice(cells, spacing, second);
  }
  if (!equal) stretch(body, spacings.vector(dimension::length, kPositive));
  if (reach) body.connections = connections_within(body.rest, *reach);
  reader.finish();
  return body;
}

Body read_packing(Reader reader) {
  const Vector3 size = reader.at("size").vector(dimension::length, kPositive);
  const double distance = reader.at("distance").quantity(dimension::length, kPositive);
  const double molecules = (size.array() / distance + 1).prod();
  if (!(molecules < 5e6))
    reader.fail("a box of this size has too many molecules at this distance: at most 5e6 are allowed");
  reader.check_size(molecules);
  const int seed = reader.has("seed") ? reader.at("seed").whole(0) : 1;
  const auto reach = read_reach(reader.find("connections"));
  reader.finish();
  return random_packing(size, distance, reach.value_or(1.5 * distance), static_cast<std::uint64_t>(seed));
}

Body read_tetrahedra(Reader reader, Order& order) {
  const BlockKind kind = reader.at("kind").choice<BlockKind>(
      {{"kuhn", BlockKind::kuhn}, {"alternating", BlockKind::alternating}, {"body_centred", BlockKind::body_centred}});
  order = reader.find("order");
  const auto cubes = read_counts(reader.at("cubes"), 2);
  const Vector3 size = reader.at("size").vector(dimension::length, kPositive);
  reader.finish();
  return tetrahedral_block(kind, cubes, size);
}

/// A few may be a fault of the mesh; all of them are another program's convention.
void warn_of_reoriented(const mesh::Mesh& mesh, const std::string& path, std::vector<std::string>& warnings) {
  if (mesh.reoriented == 0) return;
  std::size_t cells = mesh.blocks.empty() ? mesh.tetrahedra.size() : 0;
  for (const CellBlock& block : mesh.blocks) cells += static_cast<std::size_t>(block.size());
  warnings.push_back(path + ": " + std::to_string(mesh.reoriented) + " of " + counted(cells, "cell") +
                     " had their corners in the mirrored order, and were reoriented");
}

Body read_mesh(Reader reader, Order& order, Remarks remarks) {
  mesh::Mesh mesh = read_mesh_file(reader);
  warn_of_reoriented(mesh, reader.path(), remarks.warnings);
  order = reader.find("order");
  if (remarks.sets) *remarks.sets = mesh.sets;
  reader.set_mesh_sets(std::move(mesh.sets));
  reader.finish();
  Body body;
  body.rest = std::move(mesh.points);
  body.triangles = std::move(mesh.triangles);
  body.tetrahedra = std::move(mesh.tetrahedra);
  body.blocks = std::move(mesh.blocks);
  body.connections = connections_of_cells(body.rest, body.triangles, body.tetrahedra);
  return body;
}

/// triangles: [[0, 1, 2], …] of a body given by its molecules.
Cells<3> read_triangles(const Reader& reader, int count) {
  Cells<3> triangles;
  for (const Reader& item : reader.items()) {
    const auto corners = item.items(3);
    triangles.push_back({corners[0].molecule(count), corners[1].molecule(count), corners[2].molecule(count)});
    const auto& [a, b, c] = triangles.back();
    if (a == b || b == c || c == a) item.fail("a triangle needs three different molecules");
  }
  return triangles;
}

Body read_list(const Reader& molecules, std::optional<Reader> connections, std::optional<Reader> triangles) {
  std::vector<Vector3> positions;
  for (const Reader& item : molecules.items()) positions.push_back(item.vector(dimension::length));
  if (positions.empty()) molecules.fail("a body needs at least one molecule");
  std::vector<std::array<int, 2>> pairs;
  const auto reach = read_reach(connections);
  const int count = static_cast<int>(positions.size());
  if (connections && !reach)
    for (const Reader& item : connections->items()) {
      const auto ends = item.items(2);
      pairs.push_back({ends[0].molecule(count), ends[1].molecule(count)});
      if (pairs.back()[0] == pairs.back()[1]) item.fail("a connection needs two different molecules");
    }
  Body body = listed_body(positions, pairs);
  if (reach) body.connections = connections_within(body.rest, *reach);
  if (!triangles) return body;
  if (connections) triangles->fail("the sides of the triangles are the connections; leave `connections` out");
  body.triangles = read_triangles(*triangles, count);
  body.connections = connections_of_cells(body.rest, body.triangles, {});
  return body;
}

const std::vector<std::string> kShapes{"lattice", "packing", "tetrahedra", "sphere", "sphere_octant", "disc",
                                       "sheet",   "canopy",  "mesh",       "fill",   "molecules"};

/// `volumes` of the molecules [m³] are set where the shape knows them, and left alone where it does not.
Body read_shape(Reader& reader, VectorX& volumes, Order& order, Remarks remarks,
                const std::shared_ptr<const Processes>& processes) {
  for (const char* key : {"given", "given_shape"})
    if (const auto given = reader.given_body(key)) {
      order = reader.find("order");
      return *given;
    }
  std::optional<Reader> shape;
  std::string name;
  for (const std::string& key : kShapes)
    if (auto found = reader.find(key)) {
      if (shape) found->fail("the body has a shape already: " + shape->path());
      shape = found;
      name = key;
    }
  if (!shape) {
    for (const char* key : {"radius", "jitter", "grade", "cells", "connections", "triangles", "regions", "lines"})
      reader.has(key);
    reader.finish();
    std::string known;
    for (const std::string& key : kShapes) known += (known.empty() ? "" : key == kShapes.back() ? " or " : ", ") + key;
    reader.fail("needs a shape: " + known);
  }
  if (name == "lattice") return read_lattice(*shape, order, processes);
  if (name == "packing") return read_packing(*shape);
  if (name == "tetrahedra") return read_tetrahedra(*shape, order);
  if (name == "mesh") return read_mesh(*shape, order, remarks);
  if (name == "fill") {
    for (const char* key : {"jitter", "grade", "cells", "connections"})
      if (auto other = reader.find(key))
        other->fail(key == std::string("cells") || key == std::string("connections")
                        ? "of a filled body this key stands inside `fill`"
                        : "a filled body cannot have this: it would leave its surface");
    order = shape->find("order");
    return read_fill(*shape, volumes, remarks);
  }
  if (name != "molecules") return read_surface(name, *shape);
  return read_list(*shape, reader.find("connections"), reader.find("triangles"));
}

void read_grade(Reader reader, Body& body) {
  const int axis = reader.at("axis").choice<int>({{"x", 0}, {"y", 1}, {"z", 2}});
  const double ratio = reader.at("ratio").quantity(dimension::none, {0.01, 100});
  const auto ends = reader.find("ends");
  const bool both = ends && ends->choice<bool>({{"one", false}, {"both", true}});
  reader.finish();
  if (!both) return grade(body, axis, ratio);
  // The half beyond the middle is the mirror image of the other, which is graded as a body of its own would be.
  const double low = body.rest.row(axis).minCoeff(), length = body.rest.row(axis).maxCoeff() - low;
  const double growth = std::log(ratio);
  if (!(length > 0) || growth == 0) return;
  for (double& position : body.rest.row(axis)) {
    const double at = 2 * (position - low) / length - 1, depth = 1 - std::abs(at);
    const double graded = std::expm1(growth * depth) / std::expm1(growth);
    position = low + length * (1 + std::copysign(1 - graded, at)) / 2;
  }
  set_present_lengths(body);
}

/// cells: delaunay. The sides that are no connections of the body's own become sides of cells only; all of them its
/// connections where it has none.
void read_cells(const Reader& reader, Body& body, std::vector<std::string>& warnings) {
  reader.choice<int>({{"delaunay", 0}});
  if (!body.tetrahedra.empty() || !body.triangles.empty()) reader.fail("the body has cells already");
  body.tetrahedra = reader.located([&] { return hull::delaunay_tetrahedra(body.rest); });
  if (body.connections.size() == 0)
    body.connections = connections_of_cells(body.rest, {}, body.tetrahedra);
  else
    add_cell_sides(body, sides_of(body.tetrahedra));
  const auto flat = hull::count_slivers(body.rest, body.tetrahedra);
  if (flat > 0)
    warnings.push_back(reader.path() + ": " + std::to_string(flat) + " of " + std::to_string(body.tetrahedra.size()) +
                       " tetrahedra are nearly flat (below 1e-4 of the cube of their longest side)");
}

/// Cells of first order are what bodies of tetrahedra and triangles have anyway.
void choose_order(const Reader& reader, Body& body, VectorX& volumes) {
  const int order = reader.choice<int>({{"1", 1}, {"2", 2}});
  if (order == 1 && body.blocks.empty() && body.cubes.empty()) return;
  body = reader.located([&] { return with_order(body, order); });
  volumes.resize(0);
}

/// A molecule between others is of a set where all of those are: a set's cells are then those that they were.
void add_between(const Body& body, MoleculeSets& sets) {
  const std::size_t first = static_cast<std::size_t>(body.size()) - body.between.size();
  for (auto& [name, members] : sets) {
    std::vector<char> is_member(static_cast<std::size_t>(body.size()), 0);
    for (const int member : members) is_member[member] = 1;
    for (std::size_t i = 0; i < body.between.size(); ++i) {
      const bool all = std::all_of(body.between[i].begin(), body.between[i].end(),
                                   [&](const auto& of) { return is_member[of.first] != 0; });
      if (!all || is_member[first + i]) continue;
      is_member[first + i] = 1;
      members.push_back(static_cast<int>(first + i));
    }
  }
}

/// Gives what lies between picked molecules alone other stiffness, and these other mass. Returns how many connections
/// and cells that are.
std::size_t set_picked_region(Body& body, const std::vector<int>& molecules, double stiffness, double mass) {
  const auto picked = [&](int molecule) { return std::binary_search(molecules.begin(), molecules.end(), molecule); };
  std::size_t found = 0;
  const auto set = [&](std::ptrdiff_t count, const auto& molecules_of_member, VectorX& factors) {
    if (factors.size() == 0) factors = VectorX::Ones(count);
    for (std::ptrdiff_t member = 0; member < count; ++member) {
      const auto& corners = molecules_of_member(member);
      if (!std::all_of(corners.begin(), corners.end(), picked)) continue;
      factors[member] = stiffness;
      ++found;
    }
  };
  const auto set_cells = [&](const auto& cells, VectorX& factors) {
    set(
        static_cast<std::ptrdiff_t>(cells.size()), [&](std::ptrdiff_t cell) -> const auto& { return cells[cell]; },
        factors);
  };
  set_cells(body.connections.ends, body.connection_stiffness);
  body.tetrahedra.empty() ? set_cells(body.triangles, body.cell_stiffness)
                          : set_cells(body.tetrahedra, body.cell_stiffness);
  for (CellBlock& block : body.blocks)
    set(
        block.size(), [&](std::ptrdiff_t cell) { return block.cell(static_cast<int>(cell)); }, block.stiffness);
  for (const int molecule : molecules) body.mass[molecule] *= mass;
  return found;
}

/// Cells of which the box has a part but not all: those whose middle lies in it count whole.
std::size_t cells_cut(const Body& body, const Vector3& low, const Vector3& high) {
  const double slack = 1e-6 * (high - low).norm();
  std::size_t count = 0;
  const auto look = [&](const auto& cell) {
    bool in = false, out = false;
    for (const int molecule : cell) {
      const Vector3 place = body.rest.col(molecule);
      const double depth = std::min((place - low).minCoeff(), (high - place).minCoeff());
      in |= depth > slack, out |= depth < -slack;
    }
    count += in && out;
  };
  if (!has_blocks(body, 3)) std::for_each(body.tetrahedra.begin(), body.tetrahedra.end(), look);
  if (!has_blocks(body, 2) && body.tetrahedra.empty())
    std::for_each(body.triangles.begin(), body.triangles.end(), look);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) look(block.cell(cell));
  return count;
}

/// {from: [x, y, z], to: [x, y, z], stiffness: 1e6, mass: 10}, or {molecules: …, stiffness: 1e6}
void read_region(Reader reader, Body& body, std::vector<std::string>& notes) {
  const auto molecules = reader.find("molecules");
  if (molecules) {
    std::vector<int> picked = read_molecules(*molecules, body, Matrix3::Identity());
    std::sort(picked.begin(), picked.end());
    const auto stiffness = reader.find("stiffness"), mass = reader.find("mass");
    reader.finish();
    const auto factor = [](const std::optional<Reader>& value) {
      return value ? value->quantity(dimension::none, {1e-12, 1e12, false}) : 1;
    };
    if (set_picked_region(body, picked, factor(stiffness), factor(mass)) == 0 && stiffness)
      reader.fail("no cell and no connection has all its molecules among these, so that none gets this stiffness");
    return;
  }
  const Reader to = reader.at("to");
  const Vector3 low = reader.at("from").vector(dimension::length), high = to.vector(dimension::length);
  const auto factor = [&](const char* key) {
    const auto value = reader.find(key);
    return value ? value->quantity(dimension::none, {1e-12, 1e12, false}) : 1;
  };
  const double stiffness = factor("stiffness"), mass = factor("mass");
  reader.finish();
  if (!((high - low).array() >= 0).all()) to.fail("must not lie below `from` in any direction");
  const Vector3 least = body.rest.rowwise().minCoeff(), most = body.rest.rowwise().maxCoeff();
  const double slack = 1e-9 * (high - low).norm();
  const bool has_molecules = (((body.rest.colwise() - low).array() >= -slack).colwise().all() &&
                              ((-body.rest).colwise() + high).array().colwise().minCoeff() >= -slack)
                                 .any();
  if (set_region(body, low, high, stiffness, mass) == 0 && (stiffness != 1 || !has_molecules))
    reader.fail(
        fmt::format("no cell and no connection has its middle in this box; the body reaches from [{:.6g}, "
                    "{:.6g}, {:.6g}] mm to [{:.6g}, {:.6g}, {:.6g}] mm",
                    1e3 * least.x(), 1e3 * least.y(), 1e3 * least.z(), 1e3 * most.x(), 1e3 * most.y(), 1e3 * most.z()));
  if (const std::size_t cut = cells_cut(body, low, high); cut > 0)
    notes.push_back(reader.path() + ": the box has a part of " + counted(static_cast<std::ptrdiff_t>(cut), "cell") +
                    "; those whose middle lies in it count whole");
}

/// lines: {to: [0, 0, -6 m], stiffness: 20 kN, mass: 20 kg}, from: ends | rim.
void read_lines(Reader reader, Body& body) {
  const auto from = reader.find("from"), radius = reader.find("radius");
  const HungFrom hung =
      from ? from->choice<HungFrom>({{"ends", HungFrom::ends}, {"rim", HungFrom::rim}}) : HungFrom::ends;
  const Vector3 to = reader.at("to").vector(dimension::length);
  const double stiffness = reader.at("stiffness").quantity(dimension::force, kPositive);
  const double mass = reader.at("mass").quantity(dimension::mass, kPositive);
  const double size = radius ? radius->quantity(dimension::length, kPositive) : body.radius.maxCoeff();
  reader.finish();
  if (body.triangles.empty()) reader.fail("lines hang a load on a body of triangles; this one has none");
  reader.located([&] { hang_load(body, hung, to, stiffness, mass, size); });
}

}  // namespace

std::vector<std::pair<std::string, double>> length_units() {
  return {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}};
}

mesh::Mesh read_mesh_file(Reader& reader) {
  const Reader file = reader.at("file");
  const double unit = reader.at("length_unit").choice<double>(length_units());
  const std::string path = file.existing_file();
  try {
    mesh::Mesh mesh = mesh::load_mesh(path);
    mesh.points *= unit;
    return mesh;
  } catch (const InputError& error) {
    file.fail(error.what());
  }
}

bool makes_shares(Reader body, int processes) {
  const std::vector<std::string> keys = body.keys();
  const auto known = [](const std::string& key) { return key == "lattice" || key == "radius"; };
  if (!std::all_of(keys.begin(), keys.end(), known)) return false;
  auto lattice = body.find("lattice");
  if (!lattice || !lattice->is_map() || !lattice->has("kind") || !lattice->has("molecules")) return false;
  const auto connections = lattice->find("connections");
  if (lattice->at("kind").text() != "cubic" || lattice->has("order") || (connections && connections->is_map()))
    return false;
  return lattice->at("molecules").items(3)[2].whole(1) >= 2 * processes;
}

Body read_body(Reader reader, const Material& material, Remarks remarks,
               const std::shared_ptr<const Processes>& processes) {
  reader.set_section("body");
  VectorX volumes;
  Order order;
  Body body = reader.located([&] { return read_shape(reader, volumes, order, remarks, processes); });
  if (auto jitter = reader.find("jitter")) {
    const double amount = jitter->at("amount").quantity(dimension::none, {0, 0.5, false});
    const int seed = jitter->has("seed") ? jitter->at("seed").whole(0) : 1;
    jitter->finish();
    add_jitter(body, amount * shortest_connection(body), static_cast<std::uint64_t>(seed));
  }
  if (auto grading = reader.find("grade"))
    for (const Reader& along : grading->is_map() ? std::vector{*grading} : grading->items()) read_grade(along, body);
  if (auto cells = reader.find("cells")) read_cells(*cells, body, remarks.warnings);
  if (order) {
    choose_order(*order, body, volumes);
    MoleculeSets sets = reader.mesh_sets();
    add_between(body, sets);
    if (remarks.sets) *remarks.sets = sets;
    reader.set_mesh_sets(std::move(sets));
  }
  const auto radius = reader.find("radius"), regions = reader.find("regions"), lines = reader.find("lines");
  reader.finish();
  const std::optional<double> given =
      radius ? std::optional(radius->quantity(dimension::length, kPositive)) : std::nullopt;
  if (!reader.given_body("given") || order)
    reader.located([&] { set_matter(body, material.density, material.thickness, given); });
  else if (given)
    body.radius.setConstant(*given);
  if (volumes.size()) body.mass = material.density * volumes;
  if (regions && (material.curve || material.fibre)) regions->fail("regions need a material without curve or fibre");
  if (regions)
    for (const Reader& item : regions->items()) read_region(item, body, remarks.notes);
  if (lines) read_lines(*lines, body);
  return body;
}

SceneKey order_key() {
  return {"order", "`1`, `2`", "", "", "`1`", "order of the cells: 2 puts a molecule in the middle of each edge"};
}

std::vector<KeySection> body_keys() {
  const SceneKey seed{"seed", "whole", "", "≥ 0", "1", "seed of the random numbers"};
  const SceneKey order = order_key();
  const SceneKey within{
      "connections.within", "quantity", "m", "> 0", "none", "joins all molecules that are at most so far apart"};
  return {
      {"body",
       "Body",
       "A body has one shape, " + words_text(kShapes) + ", with the keys of its own table, and these keys beside it:",
       {{"radius", "quantity", "m", "> 0", "half the shortest connection", "radius of each molecule"},
        {"jitter.amount", "number", "", "0 … 0.5", "needed",
         "random displacement of each molecule over the shortest connection; end faces stay plane"},
        {"jitter.seed", "whole", "", "≥ 0", "1", "seed of the random numbers"},
        {"grade", "map, or list of maps", "", "", "none", "lets the spacing grow along an axis"},
        {"grade.axis", "`x`, `y`, `z`", "", "", "needed", "the axis"},
        {"grade.ratio", "number", "", "0.01 … 100", "needed",
         "spacing at the far end over that at the near end; with `ends: both` in the middle over that at both ends"},
        {"grade.ends", "`one`, `both`", "", "", "`one`", "whether the spacing grows from one end, or from both"},
        {"cells", "`delaunay`", "", "", "none", "tetrahedra between the molecules, which fill the convex hull"},
        {"regions", "list of maps", "", "", "none", "boxes of other stiffness or mass; not with `curve` or `fibre`"},
        {"regions.from", "vector", "m", "", "needed, or `molecules`", "lowest corner of the box"},
        {"regions.to", "vector", "m", "", "needed, or `molecules`", "highest corner of the box"},
        {"regions.molecules", "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule",
         "needed, or `from` and `to`", "the region is what lies between these alone"},
        {"regions.stiffness", "number", "", "1e-12 … 1e+12", "1", "factor of the material's stiffness"},
        {"regions.mass", "number", "", "1e-12 … 1e+12", "1", "factor of the material's mass"},
        {"lines", "map", "", "", "none", "a load that hangs on cables from a body of triangles"},
        {"lines.from", "`ends`, `rim`", "", "", "`ends`", "the molecules from which the cables hang"},
        {"lines.to", "vector", "m", "", "needed", "position of the load"},
        {"lines.stiffness", "quantity", "N", "> 0", "needed", "axial stiffness EA of each cable"},
        {"lines.mass", "quantity", "kg", "> 0", "needed", "mass of the load"},
        {"lines.radius", "quantity", "m", "> 0", "the largest molecule's", "radius of the load"}}},
      {"body.lattice",
       "",
       "Shape `lattice`:",
       {{"kind", "`cubic`, `body_centred`, `face_centred`", "", "", "needed", "where the molecules of a cube are"},
        {"molecules", "three wholes", "", "≥ 1", "needed for `cubic`", "molecules along x, y, z"},
        {"cells", "three wholes", "", "≥ 1", "needed for the others", "cubes along x, y, z"},
        {"spacing", "quantity, or vector", "m", "> 0", "needed", "side of a cube; three values stretch the lattice"},
        {"connections", "list of `axis`, `face`, `space`; or `nearest`, `second`; or map", "", "",
         "`[axis]`, `nearest`",
         "of `cubic`: along axes, face diagonals, space diagonals; of the others: nearest neighbours, or second ones "
         "too"},
        within,
        {"order", "`1`, `2`", "", "", "no cells",
         "of `cubic`: fills each box with a hexahedron, of 8 or of 27 molecules"}}},
      {"body.packing",
       "",
       "Shape `packing`, a random close packing:",
       {{"size", "vector", "m", "> 0", "needed", "sides of the box"},
        {"distance", "quantity", "m", "> 0", "needed", "least distance of two molecules"},
        seed,
        {"connections.within", "quantity", "m", "> 0", "1.5 `distance`", "reach of the connections"}}},
      {"body.tetrahedra",
       "",
       "Shape `tetrahedra`, a block:",
       {{"kind", "`kuhn`, `alternating`, `body_centred`", "", "", "needed", "6, 5 or 12 tetrahedra in each cube"},
        {"cubes", "three wholes", "", "≥ 1", "needed", "cubes along x, y, z"},
        {"size", "vector", "m", "> 0", "needed", "sides of the block, from the origin"},
        order}},
      {"body.mesh",
       "",
       "Shape `mesh`, cells from a file: triangles, tetrahedra, prisms, hexahedra, of first or second order:",
       {{"file", "file beside the scene", "", "", "needed",
         "`.msh` 1, 2.2 and 4.1, `.vtk`, `.vtu`, `.inp`, `.bdf`, `.unv`, `.stl`, `.obj`, `.ply`"},
        {"length_unit", kLengthUnits, "", "", "needed", "unit of the file's coordinates"},
        order}},
      {"body",
       "",
       "Shape `molecules`, positions one by one; its other keys stand beside it:",
       {{"molecules", "list of vectors", "m", "", "needed", "positions"},
        {"connections", "list of pairs of molecules, or map", "", "0 … last molecule", "none",
         "pairs of molecules, counted from 0"},
        within,
        {"triangles", "list of triples of molecules", "", "0 … last molecule", "none",
         "corners of triangles, whose sides are the connections"}}}};
}

}  // namespace elastin::lab
