#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <stdexcept>

#include "contact/search.h"
#include "elastin/contact/contact.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/integrator.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::contact;

enum class Against { plane, ball, body };
constexpr const char* kScenes[] = {"on a plane", "on a ball", "body on body"};

/// A cube of `side`³ molecules, or two halves of it, pressed in by a tenth of a radius; into a ball by half of one.
struct Scene {
  Body body;
  std::vector<Obstacle> obstacles;
  std::vector<std::vector<int>> all, surface;  ///< molecules of each piece
  double spacing;

  Scene(Against against, int side) : body(make_cube(side)), spacing(kCubeLength / (side - 1)) {
    const double radius = spacing / 2, depth = against == Against::ball ? radius / 2 : radius / 10;
    const Vector3 below(kCubeLength / 2, kCubeLength / 2, -radius + depth);
    if (against == Against::plane) obstacles.push_back({"plane", shape::Plane{}, {Matrix3::Identity(), below}});
    if (against == Against::ball) {  // of the cube's own size
      const double size = kCubeLength / 2;
      obstacles.push_back({"ball", shape::Sphere{size}, {Matrix3::Identity(), below - size * Vector3::UnitZ()}});
    }
    if (against == Against::body) cut(side / 2, depth);
    const std::vector<int> piece_of = inspect(body).piece_of;
    all.resize(against == Against::body ? 2 : 1);
    surface.resize(all.size());
    for (int molecule = 0; molecule < body.size(); ++molecule) all[piece_of[molecule]].push_back(molecule);
    for (const int molecule : surface_molecules(body)) surface[piece_of[molecule]].push_back(molecule);
  }

  std::vector<Pose> poses() const {
    std::vector<Pose> poses;
    for (const Obstacle& obstacle : obstacles) poses.push_back(obstacle.pose);
    return poses;
  }

 private:
  /// Parts what lies above a layer from what lies below, and sets it down shifted, so that no sphere is on top of one.
  void cut(int layer, double depth) {
    const double height = (layer - 0.5) * spacing;
    const auto above = [&](int molecule) { return body.rest(2, molecule) > height; };
    const auto parted = [&](const auto& cell) {
      return std::any_of(cell.begin(), cell.end(), [&](int molecule) { return above(molecule) != above(cell[0]); });
    };
    std::erase_if(body.connections.ends, parted);
    std::erase_if(body.cubes, parted);
    body.grid.reset();
    set_present_lengths(body);
    // Over the middle between four spheres of the layer below.
    const double up = std::sqrt(0.5) * spacing - depth - spacing;
    for (int molecule = 0; molecule < body.size(); ++molecule)
      if (above(molecule)) body.rest.col(molecule) += Vector3(spacing / 2, spacing / 2, up);
  }
};

constexpr const char* kMethods[] = {
    "steady", "anew", "triangles, steady", "triangles, anew", "FCL, surface alone", "FCL, every molecule"};

/// A search, and how many touches it found last. `anew`: it is led to and fro so far that it must look again.
struct Ours {
  ContactSearch search;
  Positions here, there;
  std::vector<Pose> poses;
  std::vector<ContactPoint> found = {};
  bool back = false;
  Ours(const Scene& scene, bool triangles, bool anew)
      : search(make(scene, triangles)), here(scene.body.rest), poses(scene.poses()) {
    if (triangles)  // their surface goes through the molecules' middles
      for (const int molecule : scene.all.back())
        here(2, molecule) -= (scene.obstacles.empty() ? std::sqrt(0.5) : 0.5) * scene.spacing;
    there = here;
    there.row(0).array() += (anew ? 2 : 1e-3) * scene.spacing;
  }
  static ContactSearch make(const Scene& scene, bool triangles) {
    const SurfaceSides surface = triangles ? surface_sides(scene.body) : SurfaceSides{};
    return {scene.body,
            triangles ? side_samples(scene.body, surface) : sphere_samples(scene.body, surface_molecules(scene.body)),
            surface,
            !triangles,
            scene.obstacles,
            false};
  }
  std::size_t find() {
    search.find(back ? there : here, poses, 0, found);
    back = !back;
    return found.size();
  }
};

struct Contacts {
  fcl::CollisionRequestd request{1, true};
  std::size_t count = 0;
};

bool collide(fcl::CollisionObjectd* one, fcl::CollisionObjectd* other, void* context) {
  Contacts& contacts = *static_cast<Contacts*>(context);
  fcl::CollisionResultd result;
  contacts.count += fcl::collide(one, other, contacts.request, result);
  return false;
}

std::shared_ptr<fcl::CollisionGeometryd> geometry_of(const ObstacleShape& shape) {
  if (std::holds_alternative<shape::Plane>(shape)) return std::make_shared<fcl::Halfspaced>(fcl::Vector3d::UnitZ(), 0);
  if (const auto* ball = std::get_if<shape::Sphere>(&shape)) return std::make_shared<fcl::Sphered>(ball->radius);
  throw std::runtime_error("the peer knows planes and spheres alone");
}

