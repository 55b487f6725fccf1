#include "core/forces/grid_springs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel/parallel.h"

namespace elastin {

/// The rows that springs join to the present one: places and forces of reach + 1 rows in a ring, and one row more.
struct GridSprings::Window {
  double* buffer;
  std::ptrdiff_t pitch;
  int slots;
  int first_slot;  // of the present row

  static std::ptrdiff_t pitch_of(int length) { return (length + 7) / 8 * 8; }
  RowOf3 at(int slot, int half) const { return {buffer + (2 * slot + half) * 3 * pitch, pitch}; }
  int slot(int rows_on) const { return first_slot + rows_on - (first_slot + rows_on >= slots ? slots : 0); }
  RowOf3 positions(int rows_on) const { return at(slot(rows_on), 0); }
  RowOf3 forces(int rows_on) const { return at(slot(rows_on), 1); }
  RowOf3 spare() const { return at(slots, 0); }
};

/// Reads a list of connections that ascends by first ends, row after row.
class GridSprings::Builder {
 public:
  Builder(const Body& body, const VectorX& constants, const double* rest_lengths)
      : body_(body),
        constants_(constants),
        rest_lengths_(rest_lengths),
        counts_(*body.grid),
        length_(counts_[0] <= kShort ? counts_[0] * counts_[1] : counts_[0]),
        springs_(length_, body.size() / length_) {
    for (int code = 0; code < kDirections; ++code) {
      const auto [x, y, z] = offset(code);
      const int rows_in_row = length_ / counts_[0];  // 1, or all of a layer
      springs_.directions_.push_back({rows_in_row == 1 ? x : x + counts_[0] * y,
                                      rows_in_row == 1 ? y + counts_[1] * z : z, std::vector<int>(springs_.rows_, -1)});
    }
    // Places are rounded, so lengths that should be alike are not quite, nor are constants made from them.
    const double extent = body.rest.cwiseAbs().maxCoeff();
    length_error_ = 4 * std::numeric_limits<double>::epsilon() * extent;
  }

  std::optional<GridSprings> build() {
    int last = 0;
    for (int c = 0; c < body_.connections.size(); ++c) {
      if (constants_[c] == 0) continue;
      const int a = std::min(body_.connections.ends[c][0], body_.connections.ends[c][1]);
      const int b = std::max(body_.connections.ends[c][0], body_.connections.ends[c][1]);
      if (a < last) return std::nullopt;
      if (a / length_ != last / length_) finish_row(last / length_);
      last = a;
      if (!add(a, b, constants_[c], rest_lengths_[c])) return std::nullopt;
    }
    finish_row(last / length_);
    std::erase_if(springs_.directions_, [](const Direction& direction) {
      return std::all_of(direction.numbers_at.begin(), direction.numbers_at.end(), [](int at) { return at < 0; });
    });
    for (const Direction& direction : springs_.directions_) springs_.reach_ = std::max(springs_.reach_, direction.rows);
    return std::move(springs_);
  }

 private:
  /// Lines of the grid so short count as one row with the others of their layer: few springs a row cost more than those
  /// that are not there, from the end of a line to the start of the next.
  static constexpr int kShort = 16;

  /// The 13 neighbours that come later than a molecule.
  static constexpr int kDirections = 13;
  static std::array<int, 3> offset(int code) {
    const int all = code + kDirections + 1;  // of 27, of which the middle is the molecule itself
    return {all % 3 - 1, all / 3 % 3 - 1, all / 9 - 1};
  }

  bool add(int a, int b, double constant, double rest_length) {
    const auto position = [&](int molecule) {
      return std::array{molecule % counts_[0], molecule / counts_[0] % counts_[1], molecule / counts_[0] / counts_[1]};
    };
    const auto from = position(a), to = position(b);
    int code = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const int step = to[axis] - from[axis];
      if (step < -1 || step > 1) return false;
      code = 3 * code + step + 1;
    }
    Row& row = rows_[code - kDirections - 1];
    if (row.numbers.empty()) row.numbers.assign(2 * static_cast<std::size_t>(length_), 0);
    const int at = a % length_;
    if (row.numbers[at] != 0) return false;
    row.numbers[at] = constant;
    row.numbers[length_ + at] = rest_length;
    return true;
  }

  void finish_row(int number) {
    for (int code = 0; code < kDirections; ++code) {
      Row& row = rows_[code];
      if (row.numbers.empty()) continue;
      springs_.directions_[code].numbers_at[number] = shared(row);
      row.numbers.clear();
    }
  }

  struct Row {
    std::vector<double> numbers;
    std::vector<int> known;  ///< where different rows of this direction begin, the latest last
  };

