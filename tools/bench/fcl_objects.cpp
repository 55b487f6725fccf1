#include "fcl_objects.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include <stdexcept>

namespace bench {
namespace {

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

std::shared_ptr<fcl::CollisionGeometryd> geometry_of(const elastin::contact::ObstacleShape& shape) {
  if (std::holds_alternative<elastin::contact::shape::Plane>(shape))
    return std::make_shared<fcl::Halfspaced>(fcl::Vector3d::UnitZ(), 0);
  if (const auto* ball = std::get_if<elastin::contact::shape::Sphere>(&shape))
    return std::make_shared<fcl::Sphered>(ball->radius);
  throw std::runtime_error("the peer knows planes and spheres alone");
}

struct Group {
  std::vector<int> molecules;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  fcl::DynamicAABBTreeCollisionManagerd tree;
};

}  // namespace

struct FclObjects::Impl {
  std::vector<std::unique_ptr<Group>> groups;
  std::unique_ptr<fcl::CollisionObjectd> obstacle;
};

FclObjects::FclObjects(const elastin::Body& body, const std::vector<std::vector<int>>& groups,
                       const elastin::contact::Obstacle* obstacle)
    : impl_(std::make_unique<Impl>()) {
  for (const auto& molecules : groups) {
    Group& group = *impl_->groups.emplace_back(std::make_unique<Group>());
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
    impl_->obstacle = std::make_unique<fcl::CollisionObjectd>(geometry_of(obstacle->shape), obstacle->pose.turn,
                                                              obstacle->pose.position);
}
FclObjects::~FclObjects() = default;

std::size_t FclObjects::find(const elastin::Positions& positions) {
  for (auto& group : impl_->groups) {
    for (std::size_t i = 0; i < group->objects.size(); ++i) {
      group->objects[i]->setTranslation(positions.col(group->molecules[i]));
      group->objects[i]->computeAABB();
    }
    group->tree.update();
  }
  Contacts contacts;
  if (impl_->obstacle)
    impl_->groups[0]->tree.collide(impl_->obstacle.get(), &contacts, &collide);
  else
    impl_->groups[0]->tree.collide(&impl_->groups[1]->tree, &contacts, &collide);
  return contacts.count;
}

}  // namespace bench
