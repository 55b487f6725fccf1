#include "elastin/core/forces/cells.h"

#include "core/model/incidence.h"
#include "core/parallel/parallel.h"

namespace elastin {

CellGraph::CellGraph(const Connections& connections, std::span<const int> nodes, int of_each)
    : sides(pairs_of(of_each)),
      slot_connection(connections_of_pairs(connections, nodes, of_each)),
      connections_(connections.size()) {
  Rows rows = rows_by_target(connections_, slot_connection);
  start = std::move(rows.start);
  slots_of = std::move(rows.entries);

  const auto count = static_cast<std::size_t>(cells()), of_cell = static_cast<std::size_t>(sides);
  highest_until_.resize(count), lowest_from_.resize(count);
  int highest = 0, lowest = connections_;
  for (std::size_t cell = 0; cell < count; ++cell) {
    for (std::size_t slot = cell * of_cell; slot < (cell + 1) * of_cell; ++slot)
      highest = std::max(highest, slot_connection[slot]);
    highest_until_[cell] = highest;
  }
  for (std::size_t cell = count; cell-- > 0;) {
    for (std::size_t slot = cell * of_cell; slot < (cell + 1) * of_cell; ++slot)
      lowest = std::min(lowest, slot_connection[slot]);
    lowest_from_[cell] = lowest;
  }
}

void CellGraph::gather(Eigen::Ref<const VectorX> slots, VectorX& force_densities) const {
  parallel_for(connections_, [&](int connection) {
    for (int at = start[connection]; at < start[connection + 1]; ++at)
      force_densities[connection] += slots[slots_of[at]];
  });
}

int CellGraph::ranges() const {
  if (detail::on_one_thread(cells())) return 1;
  constexpr double most_work = 1.25;  // times the cells; writing slots and gathering them costs a light law more
  const int count = threads();
  long long computed = 0;
  for (int number = 0; number < count; ++number) {
    const Range own = range(number, count);
    computed += own.last - own.first;
  }
  return static_cast<double>(computed) <= most_work * cells() ? count : 0;
}

CellGraph::Range CellGraph::range(int number, int of) const {
  const auto border = [&](int at) { return static_cast<int>(static_cast<long long>(connections_) * at / of); };
  const int begin = border(number), end = border(number + 1);
  const auto first = std::lower_bound(highest_until_.begin(), highest_until_.end(), begin);
  const auto last = std::lower_bound(lowest_from_.begin(), lowest_from_.end(), end);
  const int from = static_cast<int>(first - highest_until_.begin());
  return {from, std::max(from, static_cast<int>(last - lowest_from_.begin())), begin, end};
}

namespace detail {

bool on_one_thread(int cells) { return cells < kParallelThreshold || threads() == 1; }

void run_cells(int count, void* context, void (*range)(void*, int, int)) {
  if (on_one_thread(count)) return range(context, 0, count);
  run_ranges(count, context, range);
}

void run_each(int count, void* context, void (*work)(void*, int)) {
  parallel_for(
      count, [&](int number) { work(context, number); }, 1);
}

double sum_over_cells(int count, const std::function<double(int)>& term) { return ordered_sum(count, term); }

}  // namespace detail
}  // namespace elastin
