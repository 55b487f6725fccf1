#include "core/linear/box_assembly.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/parallel/parallel.h"
#include "elastin/core/base/dense.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

constexpr int kCorners = BoxGrid::kCorners, kPairs = kCorners * (kCorners - 1) / 2;
using Corners = BoxGrid::Corners;
using Pairs = Eigen::Array<float, kPairs, 1>;

struct CornerPair {
  int first, second;
  int code;  ///< where the second is around the first; always after it
};
constexpr std::array<CornerPair, kPairs> pairs_of_corners() {
  std::array<CornerPair, kPairs> pairs{};
  std::size_t count = 0;
  for (int i = 0; i < kCorners; ++i)
    for (int j = i + 1; j < kCorners; ++j) {
      const int x = j % 2 - i % 2, y = j / 2 % 2 - i / 2 % 2, z = j / 4 - i / 4;
      pairs[count++] = {i, j, x + 1 + 3 * (y + 1) + 9 * (z + 1)};
    }
  return pairs;
}
constexpr std::array<CornerPair, kPairs> kPair = pairs_of_corners();

/// A box that few connections look into would let motions pass that its molecules feel: those that are no gradient get
/// a stiffness of a part of the box's own, which no even strain feels [Flanagan & Belytschko 1981]; and all motions
/// against each other a trace, which keeps mechanisms from being endlessly soft.
Pairs stabilisation() {
  constexpr float bumps = 0.2F, trace = 1e-6F;
  Pairs table;
  for (int p = 0; p < kPairs; ++p) {
    float sum = 0;
    for (const int bits : {3, 5, 6, 7}) {  // yz, xz, xy, xyz as products of signs
      const auto sign = [bits](int corner) {
        return __builtin_popcount(static_cast<unsigned>(corner & bits)) % 2 ? -1 : 1;
      };
      sum += static_cast<float>(sign(kPair[p].first) * sign(kPair[p].second));
    }
    table[p] = (bumps * sum - trace) / kCorners;
  }
  return table;
}

/// How fast the values change along a vector in units of boxes.
Corners slopes_along(const Eigen::Vector3f& at, const Eigen::Vector3f& d) {
  Corners slopes;
  for (int c = 0; c < kCorners; ++c) {
    const float x = c % 2 ? at.x() : 1 - at.x(), y = c / 2 % 2 ? at.y() : 1 - at.y(), z = c / 4 ? at.z() : 1 - at.z();
    slopes[c] =
        (c % 2 ? d.x() : -d.x()) * y * z + (c / 2 % 2 ? d.y() : -d.y()) * x * z + (c / 4 ? d.z() : -d.z()) * x * y;
  }
  return slopes;
}

/// How far apart neighbours are [m]: the median over the molecules of the mean of each one's three shortest
/// connections. On a cubic lattice that is its constant, up to the corners.
double spacing_of(const Body& body) {
  constexpr float none = std::numeric_limits<float>::infinity();
  std::vector<std::array<float, 3>> shortest(body.size(), {none, none, none});
  const Connections& connections = body.connections;
  for (int c = 0; c < connections.size(); ++c) {
    const auto length = static_cast<float>(connections.rest_length[c]);
    for (const int end : connections.ends[c]) {
      auto& [first, second, third] = shortest[end];
      if (length >= third) continue;
      third = length;
      if (third < second) std::swap(second, third);
      if (second < first) std::swap(first, second);
    }
  }
  std::vector<double> means;
  for (int molecule = 0; molecule < owned_molecules(body); ++molecule) {
    float sum = 0;
    int count = 0;
    for (const float length : shortest[molecule])
      if (length < none) sum += length, ++count;
    if (sum > 0) means.push_back(double{sum / static_cast<float>(count)});
  }
  if (body.share) {
    const double all = sum_over(body, static_cast<double>(means.size()));
    return all > 0 ? nth_over(body, means, static_cast<std::int64_t>(all) / 2) : 1;
  }
  if (means.empty()) return 1;
  const auto middle = means.begin() + static_cast<std::ptrdiff_t>(means.size() / 2);
  std::nth_element(means.begin(), middle, means.end());
  return *middle;
}

