#include "core/solve/stable_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "core/base/dense.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

using Operator = std::function<void(const Positions& motion, Positions& result)>;

/// Scaled by √mass, so that M⁻¹ K becomes symmetric.
VectorX inverse_root_mass(const Body& body) { return body.mass.cwiseSqrt().cwiseInverse(); }

/// Of all molecules of the whole.
double dot_of(const Body& body, const Positions& a, const Positions& b) {
  if (!body.share) return ordered_dot(a, b);
  return sum_over(
      body, ordered_sum(owned_molecules(body), [&](int molecule) { return a.col(molecule).dot(b.col(molecule)); }));
}

/// Largest eigenvalue of a symmetric operator: the best combination of a vector, what it misses and the last step;
/// `mode`, of any length, is left at its vector.                                                    [Knyazev 2001]
double largest_eigenvalue(const Body& body, const Operator& apply, Positions& mode) {
  constexpr int most = 200, least = 8;
  constexpr double change = 1e-7, rounding = 1e-8;
  std::array<Positions, 3> basis, images;
  basis[0] = mode;
  for (int k = 0; k < 3; ++k) images[k].setZero(3, mode.cols()), basis[k].resize(3, mode.cols());
  /// Length 1 and at right angles to those before it, or zero where nothing is left.
  const auto orthogonalise = [&](int k) {
    const double before = dot_of(body, basis[k], basis[k]);
    for (int other = 0; other < k; ++other) {
      const double along = dot_of(body, basis[other], basis[k]);
      basis[k] -= along * basis[other], images[k] -= along * images[other];
    }
    const double after = dot_of(body, basis[k], basis[k]);
    const double scale = after > rounding * rounding * before ? 1 / std::sqrt(after) : 0;
    basis[k] *= scale, images[k] *= scale;
  };
  orthogonalise(0);
  apply(basis[0], images[0]);
  double value = dot_of(body, basis[0], images[0]);
  basis[2].setZero();
  for (int iteration = 0; iteration < most; ++iteration) {
    basis[1] = images[0] - value * basis[0];
    images[1].setZero();
    orthogonalise(1);
    apply(basis[1], images[1]);
    orthogonalise(2);
    Matrix3 projected;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column <= row; ++column)
        projected(row, column) = projected(column, row) = dot_of(body, basis[row], images[column]);
    if (!projected.allFinite()) return 0;
    const SymmetricEigen3 eigen = symmetric_eigen3(projected);
    Eigen::Index largest = 0;
    const double last = std::exchange(value, eigen.values.maxCoeff(&largest));
    const Vector3 part = eigen.vectors.col(largest);
    for (auto* vectors : {&basis, &images}) {
      auto& [own, missed, step] = *vectors;
      step = part[1] * missed + part[2] * step;
      own = part[0] * own + step;
    }
    if (iteration > least && std::abs(value - last) <= change * value) break;
  }
  mode = basis[0];
  return std::max(0., value);
}

/// √ of the largest eigenvalue of blockᵀ block, by an angle                                             [Smith 1961]
double spectral_norm(const Matrix3& block) {
  Matrix3 deviator = block.transpose() * block;
  const double mean = deviator.trace() / 3;
  deviator.diagonal().array() -= mean;
  const double size = std::sqrt(deviator.squaredNorm() / 6);
  if (!(size > 0)) return std::sqrt(mean);
  const double angle = std::acos(std::clamp((deviator / size).determinant() / 2, -1., 1.)) / 3;
  return std::sqrt(mean + 2 * size * std::cos(angle));
}

