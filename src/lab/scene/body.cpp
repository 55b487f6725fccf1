#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/named.h"
#include "core/shapes/orders.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/text.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/mesh/mesh_file.h"
#include "hull/delaunay.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// How many cells there are along x, y, z, with this number of molecules each.
template <class Setup, class Count>
Key<Setup> counts_key(std::string name, std::array<int, 3> Setup::*member, std::string text, Count molecules) {
  return sized(key::wholes(std::move(name), member, 1, std::move(text)), [=](const Setup& setup) {
    const auto& counts = setup.*member;
    return static_cast<double>(molecules(setup)) * counts[0] * counts[1] * counts[2];
  });
}

enum class LatticeKind { cubic, body_centred, face_centred };

struct LatticeSetup : CellOrder {
  LatticeKind kind = LatticeKind::cubic;
  std::array<int, 3> counts{};         ///< of molecules or cells
  std::optional<double> spacing;       ///< one for all directions
  Vector3 spacings = Vector3::Zero();  ///< otherwise
  CubicPattern pattern = {};           ///< of cubic lattices
  bool second = false;                 ///< of the others: second neighbours are joined, too
  std::optional<double> reach;         ///< of the connections, in the place of these
  std::optional<Reader> connections;
  bool is_cubic() const { return kind == LatticeKind::cubic; }
};

/// `connections`: a map with their reach, or what `read` reads.
template <class Setup>
Key<Setup> connections_key(SceneKey row, std::optional<double> Setup::*reach,
                           std::function<void(const Reader&, Setup&)> read) {
  const Key<Setup> within = reach_key(reach, "joins all molecules at most this far apart", "none");
  std::vector<SceneKey> rows{std::move(row)};
  rows.insert(rows.end(), within.rows().begin(), within.rows().end());
  return {"connections", std::move(rows),
          [within, read = std::move(read)](const Reader& value, Setup& setup, const Frame& frame) {
            value.is_map() ? within.read(value, setup, frame) : read(value, setup);
          }};
}

Keys<LatticeSetup> lattice_keys() {
  using S = LatticeSetup;
  return {
      key::choice("kind", &S::kind,
                  {{"cubic", LatticeKind::cubic},
                   {"body_centred", LatticeKind::body_centred},
                   {"face_centred", LatticeKind::face_centred}},
                  "where the molecules of a cube are")
          .needed(),
      counts_key("molecules", &S::counts, "molecules along x, y, z", [](const S&) { return 1; })
          .needed("needed for `cubic`")
          .when(&S::is_cubic),
      counts_key("cells", &S::counts, "cubes along x, y, z",
                 [](const S& setup) { return setup.kind == LatticeKind::body_centred ? 2 : 4; })
          .needed("needed for the others")
          .when(std::not_fn(&S::is_cubic)),
      Key<S>({"spacing", "quantity, or vector", "m", "> 0", "", "side of a cube; three values stretch the lattice"},
             [](const Reader& value, S& setup, const Frame&) {
               if (value.is_text())
                 setup.spacing = value.quantity(dimension::length, kPositive);
               else
                 setup.spacings = value.vector(dimension::length, kPositive);
             })
          .needed(),
      connections_key<S>(
          {"connections", "list of `axis`, `face`, `space`; or `nearest`, `second`; or map", "", "",
           "`[axis]`, `nearest`",
           "of `cubic`: along axes, face diagonals, space diagonals; of the others: nearest neighbours, or second ones "
           "too"},
          &S::reach,
          [](const Reader& value, S& setup) {
            if (!setup.is_cubic()) {
              setup.second = value.choice<bool>({{"nearest", false}, {"second", true}});
              return;
            }
            CubicPattern& pattern = setup.pattern = {false, false, false};
            for (const Reader& item : value.items())
              *item.choice<bool*>({{"axis", &pattern.axis}, {"face", &pattern.face}, {"space", &pattern.space}}) = true;
          })
          .place(&S::connections)
          .refused_for([](const S& setup) {
            return setup.order && setup.connections
                       ? "the sides of its cells are the connections; leave `connections` out"
                       : "";
          }),
      Key<S>(key::choice("order", &CellOrder::order, {{"1", 1}, {"2", 2}},
                         "of `cubic`: fills each box with a hexahedron, of 8 or of 27 molecules")
                 .otherwise("no cells")
                 .place(&CellOrder::order_place))};
}