/// A length [m] that few connections exceed. The stiffness of one that is longer than a box would stand in the box at
/// its middle alone, and boxes between its ends would be missing: conjugate gradients without boxes are quicker then.
double long_connection(const Body& body) {
  std::vector<double> lengths = body.connections.rest_length;
  if (body.share) {
    lengths.clear();
    for (int c = 0; c < body.connections.size(); ++c)
      if (computes(body, c)) lengths.push_back(body.connections.rest_length[c]);
    const auto all = static_cast<std::int64_t>(sum_over(body, static_cast<double>(lengths.size())));
    return all > 0 ? nth_over(body, lengths, all - 1 - all / 32) : 0;
  }
  if (lengths.empty()) return 0;
  const auto few = static_cast<std::ptrdiff_t>(lengths.size() / 32);
  std::nth_element(lengths.begin(), lengths.end() - 1 - few, lengths.end());
  return *(lengths.end() - 1 - few);
}

/// Items sorted by box, ascending in each.
struct Sorted {
  std::vector<int> start, items;
};
Sorted sorted_by_box(const BoxGrid& grid, const std::vector<int>& outline_boxes) {
  Sorted sorted{std::vector<int>(static_cast<std::size_t>(grid.boxes()) + 1, 0),
                std::vector<int>(outline_boxes.size())};
  for (const int box : outline_boxes) ++sorted.start[grid.number_of(box) + 1];
  for (std::size_t box = 1; box < sorted.start.size(); ++box) sorted.start[box] += sorted.start[box - 1];
  std::vector<int> next(sorted.start.begin(), sorted.start.end() - 1);
  for (std::size_t item = 0; item < outline_boxes.size(); ++item)
    sorted.items[next[grid.number_of(outline_boxes[item])]++] = static_cast<int>(item);
  return sorted;
}

/// Where a cell counts as being: the middle of its sides.
Vector3 middle_of(const Body& body, const CellSlopes& cells, int cell) {
  Vector3 sum = Vector3::Zero();
  for (const int c : cells.connections_of(cell))
    for (const int end : body.connections.ends[c]) sum += body.rest.col(end);
  return sum / (2 * cells.sides);
}

class Assembly {
 public:
  Assembly(const Tangent& tangent, BoxLevel& level)
      : tangent_(tangent),
        body_(tangent.model().body()),
        level_(level),
        grid_(level.grid()),
        stiffness_(VectorX::Zero(grid_.boxes())) {}

  void add_links(const Sorted& links) {
    for_each_box([&](int box) { add_links(links, box); });
  }

  /// The energy Σ slopes δs δs / 4 … of a cell's sides, δs = 2 d·δd, as Tangent has it.
  void add_cells(const CellSlopes& cells, const Sorted& by_box) {
    for_each_box([&](int box) {
      for (int at = by_box.start[box]; at < by_box.start[box + 1]; ++at) add_cell(cells, by_box.items[at], box);
    });
  }

  void add_points(const StiffPoints& points, const Sorted& by_box) {
    for_each_box([&](int box) {
      if (by_box.start[box] == by_box.start[box + 1]) return;
      PointBlocks sum;
      for (auto& of_corner : sum) of_corner.fill(Corners::Zero());
      for (int at = by_box.start[box]; at < by_box.start[box + 1]; ++at) add_point(points, by_box.items[at], sum);
      Eigen::Matrix<float, 3 * kCorners, 3 * kCorners> whole;
      for (int j = 0; j < kCorners; ++j)
        for (int c = 0; c < 3; ++c)
          for (int r = 0; r < 3; ++r)
            for (int i = 0; i < kCorners; ++i) whole(3 * i + r, 3 * j + c) = sum[j][3 * c + r][i];
      add_box(box, whole);
    });
  }

