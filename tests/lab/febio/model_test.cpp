// Models of FEBio: cubes with closed forms, what is refused, and where.

#include "lab/febio/model.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/lab/study/laboratory.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

/// Cubes of side 1 on each other along z on rollers, each with a material of its own, all of one Poisson's ratio: node
/// 4 k + 1 … 4 k + 4 lie at the height k. `loads` and `steps` go into the sections of these names.
struct Tower {
  std::vector<double> youngs_moduli{1};
  std::string control =
      "<Control><analysis>STATIC</analysis><time_steps>1</time_steps><step_size>1</step_size>"
      "</Control>";
  std::string boundary = {}, loads = {}, more = {};
  std::string curve = "<interpolate>LINEAR</interpolate><points><pt>0,0</pt><pt>1,1</pt></points>";
  bool rollers = true;
  std::string poissons_ratio = "0";

  std::string text() const {
    std::string nodes, cells, materials, domains, top;
    const int cubes = static_cast<int>(youngs_moduli.size());
    const char* corners[] = {"0,0", "1,0", "1,1", "0,1"};
    for (int k = 0; k <= cubes; ++k)
      for (int c = 0; c < 4; ++c)
        nodes +=
            "<node id=\"" + std::to_string(4 * k + c + 1) + "\">" + corners[c] + "," + std::to_string(k) + "</node>\n";
    for (int k = 0; k < cubes; ++k) {
      const std::string name = std::to_string(k + 1);
      std::string own;
      for (int c = 1; c <= 8; ++c) own += (c > 1 ? "," : "") + std::to_string(4 * k + c);
      cells +=
          "<Elements type=\"hex8\" name=\"p" + name + "\"><elem id=\"" + name + "\">" + own + "</elem></Elements>\n";
      materials += "<material id=\"" + name + "\" name=\"m" + name + "\" type=\"neo-Hookean\"><density>1</density><E>" +
                   std::to_string(youngs_moduli[static_cast<std::size_t>(k)]) + "</E><v>" + poissons_ratio +
                   "</v></material>\n";
      domains += "<SolidDomain name=\"p" + name + "\" mat=\"m" + name + "\"/>";
    }
    std::string sets[4] = {"", "", "1,2,3,4", ""};
    for (int k = 0; k <= cubes; ++k)
      for (int c = 1; c <= 4; ++c) {
        const std::string node = std::to_string(4 * k + c);
        if (c == 1 || c == 4) sets[0] += (sets[0].empty() ? "" : ",") + node;
        if (c == 1 || c == 2) sets[1] += (sets[1].empty() ? "" : ",") + node;
        if (k == cubes) sets[3] += (sets[3].empty() ? "" : ",") + node;
      }
    std::string text = "<?xml version=\"1.0\"?>\n<febio_spec version=\"4.0\"><Module type=\"solid\"/>\n" + control +
                       "\n<Material>\n" + materials + "</Material>\n<Mesh><Nodes name=\"all\">\n" + nodes +
                       "</Nodes>\n" + cells;
    const char* names[] = {"x", "y", "z", "top"};
    for (int s = 0; s < 4; ++s) text += "<NodeSet name=\"" + std::string(names[s]) + "\">" + sets[s] + "</NodeSet>\n";
    text += "<NodeSet name=\"seventh\">7</NodeSet><Surface name=\"up\"><quad4 id=\"1\">" + sets[3] +
            "</quad4></Surface></Mesh>\n<MeshDomains>" + domains + "</MeshDomains>\n<Boundary>\n";
    for (int s = 0; s < 3 && rollers; ++s)
      text += "<bc node_set=\"" + std::string(names[s]) + "\" type=\"zero displacement\"><" + names[s] + "_dof>1</" +
              names[s] + "_dof></bc>\n";
    return text + boundary + "</Boundary>\n<Loads>" + loads + "</Loads>\n" + more +
           "<LoadData><load_controller id=\"1\" type=\"loadcurve\">" + curve +
           "</load_controller></LoadData></febio_spec>\n";
  }
};

LaboratoryResult run_of(const Tower& tower) {
  const TemporaryFolder folder;
  return Laboratory(folder.write("tower.feb", tower.text())).run();
}

double norm_of(const Tower& tower) {
  const LaboratoryResult result = run_of(tower);
  INFO(result.cause);
  REQUIRE(result.outcome == Outcome::converged);
  return result.get("solution_norm");
}

const char* const kPull =
    "<nodal_load node_set=\"top\" type=\"nodal_load\"><dof>z</dof><scale lc=\"1\">0.025</scale></nodal_load>";

/// Stretch − 1 under the nominal stress P with Poisson's ratio 0: P = E/2 (λ − 1/λ).
double elongation(double stress, double youngs_modulus) {
  const double ratio = stress / youngs_modulus;
  return ratio + std::sqrt(ratio * ratio + 1) - 1;
}

