#include "contact/search.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>

#include "core/model/block_geometry.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/parallel/threads.h"
#include "support/allocations.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::contact;
using namespace elastin::testing;

namespace {

/// Both in one body; the second one's molecules come after the first one's.
Body together(const Body& one, const Body& other, const Vector3& shift) {
  Body both = one;
  const int n = one.size();
  both.rest.resize(3, n + other.size());
  both.rest << one.rest, other.rest.colwise() + shift;
  const auto append = [n](auto& to, const auto& from) {
    for (auto item : from) {
      for (int& molecule : item) molecule += n;
      to.push_back(item);
    }
  };
  append(both.connections.ends, other.connections.ends);
  append(both.triangles, other.triangles);
  append(both.tetrahedra, other.tetrahedra);
  append(both.cubes, other.cubes);
  both.grid.reset();
  set_present_lengths(both);
  both.mass = VectorX::Constant(both.size(), 1e-3);
  both.radius.resize(both.size());
  both.radius << one.radius, other.radius;
  return both;
}

Body lattice(int n) {
  Body body = cubic_lattice({n, n, n}, 0.01, {true, true, true});
  set_matter(body, 0.005, 1000, 0, std::pow(0.01 * n, 3));
  return body;
}

/// Two jittered blocks of tetrahedra, the second one turned and pressed some way into the first one's top.
Body pressed_blocks(double depth) {
  const Body one = jittered_block();
  Body other = tetrahedral_block(BlockKind::alternating, {2, 2, 2}, {0.012, 0.012, 0.01});
  set_matter(other, 0.003, 1000, 0, 0);
  rotate(other, Eigen::AngleAxisd(0.3, Vector3::UnitZ()).toRotationMatrix());
  return together(one, other, {0.011, 0.003, 0.02 - depth});
}

Pose pose(const Vector3& position, double angle = 0) {
  Pose one;
  one.turn = Eigen::AngleAxisd(angle, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  one.position = position;
  return one;
}

std::vector<Obstacle> some_obstacles() {
  return {{"floor", shape::Plane{}, pose({0, 0, 0.002})},
          {"ball", shape::Sphere{0.01}, pose({0.03, 0.01, 0.025})},
          {"drum", shape::Cylinder{0.004, 0.01}, pose({-0.001, 0.01, 0.01}, 0.4)}};
}

std::vector<Pose> poses_of(const std::vector<Obstacle>& obstacles) {
  std::vector<Pose> poses;
  for (const Obstacle& obstacle : obstacles) poses.push_back(obstacle.pose);
  return poses;
}

struct Setting {
  Body body;
  bool spheres, self = false;
  std::vector<Obstacle> obstacles = {};
  ContactSearch search() const {
    const SurfaceSides sides = spheres ? SurfaceSides{} : surface_sides(body);
    return {body,      spheres ? sphere_samples(body, surface_molecules(body)) : side_samples(body, sides),
            sides,     spheres,
            obstacles, self};
  }
};

std::vector<ContactPoint> found_by(ContactSearch& search, const Positions& positions, const std::vector<Pose>& poses,
                                   double reach) {
  std::vector<ContactPoint> found;
  search.find(positions, poses, reach, found);
  return found;
}

bool same_bits(const std::vector<ContactPoint>& one, const std::vector<ContactPoint>& other) {
  const auto equal = [](const ContactPoint& a, const ContactPoint& b) {
    return a.sample == b.sample && a.target == b.target && a.gap == b.gap && a.normal == b.normal &&
           a.position == b.position && a.molecules == b.molecules && a.weights == b.weights && a.count == b.count &&
           a.turning == b.turning && a.slopes == b.slopes;
  };
  return std::equal(one.begin(), one.end(), other.begin(), other.end(), equal);
}

Vector3 position_of(const Sample& sample, const Positions& positions) {
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < sample.count; ++k) sum += sample.weights[k] * positions.col(sample.molecules[k]);
  return sum;
}

const ContactPoint* contact_point_of(const std::vector<ContactPoint>& found, int sample, int target) {
  for (const ContactPoint& contact_point : found)
    if (contact_point.sample == sample && contact_point.target == target) return &contact_point;
  return nullptr;
}

}  // namespace