  /// factor · (Σ g·x)² / 2
  void add_gradient(std::span<const std::pair<int, Vector3>> gradient, double factor) {
    Vector3 middle = Vector3::Zero();
    for (const auto& [molecule, g] : gradient)
      middle += body_.rest.col(molecule) / static_cast<double>(gradient.size());
    const BoxGrid::Location location = grid_.locate(middle);
    if (location.box < 0) return;
    Eigen::Matrix<float, 3 * kCorners, 1> change = Eigen::Matrix<float, 3 * kCorners, 1>::Zero();
    for (const auto& [molecule, g] : gradient) {
      const Corners along = slopes_along(location.at, grid_.along(body_.rest.col(molecule) - middle).cast<float>());
      for (int corner = 0; corner < kCorners; ++corner)
        change.segment<3>(3 * corner) += along[corner] * g.cast<float>();
    }
    add_box(location.box, static_cast<float>(factor) * change * change.transpose());
  }

  /// A stiffness of its own at a position.
  void add_at(const Vector3& where, const Matrix3& block) {
    const BoxGrid::Location location = grid_.locate(where);
    const Corners values = BoxGrid::values_at(location.at);
    const auto& corners = grid_.corners(location.box);
    const Eigen::Matrix3f single = block.cast<float>();
    const Eigen::Map<const Eigen::Matrix<float, 1, 9>> numbers(single.data());
    for (const auto& [first, second, code] : kPair)
      level_.block(corners[first], code) += values[first] * values[second] * numbers;
    for (int corner = 0; corner < kCorners; ++corner) level_.sum(corners[corner]) += values[corner] * block;
  }

  const BoxGrid& grid() const { return grid_; }

  void stabilise() {
    const Pairs table = stabilisation();
    for (int box = 0; box < grid_.boxes(); ++box)
      for (int p = 0; p < kPairs; ++p)
        for (const int k : {0, 4, 8})
          level_.block(grid_.corners(box)[kPair[p].first], kPair[p].code)[k] +=
              static_cast<float>(std::max(0., stiffness_[box])) * table[p];
  }

 private:
  static constexpr int kMostSides = 6;
  static constexpr int kFewBoxes = 200;  ///< one thread does them sooner than others wake

  /// Calls work(box) for each box of the grid. Layers touch the points between them: every second at a time.
  template <class Work>
  void for_each_box(Work&& work) {
    const int layers = grid_.layers(), least = grid_.boxes() < kFewBoxes ? layers + 1 : 2;
    for (const int colour : {0, 1})
      parallel_for((layers + 1 - colour) / 2,
                   [&](int half) {
                     const int layer = 2 * half + colour;
                     for (int box = grid_.first_box(layer); box < grid_.first_box(layer + 1); ++box) work(box);
                   },
                   least);
  }

  void add_cell(const CellSlopes& cells, int cell, int box) {
    Eigen::Matrix<float, 3 * kCorners, Eigen::Dynamic, Eigen::ColMajor, 3 * kCorners, kMostSides> change(3 * kCorners,
                                                                                                         cells.sides);
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostSides, kMostSides> slope(cells.sides,
                                                                                                        cells.sides);
    const auto sides = cells.connections_of(cell);
    const double* slopes = cells.slopes_of(cell);
    const BoxGrid::Location location = grid_.locate(middle_of(body_, cells, cell));
    for (int i = 0; i < cells.sides; ++i) {
      const int c = sides[i];
      const Corners along = slopes_along(location.at, grid_.along(rest_vector(c)).cast<float>());
      const Eigen::Vector3f d = tangent_.link(c).d.cast<float>();
      for (int corner = 0; corner < kCorners; ++corner) change.block<3, 1>(3 * corner, i) = along[corner] * d;
      for (int j = 0; j < cells.sides; ++j)
        slope(i, j) = static_cast<float>(2 * cells.factor * slopes[i * cells.sides + j]);
    }
    const decltype(change) resisted = change.lazyProduct(slope);
    add_box(box, resisted.lazyProduct(change.transpose()));
  }

