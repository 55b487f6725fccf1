#include <limits>

#include "core/forces/floor.h"
#include "core/forces/pressure.h"
#include "core/forces/surface_load.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/air.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr Dimension kRate{0, 0, -1};

bool never_at_rest(const LoadValues&) { return false; }

ParameterInfo vector(const char* name, const Dimension& unit, const char* text) {
  return {name, unit, -kUnlimited, kUnlimited, kNone, text, false, ValueKind::vector, true};
}

ParameterInfo direction(const char* name, const char* text) {
  return {name, dimension::none, -1, 1, kNone, text, false, ValueKind::direction, true};
}

/// A number of at least 0.
ParameterInfo amount(const char* name, const Dimension& unit, const char* text, double fallback) {
  return {name, unit, 0, kUnlimited, fallback, text};
}

ParameterInfo required(const char* name, const Dimension& unit, const char* text) {
  ParameterInfo info = amount(name, unit, text, kNone);
  info.required = true;
  return info;
}

/// A number above 0, or none.
ParameterInfo optional(const char* name, const Dimension& unit, const char* text) {
  ParameterInfo info = amount(name, unit, text, kNone);
  info.above_low = true;
  return info;
}

Vector3 middle_of(const Body& body) { return body.rest.rowwise().mean(); }

/// All triangles, or those all of whose corners `on` picks.
Cells<3> picked_triangles(const Body& body, const LoadValues& values) {
  if (!values.has("on")) return body.triangles;
  std::vector<char> picked(static_cast<std::size_t>(body.size()), 0);
  for (const int molecule : values.molecules.at("on")) picked[molecule] = 1;
  Cells<3> triangles;
  for (const auto& triangle : body.triangles)
    if (picked[triangle[0]] && picked[triangle[1]] && picked[triangle[2]]) triangles.push_back(triangle);
  if (triangles.empty() && !body.triangles.empty())
    throw InputError("no triangle has all its corners among the molecules that `on` picks: it picks " +
                     counted(static_cast<std::ptrdiff_t>(values.molecules.at("on").size()), "molecule"));
  return triangles;
}

std::unique_ptr<Load> make_pressure(const Body& body, Cells<3> triangles, const PressureLaw& law) {
  return std::make_unique<Pressure>(body, std::move(triangles), law, middle_of(body), false);
}

ParameterInfo picked(const char* text, bool required = false) {
  return {"on", dimension::none, 0, kUnlimited, kNone, text, false, ValueKind::molecules, required};
}

std::vector<LoadedFace> faces_of_solid(const Body& body, const LoadValues& values) {
  if (body.tetrahedra.empty()) throw InputError("`on` picks faces of cells of a solid, and the body has none");
  std::vector<LoadedFace> faces = outer_faces(body, values.molecules.at("on"));
  if (faces.empty())
    throw InputError("no outer face of a cell has all its nodes among the molecules that `on` picks: it picks " +
                     counted(static_cast<std::ptrdiff_t>(values.molecules.at("on").size()), "molecule"));
  return faces;
}

/// Each space has a gas of its own.
std::vector<std::unique_ptr<Load>> make_gas(const Body& body, const LoadValues& values) {
  std::vector<std::unique_ptr<Load>> loads;
  for (Cells<3>& piece : closed_spaces(picked_triangles(body, values), body)) {
    const double volume = enclosed_volume(piece, body.rest, middle_of(body)),
                 amount =
                     values.has("amount") ? values.numbers.at("amount") : values.numbers.at("start_pressure") * volume;
    loads.push_back(make_pressure(body, std::move(piece),
                                  enclosed_gas(amount, values.numbers.at("exponent"), values.numbers.at("ambient"))));
  }
  return loads;
}

Air air_of(const LoadValues& values) {
  Air air;
  air.density = values.numbers.at("density");
  air.drag_coefficient = values.numbers.at("drag_coefficient");
  air.skin_coefficient = values.numbers.at("skin_coefficient");
  air.pressure_coefficient = values.numbers.at("pressure_coefficient");
  if (values.has("wind")) air.wind = values.vectors.at("wind");
  return air;
}

LoadKind gravity() {
  LoadKind load{{"gravity",
                 "weight: F = m g",
                 "",
                 {vector("acceleration", dimension::acceleration, "acceleration g of free fall")}}};
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(make_gravity(model.body(), values.vectors.at("acceleration")));
  };
  load.of_shares = true;
  return load;
}

LoadKind point() {
  LoadKind load{{"point", "the same dead force on each of some molecules", "", {}}};
  load.parameters = {{"molecules", dimension::none, 0, kUnlimited, kNone, "molecules on which the force acts", false,
                      ValueKind::molecules, true},
                     vector("force", dimension::force, "force on each of them")};
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    const std::vector<int>& molecules = values.molecules.at("molecules");
    model.add(std::make_unique<PointLoads>(
        model.body(), molecules, values.vectors.at("force").replicate(1, static_cast<Eigen::Index>(molecules.size()))));
  };
  load.of_shares = load.of_each = true;
  return load;
}

