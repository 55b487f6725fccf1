#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "elastin/core/base/text.h"
#include "lab/export/formats.h"
#include "lab/report/page.h"

// Bodies with their constants as engines take them: a writer and a row each.

namespace elastin::lab {
namespace {

using Takes = ExportFormat::Takes;
using Files = std::vector<ExportedFile>;

/// Appends to a text; numbers are written with as many digits as they take.
class Text {
 public:
  template <class... Args>
  Text& operator()(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    return *this;
  }
  /// `each` writes an item; `between` stands between two.
  template <class Items, class Each>
  Text& list(const Items& items, const char* between, const Each& each) {
    bool first = true;
    for (const auto& item : items) {
      if (!first) text_ += between;
      first = false;
      each(item);
    }
    return *this;
  }
  operator std::string() && { return std::move(text_); }

 private:
  std::string text_;
};

std::vector<int> numbers(const ExportedBody& body) {
  std::vector<int> all(static_cast<std::size_t>(body.positions.cols()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  return all;
}

/// Which of x, y, z of each molecule are held.
Eigen::Array<bool, 3, Eigen::Dynamic> held_axes(const ExportedBody& body) {
  Eigen::Array<bool, 3, Eigen::Dynamic> held(3, body.positions.cols());
  held.setConstant(false);
  for (const Support& support : body.supports)
    for (int axis = 0; axis < 3; ++axis) held(axis, support.molecule) = is_held(support, axis);
  return held;
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Files json_files(const ExportedBody& body) { return {{body.name + ".json", json_of_body(body)}}; }

Files csv_files(const ExportedBody& body) {
  Text connections, molecules;
  connections("a,b,rest_length_m,stiffness_N_per_m,compliance_m_per_N\n");
  for (const auto& [a, b, length, stiffness] : body.connections)
    connections("{},{},{},{},{}\n", a, b, length, stiffness, 1 / stiffness);
  const bool starts = body.start.size() > 0;
  molecules("x_m,y_m,z_m,mass_kg,radius_m,fixed{}\n", starts ? ",start_x_m,start_y_m,start_z_m" : "");
  const auto held = held_axes(body);
  for (const int i : numbers(body)) {
    molecules("{},{},{},{},{},", body.positions(0, i), body.positions(1, i), body.positions(2, i), body.masses[i],
              body.radii[i]);
    for (int axis = 0; axis < 3; ++axis)
      if (held(axis, i)) molecules("{}", "xyz"[axis]);
    if (starts) molecules(",{},{},{}", body.start(0, i), body.start(1, i), body.start(2, i));
    molecules("\n");
  }
  return {{"connections.csv", std::move(connections)}, {"molecules.csv", std::move(molecules)}};
}

/// A folder with the body as JSON and a script that makes the engine's body of it.
Files scripted(const ExportedBody& body, const char* script) {
  return {{"body.json", json_of_body(body)}, {script, page_part(script)}};
}

Files jolt_files(const ExportedBody& body) { return scripted(body, "jolt.mjs"); }
Files rapier_files(const ExportedBody& body) { return scripted(body, "rapier.mjs"); }
Files newton_files(const ExportedBody& body) { return scripted(body, "newton_body.py"); }

/// Bonds of the energy K (r − r₀)², K = k/2; equal ones are of one type. The loads are properties of the atoms. [LAMMPS
/// manual, bond_style harmonic]
Files lammps_files(const ExportedBody& body) {
  std::map<std::pair<double, double>, int> types;
  for (const auto& one : body.connections) types.try_emplace({one.stiffness, one.rest_length}, 0);
  int last = 0;
  for (auto& [constants, type] : types) type = ++last;
  const Vector3 low = body.positions.rowwise().minCoeff(), high = body.positions.rowwise().maxCoeff();
  const double size = (high - low).norm();
  double longest = 0;
  for (const auto& one : body.connections) longest = std::max(longest, one.rest_length);
  Text data;
  data("{}: m, kg, s, N; harmonic bonds E = K (r - r0)^2, K = k/2 [N/m]\n\n", body.name);
  data("{} atoms\n{} bonds\n1 atom types\n{} bond types\n\n", body.positions.cols(), body.connections.size(),
       types.size());
  for (int axis = 0; axis < 3; ++axis)
    data("{} {} {}lo {}hi\n", low[axis] - size, high[axis] + size, "xyz"[axis], "xyz"[axis]);
  data("\nBond Coeffs # harmonic\n\n");
  for (const auto& [constants, type] : types) data("{} {} {}\n", type, constants.first / 2, constants.second);
  data("\nAtoms # hybrid bond sphere\n\n");  // number, type, x, y, z, molecule, diameter, density
  for (const int i : numbers(body))
    data("{} 1 {} {} {} 1 {} {}\n", i + 1, body.positions(0, i), body.positions(1, i), body.positions(2, i),
         2 * body.radii[i], body.masses[i] / (4 * M_PI / 3 * std::pow(body.radii[i], 3)));
  data("\nBonds\n\n");
  int number = 0;
  for (const auto& one : body.connections)
    data("{} {} {} {}\n", ++number, types.at({one.stiffness, one.rest_length}), one.a + 1, one.b + 1);
  data("\nLoads\n\n");
  for (const int i : numbers(body))
    data("{} {} {} {}\n", i + 1, body.forces(0, i), body.forces(1, i), body.forces(2, i));

  Text input;
  input(
      "# {}: the equilibrium under the scene's loads. forces.dump has x, y, z and the force on each atom [N]: on a "
      "held\n"
      "# one that of its bonds and its load, the reaction with the opposite sign.\n",
      body.name);
  input(
      "units si\natom_style hybrid bond sphere\natom_modify map array\nboundary m m m\nbond_style harmonic\n"
      "special_bonds lj/coul 1 1 1\ncomm_modify mode single cutoff {}\nneighbor {} bin\n",
      2 * longest, longest);
  input("fix loads all property/atom d_fx d_fy d_fz\nread_data body.data fix loads NULL Loads\nmass 1 1\n");
  std::array<std::vector<int>, 3> held;
  for (const Support& support : body.supports)
    for (int axis = 0; axis < 3; ++axis)
      if (is_held(support, axis)) {
        held[axis].push_back(support.molecule + 1);
        if (support.displacement[axis] != 0)
          input("set atom {} {} {}\n", support.molecule + 1, "xyz"[axis],
                body.positions(axis, support.molecule) + support.displacement[axis]);
      }
  input("compute loads all property/atom d_fx d_fy d_fz\n");
  for (int axis = 0; axis < 3; ++axis) input("variable f{} atom c_loads[{}]\n", "xyz"[axis], axis + 1);
  input(
      "variable work atom -(c_loads[1]*x+c_loads[2]*y+c_loads[3]*z)\n"
      "fix load all addforce v_fx v_fy v_fz energy v_work\nfix_modify load energy yes\n");
  constexpr std::array<const char*, 3> kZero{"0 NULL NULL", "NULL 0 NULL", "NULL NULL 0"};
  std::string freed;
  for (int axis = 0; axis < 3; ++axis)
    if (!held[axis].empty()) {
      input("group h{0} id {1}\nfix h{0} h{0} setforce {2}\n", "xyz"[axis], fmt::join(held[axis], " &\n"), kZero[axis]);
      freed += fmt::format("unfix h{}\n", "xyz"[axis]);
    }
  input(
      "min_style cg\nmin_modify dmax {} line quadratic\nthermo 1000\n"
      "thermo_modify norm no lost ignore format float %.15g\nminimize 0 {} 200000 400000\n{}run 0\n"
      "write_dump all custom forces.dump id x y z fx fy fz modify sort id format float %.15g\n",
      0.1 * longest, 1e-9 * body.forces.norm() + 1e-12, freed);
  return {{"body.data", std::move(data)}, {"in.body", std::move(input)}};
}

/// Bodies of one molecule each, which slide along the axes in which they are free, joined by tendons with a stiffness;
/// of a law of cells a flex with E and nu. The energy of a flex of tetrahedra has twice the lambda of these: it gets
/// those of which mu and 2 lambda are the material's.                    [MuJoCo XML reference; user_mesh.cc,
/// MetricTensor]
Files mujoco_files(const ExportedBody& body) {
  const auto held = held_axes(body);
  Text text;
  text(
      "<mujoco model=\"{}\">\n  <!-- m, kg, s, N. Stiffness of a tendon: k [N/m]; of a flex: E [Pa], nu. -->\n"
      "  <option gravity=\"0 0 0\" timestep=\"0.001\" integrator=\"discrete\"/>\n  <worldbody>\n",
      escaped(body.name));
  for (const int i : numbers(body)) {
    const double inertia = 0.4 * body.masses[i] * body.radii[i] * body.radii[i];
    text("    <body name=\"m{}\" pos=\"{} {} {}\"><inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{} {} {}\"/>", i,
         body.positions(0, i), body.positions(1, i), body.positions(2, i), body.masses[i], inertia, inertia, inertia);
    for (int axis = 0; axis < 3; ++axis)
      if (!held(axis, i))
        text("<joint type=\"slide\" axis=\"{} {} {}\"/>", axis == 0 ? 1 : 0, axis == 1 ? 1 : 0, axis == 2 ? 1 : 0);
    if (!body.connections.empty()) text("<site name=\"s{}\"/>", i);
    text("</body>\n");
  }
  text("  </worldbody>\n");
  if (!body.connections.empty()) {
    text("  <tendon>\n");
    for (const auto& [a, b, length, stiffness] : body.connections)
      text("    <spatial stiffness=\"{}\" springlength=\"{}\"><site site=\"s{}\"/><site site=\"s{}\"/></spatial>\n",
           stiffness, length, a, b);
    text("  </tendon>\n");
  } else {
    std::map<std::pair<double, double>, std::vector<const ExportedBody::Cell*>> by_moduli;
    for (const auto& cell : body.tetrahedra) by_moduli[{cell.youngs_modulus, cell.poissons_ratio}].push_back(&cell);
    text("  <deformable>\n");
    int number = 0;
    for (const auto& [moduli, cells] : by_moduli) {
      const double poisson = moduli.second / (2 * (1 - moduli.second));
      text("    <flex name=\"cells{}\" dim=\"3\" radius=\"0.001\" body=\"", ++number);
      text.list(numbers(body), " ", [&](int i) { text("m{}", i); });
      text("\" element=\"");
      text.list(cells, " ", [&](const auto* cell) { text("{}", fmt::join(cell->nodes, " ")); });
      text(
          "\"><contact selfcollide=\"none\" internal=\"false\" contype=\"0\" conaffinity=\"0\"/>"
          "<elasticity young=\"{}\" poisson=\"{}\"/></flex>\n",
          moduli.first * (1 + poisson) / (1 + moduli.second), poisson);
    }
    text("  </deformable>\n");
  }
  text("</mujoco>\n");
  return {{"body.xml", std::move(text)}};
}

/// A link of Bullet takes out the fraction kLST of its error in each of n iterations a step. At rest under a force it
/// is a spring of k = ((1 − kLST)⁻ⁿ − 1) / ((w_a + w_b) Δt²), w = 1/m; solved for kLST.     [Bullet,
/// btSoftBody::PSolve_Links]
Files bullet_files(const ExportedBody& body) {
  Text text;
  text(
      "// {}: m, kg, s, N. Stiffness of a link, 0 to 1, from k [N/m], the time step and the iterations:\n"
      "// 1 - (1 + k (1/m_a + 1/m_b) dt^2)^(-1/iterations). Link with BulletSoftBody BulletDynamics LinearMath.\n",
      body.name);
  text(
      "#include <BulletSoftBody/btSoftBody.h>\n#include <cmath>\n\n"
      "static const struct {{ double x, y, z, mass; }} molecules[] = {{\n");
  for (const int i : numbers(body))
    text("  {{{}, {}, {}, {}}},\n", body.positions(0, i), body.positions(1, i), body.positions(2, i), body.masses[i]);
  text("}};\nstatic const struct {{ int a, b; double rest_length, stiffness; }} connections[] = {{\n");
  for (const auto& [a, b, length, stiffness] : body.connections)
    text("  {{{}, {}, {}, {}}},\n", a, b, length, stiffness);
  text("}};\nstatic const int held[] = {{");
  for (const Support& support : body.supports) text("{}, ", support.molecule);
  text("-1}};\n\n");
  text(R"(/// The body for steps of dt [s]; it is the caller's.
btSoftBody* make_body(btSoftBodyWorldInfo& world, double dt, int iterations) {{
  btAlignedObjectArray<btVector3> places;
  btAlignedObjectArray<btScalar> masses;
  for (const auto& one : molecules) {{
    places.push_back(btVector3(btScalar(one.x), btScalar(one.y), btScalar(one.z)));
    masses.push_back(btScalar(one.mass));
  }}
  btSoftBody* body = new btSoftBody(&world, places.size(), &places[0], &masses[0]);
  for (const int* molecule = held; *molecule >= 0; ++molecule) body->setMass(*molecule, 0);
  for (const auto& one : connections) {{
    const double weight = body->m_nodes[one.a].m_im + body->m_nodes[one.b].m_im;
    btSoftBody::Material* material = body->appendMaterial();
    material->m_kLST = btScalar(1 - std::pow(1 + one.stiffness * weight * dt * dt, -1.0 / iterations));
    if (!(weight > 0) || !(material->m_kLST > 0)) continue;
    body->appendLink(one.a, one.b, material);
    body->m_links[body->m_links.size() - 1].m_rl = btScalar(one.rest_length);
  }}
  body->updateLinkConstants();
  body->m_cfg.piterations = iterations;
  body->m_cfg.kDP = 0;
  return body;
}}
)");
  return {{"body.cpp", std::move(text)}};
}

/// "a b k damping rest_length" of each spring.                                  [SOFA, SpringForceField, data `spring`]
Files sofa_files(const ExportedBody& body) {
  const auto held = held_axes(body);
  Text text;
  text("<?xml version=\"1.0\"?>\n<!-- m, kg, s, N, Pa -->\n");
  text("<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\">\n");
  for (const char* plugin :
       {"LinearSolver.Iterative", "Mass", "ODESolver.Backward", "SolidMechanics.Spring", "SolidMechanics.FEM.Elastic",
        "StateContainer", "Topology.Container.Dynamic", "Constraint.Projective"})
    text("  <RequiredPlugin name=\"Sofa.Component.{}\"/>\n", plugin);
  text(
      "  <DefaultAnimationLoop/>\n  <Node name=\"body\">\n    <EulerImplicitSolver/>\n"
      "    <CGLinearSolver iterations=\"1000\" tolerance=\"1e-12\" threshold=\"1e-12\"/>\n"
      "    <MechanicalObject name=\"molecules\" template=\"Vec3\" position=\"");
  text.list(numbers(body), "  ",
            [&](int i) { text("{} {} {}", body.positions(0, i), body.positions(1, i), body.positions(2, i)); });
  text("\"/>\n");
  if (body.connections.empty()) {
    text("    <TetrahedronSetTopologyContainer tetrahedra=\"");
    text.list(body.tetrahedra, "  ", [&](const auto& cell) { text("{}", fmt::join(cell.nodes, " ")); });
    text("\"/>\n    <TetrahedronFEMForceField template=\"Vec3\" method=\"large\" poissonRatio=\"{}\" youngModulus=\"",
         body.tetrahedra.front().poissons_ratio);
    text.list(body.tetrahedra, " ", [&](const auto& cell) { text("{}", cell.youngs_modulus); });
    text("\"/>\n");
  } else {
    text("    <PointSetTopologyContainer nbPoints=\"{}\"/>\n", body.positions.cols());
    text("    <SpringForceField template=\"Vec3\" spring=\"");
    text.list(body.connections, "  ",
              [&](const auto& one) { text("{} {} {} 0 {}", one.a, one.b, one.stiffness, one.rest_length); });
    text("\"/>\n");
  }
  text("    <DiagonalMass vertexMass=\"");
  text.list(numbers(body), " ", [&](int i) { text("{}", body.masses[i]); });
  text("\"/>\n");
  for (const Support& support : body.supports)
    text("    <PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"{} {} {}\"/>\n", support.molecule,
         +held(0, support.molecule), +held(1, support.molecule), +held(2, support.molecule));
  text("  </Node>\n</Node>\n");
  return {{"body.scn", std::move(text)}};
}

/// Points, the springs as curves with their constants, and the tetrahedra of a deformable body.   [OpenUSD; UsdGeom]
Files usd_files(const ExportedBody& body) {
  Text text;
  const auto array = [&](const char* type, const char* name, const auto& items, const auto& each) {
    text("    {} {} = [", type, name);
    text.list(items, ", ", each);
    text("]\n");
  };
  const auto point = [&](int i) {
    text("({}, {}, {})", body.positions(0, i), body.positions(1, i), body.positions(2, i));
  };
  text("#usda 1.0\n(\n  defaultPrim = \"body\"\n  metersPerUnit = 1\n  kilogramsPerUnit = 1\n  doc = {}\n)\n\n",
       quoted(body.name + ": constants of " + body.strategy + ", in m, kg, s, N, Pa"));
  text("def Xform \"body\"\n{{\n  def Points \"molecules\"\n  {{\n");
  array("point3f[]", "points", numbers(body), point);
  array("float[]", "widths", numbers(body), [&](int i) { text("{}", 2 * body.radii[i]); });
  array("custom double[]", "elastin:mass", numbers(body), [&](int i) { text("{}", body.masses[i]); });
  array("custom int[]", "elastin:fixed", body.supports, [&](const Support& one) { text("{}", one.molecule); });
  text("  }}\n");
  if (!body.connections.empty()) {
    text("  def BasisCurves \"connections\"\n  {{\n    uniform token type = \"linear\"\n");
    array("int[]", "curveVertexCounts", body.connections, [&](const auto&) { text("2"); });
    array("point3f[]", "points", body.connections, [&](const auto& one) {
      point(one.a);
      text(", ");
      point(one.b);
    });
    array("custom int2[]", "elastin:ends", body.connections, [&](const auto& one) { text("({}, {})", one.a, one.b); });
    array("custom double[]", "elastin:restLength", body.connections,
          [&](const auto& one) { text("{}", one.rest_length); });
    array("custom double[]", "elastin:stiffness", body.connections,
          [&](const auto& one) { text("{}", one.stiffness); });
    text("  }}\n");
  }
  if (!body.tetrahedra.empty()) {
    text("  def TetMesh \"cells\"\n  {{\n");
    array("point3f[]", "points", numbers(body), point);
    array("int4[]", "tetVertexIndices", body.tetrahedra,
          [&](const auto& cell) { text("({})", fmt::join(cell.nodes, ", ")); });
    array("custom double[]", "elastin:youngsModulus", body.tetrahedra,
          [&](const auto& cell) { text("{}", cell.youngs_modulus); });
    array("custom double[]", "elastin:poissonsRatio", body.tetrahedra,
          [&](const auto& cell) { text("{}", cell.poissons_ratio); });
    text("  }}\n");
  }
  text("}}\n");
  return {{"body.usda", std::move(text)}};
}

std::string readme(const ExportFormat& format, const ExportedBody& body) {
  double stiffness = 0, strongest = 0;
  for (const auto& one : body.connections) {
    stiffness += one.stiffness;
    strongest = std::max(strongest, one.stiffness * (1 / body.masses[one.a] + 1 / body.masses[one.b]));
  }
  Text text;
  text("# {} for {}\n\n{}; constants of the strategy `{}`.\n", body.name, format.name,
       body.title.empty() ? body.name : body.title, body.strategy);
  text("* {}, {}, {}; mass {:.9g} kg.\n", counted(body.positions.cols(), "molecule"),
       counted(static_cast<std::ptrdiff_t>(body.connections.size()), "connection"),
       counted(static_cast<std::ptrdiff_t>(body.cells.size()), "cell"), body.masses.sum());
  text("* Units: m, kg, s, N, Pa. Numbers of molecules begin with 0 unless the engine's begin with 1.\n");
  text("* Constants: {}\n", format.constants);
  if (!body.connections.empty()) {
    text("* The sum of all spring constants is {:.12g} N/m: compare it with what the engine has read.\n", stiffness);
    text(
        "* Time steps: explicit integration is stable below {:.3g} s. A position-based solver delivers the constants "
        "only where its iterations converge: k dt^2 (1/m_a + 1/m_b) is up to {:.3g} at 1/60 s; far above 1 use "
        "smaller steps before more iterations.\n",
        body.explicit_step, strongest / 3600);
  }
  text("* Solver: {}\n", format.advice);
  text(
      "* Not in these files: fibres, volume terms, curves and laws beyond small strain, relaxation, softening, "
      "contact.\n");
  const bool drives = std::any_of(body.supports.begin(), body.supports.end(),
                                  [](const Support& support) { return !support.displacement.isZero(0); });
  if (!format.writes_loads && (drives || !body.forces.isZero(0)))
    text("* Not in these files either: {} of the experiment; `--to json` writes them.\n",
         !drives                 ? "the forces"
         : body.forces.isZero(0) ? "the prescribed displacements"
                                 : "the forces and the prescribed displacements");
  for (const std::string& note : body.notes) text("* Of this scene: {}.\n", note);
  const std::vector<std::string> driven = engines().names();
  const bool has_driver = std::find(driven.begin(), driven.end(), format.name) != driven.end();
  text("* Measure what the engine makes of them: `elastin compare SCENE {}`.\n",
       has_driver ? "--engines " + format.name : "--engine COMMAND");
  return text;
}

}  // namespace

std::string json_of_body(const ExportedBody& body) {
  const auto held = held_axes(body);
  Text text;
  text(
      "{{\"format\": \"elastin body\", \"version\": 1, \"units\": \"m, kg, s, N, Pa\",\n"
      "\"name\": {}, \"title\": {}, \"strategy\": {},\n\"positions\": [\n",
      quoted(body.name), quoted(body.title), quoted(body.strategy));
  text.list(numbers(body), ",\n",
            [&](int i) { text("[{}, {}, {}]", body.positions(0, i), body.positions(1, i), body.positions(2, i)); });
  if (body.start.size() > 0) {
    text("],\n\"start\": [\n");
    text.list(numbers(body), ",\n",
              [&](int i) { text("[{}, {}, {}]", body.start(0, i), body.start(1, i), body.start(2, i)); });
  }
  text("],\n\"masses\": [{}],\n\"radii\": [{}],\n\"connections\": [\n", fmt::join(body.masses, ", "),
       fmt::join(body.radii, ", "));
  text.list(body.connections, ",\n", [&](const auto& one) {
    text("{{\"a\": {}, \"b\": {}, \"rest_length\": {}, \"stiffness\": {}}}", one.a, one.b, one.rest_length,
         one.stiffness);
  });
  const auto cells = [&](const char* name, const std::vector<ExportedBody::Cell>& all) {
    text("],\n\"{}\": [\n", name);
    text.list(all, ",\n", [&](const auto& cell) {
      text("{{\"shape\": \"{}\", \"nodes\": [{}], \"youngs_modulus\": {}, \"poissons_ratio\": {}, \"density\": {}}}",
           cell.kind->name, fmt::join(cell.nodes, ", "), cell.youngs_modulus, cell.poissons_ratio, cell.density);
    });
  };
  cells("cells", body.cells);
  cells("tetrahedra", body.tetrahedra);
  text("],\n\"thickness\": {},\n\"supports\": [\n", body.thickness);
  text.list(body.supports, ",\n", [&](const Support& support) {
    const int i = support.molecule;
    text("{{\"molecule\": {}, \"fixed\": [{}, {}, {}], \"displacement\": [{}, {}, {}]}}", i, held(0, i), held(1, i),
         held(2, i), support.displacement[0], support.displacement[1], support.displacement[2]);
  });
  text("],\n\"forces\": [\n");
  std::vector<int> loaded = numbers(body);
  std::erase_if(loaded, [&](int i) { return body.forces.col(i).isZero(0); });
  text.list(loaded, ",\n", [&](int i) {
    text("{{\"molecule\": {}, \"force\": [{}, {}, {}]}}", i, body.forces(0, i), body.forces(1, i), body.forces(2, i));
  });
  text("],\n\"notes\": [");
  text.list(body.notes, ", ", [&](const std::string& note) { text("{}", quoted(note)); });
  text("]}}\n");
  return text;
}

/// Some engines have one E or nu for all cells.
void check_moduli(const std::string& scene, const ExportFormat& format, const std::vector<ExportedBody::Cell>& cells) {
  const auto several = [&](double ExportedBody::Cell::*modulus) {
    return std::any_of(cells.begin(), cells.end(),
                       [&](const auto& cell) { return cell.*modulus != cells.front().*modulus; });
  };
  const std::string own = (format.one_youngs_modulus && several(&ExportedBody::Cell::youngs_modulus))   ? "E"
                          : (format.one_poissons_ratio && several(&ExportedBody::Cell::poissons_ratio)) ? "nu"
                                                                                                        : "";
  if (!own.empty())
    throw InputError(scene + format.name + " has one " + own +
                     " for all cells of a body, and these have several: choose a spring rule, --strategy standard …; "
                     "json, mujoco, newton and usd take several");
}

std::vector<ExportedFile> engine_files(const ExportFormat& format, const ExportedBody& body) {
  const std::string scene = body.name + ", '" + body.strategy + "': ";
  if (format.takes == Takes::connections && body.connections.empty())
    throw InputError(scene + format.name +
                     " takes spring constants, and this strategy has none; a spring rule has: "
                     "--strategy lattice, --strategy calibrated:standard …");
  if (body.connections.empty() && body.tetrahedra.empty() && format.name != "json")
    throw InputError(scene + format.name + " takes spring constants or tetrahedra, and the body has neither");
  const auto negative = std::count_if(body.connections.begin(), body.connections.end(),
                                      [](const auto& one) { return one.stiffness < 0; });
  if (negative > 0 && !format.takes_negative)
    throw InputError(scene + counted(negative, "spring constant is", "spring constants are") + " negative, and " +
                     format.name + " has no springs like that; json, csv, lammps, sofa and mujoco have");
  if (body.connections.empty()) check_moduli(scene, format, body.tetrahedra);
  std::vector<ExportedFile> files = format.files(body);
  files.push_back({"README.md", readme(format, body)});
  return files;
}

void add_engine_formats(elastin::Table<ExportFormat>& rows) {
  const auto add = [&](const char* name, const char* summary, const char* source, Files (*files)(const ExportedBody&),
                       Takes takes, bool negative, bool loads, const char* constants, const char* advice) {
    const bool rapier = std::string(name) == "rapier", sofa = std::string(name) == "sofa";
    rows.add({{name, summary, source},
              "",
              nullptr,
              files,
              takes,
              negative,
              loads,
              rapier,
              rapier || sofa,
              constants,
              advice});
  };
  add("json", "constants and cells of the body, as JSON for any program", "scenes/README.md", json_files, Takes::either,
      true, true, "`stiffness` of each connection [N/m]; `youngs_modulus` [Pa] and `poissons_ratio` of each cell.",
      "this file is what `elastin compare --engine` hands to an engine.");
  add("csv", "constants of the connections as CSV, with their compliance", "scenes/README.md", csv_files,
      Takes::connections, true, false, "stiffness k [N/m] and compliance 1/k [m/N] of each connection.",
      "engines that take a compliance need 1/k as it stands, and divide by dt^2 themselves.");
  add("lammps", "data and input files of LAMMPS, harmonic bonds", "LAMMPS manual", lammps_files, Takes::connections,
      true, true, "K = k/2 [N/m] in harmonic bonds, E = K (r - r0)^2.",
      "`lmp -in in.body` finds the equilibrium by conjugate gradients and writes forces.dump.");
  add("mujoco", "model of MuJoCo: tendons, or a flex of cells", "MuJoCo XML reference", mujoco_files, Takes::either,
      true, false, "`stiffness` of each tendon [N/m]; of a law of cells `young` [Pa] and `poisson` of a flex.",
      "springs are forces of the smooth dynamics: they are exact at rest, and stable in small steps; `damping` on the "
      "joints brings the body to rest.");
  add("jolt", "soft body of Jolt, compliance of its edges", "Jolt Physics, SoftBodySharedSettings", jolt_files,
      Takes::connections, false, true, "`mCompliance` = 1/k [m/N] of each edge.",
      "`mNumIterations` (5 by default) are substeps of one pass each: more of them deliver stiffer bodies. Molecules "
      "that are held along some axes are held along all.");
  add("rapier", "soft body of Rapier: edges, or cells with E and nu", "Rapier, SoftBodyDesc", rapier_files,
      Takes::either, false, true,
      "natural frequency of each edge, sqrt(k (1/m_a + 1/m_b)) / 2 pi [Hz]; of a law of cells E [Pa] and nu.",
      "`numSolverIterations` are its substeps; the solver `Fem`, which cells can have, does not depend on them. "
      "Molecules that are held along some axes are held along all.");
  add("bullet", "soft body of Bullet, stiffness of its links", "Bullet, btSoftBody", bullet_files, Takes::connections,
      false, false,
      "`m_kLST` of each link, 0 to 1 without a unit: 1 - (1 + k (1/m_a + 1/m_b) dt^2)^(-1/iterations), which is made "
      "for one time step and one number of iterations.",
      "another time step needs another m_kLST: call `make_body` again. Molecules that are held along some axes are "
      "held along all.");
  add("sofa", "scene of SOFA: springs, or cells with E and nu", "SOFA, SpringForceField", sofa_files, Takes::either,
      true, false,
      "k [N/m] of each spring (a, b, k, damping, rest length); of a law of cells `youngModulus` [Pa], `poissonRatio`.",
      "EulerImplicitSolver is stable in any step; its damping goes with the step, its equilibrium does not.");
  add("newton", "particles of Newton (Warp): springs, or tetrahedra", "Newton, ModelBuilder", newton_files,
      Takes::either, false, true,
      "`ke` of each spring [N/m]; of a law of cells mu and lambda [Pa] of each tetrahedron.",
      "the solver VBD or a semi-implicit one takes ke as it stands; XPBD as compliance. Molecules that are held along "
      "some axes are held along all.");
  add("usd", "OpenUSD: points, springs as curves, tetrahedra", "OpenUSD, UsdGeom", usd_files, Takes::either, true,
      false,
      "`elastin:stiffness` [N/m] of the curves; `elastin:youngsModulus` [Pa] and `elastin:poissonsRatio` of the cells.",
      "USD has no springs of its own: the importer reads the attributes that begin with `elastin:`.");
}

}  // namespace elastin::lab
