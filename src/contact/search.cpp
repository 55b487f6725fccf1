#include "contact/search.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "contact/broad_phase.h"
#include "contact/surface_normals.h"
#include "contact/triangle.h"
#include "core/parallel/parallel.h"

namespace elastin::contact {
namespace {

/// Places that are asked for what they touch, on several threads from so many on.
constexpr int kManyGroups = 2000;
/// cos 60°: a sample has not come in through triangles that look the same way as it does.
constexpr double kSameWay = 0.5;

using Clock = std::chrono::steady_clock;
double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

ContactParts parts_of(const Body& body, std::vector<Sample> samples, Cells<3> triangles, bool spheres,
                      const std::vector<Obstacle>& obstacles, bool self) {
  ContactParts parts{body, std::move(samples), std::move(triangles), {}, {}, 0, spheres, self, 0};
  const BodyFindings findings = inspect(body);
  parts.pieces = findings.pieces;
  for (const Obstacle& obstacle : obstacles) parts.obstacles.emplace_back(obstacle.shape);
  double sides = 0;
  for (std::size_t t = 0; t < parts.triangles.size(); ++t) {
    parts.piece_of_triangle.push_back(findings.piece_of[static_cast<std::size_t>(parts.triangles[t][0])]);
    const auto [a, b, c] = parts.corners_of(static_cast<int>(t), body.rest);
    sides += (b - a).norm() + (c - b).norm() + (a - c).norm();
  }
  if (!parts.triangles.empty()) parts.depth = sides / static_cast<double>(6 * parts.triangles.size());
  return parts;
}

/// Whether each piece's surface has two triangles on every side, or four where parts meet: only then has it an inside.
std::vector<char> closed_pieces(const ContactParts& parts) {
  std::vector<std::array<int, 3>> sides;  // piece, and the two molecules
  for (std::size_t t = 0; t < parts.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(parts.triangles[t][k], parts.triangles[t][(k + 1) % 3]);
      sides.push_back({parts.piece_of_triangle[t], a, b});
    }
  std::sort(sides.begin(), sides.end());
  std::vector<char> closed(static_cast<std::size_t>(parts.pieces), 1);
  for (std::size_t i = 0, next; i < sides.size(); i = next) {
    for (next = i + 1; next < sides.size() && sides[next] == sides[i];) ++next;
    if ((next - i) % 2 == 1) closed[static_cast<std::size_t>(sides[i][0])] = 0;
  }
  return closed;
}

}  // namespace

struct ContactSearch::Impl {
  using Candidate = BroadPhase::Candidate;
  ContactParts parts;
  BroadPhase broad;
  SurfaceNormals normals;
  std::vector<char> closed;
  std::vector<int> groups;     ///< where candidates of another (sample, target) begin, and the end
  std::vector<Touch> touches;  ///< one a group
  std::vector<char> near;      ///< whether it is one
  Cost cost;

  explicit Impl(ContactParts all)
      : parts(std::move(all)),
        broad(parts),
        normals(parts.body.size(), parts.triangles),
        closed(closed_pieces(parts)) {}

