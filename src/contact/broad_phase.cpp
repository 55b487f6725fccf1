#include "contact/broad_phase.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/geometry/triangle.h"
#include "core/parallel/parallel.h"

namespace elastin::contact {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Number of boxes or molecules from which several threads handle them.
constexpr int kManyBoxes = 20000;

/// Of a radius: what lies nearer to each other at rest is what a cut has split, and has no side on which it is.
constexpr double kOnePlace = 1e-9;

Rows neighbours_of(const Body& body) {
  std::vector<int> from, to;
  for (const auto& [a, b] : body.connections.ends) {
    from.insert(from.end(), {a, b});
    to.insert(to.end(), {b, a});
  }
  for (const Tie& tie : body.ties)
    for (const int corner : tie.corners) {
      from.insert(from.end(), {tie.molecule, corner});
      to.insert(to.end(), {corner, tie.molecule});
    }
  Rows rows = rows_by_target(body.size(), from);
  for (int& entry : rows.entries) entry = to[entry];
  return rows;
}

/// A part of what is typical between neighbours on the surface: wide enough to last, narrow enough to leave few
/// candidates. Of triangles there are many in a wide ring.
double typical_skin(const ContactGeometry& geometry) {
  double radii = 0, sides = 0;
  for (const Sample& sample : geometry.samples) radii += sample.radius;
  for (std::size_t t = 0; t < geometry.triangles.size(); ++t) {
    const auto [a, b, c] = geometry.corners_of(static_cast<int>(t), geometry.rest);
    sides += ((b - a).norm() + (c - b).norm() + (a - c).norm()) / 3;
  }
  const double of_radii = geometry.samples.empty() ? 0 : radii / static_cast<double>(geometry.samples.size());
  const double of_sides = geometry.triangles.empty() ? 0 : sides / static_cast<double>(geometry.triangles.size()) / 4;
  const double size = geometry.body.size()
                          ? (geometry.body.rest.rowwise().maxCoeff() - geometry.body.rest.rowwise().minCoeff()).norm()
                          : 0;
  return std::max({geometry.spheres || of_sides == 0 ? of_radii : 0, of_sides, 1e-4 * size});
}

}  // namespace

BroadPhase::BroadPhase(const ContactGeometry& geometry) : geometry_(geometry), skin_(typical_skin(geometry)) {
  std::vector<char> seen(geometry.pieces, 0);
  std::vector<char> moves(static_cast<std::size_t>(geometry.rest.cols()), 0);
  for (const Sample& sample : geometry.samples) {
    piece_of_sample_.push_back(sample.piece);
    seen[sample.piece] = 1;
    for (int k = 0; k < sample.count; ++k) moves[sample.molecules[k]] = 1;
  }
  for (const int piece : geometry.piece_of_triangle) seen[piece] = 1;
  within_body_ = (geometry.spheres || !geometry.triangles.empty()) &&
                 (geometry.self || std::count(seen.begin(), seen.end(), 1) > 1);
  if (within_body_ && !geometry.spheres)
    for (const auto& triangle : geometry.triangles)
      for (const int point : triangle) moves[point] = 1;
  for (int point = 0; point < geometry.rest.cols(); ++point)
    if (moves[point]) moving_.push_back(point);
  if (geometry.self) neighbours_ = neighbours_of(geometry.body);
  positions_.resize(3, static_cast<Eigen::Index>(moving_.size()));
  sample_boxes_.resize(geometry.samples.size());
  if (within_body_ && !geometry.spheres) triangle_boxes_.resize(geometry.triangles.size());
}