TEST_CASE("a body's surface encloses its volume, normals outwards", "[contact]") {
  const auto enclosed = [](const Body& body) {
    double volume = 0;
    for (const auto& triangle : surface_triangles(body))
      volume += area_vector(body.rest, triangle).dot(body.rest.col(triangle[0])) / 3;
    return volume;
  };
  CHECK(enclosed(lattice(4)) == Approx(std::pow(0.03, 3)).epsilon(1e-12));
  for (const BlockKind kind : {BlockKind::kuhn, BlockKind::alternating, BlockKind::body_centred})
    CHECK(enclosed(tetrahedral_block(kind, {3, 2, 2}, {0.03, 0.02, 0.04})) == Approx(2.4e-5).epsilon(1e-12));
  const Body ball = sphere(0.1, SphereMesh::icosahedron, 4);
  CHECK(enclosed(ball) == Approx(4. / 3 * M_PI * 1e-3).epsilon(0.05));
  Body skinned = jittered_block();  // its own triangles are those of its cells
  skinned.triangles = surface_triangles(skinned);
  CHECK(surface_triangles(skinned).size() == skinned.triangles.size());
}

TEST_CASE("molecules inside a surface of cells cannot touch, all others can", "[contact]") {
  const Body body = lattice(5);
  CHECK(surface_molecules(body).size() == 125 - 27);
  Body isolated = listed_body({{0, 0, 0}, {0.1, 0, 0}}, {});
  set_matter(isolated, 0.01, 1000, 0, 1);
  const Body with_isolated = together(body, isolated, {0, 0, 1});
  CHECK(surface_molecules(with_isolated).size() == 125 - 27 + 2);
  CHECK(surface_molecules(isolated).size() == 2);
}

TEST_CASE("samples stand for the surface's whole area and its moments", "[contact]") {
  const Body body = jittered_block();
  const Cells<3> triangles = surface_triangles(body);
  const auto samples = side_samples(body, surface_sides(body));
  REQUIRE(samples.size() == 3 * triangles.size());
  double area = 0, expected = 0, moment = 0, expected_moment = 0;
  for (const Sample& sample : samples) {
    area += sample.area;
    moment += sample.area * std::pow(position_of(sample, body.rest).x(), 2);
    CHECK(sample.weights[0] + sample.weights[1] + sample.weights[2] == Approx(1).epsilon(1e-15));
  }
  for (const auto& triangle : triangles) {
    const double a = area_vector(body.rest, triangle).norm();
    const Vector3 x(body.rest(0, triangle[0]), body.rest(0, triangle[1]), body.rest(0, triangle[2]));
    expected += a;
    expected_moment += a / 12 * (x.squaredNorm() + x.sum() * x.sum());
  }
  CHECK(area == Approx(expected).epsilon(1e-13));
  CHECK(moment == Approx(expected_moment).epsilon(1e-13));  // exact up to squares
}

TEST_CASE("quadrilaterals carry an even pressure as their shape functions do; curved sides have their own area",
          "[contact]") {
  // ∫ N_a dA of each molecule, as the cells' own rule has it, from the samples: no diagonal, no chord.
  for (const char* kind : {"hexahedron8", "hexahedron20", "hexahedron27", "tetrahedron10", "prism6"})
    for (const bool curved : {false, true}) {
      if (curved && cell_kind(kind).order == 1) continue;
      INFO(kind << (curved ? ", curved" : ""));
      const Body body = cell_box(cell_kind(kind), {2, 2, 2}, {0.02, 0.02, 0.02}, 0.2, curved);
      VectorX expected = VectorX::Zero(body.size()), found = expected;
      double area = 0;
      for (const BlockFace& face : boundary_faces(body))
        for (std::size_t g = 0; g < face.kind->slopes.size(); ++g) {
          const auto point = static_cast<Eigen::Index>(g);
          const double weight = face.kind->weights[point] *
                                measure_of(positions_of(body.rest, face.nodes) * face.kind->slopes[g].transpose());
          area += weight;
          for (std::size_t a = 0; a < face.nodes.size(); ++a)
            expected[face.nodes[a]] += weight * face.kind->values(static_cast<Eigen::Index>(a), point);
        }
      double sum = 0;
      for (const Sample& sample : side_samples(body, surface_sides(body))) {
        sum += sample.area;
        for (int k = 0; k < sample.count; ++k) found[sample.molecules[k]] += sample.area * sample.weights[k];
      }
      CHECK(sum == Approx(area).epsilon(1e-12));
      if (cell_kind(kind).order == 1) CHECK((found - expected).norm() < 1e-3 * expected.norm());
    }
}

