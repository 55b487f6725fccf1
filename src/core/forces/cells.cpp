#include "elastin/core/forces/cells.h"

#include "core/model/incidence.h"
#include "core/parallel/parallel.h"

namespace elastin {

CellGraph::CellGraph(const Body& body, int corners) : sides(connections_of_cell(corners)) {
  const auto append = [&](const auto& cells) {
    for (const auto& cell : cells) slot_connection.insert(slot_connection.end(), cell.begin(), cell.end());
  };
  if (corners == 3) append(connections_of_each_cell<3>(body.connections, body.triangles));
  if (corners == 4) append(connections_of_each_cell<4>(body.connections, body.tetrahedra));
  set_slots(body.connections.size());
}

CellGraph::CellGraph(const Connections& connections, const Cells<4>& tetrahedra) : sides(6) {
  for (const auto& cell : connections_of_each_cell<4>(connections, tetrahedra))
    slot_connection.insert(slot_connection.end(), cell.begin(), cell.end());
  set_slots(connections.size());
}

void CellGraph::set_slots(int connections) {
  connections_ = connections;
  Rows rows = rows_by_target(connections_, slot_connection);
  start = std::move(rows.start);
  slots_of = std::move(rows.entries);
}

void CellGraph::gather(Eigen::Ref<const VectorX> slots, VectorX& force_densities) const {
  parallel_for(connections_, [&](int connection) {
    for (int at = start[connection]; at < start[connection + 1]; ++at)
      force_densities[connection] += slots[slots_of[at]];
  });
}

namespace detail {

bool on_one_thread(int cells) { return cells < kParallelThreshold || threads() == 1; }

void run_cells(int count, void* context, void (*range)(void*, int, int)) {
  if (on_one_thread(count)) return range(context, 0, count);
  run_ranges(count, context, range);
}

double sum_over_cells(int count, const std::function<double(int)>& term) { return ordered_sum(count, term); }

}  // namespace detail
}  // namespace elastin