/// Row sums of the norms of the blocks that `visit` hands over, over the molecules' masses. Of a share the largest that
/// a process owns, and its own molecule.
std::pair<double, int> bound_of(const Body& body, const std::function<void(const Load::BlockVisitor&)>& visit) {
  // The parts of one block must be added before its norm is taken, or cells would count many times: blocks by row.
  std::vector<std::vector<std::pair<int, Matrix3>>> rows(body.size());
  visit([&](int a, int b, const Matrix3& block) {
    auto& row = rows[a];
    const auto at = std::find_if(row.begin(), row.end(), [&](const auto& entry) { return entry.first == b; });
    if (at == row.end())
      row.emplace_back(b, block);
    else
      at->second += block;
  });
  std::pair<double, int> most{0, -1};
  for (int a = 0; a < owned_molecules(body); ++a) {
    double sum = 0;
    for (const auto& [b, block] : rows[a]) sum += spectral_norm(block) / std::sqrt(body.mass[a] * body.mass[b]);
    if (sum > most.first) most = {sum, a};
  }
  most.first = largest_over(body, most.first);
  return most;
}

std::pair<double, int> bound_of(const Tangent& tangent) {
  return bound_of(tangent.model().body(), [&](const Load::BlockVisitor& visit) { tangent.visit_blocks(visit); });
}

/// Of the damping alone: of loads by their own blocks, of internal damping as what stiffness w so large leaves that the
/// rest is a millionth of the frequency.
double damping_bound(Model& model, const State& state, double frequency) {
  if (!model.viscosity().empty()) {
    const double w = 1e6 * std::max(frequency, 1.);
    return bound_of(Tangent(model, state, {.velocity = w})).first / w;
  }
  return bound_of(model.body(),
                  [&](const Load::BlockVisitor& visit) {
                    for (const auto& load : model.loads()) {
                      load->visit_blocks(state, 1, visit);
                      load->visit_blocks(state, 0, [&](int a, int b, const Matrix3& block) { visit(a, b, -block); });
                    }
                  })
      .first;
}

/// Which connection or cell stores most of a mode's energy, ½ (2 d·δ)² slope and q |δ|² of springs.
void name_culprit(const Tangent& tangent, const Positions& mode, StableStep& found) {
  const Connections& connections = tangent.model().body().connections;
  VectorX squared_length_changes(connections.size());
  VectorX share(connections.size());
  for (int c = 0; c < connections.size(); ++c) {
    const auto& [a, b] = connections.ends[c];
    const Vector3 delta = mode.col(b) - mode.col(a);
    const Tangent::Link link = tangent.link(c);
    squared_length_changes[c] = 2 * link.d.dot(delta);
    share[c] = std::abs(link.slope / 2 * squared_length_changes[c] * squared_length_changes[c] +
                        link.density * delta.squaredNorm());
  }
  double most = share.size() ? share.maxCoeff(&found.connection) : 0;
  int cell = 0;
  tangent.visit_cells([&](const CellSlopes& cells) {
    for (int own = 0; own < cells.size(); ++own, ++cell) {
      const auto sides = cells.connections_of(own);
      const double* slope = cells.slopes_of(own);
      double energy = 0;
      for (const int i : sides)
        for (const int j : sides) energy += squared_length_changes[i] * *slope++ * squared_length_changes[j];
      energy *= cells.factor;
      if (std::abs(energy) > most) most = std::abs(energy), found.cell = cell, found.connection = -1;
    }
  });
}

/// In bodies of blocks: the cell whose nodes the mode moves most against each other.
void name_block_cell(const Body& body, const Positions& mode, StableStep& found) {
  double most = 0;
  int number = 0;
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell, ++number) {
      double sum = 0;
      for (const auto& [a, b] : block.kind->edges) {
        const auto nodes = block.cell(cell);
        sum += (mode.col(nodes[a]) - mode.col(nodes[b])).squaredNorm();
      }
      if (sum > most) most = sum, found.cell = number, found.connection = -1;
    }
}

bool resists(const Model& model) {
  return !model.viscosity().empty() ||
         std::any_of(model.loads().begin(), model.loads().end(), [](const auto& load) { return load->changes(); });
}

/// Begins the history of the laws at the state: what relaxes then has the stiffness that steps meet, which is larger
/// than that of a body that has had all time.
State begun(Model& model, State state) {
  model.declare_history(state);
  if (!model.history().empty()) model.begin_step(state, state.time);
  return state;
}

