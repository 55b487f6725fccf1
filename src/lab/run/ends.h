#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/model/faces.h"
#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// Which molecules an experiment holds at the two ends of its body.
struct GripSetup {
  double grip_depth = 0;  ///< [m]: molecules this close to the furthest one belong to its end; 0 = see end_face
  std::optional<std::vector<int>> fixed, loaded;  ///< ascending, in place of those of an end
  bool longest = false;                           ///< whether the axis is the body's longest one
};

/// The principal axis of inertia along which a body extends furthest, its largest component positive. Throws InputError
/// where it extends as far along another one, to 1 %.
Vector3 longest_axis(const Body& body);

/// "265.1 mm2": four digits, in the unit that keeps them readable, of an area [m²].
std::string area_text(double area);

/// Finds the ends of a body, looks at what it caught, and keeps what is to be said of that.
class EndFinder {
 public:
  EndFinder(const Body& body, double grip_depth, bool longest = false)
      : body_(body), grip_depth_(grip_depth), longest_(longest) {}

  /// The end that looks along `direction` (unit), or the molecules that the scene picks in its place; `name` is "fixed"
  /// or "loaded". Of a solid: throws InputError, with a grip_depth that would do, where fewer than three molecules were
  /// found, or where the end has less than half the area of the section behind it. A picked set is named only.
  Face find(const std::string& name, const Vector3& direction, const std::optional<std::vector<int>>& picked = {});

  Findings findings;

 private:
  void judge_solid(const std::string& name, const Vector3& direction, bool picked, const Face& face);
  void judge_molecules(const std::string& name, const Vector3& direction, const Face& face);

  const Body& body_;
  double grip_depth_;
  bool longest_;  ///< whether the axis is the body's longest one
};

/// The two ends of a body along an axis.
struct Ends {
  Ends(const Body& body, const Vector3& axis, const GripSetup& setup);
  Face fixed, loaded;
  std::vector<int> held, moved;  ///< the molecules of both, with all of a rigid body of which they have some
  Findings findings;
  /// Heights [m] along the axis between which the section is to be measured: of the whole body, or, where an end is no
  /// plane, was picked or has a depth, of what lies between the two.
  double low = 0, high = 0;
  /// Whether ends that are no planes across the axis take up so much of the length that the body is no prism: its
  /// height varies by over a quarter.
  bool slanted = false;
};

/// Where a grip that is held or moved as a whole ends along the axis [m]: the mean height of its molecules that are
/// joined to others, for what lies deeper in it takes no part in a strain; `otherwise` where none are, or all.
double end_of_grip(const Body& body, const std::vector<int>& molecules, const Vector3& axis, double otherwise);

/// Says that a stated gauge length or cross-section is far from the body's own: by more than a factor of two from all
/// of `own`, which may be several of a porous or curved body; `refer`: what refers to it.
void note_stated(const std::string& key, const std::string& refer, double stated, const std::vector<double>& own,
                 const std::function<std::string(double)>& text, Findings& findings);
/// The same of a cross-section along the axis. The body's own are `section`, that of its hull, and that of the hull
/// around its molecules' spheres.
void note_stated_section(const Body& body, const Vector3& axis, double stated, double section, Findings& findings);

/// Says that the walls of a body's cavities move as its surface does, where all of that is given a motion. Throws
/// InputError where a part of the body is rigid, and cannot follow.
void note_cavities(const Body& body, Findings& findings);

/// The convex hull of a body seen on a plane; where its end `fixed` is no plane that of this end alone, for a tilted
/// bar has a larger shadow than section.
Points2 hull_of_section(const Body& body, const Face& fixed, const Eigen::Matrix<double, 3, 2>& plane);

/// The grip depth [m] with which both ends of a solid have half of the section; 0 where they are held well without, or
/// no depth would do.
double needed_grip_depth(const Body& body, const Vector3& axis);

}  // namespace elastin::lab
