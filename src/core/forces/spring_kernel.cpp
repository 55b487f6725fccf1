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

[[gnu::always_inline]] inline void add_flows(RowOf3 from, RowOf3 to, const double* constants,
                                             const double* rest_lengths, int count, RowOf3 on_from, RowOf3 on_to) {
  const double *ax = from.x, *ay = from.y(), *az = from.z(), *bx = to.x, *by = to.y(), *bz = to.z();
  double *fx = on_from.x, *fy = on_from.y(), *fz = on_from.z(), *gx = on_to.x, *gy = on_to.y(), *gz = on_to.z();
  ELASTIN_ROWS_APART
  for (int i = 0; i < count; ++i) {
    const double dx = bx[i] - ax[i], dy = by[i] - ay[i], dz = bz[i] - az[i];
    const double q = density(dx, dy, dz, constants[i], rest_lengths[i]);
    fx[i] += q * dx, fy[i] += q * dy, fz[i] += q * dz;
    gx[i] -= q * dx, gy[i] -= q * dy, gz[i] -= q * dz;
  }
}

/// Adding to one end must not wait for the other, so that the flows lie between the two.
[[gnu::always_inline]] inline void add_in_row(RowOf3 positions, int apart, const double* constants,
                                              const double* rest_lengths, int count, RowOf3 on, RowOf3 spare) {
  const double *ax = positions.x, *ay = positions.y(), *az = positions.z(), *bx = ax + apart, *by = ay + apart,
               *bz = az + apart;
  double *fx = on.x, *fy = on.y(), *fz = on.z(), *gx = spare.x, *gy = spare.y(), *gz = spare.z();
  ELASTIN_ROWS_APART
  for (int i = 0; i < count; ++i) {
    const double dx = bx[i] - ax[i], dy = by[i] - ay[i], dz = bz[i] - az[i];
    const double q = density(dx, dy, dz, constants[i], rest_lengths[i]);
    gx[i] = q * dx, gy[i] = q * dy, gz[i] = q * dz;
    fx[i] += q * dx, fy[i] += q * dy, fz[i] += q * dz;
  }
  fx += apart, fy += apart, fz += apart;
  ELASTIN_ROWS_APART
  for (int i = 0; i < count; ++i) fx[i] -= gx[i], fy[i] -= gy[i], fz[i] -= gz[i];
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

/// The vectors of four springs from end to end, and their force densities.
struct FourSprings {
  Four xy_02, xy_13;  // of the springs 0 and 2, 1 and 3
  Four z, force_densities;

  [[gnu::always_inline]] void set(const ListedSprings& springs, int first, const double* positions) {
    const double *a[4], *b[4];
    for (int i = 0; i < 4; ++i)
      a[i] = positions + offset_of(springs.ends[first + i][0]),
      b[i] = positions + offset_of(springs.ends[first + i][1]);
    xy_02 = PairOfPairs(b[0], b[2]).all - PairOfPairs(a[0], a[2]).all;
    xy_13 = PairOfPairs(b[1], b[3]).all - PairOfPairs(a[1], a[3]).all;
    z = Four{b[0][2], b[1][2], b[2][2], b[3][2]} - Four{a[0][2], a[1][2], a[2][2], a[3][2]};
    const Four x = __builtin_shufflevector(xy_02, xy_13, 0, 4, 2, 6),
               y = __builtin_shufflevector(xy_02, xy_13, 1, 5, 3, 7);
    const Four squares = x * x + y * y + z * z;
    double square[4], length[4];
    std::memcpy(square, &squares, sizeof squares);
    for (int i = 0; i < 4; ++i) length[i] = __builtin_sqrt(square[i]);
    Four l, k, rest;
    load(length, l), load(springs.constants + first, k), load(springs.rest_lengths + first, rest);
    force_densities = l > Four{} ? k * (l - rest) / l : Four{};
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
[[gnu::always_inline]] inline void add_listed(const ListedSprings& springs, int first, int last, int begin, int end,
                                              const double* positions, double* forces) {
  FlowSum sum{forces, begin, end};
  int c = first;
  FourSprings now, next;
  if (c + 4 <= last) next.set(springs, c, positions);
  while (c + 4 <= last) {
    now = next;
    if (c + 8 <= last) next.set(springs, c + 4, positions);
    const Four& q = now.force_densities;
    const Four flow_02 = now.xy_02 * __builtin_shufflevector(q, q, 0, 0, 2, 2);
    const Four flow_13 = now.xy_13 * __builtin_shufflevector(q, q, 1, 1, 3, 3), flow_z = q * now.z;
    sum.add(springs.ends[c], __builtin_shufflevector(flow_02, flow_02, 0, 1), flow_z[0]);
    sum.add(springs.ends[c + 1], __builtin_shufflevector(flow_13, flow_13, 0, 1), flow_z[1]);
    sum.add(springs.ends[c + 2], __builtin_shufflevector(flow_02, flow_02, 2, 3), flow_z[2]);
    sum.add(springs.ends[c + 3], __builtin_shufflevector(flow_13, flow_13, 2, 3), flow_z[3]);
    c += 4;
  }
  for (; c < last; ++c) {
    const double *a = positions + offset_of(springs.ends[c][0]), *b = positions + offset_of(springs.ends[c][1]);
    const double dx = b[0] - a[0], dy = b[1] - a[1], dz = b[2] - a[2];
    const double q = density(dx, dy, dz, springs.constants[c], springs.rest_lengths[c]);
    sum.add(springs.ends[c], Pair{q * dx, q * dy}, q * dz);
  }
  sum.finish();
}

/// The functions under a target attribute, which must come first.
#define ELASTIN_VERSION(name, ...)                                                                               \
  struct name {                                                                                                  \
    __VA_ARGS__ static void flows(RowOf3 from, RowOf3 to, const double* k, const double* L, int count, RowOf3 f, \
                                  RowOf3 g) {                                                                    \
      add_flows(from, to, k, L, count, f, g);                                                                    \
    }                                                                                                            \
    __VA_ARGS__ static void in_row(RowOf3 positions, int apart, const double* k, const double* L, int count,     \
                                   RowOf3 on, RowOf3 spare) {                                                    \
      add_in_row(positions, apart, k, L, count, on, spare);                                                      \
    }                                                                                                            \
    __VA_ARGS__ static void force_densities(RowOf3 d, const double* k, const double* L, int count, double* q) {  \
      set_force_densities(d, k, L, count, q);                                                                    \
    }                                                                                                            \
    __VA_ARGS__ static void listed_flows(const ListedSprings& springs, int first, int last, int begin, int end,  \
                                         const double* positions, double* forces) {                              \
      add_listed(springs, first, last, begin, end, positions, forces);                                           \
    }                                                                                                            \
    static constexpr SpringKernel kernel{flows, in_row, force_densities, listed_flows};                          \
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
