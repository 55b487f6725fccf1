#include "core/forces/spring_kernel.h"

#include <cstring>

namespace elastin {
namespace {

#if defined(__clang__)
#define ELASTIN_ROWS_APART _Pragma("clang loop vectorize(assume_safety)")
#else
#define ELASTIN_ROWS_APART _Pragma("GCC ivdep")
#endif

/// Square root and division are exactly rounded and nothing is contracted, so a lane does what a lone number would.
/// A seed in single precision with Newton steps takes longer than the two on vectors of 256 bits, and half as long
/// again without vectors, as in browsers; on 512 bits it gains a seventh.
[[gnu::always_inline]] inline double density(double dx, double dy, double dz, double constant, double rest_length) {
  const double l = __builtin_sqrt(dx * dx + dy * dy + dz * dz);
  const double tension = constant * (l - rest_length);
  return l > 0 ? tension / l : 0;
}

struct Vector {
  double x, y, z;
  [[gnu::always_inline]] Vector times(double factor) const { return {x * factor, y * factor, z * factor}; }
};

/// Flows that have components along n axes alone. Adding to one end must not wait for the other: flows in one row lie
/// in `on_to` between the two.
template <int n, class Flow>
[[gnu::always_inline]] inline void add_row(const int* axes, int count, int shift, RowOf3 on_from, RowOf3 on_to,
                                           const Flow& flow) {
  double *f[n], *g[n];
  for (int k = 0; k < n; ++k) f[k] = on_from.along(axes[k]), g[k] = on_to.along(axes[k]);
  if (shift == 0) {
    ELASTIN_ROWS_APART
    for (int i = 0; i < count; ++i) {
      double own[n];
      flow(i, own);
      for (int k = 0; k < n; ++k) f[k][i] += own[k], g[k][i] -= own[k];
    }
    return;
  }
  ELASTIN_ROWS_APART
  for (int i = 0; i < count; ++i) {
    double own[n];
    flow(i, own);
    for (int k = 0; k < n; ++k) f[k][i] += own[k], g[k][i] = own[k];
  }
  for (int k = 0; k < n; ++k) f[k] += shift;
  ELASTIN_ROWS_APART
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < n; ++k) f[k][i] -= g[k][i];
}

[[gnu::always_inline]] inline void add_flows(RowOf3 from, RowOf3 to, const double* constants,
                                             const double* rest_lengths, int count, int shift, RowOf3 on_from,
                                             RowOf3 on_to) {
  constexpr int axes[] = {0, 1, 2};
  const double *ax = from.x, *ay = from.y(), *az = from.z(), *bx = to.x, *by = to.y(), *bz = to.z();
  add_row<3>(
      axes, count, shift, on_from, on_to, [&](int i, double* flow) __attribute__((always_inline)) {
        const double dx = bx[i] - ax[i], dy = by[i] - ay[i], dz = bz[i] - az[i];
        const double q = density(dx, dy, dz, constants[i], rest_lengths[i]);
        flow[0] = q * dx, flow[1] = q * dy, flow[2] = q * dz;
      });
}

template <int n>
[[gnu::always_inline]] inline void add_changes_along(const int* axes, RowOf3 from, RowOf3 to, const double* d,
                                                     const double* slopes, int count, int shift, RowOf3 on_from,
                                                     RowOf3 on_to) {
  const double *a[n], *b[n];
  double along[n];
  for (int k = 0; k < n; ++k) a[k] = from.along(axes[k]), b[k] = to.along(axes[k]), along[k] = d[axes[k]];
  add_row<n>(
      axes, count, shift, on_from, on_to, [&](int i, double* flow) __attribute__((always_inline)) {
        double change = along[0] * (a[0][i] - b[0][i]);
        for (int k = 1; k < n; ++k) change += along[k] * (a[k][i] - b[k][i]);
        const double q = slopes[i] * change;
        for (int k = 0; k < n; ++k) flow[k] = q * along[k];
      });
}

/// Connections along an axis or in a plane of two, as those of lattices, move nothing along the others.
[[gnu::always_inline]] inline void add_changes(RowOf3 from, RowOf3 to, const double* d, const double* slopes, int count,
                                               int shift, RowOf3 on_from, RowOf3 on_to) {
  int axes[3], n = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (d[axis] != 0) axes[n++] = axis;
  if (n == 3) add_changes_along<3>(axes, from, to, d, slopes, count, shift, on_from, on_to);
  if (n == 2) add_changes_along<2>(axes, from, to, d, slopes, count, shift, on_from, on_to);
  if (n == 1) add_changes_along<1>(axes, from, to, d, slopes, count, shift, on_from, on_to);
}

[[gnu::always_inline]] inline void set_force_densities(RowOf3 d, const double* constants, const double* rest_lengths,
                                                       int count, double* force_densities) {
  const double *dx = d.x, *dy = d.y(), *dz = d.z();
  ELASTIN_ROWS_APART
  for (int i = 0; i < count; ++i) force_densities[i] = density(dx[i], dy[i], dz[i], constants[i], rest_lengths[i]);
}

typedef double Pair __attribute__((vector_size(16)));  // x and y of a molecule
typedef double Four __attribute__((vector_size(32)));

template <class Vector>
[[gnu::always_inline]] inline void load(const double* from, Vector& to) {
  std::memcpy(&to, from, sizeof to);
}
[[gnu::always_inline]] inline void store(const Pair& from, double* to) { std::memcpy(to, &from, sizeof from); }

[[gnu::always_inline]] inline std::ptrdiff_t offset_of(int molecule) {
  return 3 * static_cast<std::ptrdiff_t>(molecule);
}

struct PairOfPairs {
  Four all;
  [[gnu::always_inline]] PairOfPairs(const double* one, const double* other) {
    Pair own, others;
    load(one, own), load(other, others);
    all = __builtin_shufflevector(own, others, 0, 1, 2, 3);
  }
};

using Ends = const std::array<int, 2>*;

/// Vectors of four connections.
struct FourVectors {
  Four xy_02, xy_13;  // of the connections 0 and 2, 1 and 3
  Four z;