  void set_groups();
  /// What the group's sample touches of its target, if it is nearer than reach.
  bool touch(int group, const Positions& places, const std::vector<Pose>& poses, double reach, Touch& touch) const;
  bool touch_obstacle(const Pose& pose, const Vector3& place, double reach, Touch& touch) const;
  bool touch_surface(int group, const Positions& places, const Vector3& place, double reach, Touch& touch) const;
  bool touch_sphere(const Positions& places, const Vector3& place, double reach, Touch& touch) const;
};

void ContactSearch::Impl::set_groups() {
  const auto& candidates = broad.candidates();
  groups.clear();
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (c == 0 || candidates[c].sample != candidates[c - 1].sample || candidates[c].target != candidates[c - 1].target)
      groups.push_back(static_cast<int>(c));
  if (touches.capacity() < groups.size()) {  // with room for a few more next time
    touches.reserve(2 * groups.size());
    near.reserve(2 * groups.size());
  }
  touches.resize(groups.size());
  near.resize(groups.size());
  groups.push_back(static_cast<int>(candidates.size()));
}

bool ContactSearch::Impl::touch(int group, const Positions& places, const std::vector<Pose>& poses, double reach,
                                Touch& found) const {
  const Candidate& candidate = broad.candidates()[static_cast<std::size_t>(groups[static_cast<std::size_t>(group)])];
  found = Touch{};
  found.sample = candidate.sample;
  found.target = candidate.target;
  const Vector3 place = parts.place_of(parts.samples[static_cast<std::size_t>(candidate.sample)], places);
  if (candidate.target < parts.first_piece())
    return touch_obstacle(poses[static_cast<std::size_t>(candidate.target)], place, reach, found);
  if (candidate.target < parts.first_sphere()) return touch_surface(group, places, place, reach, found);
  return touch_sphere(places, place, reach, found);
}

bool ContactSearch::Impl::touch_obstacle(const Pose& pose, const Vector3& place, double reach, Touch& found) const {
  const Distance distance = parts.obstacles[static_cast<std::size_t>(found.target)].at(pose.to_own(place));
  found.gap = distance.value - parts.samples[static_cast<std::size_t>(found.sample)].radius;
  if (!(found.gap < reach)) return false;
  found.normal = pose.turn * distance.normal;
  found.place = place - distance.value * found.normal;
  found.turning = pose.turn * distance.turning * pose.turn.transpose();
  return true;
}

bool ContactSearch::Impl::touch_sphere(const Positions& places, const Vector3& place, double reach,
                                       Touch& found) const {
  const Sample& target = parts.samples[static_cast<std::size_t>(found.target - parts.first_sphere())];
  const Vector3 middle = parts.place_of(target, places), away = place - middle;
  const double distance = away.norm();
  found.gap = distance - parts.samples[static_cast<std::size_t>(found.sample)].radius - target.radius;
  if (!(found.gap < reach)) return false;
  const bool apart = distance > 1e-12 * target.radius && distance > 0;
  found.normal = apart ? Vector3(away / distance) : Vector3::UnitZ();
  if (apart) found.turning = (Matrix3::Identity() - found.normal * found.normal.transpose()) / distance;
  found.place = middle + target.radius * found.normal;
  found.molecules = target.molecules;
  found.weights = target.weights;
  found.count = target.count;
  return true;
}

bool ContactSearch::Impl::touch_surface(int group, const Positions& places, const Vector3& place, double reach,
                                        Touch& found) const {
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    int triangle = -1;
    NearestPlace place{};
    bool same_way = false;
  } nearest, facing;  // of all, and of those that look at the sample's own side
  const Sample& sample = parts.samples[static_cast<std::size_t>(found.sample)];
  const int piece = found.target - parts.first_piece();
  Vector3 looks = Vector3::Zero();
  if (sample.count == 3) {
    const Vector3 a = places.col(sample.molecules[0]);
    looks = (places.col(sample.molecules[1]) - a).cross(places.col(sample.molecules[2]) - a).normalized();
  }
  for (int c = groups[static_cast<std::size_t>(group)]; c < groups[static_cast<std::size_t>(group) + 1]; ++c) {
    const int triangle = broad.candidates()[static_cast<std::size_t>(c)].item;
    const auto corners = parts.corners_of(triangle, places);
    const Vector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double same_way = across.dot(looks), limit = kSameWay * across.norm();
    if (piece == sample.piece && same_way > 0) continue;
    const NearestPlace on = nearest_place(place, corners);
    const double distance = (place - on.place).norm();
    if (distance < nearest.distance) nearest = {distance, triangle, on, same_way > limit};
    if (distance < facing.distance && same_way < -limit) facing = {distance, triangle, on, false};
  }
  if (nearest.triangle < 0) return false;
  Distance distance = normals.distance(places, nearest.triangle, nearest.place, place);
  if (!closed[static_cast<std::size_t>(piece)]) {  // a sheet has two fronts and no inside
    if (distance.value < 0) distance = {-distance.value, -distance.normal, -distance.turning};
  } else if (distance.value < 0) {
    if (nearest.same_way) {  // more than half through: back to where it came in
      if (facing.triangle < 0) return false;
      nearest = facing;
      distance = normals.distance(places, nearest.triangle, nearest.place, place);
    }
    if (!(distance.value < 0) || distance.value < -parts.depth) return false;
  }
  found.gap = distance.value - sample.radius;
  if (!(found.gap < reach)) return false;
  found.normal = distance.normal;
  found.turning = distance.turning;
  found.place = nearest.place.place;
  found.molecules = parts.triangles[static_cast<std::size_t>(nearest.triangle)];
  found.weights = nearest.place.weights;
  found.count = 3;
  found.slopes = weight_slopes(parts.corners_of(nearest.triangle, places), nearest.place.weights);
  return true;
}

ContactSearch::ContactSearch(const Body& body, std::vector<Sample> samples, Cells<3> triangles, bool spheres,
                             const std::vector<Obstacle>& obstacles, bool self)
    : impl_(
          std::make_unique<Impl>(parts_of(body, std::move(samples), std::move(triangles), spheres, obstacles, self))) {}
ContactSearch::~ContactSearch() = default;
ContactSearch::ContactSearch(ContactSearch&&) noexcept = default;

void ContactSearch::find(const Positions& places, const std::vector<Pose>& poses, double reach,
                         std::vector<Touch>& found) {
  Impl& impl = *impl_;
  const auto start = Clock::now();
  if (impl.broad.update(places, poses, reach)) {
    impl.set_groups();
    ++impl.cost.rebuilds;
  }
  const auto middle = Clock::now();
  const int groups = static_cast<int>(impl.near.size());
  parallel_for(
      groups,
      [&](int group) {
        const auto g = static_cast<std::size_t>(group);
        impl.near[g] = impl.touch(group, places, poses, reach, impl.touches[g]);
      },
      kManyGroups);
  found.clear();
  for (std::size_t group = 0; group < impl.near.size(); ++group)
    if (impl.near[group]) found.push_back(impl.touches[group]);
  const auto end = Clock::now();
  impl.cost.broad_seconds += seconds_between(start, middle);
  impl.cost.narrow_seconds += seconds_between(middle, end);
  impl.cost.candidates = impl.broad.candidates().size();
  ++impl.cost.calls;
}

const std::vector<Sample>& ContactSearch::samples() const { return impl_->parts.samples; }
const ContactSearch::Cost& ContactSearch::cost() const { return impl_->cost; }

}  // namespace elastin::contact
