#include "contact/search.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "contact/broad_phase.h"
#include "contact/distance.h"
#include "core/parallel/parallel.h"

namespace elastin::contact {
namespace {

/// Number of samples from which the search goes on several threads.
constexpr int kManyGroups = 2000;
/// cos 60°: a sample has not come in through triangles that look the same way as it does.
constexpr double kSameDirection = 0.5;

using Clock = std::chrono::steady_clock;
double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

ContactGeometry geometry_of(const Body& body, std::vector<Sample> samples, const SurfaceSides& sides, bool spheres,
                            const std::vector<Obstacle>& obstacles, bool self) {
  ContactGeometry geometry{
      body, std::move(samples), sides.triangles, sides.quadrilaterals, body.rest, {}, {}, 0, spheres, self, 0};
  int middle = body.size();
  geometry.rest.conservativeResize(3, middle + static_cast<Eigen::Index>(sides.quadrilaterals.size()));
  geometry.set_middles(geometry.rest);
  for (const auto& [a, b, c, d] : sides.quadrilaterals) {
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, d}, {d, a}})
      geometry.triangles.push_back({from, to, middle});
    ++middle;
  }
  const BodyFindings findings = inspect(body);
  geometry.pieces = findings.pieces;
  for (const Obstacle& obstacle : obstacles) geometry.obstacles.emplace_back(obstacle.shape);
  double lengths = 0;
  for (std::size_t t = 0; t < geometry.triangles.size(); ++t) {
    geometry.piece_of_triangle.push_back(findings.piece_of[geometry.triangles[t][0]]);
    const auto [a, b, c] = geometry.corners_of(static_cast<int>(t), geometry.rest);
    lengths += (b - a).norm() + (c - b).norm() + (a - c).norm();
  }
  if (!geometry.triangles.empty()) geometry.depth = lengths / static_cast<double>(6 * geometry.triangles.size());
  return geometry;
}

/// Whether each piece's surface has two triangles on every side, or four where parts meet: only then has it an inside.
std::vector<char> closed_pieces(const ContactGeometry& geometry) {
  std::vector<std::array<int, 3>> sides;  // piece, and the two points
  for (std::size_t t = 0; t < geometry.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(geometry.triangles[t][k], geometry.triangles[t][(k + 1) % 3]);
      sides.push_back({geometry.piece_of_triangle[t], a, b});
    }
  std::sort(sides.begin(), sides.end());
  std::vector<char> closed(geometry.pieces, 1);
  for (std::size_t i = 0, next; i < sides.size(); i = next) {
    for (next = i + 1; next < sides.size() && sides[next] == sides[i];) ++next;
    if ((next - i) % 2 == 1) closed[sides[i][0]] = 0;
  }
  return closed;
}

}  // namespace

struct ContactSearch::Impl {
  using Candidate = BroadPhase::Candidate;
  ContactGeometry geometry;
  BroadPhase broad;
  SurfaceNormals normals;
  std::vector<char> closed;
  Positions points;                          ///< of a body with quadrilaterals
  std::vector<int> groups;                   ///< where candidates of another (sample, target) begin, and the end
  std::vector<ContactPoint> contact_points;  ///< one a group
  std::vector<char> near;                    ///< whether it is one
  Cost cost;

  explicit Impl(ContactGeometry all)
      : geometry(std::move(all)),
        broad(geometry),
        normals(static_cast<int>(geometry.rest.cols()), geometry.triangles),
        closed(closed_pieces(geometry)) {}

  /// The molecules' positions and behind them those of the quadrilaterals' middles.
  const Positions& with_middles(const Positions& positions) {
    if (geometry.quadrilaterals.empty()) return positions;
    points.resize(3, geometry.rest.cols());
    points.leftCols(positions.cols()) = positions;
    geometry.set_middles(points);
    return points;
  }
  void set_groups();
  /// Makes a position on a triangle the target: a middle stands for its four molecules in equal parts.
  void set_target(int triangle, const std::array<double, 3>& weights, const std::array<Vector3, 3>& slopes,
                  ContactPoint& found) const;
  /// What the group's sample touches of its target, if it is nearer than reach.
  bool contact_point(int group, const Positions& positions, const std::vector<Pose>& poses, double reach,
                     ContactPoint& contact_point) const;
  bool add_obstacle_contact(const Pose& pose, const Vector3& position, double reach, ContactPoint& contact_point) const;
  bool add_surface_contact(int group, const Positions& positions, const Vector3& position, double reach,
                           ContactPoint& contact_point) const;
  bool add_sphere_contact(const Positions& positions, const Vector3& position, double reach,
                          ContactPoint& contact_point) const;
};

