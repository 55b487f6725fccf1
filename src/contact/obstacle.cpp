#include "elastin/contact/obstacle.h"

namespace elastin::contact {

Vector3 Pose::to_world(const Vector3& own) const { return turn * own + position; }
Vector3 Pose::to_own(const Vector3& world) const { return turn.transpose() * (world - position); }
Vector3 Pose::velocity_at(const Vector3& world) const { return velocity + spin.cross(world - position); }

}  // namespace elastin::contact
