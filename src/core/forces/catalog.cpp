#include "core/forces/load_rows.h"

namespace elastin {

const Table<LoadKind>& built_in_loads() {
  static const Table<LoadKind> table = [] {
    Table<LoadKind> rows("load");
    rows.add(gravity());
    rows.add(point());
    rows.add(pressure());
    rows.add(traction());
    rows.add(gas());
    rows.add(floor_plane());
    rows.add(air());
    rows.add(stokes_drag());
    rows.add(quadratic_drag());
    rows.add(damping());
    rows.add(cell_damping());
    rows.add(rayleigh());
    return rows;
  }();
  return table;
}

}  // namespace elastin