  /// Where numbers like these begin: a lattice has a few kinds of rows (inside, on faces, on edges), a jittered body
  /// as many as rows.
  int shared(Row& row) {
    const auto& numbers = row.numbers;
    constexpr std::ptrdiff_t most = 16;
    const auto begin = row.known.size() > most ? row.known.end() - most : row.known.begin();
    for (auto at = row.known.end(); at != begin;)
      if (alike(springs_.numbers_.data() + *--at, numbers.data())) return *at;
    row.known.push_back(static_cast<int>(springs_.numbers_.size()));
    springs_.numbers_.insert(springs_.numbers_.end(), numbers.begin(), numbers.end());
    return row.known.back();
  }

  bool alike(const double* one, const double* other) const {
    for (int i = 0; i < length_; ++i) {
      const double length = one[length_ + i];
      if (std::abs(other[length_ + i] - length) > length_error_) return false;
      if (std::abs(other[i] - one[i]) * length > length_error_ * std::abs(one[i])) return false;
    }
    return true;
  }

  const Body& body_;
  const VectorX& constants_;
  const double* rest_lengths_;
  std::array<int, 3> counts_;
  int length_;  ///< of a row
  GridSprings springs_;
  std::array<Row, kDirections> rows_;
  double length_error_;
};

std::optional<GridSprings> GridSprings::make(const Body& body, const VectorX& constants, const double* rest_lengths) {
  if (!body.grid || body.size() == 0) return std::nullopt;
  const auto& [nx, ny, nz] = *body.grid;
  if (static_cast<long long>(nx) * ny * nz != body.size()) return std::nullopt;
  return Builder(body, constants, rest_lengths).build();
}

void GridSprings::add_forces(const Positions& positions, Positions& forces, Workspace& workspace) const {
  const int springs = length_ * rows_ * static_cast<int>(directions_.size());
  const int ranges = springs < kParallelThreshold ? 1 : std::clamp(rows_ / (reach_ + 1), 1, threads());
  const Eigen::Index buffer = (2 * (reach_ + 1) + 1) * 3 * Window::pitch_of(length_);
  workspace.reserve_ranges(ranges);
  for (int range = 0; range < ranges; ++range) workspace.range_buffer(range, buffer);
  parallel_for(
      ranges,
      [&](int range) {
        const auto start = [&](int p) { return static_cast<int>(static_cast<long long>(rows_) * p / ranges); };
        add_rows(start(range), start(range + 1), positions, forces, workspace.range_buffer(range, buffer));
      },
      2);
}

void GridSprings::add_rows(int begin, int end, const Positions& positions, Positions& forces,
                           Eigen::Map<VectorX> buffer) const {
  const int first = std::max(0, begin - reach_);
  Window window{buffer.data(), Window::pitch_of(length_), reach_ + 1, 0};
  const auto load = [&](int row, int rows_on) {
    if (row >= rows_) return;
    const double* from = positions.data() + 3 * static_cast<std::ptrdiff_t>(row) * length_;
    const RowOf3 to = window.positions(rows_on), zero = window.forces(rows_on);
    for (int i = 0; i < length_; ++i) to.x[i] = from[3 * i], to.y()[i] = from[3 * i + 1], to.z()[i] = from[3 * i + 2];
    std::fill_n(zero.x, 3 * zero.pitch, 0.);
  };
  for (int on = 0; on < reach_; ++on) load(first + on, on);
  for (int row = first; row < end; ++row, window.first_slot = window.slot(1)) {
    load(row + reach_, reach_);
    add_row(row, begin, window);
    if (row < begin) continue;
    double* to = forces.data() + 3 * static_cast<std::ptrdiff_t>(row) * length_;
    const RowOf3 sum = window.forces(0);
    for (int i = 0; i < length_; ++i) to[3 * i] += sum.x[i], to[3 * i + 1] += sum.y()[i], to[3 * i + 2] += sum.z()[i];
  }
}

/// Adds the forces of the springs that start in a row, where they reach the row `begin` or a later one.
void GridSprings::add_row(int row, int begin, const Window& window) const {
  const SpringKernel& kernel = spring_kernel();
  const RowOf3 positions = window.positions(0), forces = window.forces(0);
  for (const Direction& direction : directions_) {
    const int at = direction.numbers_at[row];
    if (at < 0 || row + direction.rows < begin) continue;
    const int skip = std::max(0, -direction.x), count = length_ - std::abs(direction.x);
    const double* constants = numbers_.data() + at + skip;
    if (direction.rows == 0)
      kernel.add_in_row_flows(positions, direction.x, constants, constants + length_, count, forces, window.spare());
    else
      kernel.add_row_flows(positions.from(skip), window.positions(direction.rows).from(skip + direction.x), constants,
                           constants + length_, count, forces.from(skip),
                           window.forces(direction.rows).from(skip + direction.x));
  }
}

}  // namespace elastin
