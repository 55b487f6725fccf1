#include "elastin/core/model/share.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "core/linear/box_assembly.h"
#include "core/model/faces.h"
#include "core/solve/energies.h"
#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/stepper.h"
#include "support/bodies.h"
#include "support/processes.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

std::vector<Body> shares_of(const Body& whole, int count) {
  return on_processes(count, [&](const auto& processes) {
    std::string why;
    return share_out([&] { return whole; }, processes, why);
  });
}

Body tetrahedra_with_sides() {
  Body body = jittered_block();
  add_cell_sides(body, sides_of(body.tetrahedra));
  return body;
}

Material soft() {
  Material material;
  material.youngs_modulus = 1e4;
  material.poissons_ratio = 0.3;
  material.thickness = 1e-3;
  return material;
}

}  // namespace

TEST_CASE("share: every molecule has one owner, every element is computed once", "[share]") {
  for (const Body& whole : {jittered_lattice(), tetrahedra_with_sides(), sheet(1e-3)})
    for (const int count : {1, 2, 5}) {
      std::set<std::int64_t> numbers, places;
      std::size_t connections = 0, cells = 0;
      for (const Body& share : shares_of(whole, count)) {
        REQUIRE(share.share);
        CHECK(share.share->molecules == whole.size());
        CHECK(share.share->connections == whole.connections.proper());
        CHECK(std::abs(owned_molecules(share) - whole.size() / count) <= 2);
        for (int molecule = 0; molecule < share.size(); ++molecule)
          CHECK(share.rest.col(molecule) == whole.rest.col(number_in_whole(share, molecule)));
        numbers.insert(share.share->number.begin(), share.share->number.begin() + owned_molecules(share));
        places.insert(share.share->place.begin(), share.share->place.begin() + owned_molecules(share));
        const Subdomain own = computed_by(share);
        connections += static_cast<std::size_t>(std::count(own.computes.begin(), own.computes.end(), 1));
        cells += own.tetrahedra.size() + own.triangles.size();
      }
      CHECK(numbers.size() == static_cast<std::size_t>(whole.size()));
      CHECK(places.size() == numbers.size());
      CHECK(connections == static_cast<std::size_t>(whole.connections.size()));
      CHECK(cells == whole.tetrahedra.size() + whole.triangles.size());
    }
}

TEST_CASE("share: constants, forces and energies of all are the whole's", "[share]") {
  struct Case {
    Body body;
    std::string strategy;
  };
  const std::vector<Case> cases{{jittered_lattice(), "standard"},
                                {jittered_lattice(), "lattice+volume"},
                                {tetrahedra_with_sides(), "van_gelder"},
                                {tetrahedra_with_sides(), "neo_hookean"},
                                {tetrahedra_with_sides(), "neo_hookean+volume"},
                                {sheet(1e-3), "neo_hookean_membrane"}};
  for (const auto& [whole, strategy] : cases) {
    CAPTURE(strategy);
    const Strategy kind = built_in_catalog().find(strategy);
    Model model(whole);
    model.add(kind.make(whole, soft(), {}));
    const Positions positions = deformed(whole, 0.0003);
    const Positions forces = model.elastic_forces(positions);
    const double energy = model.elastic_energy(positions);
    for (const int count : {2, 3}) {
      Positions sum = Positions::Zero(3, whole.size());
      double energies = 0;
      for (const Body& share : shares_of(whole, count)) {
        Model own(share);
        own.keep_all_elements();
        own.add(kind.make(share, soft(), {}));
        Positions local(3, share.size());
        for (int i = 0; i < share.size(); ++i) local.col(i) = positions.col(number_in_whole(share, i));
        const Positions here = own.elastic_forces(local);
        for (int i = 0; i < share.size(); ++i) sum.col(number_in_whole(share, i)) += here.col(i);
        energies += own.elastic_energy(local);
      }
      CHECK((sum - forces).norm() <= 1e-12 * forces.norm());
      CHECK(energies == Approx(energy).epsilon(1e-12));
    }
  }
}

