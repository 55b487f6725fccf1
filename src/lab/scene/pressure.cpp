#include "elastin/core/forces/pressure.h"

#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Throws where the triangles have no common outside, before any run.
void add_pressure(Model& model, const PressureLaw& law) {
  const Vector3 middle = model.body().rest.rowwise().mean();
  model.add(std::make_unique<Pressure>(model.body(), law, middle, false));
}

SceneLoad checked(const Reader& reader, const Body& body, const PressureLaw& law) {
  reader.located([&] {
    Model model(body);
    add_pressure(model, law);
  });
  return {[=](Model& model) { add_pressure(model, law); }};
}

}  // namespace

GasSetup read_gas(Reader reader) {
  GasSetup gas;
  const auto amount = reader.find("amount"), start = reader.find("start_pressure");
  if (amount) gas.amount = amount->quantity(dimension::energy, kPositive);
  if (start) gas.start_pressure = start->quantity(dimension::pressure, kPositive);
  if (auto exponent = reader.find("exponent")) gas.exponent = exponent->quantity(dimension::none, {1, 2});
  if (auto ambient = reader.find("ambient")) gas.ambient = ambient->quantity(dimension::pressure, kNotNegative);
  reader.finish();
  if (amount.has_value() == start.has_value())
    reader.fail("give one of amount (absolute pressure times volume, n R T) and start_pressure (absolute)");
  return gas;
}

SceneLoad read_pressure(const Reader& reader, const Body& body) {
  return checked(reader, body, constant_pressure(reader.quantity(dimension::pressure)));
}

SceneLoad read_gas_load(const Reader& reader, const Body& body) {
  const GasSetup gas = read_gas(reader);
  const Vector3 middle = body.rest.rowwise().mean();
  const double volume = enclosed_volume(body.triangles, body.rest, middle);
  if (inspect_surface(body.triangles).rim_sides > 0 || !(volume > 0))
    reader.fail("gas needs a closed surface of triangles that look outwards");
  const double amount = gas.amount > 0 ? gas.amount : gas.start_pressure * volume;
  return checked(reader, body, enclosed_gas(amount, gas.exponent, gas.ambient));
}

}  // namespace elastin::lab
