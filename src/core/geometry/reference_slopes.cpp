#include "core/geometry/reference_slopes.h"

namespace elastin {
namespace {

/// Vectors at 3 × 3 × 3 places, x first.
using Places = std::array<std::array<double, 3>, 27>;
using Factors = std::array<std::array<double, 3>, 3>;

/// to(…, i, …) (+)= Σ_k factors(i, k) from(…, k, …) along one axis; `across` turns i and k round.
template <int axis, bool across, bool add>
inline void multiply(const Factors& factors, const Places& from, Places& to) {
  constexpr std::size_t step = axis == 0 ? 1 : axis == 1 ? 3 : 9, next = step == 9 ? 1 : 3 * step;
  constexpr std::size_t rows = 9 / (step == 9 ? 9 : step), run = step == 9 ? 9 : step;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t at = row * next, end = at + run; at < end; ++at)
      for (std::size_t i = 0; i < 3; ++i) {
        const double f0 = across ? factors[0][i] : factors[i][0], f1 = across ? factors[1][i] : factors[i][1],
                     f2 = across ? factors[2][i] : factors[i][2];
        for (std::size_t c = 0; c < 3; ++c) {
          const double sum = f0 * from[at][c] + f1 * from[at + step][c] + f2 * from[at + 2 * step][c];
          double& target = to[at + i * step][c];
          target = add ? target + sum : sum;
        }
      }
}

}  // namespace

template <int d>
ReferenceSlopes<d>::ReferenceSlopes(const CellKind& kind) : kind_(kind), points_(static_cast<int>(kind.slopes.size())) {
  if (d != 3 || kind.nodes != 27) return;
  nodes_.resize(27);
  for (int a = 0; a < 27; ++a) {
    const Eigen::Vector3i at = (kind.reference.col(a).array() + 1).round().template cast<int>();
    nodes_[at[0] + 3 * at[1] + 9 * at[2]] = a;
  }
  // Of the nodes on the x axis at the points on it: along y and z the functions of one coordinate are the same.
  for (int g = 0; g < 3; ++g) {
    const double x = kind.points(0, g);
    const auto at = static_cast<std::size_t>(g);
    values_[at] = {x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2};
    slopes_[at] = {x - 0.5, -2 * x, x + 0.5};
  }
}

template <int d>
void ReferenceSlopes<d>::gradients(const NodeVectors& values, PointGradients<d>& at_points) const {
  if (!nodes_.empty()) return gradients_by_products(values, at_points);
  for (int g = 0; g < points_; ++g) {
    const double* slopes = kind_.slopes[g].data();
    const double* v = values.data();
    auto& sum = at_points[g];
    sum.setZero();
    for (int a = 0; a < kind_.nodes; ++a, v += 3, slopes += d)
      for (int i = 0; i < d; ++i)
        for (int k = 0; k < 3; ++k) sum(k, i) += v[k] * slopes[i];
  }
}

template <int d>
void ReferenceSlopes<d>::spread(const PointGradients<d>& at_points, NodeVectors& own) const {
  if (!nodes_.empty()) return spread_by_products(at_points, own);
  for (int g = 0; g < points_; ++g) {
    const auto& of_reference = at_points[g];
    const double* slopes = kind_.slopes[g].data();
    double* v = own.data();
    for (int a = 0; a < kind_.nodes; ++a, v += 3, slopes += d)
      for (int i = 0; i < d; ++i)
        for (int k = 0; k < 3; ++k) v[k] += of_reference(k, i) * slopes[i];
  }
}

template <int d>
void ReferenceSlopes<d>::gradients_by_products(const NodeVectors& values, PointGradients<d>& at_points) const {
  if constexpr (d == 3) {
    Places v, by_z, of_z, by_y, of_zy, of_y;
    for (std::size_t at = 0; at < 27; ++at)
      for (int k = 0; k < 3; ++k) v[at][k] = values(k, nodes_[at]);
    multiply<2, false, false>(values_, v, of_z);
    multiply<2, false, false>(slopes_, v, by_z);
    multiply<1, false, false>(values_, of_z, of_zy);
    multiply<1, false, false>(slopes_, of_z, by_y);
    multiply<1, false, false>(values_, by_z, of_y);
    Places slopes[3];
    multiply<0, false, false>(slopes_, of_zy, slopes[0]);
    multiply<0, false, false>(values_, by_y, slopes[1]);
    multiply<0, false, false>(values_, of_y, slopes[2]);
    for (std::size_t g = 0; g < 27; ++g)
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) at_points[g](k, i) = slopes[i][g][k];
  }
}

template <int d>
void ReferenceSlopes<d>::spread_by_products(const PointGradients<d>& at_points, NodeVectors& own) const {
  if constexpr (d == 3) {
    Places slopes[3], by_x, of_xy, of_x, of_y, sum;
    for (std::size_t g = 0; g < 27; ++g)
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) slopes[i][g][k] = at_points[g](k, i);
    multiply<0, true, false>(slopes_, slopes[0], by_x);
    multiply<0, true, false>(values_, slopes[1], of_x);
    multiply<0, true, false>(values_, slopes[2], of_y);
    multiply<1, true, false>(values_, by_x, of_xy);
    multiply<1, true, true>(slopes_, of_x, of_xy);
    multiply<1, true, false>(values_, of_y, of_x);
    multiply<2, true, false>(values_, of_xy, sum);
    multiply<2, true, true>(slopes_, of_x, sum);
    for (std::size_t at = 0; at < 27; ++at)
      for (int k = 0; k < 3; ++k) own(k, nodes_[at]) += sum[at][k];
  }
}

template class ReferenceSlopes<2>;
template class ReferenceSlopes<3>;

}  // namespace elastin