void ContactSearch::Impl::set_groups() {
  const auto& candidates = broad.candidates();
  groups.clear();
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (c == 0 || candidates[c].sample != candidates[c - 1].sample || candidates[c].target != candidates[c - 1].target)
      groups.push_back(static_cast<int>(c));
  if (contact_points.capacity() < groups.size()) {  // with room for a few more next time
    contact_points.reserve(2 * groups.size());
    near.reserve(2 * groups.size());
  }
  contact_points.resize(groups.size());
  near.resize(groups.size());
  groups.push_back(static_cast<int>(candidates.size()));
}

bool ContactSearch::Impl::contact_point(int group, const Positions& positions, const std::vector<Pose>& poses,
                                        double reach, ContactPoint& found) const {
  const Candidate& candidate = broad.candidates()[groups[group]];
  found = ContactPoint{};
  found.sample = candidate.sample;
  found.target = candidate.target;
  const Vector3 position = geometry.position_of(geometry.samples[candidate.sample], positions);
  if (candidate.target < geometry.first_piece())
    return add_obstacle_contact(poses[candidate.target], position, reach, found);
  if (candidate.target < geometry.first_sphere()) return add_surface_contact(group, positions, position, reach, found);
  return add_sphere_contact(positions, position, reach, found);
}

bool ContactSearch::Impl::add_obstacle_contact(const Pose& pose, const Vector3& position, double reach,
                                               ContactPoint& found) const {
  const Distance distance = geometry.obstacles[found.target].at(pose.to_own(position));
  found.gap = distance.value - geometry.samples[found.sample].radius;
  if (!(found.gap < reach)) return false;
  found.normal = pose.turn * distance.normal;
  found.position = position - distance.value * found.normal;
  found.turning = pose.turn * distance.turning * pose.turn.transpose();
  return true;
}

bool ContactSearch::Impl::add_sphere_contact(const Positions& positions, const Vector3& position, double reach,
                                             ContactPoint& found) const {
  const Sample& target = geometry.samples[found.target - geometry.first_sphere()];
  const Vector3 middle = geometry.position_of(target, positions), away = position - middle;
  const double distance = away.norm();
  found.gap = distance - geometry.samples[found.sample].radius - target.radius;
  if (!(found.gap < reach)) return false;
  const bool apart = distance > 1e-12 * target.radius && distance > 0;
  found.normal = apart ? Vector3(away / distance) : Vector3::UnitZ();
  if (apart) found.turning = (Matrix3::Identity() - found.normal * found.normal.transpose()) / distance;
  found.position = middle + target.radius * found.normal;
  found.molecules = target.molecules;
  found.weights = target.weights;
  found.count = target.count;
  return true;
}