TEST_CASE("spheres touch each other as all pairs tried do", "[contact]") {
  const Setting setting{together(lattice(3), lattice(4), {0.004, -0.003, 0.0285}), true};
  ContactSearch search = setting.search();
  const auto& samples = search.samples();
  const int pieces = 2;
  for (const double amount : {0., 5e-4, 2e-3}) {
    const Positions positions = setting.body.rest + amount * random_motion(setting.body, 7);
    const auto found = found_by(search, positions, {}, 1e-3);
    std::size_t expected = 0;
    for (std::size_t a = 0; a < samples.size(); ++a)
      for (std::size_t b = a + 1; b < samples.size(); ++b) {
        const Vector3 away = position_of(samples[a], positions) - position_of(samples[b], positions);
        const double gap = away.norm() - samples[a].radius - samples[b].radius;
        if (samples[a].piece == samples[b].piece || !(gap < 1e-3)) continue;
        ++expected;
        const ContactPoint* contact_point = contact_point_of(found, static_cast<int>(a), pieces + static_cast<int>(b));
        REQUIRE(contact_point);
        CHECK(contact_point->gap == Approx(gap).margin(1e-15));
        CHECK((contact_point->normal - away.normalized()).norm() < 1e-14);
        CHECK((contact_point->position - position_of(samples[b], positions)).norm() == Approx(samples[b].radius));
        CHECK(contact_point->count == 1);
        CHECK(contact_point->molecules[0] == samples[b].molecules[0]);
      }
    CHECK(found.size() == expected);
    CHECK(expected > 5);
  }
}

TEST_CASE("a piece that touches itself leaves out what is joined and what overlaps at rest", "[contact]") {
  Body body = lattice(3);
  body.radius.setConstant(0.006);  // neighbours along an axis and a face diagonal: 0.010, 0.014; the next: 0.0173, 0.02
  const Setting setting{body, true, true};
  ContactSearch search = setting.search();
  CHECK(found_by(search, body.rest, {}, 0).empty());
  Positions folded = body.rest;
  folded.col(0) = body.rest.col(26) + Vector3(0.009, 0, 0);  // the first corner comes to the last
  const auto found = found_by(search, folded, {}, 0);
  REQUIRE(found.size() >= 1);
  CHECK(contact_point_of(found, 0, 1 + 25));  // molecule 26 is sample 25: the middle one cannot touch
}

TEST_CASE("touches of every kind are those of a search that looks at everything again", "[contact]") {
  // The same search goes through a history of motions and reaches; another is made new for each.
  const std::vector<Setting> settings{
      {pressed_blocks(5e-4), false, false, some_obstacles()},
      {pressed_blocks(5e-4), false, true, some_obstacles()},
      {together(lattice(4), lattice(3), {0.003, 0, 0.0395}), true, true, some_obstacles()}};
  for (const Setting& setting : settings) {
    ContactSearch lasting = setting.search();
    std::size_t contact_points = 0;
    for (int step = 0; step < 40; ++step) {
      Positions positions = setting.body.rest + 4e-4 * std::sin(0.4 * step) * random_motion(setting.body, 8);
      positions.row(2).array() += 1e-4 * step;
      std::vector<Pose> poses = poses_of(setting.obstacles);
      poses[1] = pose({0.03 - 2e-4 * step, 0.01, 0.025}, 0.01 * step);
      poses[2] = pose({-0.001, 0.01, 0.01}, 0.005 * step);
      const double reach = step % 3 ? 0 : 2e-3;
      ContactSearch fresh = setting.search();
      const auto found = found_by(lasting, positions, poses, reach);
      CHECK(same_bits(found, found_by(fresh, positions, poses, reach)));
      contact_points += found.size();
      CHECK(std::is_sorted(found.begin(), found.end(), [](const ContactPoint& a, const ContactPoint& b) {
        return std::pair{a.sample, a.target} < std::pair{b.sample, b.target};
      }));
    }
    CHECK(contact_points > 1000);
    CHECK(lasting.cost().rebuilds < 30);
  }
}

TEST_CASE("touches are bitwise identical on any number of threads", "[contact]") {
  const Setting setting{together(lattice(14), lattice(14), {0.003, 0.002, 0.1297}), false, false, some_obstacles()};
  const Positions positions = setting.body.rest + 5e-4 * random_motion(setting.body, 9);
  std::vector<std::vector<ContactPoint>> all;
  for (const int threads : {1, 2, 4}) {
    set_threads(threads);
    ContactSearch search = setting.search();
    all.push_back(found_by(search, positions, poses_of(setting.obstacles), 1e-3));
  }
  set_threads(0);
  CHECK(all[0].size() > 2000);
  CHECK(same_bits(all[0], all[1]));
  CHECK(same_bits(all[0], all[2]));
}

