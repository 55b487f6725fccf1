#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/neo_hookean_log.h"
#include "core/laws/solids/ogden.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "core/laws/solids/transversely_isotropic.h"
#include "core/laws/solids/yeoh.h"
#include "elastin/core/base/text.h"
#include "elastin/core/laws/material_law.h"
#include "lab/export/formats.h"
#include "lab/export/problem.h"

namespace elastin::lab {
namespace {

using Numbers = std::vector<int>;
/// A number and how it goes with time, by the number of a load controller; 0: it does not change.
struct Course {
  double scale = 0;
  int controller = 0;
  auto operator<=>(const Course&) const = default;
};

class FebioDeck : Deck {
 public:
  explicit FebioDeck(const StaticProblem& problem) : Deck("FEBio", problem), problem_(problem) {}

  std::string text() {
    if (problem_.small)
      refuse(
          "it knows large displacements alone, and the scene has `displacements: small`; --set "
          "solver.displacements=large");
    write("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<febio_spec version=\"4.0\">\n<Module type=\"solid\"/>\n");
    write("<Control><analysis>STATIC</analysis><time_steps>{}</time_steps><step_size>1</step_size></Control>\n",
          problem_.steps.size());
    write("<Material>\n");
    for (std::size_t i = 0; i < problem_.materials.size(); ++i)
      problem_.growths.empty() ? write_material(i) : write_growing(i);
    write("</Material>\n");
    const std::string boundary = boundary_text(), loads = loads_text();  // they collect sets and curves
    write_mesh();
    write_domains();
    write("<Boundary>\n{}</Boundary>\n<Loads>\n{}</Loads>\n", boundary, loads);
    write_curves();
    write("<Output><plotfile type=\"febio\"><var type=\"displacement\"/><var type=\"stress\"/></plotfile></Output>\n");
    write("</febio_spec>\n");
    return std::move(out_);
  }

 private:
  void write_number(const char* name, double value) { write("<{}>{:.17g}</{}>", name, value, name); }

  void write_volume(const ConstantsOf& own) {
    const Volumetric volume = own.volume();
    write_number("k", volume.modulus);
    write("<pressure_model>{}</pressure_model>", volume.form == Volumetric::Form::logarithmic ? "default"
                                                 : volume.form == Volumetric::Form::mixed     ? "NIKE3D"
                                                                                              : "Abaqus");
  }

  // ------------------------------------------------------------------------------------------ materials, by their laws

  using Write = void (FebioDeck::*)(const Material& material);
  struct Law {
    std::string_view name;
    const char* type;  ///< FEBio's
    bool uncoupled;    ///< shape and volume are apart, as FEBio's cells with a volume of their own need it
    Write write;
  };
  static const std::vector<Law>& laws() {
    static const std::vector<Law> all{
        {NeoHookeanLog::name, "neo-Hookean", false, &FebioDeck::write_moduli},
        {StVenantKirchhoff::name, "isotropic elastic", false, &FebioDeck::write_moduli},
        {MooneyRivlin::name, "Mooney-Rivlin", true, &FebioDeck::write_mooney_rivlin},
        {Yeoh::name, "Yeoh", true, &FebioDeck::write_yeoh},
        {Ogden::name, "Ogden", true, &FebioDeck::write_ogden},
        {TransverselyIsotropic::name, "trans iso Mooney-Rivlin", true, &FebioDeck::write_fibres},
    };
    return all;
  }
  const Law& law() const {
    std::string known;
    for (const Law& law : laws()) {
      if (law.name == problem_.law) return law;
      known += (known.empty() ? "" : ", ") + std::string(law.name);
    }
    const std::string log(NeoHookeanLog::name);
    refuse("it has no law '" + problem_.law + "'; allowed: " + known +
           (problem_.law == NeoHookean::name ? ". Its own neo-Hookean is " + log + ": --set stiffness=" + log : ""));
  }

  void write_material(std::size_t number) {
    write("<material id=\"{}\" name=\"m{}\" type=\"{}\">", number + 1, number + 1, law().type);
    write_number("density", problem_.materials[number].density);
    (this->*law().write)(problem_.materials[number]);
    write("</material>\n");
  }

