#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "elastin/contact/obstacle.h"

namespace elastin::contact {

/// A point on a body's surface that can touch something: Σ weight · position of up to four molecules.
struct Sample {
  std::array<int, 4> molecules{-1, -1, -1, -1};  ///< the first `count`
  std::array<double, 4> weights{0, 0, 0, 0};     ///< they sum to 1
  int count = 1;
  double radius = 0;  ///< of the sphere about it [m]
  double area = 0;    ///< of the surface that it stands for [m²]
  int piece = 0;      ///< of the body (BodyFindings::piece_of)
};

/// A body's surface, normals outwards, as its cells have it: no diagonal of a quadrilateral is preferred.
struct SurfaceSides {
  Cells<3> triangles;
  Cells<4> quadrilaterals;
  /// At rest [m²], of the triangles and then of the quadrilaterals. Those of a curved side share its own area.
  std::vector<double> areas;
  bool empty() const { return areas.empty(); }
};
/// Sides of one cell alone, those of second order in the flat sides that their nodes make, and cells of two dimensions.
/// Empty where the body has no such cells.
SurfaceSides surface_sides(const Body& body);
/// The names of a body's parts of which nothing is in these sides, such as ropes and packings.
std::vector<std::string> parts_without(const SurfaceSides& sides, const Body& body);

/// The molecules' own spheres; area (2r)². `molecules` names those that can touch.
std::vector<Sample> sphere_samples(const Body& body, const std::vector<int>& molecules);
/// Points of a surface where integrals are taken, radius 0: three a triangle, four a quadrilateral. Together those of a
/// side stand for its area.
std::vector<Sample> side_samples(const Body& body, const SurfaceSides& sides);

/// The body's surface in triangles alone, for pictures.
Cells<3> surface_triangles(const Body& body);
/// Molecules that can touch, ascending: all but those inside a surface of cells (tetrahedra, cubes).
std::vector<int> surface_molecules(const Body& body);

/// A sample near something that it can touch.
struct ContactPoint {
  int sample = 0;
  int target = 0;  ///< an obstacle's number; then, from the number of obstacles on, pieces of the body; then samples
  Vector3 normal = Vector3::UnitZ();   ///< unit, from the target to the sample
  double gap = 0;                      ///< between the surfaces [m]; below 0 = pressed in
  Vector3 position = Vector3::Zero();  ///< on the target's surface [m]
  /// On the body as target: position = Σ weight · molecule + reach of a sphere along the normal. Count 0 = an obstacle.
  std::array<int, 4> molecules{-1, -1, -1, -1};
  std::array<double, 4> weights{0, 0, 0, 0};
  int count = 0;
  /// How the normal turns as the sample moves against the target: ∂n/∂(x_sample − x_target) [1/m], symmetric; zero on a
  /// plane.
  Matrix3 turning = Matrix3::Zero();
  /// How it turns with the target's triangle: δn = −Σ slope_j (n · δx_j) [1/m]; zero where it has none.
  std::array<Vector3, 4> slopes{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
};

/// Finds what is near. Pieces touch each other; a quadrilateral is touched as four triangles about its middle. A closed
/// surface pushes out what is up to half its mean side behind it: back through where it came in, if it is more than
/// half through. A surface with a rim is a sheet, touched on both sides and never behind: what touches it needs a
/// radius. Within a piece what is joined, and what overlaps at rest, does not touch. Broad phase by FCL over boxes that
/// are `skin` wider than they must be, and made again only when something has moved by half of it; the touches found
/// never depend on that. Not to be shared between threads.
class ContactSearch {
 public:
  struct Cost {
    double broad_seconds = 0, narrow_seconds = 0;
    long rebuilds = 0, calls = 0;
    std::size_t candidates = 0;  ///< pairs that the broad phase left, last time
  };
  /// @param spheres whether the body is touched as spheres (else as `sides`, which may be empty).
  /// @param self whether samples touch their own piece, too: not what they are joined to.
  ContactSearch(const Body& body, std::vector<Sample> samples, const SurfaceSides& sides, bool spheres,
                const std::vector<Obstacle>& obstacles, bool self);
  ~ContactSearch();
  ContactSearch(ContactSearch&&) noexcept;

  /// All pairs with gap < reach [m], ascending by (sample, target); of several places on one target the nearest.
  /// Nothing is allocated once `found` and the search have served.
  void find(const Positions& positions, const std::vector<Pose>& poses, double reach, std::vector<ContactPoint>& found);

  const std::vector<Sample>& samples() const;
  const Cost& cost() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastin::contact
