#include "scene/parts.h"

#include <cmath>

#include "experiment/faces.h"

namespace elastin {

StrategyChoice read_strategy(Reader reader, const Catalog& catalog) {
  if (reader.is_text()) return reader.located([&] { return choose_strategy(catalog, reader.text()); });
  const Reader name = reader.at("strategy");
  StrategyChoice choice = name.located([&] { return choose_strategy(catalog, name.text()); });
  for (const ParameterInfo& info : choice.strategy.parameters)
    if (auto value = reader.find(info.name))
      choice.values[info.name] = value->quantity(info.unit, {info.low, info.high});
  if (auto volume = reader.find("volume")) {
    const bool springs = choice.strategy.kind != StrategyKind::cell_law;
    const auto words = springs ? std::vector<std::pair<std::string, bool>>{{"true", true}, {"false", false}}
                               : std::vector<std::pair<std::string, bool>>{{"averaged", true}, {"cells", false}};
    if (choice.strategy.volume_modulus) volume->fail("'" + choice.label + "' says it already");
    if (volume->choice(words)) choice = volume->located([&] { return with_volume(std::move(choice)); });
  }
  if (auto wrinkling = reader.find("wrinkling");
      wrinkling && wrinkling->choice<bool>({{"drop", true}, {"keep", false}}))
    choice = wrinkling->located([&] { return with_wrinkling(std::move(choice)); });
  if (auto label = reader.find("label")) choice.label = label->text();
  reader.finish();
  return choice;
}

Vector3 read_direction(const Reader& reader) {
  if (!reader.is_text()) {
    const Vector3 direction = reader.vector(dimension::none);
    if (!(direction.norm() > 0)) reader.fail("a direction must not be zero");
    return direction.normalized();
  }
  return reader.choice<Vector3>({{"x", Vector3::UnitX()},
                                 {"y", Vector3::UnitY()},
                                 {"z", Vector3::UnitZ()},
                                 {"-x", -Vector3::UnitX()},
                                 {"-y", -Vector3::UnitY()},
                                 {"-z", -Vector3::UnitZ()}});
}

Matrix3 read_rotation(Reader reader) {
  const Vector3 axis = read_direction(reader.at("axis"));
  const double angle = reader.at("angle").quantity(dimension::none);
  reader.finish();
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

StaticOptions read_solver(Reader reader) {
  StaticOptions options;
  if (auto value = reader.find("displacements"))
    options.linear = value->choice<bool>({{"large", false}, {"small", true}});
  if (auto value = reader.find("linear_solver"))
    options.method = value->choice<LinearMethod>(
        {{"automatic", LinearMethod::automatic}, {"pcg", LinearMethod::pcg}, {"direct", LinearMethod::direct}});
  if (auto value = reader.find("tolerance")) options.tolerance = value->quantity(dimension::none, {1e-14, 0.1, false});
  if (auto value = reader.find("newton_limit")) options.newton_limit = value->whole(1, 100000);
  reader.finish();
  return options;
}

namespace {

SceneLoad read_drag(Reader reader) {
  const bool stokes = reader.at("kind").choice<bool>({{"stokes", true}, {"quadratic", false}});
  if (stokes) {
    const double viscosity = reader.at("viscosity").quantity(dimension::viscosity, kNotNegative);
    reader.finish();
    return {[=](Model& model) { model.add(make_stokes_drag(model.body(), viscosity)); }, false};
  }
  const double density = reader.at("density").quantity(dimension::density, kNotNegative);
  const double coefficient = reader.at("drag_coefficient").quantity(dimension::none, kNotNegative);
  reader.finish();
  return {[=](Model& model) { model.add(make_quadratic_drag(model.body(), density, coefficient)); }, false};
}

SceneLoad read_damping(const Reader& reader, const Body&) {
  const double coefficient = reader.quantity(dimension::damping, kNotNegative);
  return {[=](Model& model) { model.add(make_damping(coefficient)); }, false};
}

SceneLoad read_cell_damping(Reader reader, const Body& body) {
  const double bulk = reader.at("bulk").quantity(dimension::viscosity, kNotNegative);
  const double shear = reader.at("shear").quantity(dimension::viscosity, kNotNegative);
  reader.finish();
  if (body.tetrahedra.empty()) reader.fail("needs a body with tetrahedra; `damping` works on connections");
  return {[=](Model& model) { model.add(make_cell_damping(model.body(), bulk, shear)); }, false};
}

SceneLoad read_point(Reader reader, const Body& body, const Matrix3& rotation) {
  std::vector<int> molecules;
  for (const Reader& item : reader.at("molecules").items()) molecules.push_back(item.whole(0, body.size() - 1));
  const Vector3 force = rotation * reader.at("force").vector(dimension::force);
  reader.finish();
  return {[=](Model& model) {
    model.add(std::make_unique<PointLoads>(model.body(), molecules,
                                           force.replicate(1, static_cast<Eigen::Index>(molecules.size()))));
  }};
}

SceneLoad read_face(Reader reader, const Body& body, const Matrix3& rotation) {
  const Vector3 side = rotation * read_direction(reader.at("side"));
  const Vector3 traction = rotation * reader.at("traction").vector(dimension::pressure);
  reader.finish();
  const Face face = reader.located([&] { return end_face(body, side, 0); });
  if (!(face.area > 0)) reader.fail("the molecules on this side span no area");
  return {[=](Model& model) {
    model.add(
        std::make_unique<PointLoads>(model.body(), face.molecules, face.area * traction * face.share.transpose()));
  }};
}

}  // namespace

SceneLoad read_load(Reader reader, const Body& body, const Matrix3& rotation) {
  const auto gravity = reader.find("gravity"), drag = reader.find("drag"), damping = reader.find("damping"),
             cell_damping = reader.find("cell_damping"), point = reader.find("point"), face = reader.find("face");
  reader.finish();
  if (gravity.has_value() + drag.has_value() + damping.has_value() + cell_damping.has_value() + point.has_value() +
          face.has_value() !=
      1)
    reader.fail("a load is one of gravity, drag, damping, cell_damping, point, face; write each as an item of its own");
  if (drag) return read_drag(*drag);
  if (damping) return read_damping(*damping, body);
  if (cell_damping) return read_cell_damping(*cell_damping, body);
  if (point) return read_point(*point, body, rotation);
  if (face) return read_face(*face, body, rotation);
  const Vector3 acceleration = rotation * gravity->vector(dimension::acceleration);
  return {[=](Model& model) { model.add(make_gravity(model.body(), acceleration)); }};
}

}  // namespace elastin
