#include "elastin/core/model/subdomain.h"

#include <catch2/catch.hpp>
#include <map>
#include <vector>

#include "core/linear/box_assembly.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// A strategy on a body, whole and shared out.
struct Shared {
  Shared(const Body& body, const std::string& strategy, int parts) : whole(body) {
    Material material;
    material.youngs_modulus = 1e4;
    material.poissons_ratio = 0.3;
    material.thickness = 1e-3;
    whole.add(built_in_catalog().find(strategy).make(body, material, {}));
    const std::vector<int> owners = bisect(body.rest, parts);
    subdomains.reserve(static_cast<std::size_t>(parts));
    for (int part = 0; part < parts; ++part) {
      subdomains.push_back(make_subdomain(body, owners, part));
      models.emplace_back(*subdomains.back().body);
      for (const auto& law : whole.elasticity()) models.back().add(law->on_subdomain(subdomains.back()));
    }
  }
  static Positions taken(const Subdomain& own, const Positions& of_whole) {
    return of_whole(Eigen::all, own.molecules);
  }
  static void add(const Subdomain& own, const Positions& values, Positions& sum) {
    for (std::size_t i = 0; i < own.molecules.size(); ++i)
      sum.col(own.molecules[i]) += values.col(static_cast<Eigen::Index>(i));
  }

  Model whole;
  std::vector<Subdomain> subdomains;
  std::vector<Model> models;
};

Body tetrahedra_with_sides() {
  Body body = jittered_block();
  add_cell_sides(body, sides_of(body.tetrahedra));
  return body;
}

}  // namespace

TEST_CASE("subdomain: every molecule has one owner, every element is computed once", "[subdomain]") {
  for (const Body& body : {jittered_lattice(), tetrahedra_with_sides(), sheet(1e-3)})
    for (const int parts : {1, 2, 5}) {
      const std::vector<int> owners = bisect(body.rest, parts);
      int molecules = 0, connections = 0;
      std::size_t cells = 0;
      for (int part = 0; part < parts; ++part) {
        const Subdomain own = make_subdomain(body, owners, part);
        molecules += own.owned;
        for (const char computes : own.computes) connections += computes;
        cells += own.tetrahedra.size() + own.triangles.size();
        CHECK(std::abs(own.owned - body.size() / parts) <= 2);
        for (std::size_t i = 0; i < own.molecules.size(); ++i)
          CHECK(own.local(own.molecules[i]) == static_cast<int>(i));
        CHECK(own.local(body.size()) == -1);
      }
      CHECK(molecules == body.size());
      CHECK(connections == body.connections.size());
      CHECK(cells == body.tetrahedra.size() + body.triangles.size());
    }
}

TEST_CASE("subdomain: a lattice is cut across its longest side", "[subdomain]") {
  const Body body = cubic_lattice({3, 8, 2}, 0.01, {true, false, false});
  const std::vector<int> owners = bisect(body.rest, 2);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    CHECK(owners[molecule] == (body.rest(1, molecule) > 0.035 ? 1 : 0));
}

TEST_CASE("subdomain: forces, energies and tangents of all are those of the whole", "[subdomain]") {
  struct Case {
    Body body;
    const char* strategy;
  };
  const std::vector<Case> cases{{jittered_lattice(), "lattice"},
                                {jittered_lattice(), "lattice+volume"},
                                {tetrahedra_with_sides(), "patch+volume"},
                                {tetrahedra_with_sides(), "neo_hookean"},
                                {tetrahedra_with_sides(), "neo_hookean+volume"},
                                {sheet(1e-3), "hencky_membrane"}};
  for (const auto& [body, strategy] : cases)
    for (const int parts : {1, 2, 5}) {
      CAPTURE(strategy, parts);
      Shared shared(body, strategy, parts);
      const Positions positions = deformed(body, 5e-4), motion = random_motion(body, 7);
      const State state{positions, Positions::Zero(3, body.size())};
      const Positions forces = shared.whole.elastic_forces(positions);
      Positions change = forces, forces_of_all = 0 * forces, change_of_all = 0 * forces;
      Tangent(shared.whole, state).apply(motion, change);
      double energy = 0;
      for (std::size_t part = 0; part < shared.models.size(); ++part) {
        const Subdomain& own = shared.subdomains[part];
        const State at{Shared::taken(own, positions), Positions::Zero(3, own.body->size())};
        energy += shared.models[part].elastic_energy(at.positions);
        Shared::add(own, shared.models[part].elastic_forces(at.positions), forces_of_all);
        Positions local(3, own.body->size());
        Tangent(shared.models[part], at).apply(Shared::taken(own, motion), local);
        Shared::add(own, local, change_of_all);
      }
      CHECK(energy == Approx(shared.whole.elastic_energy(positions)).epsilon(1e-12));
      CHECK((forces_of_all - forces).norm() < 1e-12 * forces.norm());
      CHECK((change_of_all - change).norm() < 1e-12 * change.norm());
    }
}

TEST_CASE("subdomain: parts of a grid of boxes add up to the whole's, on coarser grids too", "[subdomain]") {
  const Body body = cubic_lattice({9, 9, 9}, 0.01, {true, true, false});
  Shared shared(body, "lattice+volume", 3);
  const State rest = state_at_rest(body);
  const std::vector<Support> supports{{0}, {1}, {400}};
  using Pair = std::array<std::array<int, 3>, 2>;  // where two points are
  const auto add_blocks = [](const BoxLevel& level, std::map<Pair, Matrix3>& sums) {
    for (int point = 0; point < level.points(); ++point) {
      int n = 0;
      for (const int other : level.neighbours(point)) {
        const Matrix3 block = level.block_to(point, n++);
        if (other != point || n == 1)
          sums.try_emplace({level.grid().at(point), level.grid().at(other)}, Matrix3::Zero()).first->second += block;
      }
    }
  };
  std::unique_ptr<BoxLevel> whole = assemble_level(Tangent(shared.whole, rest), supports).level;
  for (const bool coarse : {false, true}) {
    if (coarse) whole = whole->coarser(whole->grid().coarser());
    std::map<Pair, Matrix3> sums, blocks;
    add_blocks(*whole, blocks);
    for (std::size_t part = 0; part < shared.models.size(); ++part) {
      const Subdomain& own = shared.subdomains[part];
      std::vector<Support> local;
      for (Support support : supports)
        if (const int molecule = own.local(support.molecule); molecule >= 0) {
          support.molecule = molecule;
          local.push_back(support);
        }
      const State at = state_at_rest(*own.body);
      std::unique_ptr<BoxLevel> level = assemble_part(Tangent(shared.models[part], at), local, frame_of(body)).level;
      if (coarse) level = level->coarser(level->grid().coarser(), true);
      add_blocks(*level, sums);
    }
    double error = 0, size = 0;
    for (const auto& [pair, block] : blocks) {
      REQUIRE(sums.contains(pair));
      error += (sums.at(pair) - block).squaredNorm();
      size += block.squaredNorm();
    }
    CHECK(std::sqrt(error) < 1e-5 * std::sqrt(size));  // of single precision
  }
}
