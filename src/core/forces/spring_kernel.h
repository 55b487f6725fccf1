#pragma once
#include <array>
#include <cstddef>
#include <span>

namespace elastin {

/// One vector of each molecule of a row of a grid: all x, then all y, then all z, each `pitch` numbers after the other.
struct RowOf3 {
  double* x;
  std::ptrdiff_t pitch;
  double* along(int axis) const { return x + axis * pitch; }
  double* y() const { return along(1); }
  double* z() const { return along(2); }
  RowOf3 from(int molecule) const { return {x + molecule, pitch}; }
};

/// Springs from each of `count` molecules to its partner in another row: adds q d to on_from and −q d to on_to, with
/// d = to − from, q = k (|d| − L)/|d|, 0 where |d| = 0. The four rows must not overlap.
/// @param shift ≠ 0: both ends are in one row, that far apart; then `on_to` is a workspace, and −q d is added to
/// on_from.from(shift) behind all q d.
using AddRowFlows = void (*)(RowOf3 from, RowOf3 to, const double* constants, const double* rest_lengths, int count,
                             int shift, RowOf3 on_from, RowOf3 on_to);

/// As AddRowFlows of 2 ∂q/∂s (d·δ) d, δ being a molecule's motion [m] less its partner's: of unstressed springs that
/// all have the vector d from end to end.
/// @param slopes 2 ∂q/∂s [N/m³]
using AddRowChanges = void (*)(RowOf3 from, RowOf3 to, const double* d, const double* slopes, int count, int shift,
                               RowOf3 on_from, RowOf3 on_to);

/// Force densities q of `count` springs of vectors d from end to end.
using SetSpringForceDensities = void (*)(RowOf3 d, const double* constants, const double* rest_lengths, int count,
                                         double* force_densities);

/// Springs between any molecules.
struct ListedSprings {
  const std::array<int, 2>* ends;
  const double *constants, *rest_lengths;
};
/// Adds the forces of the springs first … last−1 to those of their ends that are in begin … end−1; the first end of
/// each must be below `end`. A molecule meets its springs in the order of the list. Positions and forces stand molecule
/// by molecule and must not overlap.
using AddListedFlows = void (*)(const ListedSprings& springs, int first, int last, int begin, int end,
                                const double* positions, double* forces);

/// Linearised springs between any molecules: ∂q/∂s [N/m³] of each, and its force density [N/m] unless null.
struct ListedLinks {
  const std::array<int, 2>* ends;
  const double *slopes, *densities;
};
/// As AddListedFlows of q δ + 2 ∂q/∂s (d·δ) d, with d from the first end to the second and δ the first's motion less
/// the second's: adds the product of their stiffness with `motion` [m] to `forces`.
using AddListedChanges = void (*)(const ListedLinks& links, int first, int last, int begin, int end,
                                  const double* positions, const double* motion, double* forces);

/// The same functions for each vector width that this processor has, the best one last. All give bitwise identical
/// results.
struct SpringKernel {
  AddRowFlows add_row_flows;
  AddRowChanges add_row_changes;
  SetSpringForceDensities set_force_densities;
  AddListedFlows add_listed_flows;
  AddListedChanges add_listed_changes;
};
std::span<const SpringKernel> spring_kernels();
/// The best one.
const SpringKernel& spring_kernel();

}  // namespace elastin
