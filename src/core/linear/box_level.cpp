#include "core/linear/box_level.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "core/linear/block_inverse.h"
#include "core/linear/smoothing.h"
#include "core/parallel/large_memory.h"

namespace elastin {
namespace {

constexpr int kBoxCorners = BoxGrid::kCorners;

/// Cost of a point's share of a pass, in connections.
constexpr int kPointThreshold = kParallelThreshold / 50;

/// The number of a pair of corners, either way.
constexpr auto kPairOf = [] {
  std::array<std::array<int, kBoxCorners>, kBoxCorners> numbers{};
  for (int i = 0, pair = 0; i < kBoxCorners; ++i)
    for (int j = i + 1; j < kBoxCorners; ++j, ++pair) numbers[i][j] = numbers[j][i] = pair;
  return numbers;
}();

/// Of a list of numbers, another one with next to certainty: two lists that had the same would only make a
/// preconditioner worse.
class Key {
 public:
  void add(std::uint64_t number) {
    value_ = (value_ ^ number) * 0x9e3779b97f4a7c15U;
    value_ ^= value_ >> 29;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

/// Calls first(item) or same(item, the first one with that key) for all items in order; those without a key, 0, are
/// first ones.
template <class First, class Same>
void by_key(const std::vector<std::uint64_t>& keys, First&& first, Same&& same) {
  std::unordered_map<std::uint64_t, int> known;
  for (int item = 0; item < static_cast<int>(keys.size()); ++item) {
    const auto [found, is_new] = keys[item] == 0 ? std::pair(known.end(), true) : known.try_emplace(keys[item], item);
    is_new ? first(item) : same(item, found->second);
  }
}

using Square = Eigen::Matrix<float, kBoxCorners, kBoxCorners>;

/// The functions of a box at the corners of each of the eight in it: a row a corner.
const std::array<Square, kBoxCorners>& functions_in_children() {
  static const std::array<Square, kBoxCorners> all = [] {
    std::array<Square, kBoxCorners> tables;
    for (int child = 0; child < kBoxCorners; ++child)
      for (int c = 0; c < kBoxCorners; ++c) {
        const Eigen::Vector3i at(child % 2 + c % 2, child / 2 % 2 + c / 2 % 2, child / 4 + c / 4);
        tables[child].row(c) = BoxGrid::values_at(at.cast<float>() / 2).matrix().transpose();
      }
    return tables;
  }();
  return all;
}

/// The stiffness of a box to its functions, put together from the boxes in it.
class LargerBox {
 public:
  LargerBox() {
    for (auto& row : entries_) row.fill(Square::Zero());
  }
  void add(const BoxElements& elements, int child, int octant) {
    const Square& functions = functions_in_children()[octant];
    const BoxElements::Element& element = elements.of(child);
    const int sums = elements.sums_of[child];
    for (int row = 0; row < 3; ++row)
      for (int column = row; column < 3; ++column) {
        Square own = Square::Zero();
        for (int i = 0, pair = 0; i < kBoxCorners; ++i)
          for (int j = i + 1; j < kBoxCorners; ++j, ++pair)
            own(i, j) = element[row + 3 * column][pair], own(j, i) = element[column + 3 * row][pair];
        for (int i = 0; i < kBoxCorners; ++i)
          own(i, i) = (sums < 0 ? 0 : static_cast<float>(elements.sums[sums][i](row, column))) - own.row(i).sum();
        const Square applied = own.lazyProduct(functions);
        entries_[row][column] += functions.transpose().lazyProduct(applied);
      }
  }
  BoxElements::Element element() const {
    BoxElements::Element result;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        for (int i = 0, pair = 0; i < kBoxCorners; ++i)
          for (int j = i + 1; j < kBoxCorners; ++j, ++pair)
            result[row + 3 * column][pair] = row <= column ? entries_[row][column](i, j) : entries_[column][row](j, i);
    return result;
  }

 private:
  std::array<std::array<Square, 3>, 3> entries_;  ///< of row ≤ column
};

}  // namespace

BoxElements::BoxElements(int boxes) : elements(new Element[boxes]), kind_of(boxes, 0), sums_of(boxes, -1) {
  prefer_large_pages(elements.get(), boxes * sizeof(Element));
}

void BoxElements::set(int box, const Element& element, std::vector<int>& kinds) {
  constexpr float rounding = 1e-5F;
  constexpr std::ptrdiff_t most = 64;
  float size = 0;
  for (const int e : {0, 4, 8}) size = std::max(size, element[e].abs().maxCoeff());
  const auto alike = [&](int kind) {
    if (!(std::abs(element[0][0] - elements[kind][0][0]) <= rounding * size)) return false;  // most end here
    for (int e = 0; e < 9; ++e)
      if (!((element[e] - elements[kind][e]).abs().maxCoeff() <= rounding * size)) return false;
    return true;
  };
  const auto last =
      kinds.size() > most ? kinds.rend() - (static_cast<std::ptrdiff_t>(kinds.size()) - most) : kinds.rend();
  if (const auto found = std::find_if(kinds.rbegin(), last, alike); found != last) {
    kind_of[box] = *found;
    return;
  }
  if (&element != &elements[box]) elements[box] = element;
  kind_of[box] = box;
  kinds.push_back(box);
}

void BoxElements::share() {
  const int boxes = static_cast<int>(kind_of.size());
  int own = 0;
  for (int box = 0; box < boxes; ++box) own += kind_of[box] == box;
  shared = 2 * own <= boxes;
  if (!shared) return;  // of no lattice
  std::vector<int> kinds;
  for (int box = 0; box < boxes; ++box)
    if (kind_of[box] == box)
      set(box, elements[box], kinds);
    else
      kind_of[box] = kind_of[kind_of[box]];
}

void BoxElements::set_sums_in(const std::vector<char>& boxes) {
  int count = 0;
  for (std::size_t box = 0; box < boxes.size(); ++box)
    if (boxes[box]) sums_of[box] = count++;
  Sums zero;
  zero.fill(Matrix3::Zero());
  sums.assign(static_cast<std::size_t>(count), zero);
}

BoxLevel::BoxLevel(BoxGrid grid, BoxElements elements, bool is_part)
    : grid_(std::move(grid)), elements_(std::move(elements)) {
  set_rows();
  if (is_part) return;
  inverse_.resize(points());
  parallel_for(
      points(),
      [&](int point) {
        const Matrix3 own = block_to(point, 0);
        inverse_[point] = positive_inverse((own + own.transpose()) / 2).cast<float>();
      },
      kPointThreshold);
  set_damping();
}

/// Of the blocks of a point's row, from the boxes around it and where their corners stand in the row; 0 where it has
/// blocks of its own, as where something outside the body resists.
std::uint64_t BoxLevel::row_key(int point, const std::vector<int>& slots) const {
  if (!elements_.shared) return 0;
  Key key;
  for (const int corner : grid_.around(point)) {
    const int box = corner / kBoxCorners;
    if (elements_.sums_of[box] >= 0) return 0;
    std::uint64_t places = 0;
    for (const int other : grid_.corners(box)) places = std::rotl(places, 8) ^ static_cast<unsigned>(slots[other]);
    key.add(static_cast<unsigned>(kBoxCorners * elements_.kind_of[box] + corner % kBoxCorners) + 1U);
    key.add(places);
  }
  return key.value();
}

void BoxLevel::set_rows() {
  const auto for_points = [&](const auto& work) {
    parallel_ranges(
        points(),
        [&](int begin, int end) {
          std::vector<int> slots(points(), -1);  // of the points around this one
          for (int point = begin; point < end; ++point) work(point, slots);
        },
        kPointThreshold);
  };
  const auto round_up = [](int count) { return (count + kWidth - 1) / kWidth * kWidth; };
  // A point itself comes first.
  const auto number_around = [&](int point, std::vector<int>& slots, const auto& number) {
    slots[point] = 0;
    int count = 1;
    for (const int corner : grid_.around(point))
      for (const int other : grid_.corners(corner / kBoxCorners))
        if (slots[other] < 0) {
          number(count, other);
          slots[other] = count++;
        }
    return count;
  };
  const auto forget = [&](int point, std::vector<int>& slots) {
    slots[point] = -1;
    for (const int corner : grid_.around(point))
      for (const int other : grid_.corners(corner / kBoxCorners)) slots[other] = -1;
  };
  start_.assign(points() + 1, 0);
  std::vector<std::uint64_t> keys(points());
  for_points([&](int point, std::vector<int>& slots) {
    start_[point + 1] = round_up(number_around(point, slots, [](int, int) {}));
    keys[point] = row_key(point, slots);
    forget(point, slots);
  });
  for (int point = 0; point < points(); ++point) start_[point + 1] += start_[point];
  neighbours_.resize(start_.back());
  row_at_.resize(points());
  std::vector<char> is_first(points(), 0);
  int rows = 0;
  by_key(
      keys,
      [&](int point) {
        row_at_[point] = rows, is_first[point] = 1, rows += (start_[point + 1] - start_[point]) / kWidth;
      },
      [&](int point, int first) { row_at_[point] = row_at_[first]; });
  kept_rows_ = static_cast<int>(std::count(is_first.begin(), is_first.end(), 1));
  rows_.reset(new Blocks[rows]);
  prefer_large_pages(rows_.get(), rows * sizeof(Blocks));
  sums_.assign(points(), Matrix3::Zero());
  for_points([&](int point, std::vector<int>& slots) {
    int* neighbours = &neighbours_[start_[point]];
    std::fill(neighbours, &neighbours_[0] + start_[point + 1], point);
    number_around(point, slots, [&](int slot, int other) { neighbours[slot] = other; });
    if (!is_first[point]) return forget(point, slots);
    Blocks* row = &rows_[row_at_[point]];
    for (int n = 0; n < (start_[point + 1] - start_[point]) / kWidth; ++n)
      for (auto& entry : row[n]) entry.setZero();
    for (const int around : grid_.around(point)) {
      const int box = around / kBoxCorners, c = around % kBoxCorners;
      const BoxElements::Element& element = elements_.of(box);
      for (int other = 0; other < kBoxCorners; ++other) {
        if (other == c) continue;
        const int slot = slots[grid_.corners(box)[other]];
        Blocks& blocks = row[slot / kWidth];
        const int pair = kPairOf[c][other];
        for (int e = 0; e < 9; ++e) blocks[e][slot % kWidth] += element[c < other ? e : e / 3 + 3 * (e % 3)][pair];
      }
      if (const int sums = elements_.sums_of[box]; sums >= 0) sums_[point] += elements_.sums[sums][c];
    }
    for (int e = 0; e < 9; ++e) row[0][e][0] = static_cast<float>(sums_[point].data()[e]);
    forget(point, slots);
  });
}

Matrix3 BoxLevel::block_to(int point, int neighbour) const {
  Matrix3 block = Matrix3::Zero();
  const auto add = [&](int n, double sign) {
    const Blocks& blocks = rows_[row_at_[point] + n / kWidth];
    for (int e = 0; e < 9; ++e) block.data()[e] += sign * double{blocks[e][n % kWidth]};
  };
  if (neighbour != 0) {
    add(neighbour, 1);
    return block;
  }
  block = sums_[point];
  for (int other = 1; other < start_[point + 1] - start_[point]; ++other) add(other, -1);
  return block;
}

/// (A x)_i. Of four neighbours at once, each read with the number behind it.
inline Eigen::Vector3f BoxLevel::difference(const Vectors& x, int point) const {
  typedef float Four __attribute__((vector_size(4 * kWidth)));
  const auto read = [](const float* from, Four& four) { std::memcpy(&four, from, sizeof four); };
  const int first = start_[point], end = start_[point + 1];
  const Blocks* row = &rows_[row_at_[point]];
  const auto of = [all = x.data()](int other) { return all + 3 * static_cast<std::ptrdiff_t>(other); };
  Four own, sums[3] = {};
  read(of(point), own);
  for (int n = first; n < end; n += kWidth) {
    Four d[kWidth];
    for (int i = 0; i < kWidth; ++i) {
      read(of(neighbours_[n + i]), d[i]);
      d[i] -= own;
    }
    if (n == first) d[0] = own;
    const Four xy_01 = __builtin_shufflevector(d[0], d[1], 0, 4, 1, 5),
               xy_23 = __builtin_shufflevector(d[2], d[3], 0, 4, 1, 5),
               z_01 = __builtin_shufflevector(d[0], d[1], 2, 6, 3, 7),
               z_23 = __builtin_shufflevector(d[2], d[3], 2, 6, 3, 7);
    const Four dx = __builtin_shufflevector(xy_01, xy_23, 0, 1, 4, 5),
               dy = __builtin_shufflevector(xy_01, xy_23, 2, 3, 6, 7),
               dz = __builtin_shufflevector(z_01, z_23, 0, 1, 4, 5);
    const float* block = (*row++)[0].data();
    for (int k = 0; k < 3; ++k) {
      Four x_entries, y_entries, z_entries;
      read(block + kWidth * k, x_entries);
      read(block + kWidth * (3 + k), y_entries);
      read(block + kWidth * (6 + k), z_entries);
      sums[k] += x_entries * dx + y_entries * dy + z_entries * dz;
    }
  }
  Eigen::Vector3f result;
  for (int k = 0; k < 3; ++k) result[k] = (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]);
  return result;
}

void BoxLevel::set_residual(const Vectors& b, const Vectors& x, Vectors& residual) const {
  parallel_for(
      points(), [&](int i) { residual.col(i) = b.col(i) - difference(x, i); }, kPointThreshold);
}

void BoxLevel::start(const Vectors& b, Vectors& x, Vectors& d) const {
  const auto now = static_cast<float>(smoothing_step(1).now);
  parallel_for(points(), [&](int i) { d.col(i) = x.col(i) = now * (inverse_[i] * b.col(i)); });
}

void BoxLevel::smooth(int step, const Vectors& b, const Vectors& x, Vectors& better, Vectors& d) const {
  const auto [before, now] = smoothing_step(step);
  const auto of_before = static_cast<float>(before), of_now = static_cast<float>(now);
  parallel_for(
      points(),
      [&](int i) {
        d.col(i) = of_before * d.col(i) + of_now * (inverse_[i] * (b.col(i) - difference(x, i)));
        better.col(i) = x.col(i) + d.col(i);
      },
      kPointThreshold);
}

void BoxLevel::set_damping() {
  Vectors x = vectors(), y = vectors(), z = vectors();
  constexpr double stiff = 4.5;  // where volumes resist far more than shape
  const auto [of_most, bound] = largest_eigenvalue(points(), x, y, z, [&](const Vectors& from, Vectors& to) {
    parallel_for(
        points(), [&](int i) { to.col(i) = inverse_[i] * difference(from, i); }, kPointThreshold);
  });
  steps_ = of_most > stiff ? 6 : of_most > kOneStep ? 2 : 1;
  for (auto& inverse : inverse_) inverse /= static_cast<float>(bound);
}

std::unique_ptr<BoxLevel> BoxLevel::coarser(BoxGrid::Coarser coarser, bool is_part) {
  const BoxGrid& coarse = coarser.grid;
  const std::vector<int>& parents = coarser.parents;
  BoxElements elements(coarse.boxes());
  std::vector<char> resisted(coarse.boxes(), 0);
  for (int box = 0; box < grid_.boxes(); ++box)
    if (elements_.sums_of[box] >= 0) resisted[parents[box]] = 1;
  elements.set_sums_in(resisted);
  elements.shared = elements_.shared;
  const BoxMembers children(coarse, parents, [](int) { return Eigen::Vector3f(); });
  const auto octant_of = [&](int child) {
    const auto& [x, y, z] = grid_.cell(child);
    return x % 2 + 2 * (y % 2) + 4 * (z % 2);
  };
  std::vector<std::uint64_t> keys(coarse.boxes(), 0);
  parallel_for(
      coarse.boxes(),
      [&](int box) {
        if (resisted[box] || !elements_.shared) return;
        Key key;
        for (const auto& [child, ignored] : children.in(box))
          key.add(static_cast<unsigned>(kBoxCorners * elements_.kind_of[child] + octant_of(child)) + 1U);
        keys[box] = key.value();
      },
      kPointThreshold);
  by_key(
      keys, [&](int box) { elements.kind_of[box] = box; }, [&](int box, int first) { elements.kind_of[box] = first; });
  parallel_for(
      coarse.boxes(),
      [&](int box) {
        if (elements.kind_of[box] != box) return;
        LargerBox larger;
        for (const auto& [child, ignored] : children.in(box)) {
          const int octant = octant_of(child);
          larger.add(elements_, child, octant);
          if (elements_.sums_of[child] < 0) continue;
          const BoxElements::Sums& sums = elements_.sums[elements_.sums_of[child]];
          for (int i = 0; i < kBoxCorners; ++i)
            for (int c = 0; c < kBoxCorners; ++c)
              elements.sums[elements.sums_of[box]][i] +=
                  static_cast<double>(functions_in_children()[octant](c, i)) * sums[c];
        }
        elements.elements[box] = larger.element();
      },
      kPointThreshold / 20);
  elements_ = BoxElements(0);
  std::vector<int> box_of(points());
  for (int point = 0; point < points(); ++point) box_of[point] = parents[grid_.around(point).front() / kBoxCorners];
  members_ = BoxMembers(coarse, box_of, [&](int point) {
    Eigen::Vector3f at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<float>(grid_.at(point)[axis] - 2 * coarse.cell(box_of[point])[axis]) / 2;
    return at;
  });
  return std::make_unique<BoxLevel>(std::move(coarser.grid), std::move(elements), is_part);
}

void BoxLevel::restrict_to(const BoxLevel& coarse, const Vectors& fine, Vectors& of_boxes, Vectors& result) const {
  members_.restrict_to(
      coarse.grid_, [&](int point) { return fine.col(point); }, of_boxes, result);
}

void BoxLevel::prolong_from(const BoxLevel& coarse, const Vectors& values, Vectors& fine) const {
  members_.prolong_from(coarse.grid_, values,
                        [&](int point, const Eigen::Vector3f& value) { fine.col(point) += value; });
}

}  // namespace elastin