Body make_lattice(const LatticeSetup& setup, const std::shared_ptr<const Processes>& processes) {
  const double spacing = setup.spacing.value_or(1);
  Body body = setup.is_cubic() ? (processes ? cubic_lattice_share(setup.counts, spacing, setup.pattern, processes)
                                            : cubic_lattice(setup.counts, spacing, setup.pattern))
              : setup.kind == LatticeKind::body_centred ? body_centred_lattice(setup.counts, spacing, setup.second)
                                                        : face_centred_lattice(setup.counts, spacing, setup.second);
  if (!setup.spacing) stretch(body, setup.spacings);
  if (setup.reach) body.connections = connections_within(body.rest, *setup.reach);
  return body;
}

Shape lattice_shape() {
  return shape("lattice", "", lattice_keys(), [](const LatticeSetup& setup, const ShapeContext& context) {
    return make_lattice(setup, context.processes);
  });
}

Shape packing_shape() {
  struct S {
    Vector3 size = Vector3::Zero();
    double distance = 0;
    std::uint64_t seed = 1;
    std::optional<double> reach;
    std::optional<Reader> place;
  };
  return shape(
      "packing", ", a random close packing",
      Keys<S>{key::vector("size", &S::size, dimension::length, "sides of the box", kPositive).needed(),
              key::quantity("distance", &S::distance, dimension::length, "least distance of two molecules", kPositive)
                  .needed(),
              seed_key(&S::seed), reach_key(&S::reach, "reach of the connections", "1.5 `distance`")},
      [](const S& setup) {
        const double molecules = (setup.size.array() / setup.distance + 1).prod();
        if (!(molecules < 5e6))
          setup.place->fail("a box of this size has too many molecules at this distance: at most 5e6 are allowed");
        setup.place->check_size(molecules);
        return random_packing(setup.size, setup.distance, setup.reach.value_or(1.5 * setup.distance), setup.seed);
      });
}

Shape tetrahedra_shape() {
  struct S : CellOrder {
    BlockKind kind = BlockKind::kuhn;
    std::array<int, 3> cubes{};
    Vector3 size = Vector3::Zero();
  };
  return shape(
      "tetrahedra", ", a block",
      Keys<S>{
          key::choice("kind", &S::kind,
                      {{"kuhn", BlockKind::kuhn},
                       {"alternating", BlockKind::alternating},
                       {"body_centred", BlockKind::body_centred}},
                      "6, 5 or 12 tetrahedra in each cube")
              .needed(),
          counts_key("cubes", &S::cubes, "cubes along x, y, z", [](const S&) { return 2; }).needed(),
          key::vector("size", &S::size, dimension::length, "sides of the block, from the origin", kPositive).needed(),
          order_key()},
      [](const S& setup) { return tetrahedral_block(setup.kind, setup.cubes, setup.size); });
}

/// A few may be a fault of the mesh; all of them are another program's convention.
void warn_of_reoriented(const mesh::Mesh& mesh, const std::string& path, std::vector<std::string>& warnings) {
  if (mesh.reoriented == 0) return;
  std::size_t cells = mesh.blocks.empty() ? mesh.tetrahedra.size() : 0;
  for (const CellBlock& block : mesh.blocks) cells += static_cast<std::size_t>(block.size());
  warnings.push_back(path + ": " + std::to_string(mesh.reoriented) + " of " + counted(cells, "cell") +
                     " had their corners in the mirrored order, and were reoriented");
}