  [[gnu::always_inline]] void set_xy(Four& x, Four& y) const {
    x = __builtin_shufflevector(xy_02, xy_13, 0, 4, 2, 6), y = __builtin_shufflevector(xy_02, xy_13, 1, 5, 3, 7);
  }
  [[gnu::always_inline]] FourVectors times(const Four& factors) const {
    return {xy_02 * __builtin_shufflevector(factors, factors, 0, 0, 2, 2),
            xy_13 * __builtin_shufflevector(factors, factors, 1, 1, 3, 3), z * factors};
  }
  [[gnu::always_inline]] FourVectors plus(const FourVectors& other) const {
    return {xy_02 + other.xy_02, xy_13 + other.xy_13, z + other.z};
  }
};

/// From the ends numbered `from` to the others.
[[gnu::always_inline]] inline FourVectors four_vectors(Ends ends, int from, const double* positions) {
  const double *a[4], *b[4];
  for (int i = 0; i < 4; ++i)
    a[i] = positions + offset_of(ends[i][from]), b[i] = positions + offset_of(ends[i][1 - from]);
  return {PairOfPairs(b[0], b[2]).all - PairOfPairs(a[0], a[2]).all,
          PairOfPairs(b[1], b[3]).all - PairOfPairs(a[1], a[3]).all,
          Four{b[0][2], b[1][2], b[2][2], b[3][2]} - Four{a[0][2], a[1][2], a[2][2], a[3][2]}};
}

[[gnu::always_inline]] inline Vector vector(const std::array<int, 2>& ends, int from, const double* positions) {
  const double *a = positions + offset_of(ends[from]), *b = positions + offset_of(ends[1 - from]);
  return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

/// Flows q d of springs on their first ends.
struct SpringFlows {
  const ListedSprings& springs;
  const double* positions;

  [[gnu::always_inline]] FourVectors four(int first) const {
    const FourVectors d = four_vectors(springs.ends + first, 0, positions);
    Four x, y;
    d.set_xy(x, y);
    const Four squares = x * x + y * y + d.z * d.z;
    double square[4], length[4];
    std::memcpy(square, &squares, sizeof squares);
    for (int i = 0; i < 4; ++i) length[i] = __builtin_sqrt(square[i]);
    Four l, k, rest;
    load(length, l), load(springs.constants + first, k), load(springs.rest_lengths + first, rest);
    return d.times(l > Four{} ? k * (l - rest) / l : Four{});
  }
  [[gnu::always_inline]] Vector one(int c) const {
    const Vector d = vector(springs.ends[c], 0, positions);
    return d.times(density(d.x, d.y, d.z, springs.constants[c], springs.rest_lengths[c]));
  }
};

/// Changes q δ + 2 ∂q/∂s (d·δ) d of linearised springs, as Tangent has them for connections that are gathered.
struct LinkFlows {
  const ListedLinks& links;
  const double *positions, *motion;

  [[gnu::always_inline]] FourVectors four(int first) const {
    const FourVectors d = four_vectors(links.ends + first, 0, positions);
    const FourVectors delta = four_vectors(links.ends + first, 1, motion);
    Four slopes, densities, x, y, delta_x, delta_y;
    load(links.slopes + first, slopes);
    d.set_xy(x, y), delta.set_xy(delta_x, delta_y);
    const FourVectors along = d.times((slopes + slopes) * (x * delta_x + y * delta_y + d.z * delta.z));
    if (!links.densities) return along;
    load(links.densities + first, densities);
    return delta.times(densities).plus(along);
  }
  [[gnu::always_inline]] Vector one(int c) const {
    const Vector d = vector(links.ends[c], 0, positions), delta = vector(links.ends[c], 1, motion);
    const Vector along = d.times(2 * links.slopes[c] * (d.x * delta.x + d.y * delta.y + d.z * delta.z));
    if (!links.densities) return along;
    const Vector across = delta.times(links.densities[c]);
    return {across.x + along.x, across.y + along.y, across.z + along.z};
  }
};

/// Adds flows to the ends of springs; the sum of a molecule with many springs in a row need not go through memory.
struct FlowSum {
  double* forces;
  int begin, end;
  int molecule = -1;
  Pair xy{};
  double z = 0;

  [[gnu::always_inline]] void add(const std::array<int, 2>& ends, const Pair& flow_xy, double flow_z) {
    if (ends[0] != molecule) {
      finish();
      molecule = ends[0];
      load(forces + offset_of(molecule), xy);
      z = forces[offset_of(molecule) + 2];
    }
    xy += flow_xy, z += flow_z;
    if (ends[1] < begin || ends[1] >= end) return;
    double* on = forces + offset_of(ends[1]);
    Pair before;
    load(on, before);
    store(before - flow_xy, on);
    on[2] -= flow_z;
  }
  [[gnu::always_inline]] void finish() {
    if (molecule < begin) return;
    store(xy, forces + offset_of(molecule));
    forces[offset_of(molecule) + 2] = z;
  }
};

/// The next four springs' roots and divisions are under way while the flows of these are added.
template <class Flows>
[[gnu::always_inline]] inline void add_listed(const Flows& flows, Ends ends, int first, int last, int begin, int end,
                                              double* forces) {
  FlowSum sum{forces, begin, end};
  int c = first;
  FourVectors now, next;
  if (c + 4 <= last) next = flows.four(c);
  while (c + 4 <= last) {
    now = next;
    if (c + 8 <= last) next = flows.four(c + 4);
    sum.add(ends[c], __builtin_shufflevector(now.xy_02, now.xy_02, 0, 1), now.z[0]);
    sum.add(ends[c + 1], __builtin_shufflevector(now.xy_13, now.xy_13, 0, 1), now.z[1]);
    sum.add(ends[c + 2], __builtin_shufflevector(now.xy_02, now.xy_02, 2, 3), now.z[2]);
    sum.add(ends[c + 3], __builtin_shufflevector(now.xy_13, now.xy_13, 2, 3), now.z[3]);
    c += 4;
  }
  for (; c < last; ++c) {
    const Vector flow = flows.one(c);
    sum.add(ends[c], Pair{flow.x, flow.y}, flow.z);
  }
  sum.finish();
}

/// The functions under a target attribute, which must come first.
#define ELASTIN_VERSION(name, ...)                                                                                  \
  struct name {                                                                                                     \
    __VA_ARGS__ static void flows(RowOf3 from, RowOf3 to, const double* k, const double* L, int count, int shift,   \
                                  RowOf3 f, RowOf3 g) {                                                             \
      add_flows(from, to, k, L, count, shift, f, g);                                                                \
    }                                                                                                               \
    __VA_ARGS__ static void changes(RowOf3 from, RowOf3 to, const double* d, const double* k, int count, int shift, \
                                    RowOf3 f, RowOf3 g) {                                                           \
      add_changes(from, to, d, k, count, shift, f, g);                                                              \
    }                                                                                                               \
    __VA_ARGS__ static void force_densities(RowOf3 d, const double* k, const double* L, int count, double* q) {     \
      set_force_densities(d, k, L, count, q);                                                                       \
    }                                                                                                               \
    __VA_ARGS__ static void listed_flows(const ListedSprings& springs, int first, int last, int begin, int end,     \
                                         const double* positions, double* forces) {                                 \
      add_listed(SpringFlows{springs, positions}, springs.ends, first, last, begin, end, forces);                   \
    }                                                                                                               \
    __VA_ARGS__ static void listed_changes(const ListedLinks& links, int first, int last, int begin, int end,       \
                                           const double* positions, const double* motion, double* forces) {         \
      add_listed(LinkFlows{links, positions, motion}, links.ends, first, last, begin, end, forces);                 \
    }                                                                                                               \
    static constexpr SpringKernel kernel{flows, changes, force_densities, listed_flows, listed_changes};            \
  };

ELASTIN_VERSION(Plain, )
#if defined(__x86_64__) && defined(__GNUC__)
#define ELASTIN_HAS_X86_VERSIONS
ELASTIN_VERSION(Avx2, [[gnu::target("avx2")]])
#endif

struct Versions {
  std::array<SpringKernel, 2> list{{Plain::kernel}};
  std::size_t count = 1;

  Versions() {
#ifdef ELASTIN_HAS_X86_VERSIONS
    // Vectors of 512 bits were slower: they divide no more numbers a cycle, and short rows fill them badly.
    if (__builtin_cpu_supports("avx2")) list[count++] = Avx2::kernel;
#endif
  }
};

}  // namespace

std::span<const SpringKernel> spring_kernels() {
  static const Versions versions;
  return {versions.list.data(), versions.count};
}

const SpringKernel& spring_kernel() {
  static const SpringKernel& best = spring_kernels().back();
  return best;
}

}  // namespace elastin
