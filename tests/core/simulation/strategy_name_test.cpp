#include "elastin/core/simulation/strategy_name.h"

#include <catch2/catch.hpp>

#include "elastin/core/simulation/catalog.h"

using namespace elastin;

TEST_CASE("a strategy's name is read into its properties and written back", "[strategy_name]") {
  struct Case {
    const char *text, *rule;
    bool relaxed, softened, calibrated, volume, wrinkling;
  };
  for (const Case& c : {Case{"lattice", "lattice", false, false, false, false, false},
                        Case{"prony:mullins:calibrated:patch+volume", "patch", true, true, true, true, false},
                        Case{"curve_membrane+wrinkling", "curve_membrane", false, false, false, false, true},
                        Case{"mullins:neo_hookean+volume", "neo_hookean", false, true, false, true, false}}) {
    const StrategyName name(c.text);
    CAPTURE(c.text);
    CHECK(name.rule == c.rule);
    CHECK(name.relaxed == c.relaxed);
    CHECK(name.softened == c.softened);
    CHECK(name.calibrated == c.calibrated);
    CHECK(name.volume == c.volume);
    CHECK(name.wrinkling == c.wrinkling);
    CHECK(name.text() == c.text);
    CHECK(built_in_catalog().find(name).name == c.text);
  }
  CHECK(StrategyName("calibrated").text() == "calibrated:standard");
  CHECK(StrategyName("prony:calibrated+volume").text() == "prony:calibrated:standard+volume");
  CHECK(StrategyName::of_law("ogden", 2).text() == "ogden_membrane");
  CHECK(StrategyName("ogden_membrane+wrinkling").law() == "ogden");
  CHECK(StrategyName("a label: by + hand").text() == "a label: by + hand");
}
