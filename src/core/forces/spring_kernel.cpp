#include "core/forces/spring_kernel.h"

#include <array>

namespace elastin {
namespace {

#if defined(__clang__)
#define ELASTIN_ROWS_APART _Pragma("clang loop vectorize(assume_safety)")
#else
#define ELASTIN_ROWS_APART _Pragma("GCC ivdep")
#endif

/// Square root and division are exactly rounded and nothing is contracted, so a lane does what a lone number would.
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
  };

ELASTIN_VERSION(Plain, )
#if defined(__x86_64__) && defined(__GNUC__)
#define ELASTIN_HAS_X86_VERSIONS
ELASTIN_VERSION(Avx2, [[gnu::target("avx2")]])
#endif

struct Versions {
  std::array<SpringKernel, 2> list{{{Plain::flows, Plain::in_row, Plain::force_densities}}};
  std::size_t count = 1;

  Versions() {
#ifdef ELASTIN_HAS_X86_VERSIONS
    // Vectors of 512 bits were slower: they divide no more numbers a cycle, and short rows fill them badly.
    if (__builtin_cpu_supports("avx2")) list[count++] = {Avx2::flows, Avx2::in_row, Avx2::force_densities};
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
