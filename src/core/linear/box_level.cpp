#include "core/linear/box_level.h"

#include <cmath>

#include "core/linear/block_inverse.h"
#include "core/parallel/parallel.h"

namespace elastin {
namespace {

/// Cost of a point's share of a pass, in connections.
constexpr int kPointThreshold = kParallelThreshold / 25;

/// The trilinear function's weight at one of the 27 points around the coarse one.
float weight_at(int code) {
  const auto [x, y, z] = around(code);
  return 1.F / static_cast<float>(1 << (std::abs(x) + std::abs(y) + std::abs(z)));
}

Eigen::Map<const Eigen::Matrix3f> as_block(const float* numbers) { return Eigen::Map<const Eigen::Matrix3f>(numbers); }

}  // namespace

BoxLevel::BoxLevel(BoxGrid grid)
    : grid_(std::move(grid)),
      rows_(grid_.points(), Row::Zero()),
      around_(grid_.points()),
      sums_(grid_.points(), Matrix3::Zero()) {
  parallel_for(
      points(),
      [&](int point) {
        const auto& [x, y, z] = grid_.at(point);
        for (int code = 0; code < BoxGrid::kAround; ++code) {
          const auto [dx, dy, dz] = around(code);
          const int other = grid_.point_at({x + dx, y + dy, z + dz});
          around_[point][code] = other < 0 ? point : other;
        }
      },
      kPointThreshold);
}

Matrix3 BoxLevel::block_to(int point, int code) const {
  const Row& row = rows_[point];
  if (code != BoxGrid::kSelf) {
    const Eigen::Matrix<float, 1, 9> numbers = row.row(code);
    return as_block(numbers.data()).cast<double>();
  }
  Matrix3 own = sum(point);
  for (int other = 0; other < BoxGrid::kAround; ++other)
    if (other != BoxGrid::kSelf) own -= block_to(point, other);
  return own;
}

void BoxLevel::finish(bool is_part) {
  parallel_for(
      points(),
      [&](int point) {
        Row& row = rows_[point];
        for (int code = 0; code < BoxGrid::kSelf; ++code) {
          const int other = around_[point][code];
          if (other == point) continue;
          const Eigen::Matrix<float, 1, 9> numbers = rows_[other].row(26 - code);
          const Eigen::Matrix3f block = as_block(numbers.data()).transpose();
          row.row(code) = Eigen::Map<const Eigen::Matrix<float, 1, 9>>(block.data());
        }
        const Eigen::Matrix3f own = sums_[point].cast<float>();
        row.row(BoxGrid::kSelf) = Eigen::Map<const Eigen::Matrix<float, 1, 9>>(own.data());
      },
      kPointThreshold);
  if (is_part) return;
  inverse_.resize(rows_.size());
  parallel_for(
      points(),
      [&](int point) {
        const Matrix3 own = block_to(point, BoxGrid::kSelf);
        inverse_[point] = positive_inverse((own + own.transpose()) / 2).cast<float>();
      },
      kPointThreshold);
  set_damping();
}

/// (A x)_i
inline Eigen::Vector3f BoxLevel::difference(const Vectors& x, int point) const {
  const Row& row = rows_[point];
  const auto& others = around_[point];
  alignas(16) float d[3][kSlots];
  const float* all = x.data();
  const float* own = all + 3 * static_cast<std::ptrdiff_t>(point);
  for (int code = 0; code < BoxGrid::kAround; ++code) {
    const float* other = all + 3 * static_cast<std::ptrdiff_t>(others[code]);
    for (int k = 0; k < 3; ++k) d[k][code] = other[k] - own[k];
  }
  for (int k = 0; k < 3; ++k) d[k][BoxGrid::kSelf] = own[k], d[k][27] = 0;
  using Column = Eigen::Map<const Eigen::Array<float, kSlots, 1>, Eigen::Aligned16>;
  const Column dx(d[0]), dy(d[1]), dz(d[2]);
  const auto sum_of = [&](int k) {
    return (row.col(k).array() * dx + row.col(3 + k).array() * dy + row.col(6 + k).array() * dz).sum();
  };
  return {sum_of(0), sum_of(1), sum_of(2)};
}

void BoxLevel::set_residual(const Vectors& b, const Vectors& x, Vectors& residual) const {
  parallel_for(
      points(), [&](int i) { residual.col(i) = b.col(i) - difference(x, i); }, kPointThreshold);
}

void BoxLevel::start(const Vectors& b, Vectors& x) const {
  parallel_for(points(), [&](int i) { x.col(i) = inverse_[i] * b.col(i); });
}

void BoxLevel::smooth(const Vectors& b, const Vectors& x, Vectors& better) const {
  parallel_for(
      points(), [&](int i) { better.col(i) = x.col(i) + inverse_[i] * (b.col(i) - difference(x, i)); },
      kPointThreshold);
}

/// ω = 4/3 over the largest eigenvalue of D⁻¹ A, found by powers of it: what is left above a quarter of the spectrum
/// falls to a third.
void BoxLevel::set_damping() {
  Vectors x(3, points()), y(3, points());
  for (int i = 0; i < points(); ++i)
    for (int k = 0; k < 3; ++k)
      x(k, i) = std::sin(1.F + 12.9898F * static_cast<float>(i % 4099) + 78.233F * static_cast<float>(k));
  double largest = 1;
  for (int step = 0; step < 8; ++step) {
    parallel_for(
        points(), [&](int i) { y.col(i) = inverse_[i] * difference(x, i); }, kPointThreshold);
    const double size =
        std::sqrt(ordered_sum(points(), [&](int i) { return static_cast<double>(y.col(i).squaredNorm()); }));
    const double before =
        std::sqrt(ordered_sum(points(), [&](int i) { return static_cast<double>(x.col(i).squaredNorm()); }));
    if (!(before > 0) || !std::isfinite(size)) break;
    largest = std::max(1., size / before);
    x = y / static_cast<float>(size);
  }
  const auto damping = static_cast<float>(4. / 3 / (1.1 * largest));
  for (auto& inverse : inverse_) inverse *= damping;
}

std::unique_ptr<BoxLevel> BoxLevel::coarser(bool is_part) const {
  auto coarse = std::make_unique<BoxLevel>(grid_.coarser());
  parallel_for(
      coarse->points(),
      [&](int point) {
        const auto& [X, Y, Z] = coarse->grid_.at(point);
        // First the rows of the points around are added up, by how far their neighbours are: 5 × 5 × 5.
        Eigen::Matrix<float, 9, 125> far = Eigen::Matrix<float, 9, 125>::Zero();
        Matrix3 sum = Matrix3::Zero();
        for (int code = 0; code < BoxGrid::kAround; ++code) {
          const auto [x, y, z] = around(code);
          const int fine = grid_.point_at({2 * X + x, 2 * Y + y, 2 * Z + z});
          if (fine < 0) continue;
          const float weight = weight_at(code);
          sum += weight * sums_[fine];
          const Eigen::Matrix3f own = block_to(fine, BoxGrid::kSelf).cast<float>();
          for (int next = 0; next < BoxGrid::kAround; ++next) {
            const auto [nx, ny, nz] = around(next);
            auto to = far.col(x + nx + 2 + 5 * (y + ny + 2) + 25 * (z + nz + 2));
            if (next == BoxGrid::kSelf)
              to += weight * Eigen::Map<const Eigen::Matrix<float, 9, 1>>(own.data());
            else
              to += weight * rows_[fine].row(next).transpose();
          }
        }
        coarse->sums_[point] = sum;
        // Then each neighbour takes its weight at what lies within reach of it.
        for (int code = BoxGrid::kSelf + 1; code < BoxGrid::kAround; ++code) {
          const auto [x, y, z] = around(code);
          Eigen::Matrix<float, 9, 1> block = Eigen::Matrix<float, 9, 1>::Zero();
          for (int near = 0; near < BoxGrid::kAround; ++near) {
            const auto [nx, ny, nz] = around(near);
            const int fx = 2 * x + nx, fy = 2 * y + ny, fz = 2 * z + nz;
            if (std::abs(fx) > 2 || std::abs(fy) > 2 || std::abs(fz) > 2) continue;
            block += weight_at(near) * far.col(fx + 2 + 5 * (fy + 2) + 25 * (fz + 2));
          }
          if (coarse->around_[point][code] != point) coarse->rows_[point].row(code) = block.transpose();
        }
      },
      kPointThreshold / 20);
  coarse->finish(is_part);
  return coarse;
}

void BoxLevel::restrict_to(const BoxLevel& coarse, const Vectors& fine, Vectors& result) const {
  parallel_for(
      coarse.points(),
      [&](int point) {
        const auto& [X, Y, Z] = coarse.grid_.at(point);
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int code = 0; code < BoxGrid::kAround; ++code) {
          const auto [x, y, z] = around(code);
          const int from = grid_.point_at({2 * X + x, 2 * Y + y, 2 * Z + z});
          if (from >= 0) sum += weight_at(code) * fine.col(from);
        }
        result.col(point) = sum;
      },
      kPointThreshold);
}

void BoxLevel::prolong_from(const BoxLevel& coarse, const Vectors& values, Vectors& fine) const {
  parallel_for(
      points(),
      [&](int point) {
        const auto& [x, y, z] = grid_.at(point);
        const float weight = 1.F / static_cast<float>(1 << (x % 2 + y % 2 + z % 2));
        for (int corner = 0; corner < BoxGrid::kCorners; ++corner) {
          const int dx = corner % 2, dy = corner / 2 % 2, dz = corner / 4;
          if ((dx && x % 2 == 0) || (dy && y % 2 == 0) || (dz && z % 2 == 0)) continue;
          const int from = coarse.grid_.point_at({x / 2 + dx, y / 2 + dy, z / 2 + dz});
          if (from >= 0) fine.col(point) += weight * values.col(from);
        }
      },
      kPointThreshold);
}

}  // namespace elastin