/// The names that its molecules can be picked by, and what of the file is not in the body.
void note_contents(const mesh::Mesh& mesh, const std::string& file, std::vector<std::string>& notes) {
  constexpr std::size_t most = 20;
  std::vector<std::string> sets;
  for (const auto& [name, molecules] : mesh.sets)
    if (sets.size() < most) sets.push_back(fmt::format("{} ({})", name, molecules.size()));
  if (mesh.sets.size() > most) sets.push_back(fmt::format("{} more", mesh.sets.size() - most));
  if (!sets.empty()) notes.push_back(file + ": sets, with their molecules: " + listed(sets));
  if (!mesh.repairs.empty()) notes.push_back(file + " repaired: " + listed(mesh.repairs));
  if (!mesh.comment.empty()) notes.push_back(file + ": " + mesh.comment);
}

Shape mesh_shape() {
  struct S : MeshFile, CellOrder {
    std::optional<Reader> place, join_place;
    std::optional<double> join;
  };
  std::string endings;
  for (const mesh::MeshFormat& format : mesh::mesh_formats())
    endings +=
        (endings.empty() ? "`" : ", `") + format.ending + "`" + (format.versions.empty() ? "" : " " + format.versions);
  return shape("mesh", ", cells from a file: triangles, tetrahedra, prisms, hexahedra, of first or second order",
               Keys<S>{mesh_file_key(endings), length_unit_key(), order_key(),
                       key::quantity("join", &S::join, dimension::length,
                                     "makes one point of those that lie within this distance of each other, as at a "
                                     "seam of parts",
                                     kPositive)
                           .place(&S::join_place)},
               [](const S& setup, ShapeContext& context) {
                 mesh::Mesh mesh = setup.load();
                 if (setup.join)
                   setup.join_place->located([&] {
                     const int taken = mesh::join_points(mesh, *setup.join);
                     if (taken > 0)
                       mesh.repairs.push_back(counted(taken, "point") + " joined to others");
                     else
                       context.remarks.notes.push_back("`join`: no two points lie within this distance");
                   });
                 warn_of_reoriented(mesh, setup.place->path(), context.remarks.warnings);
                 note_contents(mesh, setup.file->text(), context.remarks.notes);
                 if (context.remarks.sets) *context.remarks.sets = mesh.sets;
                 context.map.set_mesh_sets(std::move(mesh.sets));
                 Body body;
                 body.rest = std::move(mesh.points);
                 body.triangles = std::move(mesh.triangles);
                 body.tetrahedra = std::move(mesh.tetrahedra);
                 body.blocks = std::move(mesh.blocks);
                 body.connections = connections_of_cells(body.rest, body.triangles, body.tetrahedra);
                 return body;
               });
}

struct ListSetup {
  std::vector<Vector3> molecules;
  std::vector<std::array<int, 2>> pairs;
  std::optional<double> reach;
  Cells<3> triangles;
  std::optional<Reader> connections_place, triangles_place;
  int count() const { return static_cast<int>(molecules.size()); }
};

Keys<ListSetup> list_keys() {
  using S = ListSetup;
  return {
      Key<S>({"molecules", "list of vectors", "m", "", "", "positions"},
             [](const Reader& value, S& setup, const Frame&) {
               for (const Reader& item : value.items()) setup.molecules.push_back(item.vector(dimension::length));
               if (setup.molecules.empty()) value.fail("a body needs at least one molecule");
             })
          .needed(),
      connections_key<S>({"connections", "list of pairs of molecules, or map", "", "0 … last molecule", "none",
                          "pairs of molecules, counted from 0"},
                         &S::reach,
                         [](const Reader& value, S& setup) {
                           for (const Reader& item : value.items()) {
                             const auto ends = item.items(2);
                             setup.pairs.push_back({ends[0].molecule(setup.count()), ends[1].molecule(setup.count())});
                             if (setup.pairs.back()[0] == setup.pairs.back()[1])
                               item.fail("a connection needs two different molecules");
                           }
                         })
          .place(&S::connections_place),
      Key<S>({"triangles", "list of triples of molecules", "", "0 … last molecule", "none",
              "corners of triangles, whose sides are the connections"},
             [](const Reader& value, S& setup, const Frame&) {
               if (setup.connections_place)
                 value.fail("the sides of the triangles are the connections; leave `connections` out");
               for (const Reader& item : value.items()) {
                 const auto corners = item.items(3);
                 setup.triangles.push_back({corners[0].molecule(setup.count()), corners[1].molecule(setup.count()),
                                            corners[2].molecule(setup.count())});
                 const auto& [a, b, c] = setup.triangles.back();
                 if (a == b || b == c || c == a) item.fail("a triangle needs three different molecules");
               }
             })
          .place(&S::triangles_place)};
}

