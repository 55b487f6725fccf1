#include "forces/grid_kernel.h"

#include <array>

namespace elastin {
namespace {

/// Square root and division are exactly rounded and nothing is contracted, so a lane does what a lone number would.
[[gnu::always_inline]] inline void add_flows(RowOf3 from, RowOf3 to, const double* __restrict constants,
                                             const double* __restrict rest_lengths, int count, RowOf3 on_from,
                                             RowOf3 on_to) {
  const double* __restrict ax = from.x, * __restrict ay = from.y(), * __restrict az = from.z();
  const double* __restrict bx = to.x, * __restrict by = to.y(), * __restrict bz = to.z();
  double* __restrict fx = on_from.x, * __restrict fy = on_from.y(), * __restrict fz = on_from.z();
  double* __restrict gx = on_to.x, * __restrict gy = on_to.y(), * __restrict gz = on_to.z();
  for (int i = 0; i < count; ++i) {
    const double dx = bx[i] - ax[i], dy = by[i] - ay[i], dz = bz[i] - az[i];
    const double l = __builtin_sqrt(dx * dx + dy * dy + dz * dz);
    const double tension = constants[i] * (l - rest_lengths[i]);
    const double q = l > 0 ? tension / l : 0;
    fx[i] += q * dx, fy[i] += q * dy, fz[i] += q * dz;
    gx[i] -= q * dx, gy[i] -= q * dy, gz[i] -= q * dz;
  }
}

void add_flows_plain(RowOf3 from, RowOf3 to, const double* k, const double* L, int count, RowOf3 f, RowOf3 g) {
  add_flows(from, to, k, L, count, f, g);
}

#if defined(__x86_64__) && defined(__GNUC__)
[[gnu::target("avx2")]] void add_flows_avx2(RowOf3 from, RowOf3 to, const double* k, const double* L, int count,
                                            RowOf3 f, RowOf3 g) {
  add_flows(from, to, k, L, count, f, g);
}
[[gnu::target("avx512f,avx512dq,avx512vl")]] void add_flows_avx512(RowOf3 from, RowOf3 to, const double* k,
                                                                   const double* L, int count, RowOf3 f, RowOf3 g) {
  add_flows(from, to, k, L, count, f, g);
}
#endif

struct Versions {
  std::array<AddRowFlows, 3> list{add_flows_plain};
  std::size_t count = 1;

  Versions() {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
      list[count++] = add_flows_avx512;
    if (__builtin_cpu_supports("avx2")) list[count++] = add_flows_avx2;
#endif
  }
};

}  // namespace

std::span<const AddRowFlows> row_flows() {
  static const Versions versions;
  return {versions.list.data(), versions.count};
}

}  // namespace elastin
