#include "elastin/core/base/units.h"

#include <catch2/catch.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"

using namespace elastin;

namespace {

std::string error_of(const std::string& text, const Dimension& wanted) {
  try {
    parse_quantity(text, wanted);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a number and its unit give the value in SI units", "[units]") {
  struct Row {
    const char* text;
    Dimension wanted;
    double value;
    bool has_unit = true;
  };
  using namespace dimension;
  const double pi = std::numbers::pi;
  const std::vector<Row> rows{
      {"15 mm", length, 0.015},
      {"15mm", length, 0.015},
      {"  2.5   cm ", length, 0.025},
      {"0.1 m", length, 0.1},
      {"-3 um", length, -3e-6},
      {"+3 µm", length, 3e-6},  // the micro sign
      {"3 μm", length, 3e-6},   // the Greek letter
      {"7 nm", length, 7e-9},
      {"2 km", length, 2000},
      {"9 cm2", area, 9e-4},
      {"9 cm^2", area, 9e-4},
      {"9 cm²", area, 9e-4},
      {"24 mm2", area, 24e-6},
      {"1 m m", area, 1},
      {"2 l", volume, 2e-3},
      {"3 ml", volume, 3e-6},
      {"1 dm³", volume, 1e-3},
      {"5 g", mass, 5e-3},
      {"2 kg", mass, 2},
      {"1 t", mass, 1000},
      {"2 ms", dimension::time, 2e-3},
      {"2 min", dimension::time, 120},
      {"1e3 N", force, 1000},
      {"1.5e-3 kN", force, 1.5},
      {"45 uN", force, 45e-6},
      {"45 µN", force, 45e-6},
      {"1 kg m/s2", force, 1},
      {"5 kPa", pressure, 5000},
      {"1.2 MPa", pressure, 1.2e6},
      {"2 GPa", pressure, 2e9},
      {"7 hPa", pressure, 700},
      {"1 bar", pressure, 1e5},
      {"20 mbar", pressure, 2000},
      {"120 mmHg", pressure, 120 * 133.322387415},
      {"4 N/mm^2", pressure, 4e6},
      {"1000 kg/m3", density, 1000},
      {"1.1 g/cm3", density, 1100},
      {"1 kg m^-3", density, 1},
      {"36 km/min", velocity, 600},
      {"9.81 m/s2", acceleration, 9.81},
      {"9.81 m/s/s", acceleration, 9.81},
      {"200 N/m", stiffness, 200},
      {"2 N s/m", damping, 2},
      {"2 N*s/m", damping, 2},
      {"1 mPa s", viscosity, 1e-3},
      {"1 Pa·s", viscosity, 1},
      {"3 mJ", energy, 3e-3},
      {"0.2 %", none, 2e-3},
      {"30 deg", none, pi / 6},
      {"30 °", none, pi / 6},
      {"1 rad", none, 1},
      {"5 mm/m", none, 5e-3},
      {"0.25", none, 0.25, false},
      {"-1e-3", none, -1e-3, false},
      {"+4", length, 4, false},  // a plain number is in SI units
      {"5000", pressure, 5000, false},
      {"0", force, 0, false},
  };
  for (const Row& row : rows) {
    INFO(row.text);
    const Quantity quantity = parse_quantity(row.text, row.wanted);
    CHECK(quantity.value == Approx(row.value).epsilon(1e-14).margin(0));  // a few roundings
    CHECK(quantity.has_unit == row.has_unit);
  }
}

TEST_CASE("a unit of another dimension is refused, with examples of what fits", "[units]") {
  CHECK(error_of("1 mm", dimension::force) ==
        "'mm' cannot be converted to N; write a number and its unit, for example 1 N, 5 kN");
  CHECK(error_of("1 mm", dimension::none) ==
        "'mm' cannot be converted to a plain number; write a number, for example 0.3, 20 %, 30 deg");
  CHECK(error_of("5 %", dimension::length) ==
        "'%' cannot be converted to m; write a number and its unit, for example 15 mm, 2 cm, 0.1 m");
  CHECK_THAT(error_of("5 N", dimension::pressure), Catch::StartsWith("'N' cannot be converted to Pa"));
  CHECK_THAT(error_of("5 N m", dimension::stiffness), Catch::StartsWith("'N m' cannot be converted to N/m"));
}

TEST_CASE("an unknown unit is refused and named", "[units]") {
  for (const auto& [text, name] :
       std::vector<std::pair<std::string, std::string>>{{"5 kPaa", "kPaa"},
                                                        {"5 pascal", "pascal"},
                                                        {"5 kmmHg", "kmmHg"},
                                                        {"1 Kpa", "Kpa"},
                                                        {"5 e", "e"},

                                                        {"5 kPa/", "kPa/"},
                                                        {"5 kPa//m", "kPa//m"},
                                                        {"5 m^0", "m"},
                                                        {"5 m^10", "m"},
                                                        {"5 m^99999999999", "m^99999999999"}}) {
    INFO(text);
    CHECK_THAT(error_of(text, dimension::pressure), Catch::StartsWith("unknown unit '" + name + "'"));
  }
}

TEST_CASE("a number written as elsewhere is refused with what to write", "[units]") {
  for (const auto& [text, hint] : std::vector<std::pair<std::string, std::string>>{
           {"1,5 kPa", "write 1.5 kPa;"},
           {"-0,5 kPa", "write -0.5 kPa;"},
           {"1,100 kPa", "write 1.100 kPa, or 1100 kPa if thousands are meant;"},
           {"1,100.5 kPa", "write 1100.5 kPa;"},
           {"1 000 Pa", "write 1000 Pa;"},
           {"1'000'000 Pa", "write 1000000 Pa;"},
           {"1.2*10^6 Pa", "write 1.2e6 Pa;"},
           {"1.2 x 10^+6 Pa", "write 1.2e6 Pa;"},
           {"6/2 kPa", "write = 6 kPa / 2;"},
           {"1.0 - 1.4 MPa", "one number is needed, not a range;"},
           {"~1.2 MPa", "write the number alone: 1.2 MPa;"},
           {"1.2 MPa (skin)", "write 1.2 MPa  # (skin);"},
           {"5 Kpa", "did you mean 'kPa'?"},
           {"5 MPA", "did you mean 'MPa'?"},
           {"5 kilopascals", "did you mean 'kPa'?"},
           {"5 kPa.", "did you mean 'kPa'?"},
           {"5 psi", "1 psi is 6.8948 kPa;"},
       }) {
    INFO(text);
    CHECK_THAT(error_of(text, dimension::pressure), Catch::Contains(hint));
  }
  // Signs of printed text are those of a keyboard.
  CHECK(parse_quantity("\u22121.5\u00a0kPa", dimension::pressure).value == -1500);
  CHECK(parse_quantity("30 degrees", dimension::none).value == Approx(std::numbers::pi / 6));
}

TEST_CASE("what is no finite number is refused", "[units]") {
  for (const char* text : {"", " ", "abc", "mm", "mm 15", "nan", "NaN Pa", "inf", "-inf Pa", "infinity", "1e999 Pa",
                           "+-1 Pa", "++1", "- 1", "--1", ".", "-", "1e308 MPa"}) {
    INFO(text);
    CHECK_THAT(error_of(text, dimension::pressure),
               Catch::StartsWith("'" + std::string(text == std::string(" ") ? "" : text) + "'"));
    CHECK_THAT(error_of(text, dimension::pressure), Catch::EndsWith("for example 5 kPa, 1.2 MPa"));
  }
}

TEST_CASE("the SI unit of a dimension", "[units]") {
  using namespace dimension;
  CHECK(si_unit(none) == "");
  CHECK(si_unit(length) == "m");
  CHECK(si_unit(area) == "m^2");
  CHECK(si_unit(density) == "kg/m^3");
  CHECK(si_unit(force) == "N");
  CHECK(si_unit(pressure) == "Pa");
  CHECK(si_unit(stiffness) == "N/m");
  CHECK(si_unit(damping) == "N s/m");
  CHECK(si_unit(viscosity) == "Pa s");
  CHECK(si_unit(energy) == "J");
  CHECK(si_unit(velocity) == "m/s");
  CHECK(si_unit({0, 0, -1}) == "1/s");
}

TEST_CASE("examples and SI units of a dimension are units of it", "[units]") {
  using namespace dimension;
  for (const Dimension& wanted : {none, length, area, volume, mass, dimension::time, force, pressure, density, velocity,
                                  acceleration, stiffness, damping, viscosity, energy}) {
    std::string examples = unit_examples(wanted) + ",";
    INFO(examples);
    for (std::size_t comma; (comma = examples.find(',')) != std::string::npos; examples.erase(0, comma + 1))
      CHECK_NOTHROW(parse_quantity(examples.substr(0, comma), wanted));
    CHECK(parse_quantity("1 " + si_unit(wanted), wanted).value == 1);
  }
}