bool ContactSearch::Impl::add_surface_contact(int group, const Positions& positions, const Vector3& position,
                                              double reach, ContactPoint& found) const {
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    int triangle = -1;
    NearestPoint position{};
    bool same_direction = false;
  } nearest, facing;  // of all, and of those that look at the sample's own side
  const Sample& sample = geometry.samples[found.sample];
  const int piece = found.target - geometry.first_piece();
  Vector3 looks = Vector3::Zero();
  if (sample.count >= 3) {  // of four the diagonals
    const auto at = [&](int corner) -> Vector3 { return positions.col(sample.molecules[corner]); };
    looks =
        (sample.count == 4 ? (at(2) - at(0)).cross(at(3) - at(1)) : (at(1) - at(0)).cross(at(2) - at(0))).normalized();
  }
  for (int c = groups[group]; c < groups[group + 1]; ++c) {
    const int triangle = broad.candidates()[c].item;
    const auto corners = geometry.corners_of(triangle, positions);
    const Vector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double same_direction = across.dot(looks), limit = kSameDirection * across.norm();
    if (piece == sample.piece && same_direction > 0) continue;
    const NearestPoint on = nearest_point(position, corners);
    const double distance = (position - on.position).norm();
    if (distance < nearest.distance) nearest = {distance, triangle, on, same_direction > limit};
    if (distance < facing.distance && same_direction < -limit) facing = {distance, triangle, on, false};
  }
  if (nearest.triangle < 0) return false;
  Distance distance = distance_to_surface(normals, positions, nearest.triangle, nearest.position, position);
  if (!closed[piece]) {  // a sheet has two fronts and no inside
    if (distance.value < 0) distance = {-distance.value, -distance.normal, -distance.turning};
  } else if (distance.value < 0) {
    if (nearest.same_direction) {  // more than half through: back to where it came in
      if (facing.triangle < 0) return false;
      nearest = facing;
      distance = distance_to_surface(normals, positions, nearest.triangle, nearest.position, position);
    }
    if (!(distance.value < 0) || distance.value < -geometry.depth) return false;
  }
  found.gap = distance.value - sample.radius;
  if (!(found.gap < reach)) return false;
  found.normal = distance.normal;
  found.turning = distance.turning;
  found.position = nearest.position.position;
  set_target(nearest.triangle, nearest.position.weights,
             weight_slopes(geometry.corners_of(nearest.triangle, positions), nearest.position.weights), found);
  return true;
}

void ContactSearch::Impl::set_target(int triangle, const std::array<double, 3>& weights,
                                     const std::array<Vector3, 3>& slopes, ContactPoint& found) const {
  const std::span<const int> molecules = geometry.molecules_of(triangle);
  const auto& corners = geometry.triangles[triangle];
  found.count = static_cast<int>(molecules.size());
  for (int k = 0; k < found.count; ++k) {
    found.molecules[k] = molecules[k];
    found.weights[k] = found.count == 4 ? weights[2] / 4 : 0;
    if (found.count == 4) found.slopes[k] = slopes[2] / 4;
    for (int corner = 0; corner < 3; ++corner)
      if (corners[corner] == molecules[k]) found.weights[k] += weights[corner], found.slopes[k] += slopes[corner];
  }
}

ContactSearch::ContactSearch(const Body& body, std::vector<Sample> samples, const SurfaceSides& sides, bool spheres,
                             const std::vector<Obstacle>& obstacles, bool self)
    : impl_(std::make_unique<Impl>(geometry_of(body, std::move(samples), sides, spheres, obstacles, self))) {}
ContactSearch::~ContactSearch() = default;
ContactSearch::ContactSearch(ContactSearch&&) noexcept = default;

void ContactSearch::find(const Positions& molecules, const std::vector<Pose>& poses, double reach,
                         std::vector<ContactPoint>& found) {
  Impl& impl = *impl_;
  const Positions& positions = impl.with_middles(molecules);
  const auto start = Clock::now();
  if (impl.broad.update(positions, poses, reach)) {
    impl.set_groups();
    ++impl.cost.rebuilds;
  }
  const auto middle = Clock::now();
  const int groups = static_cast<int>(impl.near.size());
  parallel_for(
      groups,
      [&](int group) {
        const auto g = static_cast<std::size_t>(group);
        impl.near[g] = impl.contact_point(group, positions, poses, reach, impl.contact_points[g]);
      },
      kManyGroups);
  found.clear();
  for (std::size_t group = 0; group < impl.near.size(); ++group)
    if (impl.near[group]) found.push_back(impl.contact_points[group]);
  const auto end = Clock::now();
  impl.cost.broad_seconds += seconds_between(start, middle);
  impl.cost.narrow_seconds += seconds_between(middle, end);
  impl.cost.candidates = impl.broad.candidates().size();
  ++impl.cost.calls;
}

const std::vector<Sample>& ContactSearch::samples() const { return impl_->geometry.samples; }
const ContactSearch::Cost& ContactSearch::cost() const { return impl_->cost; }

}  // namespace elastin::contact
