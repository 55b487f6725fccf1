#pragma once
#include <memory>
#include <vector>

#include "elastin/contact/obstacle.h"

namespace bench {

/// The peer of contact: FCL as one uses it by hand. One collision object a sphere in a dynamic tree for each group;
/// every time all are moved, the trees brought up to date, and what the broad phase leaves is asked for contacts.
class FclObjects {
 public:
  /// Groups of molecules (pieces of a body); an obstacle, a plane or a sphere, if there is one group alone.
  FclObjects(const elastin::Body& body, const std::vector<std::vector<int>>& groups,
             const elastin::contact::Obstacle* obstacle);
  ~FclObjects();
  /// Pairs that touch at these positions.
  std::size_t find(const elastin::Positions& positions);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bench