/// Its keys are among those of the body.
Shape molecules_shape() {
  const auto make = [keys = list_keys()](const Reader&, ShapeContext& context) {
    ListSetup setup;
    keys.read_into(context.map, setup);
    Body body = listed_body(setup.molecules, setup.pairs);
    if (setup.reach) body.connections = connections_within(body.rest, *setup.reach);
    if (!setup.triangles_place) return body;
    body.triangles = std::move(setup.triangles);
    body.connections = connections_of_cells(body.rest, body.triangles, {});
    return body;
  };
  return {"molecules", ", positions one by one; its other keys are keys of the body", "body", list_keys().rows(), make};
}

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> all = [] {
    std::vector<Shape> list;
    for (Shape (*const make)() : {lattice_shape, packing_shape, tetrahedra_shape}) list.push_back(make());
    for (Shape& surface : surface_shapes()) list.push_back(std::move(surface));
    for (Shape (*const make)() : {mesh_shape, fill_shape, image_shape, molecules_shape}) list.push_back(make());
    return list;
  }();
  return all;
}

/// Spacings grow along an axis.
struct Grade {
  int axis = 0;
  double ratio = 1;
  bool both = false;  ///< from both ends
};

Keys<Grade> grade_keys() {
  return {
      key::choice("axis", &Grade::axis, {{"x", 0}, {"y", 1}, {"z", 2}}, "the axis").needed(),
      key::quantity("ratio", &Grade::ratio, dimension::none,
                    "spacing at the far end over that at the near end; with `ends: both` in the middle over that at "
                    "both ends",
                    {0.01, 100})
          .needed(),
      key::choice("ends", &Grade::both, {{"one", false}, {"both", true}},
                  "whether the spacing grows from one end, or from both")};
}

void apply_grade(const Grade& setup, Body& body) {
  if (!setup.both) return grade(body, setup.axis, setup.ratio);
  // The half beyond the middle is the mirror image of the other, which is graded as a body of its own would be.
  const double low = body.rest.row(setup.axis).minCoeff(), length = body.rest.row(setup.axis).maxCoeff() - low;
  const double growth = std::log(setup.ratio);
  if (!(length > 0) || growth == 0) return;
  for (double& position : body.rest.row(setup.axis)) {
    const double at = 2 * (position - low) / length - 1, depth = 1 - std::abs(at);
    const double graded = std::expm1(growth * depth) / std::expm1(growth);
    position = low + length * (1 + std::copysign(1 - graded, at)) / 2;
  }
  set_present_lengths(body);
}

/// The sides that are no connections of the body's own become sides of cells only; all of them its connections where
/// it has none.
void fill_with_tetrahedra(const Reader& reader, Body& body, std::vector<std::string>& warnings) {
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
void choose_order(const CellOrder& chosen, Body& body, VectorX& volumes) {
  const int order = *chosen.order;
  if (order == 1 && body.blocks.empty() && body.cubes.empty()) return;
  body = chosen.order_place->located([&] { return with_order(body, order); });
  if (volumes.size() != body.size()) volumes.resize(0);
}

/// Cells of which the box has a part but not all: those whose middle lies in it count whole.
std::size_t cells_cut(const Body& body, const Vector3& low, const Vector3& high) {
  const double slack = 1e-6 * (high - low).norm();
  std::size_t count = 0;
  const auto look = [&](const auto& cell) {
    Vector3 lowest = body.rest.col(*cell.begin()), highest = lowest;  // of the cell's bounding box
    for (const int molecule : cell) {
      lowest = lowest.cwiseMin(body.rest.col(molecule));
      highest = highest.cwiseMax(body.rest.col(molecule));
    }
    const bool inside = ((lowest - low).array() >= -slack).all() && ((high - highest).array() >= -slack).all();
    const bool apart = ((lowest - high).array() >= -slack).any() || ((low - highest).array() >= -slack).any();
    count += !inside && !apart;
  };
  if (!has_blocks(body, 3)) std::for_each(body.tetrahedra.begin(), body.tetrahedra.end(), look);
  if (!has_blocks(body, 2) && body.tetrahedra.empty())
    std::for_each(body.triangles.begin(), body.triangles.end(), look);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) look(block.cell(cell));
  return count;
}