/// The peer of contact: FCL as one uses it by hand. One collision object a sphere in a dynamic tree for each group;
/// every time all are moved, the trees brought up to date, and what the broad phase leaves is asked for contacts.
class FclObjects {
 public:
  /// Groups of molecules (pieces of a body); an obstacle, a plane or a sphere, if there is one group alone.
  FclObjects(const Body& body, const std::vector<std::vector<int>>& groups, const Obstacle* obstacle) {
    for (const auto& molecules : groups) {
      Group& group = *groups_.emplace_back(std::make_unique<Group>());
      group.molecules = molecules;
      const auto sphere = std::make_shared<fcl::Sphered>(body.radius[molecules.front()]);  // the same for all
      std::vector<fcl::CollisionObjectd*> all;
      for (const int molecule : molecules) {
        const fcl::Vector3d position = body.rest.col(molecule);
        group.objects.push_back(std::make_unique<fcl::CollisionObjectd>(sphere, fcl::Matrix3d::Identity(), position));
        all.push_back(group.objects.back().get());
      }
      group.tree.registerObjects(all);
      group.tree.setup();
    }
    if (obstacle)
      obstacle_ = std::make_unique<fcl::CollisionObjectd>(geometry_of(obstacle->shape), obstacle->pose.turn,
                                                          obstacle->pose.position);
  }
  /// Pairs that touch at these positions.
  std::size_t find(const Positions& positions) {
    for (auto& group : groups_) {
      for (std::size_t i = 0; i < group->objects.size(); ++i) {
        group->objects[i]->setTranslation(positions.col(group->molecules[i]));
        group->objects[i]->computeAABB();
      }
      group->tree.update();
    }
    Contacts contacts;
    if (obstacle_)
      groups_[0]->tree.collide(obstacle_.get(), &contacts, &collide);
    else
      groups_[0]->tree.collide(&groups_[1]->tree, &contacts, &collide);
    return contacts.count;
  }

 private:
  struct Group {
    std::vector<int> molecules;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
    fcl::DynamicAABBTreeCollisionManagerd tree;
  };
  std::vector<std::unique_ptr<Group>> groups_;
  std::unique_ptr<fcl::CollisionObjectd> obstacle_;
};

/// Elastin's searches and FCL's, in turn, on some number of threads (FCL has one).
std::vector<Figures> race(Against against, int side, int threads, int repeats) {
  const Scene scene(against, side);
  set_threads(threads);
  std::vector<Ours> ours;
  for (const bool triangles : {false, true})
    for (const bool anew : {false, true}) ours.emplace_back(scene, triangles, anew);
  const Obstacle* obstacle = scene.obstacles.empty() ? nullptr : scene.obstacles.data();
  std::deque<FclObjects> peers;
  if (threads == 1) {
    peers.emplace_back(scene.body, scene.surface, obstacle);
    peers.emplace_back(scene.body, scene.all, obstacle);
  }
  if (const std::size_t found = ours[0].find(); threads == 1 && (found == 0 || peers[0].find(scene.body.rest) != found))
    throw std::runtime_error("FCL and elastin find other touches");
  ours[0].back = false;
  const int calls = std::max(1, 20000 / (side * side));  // long against the clock
  std::vector<std::function<void()>> works;
  for (Ours& one : ours)
    works.emplace_back([&, calls] {
      for (int i = 0; i < calls; ++i) one.find();
    });
  for (FclObjects& one : peers) works.emplace_back([&] { one.find(scene.body.rest); });
  std::vector<Figures> found;
  for (const Sample& sample : interleaved(works, repeats)) {
    const bool peer = found.size() >= ours.size();
    Figures figures;
    figures.molecules = scene.body.size();
    figures.touches = static_cast<double>(peer ? ours[0].found.size() : ours[found.size()].found.size());
    figures.minimum = sample.minimum / (peer ? 1 : calls);
    figures.median = sample.median / (peer ? 1 : calls);
    found.push_back(figures);
  }
  return found;
}

/// How the time of one method grows: the slope of log time over log molecules.
double exponent(const std::vector<const Row*>& rows) {
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const Row* row : rows) {
    const double u = std::log(row->figures.molecules), v = std::log(row->figures.minimum);
    x += u, y += v, xx += u * u, xy += u * v;
  }
  const double n = static_cast<double>(rows.size());
  return (n * xy - x * y) / (n * xx - x * x);
}