void BroadPhase::refit(const Positions& positions) {
  parallel_for(
      static_cast<int>(sample_boxes_.size()),
      [&](int s) {
        const Sample& sample = geometry_.samples[s];
        const Vector3 position = geometry_.position_of(sample, positions), wide = Vector3::Constant(sample.radius);
        sample_boxes_[s] = {position - wide, position + wide};
      },
      kManyBoxes);
  parallel_for(
      static_cast<int>(triangle_boxes_.size()),
      [&](int t) {
        const auto [a, b, c] = geometry_.corners_of(t, positions);
        triangle_boxes_[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
      },
      kManyBoxes);
  const auto serve = [](BoxTree& tree, const std::vector<Box>& boxes, const std::vector<int>& groups) {
    if (!tree.nodes().empty()) tree.refit(boxes);
    if (tree.nodes().empty() || tree.worn()) tree = BoxTree(boxes, groups);
  };
  serve(samples_, sample_boxes_, piece_of_sample_);
  if (!triangle_boxes_.empty()) serve(triangles_, triangle_boxes_, geometry_.piece_of_triangle);
}

bool BroadPhase::still_valid(const Positions& positions, const std::vector<Pose>& poses, double reach) const {
  if (left_out_.size() != poses.size() || samples_.nodes().empty()) return false;
  const double square = largest_of_ranges(static_cast<int>(moving_.size()), [&](int begin, int end) {
    double most = 0;
    for (int i = begin; i < end; ++i)
      most = std::max(most, (positions.col(moving_[i]) - positions_.col(i)).squaredNorm());
    return most;
  });
  const Box& all = samples_.nodes()[0].box;
  const double half = all.half_diagonal(), rounding = 1e-12 * (half + all.middle().norm());
  const double moved = std::sqrt(square) + rounding;
  if (within_body_ && !(left_out_in_body_ - needed(reach) > 2 * moved)) return false;
  for (std::size_t o = 0; o < poses.size(); ++o) {
    // In the obstacle's frame a sample at middle + s, |s| ≤ half, has moved by what the middle has and ΔRᵀ s.
    const Pose &now = poses[o], &then = poses_[o];
    const double turned =
        (now.to_own(all.middle()) - then.to_own(all.middle())).norm() + (now.turn - then.turn).norm() * half;
    if (!(left_out_[o] - reach > moved + turned)) return false;
  }
  return true;
}

bool BroadPhase::update(const Positions& positions, const std::vector<Pose>& poses, double reach) {
  searched_reach_ = std::max(searched_reach_, reach);
  if (geometry_.samples.empty() || still_valid(positions, poses, reach)) return false;
  // Whoever asks for little and much in turn is to be served with one look.
  const double widest = std::exchange(searched_reach_, reach);
  refit(positions);
  now_ = &positions;
  for (std::size_t i = 0; i < moving_.size(); ++i)
    positions_.col(static_cast<Eigen::Index>(i)) = positions.col(moving_[i]);
  poses_ = poses;
  left_out_.assign(poses.size(), kInfinite);
  left_out_in_body_ = kInfinite;
  candidates_.clear();
  for (std::size_t o = 0; o < poses.size(); ++o) visit_obstacle(0, static_cast<int>(o), poses[o], widest + skin_);
  if (within_body_) {
    const double within = needed(widest) + skin_;
    if (geometry_.spheres)
      visit_spheres(0, within);
    else
      visit_triangles(0, 0, within);
  }
  sort_candidates();
  return true;
}

/// Into the rows of their samples, then each row: n log n over all would take longer than to find them.
void BroadPhase::sort_candidates() {
  starts_.assign(geometry_.samples.size() + 1, 0);
  for (const Candidate& candidate : candidates_) ++starts_[candidate.sample + 1];
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  if (sorted_.capacity() < candidates_.size()) sorted_.reserve(2 * candidates_.size());
  sorted_.resize(candidates_.size());
  for (const Candidate& candidate : candidates_) sorted_[starts_[candidate.sample]++] = candidate;
  auto begin = sorted_.begin();
  for (std::size_t s = 0; s < geometry_.samples.size(); ++s) {  // each start is now its row's end
    const auto end = sorted_.begin() + starts_[s];
    if (end - begin > 1) std::sort(begin, end);
    begin = end;
  }
  std::swap(candidates_, sorted_);
}

void BroadPhase::visit_obstacle(int node, int obstacle, const Pose& pose, double within) {
  const BoxTree::Node& here = samples_.nodes()[node];
  const bool leaf = here.second < 0;
  const double around = leaf ? geometry_.samples[here.item].radius : here.box.half_diagonal();
  const auto o = static_cast<std::size_t>(obstacle);
  const double gap = geometry_.obstacles[o].at(pose.to_own(here.box.middle())).value - around;
  if (!(gap < within)) {
    left_out_[o] = std::min(left_out_[o], gap);
  } else if (leaf) {
    candidates_.push_back({here.item, obstacle, 0});
  } else {
    visit_obstacle(node + 1, obstacle, pose, within);
    visit_obstacle(here.second, obstacle, pose, within);
  }
}

void BroadPhase::visit_triangles(int node, int other, double within) {
  const BoxTree::Node& samples = samples_.nodes()[node];
  const BoxTree::Node& triangles = triangles_.nodes()[other];
  if (!geometry_.self && samples.group >= 0 && samples.group == triangles.group) return;
  const double gap = samples.box.distance(triangles.box);
  if (!(gap < within)) {
    left_out_in_body_ = std::min(left_out_in_body_, gap);
  } else if (samples.second < 0 && triangles.second < 0) {
    add_triangle(samples.item, triangles.item, within);
  } else if (triangles.second < 0 ||
             (samples.second >= 0 && samples.box.half_diagonal() > triangles.box.half_diagonal())) {
    visit_triangles(node + 1, other, within);
    visit_triangles(samples.second, other, within);
  } else {
    visit_triangles(node, other + 1, within);
    visit_triangles(node, triangles.second, within);
  }
}

void BroadPhase::visit_spheres(int node, double within) {
  const BoxTree::Node& here = samples_.nodes()[node];
  if (here.second < 0 || (!geometry_.self && here.group >= 0)) return;
  visit_spheres(node + 1, within);
  visit_spheres(here.second, within);
  visit_sphere_pairs(node + 1, here.second, within);
}

void BroadPhase::visit_sphere_pairs(int node, int other, double within) {
  const BoxTree::Node& one = samples_.nodes()[node];
  const BoxTree::Node& two = samples_.nodes()[other];
  if (!geometry_.self && one.group >= 0 && one.group == two.group) return;
  const double gap = one.box.distance(two.box);
  if (!(gap < within)) {
    left_out_in_body_ = std::min(left_out_in_body_, gap);
  } else if (one.second < 0 && two.second < 0) {
    add_spheres(std::min(one.item, two.item), std::max(one.item, two.item));
  } else if (two.second < 0 || (one.second >= 0 && one.box.half_diagonal() > two.box.half_diagonal())) {
    visit_sphere_pairs(node + 1, other, within);
    visit_sphere_pairs(one.second, other, within);
  } else {
    visit_sphere_pairs(node, other + 1, within);
    visit_sphere_pairs(node, two.second, within);
  }
}

bool BroadPhase::joined(const Sample& sample, std::span<const int> molecules) const {
  for (int k = 0; k < sample.count; ++k)
    for (const int molecule : molecules) {
      if (sample.molecules[k] == molecule) return true;
      const auto near = neighbours_[sample.molecules[k]];
      if (std::find(near.begin(), near.end(), molecule) != near.end()) return true;
    }
  return false;
}

bool BroadPhase::overlap_at_rest(const Sample& sample, int triangle) const {
  const Vector3 position = geometry_.position_of(sample, geometry_.rest);
  const auto corners = geometry_.corners_of(triangle, geometry_.rest);
  const Vector3 away = position - nearest_point(position, corners).position;
  const double distance = away.norm();
  const bool behind = away.dot((corners[1] - corners[0]).cross(corners[2] - corners[0])) <= 0;
  return distance < sample.radius || (behind && distance < 3 * geometry_.depth);
}

void BroadPhase::add_triangle(int s, int triangle, double within) {
  const Sample& sample = geometry_.samples[s];
  const int piece = geometry_.piece_of_triangle[triangle];
  if (piece == sample.piece) {
    if (!geometry_.self || joined(sample, geometry_.molecules_of(triangle)) || overlap_at_rest(sample, triangle))
      return;
  }
  const Vector3 position = geometry_.position_of(sample, *now_);
  const double gap =
      (position - nearest_point(position, geometry_.corners_of(triangle, *now_)).position).norm() - sample.radius;
  if (!(gap < within)) {
    left_out_in_body_ = std::min(left_out_in_body_, gap);
    return;
  }
  candidates_.push_back({s, geometry_.first_piece() + piece, triangle});
}

void BroadPhase::add_spheres(int first, int second) {
  const Sample& one = geometry_.samples[first];
  const Sample& two = geometry_.samples[second];
  const Positions& rest = geometry_.body.rest;
  const double apart = (geometry_.position_of(one, rest) - geometry_.position_of(two, rest)).norm();
  if (apart < kOnePlace * one.radius) return;
  if (one.piece == two.piece)
    if (!geometry_.self || joined(one, {two.molecules.data(), static_cast<std::size_t>(two.count)}) ||
        apart < one.radius + two.radius)
      return;
  candidates_.push_back({first, geometry_.first_sphere() + second, 0});
}

}  // namespace elastin::contact
