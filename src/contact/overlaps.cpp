#include "contact/overlaps.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <unordered_set>

namespace elastin::contact {
namespace {

struct Query {
  const Body& body;
  const Positions& positions;
  double tolerance;
  std::vector<Overlap> found;
};

int molecule_of(const fcl::CollisionObjectd* object) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(object->getUserData()));
}

/// Called by the broad phase for every pair of overlapping boxes.
bool meet(fcl::CollisionObjectd* one, fcl::CollisionObjectd* other, void* context) {
  Query& query = *static_cast<Query*>(context);
  const int a = std::min(molecule_of(one), molecule_of(other)), b = std::max(molecule_of(one), molecule_of(other));
  const double depth =
      query.body.radius[a] + query.body.radius[b] - (query.positions.col(b) - query.positions.col(a)).norm();
  if (depth > query.tolerance * std::min(query.body.radius[a], query.body.radius[b]))
    query.found.push_back({a, b, depth});
  return false;
}

}  // namespace

std::vector<Overlap> find_overlaps(const Body& body, const Positions& positions, double tolerance) {
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  std::vector<fcl::CollisionObjectd*> pointers;
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    auto sphere = std::make_shared<fcl::Sphered>(body.radius[molecule]);
    const fcl::Vector3d position = positions.col(molecule);
    objects.push_back(std::make_unique<fcl::CollisionObjectd>(sphere, fcl::Matrix3d::Identity(), position));
    objects.back()->setUserData(reinterpret_cast<void*>(static_cast<std::intptr_t>(molecule)));
    pointers.push_back(objects.back().get());
  }
  fcl::DynamicAABBTreeCollisionManagerd tree;
  tree.registerObjects(pointers);  // one by one a chain would make the tree a chain
  tree.setup();
  Query query{body, positions, tolerance, {}};
  tree.collide(&query, &meet);

  std::unordered_set<std::uint64_t> joined;
  const auto key = [](int a, int b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
  };
  for (int c = 0; c < body.connections.proper(); ++c)
    joined.insert(key(body.connections.ends[c][0], body.connections.ends[c][1]));
  std::erase_if(query.found,
                [&](const Overlap& overlap) { return joined.contains(key(overlap.first, overlap.second)); });
  std::sort(query.found.begin(), query.found.end(), [](const Overlap& x, const Overlap& y) {
    return std::pair{x.first, x.second} < std::pair{y.first, y.second};
  });
  return std::move(query.found);
}

}  // namespace elastin::contact
