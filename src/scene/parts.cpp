#include "scene/parts.h"

#include <cmath>

#include "experiment/faces.h"

namespace elastin {

Material read_material(Reader reader) {
  Material material;
  material.youngs_modulus = reader.at("youngs_modulus").quantity(dimension::pressure, kPositive);
  if (auto value = reader.find("poissons_ratio"))
    material.poissons_ratio = value->quantity(dimension::none, {-0.99, 0.4999, false});
  if (auto value = reader.find("density")) material.density = value->quantity(dimension::density, kPositive);
  if (auto value = reader.find("thickness")) material.thickness = value->quantity(dimension::length, kPositive);
  reader.finish();
  return material;
}

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

using MakeLoad = std::function<std::unique_ptr<Load>(const Body&)>;

MakeLoad read_drag(Reader reader) {
  const bool stokes = reader.at("kind").choice<bool>({{"stokes", true}, {"quadratic", false}});
  if (stokes) {
    const double viscosity = reader.at("viscosity").quantity(dimension::viscosity, kNotNegative);
    reader.finish();
    return [=](const Body& body) { return make_stokes_drag(body, viscosity); };
  }
  const double density = reader.at("density").quantity(dimension::density, kNotNegative);
  const double coefficient = reader.at("drag_coefficient").quantity(dimension::none, kNotNegative);
  reader.finish();
  return [=](const Body& body) { return make_quadratic_drag(body, density, coefficient); };
}

MakeLoad read_cell_damping(Reader reader, const Body& body) {
  const double bulk = reader.at("bulk").quantity(dimension::viscosity, kNotNegative);
  const double shear = reader.at("shear").quantity(dimension::viscosity, kNotNegative);
  reader.finish();
  if (body.tetrahedra.empty()) reader.fail("needs a body with tetrahedra; `damping` works on connections");
  return [=](const Body& damped) { return make_cell_damping(damped, bulk, shear); };
}

MakeLoad read_point(Reader reader, const Body& body, const Matrix3& rotation) {
  std::vector<int> molecules;
  for (const Reader& item : reader.at("molecules").items()) molecules.push_back(item.whole(0, body.size() - 1));
  const Vector3 force = rotation * reader.at("force").vector(dimension::force);
  reader.finish();
  return [=](const Body& loaded) {
    return std::make_unique<PointLoads>(loaded, molecules,
                                        force.replicate(1, static_cast<Eigen::Index>(molecules.size())));
  };
}

MakeLoad read_face(Reader reader, const Body& body, const Matrix3& rotation) {
  const Vector3 side = rotation * read_direction(reader.at("side"));
  const Vector3 traction = rotation * reader.at("traction").vector(dimension::pressure);
  reader.finish();
  const Face face = reader.located([&] { return end_face(body, side, 0); });
  if (!(face.area > 0)) reader.fail("the molecules on this side span no area");
  return [=](const Body& loaded) {
    return std::make_unique<PointLoads>(loaded, face.molecules, face.area * traction * face.share.transpose());
  };
}

}  // namespace

MakeLoad read_load(Reader reader, const Body& body, const Matrix3& rotation, std::vector<std::string>& warnings) {
  const auto gravity = reader.find("gravity"), drag = reader.find("drag"), damping = reader.find("damping"),
             cell_damping = reader.find("cell_damping"), point = reader.find("point"), face = reader.find("face");
  reader.finish();
  if (gravity.has_value() + drag.has_value() + damping.has_value() + cell_damping.has_value() + point.has_value() +
          face.has_value() !=
      1)
    reader.fail("a load is one of gravity, drag, damping, cell_damping, point, face; write each as an item of its own");
  MakeLoad load;
  if (gravity) {
    const Vector3 acceleration = rotation * gravity->vector(dimension::acceleration);
    load = [=](const Body& loaded) { return make_gravity(loaded, acceleration); };
  } else if (drag) {
    load = read_drag(*drag);
  } else if (damping) {
    const double coefficient = damping->quantity(dimension::damping, kNotNegative);
    load = [=](const Body& loaded) { return make_damping(loaded, coefficient); };
  } else if (cell_damping) {
    load = read_cell_damping(*cell_damping, body);
  } else if (point) {
    load = read_point(*point, body, rotation);
  } else {
    load = read_face(*face, body, rotation);
  }
  if (!load(body)->acts_at_rest())
    warnings.push_back(reader.path() + ": acts on moving bodies only; it changes nothing in a static experiment");
  return load;
}

}  // namespace elastin
