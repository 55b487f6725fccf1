#include "core/forces/grid_springs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel/parallel.h"

namespace elastin {
namespace {

/// Lines of the grid so short count as one row with the others of their layer: few connections a row cost more than
/// those that are not there, from the end of a line to the start of the next.
constexpr int kShort = 16;

using Offset = std::array<int, 3>;
constexpr auto kOffsets = [] {
  std::array<Offset, GridRows::kDirections> offsets{};
  for (int all = 14; Offset & own : offsets) {  // of 27, of which the middle is the molecule itself
    own = {all % 3 - 1, all / 3 % 3 - 1, all / 9 - 1};
    ++all;
  }
  return offsets;
}();

/// Places are rounded, so lengths that should be alike are not quite [m], nor are constants made from them.
double length_error(const Body& body) {
  return body.size() == 0 ? 0 : 4 * std::numeric_limits<double>::epsilon() * body.rest.cwiseAbs().maxCoeff();
}

}  // namespace

/// The rows that connections join to the present one: vectors and forces of reach + 1 rows in a ring, and one row
/// more.
struct GridRows::Window {
  double* buffer;
  std::ptrdiff_t pitch;
  int slots;
  int first_slot;  // of the present row

  static std::ptrdiff_t pitch_of(int length) { return (length + 7) / 8 * 8; }
  RowOf3 at(int slot, int half) const { return {buffer + (2 * slot + half) * 3 * pitch, pitch}; }
  int slot(int rows_on) const { return first_slot + rows_on - (first_slot + rows_on >= slots ? slots : 0); }
  RowOf3 vectors(int rows_on) const { return at(slot(rows_on), 0); }
  RowOf3 forces(int rows_on) const { return at(slot(rows_on), 1); }
  RowOf3 spare() const { return at(slots, 0); }
};

/// Reads a list of connections that ascends by first ends, row after row.
template <class Acts, class Set, class Alike>
bool GridRows::fill(const Body& body, int numbers, const Acts& acts, const Set& set, const Alike& alike) {
  if (!body.grid || body.size() == 0) return false;
  const auto& counts = *body.grid;
  const auto [nx, ny, nz] = counts;
  if (static_cast<long long>(nx) * ny * nz != body.size()) return false;
  const bool layers = nx <= kShort;
  length_ = layers ? nx * ny : nx;
  rows_ = body.size() / length_;
  numbers_.clear();
  std::array<int, kDirections> apart;
  for (int direction = 0; direction < kDirections; ++direction) {
    const auto [x, y, z] = kOffsets[direction];
    Direction& own = directions_[direction];
    own.x = layers ? x + nx * y : x;
    own.rows = layers ? z : y + ny * z;
    own.numbers_at.assign(rows_, -1);
    own.now.assign(static_cast<std::size_t>(numbers) * length_, 0);
    own.last = -1;
    own.known.clear();
    apart[direction] = x + nx * (y + ny * z);
  }
  std::array<int, 3> at{};  // of the molecule `now`
  int now = 0, direction = 0;
  const auto leads_there = [&](int to) {
    if (apart[direction] != to - now) return false;
    const Offset& by = kOffsets[direction];
    for (int axis = 0; axis < 3; ++axis)
      if (const int there = at[axis] + by[axis]; there < 0 || there >= counts[axis]) return false;
    return true;
  };
  for (int c = 0; c < body.connections.size(); ++c) {
    if (!acts(c)) continue;
    const auto [a, b] = std::minmax(body.connections.ends[c][0], body.connections.ends[c][1]);
    if (a < now) return false;
    for (; now < a; ++now) {
      for (int axis = 0; ++at[axis] == counts[axis]; ++axis) at[axis] = 0;
      if ((now + 1) % length_ == 0) finish_row(now / length_, alike);
    }
    int left = kDirections;
    do {
      if (--left < 0) return false;
      direction = direction + 1 < kDirections ? direction + 1 : 0;
    } while (!leads_there(b));
    Direction& own = directions_[direction];
    if (std::exchange(own.last, a) == a) return false;
    if (!set(c, direction, own.now.data() + a % length_)) return false;
  }
  finish_row(now / length_, alike);
  reach_ = 0;
  for (const Direction& own : directions_)
    if (own.last >= 0) reach_ = std::max(reach_, own.rows);
  return true;
}

/// A lattice has a few kinds of rows (inside, on faces, on edges), a jittered body as many as rows.
template <class Alike>
void GridRows::finish_row(int row, const Alike& alike) {
  constexpr std::ptrdiff_t most = 16;
  for (Direction& own : directions_) {
    if (own.last < row * length_) continue;
    const auto begin = own.known.size() > most ? own.known.end() - most : own.known.begin();
    const auto known = std::find_if(std::make_reverse_iterator(own.known.end()), std::make_reverse_iterator(begin),
                                    [&](int at) { return alike(numbers_.data() + at, own.now.data()); });
    if (known.base() != begin) {
      own.numbers_at[row] = *known;
    } else {
      own.numbers_at[row] = static_cast<int>(numbers_.size());
      own.known.push_back(own.numbers_at[row]);
      numbers_.insert(numbers_.end(), own.now.begin(), own.now.end());
    }
    std::fill(own.now.begin(), own.now.end(), 0);
  }
}

template <class Add>
void GridRows::add_flows(const Positions& vectors, Positions& forces, bool overwrite, Workspace& workspace,
                         const Add& add) const {
  const int connections = length_ * rows_ * kDirections;
  const int ranges = connections < kParallelThreshold ? 1 : std::clamp(rows_ / (reach_ + 1), 1, threads());
  const Eigen::Index buffer = (2 * (reach_ + 1) + 1) * 3 * Window::pitch_of(length_);
  workspace.reserve_ranges(ranges);
  for (int range = 0; range < ranges; ++range) workspace.range_buffer(range, buffer);
  parallel_for(
      ranges,
      [&](int range) {
        const auto start = [&](int p) { return static_cast<int>(static_cast<long long>(rows_) * p / ranges); };
        add_rows(start(range), start(range + 1), vectors, forces, overwrite, workspace.range_buffer(range, buffer),
                 add);
      },
      2);
}

template <class Add>
void GridRows::add_rows(int begin, int end, const Positions& vectors, Positions& forces, bool overwrite,
                        Eigen::Map<VectorX> buffer, const Add& add) const {
  const int first = std::max(0, begin - reach_);
  Window window{buffer.data(), Window::pitch_of(length_), reach_ + 1, 0};
  const auto load = [&](int row, int rows_on) {
    if (row >= rows_) return;
    const double* from = vectors.data() + 3 * static_cast<std::ptrdiff_t>(row) * length_;
    const RowOf3 to = window.vectors(rows_on), zero = window.forces(rows_on);
    for (int i = 0; i < length_; ++i) to.x[i] = from[3 * i], to.y()[i] = from[3 * i + 1], to.z()[i] = from[3 * i + 2];
    std::fill_n(zero.x, 3 * zero.pitch, 0.);
  };
  for (int on = 0; on < reach_; ++on) load(first + on, on);
  for (int row = first; row < end; ++row, window.first_slot = window.slot(1)) {
    load(row + reach_, reach_);
    const RowOf3 sum = window.forces(0);
    for (int direction = 0; direction < kDirections; ++direction) {
      const Direction& own = directions_[direction];
      const int at = own.numbers_at[row];
      if (at < 0 || row + own.rows < begin) continue;
      const int skip = std::max(0, -own.x), count = length_ - std::abs(own.x);
      const bool apart = own.rows > 0;
      add(Row{direction, numbers_.data() + at + skip, count, apart ? 0 : own.x, window.vectors(0).from(skip),
              window.vectors(own.rows).from(skip + own.x), sum.from(skip),
              apart ? window.forces(own.rows).from(skip + own.x) : window.spare()});
    }
    if (row < begin) continue;
    double* to = forces.data() + 3 * static_cast<std::ptrdiff_t>(row) * length_;
    if (overwrite)
      for (int i = 0; i < length_; ++i) to[3 * i] = sum.x[i], to[3 * i + 1] = sum.y()[i], to[3 * i + 2] = sum.z()[i];
    else
      for (int i = 0; i < length_; ++i) to[3 * i] += sum.x[i], to[3 * i + 1] += sum.y()[i], to[3 * i + 2] += sum.z()[i];
  }
}

std::optional<GridSprings> GridSprings::make(const Body& body, const VectorX& constants, const double* rest_lengths) {
  GridSprings result;
  GridRows& rows = result.rows_;
  const double error = length_error(body);
  const auto alike = [&](const double* one, const double* other) {
    for (int i = 0; i < rows.length(); ++i) {
      const double length = one[rows.length() + i];
      if (std::abs(other[rows.length() + i] - length) > error) return false;
      if (std::abs(other[i] - one[i]) * length > error * std::abs(one[i])) return false;
    }
    return true;
  };
  const bool filled = rows.fill(
      body, 2, [&](int c) { return constants[c] != 0; },
      [&](int c, int, double* numbers) {
        numbers[0] = constants[c], numbers[rows.length()] = rest_lengths[c];
        return true;
      },
      alike);
  return filled ? std::optional(std::move(result)) : std::nullopt;
}

void GridSprings::add_forces(const Positions& positions, Positions& forces, Workspace& workspace) const {
  const auto add = spring_kernel().add_row_flows;
  rows_.add_flows(positions, forces, false, workspace, [&](const GridRows::Row& row) {
    add(row.from, row.to, row.numbers, row.numbers + rows_.length(), row.count, row.shift, row.on_from, row.on_to);
  });
}

bool GridLinks::set(const Body& body, const Positions& positions, const VectorX& slopes) {
  const double error = length_error(body);
  double shortest = std::numeric_limits<double>::infinity();
  std::array<bool, GridRows::kDirections> known{};
  const auto set = [&](int c, int direction, double* numbers) {
    numbers[0] = 2 * slopes[c];
    const auto [a, b] = std::minmax(body.connections.ends[c][0], body.connections.ends[c][1]);
    const Vector3 d = positions.col(b) - positions.col(a);
    if (!std::exchange(known[direction], true)) d_[direction] = d, shortest = std::min(shortest, d.norm());
    return (d - d_[direction]).cwiseAbs().maxCoeff() <= error;
  };
  const auto alike = [&](const double* one, const double* other) {
    for (int i = 0; i < rows_.length(); ++i)
      if (!(std::abs(other[i] - one[i]) * shortest <= 4 * error * std::abs(one[i]))) return false;
    return true;
  };
  return rows_.fill(
      body, 1, [&](int c) { return slopes[c] != 0; }, set, alike);
}

void GridLinks::set_changes(const Positions& motion, Positions& forces, Workspace& workspace) const {
  const auto add = spring_kernel().add_row_changes;
  rows_.add_flows(motion, forces, true, workspace, [&](const GridRows::Row& row) {
    add(row.from, row.to, d_[row.direction].data(), row.numbers, row.count, row.shift, row.on_from, row.on_to);
  });
}

}  // namespace elastin
