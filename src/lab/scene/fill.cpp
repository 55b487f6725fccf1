#include "mesh/fill.h"

#include <fmt/format.h>

#include <algorithm>

#include "contact/surface_check.h"
#include "elastin/core/base/text.h"
#include "lab/scene/parts.h"
#include "mesh/surface_repair.h"

namespace elastin::lab {
namespace {

/// Below this part of the surface's volume the filling is another body.
constexpr double kLeastVolume = 0.9;
/// A surface with a wider hole, over its longest side, is a sheet.
constexpr double kWidestHole = 0.5;

struct FillSetup : MeshFile, CellOrder, mesh::FillOptions {
  bool cells = true, repair = true;
  std::optional<double> reach;
  std::optional<Reader> place, spacing_place;
};

void report(const std::string& path, const std::string& name, const mesh::FillRegion& inside,
            const mesh::Filling& filling, Remarks remarks) {
  const double part = filling.volume / filling.surface_volume;
  remarks.notes.push_back(fmt::format(
      "{} filled: {} molecules, {} of them on the surface, {} tetrahedra; volume {:.2f} % of the surface's {:.5g} cm3, "
      "masses scaled to the surface's; a computed reference is that of these cells{}",
      name, filling.positions.cols(), filling.on_surface, filling.tetrahedra.size(), 100 * part,
      1e6 * filling.surface_volume, inside.shells() > 1 ? "; its separate shells are filled each by itself" : ""));
  if (filling.empty_shells > 0)
    remarks.warnings.push_back(fmt::format(
        "{}: of {} separate shells {} left out, because no tetrahedron fits inside: give a smaller spacing", path,
        inside.shells(), filling.empty_shells == 1 ? "1 is" : fmt::format("{} are", filling.empty_shells)));
  if (filling.slivers > 0)
    remarks.warnings.push_back(
        fmt::format("{}: {} of {} tetrahedra are nearly flat (below 1e-4 of the cube of their longest side)", path,
                    filling.slivers, filling.tetrahedra.size()));
  if (filling.left_out > 0)
    remarks.warnings.push_back(
        fmt::format("{}: {} left out: no tetrahedron inside has them", path, counted(filling.left_out, "molecule")));
  if (part < kLeastVolume)
    remarks.warnings.push_back(
        fmt::format("{}: only {:.1f} % of the surface's volume is filled: give a smaller spacing", path, 100 * part));
}

Body fill(const FillSetup& setup, ShapeContext& context) {
  const mesh::Mesh mesh = setup.load();
  const Reader& file = *setup.file;
  if (!mesh.tetrahedra.empty()) file.fail("contains tetrahedra: use the shape `mesh`; a surface consists of triangles");
  mesh::RepairedSurface surface = mesh::repair_surface(mesh.points, mesh.triangles);
  surface.repairs.insert(surface.repairs.begin(), mesh.repairs.begin(), mesh.repairs.end());
  const std::string name = file.text();
  if (!setup.repair) {
    if (const std::string wrong = contact::check_surface(mesh.points, mesh.triangles); !wrong.empty())
      file.fail("'" + name + "' encloses no volume that could be filled: " + wrong);
    if (!surface.repairs.empty()) file.fail("'" + name + "' needs its repair: " + listed(surface.repairs));
  }
  const std::string wrong = contact::check_surface(surface.points, surface.triangles);
  const auto extent = [&] {
    return (surface.points.rowwise().maxCoeff() - surface.points.rowwise().minCoeff()).maxCoeff();
  };
  if (surface.triangles.empty() || (!wrong.empty() && surface.widest_hole > kWidestHole * extent()))
    file.fail("'" + name + "' encloses no volume that could be filled: " + wrong +
              (surface.repairs.empty() ? "" : " after its repair: " + listed(surface.repairs)) +
              "; close its holes in a mesh program, such as MeshLab or Blender");
  if (!surface.repairs.empty()) context.remarks.notes.push_back(name + " repaired: " + listed(surface.repairs));
  const mesh::FillRegion inside(surface.points, surface.triangles, !wrong.empty());
  if (!wrong.empty())
    context.remarks.warnings.push_back(
        fmt::format("{}: {}; what it goes round at least half a time is inside (winding number), and its volume is "
                    "measured to 0.5 %{}",
                    setup.place->path(), wrong,
                    inside.filled_as_one() > 1
                        ? fmt::format("; its {} shells next to each other are filled as one body, which closes gaps "
                                      "between them that are narrower than the spacing: repair the surface, or give a "
                                      "smaller spacing",
                                      inside.filled_as_one())
                        : ""));

  mesh::FillOptions options = setup;
  options.most_molecules = std::min(options.most_molecules, file.most_molecules());
  const mesh::Filling filling = setup.spacing_place->located([&] { return inside.fill(options); });
  report(setup.place->path(), file.text(), inside, filling, context.remarks);
  Body body;
  body.rest = filling.positions;
  context.volumes = filling.surface_volume * filling.share;
  body.connections = setup.reach ? inside.connections_within(filling, *setup.reach)
                                 : connections_of_cells(body.rest, {}, filling.tetrahedra);
  if (setup.cells) {
    body.tetrahedra = filling.tetrahedra;
    add_cell_sides(body, sides_of(body.tetrahedra));
  } else {
    body.voronoi.emplace().problem = "needs the surface of its molecules: leave the filled body its cells";
  }
  return body;
}

}  // namespace

Shape fill_shape() {
  using S = FillSetup;
  std::vector<std::string> endings;
  for (const mesh::MeshFormat& format : mesh::mesh_formats())
    if (format.content == mesh::MeshContent::surface) endings.push_back(format.ending);
  return shape(
      "fill", ", the inside of a closed surface",
      Keys<S>{mesh_file_key("a surface of triangles: " + words_text(endings) + " …"), length_unit_key(),
              Key<S>(key::quantity("spacing", &mesh::FillOptions::spacing, dimension::length,
                                   "distance of neighbouring molecules", kPositive))
                  .needed()
                  .place(&S::spacing_place),
              key::choice("packing", &mesh::FillOptions::packing,
                          {{"lattice", mesh::FillPacking::lattice}, {"blue_noise", mesh::FillPacking::blue_noise}},
                          "regular or random positions inside"),
              seed_key(&mesh::FillOptions::seed),
              key::choice("boundary", &mesh::FillOptions::follow, {{"follow", true}, {"none", false}},
                          "whether molecules lie on the surface and along its sharp edges"),
              key::choice("cells", &S::cells, {{"delaunay", true}, {"none", false}}, "tetrahedra inside the surface"),
              key::choice("repair", &S::repair, {{"automatic", true}, {"none", false}},
                          "mends a surface that is not closed or not oriented, and notes it; `none` refuses one"),
              reach_key(&S::reach, "reach of connections between molecules that see each other inside",
                        "sides of the cells"),
              order_key()},
      [](const S& setup, ShapeContext& context) {
        for (const char* key : {"jitter", "grade", "cells", "connections"})
          if (const auto other = context.map.find(key))
            other->fail(key == std::string("cells") || key == std::string("connections")
                            ? "of a filled body this key stands inside `fill`"
                            : "a filled body cannot have this: it would leave its surface");
        return fill(setup, context);
      });
}

}  // namespace elastin::lab
