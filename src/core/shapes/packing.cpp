#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "core/base/random.h"
#include "elastin/core/geometry/numbering.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/model/share.h"
#include "elastin/core/shapes/shapes.h"

namespace elastin {
namespace {

/// Moves overlapping spheres apart, with soft springs between them and the descent of [Bitzek et al. 2006, FIRE].
/// Centres stay in the box. Returns how far each molecule still overlaps others, summed; all zero where there was room.
VectorX push_apart(Positions& positions, const Vector3& size, double distance) {
  constexpr int steps = 400;
  constexpr double skin = 0.3;
  double step = 0.1, mixing = 0.1;
  int downhill = 0;
  Positions velocity = Positions::Zero(3, positions.cols()), force(3, positions.cols());
  Connections near;
  double moved = INFINITY;  // since the pairs were listed; they serve until two could have met unseen
  for (int i = 0;; ++i) {
    if (2 * moved > skin * distance) {
      near = connections_within(positions, (1 + skin) * distance);
      moved = 0;
    }
    force.setZero();
    VectorX overlaps = VectorX::Zero(positions.cols());
    for (const auto& [a, b] : near.ends) {
      const Vector3 gap = positions.col(b) - positions.col(a);
      const double length = gap.norm(), overlap = distance - length;
      if (overlap <= 0) continue;
      overlaps[a] += overlap, overlaps[b] += overlap;
      const Vector3 push = length > 0 ? Vector3(gap * (overlap / length)) : Vector3(overlap, 0, 0);
      force.col(a) -= push;
      force.col(b) += push;
    }
    if (i == steps || overlaps.maxCoeff() == 0) return overlaps;
    if (force.cwiseProduct(velocity).sum() > 0) {
      velocity = (1 - mixing) * velocity + mixing * velocity.norm() / force.norm() * force;
      if (++downhill > 5) step = std::min(1.1 * step, 0.3), mixing *= 0.99;
    } else {
      velocity.setZero();
      step *= 0.5, mixing = 0.1, downhill = 0;
    }
    velocity += step * force;
    const Positions next = (positions + step * velocity).cwiseMax(0).cwiseMin(size.replicate(1, positions.cols()));
    moved += std::sqrt((next - positions).colwise().squaredNorm().maxCoeff());
    velocity = (next - positions) / step;  // what a wall stops, stops
    positions = next;
  }
}

}  // namespace

Body random_packing(const Vector3& size, double distance, double reach, std::uint64_t seed) {
  // Centres fill `size`, so the spheres themselves fill half a diameter more on every side. 0.62 of that is more than
  // walls let in; the molecules that find no room are taken out, the most crowded first, until all others have it.
  constexpr double fraction = 0.62;
  const double volume = (size.array() + distance).prod(), sphere = std::numbers::pi / 6 * std::pow(distance, 3);
  const int count = std::max(1, static_cast<int>(fraction * volume / sphere));
  std::mt19937_64 generator(seed);
  Positions positions(3, count);
  for (int molecule = 0; molecule < count; ++molecule)
    for (int axis = 0; axis < 3; ++axis) positions(axis, molecule) = size[axis] * unit_random(generator);

  const double apart = distance * 1.001;  // a little more than requested, so that rounding breaks no distance
  for (VectorX overlaps; (overlaps = push_apart(positions, size, apart)).maxCoeff() > 0;) {
    std::vector<int> crowded(positions.cols());
    std::iota(crowded.begin(), crowded.end(), 0);
    std::stable_sort(crowded.begin(), crowded.end(), [&](int a, int b) { return overlaps[a] > overlaps[b]; });
    crowded.resize(1 + crowded.size() / 200);
    std::sort(crowded.begin(), crowded.end(), std::greater<>());
    for (const int molecule : crowded) {
      positions.middleCols(molecule, positions.cols() - molecule - 1) =
          positions.rightCols(positions.cols() - molecule - 1).eval();
      positions.conservativeResize(3, positions.cols() - 1);
    }
  }
  std::vector<Vector3> rest;
  for (const int molecule : order_in_space(positions)) rest.push_back(positions.col(molecule));
  Body body = listed_body(rest, {});
  body.connections = connections_within(body.rest, reach);
  return body;
}

void add_jitter(Body& body, double amount, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const Vector3 low = body.rest.rowwise().minCoeff(), high = body.rest.rowwise().maxCoeff();
  const double tolerance = 1e-9 * (high - low).norm();
  for (int molecule = 0; molecule < body.size(); ++molecule)
    for (int axis = 0; axis < 3; ++axis) {
      const double move = amount * (2 * unit_random(generator) - 1);
      double& position = body.rest(axis, molecule);
      if (position > low[axis] + tolerance && position < high[axis] - tolerance) position += move;
    }
  set_present_lengths(body);
}

void rotate(Body& body, const Matrix3& rotation) {
  body.rest = (rotation * body.rest).eval();
  body.outline = (rotation * body.outline).eval();
  if (!body.unstressed) return;
  Rest turned = *body.unstressed;
  turned.metric = [R = rotation, own = body.unstressed](const Vector3& place, const Vector3& middle) -> Matrix3 {
    return R * own->metric(R.transpose() * place, R.transpose() * middle) * R.transpose();
  };
  if (turned.length)
    turned.length = [R = rotation, own = body.unstressed](const Vector3& first, const Vector3& second) {
      return own->length(R.transpose() * first, R.transpose() * second);
    };
  body.unstressed = std::make_shared<const Rest>(std::move(turned));
}

void set_matter(Body& body, double radius, double density, double thickness, double volume) {
  body.radius = VectorX::Constant(body.size(), radius);
  const bool has_cells = !body.triangles.empty() || !body.tetrahedra.empty();
  if (!body.blocks.empty()) {
    body.mass = density * lumped_volumes(body, thickness);
    return;
  }
  body.mass = has_cells
                  ? lumped_mass(body.rest, body.triangles, body.tetrahedra, density, thickness)
                  : VectorX::Constant(body.size(), density * volume / static_cast<double>(molecules_of_whole(body)));
}

}  // namespace elastin
