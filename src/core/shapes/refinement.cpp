#include "core/shapes/refinement.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/shapes/block_orders.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

using MatrixXd = Eigen::MatrixXd;

void check_refinable(const Body& body) {
  if (!body.parts.empty() || !body.ties.empty()) throw InputError("a body of several parts cannot be refined");
  if (!body.cables.empty()) throw InputError("a body with cables cannot be refined");
  if (body.blocks.empty() && body.tetrahedra.empty() && body.triangles.empty())
    throw InputError("a body without cells cannot be refined");
}

/// The parts of a reference cell, each by its own corners, a column each.
using Parts = std::vector<MatrixXd>;

MatrixXd columns(const std::vector<VectorX>& corners) {
  MatrixXd all(corners.front().size(), static_cast<Eigen::Index>(corners.size()));
  for (std::size_t c = 0; c < corners.size(); ++c) all.col(static_cast<Eigen::Index>(c)) = corners[c];
  return all;
}

/// Of boxes, prisms and triangles: what is left when all shrinks towards each corner by half; and the middle triangle.
Parts halves(const CellKind& kind) {
  Parts parts;
  const MatrixXd corners = kind.reference.leftCols(kind.corners);
  for (int c = 0; c < kind.corners; ++c) parts.push_back((corners.colwise() + VectorX(corners.col(c))) / 2);
  const auto middle = [&](int a, int b) { return VectorX((corners.col(a) + corners.col(b)) / 2); };
  if (kind.corners == 3) parts.push_back(columns({middle(0, 1), middle(1, 2), middle(2, 0)}));
  if (kind.corners == 6) {
    const MatrixXd low = columns({middle(0, 1), middle(1, 2), middle(2, 0)}),
                   high = columns({middle(3, 4), middle(4, 5), middle(5, 3)});
    MatrixXd lower(3, 6), upper(3, 6);
    lower << low, (low + high) / 2;
    upper << (low + high) / 2, high;
    parts.push_back(lower), parts.push_back(upper);
  }
  return parts;
}

/// Of tetrahedra: one at each corner, and the octahedron between them, cut along one of its diagonals.
Parts halved_tetrahedron(const CellKind& kind, int diagonal) {
  Parts parts = halves(kind);
  const auto middle = [&](int a, int b) { return VectorX((kind.reference.col(a) + kind.reference.col(b)) / 2); };
  // The middles of two edges that do not meet, and the ring of the other four.
  static constexpr int ends[3][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}};
  const auto& [a, b, c, d] = ends[diagonal];
  const VectorX low = middle(a, b), high = middle(c, d);
  const std::vector<VectorX> ring{middle(a, c), middle(c, b), middle(b, d), middle(d, a)};
  for (std::size_t i = 0; i < 4; ++i) {
    MatrixXd own = columns({low, high, ring[i], ring[(i + 1) % 4]});
    const Vector3 origin = own.col(0);
    if (Vector3(own.col(1) - origin).cross(Vector3(own.col(2) - origin)).dot(Vector3(own.col(3) - origin)) < 0)
      own.col(2).swap(own.col(3));
    parts.push_back(own);
  }
  return parts;
}

int shortest_diagonal(const MatrixXd& x) {
  const auto middle = [&](int a, int b) { return Vector3((x.col(a) + x.col(b)) / 2); };
  const std::array<double, 3> lengths{(middle(0, 1) - middle(2, 3)).norm(), (middle(0, 2) - middle(1, 3)).norm(),
                                      (middle(0, 3) - middle(1, 2)).norm()};
  int shortest = 0;
  for (int i = 1; i < 3; ++i)
    if (lengths[i] < lengths[shortest] * (1 - 1e-9)) shortest = i;
  return shortest;
}

