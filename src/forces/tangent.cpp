#include "forces/tangent.h"

#include "forces/graph.h"

namespace elastin {

Tangent::Tangent(Model& model, const Positions& positions) : model_(model), links_(model.body().connections.size()) {
  const VectorX densities = model.force_densities(positions);
  VectorX slopes = VectorX::Zero(densities.size());
  for (const auto& part : model.elasticity()) {
    part->linearise(positions);
    part->add_own_slopes(slopes);
    coupled_ |= part->coupled();
  }
  const auto& ends = model.body().connections.ends;
  parallel_for(static_cast<int>(links_.size()), [&](int c) {
    links_[c] = {positions.col(ends[c][1]) - positions.col(ends[c][0]), densities[c], 2 * slopes[c]};
  });
}

void Tangent::apply(const Positions& motion, Positions& result) const {
  const Connections& connections = model_.body().connections;
  const Rows* incident = model_.graph_ ? &model_.graph_->incident : nullptr;
  result.setZero();
  if (!coupled_) {
    add_flows(connections, incident, result, [&](int c, int a, int b) -> Vector3 {
      const Link& link = links_[c];
      const Vector3 delta = motion.col(a) - motion.col(b);
      return link.density * delta + (link.slope * link.d.dot(delta)) * link.d;
    });
    return;
  }
  VectorX squares(connections.size()), densities(connections.size());
  parallel_for(connections.size(), [&](int c) {
    const auto& [a, b] = connections.ends[c];
    squares[c] = 2 * links_[c].d.dot(motion.col(b) - motion.col(a));
    densities[c] = links_[c].slope / 2 * squares[c];
  });
  for (const auto& part : model_.elasticity()) part->add_change(squares, densities);
  add_flows(connections, incident, result, [&](int c, int a, int b) -> Vector3 {
    const Link& link = links_[c];
    return link.density * (motion.col(a) - motion.col(b)) - densities[c] * link.d;
  });
}

void Tangent::visit_link_and_cell_blocks(const BlockVisitor& visit) const {
  const auto& ends = model_.body().connections.ends;
  const auto visit_pair = [&](int c, int other, const Matrix3& block) {
    for (const int i : {0, 1})
      for (const int j : {0, 1}) visit(ends[c][i], ends[other][j], i == j ? block : Matrix3(-block));
  };
  for (std::size_t c = 0; c < links_.size(); ++c) {
    const auto& [d, density, slope] = links_[c];
    visit_pair(static_cast<int>(c), static_cast<int>(c), density * Matrix3::Identity() + slope * d * d.transpose());
  }
  for (const auto& part : model_.elasticity())
    part->visit_cells([&](std::span<const int> connections, const double* slopes) {
      const std::size_t sides = connections.size();
      for (std::size_t i = 0; i < sides; ++i)
        for (std::size_t j = 0; j < sides; ++j)
          visit_pair(connections[i], connections[j],
                     2 * slopes[i * sides + j] * links_[connections[i]].d * links_[connections[j]].d.transpose());
    });
}

void Tangent::visit_blocks(const BlockVisitor& visit) const {
  visit_link_and_cell_blocks(visit);
  for (const auto& part : model_.elasticity()) part->visit_blocks(visit);
}

std::vector<Matrix3> Tangent::diagonal() const {
  std::vector<Matrix3> blocks(model_.body().size(), Matrix3::Zero());
  visit_link_and_cell_blocks([&](int a, int b, const Matrix3& part) {
    if (a == b) blocks[a] += part;
  });
  for (const auto& part : model_.elasticity()) part->add_diagonal(blocks);
  return blocks;
}

}  // namespace elastin