TEST_CASE("share: a lattice's is made without the rest of it", "[share]") {
  const CubicPattern pattern{true, true, false};
  const std::array<int, 3> molecules{4, 3, 11};
  const Body whole = cubic_lattice(molecules, 0.01, pattern);
  for (const int count : {2, 3, 5}) {
    const auto shares = on_processes(
        count, [&](const auto& processes) { return cubic_lattice_share(molecules, 0.01, pattern, processes); });
    int rank = 0;
    for (const Body& share : shares) {
      const auto owner = [&](int molecule) {
        for (int process = 0;; ++process)
          if (molecule / 12 < 11 * (process + 1) / count) return process;
      };
      const auto number = [](int molecule) { return std::int64_t{molecule}; };
      const Body cut = make_share(whole, {owner, number, number, whole.size()}, rank++);
      CHECK(share.rest == cut.rest);
      CHECK(share.connections.ends == cut.connections.ends);
      CHECK(share.connections.rest_length == cut.connections.rest_length);
      CHECK(share.cubes == cut.cubes);
      CHECK(share.share->number == cut.share->number);
      CHECK(share.share->owned == cut.share->owned);
      CHECK(share.share->molecules == whole.size());
      CHECK(share.share->connections == whole.connections.size());
    }
  }
}

TEST_CASE("share: what is asked of all is what the whole says", "[share]") {
  Body whole = jittered_lattice();
  set_matter(whole, 1000, 0, std::nullopt);
  const Face end = end_face(whole, Vector3::UnitZ(), 0.3 * whole.rest.row(2).maxCoeff());
  const BoxGrid::Frame frame = frame_of(whole);
  struct Found {
    double area = 0, share = 0, size = 0, nth = 0;
    Vector3 high = Vector3::Zero();
    std::string first;
    std::size_t molecules = 0;
  };
  const auto found = on_processes(3, [&](const auto& processes) {
    std::string why;
    const Body share = share_out([&] { return whole; }, processes, why);
    const Face face = end_face(share, Vector3::UnitZ(), 0.3 * whole.rest.row(2).maxCoeff());
    Found own;
    own.area = face.area;
    own.share = sum_over(share, face.share.sum());
    for (std::size_t i = 0; i < face.molecules.size(); ++i) {
      const std::int64_t number = number_in_whole(share, face.molecules[i]);
      const auto at = std::find(end.molecules.begin(), end.molecules.end(), static_cast<int>(number));
      own.molecules += at != end.molecules.end();
      const double expected = face.molecules[i] < owned_molecules(share) && at != end.molecules.end()
                                  ? end.share[at - end.molecules.begin()]
                                  : 0;
      if (std::abs(face.share[static_cast<Eigen::Index>(i)] - expected) > 1e-12) own.molecules = 0;
    }
    own.size = frame_of(share).size;
    own.high = outline_of_whole(share)[1];
    own.nth = nth_over(share, {1. + processes->rank(), 4.}, 2);
    own.first = first_over(share, processes->rank() == 1 ? "here" : "");
    return own;
  });
  for (const Found& own : found) {
    CHECK(own.area == Approx(end.area).epsilon(1e-12));
    CHECK(own.share == Approx(1).epsilon(1e-12));
    CHECK(own.molecules > 0);
    CHECK(own.size == Approx(frame.size).epsilon(1e-6));
    CHECK(own.high == frame.high);
    CHECK(own.nth == 3);  // of 1, 2, 3, 4, 4, 4
    CHECK(own.first == "here");
  }
}

namespace {

/// Gives ghosts what their owners have.
Model::Spread spread_of(const Body& share) {
  return [&share](Positions& values) {
    const auto owned = static_cast<std::size_t>(3 * owned_molecules(share));
    const std::vector<double> all = share.share->processes->gather({values.data(), owned});
    for (int ghost = owned_molecules(share); ghost < share.size(); ++ghost)
      values.col(ghost) = Eigen::Map<const Vector3>(all.data() + 3 * share.share->place[ghost]);
  };
}

struct Stepped {
  Positions positions;  ///< of the whole, those that the process owns
  double energy = 0, error = 0, stable_step = 0;
  bool ghosts_follow = true, converged = true;
};

/// Some steps of a model that has a load and damping, from a deformed state; the body a share or the whole.
Stepped stepped(const Body& body, int molecules, const std::string& strategy, const std::string& method, double dt) {
  Model model(body);
  if (body.share) model.complete_rows(spread_of(body));
  model.add(built_in_catalog().find(strategy).make(body, soft(), {}));
  model.add(make_gravity(body, {0, 1, -9.81}));
  model.add(make_damping(1e-3));
  State state = state_at_rest(body);
  for (int i = 0; i < body.size(); ++i) {
    const auto number = static_cast<double>(number_in_whole(body, i));
    state.positions.col(i) += 2e-4 * Vector3(std::sin(number), std::cos(2 * number), std::sin(3 * number));
    if (number < 8) model.supports.push_back({i});
  }
  Stepped found;
  found.stable_step = find_stable_step(model, state).step;
  const auto stepper = make_stepper({method});
  Ledger ledger(model, state);
  for (int step = 0; step < 5; ++step) {
    const StepResult result = stepper->advance(model, state, dt);
    found.converged &= result.outcome == Outcome::converged;
    ledger.record(model, state);
    found.error = result.error;
  }
  found.energy = ledger.energies(model, state).balance();
  Positions ghosts = state.positions;
  model.spread(ghosts);
  found.ghosts_follow = ghosts == state.positions;
  found.positions = Positions::Zero(3, molecules);
  for (int i = 0; i < owned_molecules(body); ++i)
    found.positions.col(number_in_whole(body, i)) = state.positions.col(i);
  return found;
}

}  // namespace