TEST_CASE("a search that has served allocates nothing", "[contact]") {
  const Setting setting{pressed_blocks(5e-4), false, true, some_obstacles()};
  ContactSearch search = setting.search();
  std::vector<ContactPoint> found;
  const auto poses = poses_of(setting.obstacles);
  const Positions positions = setting.body.rest, moved = positions.array() + 1e-5, far = positions.array() + 0.1;
  for (const Positions* at : {&positions, &moved, &far, &positions}) search.find(*at, poses, 1e-3, found);
  const long before = allocations(), rebuilds = search.cost().rebuilds;
  for (const Positions* at : {&moved, &positions, &far, &moved}) search.find(*at, poses, 1e-3, found);
  CHECK(allocations() == before);
  CHECK(search.cost().rebuilds == rebuilds + 2);
  CHECK(found.size() > 10);
}

TEST_CASE("a gap's gradient is the normal times the weights, and the normal turns as it says", "[contact]") {
  const std::vector<Setting> settings{
      {pressed_blocks(3e-4), false, false, some_obstacles()},
      {pressed_blocks(-2e-4), false, false, {}},
      {together(lattice(4), lattice(3), {0.003, 0, 0.0395}), true, false, some_obstacles()}};
  for (const Setting& setting : settings) {
    const Body& body = setting.body;
    const auto poses = poses_of(setting.obstacles);
    ContactSearch search = setting.search();
    const Positions positions = body.rest + 1e-4 * random_motion(body, 10);
    const auto found = found_by(search, positions, poses, 1e-3);
    REQUIRE(found.size() > 10);
    int flat = 0, bent = 0;
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Positions motion = random_motion(body, 20 + seed);
      constexpr double h = 1e-8;  // [m]; cells are 5e-3
      const auto ahead = found_by(search, positions + h * motion, poses, 1e-3);
      const auto behind = found_by(search, positions - h * motion, poses, 1e-3);
      for (const ContactPoint& contact_point : found) {
        const ContactPoint* after = contact_point_of(ahead, contact_point.sample, contact_point.target);
        const ContactPoint* before = contact_point_of(behind, contact_point.sample, contact_point.target);
        if (!after || !before || after->molecules != before->molecules) continue;
        const auto zeros = [](const ContactPoint& one) {
          return std::count(one.weights.begin(), one.weights.end(), 0);
        };
        if (zeros(*after) != zeros(*before)) continue;  // the nearest point went over a side
        Vector3 moved = Vector3::Zero(), turned = Vector3::Zero();
        const Sample& sample = search.samples()[contact_point.sample];
        for (int k = 0; k < sample.count; ++k) moved += sample.weights[k] * motion.col(sample.molecules[k]);
        for (int k = 0; k < contact_point.count; ++k) {
          moved -= contact_point.weights[k] * motion.col(contact_point.molecules[k]);
          turned -= contact_point.slopes[k] * contact_point.normal.dot(motion.col(contact_point.molecules[k]));
        }
        CAPTURE(contact_point.sample, contact_point.target, contact_point.gap);
        CHECK((after->gap - before->gap) / (2 * h) == Approx(contact_point.normal.dot(moved)).margin(1e-7));
        const Vector3 rate = (after->normal - before->normal) / (2 * h);
        const Vector3 expected = contact_point.turning * moved + turned;
        CHECK((rate - expected).norm() < 1e-5 * (1 + expected.norm() + std::pow(contact_point.turning.norm(), 2) * h));
        (contact_point.turning.isZero(0) ? flat : bent) += 1;
      }
    }
    CHECK(flat > 10);
    if (setting.spheres || !setting.obstacles.empty()) CHECK(bent > 10);
  }
}

TEST_CASE("a sample deep in another piece is pushed back out where it came in, or not at all", "[contact]") {
  // A thin plate of one layer of cells, 2 mm thick with cells 10 mm wide; a block comes through from above.
  Body plate = tetrahedral_block(BlockKind::kuhn, {6, 6, 1}, {0.06, 0.06, 0.002});
  set_matter(plate, 0.001, 1000, 0, 0);
  Body block = tetrahedral_block(BlockKind::kuhn, {2, 2, 2}, {0.02, 0.02, 0.02});
  set_matter(block, 0.001, 1000, 0, 0);
  for (const double depth : {1e-4, 9e-4, 1.5e-3, 1.9e-3}) {
    const Setting setting{together(plate, block, {0.021, 0.022, 0.002 - depth}), false};
    ContactSearch search = setting.search();
    int from_block = 0;
    for (const ContactPoint& contact_point : found_by(search, setting.body.rest, {}, 0)) {
      const Sample& sample = search.samples()[contact_point.sample];
      if (sample.piece != 1) continue;
      const Vector3 position = position_of(sample, setting.body.rest);
      if (position.z() > 0.002 - depth + 1e-6) continue;  // of the block's lower face alone
      ++from_block;
      CHECK(contact_point.gap == Approx(-depth).epsilon(1e-9));
      CHECK((contact_point.normal - Vector3::UnitZ()).norm() < 1e-12);
    }
    CHECK(from_block == 3 * 8);
  }
  // Right through: what looks down has left upwards-looking triangles behind, and only sides may push it.
  const Setting through{together(plate, block, {0.021, 0.022, -0.001}), false};
  ContactSearch search = through.search();
  for (const ContactPoint& contact_point : found_by(search, through.body.rest, {}, 0)) {
    const Vector3 position = position_of(search.samples()[contact_point.sample], through.body.rest);
    if (position.z() < 1e-6) CHECK(std::abs(contact_point.normal.z()) < 1e-12);
  }
}