  /// The stiffness of a box in 3 × 3 blocks: of each second corner, of each entry, of all first corners.
  using PointBlocks = std::array<std::array<Corners, 9>, kCorners>;
  /// Σ_pq a_p[i] a_q[j] K_pq, with the slopes a of the corners' values.
  void add_point(const StiffPoints& points, int point, PointBlocks& sum) const {
    const auto [frame, stiffness] = points.stiffness_at(point);
    const BoxGrid::Location location = grid_.locate(points.place_of(point));
    const Eigen::Index axes = frame.cols();
    std::array<Corners, 3> along;
    for (Eigen::Index p = 0; p < axes; ++p)
      along[p] = slopes_along(location.at, grid_.along(frame.col(p)).cast<float>());
    for (Eigen::Index p = 0; p < axes; ++p) {
      std::array<Corners, 9> of_second;  // Σ_q a_q[j] K_pq
      of_second.fill(Corners::Zero());
      for (Eigen::Index q = 0; q < axes; ++q) {
        const Eigen::Matrix3f part = stiffness.block<3, 3>(3 * p, 3 * q).cast<float>();
        for (int e = 0; e < 9; ++e) of_second[e] += part.data()[e] * along[q];
      }
      for (int j = 0; j < kCorners; ++j)
        for (int e = 0; e < 9; ++e) sum[j][e] += of_second[e][j] * along[p];
    }
  }

  Vector3 rest_vector(int c) const {
    const auto& [a, b] = body_.connections.ends[c];
    return body_.rest.col(b) - body_.rest.col(a);
  }