/// Says at the largest of each method how it grows, and how FCL's surface loop compares.
void add_comparisons(std::vector<Row>& rows) {
  std::map<std::pair<std::string, int>, std::vector<const Row*>> of_method;
  std::map<std::pair<std::string, int>, double> fcl;  // by scene and side
  const auto scene_of = [](const Row& row) { return row.method.substr(0, row.method.find(':')); };
  for (Row& row : rows) {
    of_method[{row.method, row.threads}].push_back(&row);
    if (row.method.ends_with(kMethods[4])) fcl[{scene_of(row), row.side}] = row.figures.minimum;
  }
  for (Row& row : rows) {
    if (const auto peer = fcl.find({scene_of(row), row.side}); peer != fcl.end())
      row.figures.ratio = peer->second / row.figures.minimum;
    const auto& alike = of_method[{row.method, row.threads}];
    if (alike.size() > 1 && alike.back() == &row) row.note = fmt::format("∝ molecules^{:.2f}", exponent(alike));
  }
}

enum class Kind { none, far_spheres, far_triangles, pressed_spheres, pressed_triangles };
constexpr const char* kSteps[] = {"steps: no contact", "steps: plane far away, spheres",
                                  "steps: plane far away, triangles", "steps: on the plane, spheres",
                                  "steps: on the plane, triangles"};

/// Velocity Verlet of the cube on its lattice pass, the fastest there is: contact has to be cheap beside it.
struct Run {
  Body body;
  Model model;
  State state;
  std::unique_ptr<Integrator> integrator = make_integrator({.scheme = "velocity_verlet"});
  double dt;

  Run(Kind kind, int side) : body(make_cube(side)), model(body), state(state_at_rest(body)) {
    const VectorX constants = built_in_catalog().find("lattice").constants(body, kMaterial, {});
    dt = 0.1 * std::sqrt(body.mass.minCoeff() / (18 * constants.maxCoeff()));
    model.add(make_springs(body, constants));
    state.positions.row(2) *= 1.001;  // so that it moves
    if (kind == Kind::none) return;
    ContactOptions options;
    options.stiffness = default_contact_stiffness(body, kMaterial.youngs_modulus);
    const bool spheres = kind == Kind::far_spheres || kind == Kind::pressed_spheres;
    options.surface = spheres ? ContactSurface::spheres : ContactSurface::triangles;
    const bool far = kind == Kind::far_spheres || kind == Kind::far_triangles;
    const double spacing = kCubeLength / (side - 1);
    Pose pose;
    pose.position.z() = far ? -1 : 0.01 * spacing - (spheres ? spacing / 2 : 0);
    options.obstacles.push_back({"plane", shape::Plane{}, pose});
    model.add(make_contact(body, options));
  }
  void advance(int steps) {
    for (int step = 0; step < steps; ++step)
      if (integrator->advance(model, state, dt).outcome != Outcome::converged) throw std::runtime_error("diverged");
  }
};

std::vector<Figures> race_steps(int side, int threads, int repeats) {
  set_threads(threads);
  std::vector<std::unique_ptr<Run>> runs;
  for (int kind = 0; kind < static_cast<int>(std::size(kSteps)); ++kind)
    runs.push_back(std::make_unique<Run>(static_cast<Kind>(kind), side));
  const double springs = runs[0]->body.connections.size();
  const int steps =
      std::clamp(static_cast<int>(2e6 / springs), 1, 200);  // short: few are disturbed, and the minimum counts
  std::vector<std::function<void()>> works;
  for (const auto& run : runs) works.emplace_back([&run, steps] { run->advance(steps); });
  std::vector<Figures> found;
  for (const Sample& sample : interleaved(works, 10 * repeats)) {
    Figures figures;
    figures.molecules = runs[0]->body.size();
    figures.springs = springs;
    figures.minimum = sample.minimum / steps;
    figures.median = sample.median / steps;
    figures.without = figures.minimum / (found.empty() ? figures.minimum : found[0].minimum);
    found.push_back(figures);
  }
  return found;
}

}  // namespace

std::vector<Row> run_contact(const Settings& settings) {
  std::vector<Row> rows;
  for (const Against against : {Against::plane, Against::ball, Against::body})
    for (const int side : settings.sides)
      for (const int threads : settings.threads) {
        const std::string scene = kScenes[static_cast<int>(against)];
        say(fmt::format("contact {}, side {}, threads {}", scene, side, threads));
        const auto found = in_child([&] { return race(against, side, threads, settings.repeats); });
        for (std::size_t i = 0; i < found.size(); ++i)
          rows.push_back({"contact", scene + ": " + kMethods[i], side, threads, settings.repeats, found[i], ""});
      }
  add_comparisons(rows);
  for (const int side : settings.sides)
    for (const int threads : settings.threads) {
      say(fmt::format("contact, steps, side {}, threads {}", side, threads));
      const auto found = in_child([&] { return race_steps(side, threads, settings.repeats); });
      for (std::size_t i = 0; i < found.size(); ++i)
        rows.push_back({"contact", kSteps[i], side, threads, 10 * settings.repeats, found[i], ""});
    }
  return rows;
}

}  // namespace bench
