#include "elastin/core/simulation/parts.h"

#include <catch2/catch.hpp>

#include "core/simulation/fibres.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/parts.h"
#include "elastin/mesh/voronoi.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::mesh;
using namespace elastin::testing;

namespace {

/// A soft part and a stiffer one with a curve and fibres, which meet in a face of molecules that are one, and bone.
struct Assembly {
  Body body;
  std::vector<Material> materials;
};

Assembly assembly(bool lattice) {
  const auto make = [&](double at, bool rigid, const char* name, int material, Body& whole) {
    Body body = lattice ? cubic_lattice({4, 3, 3}, 0.01, {true, true, true})
                        : tetrahedral_block(BlockKind::body_centred, {3, 2, 2}, {0.03, 0.02, 0.02});
    set_matter(body, 0.004, 1000, 0, 1e-6);
    body.rest.row(0).array() += at;
    Part part;
    part.name = name, part.rigid = rigid, part.material = material;
    add_part(whole, body, part);
  };
  Assembly result;
  make(-0.03, true, "bone", 0, result.body);
  make(0, false, "soft", 0, result.body);
  make(0.03, false, "hard", 1, result.body);
  tie_parts(result.body, "bone", "soft", 1e-5, 1);
  tie_parts(result.body, "soft", "hard", 1e-5, 1);
  Material soft{.youngs_modulus = 1e4, .poissons_ratio = 0.3}, hard{.youngs_modulus = 5e4, .poissons_ratio = 0.2};
  hard.curve = StressStrain::toe(0.05, 5e4, 2e5);
  hard.fibre = Fibre{Vector3::UnitX(), StressStrain::linear(3e4)};
  result.materials = {soft, hard};
  for (Part& part : result.body.parts) part.voronoi = voronoi_cells(part_alone(result.body, part).body);
  return result;
}

void add_all(Model& model, const Strategy& strategy, const Material& material) {
  model.add(strategy.make(model.body(), material, {}));
  if (!strategy.by_parts) model.add(make_fibres(strategy, model.body(), material));
}

}  // namespace

TEST_CASE("every strategy in parts: the forces of each part by itself, added up", "[parts]") {
  std::vector<Strategy> strategies = built_in_catalog().strategies();
  for (const char* name : {"patch", "angles_update", "neo_hookean"})
    strategies.push_back(with_volume(built_in_catalog().find(name)));
  int used = 0;
  for (const bool lattice : {true, false}) {
    const Assembly parts = assembly(lattice);
    REQUIRE(parts.body.parts[2].shared.size() >= 9);
    for (const Strategy& plain : strategies) {
      const Strategy strategy = in_parts(plain, parts.body, parts.materials);
      if (plain.kind == StrategyKind::wrapper) continue;
      REQUIRE(strategy.by_parts);
      if (!strategy.unsuited(parts.body).empty()) continue;
      INFO(plain.name << (lattice ? " on lattices" : " on tetrahedra"));
      ++used;
      Model model(parts.body);
      add_all(model, strategy, parts.materials[0]);
      const Positions positions = deformed(parts.body, 2e-4);
      Positions expected = Positions::Zero(3, parts.body.size());
      for (const std::size_t p : {1U, 2U}) {
        const PartAlone alone = part_alone(parts.body, parts.body.parts[p]);
        Model own(alone.body);
        // As a run does: the curve joins the constants of spring rules.
        const Material& material = parts.materials[p - 1];
        if (plain.constants && plain.volume_modulus) {
          own.add(make_springs(alone.body, plain.constants(alone.body, material, {}), material));
          Material straight = material;
          straight.curve.reset();
          Positions with = Positions::Zero(3, alone.body.size()), without = with;
          Model one(alone.body), other(alone.body);
          one.add(plain.make(alone.body, straight, {}));
          other.add(make_springs(alone.body, plain.constants(alone.body, straight, {})));
          const Positions volume = one.elastic_forces(positions(Eigen::all, alone.molecules)) -
                                   other.elastic_forces(positions(Eigen::all, alone.molecules));
          for (std::size_t i = 0; i < alone.molecules.size(); ++i)
            expected.col(alone.molecules[i]) += volume.col(static_cast<Eigen::Index>(i));
          own.add(make_fibres(plain, alone.body, material));
        } else {
          add_all(own, plain, material);
        }
        const Positions forces = own.elastic_forces(positions(Eigen::all, alone.molecules));
        for (std::size_t i = 0; i < alone.molecules.size(); ++i)
          expected.col(alone.molecules[i]) += forces.col(static_cast<Eigen::Index>(i));
      }
      const Positions forces = model.elastic_forces(positions);
      CHECK((forces - expected).norm() < 1e-12 * expected.norm());
      if (strategy.constants) {
        const VectorX constants = strategy.constants(parts.body, parts.materials[0], {});
        CHECK(constants.size() == parts.body.connections.size());
        CHECK(constants.cwiseAbs().maxCoeff() > 0);
      }
      if (!model.has_full_tangent()) continue;
      const Positions motion = random_motion(parts.body, 5);
      Positions change(3, parts.body.size());
      Tangent(model, {positions, Positions::Zero(3, positions.cols())}).apply(motion, change);
      const double h = 1e-8;
      const Positions measured =
          -(model.elastic_forces(positions + h * motion) - model.elastic_forces(positions - h * motion)) / (2 * h);
      CHECK((change - measured).norm() <= 1e-5 * measured.norm());
    }
  }
  CHECK(used > 15);
}

TEST_CASE("a strategy that does not suit a part says which", "[parts]") {
  const Assembly parts = assembly(true);
  const auto why = [&](const char* name) {
    return in_parts(built_in_catalog().find(name), parts.body, parts.materials).unsuited(parts.body);
  };
  CHECK_THAT(why("van_gelder"), Catch::StartsWith("body 'soft': needs tetrahedra"));
  CHECK(why("lattice").empty());
}

TEST_CASE("a body of one part, or a strategy that is so already, is left alone", "[parts]") {
  const Strategy plain = built_in_catalog().find("standard");
  CHECK(!in_parts(plain, jittered_lattice(), {}).by_parts);
  const Assembly parts = assembly(true);
  const Strategy once = in_parts(plain, parts.body, parts.materials);
  CHECK(in_parts(once, parts.body, {}).unsuited(parts.body).empty());
}