/// On picked faces of a solid, or else on triangles.
std::unique_ptr<Load> pressure_load(const Body& body, const LoadValues& values) {
  const double pressure = values.numbers.at("pressure");
  if (!values.has("on") && !body.tetrahedra.empty())
    throw InputError("a solid has pressure on some of its faces: give `on`, for example on: {set: LUMEN}");
  const bool on_solid =
      values.has("on") && (body.triangles.empty() || !outer_faces(body, values.molecules.at("on")).empty());
  if (on_solid)
    return std::make_unique<SurfaceForces>(body, SurfaceLoad{.faces = faces_of_solid(body, values)}, pressure);
  return make_pressure(body, picked_triangles(body, values), constant_pressure(pressure));
}

LoadKind pressure() {
  LoadKind load{{"pressure", "pressure along present normals: on triangles, or on faces of a solid", "", {}}};
  load.parameters = {
      required("pressure", dimension::pressure, "pressure over that on the other side; into a solid; may be negative"),
      picked("molecules: it acts on the outer faces of a solid's cells all of whose nodes are among them, or on the "
             "triangles all of whose corners are; without it on all triangles")};
  load.parameters.front().low = -kUnlimited;
  load.check = [](const Body& body, const LoadValues& values) { pressure_load(body, values); };
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(pressure_load(model.body(), values));
  };
  return load;
}

LoadKind traction() {
  LoadKind load{{"traction", "a dead traction on faces of a solid", "", {}}};
  load.parameters = {
      vector("traction", dimension::pressure, "force over area at rest"),
      picked("molecules of a solid: it acts on the outer faces of cells all of whose nodes are among them", true)};
  load.check = [](const Body& body, const LoadValues& values) { faces_of_solid(body, values); };
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(std::make_unique<SurfaceForces>(model.body(), SurfaceLoad{.faces = faces_of_solid(model.body(), values),
                                                                        .pressure = false,
                                                                        .traction = values.vectors.at("traction"),
                                                                        .at_rest = true}));
  };
  return load;
}

LoadKind gas() {
  LoadKind load{
      {"gas",
       "a closed amount of gas within each closed surface of triangles, around those within it: p V^exponent stays",
       "",
       {}}};
  load.parameters = {
      optional("amount", dimension::energy,
               "absolute pressure times volume, n R T, of each closed surface; this or start_pressure"),
      optional("start_pressure", dimension::pressure, "absolute pressure in the volume at rest; this or amount"),
      {"exponent", dimension::none, 1, 2, 1, "1: constant temperature; 1.4: air without exchange of heat"},
      amount("ambient", dimension::pressure, "absolute pressure outside", 101325),
      picked("molecules: it fills what triangles enclose all of whose corners are among them; without it what any do")};
  load.check = [](const Body& body, const LoadValues& values) {
    if (values.has("amount") == values.has("start_pressure"))
      throw InputError("give one of amount (absolute pressure times volume, n R T) and start_pressure (absolute)");
    make_gas(body, values);
  };
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    for (std::unique_ptr<Load>& own : make_gas(model.body(), values)) model.add(std::move(own));
  };
  return load;
}

LoadKind floor_plane() {
  LoadKind load{
      {"floor", "a smooth plane that resists the molecules pressed into it, as spheres; no friction", "", {}}};
  load.parameters = {
      vector("point", dimension::length, "a point of the plane"), direction("normal", "normal towards the free side"),
      optional("stiffness", dimension::stiffness,
               "stiffness k for each molecule pressed in: beyond a depth d of a tenth of its radius r the force is "
               "k (d − r/20), and less before; without it E times the mean molecule's diameter"),
      amount("damping", dimension::damping, "damping for each molecule pressed in", 0)};
  load.add = [](Model& model, const LoadValues& values, const Material* material) {
    if (!values.has("stiffness") && !material)
      throw InputError("floor.stiffness is missing: nothing says what the body is made of");
    const Floor floor{
        values.vectors.at("point"), values.vectors.at("normal"),
        values.has("stiffness") ? values.numbers.at("stiffness") : default_floor_stiffness(model.body(), *material),
        values.numbers.at("damping")};
    model.add(make_floor(model.body(), floor));
    if (floor.damping > 0) model.add(make_floor_damping(model.body(), floor));
  };
  load.of_shares = true;
  return load;
}

LoadKind air() {
  const Air defaults;
  LoadKind load{{"air", "quadratic drag on each triangle by its own relative wind", "[Hoerner 1965]", {}}};
  ParameterInfo wind = vector("wind", dimension::velocity, "velocity of the air far away; still air without it");
  wind.required = false;
  load.parameters = {amount("density", dimension::density, "density of the air", defaults.density),
                     amount("drag_coefficient", dimension::none, "coefficient of the flow across a triangle",
                            defaults.drag_coefficient),
                     amount("skin_coefficient", dimension::none, "coefficient of the flow along a triangle",
                            defaults.skin_coefficient),
                     amount("pressure_coefficient", dimension::none, "coefficient of the air that a canopy has caught",
                            defaults.pressure_coefficient),
                     wind};
  load.check = [](const Body& body, const LoadValues&) {
    if (body.triangles.empty())
      throw InputError(
          "air drags on triangles and the body has none; stokes_drag and quadratic_drag work on molecules");
  };
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(make_air(model.body(), air_of(values)));
  };
  load.acts_at_rest = [](const LoadValues& values) { return air_of(values).wind.norm() > 0; };
  return load;
}