/// A part of the body with other stiffness or mass: a box, or what lies between these molecules alone.
struct Region : BoxCorners {
  std::optional<std::vector<int>> molecules;
  double stiffness = 1, mass = 1;
  std::optional<Reader> place;
};

Keys<Region> region_keys() {
  using S = Region;
  const Range factor{1e-12, 1e12};
  const auto of_box = [](const Key<BoxCorners>& corner) {
    return Key<S>(corner).needed("needed, or `molecules`").when([](const S& setup) { return !setup.molecules; });
  };
  return {molecules_key("molecules", &S::molecules, "the region is what lies between these alone")
              .otherwise("needed, or `from` and `to`"),
          of_box(low_corner_key()), of_box(high_corner_key()),
          key::quantity("stiffness", &S::stiffness, dimension::none,
                        "factor of the material's stiffness; springs take the mean of the cells around them", factor),
          key::quantity("mass", &S::mass, dimension::none, "factor of the material's mass", factor)};
}

void apply_picked_region(const Region& region, Body& body, std::vector<std::string>& notes) {
  std::vector<char> picked(static_cast<std::size_t>(body.size()));
  for (const int molecule : *region.molecules) picked[molecule] = 1, body.mass[molecule] *= region.mass;
  const auto are_picked = [&](const auto& molecules) {
    return std::all_of(molecules.begin(), molecules.end(), [&](int molecule) { return picked[molecule]; });
  };
  int connections = 0, cells = 0;
  change_stiffness(
      body,
      [&](const auto& molecules, double& factor) {
        if (are_picked(molecules)) factor = region.stiffness, cells += molecules.size() > 2;
      },
      true);
  if (cells > 0 || region.stiffness == 1) return;
  for (int connection = 0; connection < body.connections.size(); ++connection)
    if (are_picked(body.connections.ends[connection]))
      body.connection_stiffness[connection] = region.stiffness, ++connections;
  if (connections == 0)
    region.place->fail("no cell and no connection has all its molecules among these, so that none gets this stiffness");
  if (!body.tetrahedra.empty() || !body.triangles.empty() || !body.blocks.empty())
    notes.push_back(region.place->path() + ": no cell has all its molecules among these, but " +
                    counted(connections, "connection") + ": springs get this stiffness, laws of cells do not");
}

void apply_region(const Region& region, Body& body, std::vector<std::string>& notes) {
  if (region.molecules) return apply_picked_region(region, body, notes);
  const Vector3 least = body.rest.rowwise().minCoeff(), most = body.rest.rowwise().maxCoeff();
  const double slack = 1e-9 * (region.to - region.from).norm();
  const bool has_molecules = (((body.rest.colwise() - region.from).array() >= -slack).colwise().all() &&
                              ((-body.rest).colwise() + region.to).array().colwise().minCoeff() >= -slack)
                                 .any();
  if (set_region(body, region.from, region.to, region.stiffness, region.mass) == 0 &&
      (region.stiffness != 1 || !has_molecules))
    region.place->fail(
        fmt::format("no cell and no connection has its middle in this box; the body reaches from [{:.6g}, "
                    "{:.6g}, {:.6g}] mm to [{:.6g}, {:.6g}, {:.6g}] mm",
                    1e3 * least.x(), 1e3 * least.y(), 1e3 * least.z(), 1e3 * most.x(), 1e3 * most.y(), 1e3 * most.z()));
  if (const std::size_t cut = cells_cut(body, region.from, region.to); cut > 0)
    notes.push_back(region.place->path() + ": the box has a part of " +
                    counted(static_cast<std::ptrdiff_t>(cut), "cell") + "; those whose middle lies in it count whole");
}

