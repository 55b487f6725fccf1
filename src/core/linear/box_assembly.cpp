#include "core/linear/box_assembly.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "core/base/dense.h"
#include "core/parallel/large_memory.h"
#include "core/parallel/parallel.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

constexpr int kCorners = BoxGrid::kCorners, kPairs = BoxElements::kPairs;
using Corners = BoxGrid::Corners;
using Pairs = BoxElements::Pairs;

struct CornerPair {
  int first, second;
};
constexpr auto kPair = [] {
  std::array<CornerPair, kPairs> pairs{};
  std::size_t count = 0;
  for (int i = 0; i < kCorners; ++i)
    for (int j = i + 1; j < kCorners; ++j) pairs[count++] = {i, j};
  return pairs;
}();

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
  const Corners x = BoxGrid::values_along(0, at), y = BoxGrid::values_along(1, at), z = BoxGrid::values_along(2, at);
  const auto slope = [&](int axis) { return BoxGrid::signs(axis) * d[axis]; };
  return slope(0) * y * z + slope(1) * x * z + slope(2) * x * y;
}

/// How far apart neighbours are [m]: the median over the molecules of the mean of each one's three shortest
/// connections. On a cubic lattice that is its constant, up to the corners.
double spacing_of(const Body& body) {
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<std::array<double, 3>> shortest(body.size(), {none, none, none});
  const Connections& connections = body.connections;
  for (int c = 0; c < connections.size(); ++c) {
    const double length = connections.rest_length[c];
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
    double sum = 0;
    int count = 0;
    for (const double length : shortest[molecule])
      if (length < none) sum += length, ++count;
    if (sum > 0) means.push_back(sum / count);
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

/// A length [m] that few connections exceed, or `least` where that is more. The stiffness of one that is longer than a
/// box would stand in the box at its middle alone, and boxes between its ends would be missing: conjugate gradients
/// without boxes are quicker then.
double long_connection(const Body& body, double least) {
  std::vector<double> longer;
  int count = 0;
  for (int c = 0; c < body.connections.size(); ++c) {
    if (!computes(body, c)) continue;
    ++count;
    if (body.connections.rest_length[c] > least) longer.push_back(body.connections.rest_length[c]);
  }
  const auto all = static_cast<std::int64_t>(sum_over(body, count)),
             above = static_cast<std::int64_t>(sum_over(body, static_cast<double>(longer.size())));
  const std::int64_t few = all / 32;
  if (above <= few) return least;
  return nth_over(body, longer, above - 1 - few);
}

/// Where a cell counts as being: the middle of its sides.
Vector3 middle_of(const Body& body, const CellSlopes& cells, int cell) {
  Vector3 sum = Vector3::Zero();
  for (const int c : cells.connections_of(cell))
    for (const int end : body.connections.ends[c]) sum += body.rest.col(end);
  return sum / (2 * cells.sides);
}

/// Items sorted by a number of each, ascending in each.
struct Sorted {
  std::vector<int> start;
  std::unique_ptr<int[]> items;
  Sorted(const std::vector<int>& numbers, int count)
      : start(static_cast<std::size_t>(count) + 1, 0), items(new int[numbers.size()]) {
    prefer_large_pages(items.get(), sizeof(int) * numbers.size());
    for (const int number : numbers) ++start[number + 1];
    for (int number = 0; number < count; ++number) start[number + 1] += start[number];
    std::vector<int> next(start.begin(), start.end() - 1);
    for (std::size_t item = 0; item < numbers.size(); ++item) items[next[numbers[item]]++] = static_cast<int>(item);
  }
  std::span<const int> of(int number) const {
    return {items.get() + start[number], static_cast<std::size_t>(start[number + 1] - start[number])};
  }
};

/// What list(i, all) appends to all for i = 0 … count − 1, in that order.
template <class Item, class List>
std::vector<Item> listed(int count, List&& list) {
  constexpr int block = 512;
  std::vector<std::vector<Item>> blocks((count + block - 1) / block);
  parallel_for(
      static_cast<int>(blocks.size()),
      [&](int b) {
        for (int i = block * b; i < std::min(count, block * (b + 1)); ++i) list(i, blocks[b]);
      },
      8);
  std::vector<Item> all;
  for (const auto& own : blocks) all.insert(all.end(), own.begin(), own.end());
  return all;
}

/// The box that each molecule, connection and other element of a body belongs to: first of the outline.
struct Homes {
  std::vector<int> outline;  ///< of the molecules, too
  std::vector<int> molecules, links;
  std::vector<std::vector<int>> elements;  ///< of each law and shape, as visit_elements visits them
};

/// A molecule of a cell, and which of the cell's points is nearest to it.
struct Reached {
  int molecule, point;
};

/// Of the cells that reach further along an axis than half a box of this size [m]: of smaller ones, and of cubes of
/// first order that lie along the axes, each box has points enough.
std::vector<Reached> reached_by(const StiffPoints& points, const Positions& rest, double size) {
  constexpr double half = 0.55;
  std::vector<Reached> result;
  for (int first = 0, end = 0; first < points.stiff_points(); first = end) {
    const auto nodes = points.nodes_of(first);
    while (end < points.stiff_points() && points.nodes_of(end).data() == nodes.data()) ++end;
    double length = 0;
    for (const int node : nodes)
      length = std::max(length, (rest.col(node) - rest.col(nodes.front())).cwiseAbs().maxCoeff());
    if (length <= half * size) continue;
    std::vector<Vector3> places;
    for (int point = first; point < end; ++point) places.push_back(points.place_of(point));
    for (const int node : nodes) {
      const auto nearest = std::min_element(places.begin(), places.end(), [&](const Vector3& a, const Vector3& b) {
        return (rest.col(node) - a).squaredNorm() < (rest.col(node) - b).squaredNorm();
      });
      result.push_back({node, first + static_cast<int>(nearest - places.begin())});
    }
  }
  return result;
}

/// Of each law and shape that has points.
using ReachedByLaw = std::vector<std::vector<Reached>>;

/// Calls visit(count, place_of, nodes_of) for each group of elements: cells, then points and molecules by their points.
template <class Visit>
void visit_elements(const Tangent& tangent, const ReachedByLaw& reached, Visit&& visit) {
  const Body& body = tangent.model().body();
  tangent.visit_cells([&](const CellSlopes& cells) {
    const std::size_t nodes = cells.nodes.size() / static_cast<std::size_t>(std::max(1, cells.size()));
    visit(
        cells.size(), [&](int cell) { return middle_of(body, cells, cell); },
        [&](int cell) { return cells.nodes.subspan(static_cast<std::size_t>(cell) * nodes, nodes); });
  });
  auto next = reached.begin();
  tangent.visit_points([&](const StiffPoints& points) {
    const std::vector<Reached>& molecules = *next++;
    visit(
        points.stiff_points(), [&](int point) { return points.place_of(point); },
        [&](int point) { return points.nodes_of(point); });
    visit(
        static_cast<int>(molecules.size()), [&](int i) -> Vector3 { return body.rest.col(molecules[i].molecule); },
        [&](int i) { return points.nodes_of(molecules[i].point); });
  });
}

/// Of some molecules the first one that lies in a box of the outline; the first where none does.
int node_in(std::span<const int> nodes, const std::vector<int>& outline, int box) {
  const auto found = std::find_if(nodes.begin(), nodes.end(), [&](int node) { return outline[node] == box; });
  return found == nodes.end() ? nodes.front() : *found;
}

/// The pieces of each box of the outline: what its molecules and connections join, with the ends of these elsewhere. A
/// connection of a piece that has no molecule in the box belongs to the box of its first end.
void split_boxes(const Body& body, BoxGrid& grid, Homes& homes) {
  const auto& ends = body.connections.ends;
  const Sorted molecules(homes.molecules, grid.outline_boxes()), links(homes.links, grid.outline_boxes());
  std::vector<int> pieces(grid.outline_boxes(), 0), piece_of(ends.size(), -1), piece_of_molecule(body.size());
  parallel_ranges(
      grid.outline_boxes(),
      [&](int begin, int end) {
        std::vector<int> number(body.size(), -1), nodes;
        for (int box = begin; box < end; ++box) {
          nodes.assign(molecules.of(box).begin(), molecules.of(box).end());
          const std::size_t inside = nodes.size();
          if (inside == 0) continue;
          for (std::size_t i = 0; i < inside; ++i) number[nodes[i]] = static_cast<int>(i);
          DisjointSets sets(inside + 2 * links.of(box).size());
          for (const int c : links.of(box)) {
            for (const int molecule : ends[c])
              if (number[molecule] < 0) number[molecule] = static_cast<int>(nodes.size()), nodes.push_back(molecule);
            sets.join(number[ends[c][0]], number[ends[c][1]]);
          }
          for (std::size_t i = 0; i < inside; ++i) {
            const int set = sets.set_of(static_cast<int>(i));
            piece_of_molecule[nodes[i]] = set == static_cast<int>(i) ? pieces[box]++ : piece_of_molecule[nodes[set]];
          }
          for (const int c : links.of(box))
            if (const int set = sets.set_of(number[ends[c][0]]); set < static_cast<int>(inside))
              piece_of[c] = piece_of_molecule[nodes[set]];
          for (const int molecule : nodes) number[molecule] = -1;
        }
      },
      kParallelThreshold / 50);
  grid.number_boxes(pieces);
  parallel_for(body.size(),
               [&](int a) { homes.molecules[a] = grid.number_of(homes.molecules[a]) + piece_of_molecule[a]; });
  parallel_for(static_cast<int>(ends.size()), [&](int c) {
    homes.links[c] = piece_of[c] < 0 ? homes.molecules[ends[c][0]] : grid.number_of(homes.links[c]) + piece_of[c];
  });
  using Joined = std::vector<std::array<int, 2>>;
  grid.number_points(listed<Joined::value_type>(grid.outline_boxes(), [&](int box, Joined& joined) {
    const auto first = static_cast<std::ptrdiff_t>(joined.size());
    for (const int c : links.of(box))
      for (const int molecule : ends[c]) {
        const std::array<int, 2> pair{homes.links[c], homes.molecules[molecule]};
        if (pair[0] != pair[1] && std::find(joined.begin() + first, joined.end(), pair) == joined.end())
          joined.push_back(pair);
      }
  }));
}

/// A molecule without an element in its box, whose connections resist nothing by themselves, belongs to one of its
/// elements' boxes. The box would have no stiffness, and the grid no positive one.
void move_to_elements(const Tangent& tangent, const ReachedByLaw& reached, Homes& homes) {
  constexpr int linked = -2;
  std::vector<int> found(homes.molecules.size(), -1);
  const auto& ends = tangent.model().body().connections.ends;
  const auto resists = [&](std::size_t c) { return tangent.linked() && tangent.link(static_cast<int>(c)).slope != 0; };
  for (std::size_t c = 0; c < ends.size(); ++c)
    if (resists(c)) found[ends[c][0]] = found[ends[c][1]] = linked;
  auto boxes = homes.elements.begin();
  visit_elements(tangent, reached, [&](int count, const auto&, const auto& nodes_of) {
    for (int i = 0; i < count; ++i)
      for (const int node : nodes_of(i))
        if (found[node] != linked && (found[node] < 0 || (*boxes)[i] == homes.molecules[node]))
          found[node] = (*boxes)[i];
    ++boxes;
  });
  for (std::size_t a = 0; a < found.size(); ++a)
    if (found[a] >= 0) homes.molecules[a] = found[a];
  for (std::size_t c = 0; c < homes.links.size(); ++c)
    if (!resists(c) && homes.links[c] != homes.molecules[ends[c][1]]) homes.links[c] = homes.molecules[ends[c][0]];
}

Homes find_homes(const Tangent& tangent, const ReachedByLaw& reached, BoxGrid& grid, bool whole_boxes) {
  const Body& body = tangent.model().body();
  Homes homes;
  homes.molecules.resize(body.size()), homes.links.resize(body.connections.size());
  parallel_for(
      body.size(), [&](int a) { homes.molecules[a] = grid.outline_box(body.rest.col(a)); }, kMoleculeThreshold);
  parallel_for(body.connections.size(), [&](int c) {
    const auto& [a, b] = body.connections.ends[c];
    homes.links[c] = grid.outline_box((body.rest.col(a) + body.rest.col(b)) / 2);
  });
  visit_elements(tangent, reached, [&](int count, const auto& place_of, const auto&) {
    auto& boxes = homes.elements.emplace_back(count);
    parallel_for(count, [&](int i) { boxes[i] = grid.outline_box(place_of(i)); });
  });
  if (!whole_boxes) move_to_elements(tangent, reached, homes);
  homes.outline = homes.molecules;
  if (whole_boxes) {
    const auto for_all = [&](const auto& change) {
      for (int& box : homes.molecules) change(box);
      for (int& box : homes.links) change(box);
      for (auto& of_group : homes.elements)
        for (int& box : of_group) change(box);
    };
    for_all([&](int& box) { grid.used()[box] = 1; });
    grid.number();
    for_all([&](int& box) { box = grid.number_of(box); });
    return homes;
  }
  split_boxes(body, grid, homes);
  std::size_t group = 0;
  visit_elements(tangent, reached, [&](int count, const auto&, const auto& nodes_of) {
    auto& boxes = homes.elements[group++];
    parallel_for(count, [&](int i) { boxes[i] = homes.molecules[node_in(nodes_of(i), homes.outline, boxes[i])]; });
  });
  return homes;
}

/// What stands at a molecule itself, and nowhere else.
struct BlockAt {
  int molecule;
  Matrix3 block;
};

/// factor · (Σ g·x)² / 2 of some molecules, and the box that it belongs to.
struct GradientIn {
  std::vector<std::pair<int, Vector3>> gradient;
  double factor;
  Vector3 middle;
  int box;
};

/// The stiffness of all boxes, each of which is added up at once. What a law or others add is given before: what it
/// refers to has to stay until result().
class Assembly {
 public:
  Assembly(const Tangent& tangent, const BoxGrid& grid)
      : tangent_(tangent), body_(tangent.model().body()), grid_(grid), result_(grid.boxes()) {}

  BoxElements result() {
    constexpr int block = 128;  // fixed, so that what is shared does not hang on the number of threads
    const int boxes = grid_.boxes();
    parallel_for((boxes + block - 1) / block,
                 [&](int b) {
                   std::vector<int> kinds;
                   BoxSum sum;
                   for (int box = block * b; box < std::min(boxes, block * (b + 1)); ++box) {
                     for (auto& entry : sum.element) entry.setZero();
                     sum.stiffness = 0;
                     for (const auto& add : added_) add(box, sum);
                     stabilise(sum);
                     result_.set(box, sum.element, kinds);
                   }
                 },
                 kFewBlocks);
    result_.share();
    return std::move(result_);
  }

  void add_links(const std::vector<int>& homes) {
    added_.emplace_back([this, links = by_box(homes)](int box, BoxSum& sum) { add_links(*links, box, sum); });
  }

  /// The energy Σ slopes δs δs / 4 … of a cell's sides, δs = 2 d·δd, as Tangent has it.
  void add_cells(const CellSlopes& cells, const std::vector<int>& homes) {
    added_.emplace_back([this, cells, by_home = by_box(homes)](int box, BoxSum& sum) {
      for (const int cell : by_home->of(box)) add_cell(cells, cell, box, sum);
    });
  }

  /// A point's stiffness stands in the box where it lies and, a part, in those of the molecules that it is nearest to.
  /// Without that part a box with molecules and hardly a point would be much softer than they are: as where cells are
  /// turned against the grid, those of second order, as large as a box, above all.
  void add_points(const StiffPoints& points, const std::vector<int>& homes, const std::vector<Reached>& reached,
                  const std::vector<int>& homes_of_reached) {
    constexpr float part = 0.25F;
    std::vector<float> share(homes.size(), 0), stays(homes.size(), 1);
    for (const auto& [molecule, point] : reached) ++share[point];
    for (float& of_one : share) of_one = part / std::max(1.F, of_one);
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (const int point = reached[i].point; homes_of_reached[i] != homes[point]) stays[point] -= share[point];
    added_.emplace_back([this, &points, &homes, &reached, share = std::move(share), stays = std::move(stays),
                         by_place = by_box(homes), by_molecule = by_box(homes_of_reached)](int box, BoxSum& of_box) {
      if (by_place->of(box).empty() && by_molecule->of(box).empty()) return;
      PointBlocks sum;
      for (auto& of_corner : sum) of_corner.fill(Corners::Zero());
      for (const int point : by_place->of(box)) add_point(points, point, box, stays[point], sum);
      for (const int i : by_molecule->of(box))
        if (const int point = reached[i].point; homes[point] != box) add_point(points, point, box, share[point], sum);
      Eigen::Matrix<float, 3 * kCorners, 3 * kCorners> whole;
      for (int j = 0; j < kCorners; ++j)
        for (int c = 0; c < 3; ++c)
          for (int r = 0; r < 3; ++r)
            for (int i = 0; i < kCorners; ++i) whole(3 * i + r, 3 * j + c) = sum[j][3 * c + r][i];
      add_box(whole, of_box);
    });
  }

  void add_gradients(const std::vector<GradientIn>& gradients) {
    std::vector<int> homes;
    for (const GradientIn& one : gradients) homes.push_back(one.box);
    if (homes.empty()) return;
    added_.emplace_back([this, &gradients, by_home = by_box(homes)](int box, BoxSum& sum) {
      for (const int i : by_home->of(box)) add_gradient(gradients[i], sum);
    });
  }

  void add_at(const std::vector<BlockAt>& blocks, const std::vector<int>& home_of_molecule) {
    std::vector<int> homes;
    std::vector<char> resisted(grid_.boxes(), 0);
    for (const BlockAt& one : blocks) homes.push_back(home_of_molecule[one.molecule]), resisted[homes.back()] = 1;
    if (homes.empty()) return;
    result_.set_sums_in(resisted);
    added_.emplace_back([this, &blocks, by_home = by_box(homes)](int box, BoxSum& sum) {
      for (const int i : by_home->of(box)) add_at(blocks[i], box, sum);
    });
  }

 private:
  static constexpr int kMostSides = 6;
  static constexpr int kFewBlocks = 2;  ///< one thread does them sooner than others wake

  /// A connection as a box sees it.
  struct LinkIn {
    std::array<float, 3> at, extent;  ///< its middle and its extent, in units of boxes
    std::array<float, 3> d;           ///< [m]
    float slope, density;
  };
  /// What a box's connections add up to: xx, xy, xz, yy, yz, zz of each pair's block.
  struct LinksOfBox {
    std::vector<LinkIn> links;
    std::array<Pairs, 6> blocks;
    LinksOfBox() { blocks.fill(Pairs::Zero()); }
  };

  /// A box's stiffness as it is added up.
  struct BoxSum {
    BoxElements::Element element;
    double stiffness;  ///< mean of its diagonal [N/m]
    std::vector<LinkIn> links;
    std::array<LinksOfBox, 4> known_links;  ///< of boxes before
    int oldest = 0;                         ///< of these
  };

  /// Functions can only contain what can be copied.
  std::shared_ptr<const Sorted> by_box(const std::vector<int>& homes) const {
    return std::make_shared<const Sorted>(homes, grid_.boxes());
  }

  static void stabilise(BoxSum& sum) {
    static const Pairs table = stabilisation();
    for (const int e : {0, 4, 8}) sum.element[e] += static_cast<float>(std::max(0., sum.stiffness)) * table;
  }

  void add_gradient(const GradientIn& one, BoxSum& sum) const {
    const Eigen::Vector3f at = grid_.at_in(one.box, one.middle);
    Eigen::Matrix<float, 3 * kCorners, 1> change = Eigen::Matrix<float, 3 * kCorners, 1>::Zero();
    for (const auto& [molecule, g] : one.gradient) {
      const Corners along = slopes_along(at, grid_.along(body_.rest.col(molecule) - one.middle).cast<float>());
      for (int corner = 0; corner < kCorners; ++corner)
        change.segment<3>(3 * corner) += along[corner] * g.cast<float>();
    }
    add_box(static_cast<float>(one.factor) * change * change.transpose(), sum);
  }

  void add_at(const BlockAt& one, int box, BoxSum& sum) {
    const Corners values = BoxGrid::values_at(grid_.at_in(box, body_.rest.col(one.molecule)));
    for (int p = 0; p < kPairs; ++p)
      for (int e = 0; e < 9; ++e)
        sum.element[e][p] += values[kPair[p].first] * values[kPair[p].second] * static_cast<float>(one.block.data()[e]);
    auto& sums = result_.sums[result_.sums_of[box]];
    for (int corner = 0; corner < kCorners; ++corner) sums[corner] += values[corner] * one.block;
  }

  void add_cell(const CellSlopes& cells, int cell, int box, BoxSum& sum) const {
    Eigen::Matrix<double, 3 * kCorners, Eigen::Dynamic, Eigen::ColMajor, 3 * kCorners, kMostSides> change(3 * kCorners,
                                                                                                          cells.sides);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostSides, kMostSides> slope(cells.sides,
                                                                                                         cells.sides);
    const auto sides = cells.connections_of(cell);
    const double* slopes = cells.slopes_of(cell);
    const Eigen::Vector3f at = grid_.at_in(box, middle_of(body_, cells, cell));
    for (int i = 0; i < cells.sides; ++i) {
      const int c = sides[i];
      const Corners along = slopes_along(at, grid_.along(rest_vector(c)).cast<float>());
      const Vector3 d = tangent_.link(c).d;
      for (int corner = 0; corner < kCorners; ++corner) change.block<3, 1>(3 * corner, i) = double{along[corner]} * d;
      for (int j = 0; j < cells.sides; ++j) slope(i, j) = 2 * cells.factor * slopes[i * cells.sides + j];
    }
    const decltype(change) resisted = change.lazyProduct(slope);
    add_box(resisted.lazyProduct(change.transpose()).template cast<float>(), sum);
  }

  /// The stiffness of a box in 3 × 3 blocks: of each second corner, of each entry, of all first corners.
  using PointBlocks = std::array<std::array<Corners, 9>, kCorners>;
  /// factor Σ_pq a_p[i] a_q[j] K_pq, with the slopes a of the corners' values.
  void add_point(const StiffPoints& points, int point, int box, float factor, PointBlocks& sum) const {
    const auto [frame, stiffness] = points.stiffness_at(point);
    const Eigen::Vector3f at = grid_.at_in(box, points.place_of(point));
    const Eigen::Index axes = frame.cols();
    std::array<Corners, 3> along;
    for (Eigen::Index p = 0; p < axes; ++p) along[p] = slopes_along(at, grid_.along(frame.col(p)).cast<float>());
    for (Eigen::Index p = 0; p < axes; ++p) {
      std::array<Corners, 9> of_second;  // Σ_q a_q[j] K_pq
      of_second.fill(Corners::Zero());
      for (Eigen::Index q = 0; q < axes; ++q) {
        const Eigen::Matrix3f part = factor * stiffness.block<3, 3>(3 * p, 3 * q).cast<float>();
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

  /// A box's connections that have one stiffness, and the sum of their corners' products.
  struct AlikeLinks {
    LinkIn link;
    Pairs products;
  };
  /// Connections of a lattice come in a few directions: the products of those that are alike are added up first.
  static void add_up(LinksOfBox& of_box) {
    constexpr float rounding = 1e-6F;
    constexpr std::size_t most = 16;
    std::array<AlikeLinks, most> kinds;
    std::size_t known = 0;
    auto& blocks = of_box.blocks;
    for (Pairs& block : blocks) block.setZero();
    const auto add = [&](const AlikeLinks& alike) {
      const auto [x, y, z] = alike.link.d;
      const float s = alike.link.slope, q = alike.link.density;
      blocks[0] += (s * x * x + q) * alike.products;
      blocks[1] += s * x * y * alike.products;
      blocks[2] += s * x * z * alike.products;
      blocks[3] += (s * y * y + q) * alike.products;
      blocks[4] += s * y * z * alike.products;
      blocks[5] += (s * z * z + q) * alike.products;
    };
    for (const LinkIn& link : of_box.links) {
      const Corners along = slopes_along(Eigen::Vector3f(link.at.data()), Eigen::Vector3f(link.extent.data()));
      AlikeLinks own{link, {}};
      for (int i = 0, p = 0; i < kCorners; ++i)
        for (int j = i + 1; j < kCorners; ++j, ++p) own.products[p] = along[i] * along[j];
      const auto end = kinds.begin() + static_cast<std::ptrdiff_t>(known);
      const auto found = std::find_if(kinds.begin(), end,
                                      [&](const AlikeLinks& kind) { return is_as_stiff(kind.link, link, rounding); });
      if (found != end)
        found->products += own.products;
      else if (known < most)
        kinds[known++] = own;
      else
        add(own);
    }
    for (std::size_t kind = 0; kind < known; ++kind) add(kinds[kind]);
  }

  static bool is_as_stiff(const LinkIn& one, const LinkIn& other, float rounding) {
    const auto size = [](const std::array<float, 3>& v) {
      return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    };
    const std::array<float, 3> change{one.d[0] - other.d[0], one.d[1] - other.d[1], one.d[2] - other.d[2]};
    return size(change) <= rounding * size(other.d) &&
           std::abs(one.slope - other.slope) <= rounding * std::abs(other.slope) &&
           std::abs(one.density - other.density) <= rounding * std::abs(other.density);
  }

  /// A box of a lattice has the connections of one before it, again.
  void add_links(const Sorted& links, int box, BoxSum& sum) const {
    constexpr float rounding = 1e-5F;
    std::vector<LinkIn>& own = sum.links;
    own.clear();
    for (const int c : links.of(box)) {
      const auto& [a, b] = body_.connections.ends[c];
      const Eigen::Vector3f at = grid_.at_in(box, (body_.rest.col(a) + body_.rest.col(b)) / 2),
                            extent = grid_.along(rest_vector(c)).cast<float>();
      const auto [d, density, slope] = tangent_.link(c);
      const Eigen::Vector3f own_d = d.cast<float>();
      own.push_back({{at.x(), at.y(), at.z()},
                     {extent.x(), extent.y(), extent.z()},
                     {own_d.x(), own_d.y(), own_d.z()},
                     static_cast<float>(slope),
                     static_cast<float>(density)});
    }
    const auto alike = [](const LinkIn& one, const LinkIn& other) {
      float most_apart = 0;
      for (int k = 0; k < 3; ++k)
        most_apart =
            std::max({most_apart, std::abs(one.at[k] - other.at[k]), std::abs(one.extent[k] - other.extent[k])});
      return most_apart <= rounding && is_as_stiff(one, other, rounding);
    };
    auto& known = sum.known_links;
    auto found = std::find_if(known.begin(), known.end(), [&](const LinksOfBox& other) {
      return std::equal(own.begin(), own.end(), other.links.begin(), other.links.end(), alike);
    });
    if (found == known.end()) {
      found = known.begin() + sum.oldest;
      sum.oldest = (sum.oldest + 1) % static_cast<int>(known.size());
      std::swap(found->links, own);
      add_up(*found);
    }
    const auto& blocks = found->blocks;
    constexpr int from[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    for (int e = 0; e < 9; ++e) sum.element[e] += blocks[from[e]];
    sum.stiffness -= double{(blocks[0] + blocks[3] + blocks[5]).sum()} / (1.5 * kCorners);
  }

  static void add_box(const Eigen::Matrix<float, 3 * kCorners, 3 * kCorners>& stiffness, BoxSum& sum) {
    for (int p = 0; p < kPairs; ++p)
      for (int e = 0; e < 9; ++e)
        sum.element[e][p] += stiffness(3 * kPair[p].first + e % 3, 3 * kPair[p].second + e / 3);
    sum.stiffness += stiffness.trace() / (3 * kCorners);
  }

  const Tangent& tangent_;
  const Body& body_;
  const BoxGrid& grid_;
  BoxElements result_;
  std::vector<std::function<void(int box, BoxSum& sum)>> added_;
};

/// The part of a symmetric block that is positive.
Matrix3 positive_part(const Matrix3& block) {
  const SymmetricEigen3 eigen = symmetric_eigen3(Matrix3((block + block.transpose()) / 2));
  return eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
}

/// What stands at molecules themselves: inertia, loads, supports.
std::vector<BlockAt> blocks_at_molecules(const Tangent& tangent, const std::vector<Support>& supports) {
  const Body& body = tangent.model().body();
  std::vector<BlockAt> blocks;
  std::vector<Matrix3> own;
  tangent.visit_other_diagonal([&](int molecule, const Matrix3& block) {
    if (own.empty()) own.assign(body.size(), Matrix3::Zero());
    own[molecule] += block;
  });
  const double inertia = tangent.weights().acceleration;
  for (int a = 0; a < body.size() && (inertia != 0 || !own.empty()); ++a) {
    Matrix3 block = own.empty() ? Matrix3::Zero() : positive_part(own[a]);
    if (inertia != 0) block.diagonal().array() += inertia * body.mass[a];
    if (!block.isZero(0)) blocks.push_back({a, block});
  }
  for (const Support& support : supports) {
    const Matrix3 held = Matrix3::Identity() - support.free;
    blocks.push_back({support.molecule, positive_part(held * tangent.diagonal(support.molecule) * held)});
  }
  return blocks;
}

std::vector<GradientIn> gradients_in(const Tangent& tangent, const Homes& homes, const BoxGrid& grid) {
  const Body& body = tangent.model().body();
  std::vector<GradientIn> gradients;
  std::vector<int> molecules;
  tangent.visit_gradients([&](std::span<const std::pair<int, Vector3>> gradient, double factor) {
    Vector3 middle = Vector3::Zero();
    molecules.clear();
    for (const auto& [molecule, g] : gradient) {
      middle += body.rest.col(molecule) / static_cast<double>(gradient.size());
      molecules.push_back(molecule);
    }
    const int box = homes.molecules[node_in(molecules, homes.outline, grid.outline_box(middle))];
    gradients.push_back({{gradient.begin(), gradient.end()}, factor, middle, box});
  });
  return gradients;
}

GridLevel assemble(const Tangent& tangent, const std::vector<Support>& supports, const BoxGrid::Frame& frame,
                   bool is_part) {
  const Body& body = tangent.model().body();
  BoxGrid grid(frame);
  ReachedByLaw reached;
  tangent.visit_points(
      [&](const StiffPoints& points) { reached.push_back(reached_by(points, body.rest, grid.size())); });
  const Homes homes = find_homes(tangent, reached, grid, is_part);
  Assembly assembly(tangent, grid);
  if (tangent.linked()) assembly.add_links(homes.links);
  auto next = homes.elements.begin();
  auto molecules_of = reached.begin();
  tangent.visit_cells([&](const CellSlopes& cells) { assembly.add_cells(cells, *next++); });
  tangent.visit_points([&](const StiffPoints& points) {
    const auto& of_points = *next++;
    assembly.add_points(points, of_points, *molecules_of++, *next++);
  });
  const std::vector<GradientIn> gradients = gradients_in(tangent, homes, grid);
  assembly.add_gradients(gradients);
  const std::vector<BlockAt> blocks = blocks_at_molecules(tangent, supports);
  assembly.add_at(blocks, homes.molecules);
  BoxMembers members(grid, homes.molecules,
                     [&](int molecule) { return grid.at_in(homes.molecules[molecule], body.rest.col(molecule)); });
  BoxElements elements = assembly.result();
  return {std::make_unique<BoxLevel>(std::move(grid), std::move(elements), is_part), std::move(members)};
}

}  // namespace

BoxGrid::Frame frame_of(const Body& body) {
  const double size = long_connection(body, 2 * spacing_of(body));
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