/// N_a of the coarse cell at every node of each of its parts.
using PartWeights = std::vector<std::vector<VectorX>>;
PartWeights weights_of(const CellKind& kind, const Parts& parts) {
  const CellKind& linear = first_order_of(kind);
  PartWeights weights;
  for (const MatrixXd& corners : parts) {
    auto& own = weights.emplace_back();
    for (int a = 0; a < kind.nodes; ++a)
      own.push_back(kind.functions(corners * linear.functions(kind.reference.col(a))));
  }
  return weights;
}

/// Numbers new molecules by what they lie between.
class Molecules {
 public:
  explicit Molecules(int old) : old_(old) {}
  int at(std::span<const int> nodes, const VectorX& weights) {
    MoleculeBetween between;
    for (Eigen::Index a = 0; a < weights.size(); ++a)
      if (std::abs(weights[a]) > 1e-9) between.emplace_back(nodes[a], weights[a]);
    if (between.size() == 1) return between.front().first;
    std::sort(between.begin(), between.end());
    std::vector<std::pair<int, long>> key;
    for (const auto& [node, weight] : between) key.emplace_back(node, std::lround(1e6 * weight));
    const auto [found, is_new] = numbers_.emplace(std::move(key), old_ + static_cast<int>(between_.size()));
    if (is_new) between_.push_back(std::move(between));
    return found->second;
  }
  std::vector<MoleculeBetween>& between() { return between_; }

 private:
  int old_;
  std::map<std::vector<std::pair<int, long>>, int> numbers_;
  std::vector<MoleculeBetween> between_;
};

CellBlock cut(const CellBlock& block, const Positions& rest, Molecules& molecules) {
  const CellKind& kind = *block.kind;
  std::vector<PartWeights> ways;
  if (kind.corners == 4 && kind.dimensions == 3)
    for (const int diagonal : {0, 1, 2}) ways.push_back(weights_of(kind, halved_tetrahedron(kind, diagonal)));
  else
    ways.push_back(weights_of(kind, halves(kind)));
  CellBlock result{&kind, {}, {}};
  for (int cell = 0; cell < block.size(); ++cell) {
    const auto nodes = block.cell(cell);
    const std::size_t way =
        ways.size() == 1 ? 0 : static_cast<std::size_t>(shortest_diagonal(positions_of(rest, nodes)));
    for (const auto& part : ways[way])
      for (const VectorX& weights : part) result.nodes.push_back(molecules.at(nodes, weights));
  }
  if (block.stiffness.size()) {
    const Eigen::Index parts = result.size() / block.size();
    result.stiffness.resize(result.size());
    for (Eigen::Index i = 0; i < result.stiffness.size(); ++i) result.stiffness[i] = block.stiffness[i / parts];
  }
  return result;
}

template <std::size_t corners>
void take_back(const CellBlock& block, std::vector<std::array<int, corners>>& cells, VectorX& stiffness) {
  cells.clear();
  for (int cell = 0; cell < block.size(); ++cell) {
    auto& own = cells.emplace_back();
    std::copy_n(block.cell(cell).begin(), corners, own.begin());
  }
  stiffness = block.stiffness;
}

double size_of(const Positions& rest, const std::array<int, 4>& cell) { return signed_volume(rest, cell); }
double size_of(const Positions& rest, const std::array<int, 3>& cell) { return area_vector(rest, cell).norm(); }

}  // namespace

VectorX volumes_of_molecules(const Body& body) {
  if (!body.blocks.empty()) return lumped_volumes(body, 1);
  if (body.tetrahedra.empty() && !body.cubes.empty()) {
    Body hexahedra;
    hexahedra.rest = body.rest, hexahedra.blocks = blocks_of(body);
    return lumped_volumes(hexahedra, 1);
  }
  return lumped_mass(body.rest, body.tetrahedra.empty() ? body.triangles : Cells<3>{}, body.tetrahedra, 1, 1);
}

