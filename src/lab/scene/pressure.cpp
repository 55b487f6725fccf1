#include "lab/scene/parts.h"

namespace elastin::lab {
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

}  // namespace elastin::lab