  /// The law of F F_g⁻¹: a kinematic growth along all directions, or a prestrain of which all acts.
  void write_growing(std::size_t number) {
    if (law().uncoupled) refuse("it has no `rest` of '" + problem_.law + "', whose shape and volume are apart");
    const Matrix3& growth = problem_.growths[number];
    const bool even = (growth - growth(0, 0) * Matrix3::Identity()).norm() <= 1e-12;
    write("<material id=\"{}\" name=\"m{}\" type=\"{}\">", number + 1, number + 1,
          even ? "kinematic growth" : "prestrain elastic");
    write_number("density", problem_.materials[number].density);
    write("<elastic type=\"{}\">", law().type);
    write_number("density", problem_.materials[number].density);
    (this->*law().write)(problem_.materials[number]);
    write("</elastic>");
    if (even) {
      std::vector<double> factors;
      for (const double part : problem_.rest_parts) factors.push_back(1 + part * (growth(0, 0) - 1));
      const Course course = course_of(factors, 1);
      write("<growth type=\"volume growth\"><multiplier lc=\"{}\">{:.17g}</multiplier></growth>", course.controller,
            course.scale);
    } else {
      if (problem_.steps.size() > 1)
        refuse("a `rest` that is not the same along all directions grows there otherwise: write `load_steps: 1`");
      const Matrix3 prestrain =
          (Matrix3::Identity() + problem_.rest_parts[0] * (growth - Matrix3::Identity())).inverse();
      write("<prestrain type=\"prestrain gradient\"><F0>");
      for (int i = 0; i < 9; ++i) write("{}{:.17g}", i > 0 ? "," : "", prestrain(i / 3, i % 3));
      write("</F0><ramp lc=\"{}\">1</ramp></prestrain>", course_of({1}).controller);
    }
    write("</material>\n");
  }

  void write_moduli(const Material& material) {
    write_number("E", material.youngs_modulus);
    write_number("v", material.poissons_ratio);
  }
  void write_mooney_rivlin(const Material& material) {
    write_volume(ConstantsOf(material, MooneyRivlin::name));
    const auto [c1, c2] = MooneyRivlin{}.density(material);
    write_number("c1", c1);
    write_number("c2", c2);
  }
  void write_yeoh(const Material& material) {
    write_volume(ConstantsOf(material, Yeoh::name));
    const Yeoh::Density density = Yeoh{}.density(material);
    for (int i = 0; i < density.terms; ++i) write_number(numbered("c", i).c_str(), density.c[i]);
  }
  void write_ogden(const Material& material) {
    write_volume(ConstantsOf(material, Ogden::name));
    const auto terms = Ogden::terms(material);
    for (int i = 0; i < terms.count; ++i) {
      write_number(numbered("c", i).c_str(), terms.c(i));
      write_number(numbered("m", i).c_str(), terms.m(i));
    }
  }
  void write_fibres(const Material& material) {
    if (material.around) refuse("directions around an axis are not exported");
    const ConstantsOf own(material, TransverselyIsotropic::name);
    write_volume(own);
    const TransverselyIsotropic::Shape shape = TransverselyIsotropic{}.shape(material);
    write_number("c1", shape.c1);
    write_number("c2", shape.c2);
    write_number("c3", own.has("c3") ? own.modulus("c3") : 0);  // 0: without a jump of the slope, as here
    write_number("c4", own.number("c4"));
    write_number("c5", own.modulus("c5"));
    write_number("lam_max", own.number("lambda_max"));
    const Vector3& a = shape.direction;
    write("<fiber type=\"vector\"><vector>{:.17g},{:.17g},{:.17g}</vector></fiber>", a[0], a[1], a[2]);
  }
  static std::string numbered(const char* name, int from_0) { return name + std::to_string(from_0 + 1); }

  void write_mesh() {
    const Positions& rest = problem_.body().rest;
    write("<Mesh>\n<Nodes name=\"all\">\n");
    for (Eigen::Index i = 0; i < rest.cols(); ++i)
      write("<node id=\"{}\">{:.17g},{:.17g},{:.17g}</node>\n", i + 1, rest(0, i), rest(1, i), rest(2, i));
    write("</Nodes>\n");
    int number = 0;
    for (std::size_t i = 0; i < problem_.cells.size(); ++i) {
      const ExportedCells& cells = problem_.cells[i];
      const auto& shapes = febio_solids();
      const auto shape =
          std::find_if(shapes.begin(), shapes.end(), [&](const auto& one) { return one.name == cells.kind->name; });
      if (shape == shapes.end()) refuse("it has no " + std::string(cells.kind->plural));
      write("<Elements type=\"{}\" name=\"p{}\">\n", shape->febio, i + 1);
      for (int cell = 0; cell < cells.size(); ++cell) {
        write("<elem id=\"{}\">", ++number);
        for (int node = 0; node < cells.kind->nodes; ++node) {
          const int own = shape->order.empty() ? node : shape->order[node];
          write("{}{}", node > 0 ? "," : "", cells.nodes[cell * cells.kind->nodes + own] + 1);
        }
        write("</elem>\n");
      }
      write("</Elements>\n");
    }
    for (std::size_t set = 0; set < sets_.size(); ++set) {
      write("<NodeSet name=\"set{}\">", set + 1);
      for (std::size_t i = 0; i < sets_[set].size(); ++i) write("{}{}", i > 0 ? "," : "", sets_[set][i] + 1);
      write("</NodeSet>\n");
    }
    write("</Mesh>\n");
  }