  void add_links(const Sorted& links, int box) {
    // xx, xy, xz, yy, yz, zz of each pair's block
    Pairs blocks[6];
    for (Pairs& block : blocks) block.setZero();
    for (int at = links.start[box]; at < links.start[box + 1]; ++at) {
      const int c = links.items[at];
      const auto& [a, b] = body_.connections.ends[c];
      const BoxGrid::Location location = grid_.locate((body_.rest.col(a) + body_.rest.col(b)) / 2);
      const Corners along = slopes_along(location.at, grid_.along(rest_vector(c)).cast<float>());
      Pairs products;
      for (int i = 0, p = 0; i < kCorners; ++i)
        for (int j = i + 1; j < kCorners; ++j, ++p) products[p] = along[i] * along[j];
      const auto& [d, density, slope] = tangent_.link(c);
      const auto x = static_cast<float>(d.x()), y = static_cast<float>(d.y()), z = static_cast<float>(d.z()),
                 s = static_cast<float>(slope), q = static_cast<float>(density);
      blocks[0] += (s * x * x + q) * products;
      blocks[1] += s * x * y * products;
      blocks[2] += s * x * z * products;
      blocks[3] += (s * y * y + q) * products;
      blocks[4] += s * y * z * products;
      blocks[5] += (s * z * z + q) * products;
    }
    const auto& corners = grid_.corners(box);
    for (int p = 0; p < kPairs; ++p) {
      auto block = level_.block(corners[kPair[p].first], kPair[p].code);
      constexpr int from[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
      for (int k = 0; k < 9; ++k) block[k] += blocks[from[k]][p];
      stiffness_[box] -= (blocks[0][p] + blocks[3][p] + blocks[5][p]) / (1.5F * kCorners);
    }
  }

  void add_box(int box, const Eigen::Matrix<float, 3 * kCorners, 3 * kCorners>& stiffness) {
    const auto& corners = grid_.corners(box);
    for (const auto& [first, second, code] : kPair) {
      const Eigen::Matrix3f block = stiffness.block<3, 3>(3 * first, 3 * second);
      level_.block(corners[first], code) += Eigen::Map<const Eigen::Matrix<float, 1, 9>>(block.data());
    }
    stiffness_[box] += stiffness.trace() / (3 * kCorners);
  }

  const Tangent& tangent_;
  const Body& body_;
  BoxLevel& level_;
  const BoxGrid& grid_;
  VectorX stiffness_;  ///< of each box: mean of its diagonal [N/m]
};

/// The part of a symmetric block that is positive.
Matrix3 positive_part(const Matrix3& block) {
  const SymmetricEigen3 eigen = symmetric_eigen3(Matrix3((block + block.transpose()) / 2));
  return eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
}

/// What stands at molecules themselves: inertia, loads, supports.
void add_at_molecules(const Tangent& tangent, const std::vector<Support>& supports, Assembly& assembly) {
  const Body& body = tangent.model().body();
  std::vector<Matrix3> own;
  tangent.visit_other_diagonal([&](int molecule, const Matrix3& block) {
    if (own.empty()) own.assign(body.size(), Matrix3::Zero());
    own[molecule] += block;
  });
  const double inertia = tangent.weights().acceleration;
  for (int a = 0; a < body.size() && (inertia != 0 || !own.empty()); ++a) {
    Matrix3 block = own.empty() ? Matrix3::Zero() : positive_part(own[a]);
    if (inertia != 0) block.diagonal().array() += inertia * body.mass[a];
    if (!block.isZero(0)) assembly.add_at(body.rest.col(a), block);
  }
  for (const Support& support : supports) {
    const Matrix3 held = Matrix3::Identity() - support.free;
    const Matrix3 block = held * tangent.diagonal(support.molecule) * held;
    assembly.add_at(body.rest.col(support.molecule), positive_part(block));
  }
}

GridLevel assemble(const Tangent& tangent, const std::vector<Support>& supports, const BoxGrid::Frame& frame,
                   bool is_part) {
  const Body& body = tangent.model().body();
  BoxGrid grid(frame);
  std::vector<int> of_molecule(body.size()), of_link(body.connections.size());
  parallel_for(body.size(), [&](int a) { of_molecule[a] = grid.outline_box(body.rest.col(a)); });
  parallel_for(body.connections.size(), [&](int c) {
    const auto& [a, b] = body.connections.ends[c];
    of_link[c] = grid.outline_box((body.rest.col(a) + body.rest.col(b)) / 2);
  });
  for (const int box : of_molecule) grid.use(box);
  for (const int box : of_link) grid.use(box);
  std::vector<std::vector<int>> of_elements;  // cells, then points, of each law and shape
  const auto used_boxes = [&](int count, const auto& place_of) {
    auto& boxes = of_elements.emplace_back(count);
    parallel_for(count, [&](int i) { boxes[i] = grid.outline_box(place_of(i)); });
    for (const int box : boxes) grid.use(box);
  };
  tangent.visit_cells([&](const CellSlopes& cells) {
    used_boxes(cells.size(), [&](int cell) { return middle_of(body, cells, cell); });
  });
  tangent.visit_points([&](const StiffPoints& points) {
    used_boxes(points.stiff_points(), [&](int point) { return points.place_of(point); });
  });
  grid.number();

  GridLevel grid_level;
  Sorted molecules = sorted_by_box(grid, of_molecule);
  grid_level.members.start = std::move(molecules.start);
  grid_level.members.members.resize(molecules.items.size());
  parallel_for(body.size(), [&](int i) {
    const int molecule = molecules.items[i];
    grid_level.members.members[i] = {molecule, grid.locate(body.rest.col(molecule)).at};
  });

  const Sorted links = sorted_by_box(grid, of_link);
  of_link = {};
  grid_level.level = std::make_unique<BoxLevel>(std::move(grid));
  Assembly assembly(tangent, *grid_level.level);
  if (tangent.linked()) assembly.add_links(links);
  auto next = of_elements.begin();
  const auto next_sorted = [&] { return sorted_by_box(assembly.grid(), std::exchange(*next++, {})); };
  tangent.visit_cells([&](const CellSlopes& cells) { assembly.add_cells(cells, next_sorted()); });
  tangent.visit_points([&](const StiffPoints& points) { assembly.add_points(points, next_sorted()); });
  tangent.visit_gradients([&](std::span<const std::pair<int, Vector3>> gradient, double factor) {
    assembly.add_gradient(gradient, factor);
  });
  assembly.stabilise();
  add_at_molecules(tangent, supports, assembly);
  grid_level.level->finish(is_part);
  return grid_level;
}

}  // namespace

BoxGrid::Frame frame_of(const Body& body) {
  const double size = std::max(2 * spacing_of(body), long_connection(body));
  const auto [low, high] = outline_of_whole(body);
  return {low, high, static_cast<int>(molecules_of_whole(body)), size};
}

GridLevel assemble_level(const Tangent& tangent, const std::vector<Support>& supports) {
  return assemble(tangent, supports, frame_of(tangent.model().body()), false);
}

GridLevel assemble_part(const Tangent& tangent, const std::vector<Support>& supports, const BoxGrid::Frame& frame) {
  return assemble(tangent, supports, frame, true);
}

}  // namespace elastin