std::string dynamic(int steps, double size, const std::string& solver = "") {
  return "<Control><analysis>DYNAMIC</analysis><time_steps>" + std::to_string(steps) + "</time_steps><step_size>" +
         std::to_string(size) + "</step_size><solver type=\"solid\">" + solver + "</solver></Control>";
}

}  // namespace

TEST_CASE("a cube of FEBio under a force has the closed form's displacements", "[febio]") {
  CHECK(norm_of({.loads = kPull}) == Approx(2 * elongation(0.1, 1)).epsilon(1e-9));
}

TEST_CASE("a tower of two materials: each cube as stiff as its own", "[febio]") {
  const double first = elongation(0.1, 1), second = elongation(0.1, 2.5);
  CHECK(norm_of({.youngs_moduli = {1, 2.5}, .loads = kPull}) ==
        Approx(2 * std::hypot(first, first + second)).epsilon(1e-9));
}

TEST_CASE("pressure, traction and nodal force on a face are the same load where its area stays", "[febio]") {
  const double expected = 2 * elongation(0.1, 1);
  for (const char* linear : {"0", "1"}) {
    const std::string how = std::string("<linear>") + linear + "</linear></surface_load>";
    CHECK(norm_of({.loads = "<surface_load surface=\"up\" type=\"pressure\"><pressure lc=\"1\">-0.1</pressure>" +
                            how}) == Approx(expected).epsilon(1e-9));
    CHECK(norm_of({.loads = "<surface_load surface=\"up\" type=\"traction\"><scale lc=\"1\">0.1</scale>"
                            "<traction>0,0,1</traction>" +
                            how}) == Approx(expected).epsilon(1e-9));
  }
  CHECK(norm_of({.loads = "<nodal_load node_set=\"top\" type=\"nodal_force\"><value lc=\"1\">0,0,0.025</value>"
                          "</nodal_load>"}) == Approx(expected).epsilon(1e-9));
}

TEST_CASE("prescribed displacements follow their load curves and are no part of the norm", "[febio]") {
  const std::string lift = "<bc node_set=\"top\" type=\"prescribed displacement\"><dof>z</dof><value lc=\"1\">";
  // Of two cubes pulled by 0.5 · 0.8 the middle rises by the half.
  Tower tower{.youngs_moduli = {1, 1}, .boundary = lift + "0.8</value></bc>"};
  tower.curve = "<interpolate>STEP</interpolate><extend>CONSTANT</extend><points><pt>0,0</pt><pt>0.9,0.5</pt></points>";
  CHECK(norm_of(tower) == Approx(2 * 0.2).epsilon(1e-9));
}

TEST_CASE("a linear constraint on a prescribed displacement prescribes another", "[febio]") {
  std::string boundary =
      "<bc node_set=\"top\" type=\"prescribed displacement\"><dof>z</dof><value lc=\"1\">0.5</value></bc>";
  for (int node = 5; node <= 8; ++node)
    boundary += "<bc type=\"linear constraint\"><dof>z</dof><node>" + std::to_string(node) +
                "</node><child_dof><dof>z</dof><node>9</node><value lc=\"1\">0.25</value></child_dof></bc>";
  // The middle is driven; what is free are the sides, which stay where they are without a Poisson's ratio.
  const LaboratoryResult result = run_of({.youngs_moduli = {1, 1}, .boundary = boundary});
  REQUIRE(result.outcome == Outcome::converged);
  CHECK(result.get("solution_norm") < 1e-9);
  CHECK(result.positions(2, 4) == Approx(1.125).epsilon(1e-12));
}

TEST_CASE("one cell pulled more on one side than on the other", "[febio]") {
  // Along x the edge at y = 1 is moved by 0.25 and that at y = 0 by twice as much; the other displacements are free.
  std::string boundary =
      "<bc node_set=\"seventh\" type=\"prescribed displacement\"><dof>x</dof><value lc=\"1\">0.25</value></bc>";
  for (const auto& [node, ratio] : {std::pair{"2", "2"}, {"3", "1"}, {"6", "2"}})
    boundary += std::string("<bc type=\"linear constraint\"><dof>x</dof><node>") + node +
                "</node><child_dof><dof>x</dof><node>7</node><value>" + ratio + "</value></child_dof></bc>";
  // Newton's method for the eight free displacements, written apart from this library: Piola's stress
  // mu (F - F^-T) + lambda ln J F^-T at 2 x 2 x 2 points, differences for the tangent, to a residual of 1e-15.
  CHECK(norm_of({.boundary = boundary, .poissons_ratio = "0.45"}) == Approx(0.4030765642808679).epsilon(1e-9));
}