TEST_CASE("a layer folded onto itself touches itself, not through its own thickness", "[contact]") {
  // A strip of two layers of cells, bent to a U: its upper side faces itself.
  Body strip = tetrahedral_block(BlockKind::kuhn, {40, 3, 2}, {0.4, 0.03, 0.01});
  set_matter(strip, 0.002, 1000, 0, 0);
  const Setting setting{strip, false, true};
  ContactSearch search = setting.search();
  CHECK(found_by(search, strip.rest, {}, 1e-3).empty());
  const auto bent = [&](double radius) {  // straight, half a turn about a line above its middle, straight
    Positions positions = strip.rest;
    for (int molecule = 0; molecule < strip.size(); ++molecule) {
      const double along = strip.rest(0, molecule) - 0.2, above = strip.rest(2, molecule);
      const double half = M_PI * radius / 2, angle = std::clamp(along, -half, half) / radius;
      const double beyond = along - std::clamp(along, -half, half), from_middle = radius - above;
      positions(0, molecule) = from_middle * std::sin(angle) + beyond * std::cos(angle);
      positions(2, molecule) = radius - from_middle * std::cos(angle) + beyond * std::sin(angle);
    }
    return positions;
  };
  CHECK(found_by(search, bent(0.04), {}, 1e-3).empty());  // the gap is 2 (0.04 − 0.01)
  Positions closed = bent(0.04);  // and now its two legs are pushed together, 0.4 mm into each other
  for (int molecule = 0; molecule < strip.size(); ++molecule)
    if (strip.rest(0, molecule) > 0.3) closed(0, molecule) -= 2 * 0.03 + 4e-4;
  int pressed = 0;
  for (const ContactPoint& contact_point : found_by(search, closed, {}, 0)) {
    const Vector3 position = position_of(search.samples()[contact_point.sample], closed);
    if (position.z() < 0.1) continue;  // where the strip was torn along to get there
    ++pressed;
    CHECK(contact_point.gap == Approx(-4e-4).epsilon(1e-6));
    CHECK(std::abs(contact_point.normal.x()) == Approx(1).epsilon(1e-9));
  }
  CHECK(pressed > 100);
}

TEST_CASE("pieces that a tie holds together do not touch each other", "[contact]") {
  for (const bool self : {false, true}) {
    Setting setting{pressed_blocks(5e-4), false, self};
    ContactSearch free = setting.search();
    CHECK(found_by(free, setting.body.rest, {}, 0).size() > 10);
    const int upper = setting.body.size() - 1;
    setting.body.ties.push_back({upper, {0, 1, 2}, {0.5, 0.25, 0.25}, 1});
    ContactSearch tied = setting.search();
    CHECK(found_by(tied, setting.body.rest, {}, 0).empty());
  }
}

TEST_CASE("an obstacle that moves is found though the body stays, and places that are no numbers find nothing",
          "[contact]") {
  const Setting setting{lattice(4), true, false, {{"ball", shape::Sphere{0.01}}}};
  ContactSearch search = setting.search();
  CHECK(found_by(search, setting.body.rest, {pose({1, 0, 0})}, 1e-4).empty());
  CHECK(found_by(search, setting.body.rest, {pose({0.043, 0.015, 0.015})}, 1e-4).size() == 4);
  const long rebuilds = search.cost().rebuilds;
  for (int i = 1; i < 200; ++i) CHECK(found_by(search, setting.body.rest, {pose({1 - 0.004 * i, 0, 0})}, 1e-4).empty());
  CHECK(search.cost().rebuilds <= rebuilds + 12);  // far away it looks again only once the way there has shrunk
  Positions lost = setting.body.rest;
  lost.setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK(found_by(search, lost, {pose({0, 0, 0})}, 1e-4).empty());
}