TEST_CASE("share: explicit steps are the whole's, on any number of processes bit by bit", "[share][slow]") {
  Body lattice = jittered_lattice(), tetrahedra = tetrahedra_with_sides();
  for (Body* body : {&lattice, &tetrahedra}) set_matter(*body, 1000, 0, std::nullopt);
  const std::vector<std::pair<const Body*, std::string>> cases{
      {&lattice, "lattice+volume"}, {&tetrahedra, "neo_hookean"}, {&tetrahedra, "neo_hookean+volume"}};
  for (const auto& [body, strategy] : cases)
    for (const std::string method : {"velocity_verlet", "symplectic_euler"}) {
      CAPTURE(strategy, method);
      const Body& whole = *body;
      const Stepped plain = stepped(whole, whole.size(), strategy, method, 1e-4);
      REQUIRE(plain.stable_step > 1e-4);
      Positions first;
      for (const int count : {1, 2, 3}) {
        const auto all = on_processes(count, [&, &strategy = strategy](const auto& processes) {
          std::string why;
          const Body share = share_out([&] { return whole; }, processes, why);
          return stepped(share, whole.size(), strategy, method, 1e-4);
        });
        Positions together = Positions::Zero(3, whole.size());
        for (const Stepped& own : all) {
          together += own.positions;
          CHECK(own.converged);
          CHECK(own.ghosts_follow);
          CHECK(own.energy == Approx(plain.energy).epsilon(1e-9));
          CHECK(own.error == Approx(plain.error).epsilon(1e-9));
          CHECK(own.stable_step == Approx(plain.stable_step).epsilon(1e-9));
        }
        if (count == 1) first = together;
        CHECK(together == first);
        CHECK((together - plain.positions).norm() <= 1e-12 * (plain.positions - whole.rest).norm());
      }
    }
}

TEST_CASE("share: molecules are known by their numbers in the whole, and ghosts as their owners", "[share]") {
  const Body whole = tetrahedra_with_sides();
  const Surface surface = find_surface(whole, Matrix3::Identity(), 0);
  const auto found = on_processes(3, [&](const auto& processes) {
    std::string why;
    const Body share = share_out([&] { return whole; }, processes, why);
    int wrong = 0;
    for (std::int64_t number = -1; number <= whole.size(); ++number) {
      const int molecule = molecule_of_whole(share, number);
      wrong += molecule >= 0 && number_in_whole(share, molecule) != number;
    }
    for (int molecule = 0; molecule < share.size(); ++molecule)
      wrong += molecule_of_whole(share, number_in_whole(share, molecule)) != molecule;
    std::vector<int> expected;
    for (const int number : surface.molecules)
      if (const int molecule = molecule_of_whole(share, number); molecule >= 0) expected.push_back(molecule);
    std::sort(expected.begin(), expected.end());
    const Surface own = find_surface(share, Matrix3::Identity(), 0);
    wrong += own.molecules != expected;
    wrong += std::abs(own.volume - surface.volume) > 1e-12 * surface.volume;
    wrong += (middle_of_whole(share) - middle_of_whole(whole)).norm() > 1e-14;
    return wrong;
  });
  CHECK(found == std::vector<int>{0, 0, 0});
}

TEST_CASE("share: what the first process cannot make no process has", "[share]") {
  const auto said = on_processes(3, [&](const auto& processes) -> std::string {
    std::string why;
    try {
      share_out([]() -> Body { throw InputError("no such mesh"); }, processes, why);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  });
  CHECK(said == std::vector<std::string>(3, "no such mesh"));
  Body cables = jittered_lattice();
  cables.cables.push_back({0, 1});
  for (const auto& [body, why] : on_processes(2, [&](const auto& processes) {
         std::pair<Body, std::string> made;
         made.first = share_out([&] { return cables; }, processes, made.second);
         return made;
       })) {
    CHECK(why == "it has cables");
    CHECK(!body.share);
    CHECK(body.size() == cables.size());
  }
}