TEST_CASE("a boundary condition of one step is released in the next", "[febio]") {
  const std::string control =
      "<Control><analysis>STATIC</analysis><time_steps>2</time_steps><step_size>0.5</step_size></Control>";
  Tower tower{.control = ""};
  tower.more = "<Step><step id=\"1\">" + control +
               "<Boundary><bc node_set=\"top\" type=\"prescribed displacement\"><dof>z</dof><value lc=\"1\">0.5</value>"
               "</bc></Boundary></step><step id=\"2\">" +
               control + "</step></Step>";
  const LaboratoryResult result = run_of(tower);
  REQUIRE(result.outcome == Outcome::converged);
  CHECK(result.get("solution_norm") < 1e-9);
  REQUIRE(result.curve.size() == 4);
}

TEST_CASE("a free cube falls by half g t^2: a body force acts against its own direction", "[febio]") {
  const LaboratoryResult result = run_of(
      {.control = dynamic(10, 0.1), .loads = "<body_load type=\"const\"><z>1</z></body_load>", .rollers = false});
  INFO(result.cause);
  REQUIRE(result.outcome == Outcome::converged);
  CHECK(result.get("solution_norm") == Approx(std::sqrt(8) / 2).epsilon(1e-9));
  CHECK(result.positions(2, 0) == Approx(-0.5).epsilon(1e-9));
}

TEST_CASE("a cube in vibration has the period of the trapezoidal rule with a consistent mass", "[febio]") {
  // One end fixed, one free: k = E, m = ρ/3, load ρ b/2; tan(ω′ Δt/2) = ω Δt/2 [Hughes 2000, ch. 9].
  const double b = 1e-5, dt = 0.2, w = std::sqrt(3.), discrete = 2 / dt * std::atan(w * dt / 2);
  for (const int steps : {3, 8, 20}) {
    const Tower tower{
        .control = dynamic(steps, dt),
        .loads = "<body_load type=\"body force\"><force>0,0," + std::to_string(b) + "</force></body_load>"};
    const double expected = 2 * b / 2 * (1 - std::cos(discrete * dt * steps));
    CHECK(norm_of(tower) == Approx(expected).epsilon(1e-4));  // what is not linear yet: b
  }
}

TEST_CASE("what is not supported in a model of FEBio is named with its line", "[febio]") {
  const auto message = [](Tower tower, const std::string& from, const std::string& to) {
    std::string text = tower.text();
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
    const TemporaryFolder folder;
    const std::string path = folder.write("bad.feb", text);
    try {
      load_febio_model(path);
    } catch (const InputError& error) {
      return std::string(error.what()).substr(path.size());
    }
    return std::string("nothing");
  };
  const Tower tower{.loads = kPull};
  const auto check = [&](const char* from, const char* to, const char* expected) {
    CHECK_THAT(message(tower, from, to), Catch::StartsWith(expected));
  };
  check("version=\"4.0\"", "version=\"3.0\"", ":2: <febio_spec>: version \"3.0\" is not supported");
  check("type=\"solid\"", "type=\"biphasic\"", ":2: <Module>: type=\"biphasic\" is not supported");
  check("neo-Hookean", "neo-hookean",
        ":5: <material>: a material of type \"neo-hookean\" is not supported; did you mean "
        "'neo-Hookean'?");
  check("<v>0</v>", "<v>0.5</v>", ":5: <v>: Poisson's ratio");
  check("<v>0</v>", "<v lc=\"1\">0</v>", ":5: <v>: the attribute lc=\"1\" is not supported");
  check("<v>0</v>", "<v>0</v><fibre/>", ":5: <fibre>: is not supported in a material");
  check("<E>1.000000</E>", "<E>one</E>", ":5: <E>: 'one' is no number");
  check("type=\"hex8\"", "type=\"hex9\"", ":17: <Elements>: the shape \"hex9\" is not supported");
  check("1,2,3,4,5,6,7,8</elem>", "1,2,3,4,5,6,7</elem>", ":17: <elem>: needs 8 nodes, not 7");
  check("1,2,3,4,5,6,7,8</elem>", "1,2,3,4,5,6,7,9</elem>", ":17: <elem>: there is no node 9");
  check("node_set=\"x\"", "node_set=\"w\"", ":25: <bc>: there is no NodeSet 'w'");
  check("zero displacement", "zero rotation", ":25: <bc>: type=\"zero rotation\" is not supported");
  check("type=\"nodal_load\"", "type=\"nodal_target\"", ":29: <nodal_load>: type=\"nodal_target\" is not supported");
  check("lc=\"1\">0.025", "lc=\"7\">0.025", ":29: <scale>: there is no load_controller 7");
  check("type=\"loadcurve\"", "type=\"math\"", ":30: <load_controller>: type=\"math\" is not supported");
  check("<LoadData>", "<Contact><contact type=\"sliding-elastic\"/></Contact><LoadData>",
        ":30: <contact>: type=\"sliding-elastic\" in <Contact> is not supported");
  check("<analysis>STATIC", "<analysis>EIGEN", ":3: <analysis>: 'EIGEN' is not supported");
  check("</febio_spec>", "", ":30: no XML");
}
