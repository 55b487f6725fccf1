#include "febio/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "config/formula.h"
#include "core/model/block_geometry.h"
#include "elastin/core/base/text.h"
#include "elastin/core/shapes/arrays.h"
#include "febio/experiment.h"
#include "febio/materials.h"
#include "febio/mesh.h"

namespace elastin::febio {
namespace {

/// A file whose elements the model refers to for as long as it lives.
struct Document {
  std::string path;
  mesh::XmlElement root;
};

/// How the cells of a block get their stiffness.
struct Domain {
  int material = 0;
  bool whole_cell = false;  ///< mean dilatation
};

/// What the model's strategy and experiment work with.
struct Built {
  std::shared_ptr<const Document> document;
  std::vector<Material> materials;
  std::vector<Domain> domains;  ///< one a block
};

const char* const kAxes[] = {"x", "y", "z"};

using NamedValues = std::initializer_list<std::pair<const char*, double>>;

/// An element's text as a formula of named values: FEBio takes powers from the left, and its `log` is that to the base
/// 10.                                                                                   [FEBio User's Manual 4.0]
double formula_value(const Element& element, NamedValues values) {
  static const config::FormulaLanguage language{.units = false,
                                                .powers_from_left = true,
                                                .functions = {{"ln", [](double x) { return std::log(x); }},
                                                              {"log", [](double x) { return std::log10(x); }},
                                                              {"asin", [](double x) { return std::asin(x); }},
                                                              {"acos", [](double x) { return std::acos(x); }},
                                                              {"atan", [](double x) { return std::atan(x); }}}};
  const auto value_of = [&](const std::string& name) -> config::FormulaValue {
    std::vector<std::string> names{"e", "pi"};
    if (name == "e") return {std::numbers::e, {}};
    for (const auto& [known, value] : values) {
      if (name == known) return {value, {}};
      names.emplace_back(known);
    }
    element.fail("the formula '" + element.text() + "': there is no value '" + name + "'" + suggestion(name, names));
  };
  const double value =
      element.located([&] { return config::formula_value(element.text(), value_of, language).number; });
  if (!std::isfinite(value)) element.fail("the formula '" + element.text() + "' is not finite everywhere");
  return value;
}

/// Of the position at rest.
std::function<double(const Vector3&)> formula_of(const Element& element) {
  return [element](const Vector3& at) { return formula_value(element, {{"X", at.x()}, {"Y", at.y()}, {"Z", at.z()}}); };
}

/// What fixes or prescribes a component of a rigid body's motion.
struct RigidComponent {
  std::string body;
  int component;  ///< displacement along x, y, z, and the rotation vector's x, y, z
  int step;       ///< in which alone it is in force, or -1: in all
  std::optional<Value> value;
};

class ModelReader {
 public:
  explicit ModelReader(std::shared_ptr<const Document> document)
      : root_(document->root, document->path), mesh_(checked(root_).at("Mesh")) {
    built_->document = std::move(document);
  }

  std::unique_ptr<lab::Scene> read();

 private:
  static const Element& checked(const Element& root);
  void refuse_sections(const Element& owner, std::initializer_list<const char*> known) const;
  void read_controllers(const Element& data);
  void read_data(const Element& section);
  void read_materials(const Element& section);
  void read_domains(const Element& section);
  void read_domain(const Element& domain);
  Step read_control(const Element& control) const;
  void read_steps();
  void read_boundary(const Element& boundary, int step);
  void read_linear_constraint(const Element& bc, int step);
  std::vector<std::pair<Value, Value>> driver_of(const Element& owner, int molecule, int axis, int step) const;
  void read_loads(const Element& loads);
  void read_nodal_load(const Element& load);
  void read_body_load(const Element& load);
  void read_surface_load(const Element& load);
  void read_discrete(const Element& discrete);
  void read_constraints(const Element& constraints, int step);
  void read_volume(const Element& constraint, int step);
  void read_rigid(const Element& rigid, int step);
  std::string rigid_body_of(const Element& owner) const;
  Vector3 centre_of(const Element& where, const Material& rigid) const;
  void drive_rigid_bodies();
  void refuse_within() const;
  Augmentation read_augmentation(const Element& constraint, const char* tolerance, double usual, int most) const;
  void read_linear_constraints(const Element& constraint);
  void read_tied_line(const Element& constraint);
  void read_rigid_wall(const Element& constraint);
  int axis_of(const Element& element) const;

  template <class Visit>
  void visit_points(const Visit& visit) const;
  void set_mass(Body& body);
  Body make_body();