struct Jitter {
  double amount = 0;
  std::uint64_t seed = 1;
};

/// A load that hangs on cables.
struct Lines {
  HungFrom from = HungFrom::ends;
  Vector3 to = Vector3::Zero();
  double stiffness = 0, mass = 0;
  std::optional<double> radius;
  std::optional<Reader> place;
};

/// The keys of all bodies.
struct BodySetup {
  std::optional<double> radius;
  std::optional<Jitter> jitter;
  std::vector<Grade> grades;
  std::optional<bool> delaunay;
  std::optional<Lines> lines;
  std::optional<Reader> cells, regions;
};

Keys<BodySetup> own_body_keys() {
  using S = BodySetup;
  return {
      key::quantity("radius", &S::radius, dimension::length, "radius of each molecule", kPositive)
          .otherwise("half the shortest connection"),
      key::map("jitter", &S::jitter,
               {key::quantity("amount", &Jitter::amount, dimension::none,
                              "random displacement of each molecule over the shortest connection; end faces stay plane",
                              {0, 0.5})
                    .needed(),
                seed_key(&Jitter::seed)}),
      Key<S>("grade",
             key::rows_below("grade", "map, or list of maps", "lets the spacing grow along an axis", grade_keys()),
             [](const Reader& value, S& setup, const Frame& frame) {
               for (const Reader& item : value.is_map() ? std::vector{value} : value.items())
                 setup.grades.push_back(grade_keys().read(item, frame));
             }),
      key::choice("cells", &S::delaunay, {{"delaunay", true}},
                  "tetrahedra between the molecules, which fill the convex hull")
          .place(&S::cells),
      Key<S>("regions",
             key::rows_below("regions", "list of maps", "boxes of other stiffness or mass; not with `curve` or `fibre`",
                             region_keys()),
             [](const Reader& value, S& setup, const Frame&) { setup.regions = value; }),
      key::map("lines", &S::lines,
               {key::choice("from", &Lines::from, {{"ends", HungFrom::ends}, {"rim", HungFrom::rim}},
                            "the molecules from which the cables hang"),
                key::vector("to", &Lines::to, dimension::length, "position of the load").needed(),
                key::quantity("stiffness", &Lines::stiffness, dimension::force, "axial stiffness EA of each cable",
                              kPositive)
                    .needed(),
                key::quantity("mass", &Lines::mass, dimension::mass, "mass of the load", kPositive).needed(),
                key::quantity("radius", &Lines::radius, dimension::length, "radius of the load", kPositive)
                    .otherwise("the largest molecule's")},
               "a load that hangs on cables from a body of triangles")};
}

/// The body as its shape has it, or as a program gives it.
Body make_shape(Reader& reader, ShapeContext& context) {
  for (const char* key : {"given", "given_shape"})
    if (const auto given = reader.given_body(key)) {
      Keys<CellOrder>{order_key()}.read_into(reader, context.order);
      return *given;
    }
  const Shape* shape = nullptr;
  std::optional<Reader> value;
  for (const Shape& row : shapes())
    if (const auto found = reader.find(row.name)) {
      if (shape) found->fail("the body has a shape already: " + value->path());
      shape = &row;
      value = found;
    }
  if (shape) return shape->make(*value, context);
  own_body_keys().add_to_known(reader);
  list_keys().add_to_known(reader);
  reader.finish();
  reader.fail("needs a shape: " + listed(names_of(shapes()), "or"));
}

}  // namespace

void add_between(const Body& body, MoleculeSets& sets) {
  const std::size_t first = static_cast<std::size_t>(body.size()) - body.between.size();
  for (auto& [name, members] : sets) {
    std::erase_if(members, [&](int member) { return member >= body.size(); });
    std::vector<char> is_member(static_cast<std::size_t>(body.size()), 0);
    for (const int member : members) is_member[member] = 1;
    for (std::size_t i = 0; i < body.between.size(); ++i) {
      const bool all = std::all_of(body.between[i].begin(), body.between[i].end(),
                                   [&](const auto& of) { return is_member[of.first] != 0; });
      if (!all || body.between[i].empty() || is_member[first + i]) continue;
      is_member[first + i] = 1;
      members.push_back(static_cast<int>(first + i));
    }
  }
}

