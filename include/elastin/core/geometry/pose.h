#pragma once
#include "elastin/core/base/types.h"

namespace elastin {

/// Where a rigid thing is and how it moves. A point p of its own frame lies at turn · p + position.
struct Pose {
  Matrix3 turn = Matrix3::Identity();
  Vector3 position = Vector3::Zero();  ///< [m]
  Vector3 velocity = Vector3::Zero();  ///< of its own origin [m/s]
  Vector3 spin = Vector3::Zero();      ///< [1/s]
  Vector3 to_world(const Vector3& own) const { return turn * own + position; }
  Vector3 to_own(const Vector3& world) const { return turn.transpose() * (world - position); }
  bool operator==(const Pose&) const = default;
  /// Of the material point that is there now [m/s].
  Vector3 velocity_at(const Vector3& world) const { return velocity + spin.cross(world - position); }
};

}  // namespace elastin
