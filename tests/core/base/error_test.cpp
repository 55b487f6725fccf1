#include "elastin/core/base/error.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/base/shell_word.h"

using namespace elastin;

TEST_CASE("the nearest name is the one with the fewest mistakes", "[error]") {
  const std::vector<std::string> names{"radius", "lattice", "packing", "tetrahedra", "mesh", "x"};
  struct Row {
    const char* word;
    const char* nearest;
  };
  for (const Row& row : std::vector<Row>{{"raduis", "radius"},          // two neighbours swapped
                                         {"radus", "radius"},           // a letter missing
                                         {"raddius", "radius"},         // one too many
                                         {"latice", "lattice"},         //
                                         {"Lattice", "lattice"},        // one wrong
                                         {"tetraedron", "tetrahedra"},  // a third of ten letters
                                         {"mehs", "mesh"},              //
                                         {"radius", "radius"},          //
                                         {"diameter", ""},              // nothing near
                                         {"w", ""},                     // every letter wrong is not near
                                         {"", ""}}) {
    INFO(row.word);
    CHECK(nearest_name(row.word, names) == row.nearest);
  }
  CHECK(nearest_name("radius", {}).empty());
  CHECK(nearest_name("face", {"fase", "faces", "face"}) == "face");
}

TEST_CASE("a suggestion says the nearest name and what is allowed", "[error]") {
  CHECK(suggestion("raduis", {"radius", "mesh"}) == "; did you mean 'radius'? (allowed: radius, mesh)");
  CHECK(suggestion("diameter", {"radius", "mesh"}) == "; allowed: radius, mesh");
}

TEST_CASE("an input error starts with its place, once", "[error]") {
  CHECK(SourceLocation{"a.yaml", 3, 7}.text() == "a.yaml:3:7");
  CHECK(SourceLocation{"a.yaml", 3, 0}.text() == "a.yaml:3");
  CHECK(SourceLocation{"a.yaml", 0, 7}.text() == "a.yaml");
  const InputError located(SourceLocation{"a.yaml", 3, 7}, "wrong"), bare("wrong");
  CHECK(std::string(located.what()) == "a.yaml:3:7: wrong");
  CHECK(located.has_location());
  CHECK(std::string(bare.what()) == "wrong");
  CHECK_FALSE(bare.has_location());
}

TEST_CASE("a word of a command line is quoted where a shell would not read it as it is", "[error]") {
  CHECK(shell_word("scenes/bar-1.yaml") == "scenes/bar-1.yaml");
  CHECK(shell_word("Hände.yaml") == "Hände.yaml");
  CHECK(shell_word("my bar.yaml") == "'my bar.yaml'");
  CHECK(shell_word("$(x)'s;") == "'$(x)'\\''s;'");
  CHECK(shell_word("") == "''");
}