/// Molecules with radii by which they drag as the whole body does, each by its part of the mass; else the body's own.
/// Drag goes with radius^power.
Body dragging(const Body& body, const LoadValues& values, double power) {
  Body molecules;
  molecules.radius = body.radius;
  if (!values.has("body_radius")) return molecules;
  const double mass = sum_over(body, body.mass.head(owned_molecules(body)).sum());
  molecules.radius = values.numbers.at("body_radius") * (body.mass / mass).array().pow(1 / power);
  return molecules;
}
ParameterInfo body_radius() {
  return optional("body_radius", dimension::length,
                  "of a sphere that drags as the whole body does, shared by mass; without it every molecule drags as a "
                  "sphere of its own radius, and the sum depends on their number");
}

LoadKind stokes_drag() {
  LoadKind load{{"stokes_drag",
                 "ambient viscous friction F = -6 pi viscosity r V",
                 "[M03]",
                 {required("viscosity", dimension::viscosity, "viscosity of the medium"), body_radius()}}};
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(make_stokes_drag(dragging(model.body(), values, 1), values.numbers.at("viscosity")));
  };
  load.acts_at_rest = never_at_rest;
  load.of_shares = true;
  return load;
}

LoadKind quadratic_drag() {
  LoadKind load{{"quadratic_drag",
                 "ambient friction F = -1/2 density drag_coefficient pi r^2 |V| V",
                 "[M03, reading]",
                 {required("density", dimension::density, "density of the medium"),
                  required("drag_coefficient", dimension::none, "drag coefficient of a molecule; 0.47 of a sphere"),
                  body_radius()}}};
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(make_quadratic_drag(dragging(model.body(), values, 2), values.numbers.at("density"),
                                  values.numbers.at("drag_coefficient")));
  };
  load.acts_at_rest = never_at_rest;
  load.of_shares = true;
  return load;
}

LoadKind damping() {
  LoadKind load{{"damping",
                 "each connection resists its own lengthening",
                 "[M03]",
                 {required("coefficient", dimension::damping, "force over the speed of lengthening")}}};
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(make_damping(values.numbers.at("coefficient")));
  };
  load.acts_at_rest = never_at_rest;
  load.of_shares = true;
  return load;
}

LoadKind cell_damping() {
  LoadKind load{{"cell_damping",
                 "stress of each tetrahedron's strain rate",
                 "[L03]",
                 {required("bulk", dimension::viscosity, "bulk viscosity phi of the stress phi tr(rate) I"),
                  required("shear", dimension::viscosity, "shear viscosity psi of the stress 2 psi rate")}}};
  load.check = [](const Body& body, const LoadValues&) {
    if (!any_over(body, !body.tetrahedra.empty()))
      throw InputError("needs a body with tetrahedra; `damping` works on connections");
  };
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(make_cell_damping(model.body(), values.numbers.at("bulk"), values.numbers.at("shear")));
  };
  load.acts_at_rest = never_at_rest;
  load.of_shares = true;
  return load;
}

LoadKind rayleigh() {
  LoadKind load{{"rayleigh",
                 "F = -(mass M + stiffness K) V, K of the body at rest; a turning body is not damped by K",
                 "[Rayleigh 1877]",
                 {amount("mass", kRate, "rate alpha of the term M; this, stiffness or both", kNone),
                  amount("stiffness", dimension::time, "time beta of the term K; this, mass or both", kNone)}}};
  load.check = [](const Body&, const LoadValues& values) {
    if (!values.has("mass") && !values.has("stiffness"))
      throw InputError("give mass (a rate), stiffness (a time), or both");
  };
  load.add = [](Model& model, const LoadValues& values, const Material*) {
    const double rate = values.has("mass") ? values.numbers.at("mass") : 0;
    const double time = values.has("stiffness") ? values.numbers.at("stiffness") : 0;
    if (rate > 0) model.add(make_mass_damping(model.body(), rate));
    if (time > 0)
      for (const auto& law : model.elasticity()) model.add(make_stiffness_damping(model.body(), *law, time));
  };
  load.acts_at_rest = never_at_rest;
  load.of_shares = true;
  return load;
}

}  // namespace

const Table<LoadKind>& built_in_loads() {
  static const Table<LoadKind> table = [] {
    Table<LoadKind> rows("load");
    for (const auto row : {gravity, point, pressure, traction, gas, floor_plane, air, stokes_drag, quadratic_drag,
                           damping, cell_damping, rayleigh})
      rows.add(row());
    return rows;
  }();
  return table;
}

}  // namespace elastin
