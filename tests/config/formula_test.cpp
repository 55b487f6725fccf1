// Numbers of a scene as formulas of named values.

#include "config/formula.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "config/scene_text.h"
#include "lab/run/config_names.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kValues =
    "values: {side: 30 mm, n: 10, E: 5 kPa, rho: 1000 kg/m3, gap: = side / n, free_fall: 9.81 m/s2}\n";

Reader of(const std::string& formula, const std::vector<std::string>& overrides = {}) {
  Reader reader = open_scene(SceneSource::of_text("a.yaml", kValues + "x: " + formula + "\n"), overrides, 1e6);
  return reader.at("x");
}

std::string refusal(const std::string& formula) {
  try {
    of(formula);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a formula gives a number with its unit", "[scene][formula]") {
  using namespace dimension;
  struct Row {
    const char* formula;
    Dimension unit;
    double value;
  };
  for (const Row& row : {Row{"= side / 9", length, 0.03 / 9},
                         {"= side/(n - 1)", length, 0.03 / 9},
                         {"= gap", length, 0.003},
                         {"= 2 * side + 1 mm", length, 0.061},
                         {"= -side + 40 mm", length, 0.01},
                         {"= side^2", area, 9e-4},
                         {"= side * side * side * rho", mass, 0.027},
                         {"= sqrt(side^2)", length, 0.03},
                         {"= max(side, 4 cm, 1 mm)", length, 0.04},
                         {"= rho * free_fall * side", pressure, 294.3},
                         {"= 1.1 g/cm3", density, 1100},
                         {"= 2 N s/m", damping, 2},
                         {"= 1000 kg/m3 * 3", density, 3000},
                         {"= 10 1/s", {0, 0, -1}, 10},
                         {"= 1 m * 10 1/ms^2 + 2 m/s2", acceleration, 1e7 + 2},
                         {"= E / 2 * 15 %", pressure, 375},
                         {"= 2 ^ 3 ^ 2", none, 512},
                         {"= 1 - 2 - 3", none, -4},
                         {"= 8 / 4 / 2", none, 1},
                         {"= sin(30 deg) + cos(pi)", none, -0.5},
                         {"= log(exp(2)) + abs(-1) + round(1.6) + floor(1.6) + ceil(1.2) + tan(0)", none, 8},
                         {"= 1e-3 * 1 m", length, 1e-3}}) {
    INFO(row.formula);
    CHECK(of(row.formula).quantity(row.unit) == Approx(row.value).epsilon(1e-14));
  }
  const StatedNumber stated =
      stated_number(SceneSource::of_text("a.yaml", "loads: [{rayleigh: {mass: 10 1/s}}]"), {}, "loads.0.rayleigh.mass");
  CHECK(stated.value == 10);
  CHECK(stated.unit == Dimension{0, 0, -1});
  CHECK(of("= n - 1").whole(1) == 9);
  CHECK(of("= side / 5 mm").whole(1) == 6);
  CHECK(of("= 0.1 + 0.2").text() == "0.3");
  CHECK(of("= 45 deg / 2").angle() == Approx(std::numbers::pi / 8));
  CHECK(of("\"= side\"").text() == "= side");  // what is quoted is text
  CHECK(of("[= n, = 2 * n, 5]").items(3)[1].whole(1) == 20);
}

TEST_CASE("the option --set changes the values that formulas are made of", "[scene][formula]") {
  CHECK(of("= gap", {"values.side=60 mm"}).quantity(dimension::length) == Approx(6e-3));
  // What no formula names changes nothing; a value may come with the formula that names it.
  CHECK_THROWS_WITH(of("= gap", {"values.sied=60 mm"}),
                    Contains("--set values.sied=60 mm: no formula of the scene names 'sied'; did you mean 'side'?"));
  CHECK(of("= gap", {"values.gap=2 * step", "values.step=4 mm"}).quantity(dimension::length) == Approx(8e-3));
  CHECK(of("1", {"x== side / 3"}).quantity(dimension::length) == Approx(0.01));
}

TEST_CASE("faults of a formula are reported at their position", "[scene][formula]") {
  for (const auto& [formula, message] : std::vector<std::pair<std::string, std::string>>{
           {"= sid / 9", "a.yaml:2:4: x: there is no value 'sid'; did you mean 'side'? (allowed: side, n, E, "},
           {"= side + E", "x: the formula 'side + E': adds Pa to m"},
           {"= side - 1", "subtracts a plain number from m"},
           {"= (side", "a bracket is not closed"},
           {"= side /", "it has no end"},
           {"= side side", "'side' is not expected there"},
           {"= 10 1/2", "'1/2' is not expected there"},
           {"= 10 1/side", "'1/side' is not expected there"},
           {"= sqrt(side)", "no unit is the square root of m"},
           {"= sine(1)", "there is no function 'sine'; did you mean 'sin'?"},
           {"= sin(side)", "sin needs a plain number, and this is m"},
           {"= 2 ^ side", "an exponent is a plain number"},
           {"= side ^ 0.5", "is a whole number up to 9"},
           {"= 1 / 0", "its result is no finite number"},
           {"=", "it has no end"}}) {
    INFO(formula);
    CHECK_THAT(refusal(formula), StartsWith("a.yaml:2:4: x: ") && Contains(message));
  }
  const auto values = [](const std::string& text) {
    try {
      open_scene(SceneSource::of_text("a.yaml", "values: " + text + "\nx: 1\n"), {}, 1e6);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(values("{a: = b, b: = a}"), Contains("is made of itself"));
  CHECK_THAT(values("{m: 3}"), StartsWith("a.yaml:1:10: values: 'm' is a unit; call it otherwise"));
  CHECK_THAT(values("{2a: 3}"), Contains("'2a' is no name"));
  CHECK_THAT(values("{a: 3 mn}"), StartsWith("a.yaml:1:13: values.a: "));
  CHECK_THAT(values("[1]"), Contains("expected a map of names"));
}

TEST_CASE("a formula that is nested too deeply is refused where it stands", "[scene][formula]") {
  const auto repeated = [](const std::string& text, int times) {
    std::string all;
    for (int i = 0; i < times; ++i) all += text;
    return all;
  };
  const auto deep = [&](int times) { return repeated("(", times) + "1" + repeated(")", times); };
  const std::string message = "more than 200 deep in each other";
  for (const int depth : {300, 20000}) {
    CHECK_THAT(refusal("= " + deep(depth)), StartsWith("a.yaml:2:4: x: the formula '(((") && Contains(message));
    CHECK_THAT(refusal("= " + repeated("-", depth) + "1"), Contains(message));
    CHECK_THAT(refusal("= " + repeated("2^", depth) + "1"), Contains(message));
    CHECK_THAT(refusal("= " + repeated("abs(", depth) + "1" + repeated(")", depth)), Contains(message));
    std::string chain = "values: {";
    for (int i = 0; i < depth; ++i) chain += "a" + std::to_string(i) + ": = a" + std::to_string(i + 1) + ", ";
    CHECK_THROWS_WITH(
        open_scene(SceneSource::of_text("a.yaml", chain + "a" + std::to_string(depth) + ": 1}\n"), {}, 1e6),
        StartsWith("a.yaml:1:") && Contains(message));
    CHECK_THROWS_WITH(open_scene(SceneSource::of_text("a.yaml", kValues), {"x== " + deep(depth)}, 1e6),
                      StartsWith("--set: x: the formula") && Contains(message));
    CHECK_THROWS_WITH(open_scene(SceneSource::of_text("a.yaml", kValues), {"x" + repeated(".x", depth) + "=1"}, 1e6),
                      StartsWith("--set x.x") && Contains("the path leads through more than 40 keys"));
    CHECK_THROWS_WITH(open_scene(SceneSource::of_text("a.yaml", "x: = " + deep(depth) + "\n"), {}, 1e6),
                      StartsWith("a.yaml:1:4: x: the formula") && Contains(message));
  }
  CHECK(of("= " + deep(100)).quantity(dimension::none) == 1);
}

TEST_CASE("a name that a formula would take for a unit's power names no value", "[scene][formula]") {
  for (const std::string name : {"m1", "N1", "mm2", "s3", "kPa4", "m²"})
    CHECK_THROWS_WITH(open_scene(SceneSource::of_text("a.yaml", "values: {" + name + ": 3}\n"), {}, 1e6),
                      StartsWith("a.yaml:1:10: values: '" + name + "' is a unit; call it otherwise"));
  CHECK_NOTHROW(open_scene(SceneSource::of_text("a.yaml", "values: {m_1: 3, n1: 4, force1: 5}\n"), {}, 1e6));
}

TEST_CASE("another language of formulas has its own powers and functions, and no units", "[formula]") {
  const config::FormulaLanguage language{
      .units = false, .powers_from_left = true, .functions = {{"log", [](double x) { return std::log10(x); }}}};
  const auto name = [](const std::string& word) -> config::FormulaValue {
    if (word == "m") return {7, {}};
    throw InputError("no " + word);
  };
  const auto value = [&](const std::string& text) { return config::formula_value(text, name, language).number; };
  CHECK(value("2 ^ 3 ^ 2") == 64);
  CHECK(value("2 ^ -1 * 4") == 2);
  CHECK(value("-2 ^ 2") == -4);
  CHECK(value("log(1000) + exp(0)") == Approx(4));
  CHECK(value("3 * m") == 21);
  CHECK_THROWS_WITH(value("3 m"), Contains("'m' is not expected there"));
  CHECK_THROWS_WITH(value("3 * mm"), Contains("no mm"));
  CHECK_THROWS_WITH(value("lg(1)"), Contains("there is no function 'lg'; did you mean 'log'?"));
}
