// Models of FEBio: cubes with closed forms, what is refused, and where.

#include "febio/model.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "elastin/lab/study/laboratory.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

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
  std::string material = {};  ///< "type=\"…\">…" in place of the neo-Hookean one

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
      const std::string usual = "type=\"neo-Hookean\"><density>1</density><E>" + std::to_string(youngs_moduli[k]) +
                                "</E><v>" + poissons_ratio + "</v>";
      materials += "<material id=\"" + name + "\" name=\"m" + name + "\" " + (material.empty() ? usual : material) +
                   "</material>\n";
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
            "</quad4></Surface><Surface name=\"skin\">";
    for (const char* face : {"1,4,3,2", "5,6,7,8", "1,2,6,5", "2,3,7,6", "3,4,8,7", "4,1,5,8"})
      text += std::string("<quad4>") + face + "</quad4>";
    text += "</Surface></Mesh>\n<MeshDomains>" + domains + "</MeshDomains>\n<Boundary>\n";
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

TEST_CASE("what grows or is prestrained in FEBio goes where it is free of stress, or pulls", "[febio][rest]") {
  const std::string elastic = "<elastic type=\"neo-Hookean\"><density>1</density><E>1</E><v>0.3</v></elastic>",
                    grows = "<interpolate>LINEAR</interpolate><points><pt>0,1</pt><pt>1,1.1</pt></points>";
  const auto grown = [&](const std::string& growth) {
    return norm_of(
        {.curve = grows, .material = "type=\"kinematic growth\">" + elastic + "<growth " + growth + "</growth>"});
  };
  const std::string along = "<fiber type=\"vector\"><vector>0,0,1</vector></fiber>";
  CHECK(grown("type=\"volume growth\"><multiplier lc=\"1\">1</multiplier>") == Approx(std::sqrt(0.12)).epsilon(1e-8));
  CHECK(grown("type=\"fiber growth\"><multiplier lc=\"1\">1</multiplier>" + along) == Approx(0.2).epsilon(1e-8));
  CHECK(grown("type=\"general growth\"><iso lc=\"1\">1</iso><ani>0.9</ani>" + along) ==
        Approx(std::sqrt(0.08)).epsilon(1e-8));
  const auto prestrained = [&](const std::string& prestrain, const std::string& law) {
    return norm_of({.material = "type=\"prestrain elastic\">" + law + "<prestrain " + prestrain + "</prestrain>"});
  };
  const std::string third = "type=\"prestrain gradient\"><ramp lc=\"1\">1</ramp><F0>1,0,0,0,1,0,0,0,1.25</F0>";
  CHECK(prestrained(third, elastic) == Approx(2 * 0.2).epsilon(1e-8));
  // The closed form of a bar under nominal stress, for a bar that is already longer.
  CHECK(norm_of({.loads = kPull,
                 .material = "type=\"prestrain elastic\"><elastic type=\"neo-Hookean\"><E>1</E><v>0</v>"
                             "</elastic><prestrain " +
                             third + "</prestrain>"}) ==
        Approx(2 * std::abs((1 + elongation(0.1, 1)) / 1.25 - 1)).epsilon(1e-8));
  CHECK(grown("type=\"fiber growth\"><multiplier lc=\"1\">1</multiplier><fiber type=\"angles\"><theta>30</theta>"
              "<phi>0</phi></fiber>") == Approx(0.2).epsilon(1e-8));
  // Numbers of each cell, and a law that without fibres is the neo-Hookean one of mu = 2 c1 and lambda = k.
  const auto coupled = [](const std::string& fibres) {
    return "<elastic type=\"coupled trans-iso Mooney-Rivlin\"><c1>0.1923076923076923</c1><k>0.5769230769230769</k>" +
           fibres + "<fiber type=\"vector\"><vector>0,0,1</vector></fiber></elastic>";
  };
  const auto with_data = [&](const std::string& name, const std::string& set, const std::string& law) {
    return Tower{.loads = kPull,
                 .more = "<MeshData><ElementData name=\"F\" elem_set=\"" + set +
                         "\" data_type=\"mat3\"><e lid=\"1\">1,0,0,0,1,0,0,0,1.25</e></ElementData></MeshData>",
                 .material = "type=\"prestrain elastic\">" + law +
                             "<prestrain type=\"prestrain gradient\"><F0 type=\"map\">" + name + "</F0></prestrain>"};
  };
  const double plain = norm_of(
      {.loads = kPull, .material = "type=\"prestrain elastic\">" + elastic + "<prestrain " + third + "</prestrain>"});
  CHECK(norm_of(with_data("F", "p1", coupled(""))) == Approx(plain).epsilon(1e-9));
  CHECK(norm_of(with_data("F", "p1", coupled("<c3>1</c3><c4>2</c4><c5>3</c5><lam_max>1.1</lam_max>"))) > 1.1 * plain);
  CHECK_THROWS_WITH(run_of(with_data("G", "p1", elastic)), Contains("there is no <ElementData> 'G'"));
  CHECK_THROWS_WITH(run_of(with_data("F", "p2", elastic)), Contains("are not of all its cells"));
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

TEST_CASE("a force on a surface is spread over its area at rest", "[febio]") {
  CHECK(norm_of({.loads = "<surface_load surface=\"up\" type=\"force\"><scale lc=\"1\">2</scale>"
                          "<force>0,0,0.05</force></surface_load>"}) == Approx(2 * elongation(0.1, 1)).epsilon(1e-9));
}

TEST_CASE("a block of FEBio stretched to twice its size along two axes", "[febio]") {
  std::string nodes, cells, sets[5];
  for (int id = 1; id <= 27; ++id) {
    const int at[] = {(id - 1) % 3, (id - 1) / 3 % 3, (id - 1) / 9};
    nodes += "<node id=\"" + std::to_string(id) + "\">" + std::to_string(at[0] / 2.) + "," +
             std::to_string(at[1] / 2.) + "," + std::to_string(at[2] / 2.) + "</node>\n";
    const bool in[] = {at[0] == 0, at[1] == 0, at[2] == 0, at[0] == 2, at[1] == 2};
    for (int set = 0; set < 5; ++set)
      if (in[set]) sets[set] += (sets[set].empty() ? "" : ",") + std::to_string(id);
    if (at[0] == 2 || at[1] == 2 || at[2] == 2) continue;
    cells += "<elem id=\"" + std::to_string(id) + "\">";
    for (const int corner : {0, 1, 4, 3, 9, 10, 13, 12}) cells += (corner ? "," : "") + std::to_string(id + corner);
    cells += "</elem>\n";
  }
  std::string text =
      "<febio_spec version=\"4.0\"><Module type=\"solid\"/><Control><analysis>STATIC</analysis><time_steps>20"
      "</time_steps><step_size>0.05</step_size></Control><Material><material id=\"1\" name=\"M\" "
      "type=\"Mooney-Rivlin\"><c1>4</c1><c2>1</c2><k>4000</k></material></Material><Mesh><Nodes>" +
      nodes + "</Nodes><Elements type=\"hex8\" name=\"P\">" + cells + "</Elements>";
  for (int set = 0; set < 5; ++set)
    text += "<NodeSet name=\"s" + std::to_string(set) + "\">" + sets[set] + "</NodeSet>";
  text += "</Mesh><MeshDomains><SolidDomain name=\"P\" mat=\"M\"/></MeshDomains><Boundary>";
  for (const auto& [set, axis] : {std::pair{"s0", "x"}, {"s1", "y"}, {"s2", "z"}})
    text += std::string("<bc node_set=\"") + set + "\" type=\"zero displacement\"><" + axis + "_dof>1</" + axis +
            "_dof></bc>";
  for (const auto& [set, axis] : {std::pair{"s3", "x"}, {"s4", "y"}})
    text += std::string("<bc node_set=\"") + set + "\" type=\"prescribed displacement\"><dof>" + axis +
            "</dof><value lc=\"1\">1</value></bc>";
  text +=
      "</Boundary><LoadData><load_controller id=\"1\" type=\"loadcurve\"><points><pt>0,0</pt><pt>1,1</pt></points>"
      "</load_controller></LoadData></febio_spec>";
  const TemporaryFolder folder;
  const LaboratoryResult result = Laboratory(folder.write("block.feb", text)).run();
  REQUIRE(result.outcome == Outcome::converged);
  // W = c1 (J^(-2/3) I1 - 3) + c2 (J^(-4/3) I2 - 3) + K/2 ln² J at its least over the third stretch.
  const auto energy = [](double third) {
    const double J = 4 * third, I1 = 8 + third * third, I2 = 16 + 8 * third * third;
    return 4 * (std::pow(J, -2. / 3) * I1 - 3) + std::pow(J, -4. / 3) * I2 - 3 + 2000 * std::pow(std::log(J), 2);
  };
  double low = 0.2, high = 0.3;
  while (high - low > 1e-9) {
    const double a = low + (high - low) * 0.382, b = low + (high - low) * 0.618;
    (energy(a) < energy(b) ? high : low) = energy(a) < energy(b) ? b : a;
  }
  CHECK(result.get("energy") == Approx(energy(low)).epsilon(1e-9));
  CHECK(result.get("solution_norm") ==
        Approx(std::sqrt(9 * (0.25 + 0.25 + 1.25 * std::pow(1 - low, 2)))).epsilon(1e-6));
}

TEST_CASE("a load controller of FEBio may be a formula of the time", "[febio]") {
  const auto text_of = [](const std::string& formula) {
    Tower tower{.loads = kPull};
    std::string text = tower.text();
    const std::size_t at = text.find("type=\"loadcurve\"");
    return text.replace(at, text.find("</load_controller>") - at, "type=\"math\"><math>" + formula + "</math>");
  };
  const TemporaryFolder folder;
  const LaboratoryResult result = Laboratory(folder.write("tower.feb", text_of("2 * t ^ 2 * sin(pi * t / 6)"))).run();
  REQUIRE(result.outcome == Outcome::converged);
  CHECK(result.get("solution_norm") == Approx(2 * elongation(0.1, 1)).epsilon(1e-9));
  CHECK_THROWS_WITH(febio::load_model(folder.write("bad.feb", text_of("2 * T"))),
                    Contains("bad.feb:30: <math>: the formula '2 * T': there is no value 'T'"));
  CHECK_THROWS_WITH(febio::load_model(folder.write("bad.feb", text_of("1 / t"))), Contains("is not finite"));
}

namespace {

/// The tower whose last cube is rigid; `bcs` fix or prescribe it.
std::string with_rigid_top(const Tower& tower, const std::string& bcs, const std::string& centre = {}) {
  std::string text = tower.text();
  const std::string number = std::to_string(tower.youngs_moduli.size());
  const auto replace = [&](const std::string& from, const std::string& end, const std::string& to) {
    const std::size_t at = text.find(from), stop = text.find(end, at);
    text.replace(at, stop - at, to);
  };
  replace("<material id=\"" + number, "\n",
          "<material id=\"" + number + "\" name=\"m" + number + "\" type=\"rigid body\"><density>1</density>" + centre +
              "</material>");
  replace("<Loads>", "<Loads>", "<Rigid>" + bcs + "</Rigid>");
  return text;
}

std::string fixed(const std::string& dofs) {
  std::string text = "<rigid_bc type=\"rigid_fixed\"><rb>2</rb>";
  for (const char axis : dofs) text += std::string("<R") + axis + "_dof>1</R" + axis + "_dof>";
  return text + "</rigid_bc>";
}

}  // namespace

TEST_CASE("a rigid body of FEBio is where its motion says", "[febio]") {
  const TemporaryFolder folder;
  const std::string lift =
      "<rigid_bc type=\"rigid_displacement\"><rb>m2</rb><dof>z</dof><value lc=\"1\">0.5</value></rigid_bc>";
  // Pulled by 0.5 with Poisson's ratio 0 the cube below grows evenly: nothing else is free to move.
  const LaboratoryResult pulled =
      Laboratory(folder.write("a.feb", with_rigid_top({.youngs_moduli = {1, 1}}, fixed("xyuvw") + lift))).run();
  REQUIRE(pulled.outcome == Outcome::converged);
  CHECK(pulled.get("solution_norm") < 1e-9);
  CHECK(pulled.get("energy") == Approx((1.5 * 1.5 - 1) / 4 - std::log(1.5) / 2).epsilon(1e-9));
  for (int node = 4; node < 12; ++node) CHECK(pulled.positions(2, node) == Approx(node < 8 ? 1.5 : 2.5));

  // Turned by a third of a turn about (1, 1, 1) through its centre, with what hangs on it: no strain anywhere.
  std::string turn = fixed("xyz");
  for (const char axis : {'u', 'v', 'w'})
    turn += std::string("<rigid_bc type=\"rigid_rotation\"><rb>m2</rb><dof>R") + axis + "</dof><value lc=\"1\">" +
            std::to_string(2 * std::numbers::pi / 3 / std::sqrt(3.)) + "</value></rigid_bc>";
  for (const char* centre : {"", "<center_of_mass>0,0,0</center_of_mass>"}) {
    Tower free{.youngs_moduli = {1, 1}, .rollers = false};
    free.control =
        "<Control><analysis>STATIC</analysis><time_steps>8</time_steps><step_size>0.125</step_size></Control>";
    const LaboratoryResult turned = Laboratory(folder.write("b.feb", with_rigid_top(free, turn, centre))).run();
    REQUIRE(turned.outcome == Outcome::converged);
    CHECK(std::abs(turned.get("energy")) < 1e-12);
    const Vector3 about = *centre ? Vector3(0, 0, 0) : Vector3(0.5, 0.5, 1.5);
    const Vector3 corner = Vector3(1, 0, 0) - about;  // x to y to z to x
    CHECK((turned.positions.col(1) - about - Vector3(corner.z(), corner.x(), corner.y())).norm() < 1e-5);
  }

  // Nodes that a rigid body carries.
  Tower carried{.youngs_moduli = {1, 1, 1}};
  carried.boundary = "<bc node_set=\"seventh\" type=\"rigid\"><rb>m3</rb></bc>";
  std::string bcs = fixed("xyuvw") + lift;
  for (std::size_t at = 0; (at = bcs.find("<rb>", at)) != std::string::npos; ++at)
    bcs.replace(at + 4, 1 + (bcs[at + 4] == 'm'), "m3");
  const LaboratoryResult result = Laboratory(folder.write("c.feb", with_rigid_top(carried, bcs))).run();
  REQUIRE(result.outcome == Outcome::converged);
  CHECK(result.positions(2, 6) == Approx(1.5));

  for (const auto& [bad, why] : std::vector<std::pair<std::string, std::string>>{
           {fixed("xyuvw"), "<Rigid>: the rigid body 'm2' free along z is not supported"},
           {fixed("xyzuv"), "the rigid body 'm2' free to turn about z is not supported"},
           {"<rigid_bc type=\"rigid_fixed\"><rb>m1</rb></rigid_bc>", "<rb>: there is no rigid body 'm1'"},
           {"<rigid_load type=\"rigid_force\"/>", "<rigid_load>: is not supported in <Rigid>"}})
    CHECK_THROWS_WITH(febio::load_model(folder.write("d.feb", with_rigid_top({.youngs_moduli = {1, 1}}, bad))),
                      Contains(why));
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

TEST_CASE("a cube in vibration by generalised alpha, and by steps that keep its energy", "[febio]") {
  // The same cube has one unknown u: m = ρ/3, load ρ b/2, W = E/4 (λ² − 1 − 2 ln λ), P = E/2 (λ − 1/λ). The stepper of
  // [Chung & Hulbert 1993] with P of the state within the step; for a radius of 1 with ΔW/Δu in its place.
  const auto energy = [](double u) { return (std::pow(1 + u, 2) - 1) / 4 - std::log(1 + u) / 2; };
  const auto stress = [](double u) { return (1 + u - 1 / (1 + u)) / 2; };
  const double b = 0.1, dt = 0.2, m = 1. / 3;
  for (const double radius : {0., 0.5, 1.}) {
    const double of_force = 1 / (1 + radius), of_mass = (2 - radius) / (1 + radius), more = of_mass - of_force;
    const double beta = (1 + more) * (1 + more) / 4, gamma = 0.5 + more;
    double u = 0, v = 0, a = -b / 2 / m;
    for (int step = 0; step < 20; ++step) {
      const auto acceleration = [&](double next) {
        return (next - u - dt * v) / (beta * dt * dt) - (1 / (2 * beta) - 1) * a;
      };
      const auto left = [&](double next) {
        const double pull =
            radius == 1 ? (energy(next) - energy(u)) / (next - u) : stress(of_force * next + (1 - of_force) * u);
        return m * (of_mass * acceleration(next) + (1 - of_mass) * a) + pull + b / 2;
      };
      double low = u - 0.31, high = u + 0.3;
      while (high - low > 1e-14) (left((low + high) / 2) > 0 ? high : low) = (low + high) / 2;
      const double a_next = acceleration(low);
      v += dt * ((1 - gamma) * a + gamma * a_next), a = a_next, u = low;
    }
    const Tower tower{
        .control = dynamic(20, dt, "<rhoi>" + std::to_string(radius) + "</rhoi>"),
        .loads = "<body_load type=\"body force\"><force>0,0," + std::to_string(b) + "</force></body_load>"};
    INFO("radius " << radius);
    CHECK(norm_of(tower) == Approx(2 * std::abs(u)).epsilon(1e-7));
  }
}

TEST_CASE("a viscoelastic cube creeps as the standard linear solid does", "[febio]") {
  // σ = E ∫ (1 + g e^(−t/τ)) dε under a constant stress: ε = σ/E (1 − g/(1 + g) e^(−t/(τ (1 + g)))).
  const double g = 0.5, tau = 2, stress = 1e-5;
  const auto creep_of = [&](int steps, double size) {
    return norm_of({.control = "<Control><analysis>STATIC</analysis><time_steps>" + std::to_string(steps) +
                               "</time_steps><step_size>" + std::to_string(size) + "</step_size></Control>",
                    .loads = "<nodal_load node_set=\"top\" type=\"nodal_load\"><dof>z</dof><scale lc=\"1\">" +
                             std::to_string(stress / 4 * 1e5) + "e-5</scale></nodal_load>",
                    .curve = "<interpolate>STEP</interpolate><points><pt>0,0</pt><pt>1000,1</pt></points>",
                    .material = "type=\"viscoelastic\"><t1>2</t1><g1>0.5</g1><elastic type=\"neo-Hookean\"><E>1</E>"
                                "<v>0</v></elastic>"});
  };
  const auto expected = [&](double time) { return 2 * stress * (1 - g / (1 + g) * std::exp(-time / (tau * (1 + g)))); };
  CHECK(creep_of(1, 1e-6) == Approx(expected(0)).epsilon(1e-4));
  CHECK(creep_of(50, 0.04) == Approx(expected(2)).epsilon(5e-3));
  CHECK(creep_of(100, 0.02) == Approx(expected(2)).epsilon(2.5e-3));  // of order 1 behind a jump
  CHECK(creep_of(20, 5) == Approx(expected(100)).epsilon(1e-4));
}

TEST_CASE("an uncoupled viscoelastic cube is stiffer in shape alone at once", "[febio]") {
  const std::string load =
      "<nodal_load node_set=\"top\" type=\"nodal_load\"><dof>z</dof><scale lc=\"1\">0.1</scale></nodal_load>";
  const std::string curve = "<interpolate>STEP</interpolate><points><pt>0,0</pt><pt>1000,1</pt></points>";
  const auto plain = [&](const std::string& c1) {
    return norm_of(
        {.loads = load, .curve = curve, .material = "type=\"Mooney-Rivlin\"><k>3</k><c1>" + c1 + "</c1><c2>0</c2>"});
  };
  const auto relaxing = [&](const std::string& size) {
    return norm_of({.control = "<Control><analysis>STATIC</analysis><time_steps>30</time_steps><step_size>" + size +
                               "</step_size></Control>",
                    .loads = load,
                    .curve = curve,
                    .material = "type=\"uncoupled viscoelastic\"><k>2</k><t1>1</t1><g0>2</g0><g1>1</g1>"
                                "<elastic type=\"Mooney-Rivlin\"><k>1</k><c1>0.25</c1><c2>0</c2></elastic>"});
  };
  CHECK(relaxing("1e-9") == Approx(plain("0.75")).epsilon(1e-7));
  CHECK(relaxing("10") == Approx(plain("0.5")).epsilon(1e-7));
}

TEST_CASE("a volume that a surface encloses is kept from the step on that says so", "[febio]") {
  // Pressed to 0.9 with ν = 0, V = 0.9; back at its height the cube is √0.9 wide.
  const std::string control =
      "<Control><analysis>STATIC</analysis><time_steps>2</time_steps><step_size>0.5</step_size></Control>";
  Tower tower{.control = "",
              .boundary =
                  "<bc node_set=\"top\" type=\"prescribed displacement\"><dof>z</dof><value lc=\"1\">-0.1</value>"
                  "</bc>",
              .curve = "<points><pt>0,0</pt><pt>1,1</pt><pt>2,0</pt></points>"};
  const std::string constraint =
      "<Constraints><constraint surface=\"skin\" type=\"volume\"><laugon>1</laugon><augtol>1e-9</augtol>"
      "<penalty>-20</penalty></constraint></Constraints>";
  tower.more = "<Step><step id=\"1\">" + control + "</step><step id=\"2\">" + control + constraint + "</step></Step>";
  CHECK(norm_of(tower) == Approx(std::sqrt(8.) * (1 - std::sqrt(0.9))).epsilon(1e-7));
}

TEST_CASE("a body force of FEBio may be a formula, in FEBio's language", "[febio]") {
  const auto norm = [](const std::string& force) {
    return norm_of({.loads = "<body_load type=\"const\"><z" + force + "</z></body_load>"});
  };
  const double usual = norm(">0.1");
  CHECK(norm(" type=\"math\">0.1 * (log(100) - 2 ^ 2 ^ 3 / 64)") == Approx(usual).epsilon(1e-12));
  CHECK(norm(" type=\"math\">0.2 * X * ln(e)") > 1.01 * usual);  // the same force in all, more of it on one side
  for (const auto& [formula, why] : {std::pair{"0.1 * t", "there is no value 't'"},
                                     {"0.1 * (X", "a bracket is not closed"},
                                     {"1 / (X - X)", "is not finite everywhere"}})
    CHECK_THROWS_WITH(norm(std::string(" type=\"math\">") + formula),
                      Contains("tower.feb:29: <z>: the formula '" + std::string(formula) + "'") && Contains(why));
}

TEST_CASE("a model of FEBio takes a title, its solver and expectations", "[febio]") {
  const TemporaryFolder folder;
  const std::string model = folder.write("tower.feb", Tower{.loads = kPull}.text());
  const std::string value = std::to_string(2 * elongation(0.1, 1));
  const auto expected = [&](const std::string& more) {
    return folder.write("scene.yaml",
                        "model: tower.feb\ntitle: own\nsolver: {tolerance: 1e-6, linear_solver: direct}\n"
                        "expect: [{measure: solution_norm, value: " +
                            value + ", tolerance: 1e-5, source: closed form}]\n" + more);
  };
  for (const LaboratoryResult& result :
       {Laboratory(model, {"solver.linear_solver=direct", "solver.tolerance=1e-6"}).run(),
        Laboratory(expected("")).run()}) {
    REQUIRE(result.outcome == Outcome::converged);
    CHECK(result.get("solution_norm") == Approx(2 * elongation(0.1, 1)).epsilon(1e-5));
  }
  CHECK_THROWS_WITH(Laboratory(model, {"solver.tolerence=1"}), Contains("unknown key 'tolerence'"));
  CHECK_THROWS_WITH(Laboratory(model, {"material.youngs_modulus=1"}),
                    Contains("--set: material: ") &&
                        Contains("is a model of FEBio: of a scene's keys it takes title, solver and expect"));
  CHECK_THROWS_WITH(Laboratory(expected("loads: []\n")), Contains("scene.yaml:5:8: loads: ") && Contains("tower.feb"));
  CHECK_THROWS_WITH(Laboratory(model, {"solver.displacements=small"}),
                    Contains("solver.displacements: goes with no model of FEBio"));
  CHECK_THROWS_WITH(Laboratory(folder.write("none.yaml", "model: none.feb\n")), Contains("none.feb"));
  CHECK_THROWS_WITH(
      Laboratory(folder.write("none.yaml", "model: none.txt\n")),
      Contains("none.yaml:1:8: model: 'none.txt' is no model of another program; allowed: files that end with .feb"));
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
      febio::load_model(path);
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
  check("type=\"loadcurve\"", "type=\"PID\"", ":30: <load_controller>: type=\"PID\" is not supported");
  check("<LoadData>", "<Contact><contact type=\"sliding-elastic\"/></Contact><LoadData>",
        ":30: <contact>: type=\"sliding-elastic\" in <Contact> is not supported");
  check("<LoadData>",
        "<Constraints><constraint surface=\"up\" type=\"volume\"><penalty>-1</penalty></constraint></Constraints>"
        "<LoadData>",
        ":30: <constraint>: the surface 'up' is not closed");
  check("type=\"neo-Hookean\"><density>1</density>",
        "type=\"viscoelastic\"><elastic type=\"Mooney-Rivlin\"><k>1</k><c1>1</c1></elastic></material>"
        "<material id=\"2\" name=\"other\" type=\"neo-Hookean\">",
        ":5: <elastic>: type=\"Mooney-Rivlin\" in a material of type viscoelastic is not supported");
  check("<analysis>STATIC", "<analysis>EIGEN", ":3: <analysis>: 'EIGEN' is not supported");
  // What stands twice, in another file, or under an invalid number.
  check("id=\"1\">0,0,0<", "id=\"1a\">0,0,0<", ":8: <node>: '1a' is no whole number");
  check("<elem id=\"1\">", "<elem id=\"1a\">", ":17: <elem>: '1a' is no whole number");
  check("load_controller id=\"1\"", "load_controller id=\"1a\"", ":30: <load_controller>: '1a' is no whole number");
  check("<LoadData>",
        "<LoadData><load_controller id=\"1\" type=\"loadcurve\"><points><pt>0,0</pt></points></load_controller>",
        ":30: <load_controller>: id=\"1\" stands here twice");
  check("<NodeSet name=\"x\">", "<NodeSet name=\"x\">1</NodeSet><NodeSet name=\"x\">",
        ":18: <NodeSet>: name=\"x\" stands here twice");
  check("<Mesh>", "<Mesh from=\"other.feb\">", ":7: <Mesh>: a section in another file");
  check("<Boundary>\n",
        "<Boundary>\n<bc node_set=\"top\" type=\"prescribed displacement\"><dof>z</dof><value>1</value></bc>"
        "<bc node_set=\"seventh\" type=\"prescribed displacement\"><dof>z</dof><value>2</value></bc>",
        ":25: <bc>: a node of 'seventh' has a prescribed displacement along z already");
  check("</febio_spec>", "", ":30: no XML");
}
