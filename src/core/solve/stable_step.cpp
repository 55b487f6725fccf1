#include "elastin/core/solve/stable_step.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/parallel/parallel.h"
#include "elastin/core/base/dense.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

using Operator = std::function<void(const Positions& motion, Positions& result)>;

/// Scaled by √mass, so that M⁻¹ K becomes symmetric.
VectorX inverse_root_mass(const Body& body) { return body.mass.cwiseSqrt().cwiseInverse(); }

/// Of all molecules of the whole.
double norm_of(const Body& body, const Positions& vectors) {
  if (!body.share) return ordered_norm(vectors);
  return std::sqrt(sum_over(
      body, ordered_sum(owned_molecules(body), [&](int molecule) { return vectors.col(molecule).squaredNorm(); })));
}

/// Largest eigenvalue by size of a symmetric operator by Lanczos-free power iteration; `mode` is left at its vector.
double largest_eigenvalue(const Body& body, const Operator& apply, Positions& mode) {
  Positions image(3, mode.cols());
  double value = 0;
  mode /= std::max(norm_of(body, mode), std::numeric_limits<double>::min());
  for (int iteration = 0; iteration < 500; ++iteration) {
    apply(mode, image);
    const double norm = norm_of(body, image), last = value;
    value = norm;
    if (!(norm > 0) || !std::isfinite(norm)) return 0;
    mode = image / norm;
    if (iteration > 20 && std::abs(value - last) <= 1e-6 * value) break;
  }
  return value;
}

double spectral_norm(const Matrix3& block) {
  return std::sqrt(symmetric_eigenvalues3(Matrix3(block.transpose() * block)).maxCoeff());
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

double longest(const StableStep& found) {
  const double w = found.frequency, c = found.damping_rate, sum = std::sqrt(w * w + c * c) + c;
  return sum > 0 ? 2 / sum : std::numeric_limits<double>::infinity();
}

}  // namespace

StableStep bounded_stable_step(Model& model, const State& state) {
  StableStep found;
  const auto [square, molecule] = bound_of(Tangent(model, state));
  found.frequency = found.bound = std::sqrt(square);
  found.molecule = molecule;
  if (resists(model)) found.damping_rate = damping_bound(model, state, found.frequency);
  found.step = longest(found);
  return found;
}

StableStep find_stable_step(Model& model, const State& state) {
  StableStep found;
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
  found.step = longest(found);
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

double frequency_bound(Model& model, const State& state) { return std::sqrt(bound_of(Tangent(model, state)).first); }

}  // namespace elastin
