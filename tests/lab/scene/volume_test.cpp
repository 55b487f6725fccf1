// The key `volume` of a strategy: what each shape of cell has, and what it has not.

#include <catch2/catch.hpp>

#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

/// Why the strategy cannot run on the body, or its name.
std::string chosen(const std::string& body, const std::string& strategy, const std::string& volume,
                   const std::string& nu = "0.45") {
  static const Catalog catalog = built_in_catalog();
  const TemporaryFolder folder;
  const auto scene =
      load_scene(folder.write("scene.yaml", "title: a block\nbody: {" + body +
                                                "}\nmaterial: {youngs_modulus: 5 kPa, poissons_ratio: " + nu +
                                                "}\n"
                                                "stiffness: {strategy: " +
                                                strategy + (volume.empty() ? "" : ", volume: " + volume) +
                                                "}\nexperiment: {kind: tension, axis: z, strain: 1 %}\n"),
                 catalog);
  const std::string why = scene->stiffness.strategy.unsuited(scene->specimen.body);
  return why.empty() ? scene->stiffness.strategy.name : why;
}

}  // namespace

TEST_CASE("volume: chooses what the cells have to keep their volume", "[scene]") {
  const std::string tetrahedra = "tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [5 mm, 5 mm, 5 mm], order: ",
                    lattice = "lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 5 mm, order: ",
                    springs = "lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 5 mm, connections: [axis, face]}",
                    with = "neo_hookean+volume";
  for (const char* word : {"automatic", "averaged"}) {
    CHECK(chosen(tetrahedra + "1}", "neo_hookean", word) == with);
    CHECK(chosen(lattice + "2}", "neo_hookean", word) == with);
  }
  for (const char* word : {"none", "cells"}) CHECK(chosen(lattice + "2}", "neo_hookean", word) == "neo_hookean");
  CHECK(chosen(lattice + "1}", "neo_hookean", "mean_dilatation") == with);
  CHECK(chosen(tetrahedra + "2}", "neo_hookean", "mean_dilatation") == with);
  CHECK(chosen(lattice + "2}", "neo_hookean", "linear_pressure") == with);
  for (const char* word : {"true", "automatic"}) CHECK(chosen(springs, "lattice", word) == "lattice+volume");
  CHECK_THAT(chosen(lattice + "2}", "neo_hookean", "mean_dilatation"),
             Contains("hexahedra of 27 nodes have no mean_dilatation") && Contains("linear_pressure"));
  CHECK_THAT(chosen(lattice + "1}", "neo_hookean", "linear_pressure"),
             Contains("hexahedra have no linear_pressure") && Contains("mean_dilatation"));
  CHECK_THAT(chosen(tetrahedra + "1}", "neo_hookean", "mean_dilatation"), Contains("volume: automatic"));
  CHECK_THROWS_WITH(chosen(springs, "lattice", "linear_pressure"), Contains("allowed: true, false, automatic, none"));
  CHECK_THROWS_WITH(chosen(lattice + "2}", "neo_hookean", "mean_dilation"),
                    Contains("scene.yaml") && Contains("mean_dilatation"));
  CHECK_THROWS_WITH(chosen(lattice + "2}", with, "automatic"), Contains("has a volume term already"));
  CHECK_THROWS_WITH(chosen(lattice + "2}", "st_venant_kirchhoff", "automatic"), Contains("volume term goes with"));
}

TEST_CASE("the range of a volume term is said of the number that the scene states", "[scene]") {
  static const Catalog catalog = built_in_catalog();
  const auto refusal = [](const std::string& material) {
    const TemporaryFolder folder;
    try {
      load_scene(folder.write("scene.yaml",
                              "title: a block\nbody: {tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [5 mm, 5 mm, 5 "
                              "mm]}}\nmaterial: " +
                                  material +
                                  "\nstiffness: mooney_rivlin+volume\nexperiment: {kind: tension, axis: z, strain: 1 "
                                  "%}\n"),
                 catalog);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  // G = 2 (c1 + c2) = 20 kPa; nu = 0.4999 is K = 2 G 1.4999 / (3 0.0002) = 99.9933 MPa, and nu = 0 is K = 2 G / 3.
  const std::string law = "{law: mooney_rivlin, c1: 8 kPa, c2: 2 kPa, bulk_modulus: ";
  CHECK(refusal(law + "99.9 MPa}") == "");
  CHECK_THAT(refusal(law + "100 MPa}"),
             Contains("scene.yaml:3:") && Contains("20000 Pa") &&
                 Contains("material.bulk_modulus: a bulk modulus of 1e+08 Pa is out of range: the volume term "
                          "(+volume) takes 13333.3 to 9.99933e+07 Pa") &&
                 !Contains("poissons_ratio"));
}

TEST_CASE("a law in `stiffness` does not lock unless the scene says so", "[scene]") {
  const std::string tetrahedra = "tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [5 mm, 5 mm, 5 mm], order: ",
                    lattice = "lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 5 mm, order: ",
                    with = "neo_hookean+volume";
  for (const std::string& body : {tetrahedra, lattice})
    for (const std::string order : {"1}", "2}"}) {
      INFO(body + order);
      CHECK(chosen(body + order, "neo_hookean", "") == with);
      CHECK(chosen(body + order, "neo_hookean", "", "0.499") == with);
      CHECK(chosen(body + order, "neo_hookean", "", "0.4") == "neo_hookean");
      CHECK(chosen(body + order, "neo_hookean", "none") == "neo_hookean");
    }
  CHECK(chosen(lattice + "2}", "st_venant_kirchhoff", "") == "st_venant_kirchhoff");  // its energy has no volume part
  CHECK(chosen(tetrahedra + "1}", "van_gelder", "") == "van_gelder");
  CHECK(chosen(tetrahedra + "1}", with, "") == with);

  static const Catalog catalog = built_in_catalog();
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write("scene.yaml", "title: a block\nbody: {" + tetrahedra +
                                     "1}}\nmaterial: {youngs_modulus: 5 kPa, poissons_ratio: 0.45}\n"
                                     "stiffness: {strategy: neo_hookean, label: soft}\nstrategies: [neo_hookean]\n"
                                     "experiment: {kind: tension, axis: z, strain: 1 %}\n"),
      catalog);
  CHECK(scene->stiffness.label == "soft");
  CHECK(scene->stiffness.strategy.name == with);
  CHECK(scene->strategies.at(0).strategy.name == "neo_hookean");  // a comparison compares what it names
  REQUIRE(scene->notes.size() == 1);
  CHECK_THAT(scene->notes[0], Contains(with) && Contains("volume: none"));
}