  void write_domains() {
    write("<MeshDomains>\n");
    for (std::size_t i = 0; i < problem_.cells.size(); ++i) {
      const CellKind& kind = *problem_.cells[i].kind;
      const bool first_order = kind.name == "hexahedron8" || kind.name == "prism6";
      if (problem_.whole_cell && !(law().uncoupled && first_order))
        refuse(
            "it keeps the volume of whole cells in hexahedra and prisms of first order alone, of laws with a "
            "bulk_modulus; write `volume: none` in stiffness, or choose these");
      write("<SolidDomain name=\"p{}\" mat=\"m{}\" type=\"{}\"/>\n", i + 1, problem_.cells[i].material + 1,
            problem_.whole_cell ? "three-field-solid" : "elastic-solid");
    }
    write("</MeshDomains>\n");
  }

  /// Values at the end of each step as one of them times a curve.
  Course course_of(const std::vector<double>& values, double before = 0) {
    const auto largest =
        std::max_element(values.begin(), values.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    if (*largest == 0) return {};
    const double scale = values.back() != 0 ? values.back() : *largest;
    std::string curve = fmt::format("<pt>0,{:.12g}</pt>", before / scale);
    for (std::size_t step = 0; step < values.size(); ++step)
      curve += fmt::format("<pt>{},{:.12g}</pt>", step + 1, values[step] / scale);
    const auto [found, added] = curves_.emplace(std::move(curve), static_cast<int>(curves_.size()) + 1);
    return {scale, found->second};
  }
  std::string set_of(Numbers molecules) {
    const auto found = std::find(sets_.begin(), sets_.end(), molecules);
    if (found != sets_.end()) return fmt::format("set{}", found - sets_.begin() + 1);
    sets_.push_back(std::move(molecules));
    return fmt::format("set{}", sets_.size());
  }

  std::string boundary_text() {
    std::map<int, int> fixed;  // axes of each molecule, a bit each
    std::array<std::map<Course, Numbers>, 3> moved;
    for (const DrivenComponent& driven : problem_.driven)
      if (const Course course = course_of(driven.displacements); course.controller == 0)
        fixed[driven.molecule] |= 1 << driven.axis;
      else
        moved[driven.axis][course].push_back(driven.molecule);
    std::map<int, Numbers> alike;
    for (const auto& [molecule, axes] : fixed) alike[axes].push_back(molecule);
    std::string text;
    for (auto& [axes, molecules] : alike)
      text += fmt::format(
          "<bc type=\"zero displacement\" node_set=\"{}\"><x_dof>{}</x_dof><y_dof>{}</y_dof><z_dof>{}"
          "</z_dof></bc>\n",
          set_of(molecules), axes & 1, axes >> 1 & 1, axes >> 2 & 1);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (auto& [course, molecules] : moved[axis])
        text += fmt::format(
            "<bc type=\"prescribed displacement\" node_set=\"{}\"><dof>{}</dof><value lc=\"{}\">{:.17g}"
            "</value><relative>0</relative></bc>\n",
            set_of(molecules), "xyz"[axis], course.controller, course.scale);
    return text;
  }

  std::string loads_text() {
    std::array<std::map<Course, Numbers>, 3> loaded;
    for (int molecule = 0; molecule < problem_.body().size(); ++molecule)
      for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (const Positions& forces : problem_.forces) values.push_back(forces(axis, molecule));
        if (const Course course = course_of(values); course.controller != 0) loaded[axis][course].push_back(molecule);
      }
    std::string text;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (auto& [course, molecules] : loaded[axis])
        text += fmt::format(
            "<nodal_load type=\"nodal_load\" node_set=\"{}\"><dof>{}</dof><scale lc=\"{}\">{:.17g}</scale>"
            "<relative>0</relative></nodal_load>\n",
            set_of(molecules), "xyz"[axis], course.controller, course.scale);
    return text;
  }

  void write_curves() {
    write("<LoadData>\n");
    for (const auto& [curve, number] : curves_)
      write(
          "<load_controller id=\"{}\" type=\"loadcurve\"><interpolate>LINEAR</interpolate><extend>CONSTANT</extend>"
          "<points>{}</points></load_controller>\n",
          number, curve);
    write("</LoadData>\n");
  }

  const StaticProblem& problem_;
  std::vector<Numbers> sets_;
  std::map<std::string, int> curves_;
};

}  // namespace

/// Faces of hex27 come round the sides first, then below and above.
const std::vector<FebioShape>& febio_solids() {
  static const std::vector<FebioShape> shapes{
      {"hex8", "hexahedron8"},
      {"hex20", "hexahedron20"},
      {"tet4", "tetrahedron4"},
      {"tet10", "tetrahedron10"},
      {"penta6", "prism6"},
      {"hex27", "hexahedron27", {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13,
                                 14, 15, 16, 17, 18, 19, 22, 21, 23, 20, 24, 25, 26}}};
  return shapes;
}

std::string febio_text(const Scene& scene, std::vector<std::string>& notes) {
  StaticProblem problem = problem_of(scene);
  std::string text = FebioDeck(problem).text();
  notes = std::move(problem.notes);
  return text;
}

}  // namespace elastin::lab
