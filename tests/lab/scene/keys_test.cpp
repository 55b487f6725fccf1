// The key reference is complete and names each key once; what it says of one is what reads it (config/keys.h).

#include "lab/scene/scene.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "lab/run/config_names.h"

using namespace elastin;
using namespace elastin::lab;

TEST_CASE("each key of the reference stands once in its map, with type, default and text", "[scene][keys]") {
  std::set<std::string> paths;
  for (const KeySection& section : key_sections(built_in_catalog(), built_in_experiments())) {
    std::set<std::string> names;
    for (const SceneKey& key : section.keys) {
      CAPTURE(section.path, section.heading, key.name);
      CHECK(names.insert(key.name).second);
      CHECK_FALSE(key.text.empty());
      CHECK_FALSE(key.fallback.empty());
      CHECK_FALSE(key.type.empty());
    }
    paths.insert(section.path);
  }
  for (const std::string path : {"", "body", "body.lattice", "experiment.tension", "contact", "time", "identify"}) {
    CAPTURE(path);
    CHECK(paths.contains(path));
  }
}

TEST_CASE("ranges of keys are written as one reads them", "[scene][keys]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CHECK(range_text(-infinity, infinity, false) == "");
  CHECK(range_text(0, infinity, true) == "> 0");
  CHECK(range_text(0, infinity, false) == "≥ 0");
  CHECK(range_text(-0.99, 0.5, false) == "−0.99 … 0.5");
  CHECK(range_text(0, 1, true) == "> 0 … 1");
}