  Element root_;
  MeshReader mesh_;
  LoadControllers controllers_;
  std::map<std::string, CellData> data_;                        ///< by its name
  std::map<std::pair<int, int>, std::vector<int>> prescribed_;  // by molecule and axis, in which steps (-1: in all)
  std::vector<RigidComponent> rigid_;
  std::map<std::string, std::vector<int>> rigid_nodes_;  // molecules by the rigid material's name
  std::shared_ptr<Built> built_ = std::make_shared<Built>();
  std::shared_ptr<ExperimentSetup> setup_ = std::make_shared<ExperimentSetup>();
};

const Element& ModelReader::checked(const Element& root) {
  if (root.name() != "febio_spec") root.fail("a model of FEBio begins with <febio_spec version=\"4.0\">");
  if (root.attribute("version") != "4.0")
    root.refuse("version \"" + root.attribute("version") + "\"", "only 4.0 is; FEBio Studio converts models");
  for (const Element& section : root.children())
    if (!section.attribute("from").empty())
      section.refuse("a section in another file, from=\"" + section.attribute("from") + "\"");
  const Element module = root.at("Module");
  if (module.attribute("type") != "solid") module.refuse("type=\"" + module.attribute("type") + "\"", "only solid is");
  return root;
}

/// Sections that are not known must be empty: what they have is not passed over.
void ModelReader::refuse_sections(const Element& owner, std::initializer_list<const char*> known) const {
  for (const Element& section : owner.children()) {
    if (std::find(known.begin(), known.end(), section.name()) != known.end()) continue;
    const auto inside = section.children();
    if (inside.empty() && section.text().empty()) continue;
    const std::string where = " in <" + section.name() + ">";
    if (inside.empty()) section.refuse("the section <" + section.name() + ">");
    const std::string type = inside.front().attribute("type");
    inside.front().refuse((type.empty() ? "<" + inside.front().name() + ">" : "type=\"" + type + "\"") + where);
  }
}

void ModelReader::read_controllers(const Element& data) {
  data.allow({"load_controller"});
  data.refuse_twice("id");
  for (const Element& one : data.children()) {
    one.allow_attributes({"id", "name", "type"});
    if (one.attribute("type") == "math") {
      one.allow({"math"});
      const auto value = [math = one.at("math"), document = built_->document](double time) {
        return formula_value(math, {{"t", time}});
      };
      value(0);
      controllers_[one.whole_attribute("id")] =
          std::make_shared<const LoadController>(LoadController{.formula = value});
      continue;
    }
    if (one.attribute("type") != "loadcurve")
      one.refuse("type=\"" + one.attribute("type") + "\"", "loadcurve and math are");
    one.allow({"interpolate", "extend", "points"});
    LoadController curve;
    const auto interpolate = one.find("interpolate"), extend = one.find("extend");
    const auto word = [](const std::optional<Element>& element, const auto& words, auto usual) {
      if (!element) return usual;
      std::vector<std::string> names;
      for (const auto& [name, value] : words) {
        if (element->text() == name) return value;
        names.emplace_back(name);
      }
      element->fail("'" + element->text() + "' is not supported" + suggestion(element->text(), names));
    };
    using Interpolation = LoadController::Interpolation;
    using Extension = LoadController::Extension;
    static const std::vector<std::pair<const char*, Interpolation>> ways{
        {"LINEAR", Interpolation::linear}, {"STEP", Interpolation::step}, {"SMOOTH", Interpolation::smooth}};
    static const std::vector<std::pair<const char*, Extension>> ends{
        {"CONSTANT", Extension::constant}, {"EXTRAPOLATE", Extension::extrapolate}, {"REPEAT", Extension::repeat}};
    curve.interpolation = word(interpolate, ways, Interpolation::linear);
    curve.extension = word(extend, ends, Extension::constant);
    const Element points = one.at("points");
    points.allow({"pt", "point"});
    for (const Element& point : points.children()) {
      const std::vector<double> pair = point.numbers(2);
      if (!curve.points.empty() && !(pair[0] > curve.points.back()[0])) point.fail("times must grow");
      curve.points.push_back({pair[0], pair[1]});
    }
    if (curve.points.empty()) points.fail("has no points");
    controllers_[one.whole_attribute("id")] = std::make_shared<const LoadController>(std::move(curve));
  }
}

Material read_rigid_material(const Element& element) {
  element.allow_attributes({"id", "name", "type"});
  element.allow({"density", "center_of_mass", "override_com", "E", "v"});
  Material material;
  material.name = element.attribute("name"), material.id = element.attribute("id");
  material.density = element.number("density", 1);
  material.rigid = true;
  const auto centre = element.find("center_of_mass");
  if (centre && element.number("override_com", 1) != 0) {
    const std::vector<double> at = centre->numbers(3);
    material.centre = Vector3(at[0], at[1], at[2]);
  }
  return material;
}

void ModelReader::read_data(const Element& section) {
  section.allow({"ElementData"});
  section.refuse_twice("name");
  const std::map<std::string, std::size_t> counts{{"", 1}, {"scalar", 1}, {"vec3", 3}, {"mat3", 9}};
  for (const Element& one : section.children()) {
    one.allow_attributes({"name", "elem_set", "data_type"});
    one.allow({"e"});
    const auto count = counts.find(one.attribute("data_type"));
    if (count == counts.end()) one.refuse("data_type=\"" + one.attribute("data_type") + "\"");
    CellData& data = data_[one.needed_attribute("name")];
    data.domain = one.needed_attribute("elem_set");
    for (const Element& row : one.children()) {
      if (row.whole_attribute("lid") != static_cast<int>(data.values.size()) + 1)
        row.refuse("lid out of order", "1, 2, 3 … are");
      data.values.push_back(row.numbers(count->second));
    }
  }
}

void ModelReader::read_materials(const Element& section) {
  section.allow({"material"});
  section.refuse_twice("id");
  section.refuse_twice("name");
  for (const Element& one : section.children()) {
    built_->materials.push_back(one.attribute("type") == "rigid body"
                                    ? read_rigid_material(one)
                                    : read_material(one, {controllers_, {setup_->clock, &setup_->clock->time}, data_}));
    if (built_->materials.back().name.empty()) one.fail("the attribute 'name' is missing");
  }
  // A rigid body moves without strain, whatever its material: that of a body that does strain.
  auto& all = built_->materials;
  const auto solid = std::find_if(all.begin(), all.end(), [](const Material& one) { return !one.rigid; });
  if (solid == all.end()) section.fail("a <material> that is not rigid is missing");
  for (Material& one : all) {
    if (!one.rigid) continue;
    one.youngs_modulus = solid->youngs_modulus, one.poissons_ratio = solid->poissons_ratio;
    one.terms = solid->terms, one.even = solid->even, one.volume = solid->volume;
    one.has_energy = solid->has_energy, one.relaxation = solid->relaxation;
  }
}

void ModelReader::read_domains(const Element& section) {
  section.allow({"SolidDomain"});
  section.refuse_twice("name");
  built_->domains.resize(mesh_.domains().size(), {-1, false});
  for (const Element& domain : section.children()) read_domain(domain);
  for (std::size_t i = 0; i < built_->domains.size(); ++i)
    if (built_->domains[i].material < 0) section.fail("<Elements> '" + mesh_.domains()[i].name + "' has no domain");
}

void ModelReader::read_domain(const Element& domain) {
  domain.allow_attributes({"name", "mat", "type", "elem_type"});
  domain.allow({"laugon", "atol", "minaug", "maxaug"});
  const std::string name = domain.needed_attribute("name"), mat = domain.needed_attribute("mat");
  const auto& all = mesh_.domains();
  const auto own = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(one.name);
  if (own == all.end()) domain.fail("there are no <Elements> '" + name + "'" + suggestion(name, names));
  const auto& materials = built_->materials;
  const auto material = std::find_if(materials.begin(), materials.end(), [&](const auto& m) { return m.name == mat; });
  names.clear();
  for (const Material& one : materials) names.push_back(one.name);
  if (material == materials.end()) domain.fail("there is no material '" + mat + "'" + suggestion(mat, names));
  if (const auto& data = material->data;
      data && (data->domain != name || static_cast<int>(data->values.size()) != mesh_.body().blocks[own->block].size()))
    domain.fail("the <ElementData> of material '" + mat + "' are not of all its cells");
  const std::string type = domain.attribute("type"), points = domain.attribute("elem_type");
  if (material->rigid) {
    if (!type.empty() && type != "rigid-solid")
      domain.refuse("type=\"" + type + "\" of a rigid body", "rigid-solid is");
    built_->domains[own->block] = {static_cast<int>(material - materials.begin()), false};
    const std::vector<int>& nodes = mesh_.body().blocks[own->block].nodes;
    rigid_nodes_[mat].insert(rigid_nodes_[mat].end(), nodes.begin(), nodes.end());
    return;
  }
  if (!type.empty() && type != "elastic-solid" && type != "three-field-solid")
    domain.refuse("type=\"" + type + "\"", "elastic-solid and three-field-solid are");
  if (!points.empty()) domain.refuse("elem_type=\"" + points + "\"", "the usual quadrature is");
  const bool first_order = own->type == "hex8" || own->type == "penta6";
  const bool whole_cell = type == "three-field-solid" || (type.empty() && material->volume && first_order);
  if (whole_cell && (!material->volume || !first_order))
    domain.refuse("type=\"three-field-solid\"", "it needs hex8 or penta6 and an uncoupled material");
  const Augmentation augmentation = read_augmentation(domain, "atol", 0.01, 0);
  if (augmentation.on && whole_cell)
    setup_->dilatations.push_back({own->block, material->volume->modulus, augmentation});
  built_->domains[own->block] = {static_cast<int>(material - materials.begin()), whole_cell};
}

/// FEBio's automatic steps are at most dtmax long, and grow by a fifth of what is left to that where increments
/// converge easily, as they are taken to do.
void set_increments(const Element& control, double count, double first, Step& step) {
  const auto stepper = control.find("time_stepper");
  const auto most = stepper ? stepper->find("dtmax") : std::nullopt;
  const bool limited = most && most->attribute("lc").empty() && most->number() > 0;
  const double longest = limited ? most->number() : first, end = count * first;
  const auto even = [&](double size) {
    const double parts = std::max(1., std::ceil(end / size * (1 - 1e-9)));
    if (parts > 1e6) control.fail("has more than 1e6 increments");
    step.increments.assign(static_cast<std::size_t>(parts), end / parts);
  };
  if (longest <= first) return even(longest);
  double time = 0, size = first;
  while (time < end * (1 - 1e-9)) {
    step.increments.push_back(std::min(size, end - time));
    time += step.increments.back();
    size += (longest - size) / 5;
  }
}

Step ModelReader::read_control(const Element& control) const {
  control.allow({"analysis", "time_steps", "step_size", "plot_zero_state", "plot_range", "plot_level", "plot_stride",
                 "output_level", "output_stride", "adaptor_re_solve", "time_stepper", "solver"});
  Step step;
  const Element analysis = control.at("analysis");
  if (analysis.text() != "STATIC" && analysis.text() != "DYNAMIC")
    analysis.refuse("'" + analysis.text() + "'", "STATIC and DYNAMIC are");
  step.dynamic = analysis.text() == "DYNAMIC";
  const Element steps = control.at("time_steps"), size = control.at("step_size");
  const double count = steps.number(), first = size.number();
  if (!(count >= 1 && count <= 1e6 && count == std::floor(count))) steps.fail("must be a whole number from 1 to 1e6");
  if (!(first > 0)) size.fail("must be above 0");
  set_increments(control, count, first, step);
  const auto solver = control.find("solver");
  if (!solver) return step;
  if (const auto arc = solver->find("arc_length"); arc && arc->text() != "0" && arc->text() != "NONE")
    arc->refuse("an arc length", "the load follows the time");
  if (!step.dynamic) return step;
  const double radius = solver->number("rhoi", -2);
  if (radius == -1) return step;
  if (radius >= 0 && radius <= 1) {
    const double force = 1 / (1 + radius), mass = (2 - radius) / (1 + radius), more = mass - force;
    step.integration = {(1 + more) * (1 + more) / 4, 0.5 + more, mass, force};
    return step;
  }
  const double alpha = solver->number("alpha", 1);
  if (!(alpha > 0 && alpha <= 1)) solver->at("alpha").fail("must be above 0 and at most 1");
  step.integration = {solver->number("beta", 0.25), solver->number("gamma", 0.5), alpha, alpha};
  if (!(step.integration.beta > 0)) solver->at("beta").fail("must be above 0");
  return step;
}

void ModelReader::read_steps() {
  const auto control = root_.find("Control"), section = root_.find("Step");
  if (control) setup_->steps.push_back(read_control(*control));
  if (section) {
    section->allow({"step"});
    for (const Element& step : section->children()) {
      refuse_sections(step, {"Control", "Boundary", "Constraints", "Rigid"});
      setup_->steps.push_back(read_control(step.at("Control")));
      if (const auto boundary = step.find("Boundary"))
        read_boundary(*boundary, static_cast<int>(setup_->steps.size()) - 1);
      if (const auto constraints = step.find("Constraints"))
        read_constraints(*constraints, static_cast<int>(setup_->steps.size()) - 1);
      if (const auto rigid = step.find("Rigid")) read_rigid(*rigid, static_cast<int>(setup_->steps.size()) - 1);
    }
  }
  if (setup_->steps.empty()) root_.fail("<Control> is missing, or <Step>");
  bool moving = false;
  for (const Step& step : setup_->steps) {
    if (moving && !step.dynamic)
      (section ? *section : root_).refuse("a STATIC step behind a DYNAMIC one", "the motion would have no end");
    moving |= step.dynamic;
  }
}

int ModelReader::axis_of(const Element& element) const {
  for (int axis = 0; axis < 3; ++axis)
    if (element.text() == kAxes[axis]) return axis;
  element.refuse("'" + element.text() + "'", "x, y and z are");
}

void ModelReader::read_boundary(const Element& boundary, int step) {
  boundary.allow({"bc"});
  for (const Element& bc : boundary.children()) {
    const std::string type = bc.needed_attribute("type");
    if (type == "linear constraint") {
      read_linear_constraint(bc, step);
      continue;
    }
    bc.allow_attributes({"name", "node_set", "type"});
    if (type == "zero displacement") {
      bc.allow({"x_dof", "y_dof", "z_dof"});
      for (const int molecule : mesh_.node_set(bc, bc.needed_attribute("node_set")))
        for (int axis = 0; axis < 3; ++axis)
          if (bc.number(std::string(kAxes[axis]) + "_dof", 0) != 0) setup_->driven.push_back({molecule, axis, step});
    } else if (type == "prescribed displacement") {
      bc.allow({"dof", "value", "relative"});
      const int axis = axis_of(bc.at("dof"));
      if (bc.number("relative", 0) != 0 && step > 0)
        bc.at("relative").refuse("a displacement relative to the end of the step before");
      const Value value = bc.at("value").value(controllers_);
      for (const int molecule : mesh_.node_set(bc, bc.needed_attribute("node_set"))) {
        std::vector<int>& steps = prescribed_[{molecule, axis}];
        if (std::any_of(steps.begin(), steps.end(), [&](int own) { return own < 0 || step < 0 || own == step; }))
          bc.fail("a node of '" + bc.attribute("node_set") + "' has a prescribed displacement along " + kAxes[axis] +
                  " already: only one could be in force");
        steps.push_back(step);
        setup_->driven.push_back({molecule, axis, step, {{Value{1}, value}}});
      }
    } else if (type == "rigid") {
      if (step >= 0) bc.refuse("type=\"rigid\" in a step");
      bc.allow({"rb", "clamp_shells"});
      std::vector<int>& nodes = rigid_nodes_[rigid_body_of(bc)];
      for (const int molecule : mesh_.node_set(bc, bc.needed_attribute("node_set"))) nodes.push_back(molecule);
    } else {
      bc.refuse("type=\"" + type + "\"", "zero displacement, prescribed displacement, linear constraint and rigid are");
    }
  }
}

/// The material that <rb> names, or numbers.
std::string ModelReader::rigid_body_of(const Element& owner) const {
  const Element rb = owner.at("rb");
  std::vector<std::string> names;
  for (const Material& one : built_->materials) {
    if (!one.rigid) continue;
    if (rb.text() == one.name || rb.text() == one.id) return one.name;
    names.push_back(one.name);
  }
  rb.fail("there is no rigid body '" + rb.text() + "'" + (names.empty() ? "" : suggestion(rb.text(), names)));
}

void ModelReader::read_rigid(const Element& rigid, int step) {
  rigid.allow({"rigid_bc"});
  for (const Element& bc : rigid.children()) {
    bc.allow_attributes({"name", "type"});
    const std::string type = bc.needed_attribute("type"), body = rigid_body_of(bc);
    static constexpr const char* rotations[] = {"Ru", "Rv", "Rw"};
    if (type == "rigid_fixed") {
      bc.allow({"rb", "Rx_dof", "Ry_dof", "Rz_dof", "Ru_dof", "Rv_dof", "Rw_dof"});
      for (int i = 0; i < 6; ++i)
        if (bc.number((i < 3 ? "R" + std::string(kAxes[i]) : rotations[i - 3]) + "_dof", 0) != 0)
          rigid_.push_back({body, i, step, std::nullopt});
    } else if (type == "rigid_displacement" || type == "rigid_rotation") {
      bc.allow({"rb", "dof", "value", "relative"});
      if (bc.number("relative", 0) != 0 && step > 0)
        bc.at("relative").refuse("a motion relative to the end of the step before");
      const Element dof = bc.at("dof");
      const auto turn = std::find(std::begin(rotations), std::end(rotations), dof.text());
      if (type == "rigid_rotation" && turn == std::end(rotations))
        dof.refuse("'" + dof.text() + "'", "Ru, Rv and Rw are");
      const auto component =
          type == "rigid_rotation" ? 3 + static_cast<int>(turn - std::begin(rotations)) : axis_of(dof);
      rigid_.push_back({body, component, step, bc.at("value").value(controllers_)});
    } else {
      bc.refuse("type=\"" + type + "\"", "rigid_fixed, rigid_displacement and rigid_rotation are");
    }
  }
}

/// The point about which it turns: as stated, or its centre of mass.
Vector3 ModelReader::centre_of(const Element& where, const Material& rigid) const {
  if (rigid.centre) return *rigid.centre;
  Vector3 moment = Vector3::Zero();
  double mass = 0;
  visit_points([&](std::size_t block, std::span<const int>, const VectorX&, const Vector3& place, double weight) {
    if (&built_->materials[built_->domains[block].material] == &rigid) mass += weight, moment += weight * place;
  });
  if (mass == 0) where.fail("the rigid body '" + rigid.name + "' has no cells: give its <center_of_mass>");
  return moment / mass;
}

/// A rigid body's nodes go where its motion says: x = c + d + R (X − c), with R of the rotation vector. All six
/// components must be known in each step.
void ModelReader::drive_rigid_bodies() {
  const bool in_steps = std::any_of(rigid_.begin(), rigid_.end(), [](const auto& one) { return one.step >= 0; });
  for (const auto& [name, nodes] : rigid_nodes_) {
    const auto own = std::find_if(built_->materials.begin(), built_->materials.end(),
                                  [&name = name](const auto& m) { return m.name == name; });
    const Element where = root_.find("Rigid").value_or(root_);
    for (int step = in_steps ? 0 : -1; step < (in_steps ? static_cast<int>(setup_->steps.size()) : 0); ++step) {
      std::array<std::optional<Value>, 6> motion;  // the last; what is prescribed counts before what is fixed
      for (const RigidComponent& one : rigid_)
        if (one.body == name && (one.step < 0 || one.step == step) && (one.value || !motion[one.component]))
          motion[one.component] = one.value.value_or(Value{});
      for (int i = 0; i < 6; ++i)
        if (!motion[i])
          where.refuse("the rigid body '" + name + "' free " + (i < 3 ? "along " : "to turn about ") + kAxes[i % 3] +
                           (step < 0 ? "" : " in step " + std::to_string(step + 1)),
                       "one whose six components are all fixed or prescribed is");
      const auto turn = [=](double time) {
        const Vector3 w(motion[3]->at(time), motion[4]->at(time), motion[5]->at(time));
        return Matrix3(Eigen::AngleAxisd(w.norm(), w.norm() > 0 ? Vector3(w.normalized()) : Vector3::UnitX()));
      };
      const auto stays = [](const Value& value) { return value.number == 0; };
      const bool turns = !stays(*motion[3]) || !stays(*motion[4]) || !stays(*motion[5]);
      const Vector3 centre = turns ? centre_of(where, *own) : Vector3(Vector3::Zero());
      for (const int molecule : std::set<int>(nodes.begin(), nodes.end()))
        for (int axis = 0; axis < 3; ++axis) {
          DrivenComponent driven{molecule, axis, step, {}};
          if (!stays(*motion[axis])) driven.terms.push_back({Value{1}, *motion[axis]});
          if (turns) {
            const Vector3 arm = mesh_.body().rest.col(molecule) - centre;
            driven.terms.push_back(
                {Value{1}, Value{1, std::make_shared<const LoadController>(LoadController{
                                        .formula = [=](double time) { return (turn(time) * arm - arm)[axis]; }})}});
          }
          setup_->driven.push_back(std::move(driven));
        }
    }
  }
}

/// What drives a component, for one that must move with it.
std::vector<std::pair<Value, Value>> ModelReader::driver_of(const Element& owner, int molecule, int axis,
                                                            int step) const {
  for (auto driven = setup_->driven.rbegin(); driven != setup_->driven.rend(); ++driven)
    if (driven->molecule == molecule && driven->axis == axis && (driven->step < 0 || driven->step == step))
      return driven->terms;
  owner.refuse("a linear constraint on a displacement that is free", "only those on prescribed displacements are");
}

/// A component that is a sum of prescribed ones is prescribed itself.
void ModelReader::read_linear_constraint(const Element& bc, int step) {
  bc.allow_attributes({"name", "type"});
  bc.allow({"dof", "node", "child_dof", "offset"});
  const auto node_of = [&](const Element& element) {
    const Element node = element.at("node");
    const std::vector<int> number = node.integers();
    if (number.size() != 1) node.fail("needs one node");
    return mesh_.molecule(node, number.front());
  };
  DrivenComponent driven{node_of(bc), axis_of(bc.at("dof")), step, {}};
  if (const auto offset = bc.find("offset")) driven.terms.push_back({Value{1}, offset->value(controllers_)});
  for (const Element& child : bc.children()) {
    if (child.name() != "child_dof") continue;
    child.allow({"dof", "node", "value"});
    const Value factor = child.at("value").value(controllers_);
    for (const auto& [own, value] : driver_of(child, node_of(child), axis_of(child.at("dof")), step)) {
      if (own.controller || own.number != 1) child.refuse("a linear constraint on one of several terms");
      driven.terms.push_back({factor, value});
    }
  }
  setup_->driven.push_back(std::move(driven));
}

/// Calls visit(block, nodes, values, place, weight) for the quadrature points of all cells, at rest.
template <class Visit>
void ModelReader::visit_points(const Visit& visit) const {
  const Body& body = mesh_.body();
  for (std::size_t number = 0; number < body.blocks.size(); ++number) {
    const CellBlock& block = body.blocks[number];
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      const Eigen::MatrixXd rest = positions_of(body.rest, nodes);
      for (std::size_t g = 0; g < block.kind->slopes.size(); ++g) {
        const auto point = static_cast<Eigen::Index>(g);
        const VectorX values = block.kind->values.col(point);
        visit(number, nodes, values, Vector3(rest * values),
              block.kind->weights[point] * measure_of(rest * block.kind->slopes[g].transpose()));
      }
    }
  }
}

void ModelReader::read_loads(const Element& loads) {
  loads.allow({"nodal_load", "surface_load", "body_load"});
  for (const Element& load : loads.children()) {
    if (load.name() == "nodal_load") read_nodal_load(load);
    if (load.name() == "surface_load") read_surface_load(load);
    if (load.name() == "body_load") read_body_load(load);
  }
}

void ModelReader::read_nodal_load(const Element& load) {
  load.allow_attributes({"name", "node_set", "type"});
  const std::string type = load.needed_attribute("type");
  DeadLoad dead{Positions::Zero(3, mesh_.body().size()), {}};
  Vector3 force = Vector3::Zero();
  if (type == "nodal_load") {
    load.allow({"dof", "scale", "relative"});
    if (load.number("relative", 0) != 0) load.at("relative").refuse("a load relative to that of the step before");
    force[axis_of(load.at("dof"))] = 1;
    dead.factor = load.at("scale").value(controllers_);
  } else if (type == "nodal_force") {
    load.allow({"value", "shell_bottom"});
    const Element value = load.at("value");
    value.allow_attributes({"lc"});
    const std::vector<double> numbers = value.numbers(3);
    force = Vector3(numbers[0], numbers[1], numbers[2]);
    dead.factor = {1, value.controller(controllers_)};
  } else {
    load.refuse("type=\"" + type + "\"", "nodal_load and nodal_force are");
  }
  // Loads that go with time alike are one: a model may have one for each node.
  auto& all = setup_->dead_loads;
  const auto alike = std::find_if(all.begin(), all.end(), [&](const DeadLoad& other) {
    return other.factor.number == 1 && other.factor.controller == dead.factor.controller;
  });
  force *= std::exchange(dead.factor.number, 1);
  DeadLoad& own = alike == all.end() ? all.emplace_back(std::move(dead)) : *alike;
  for (const int molecule : mesh_.node_set(load, load.needed_attribute("node_set"))) own.forces.col(molecule) += force;
}

/// FEBio counts a body force against its own direction: the load is −∫ N ρ b dV.
void ModelReader::read_body_load(const Element& load) {
  load.allow_attributes({"name", "type"});
  const std::string type = load.needed_attribute("type");
  const auto add = [&](int axis, const std::function<double(const Vector3&)>& at, const Value& factor) {
    DeadLoad dead{Positions::Zero(3, mesh_.body().size()), factor};
    visit_points(
        [&](std::size_t block, std::span<const int> nodes, const VectorX& values, const Vector3& place, double weight) {
          const Material& material = built_->materials[built_->domains[block].material];
          const double force = -weight * material.density * at(place);
          for (std::size_t a = 0; a < nodes.size(); ++a)
            dead.forces(axis, nodes[a]) += values[static_cast<Eigen::Index>(a)] * force;
        });
    setup_->dead_loads.push_back(std::move(dead));
  };
  if (type == "const" || type == "non-const") {
    load.allow({"x", "y", "z"});
    for (int axis = 0; axis < 3; ++axis) {
      const auto component = load.find(kAxes[axis]);
      if (!component) continue;
      if (component->attribute("type") == "math") {
        component->allow_attributes({"lc", "type"});
        add(axis, formula_of(*component), {1, component->controller(controllers_)});
      } else {
        add(
            axis, [](const Vector3&) { return 1.; }, component->value(controllers_));
      }
    }
  } else if (type == "body force") {
    load.allow({"force"});
    const Element force = load.at("force");
    force.allow_attributes({"lc"});
    const std::vector<double> numbers = force.numbers(3);
    for (int axis = 0; axis < 3; ++axis)
      if (const double one = numbers[axis]; one != 0)
        add(axis, [](const Vector3&) { return 1.; }, {one, force.controller(controllers_)});
  } else {
    load.refuse("type=\"" + type + "\"", "const, non-const and body force are");
  }
}

void ModelReader::read_surface_load(const Element& load) {
  load.allow_attributes({"name", "surface", "type"});
  const std::string type = load.needed_attribute("type");
  SurfaceLoad result;
  result.faces = mesh_.surface(load, load.needed_attribute("surface"));
  result.at_rest = load.number("linear", 0) != 0;
  if (load.number("shell_bottom", 0) != 0) load.at("shell_bottom").refuse("the bottom of a shell");
  if (type == "pressure") {
    load.allow({"pressure", "linear", "symmetric_stiffness", "shell_bottom"});
    result.factor = load.at("pressure").value(controllers_);
  } else if (type == "traction") {
    load.allow({"scale", "traction", "linear", "shell_bottom"});
    const Element traction = load.at("traction");
    traction.allow_attributes({"lc"});
    const std::vector<double> numbers = traction.numbers(3);
    result.pressure = false;
    result.traction = Vector3(numbers[0], numbers[1], numbers[2]);
    const auto scale = load.find("scale");
    result.factor = scale ? scale->value(controllers_) : Value{1};
    if (traction.controller(controllers_)) {
      if (result.factor.controller) traction.refuse("a load controller in addition to that of <scale>");
      result.factor.controller = traction.controller(controllers_);
    }
  } else if (type == "force") {  // spread evenly over the area at rest
    load.allow({"scale", "force", "shell_bottom"});
    const std::vector<double> force = load.at("force").numbers(3);
    double area = 0;
    visit_face_points(result.faces, mesh_.body().rest, [&](const FacePoint& at) {
      area += at.weight * Vector3(at.edges.col(0)).cross(Vector3(at.edges.col(1))).norm();
    });
    result.pressure = false, result.at_rest = true;
    result.traction = Vector3(force[0], force[1], force[2]) / area;
    const auto scale = load.find("scale");
    result.factor = scale ? scale->value(controllers_) : Value{1};
  } else {
    load.refuse("type=\"" + type + "\"", "pressure, traction and force are");
  }
  setup_->surface_loads.push_back(std::move(result));
}

void ModelReader::read_discrete(const Element& discrete) {
  discrete.allow({"discrete_material", "discrete"});
  discrete.refuse_twice("id");
  std::map<std::string, Value> stiffness;
  for (const Element& material : discrete.children()) {
    if (material.name() != "discrete_material") continue;
    const std::string type = material.needed_attribute("type");
    if (type != "linear spring") material.refuse("type=\"" + type + "\"", "linear spring is");
    material.allow({"E"});
    stiffness[material.needed_attribute("id")] = material.at("E").value(controllers_);
  }
  for (const Element& springs : discrete.children()) {
    if (springs.name() != "discrete") continue;
    springs.allow_attributes({"dmat", "discrete_set"});
    const auto found = stiffness.find(springs.needed_attribute("dmat"));
    if (found == stiffness.end()) springs.fail("there is no discrete_material " + springs.attribute("dmat"));
    for (const auto& ends : mesh_.discrete_set(springs, springs.needed_attribute("discrete_set")))
      setup_->springs.push_back({ends, found->second});
  }
}

Augmentation ModelReader::read_augmentation(const Element& constraint, const char* tolerance, double usual,
                                            int most) const {
  Augmentation result;
  if (const auto method = constraint.find("laugon")) {
    result.on = method->text() == "AUGLAG" || method->text() == "1";
    if (!result.on && method->text() != "PENALTY" && method->text() != "0")
      method->refuse("'" + method->text() + "'", "PENALTY and AUGLAG are");
  }
  result.tolerance = constraint.number(tolerance, usual);
  result.least = static_cast<int>(constraint.number("minaug", 0));
  result.most = static_cast<int>(constraint.number("maxaug", most));
  if (result.most <= 0) result.most = std::numeric_limits<int>::max();
  return result;
}

void ModelReader::read_constraints(const Element& constraints, int step) {
  constraints.allow({"constraint"});
  for (const Element& constraint : constraints.children()) {
    const std::string type = constraint.needed_attribute("type");
    if (type == "volume")
      read_volume(constraint, step);
    else if (step >= 0)
      constraint.refuse("type=\"" + type + "\" in a step", "there volume is");
    else if (type == "linear constraint")
      read_linear_constraints(constraint);
    else if (type == "tied-line")
      read_tied_line(constraint);
    else if (type == "rigid_wall")
      read_rigid_wall(constraint);
    else
      constraint.refuse("type=\"" + type + "\"", "linear constraint, tied-line, rigid_wall and volume are");
  }
}

/// The faces must close: each edge of one is passed the other way by another.
void ModelReader::read_volume(const Element& constraint, int step) {
  constraint.allow_attributes({"name", "surface", "type"});
  constraint.allow({"laugon", "augtol", "penalty"});
  VolumeConstraint result{mesh_.surface(constraint, constraint.needed_attribute("surface")),
                          constraint.needed_number("penalty"), read_augmentation(constraint, "augtol", 0, 0), step};
  if (!(result.augmentation.tolerance > 0)) result.augmentation.on = false;
  std::map<std::pair<int, int>, int> passed;
  for (const LoadedFace& face : result.faces) {
    const std::size_t corners = face.nodes.size();
    if (corners > 4) constraint.refuse("a volume within faces other than tri3 and quad4");
    for (std::size_t i = 0; i < corners; ++i) ++passed[{face.nodes[i], face.nodes[(i + 1) % corners]}];
  }
  for (const auto& [edge, times] : passed) {
    const auto back = passed.find({edge.second, edge.first});
    if (times != 1 || back == passed.end() || back->second != 1)
      constraint.fail("the surface '" + constraint.attribute("surface") +
                      "' is not closed, or its faces do not all turn " + "the same way");
  }
  setup_->volumes.push_back(std::move(result));
}

/// What has no form where forces are those within a step.
void ModelReader::refuse_within() const {
  if (!setup_->within()) return;
  bool half = false;
  for (const Step& step : setup_->steps) half |= step.dynamic && step.integration.alpha_force == 0.5;
  const std::string what = "rhoi above 0, or alpha below 1, ";
  if (!setup_->gaps.empty() || !setup_->volumes.empty() || !setup_->springs.empty() || !setup_->dilatations.empty())
    root_.refuse(what + "together with constraints, springs or laugon");
  for (const SurfaceLoad& load : setup_->surface_loads)
    if (!load.at_rest) root_.refuse(what + "together with a pressure or traction that follows its surface");
  for (const Domain& domain : built_->domains) {
    const Material& material = built_->materials[domain.material];
    if (material.relaxation) root_.refuse(what + "in a viscoelastic material");
    if (half && domain.whole_cell) root_.refuse("rhoi 1, or alpha 0.5, in a three-field-solid");
    if (half && !material.has_energy) root_.refuse("rhoi 1, or alpha 0.5, in a material without an energy");
  }
}

void ModelReader::read_linear_constraints(const Element& constraint) {
  constraint.allow({"laugon", "tol", "penalty", "rhs", "minaug", "maxaug", "linear_constraint"});
  if (constraint.number("rhs", 0) != 0) constraint.at("rhs").refuse("a sum other than 0");
  GapConstraint result;
  result.penalty = constraint.number("penalty", 1);
  result.augmentation = read_augmentation(constraint, "tol", 0.1, 50);
  if (!constraint.find("laugon")) result.augmentation.on = true;
  for (const Element& one : constraint.children()) {
    if (one.name() != "linear_constraint") continue;
    one.allow({"node"});
    Gap gap;
    for (const Element& node : one.children()) {
      node.allow_attributes({"id", "bc"});
      const std::string bc = node.needed_attribute("bc");
      const auto axis = std::find(std::begin(kAxes), std::end(kAxes), bc);
      if (axis == std::end(kAxes)) node.refuse("bc=\"" + bc + "\"", "x, y and z are");
      gap.terms.push_back(
          {mesh_.molecule(node, node.whole_attribute("id")), static_cast<int>(axis - kAxes), node.numbers(1).front()});
    }
    result.gaps.push_back(std::move(gap));
  }
  setup_->gaps.push_back(std::move(result));
}

/// Each node of the primary line is tied to the position on the secondary line that is nearest at rest.
void ModelReader::read_tied_line(const Element& constraint) {
  constraint.allow({"laugon", "tolerance", "penalty", "minaug", "maxaug", "max_distance", "primary", "secondary"});
  const Element primary = constraint.at("primary"), secondary = constraint.at("secondary");
  const auto lines = mesh_.edge(primary, primary.text()), targets = mesh_.edge(secondary, secondary.text());
  const Positions& rest = mesh_.body().rest;
  std::map<int, double> weights;
  for (const auto& line : lines)
    for (const int molecule : line) weights[molecule] += (rest.col(line[1]) - rest.col(line[0])).norm() / 2;
  const double furthest = constraint.number("max_distance", 0);
  GapConstraint result;
  result.penalty = constraint.number("penalty", 1);
  result.augmentation = read_augmentation(constraint, "tolerance", 0.01, 10);
  for (const auto& [molecule, weight] : weights) {
    double least = std::numeric_limits<double>::infinity(), part = 0;
    std::array<int, 2> nearest{};
    for (const auto& [a, b] : targets) {
      const Vector3 edge = rest.col(b) - rest.col(a), from = rest.col(molecule) - rest.col(a);
      const double at = from.dot(edge) / edge.squaredNorm(), distance = (from - at * edge).norm();
      if (at >= -1e-5 && at <= 1 + 1e-5 && distance < least) least = distance, part = at, nearest = {a, b};
    }
    if (!std::isfinite(least) || (furthest > 0 && least > furthest)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      Gap gap{{{molecule, axis, 1, rest(axis, molecule)},
               {nearest[0], axis, part - 1, rest(axis, nearest[0])},
               {nearest[1], axis, -part, rest(axis, nearest[1])}},
              weight};
      result.gaps.push_back(std::move(gap));
    }
  }
  if (result.gaps.empty()) constraint.fail("no node of the primary line is next to the secondary one");
  setup_->gaps.push_back(std::move(result));
}

/// A plane n · x = d + offset that the nodes of a surface do not pass, at the area at rest that each stands for.
void ModelReader::read_rigid_wall(const Element& constraint) {
  constraint.allow({"laugon", "tolerance", "penalty", "offset", "plane"});
  const std::vector<double> plane = constraint.at("plane").numbers(4);
  Vector3 normal(plane[0], plane[1], plane[2]);
  if (std::abs(normal.norm() - 1) > 1e-9)
    constraint.at("plane").fail("the normal, its first three numbers, must have length 1");
  GapConstraint result;
  result.penalty = constraint.number("penalty", 1);
  result.augmentation = read_augmentation(constraint, "tolerance", 0.01, 0);
  result.one_sided = true;
  if (const auto offset = constraint.find("offset")) result.shift = offset->value(controllers_);
  const Positions& rest = mesh_.body().rest;
  std::map<int, double> areas;
  for (const LoadedFace& face : mesh_.surface(constraint, constraint.needed_attribute("surface"))) {
    if (face.nodes.size() != 4) constraint.refuse("a rigid wall on faces other than quad4");
    const Eigen::MatrixXd own = positions_of(rest, face.nodes);
    for (Eigen::Index a = 0; a < 4; ++a) {
      const Eigen::MatrixXd edges = own * face.kind->function_slopes(face.kind->reference.col(a)).transpose();
      areas[face.nodes[a]] += Vector3(edges.col(0)).cross(Vector3(edges.col(1))).norm();
    }
  }
  for (const auto& [molecule, area] : areas) {
    Gap gap{{}, area, plane[3]};
    for (int axis = 0; axis < 3; ++axis)
      if (normal[axis] != 0) gap.terms.push_back({molecule, axis, -normal[axis], rest(axis, molecule)});
    result.gaps.push_back(std::move(gap));
  }
  setup_->gaps.push_back(std::move(result));
}

/// Lumped masses of the molecules, for everything but the steps: these have ∫ ρ N_a N_b dV.
void ModelReader::set_mass(Body& body) {
  const bool dynamic = std::any_of(setup_->steps.begin(), setup_->steps.end(), [](const Step& s) { return s.dynamic; });
  body.mass = VectorX::Zero(body.size());
  visit_points(
      [&](std::size_t block, std::span<const int> nodes, const VectorX& values, const Vector3&, double weight) {
        const double density = built_->materials[built_->domains[block].material].density;
        for (std::size_t a = 0; a < nodes.size(); ++a) {
          body.mass[nodes[a]] += weight * density / static_cast<double>(nodes.size());
          for (std::size_t b = 0; dynamic && b < nodes.size(); ++b)
            setup_->mass.push_back(
                {nodes[a], nodes[b],
                 weight * density * values[static_cast<Eigen::Index>(a)] * values[static_cast<Eigen::Index>(b)]});
        }
      });
  const double mean = body.mass.mean();
  for (double& mass : body.mass)
    if (mass == 0) mass = mean;  // at the end of a spring, in no cell
}

Body ModelReader::make_body() {
  Body body = mesh_.body();
  const auto& materials = built_->materials;
  const Material& first = materials[built_->domains.front().material];
  for (std::size_t i = 0; i < body.blocks.size(); ++i) {
    const Material& own = materials[built_->domains[i].material];
    if (own.youngs_modulus != first.youngs_modulus)
      body.blocks[i].stiffness = VectorX::Constant(body.blocks[i].size(), own.youngs_modulus / first.youngs_modulus);
  }
  set_simplices(body);
  set_matter(body, first.density, 0);
  set_mass(body);
  return body;
}

std::unique_ptr<lab::Scene> ModelReader::read() {
  root_.allow_attributes({"version"});
  refuse_sections(root_, {"Module", "Control", "Globals", "Material", "Mesh", "MeshDomains", "Boundary", "Loads",
                          "LoadData", "MeshData", "Step", "Output", "Discrete", "Constraints", "Rigid"});
  if (const auto data = root_.find("LoadData")) read_controllers(*data);
  if (const auto data = root_.find("MeshData")) read_data(*data);
  read_materials(root_.at("Material"));
  read_domains(root_.at("MeshDomains"));
  if (const auto boundary = root_.find("Boundary")) read_boundary(*boundary, -1);
  if (const auto rigid = root_.find("Rigid")) read_rigid(*rigid, -1);
  read_steps();
  drive_rigid_bodies();
  if (const auto loads = root_.find("Loads")) read_loads(*loads);
  if (const auto discrete = root_.find("Discrete")) read_discrete(*discrete);
  if (const auto constraints = root_.find("Constraints")) read_constraints(*constraints, -1);
  refuse_within();

  auto scene = std::make_unique<lab::Scene>();
  scene->specimen.body = make_body();
  const Material& first = built_->materials[built_->domains.front().material];
  scene->specimen.material.youngs_modulus = first.youngs_modulus;
  scene->specimen.material.poissons_ratio = first.poissons_ratio;
  scene->specimen.material.density = first.density;
  scene->notes.push_back("a model of FEBio has no units: its numbers count as m, kg, s, N and Pa");
  if (built_->materials.size() > 1)
    scene->notes.push_back(
        "strategies other than febio see the first material, stiffer cells by their Young's modulus");
  for (const auto& domain : mesh_.domains())
    if (domain.type == "tet10") {
      scene->notes.push_back("tet10: integrated at 4 points, where FEBio takes 8");
      break;
    }

  Strategy& strategy = scene->stiffness.strategy;
  strategy.name = scene->stiffness.label = "febio";
  strategy.summary = "each domain of a FEBio model with its own material";
  strategy.source = "[Maas et al. 2012]";
  strategy.kind = StrategyKind::cell_law;
  strategy.dimensions = 3;
  const std::size_t blocks = built_->domains.size();
  strategy.unsuited = [blocks](const Body& body) {
    return body.blocks.size() == blocks ? "" : "needs the cells of its own model";
  };
  strategy.make = [built = built_, clock = setup_->clock, stepped = setup_->within()](
                      const Body& body, const elastin::Material&, const ParameterValues&) {
    ElasticTerms terms;
    for (std::size_t i = 0; i < body.blocks.size(); ++i) {
      const Domain& domain = built->domains[i];
      terms.add(
          make_domain(body, body.blocks[i], built->materials[domain.material], domain.whole_cell, clock, stepped));
    }
    return terms;
  };
  scene->experiment = make_experiment(scene->specimen.body, setup_);
  return scene;
}

}  // namespace

std::unique_ptr<lab::Scene> load_model(const config::SceneSource& source) {
  auto document = std::make_shared<Document>();
  document->path = source.path();
  document->root = mesh::read_xml(source.path(), source.text());
  return ModelReader(std::move(document)).read();
}

}  // namespace elastin::febio
