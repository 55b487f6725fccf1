#include "core/solve/rest_samples.h"

#include <array>
#include <utility>

#include "core/forces/unstressed_lengths.h"
#include "elastin/core/geometry/cell_kind.h"

namespace elastin {

SampledRest sampled_rest(const Body& body, const Positions& positions, double part) {
  SampledRest samples;
  const auto add = [&](const Vector3& place, const Vector3& middle, const Eigen::MatrixXd& before,
                       const Eigen::MatrixXd& now) {
    const auto whole = [](const Eigen::MatrixXd& edges) {
      Matrix3 all;
      all.leftCols(edges.cols()) = edges;
      if (edges.cols() == 2) all.col(2) = all.col(0).cross(all.col(1)).normalized();
      return all;
    };
    const Matrix3 growth = body.unstressed ? body.unstressed->at(place, middle, part) : Matrix3::Identity();
    samples.points.push_back({place, middle, growth * whole(before) * whole(now).inverse()});
  };
  const auto add_simplex = [&](const auto& cell) {
    const Eigen::MatrixXd before = body.rest(Eigen::all, cell), now = positions(Eigen::all, cell);
    const Eigen::Index edges = before.cols() - 1;
    const Vector3 middle = before.rowwise().mean();
    add(middle, middle, before.rightCols(edges).colwise() - before.col(0), now.rightCols(edges).colwise() - now.col(0));
  };
  for (const auto& cell : body.tetrahedra) add_simplex(cell);
  for (const auto& cell : body.triangles) add_simplex(cell);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const std::vector<int> nodes(block.cell(cell).begin(), block.cell(cell).end());
      const Eigen::MatrixXd before = body.rest(Eigen::all, nodes), now = positions(Eigen::all, nodes);
      for (std::size_t g = 0; g < block.kind->slopes.size(); ++g) {
        const Eigen::MatrixXd slopes = block.kind->slopes[g].transpose();
        add(before * block.kind->values.col(static_cast<Eigen::Index>(g)), before.rowwise().mean(), before * slopes,
            now * slopes);
      }
    }
  UnstressedLengths lengths(body);
  lengths.set(part);
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    const double before = (body.rest.col(b) - body.rest.col(a)).norm(),
                 now = (positions.col(b) - positions.col(a)).norm();
    samples.factors.push_back(lengths[c] / body.connections.rest_length[c] * (before > 0 ? before / now : 1));
  }
  return samples;
}

Rest rest_of(const Body& body, SampledRest samples) {
  std::vector<std::array<Vector3, 2>> ends;
  for (const auto& [a, b] : body.connections.ends) ends.push_back({body.rest.col(a), body.rest.col(b)});
  Rest rest = rest_at(std::move(samples.points), std::move(ends), std::move(samples.factors));
  rest.part = [](double) { return 1; };
  return rest;
}

}  // namespace elastin
