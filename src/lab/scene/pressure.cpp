#include "lab/scene/parts.h"

namespace elastin::lab {

GasSetup read_gas(Reader reader) {
  reader.set_section("gas");
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

std::vector<KeySection> gas_keys() {
  return {{"gas",
           "",
           "The `gas` of `kind: inflation`, which fills the membrane in proportion to the load:",
           {{"amount", "quantity", "J", "> 0", "this, or `start_pressure`", "absolute pressure times volume, n R T"},
            {"start_pressure", "quantity", "Pa", "> 0", "this, or `amount`", "absolute pressure in the volume at rest"},
            {"exponent", "number", "", "1 … 2", "1", "1: constant temperature; 1.4: air without exchange of heat"},
            {"ambient", "quantity", "Pa", "≥ 0", "101325", "absolute pressure outside"}}}};
}

}  // namespace elastin::lab
