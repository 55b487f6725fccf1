#include "core/forces/graph.h"

namespace elastin {
namespace {

/// How far connections reach beyond their first end where they ascend by it and it is the lower one; else 0.
int band_of(const Connections& connections) {
  int band = 0, last = 0;
  for (const auto& [a, b] : connections.ends) {
    if (a < last || b <= a) return 0;
    last = a;
    band = std::max(band, b - a);
  }
  return band;
}

}  // namespace

Graph::Graph(const Body& body) : connections_(body.connections), molecules_(body.size()) {
  if (size() < kParallelThreshold) return;
  // A part computes the connections that reach into it once more: worth it while they are few.
  constexpr int least_ranges = 8;
  band_ = band_of(connections_);
  if (molecules_ < least_ranges * band_) band_ = 0;
  if (band_ == 0) incident_ = connections_of_molecules(molecules_, connections_);
}

int Graph::first_of(int molecule) const {
  const auto found = std::partition_point(connections_.ends.begin(), connections_.ends.end(),
                                          [molecule](const auto& ends) { return ends[0] < molecule; });
  return static_cast<int>(found - connections_.ends.begin());
}

void Graph::add_forces(const Positions& positions, const VectorX& force_densities, Positions& forces) const {
  add_flows(forces,
            [&](int c, int a, int b) -> Vector3 { return force_densities[c] * (positions.col(b) - positions.col(a)); });
}

}  // namespace elastin