/// Damping rate of laws with a history, which a dashpot in them has: the stiffness of a step h so short that all else
/// is a millionth of the frequency, θ K/h, times h.
template <class LargestSquare>
double rate_of_dashpots(Model& model, const State& state, double frequency, LargestSquare largest_square) {
  if (model.history().empty()) return 0;
  const double h = 1e-6 / std::max(frequency, 1.);
  model.begin_step(state, state.time + h);
  const double square = largest_square(Tangent(model, state));
  model.begin_step(state, state.time);
  return std::max(0., h * (square - frequency * frequency));
}

double longest(const StableStep& found) {
  const double w = found.frequency, c = found.damping_rate, sum = std::sqrt(w * w + c * c) + c;
  return sum > 0 ? 2 / sum : std::numeric_limits<double>::infinity();
}

}  // namespace

StableStep bounded_stable_step(Model& model, const State& given) {
  StableStep found;
  const State state = begun(model, given);
  const auto [square, molecule] = bound_of(Tangent(model, state));
  found.frequency = found.bound = std::sqrt(square);
  found.molecule = molecule;
  if (resists(model)) found.damping_rate = damping_bound(model, state, found.frequency);
  found.damping_rate +=
      rate_of_dashpots(model, state, found.frequency, [](const Tangent& tangent) { return bound_of(tangent).first; });
  found.step = longest(found);
  return found;
}

namespace {

StableStep stable_step(Model& model, const State& given, bool explained) {
  StableStep found;
  const State state = begun(model, given);
  const Body& body = model.body();
  const VectorX root = inverse_root_mass(body);
  const Tangent stiffness(model, state);
  const auto scaled = [&](const Tangent& tangent, const Positions& motion, Positions& result) {
    const Positions moved = motion * root.asDiagonal();
    tangent.apply(moved, result);
    result = (result * root.asDiagonal()).eval();
    keep_free(model.supports, result);
    model.spread(result);
  };
  Positions mode(3, body.size());
  for (int molecule = 0; molecule < body.size(); ++molecule)
    mode.col(molecule) = scattered_direction(number_in_whole(body, molecule));
  keep_free(model.supports, mode);
  const Positions start = mode;
  found.frequency = std::sqrt(largest_eigenvalue(
      body, [&](const Positions& motion, Positions& result) { scaled(stiffness, motion, result); }, mode));
  const Positions fastest = mode * root.asDiagonal();
  if (resists(model)) {
    const Tangent damped(model, state, {.velocity = 1});
    mode = start;
    Positions other(3, body.size());
    found.damping_rate = largest_eigenvalue(
        body,
        [&](const Positions& motion, Positions& result) {
          scaled(damped, motion, result);
          scaled(stiffness, motion, other);
          result -= other;
        },
        mode);
  }
  found.damping_rate += rate_of_dashpots(model, state, found.frequency, [&](const Tangent& tangent) {
    mode = fastest * body.mass.cwiseSqrt().asDiagonal();
    return largest_eigenvalue(
        body, [&](const Positions& motion, Positions& result) { scaled(tangent, motion, result); }, mode);
  });
  found.step = longest(found);
  if (!explained) return found;
  const auto [bound, molecule] = bound_of(stiffness);
  found.bound = std::sqrt(bound);
  found.molecule = molecule;
  if (body.share) return found;
  if (!model.nodal_laws().empty())
    name_block_cell(body, fastest, found);
  else
    name_culprit(stiffness, fastest, found);
  return found;
}

}  // namespace

StableStep find_stable_step(Model& model, const State& given) { return stable_step(model, given, false); }

StableStep explained_stable_step(Model& model, const State& given) { return stable_step(model, given, true); }

double frequency_bound(Model& model, const State& state) { return std::sqrt(bound_of(Tangent(model, state)).first); }

}  // namespace elastin