void carry_matter(const Body& from, const std::vector<MoleculeBetween>& between, Body& to) {
  const auto carry = [&](const VectorX& values) {
    VectorX all(to.size());
    all.head(from.size()) = values;
    for (std::size_t i = 0; i < between.size(); ++i) {
      double sum = 0, parts = 0;  // by size: shape functions may be negative, a mass may not
      for (const auto& [molecule, weight] : between[i])
        sum += std::abs(weight) * values[molecule], parts += std::abs(weight);
      all[from.size() + static_cast<Eigen::Index>(i)] = sum / parts;
    }
    return all;
  };
  if (from.radius.size()) to.radius = carry(from.radius);
  if (!from.mass.size()) return;
  // Molecules without cells are of one mass where the density is one, however much of a lattice's boxes is theirs.
  const bool shared = from.blocks.empty() && from.tetrahedra.empty() && from.triangles.empty();
  const VectorX before = volumes_of_molecules(from), after = volumes_of_molecules(to);
  VectorX densities(from.size());
  for (int a = 0; a < from.size(); ++a) densities[a] = before[a] > 0 ? from.mass[a] / (shared ? 1 : before[a]) : 0;
  to.mass = after.cwiseProduct(carry(densities));
  for (int a = 0; a < from.size(); ++a)  // one that belongs to no cell
    if (!(before[a] > 0)) to.mass[a] = from.mass[a];
  to.mass *= from.mass.sum() / to.mass.sum();
}

Body refined(const Body& coarse) {
  check_refinable(coarse);
  Molecules molecules(coarse.size());
  Body fine;
  std::vector<CellBlock> blocks;
  for (const CellBlock& block : blocks_of(coarse)) blocks.push_back(cut(block, coarse.rest, molecules));
  const std::vector<MoleculeBetween> between = std::move(molecules.between());
  const int old = coarse.size(), added = static_cast<int>(between.size());
  fine.rest.resize(3, old + added);
  fine.rest.leftCols(old) = coarse.rest;
  for (int i = 0; i < added; ++i) {
    Vector3 place = Vector3::Zero();
    for (const auto& [molecule, weight] : between[i]) place += weight * coarse.rest.col(molecule);
    fine.rest.col(old + i) = place;
  }
  if (coarse.blocks.empty()) {
    if (blocks.front().kind->dimensions == 3)
      take_back(blocks.front(), fine.tetrahedra, fine.cell_stiffness);
    else
      take_back(blocks.front(), fine.triangles, fine.cell_stiffness);
    fine.connections = connections_of_cells(fine.rest, fine.triangles, fine.tetrahedra);
  } else {
    fine.blocks = std::move(blocks);
    set_simplices(fine);
  }
  carry_matter(coarse, between, fine);
  if (fine.radius.size()) fine.radius /= 2;
  fine.between = coarse.between;
  fine.between.insert(fine.between.end(), between.begin(), between.end());
  return fine;
}

std::array<double, 10> moments_of_cells(const Body& body) {
  std::array<double, 10> sum{};
  const auto add = [&](double size, const auto& cell) {
    Vector3 middle = Vector3::Zero();
    Matrix3 spread = Matrix3::Zero();
    const double n = static_cast<double>(cell.size());
    for (const int corner : cell) middle += body.rest.col(corner) / n;
    for (const int corner : cell) spread += body.rest.col(corner) * body.rest.col(corner).transpose();
    // ∫ x xᵀ of a simplex with n corners is (Σ x_a x_aᵀ + n² m mᵀ) / (n (n + 1)) of its size.
    const Matrix3 second = (spread + n * n * middle * middle.transpose()) / (n * (n + 1));
    sum[0] += size;
    for (int i = 0; i < 3; ++i) sum[1 + i] += size * middle[i];
    for (int i = 0, at = 4; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++at) sum[at] += size * second(i, j);
  };
  for (const auto& cell : body.tetrahedra) add(size_of(body.rest, cell), cell);
  if (body.tetrahedra.empty())
    for (const auto& cell : body.triangles) add(size_of(body.rest, cell), cell);
  return sum;
}

}  // namespace elastin