Key<CellOrder> order_key() {
  return key::choice("order", &CellOrder::order, {{"1", 1}, {"2", 2}},
                     "order of the cells: 2 puts a molecule in the middle of each edge")
      .otherwise("`1`")
      .place(&CellOrder::order_place);
}

mesh::Mesh MeshFile::load() const {
  try {
    mesh::Mesh mesh = mesh::load_mesh(path);
    mesh.points *= length_unit;
    return mesh;
  } catch (const InputError& error) {
    file->fail(error.what());
  }
}

Key<MeshFile> mesh_file_key(std::string text) {
  return key::file("file", &MeshFile::path, std::move(text)).needed().place(&MeshFile::file);
}

Key<MeshFile> length_unit_key() {
  return key::choice("length_unit", &MeshFile::length_unit,
                     {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}},
                     "unit of the file's coordinates")
      .needed();
}

bool makes_shares(Reader body, int processes) {
  const std::vector<std::string> keys = body.keys();
  const auto known = [](const std::string& key) { return key == "lattice" || key == "radius"; };
  const auto lattice = body.find("lattice");
  if (!lattice || !std::all_of(keys.begin(), keys.end(), known)) return false;
  const LatticeSetup setup = lattice_keys().read(*lattice);
  return setup.is_cubic() && !setup.order && !setup.reach && setup.counts[2] >= 2 * processes;
}

Body read_body(Reader reader, const Material& material, Remarks remarks,
               const std::shared_ptr<const Processes>& processes) {
  reader.set_section("body");
  ShapeContext context{reader, remarks, processes, &material};
  Body body = reader.located([&] { return make_shape(reader, context); });
  BodySetup setup;
  own_body_keys().read_into(reader, setup);
  reader.finish();
  if (setup.jitter) add_jitter(body, setup.jitter->amount * shortest_connection(body), setup.jitter->seed);
  for (const Grade& grade : setup.grades) apply_grade(grade, body);
  if (setup.cells) fill_with_tetrahedra(*setup.cells, body, remarks.warnings);
  if (context.order.order) {
    choose_order(context.order, body, context.volumes);
    MoleculeSets sets = reader.mesh_sets();
    add_between(body, sets);
    if (remarks.sets) *remarks.sets = sets;
    reader.set_mesh_sets(std::move(sets));
  }
  if (!reader.given_body("given") || context.order.order)
    reader.located([&] { set_matter(body, material.density, material.thickness, setup.radius); });
  else if (setup.radius)
    body.radius.setConstant(*setup.radius);
  if (body.assumed_density > 0) body.mass *= material.density / std::exchange(body.assumed_density, 0);
  if (context.volumes.size()) body.mass = material.density * context.volumes;
  if (const auto& regions = setup.regions) {
    if (material.curve || material.fibre) regions->fail("regions need a material without curve or fibre");
    for (const Reader& item : regions->items())
      apply_region(region_keys().read(item, {Matrix3::Identity(), &body}), body, remarks.notes);
  }
  if (const auto& lines = setup.lines) {
    if (body.triangles.empty()) lines->place->fail("lines hang a load on a body of triangles; this one has none");
    lines->place->located([&] {
      hang_load(body, lines->from, lines->to, lines->stiffness, lines->mass,
                lines->radius.value_or(body.radius.maxCoeff()));
    });
  }
  return body;
}

std::vector<KeySection> body_keys() {
  std::vector<KeySection> sections{{"body", "Body",
                                    "A body has one shape, " + words_text(names_of(shapes())) +
                                        ", with the keys of its own table, and these keys in addition:",
                                    own_body_keys().rows()}};
  for (const Shape& shape : shapes())
    sections.push_back({shape.section, "", "Shape `" + shape.name + "`" + shape.text + ":", shape.keys});
  return sections;
}

}  // namespace elastin::lab
