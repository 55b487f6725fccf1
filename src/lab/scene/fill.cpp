#include "elastin/mesh/fill.h"

#include <fmt/format.h>

#include <algorithm>

#include "elastin/contact/surface_check.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Below this part of the surface's volume the filling is another body.
constexpr double kLeastVolume = 0.9;

mesh::FillOptions read_options(Reader& reader) {
  mesh::FillOptions options;
  options.most_molecules = std::min(options.most_molecules, reader.most_molecules());
  options.spacing = reader.at("spacing").quantity(dimension::length, kPositive);
  if (auto packing = reader.find("packing"))
    options.packing = packing->choice<mesh::FillPacking>(
        {{"lattice", mesh::FillPacking::lattice}, {"blue_noise", mesh::FillPacking::blue_noise}});
  if (auto seed = reader.find("seed")) options.seed = static_cast<std::uint64_t>(seed->whole(0));
  if (auto boundary = reader.find("boundary"))
    options.follow = boundary->choice<bool>({{"follow", true}, {"none", false}});
  return options;
}

void report(const std::string& path, const std::string& name, const mesh::Filling& filling, Remarks remarks) {
  const double part = filling.volume / filling.surface_volume;
  remarks.notes.push_back(fmt::format(
      "{} filled: {} molecules, {} of them on the surface, {} tetrahedra; volume {:.2f} % of the surface's {:.5g} cm3, "
      "masses scaled to the surface's; a computed reference is that of these cells",
      name, filling.positions.cols(), filling.on_surface, filling.tetrahedra.size(), 100 * part,
      1e6 * filling.surface_volume));
  if (filling.slivers > 0)
    remarks.warnings.push_back(
        fmt::format("{}: {} of {} tetrahedra are nearly flat (below 1e-4 of the cube of their longest side)", path,
                    filling.slivers, filling.tetrahedra.size()));
  if (filling.left_out > 0)
    remarks.warnings.push_back(
        fmt::format("{}: {} molecules are left out that hang on no tetrahedron inside", path, filling.left_out));
  if (part < kLeastVolume)
    remarks.warnings.push_back(
        fmt::format("{}: only {:.1f} % of the surface's volume is filled: give a smaller spacing", path, 100 * part));
}

}  // namespace

Body read_fill(Reader reader, VectorX& volumes, Remarks remarks) {
  Reader file = reader.at("file");
  const mesh::Mesh mesh = read_mesh_file(reader);
  const mesh::FillOptions options = read_options(reader);
  const auto cells = reader.find("cells"), connections = reader.find("connections");
  const bool with_cells = !cells || cells->choice<bool>({{"delaunay", true}, {"none", false}});
  double reach = 0;
  if (auto pairs = connections) {
    reach = pairs->at("within").quantity(dimension::length, kPositive);
    pairs->finish();
  }
  reader.finish();
  if (!mesh.tetrahedra.empty()) file.fail("contains tetrahedra: use the shape `mesh`; a surface consists of triangles");
  const std::string wrong = contact::check_surface(mesh.points, mesh.triangles);
  if (!wrong.empty()) file.fail("'" + file.text() + "' encloses no volume that could be filled: " + wrong);

  const mesh::FillRegion inside(mesh.points, mesh.triangles);
  const mesh::Filling filling = reader.at("spacing").located([&] { return inside.fill(options); });
  report(reader.path(), file.text(), filling, remarks);
  Body body;
  body.rest = filling.positions;
  volumes = filling.surface_volume * filling.share;
  body.connections =
      reach > 0 ? inside.connections_within(filling, reach) : connections_of_cells(body.rest, {}, filling.tetrahedra);
  if (with_cells) {
    body.tetrahedra = filling.tetrahedra;
    add_cell_sides(body, sides_of(body.tetrahedra));
  } else {
    body.voronoi.emplace().problem = "needs the surface of its molecules: leave the filled body its cells";
  }
  return body;
}

std::vector<KeySection> fill_keys() {
  return {{"body.fill",
           "",
           "Shape `fill`, the inside of a closed surface:",
           {{"file", "file beside the scene", "", "", "needed", "a surface of triangles: `.stl`, `.obj`, `.ply` …"},
            {"length_unit", kLengthUnits, "", "", "needed", "unit of the file's coordinates"},
            {"spacing", "quantity", "m", "> 0", "needed", "distance of neighbouring molecules"},
            {"packing", "`lattice`, `blue_noise`", "", "", "`lattice`", "regular or random positions inside"},
            {"seed", "whole", "", "≥ 0", "1", "seed of the random numbers"},
            {"boundary", "`follow`, `none`", "", "", "`follow`",
             "whether molecules lie on the surface and along its sharp edges"},
            {"cells", "`delaunay`, `none`", "", "", "`delaunay`", "tetrahedra inside the surface"},
            {"connections.within", "quantity", "m", "> 0", "sides of the cells",
             "reach of connections between molecules that see each other inside"},
            order_key()}}};
}

}  // namespace elastin::lab
