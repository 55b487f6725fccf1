#pragma once
#include <array>
#include <optional>
#include <vector>

#include "core/forces/spring_kernel.h"
#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// What connections between neighbours on a grid (Body::grid) have, without index arrays: those of a direction from one
/// row of molecules all lead to the same other row, so whole rows are worked on at once. Any neighbours: axes, face and
/// space diagonals, all of them or some.
///
/// On several threads each takes a run of rows and works out the connections that reach into it from before once more:
/// every molecule adds up the same forces in the same order. The bits are not those of a pass over the list of
/// connections.
class GridRows {
 public:
  /// The 13 neighbours that come later than a molecule.
  static constexpr int kDirections = 13;

  /// Numbers of `count` connections from molecules of one row to those of another, with the vectors of their ends.
  struct Row {
    int direction;
    const double* numbers;
    int count, shift;
    RowOf3 from, to, on_from, on_to;
  };

  /// False where the body is no grid, or a connection with a force is not between neighbours on it, or there twice.
  /// @param numbers of each connection, which stand `length` apart from each other
  /// @param acts acts(c) says whether connection c has a force
  /// @param set set(c, direction, numbers) sets those of connection c, which leads in this direction; false ends it all
  /// @param alike alike(one, other) says whether two rows' numbers are, so that they share them and stay in the cache
  template <class Acts, class Set, class Alike>
  bool fill(const Body& body, int numbers, const Acts& acts, const Set& set, const Alike& alike);
  int length() const { return length_; }

  /// Calls add(row) for all rows, which adds flows that follow from the molecules' vectors to both ends' forces;
  /// `overwrite`: what these were before does not count.
  template <class Add>
  void add_flows(const Positions& vectors, Positions& forces, bool overwrite, Workspace& workspace,
                 const Add& add) const;

 private:
  struct Direction {
    int x;                        ///< how far a connection's other end is along the row
    int rows;                     ///< how many rows on
    std::vector<int> numbers_at;  ///< of each row: where its numbers begin, −1 = no connections
    std::vector<double> now;      ///< of the row that is filled
    int last = -1;                ///< the last molecule there that has a connection, −1 = none
    std::vector<int> known;       ///< where different rows of this direction begin, the latest last
  };
  struct Window;

  template <class Alike>
  void finish_row(int row, const Alike& alike);
  template <class Add>
  void add_rows(int begin, int end, const Positions& vectors, Positions& forces, bool overwrite,
                Eigen::Map<VectorX> buffer, const Add& add) const;

  int length_ = 0, rows_ = 0;  ///< molecules in a row; rows
  int reach_ = 0;              ///< most rows between the ends of a connection
  std::array<Direction, kDirections> directions_;
  std::vector<double> numbers_;
};

/// The forces of springs between neighbours on a grid.
class GridSprings {
 public:
  /// None where GridRows has none.
  /// @param rest_lengths [m], one a connection
  static std::optional<GridSprings> make(const Body& body, const VectorX& constants, const double* rest_lengths);

  void add_forces(const Positions& positions, Positions& forces, Workspace& workspace) const;

 private:
  GridRows rows_;
};

/// The stiffness of unstressed springs between neighbours on a regular grid, all of a direction with one vector from
/// end to end.
class GridLinks {
 public:
  /// Whether these are such springs; @param slopes ∂q/∂s [N/m³] of each
  bool set(const Body& body, const Positions& positions, const VectorX& slopes);
  /// Overwrites the forces by its product with `motion`.
  void set_changes(const Positions& motion, Positions& forces, Workspace& workspace) const;

 private:
  GridRows rows_;
  std::array<Vector3, GridRows::kDirections> d_;
};

}  // namespace elastin
