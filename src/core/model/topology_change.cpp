#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "core/model/topology_change.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// Sets of a few things that hang together.
class Groups {
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int item) {
    while (parent_[at(item)] != item) item = parent_[at(item)] = parent_[at(parent_[at(item)])];
    return item;
  }
  /// The lowest of a group stands for it.
  void join(int a, int b) {
    a = of(a), b = of(b);
    parent_[at(std::max(a, b))] = std::min(a, b);
  }

 private:
  static std::size_t at(int item) { return static_cast<std::size_t>(item); }
  std::vector<int> parent_;
};

class TopologyBuilder {
 public:
  TopologyBuilder(const Body& body, const Positions& positions, const Neighbours& cells, TopologyChange change)
      : body_(body), positions_(positions), cells_(cells), change_(std::move(change)), nodes_(cells.nodes) {}

  ChangedBody build() {
    split_molecules();
    set_connections();
    if (result_.split_molecules || result_.removed_cells || result_.removed_connections) result_.changed = true;
    if (!result_.changed) {
      result_.body = body_;
      result_.molecule_from.resize(body_.size());
      std::iota(result_.molecule_from.begin(), result_.molecule_from.end(), 0);
      return std::move(result_);
    }
    set_molecules();
    set_cells();
    set_voronoi();
    return std::move(result_);
  }

 private:
  static std::size_t at(int number) { return static_cast<std::size_t>(number); }
  bool gone(int cell) const { return change_.cells[at(cell)]; }
  int slot_of(int cell, int molecule) const {
    const auto own = cells_.cell(cell);
    return cell * cells_.of_each + static_cast<int>(std::find(own.begin(), own.end(), molecule) - own.begin());
  }

  /// Gives each cell the number of its own molecule, where one is split; new ones come last.
  void split_molecules() {
    const int n = body_.size();
    first_new_ = n;
    from_.resize(at(n));
    std::iota(from_.begin(), from_.end(), 0);
    touched_.assign(at(n), 0);
    for (std::size_t side = 0; side < cells_.sides.size(); ++side) {
      const SharedSide& shared = cells_.sides[side];
      if (gone(shared.cells[0]) || gone(shared.cells[1])) change_.split[side] = 1;
      if (!change_.split[side]) continue;
      for (const int molecule : shared.molecules)
        if (molecule >= 0) touched_[at(molecule)] = 1;
    }
    for (int cell = 0; cell < cells_.size(); ++cell) {
      if (!gone(cell)) continue;
      ++result_.removed_cells;
      for (const int molecule : cells_.cell(cell)) touched_[at(molecule)] = 1;
    }
    std::vector<int> slot, target;
    for (std::size_t side = 0; side < cells_.sides.size(); ++side)
      for (const int molecule : cells_.sides[side].molecules)
        if (molecule >= 0 && touched_[at(molecule)]) slot.push_back(static_cast<int>(side)), target.push_back(molecule);
    Rows sides_of = rows_by_target(n, target);
    for (int& entry : sides_of.entries) entry = slot[at(entry)];
    for (int molecule = 0; molecule < n; ++molecule)
      if (touched_[at(molecule)]) split(molecule, sides_of[molecule]);
    share_.resize(from_.size(), 1);
    set_shares();
  }

  /// Cells that were connected at a molecule, and no longer are by its sides, get a molecule of their own; those with
  /// the lowest cell that is left keep it.
  void split(int molecule, std::span<const int> sides) {
    const auto own = cells_.cells_of[molecule];
    const auto index = [&](int cell) {
      return static_cast<int>(std::lower_bound(own.begin(), own.end(), cell) - own.begin());
    };
    Groups before(own.size()), after(own.size());
    for (const int side : sides) {
      const auto [a, b] = cells_.sides[at(side)].cells;
      before.join(index(a), index(b));
      if (!change_.split[at(side)]) after.join(index(a), index(b));
    }
    std::map<int, int> keeps;   // the group, by that before
    std::map<int, int> number;  // of the molecule that a group has
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (gone(own[i])) continue;
      const int group = after.of(static_cast<int>(i)), whole = before.of(static_cast<int>(i));
      const auto known = number.find(group);
      if (known == number.end()) {
        const bool first = keeps.try_emplace(whole, group).second;
        number[group] = first ? molecule : static_cast<int>(from_.size());
        if (!first) from_.push_back(molecule);
      }
      nodes_[at(slot_of(own[i], molecule))] = number[group];
    }
  }

  /// By the rest volumes of their cells. Of molecules that lose nothing the one that stays has what the others leave.
  void set_shares() {
    result_.split_molecules = static_cast<int>(from_.size()) - first_new_;
    if (!result_.split_molecules && !result_.removed_cells) return;
    VectorX whole = VectorX::Zero(body_.size()), own = VectorX::Zero(static_cast<Eigen::Index>(from_.size()));
    std::vector<char> loses(at(body_.size()), 0);
    for (int cell = 0; cell < cells_.size(); ++cell)
      for (int node = 0; node < cells_.of_each; ++node) {
        const auto slot = at(cell * cells_.of_each + node);
        const int molecule = cells_.nodes[slot];
        if (!touched_[at(molecule)]) continue;
        whole[molecule] += cells_.volume[cell];
        if (gone(cell))
          loses[at(molecule)] = 1;
        else
          own[nodes_[slot]] += cells_.volume[cell];
      }
    for (std::size_t molecule = 0; molecule < from_.size(); ++molecule) {
      const int before = from_[molecule];
      if (touched_[at(before)] && whole[before] > 0)
        share_[molecule] = own[static_cast<Eigen::Index>(molecule)] / whole[before];
    }
    for (int molecule = 0; molecule < first_new_; ++molecule)
      if (touched_[at(molecule)] && !loses[at(molecule)]) share_[at(molecule)] = 1;
    for (std::size_t molecule = at(first_new_); molecule < from_.size(); ++molecule)
      if (!loses[at(from_[molecule])]) share_[at(from_[molecule])] -= share_[molecule];
  }

  struct Ends {
    std::array<int, 2> molecules;
    double volume;
  };

  void set_connections() {
    const Connections& all = body_.connections;
    for (int c = 0; c < all.size(); ++c) {
      const auto [a, b] = all.ends[at(c)];
      const bool near = touched_[at(a)] || touched_[at(b)];
      const bool crossed = change_.crosses && change_.crosses(positions_.col(a), positions_.col(b));
      const bool removed = change_.connections[at(c)];
      if (!near && !crossed && !removed) {
        keep(c, {a, b}, 1);
        continue;
      }
      bool of_cells = false;
      const std::vector<Ends> ends = ends_of(a, b, of_cells);
      if (of_cells && removed && !ends.empty())
        throw InputError("connection " + std::to_string(c) +
                         " is a side of cells that stay: remove the cells, or cut between them");
      if (removed || (of_cells ? ends.empty() : crossed)) {
        ++result_.removed_connections;
      } else if (of_cells) {
        const double volume =
            std::accumulate(ends.begin(), ends.end(), 0., [](double sum, const Ends& one) { return sum + one.volume; });
        for (const Ends& one : ends) keep(c, one.molecules, ends.size() == 1 ? 1 : one.volume / volume);
      } else {
        const Vector3 middle = (positions_.col(a) + positions_.col(b)) / 2;
        keep(c, {nearest(a, middle), nearest(b, middle)}, 1);
      }
    }
  }

  void keep(int connection, const std::array<int, 2>& ends, double share) {
    connection_ends_.push_back(ends);
    result_.connection_from.push_back(connection);
    result_.connection_share.push_back(share);
  }

  /// The pairs that two molecules have become, by the cells that have both, with those cells' volume.
  std::vector<Ends> ends_of(int a, int b, bool& of_cells) const {
    std::vector<Ends> found;
    if (cells_.of_each == 0) return found;
    for (const int cell : cells_.cells_of[a]) {
      const auto own = cells_.cell(cell);
      if (std::find(own.begin(), own.end(), b) == own.end()) continue;
      of_cells = true;
      if (gone(cell)) continue;
      const std::array<int, 2> ends{nodes_[at(slot_of(cell, a))], nodes_[at(slot_of(cell, b))]};
      const auto known =
          std::find_if(found.begin(), found.end(), [&](const Ends& one) { return one.molecules == ends; });
      if (known == found.end())
        found.push_back({ends, cells_.volume[cell]});
      else
        known->volume += cells_.volume[cell];
    }
    return found;
  }

  /// What a molecule has become on the side of a position: that of its first cell which no cut parts from there.
  int nearest(int molecule, const Vector3& position) const {
    if (cells_.of_each == 0 || !touched_[at(molecule)]) return molecule;
    for (const int cell : cells_.cells_of[molecule])
      if (!gone(cell) && !(change_.crosses && change_.crosses(cells_.middle(cell, positions_), position)))
        return nodes_[at(slot_of(cell, molecule))];
    return molecule;
  }

  /// Molecules that have lost all are left out; then everything gets its last number.
  void set_molecules() {
    std::vector<char> lost(from_.size(), 0);
    for (std::size_t molecule = 0; molecule < at(first_new_); ++molecule)
      lost[molecule] = touched_[molecule] && share_[molecule] == 0;
    for (const auto& ends : connection_ends_)
      for (const int molecule : ends)
        if (std::exchange(lost[at(molecule)], 0)) share_[at(molecule)] = 1;  // it still belongs to a spring
    number_.assign(from_.size(), -1);
    int count = 0;
    for (std::size_t molecule = 0; molecule < from_.size(); ++molecule)
      if (!lost[molecule]) {
        number_[molecule] = count++;
        result_.molecule_from.push_back(from_[molecule]);
        result_.molecule_share.push_back(share_[molecule]);
      }
    if (count == 0) throw InputError("nothing would be left of the body");
    Body& body = result_.body;
    body.rest = body_.rest(Eigen::all, result_.molecule_from);
    body.unstressed = body_.unstressed;
    body.mass = body_.mass(result_.molecule_from);
    body.radius = body_.radius(result_.molecule_from);
    for (int molecule = 0; molecule < count; ++molecule) body.mass[molecule] *= result_.molecule_share[at(molecule)];
    Connections& connections = body.connections;
    for (std::size_t c = 0; c < connection_ends_.size(); ++c) {
      const auto& [a, b] = connection_ends_[c];
      const int before = result_.connection_from[c];
      connections.ends.push_back({number_[at(a)], number_[at(b)]});
      connections.rest_length.push_back(body_.connections.rest_length[at(before)]);
      connections.cell_sides += before >= body_.connections.proper();
    }
    if (body_.connection_stiffness.size())
      body.connection_stiffness = body_.connection_stiffness(result_.connection_from);
    for (const Cable& cable : body_.cables)
      for (auto c = std::lower_bound(result_.connection_from.begin(), result_.connection_from.end(), cable.connection);
           c != result_.connection_from.end() && *c == cable.connection; ++c) {
        const auto own = static_cast<std::size_t>(c - result_.connection_from.begin());
        body.cables.push_back({static_cast<int>(own), cable.stiffness * result_.connection_share[own]});
      }
  }

  template <std::size_t corners>
  void set_own_cells(std::vector<std::array<int, corners>>& cells) const {
    for (int cell = 0; cell < cells_.size(); ++cell) {
      if (gone(cell)) continue;
      auto& own = cells.emplace_back();
      for (std::size_t node = 0; node < corners; ++node)
        own[node] = number_[at(nodes_[at(cell * cells_.of_each) + node])];
    }
  }

  void set_cells() {
    Body& body = result_.body;
    if (cells_.of_each == 4) set_own_cells(body.tetrahedra);
    if (cells_.of_each == 8) set_own_cells(body.cubes);
    if (cells_.of_each == 3) set_own_cells(body.triangles);
    if (body_.cell_stiffness.size() == cells_.size()) {
      std::vector<int> left;
      for (int cell = 0; cell < cells_.size(); ++cell)
        if (!gone(cell)) left.push_back(cell);
      body.cell_stiffness = body_.cell_stiffness(left);
    }
    if (cells_.of_each == 3) return;
    for (std::size_t number = 0; number < body_.triangles.size(); ++number) add_triangle(static_cast<int>(number));
  }

  /// A triangle next to solid cells goes with the first one that has it as a face.
  void add_triangle(int number) {
    const auto& corners = body_.triangles[at(number)];
    bool of_cell = false;
    for (const int cell : cells_.cells_of[corners[0]]) {
      const auto own = cells_.cell(cell);
      if (!std::all_of(corners.begin(), corners.end(),
                       [&](int corner) { return std::find(own.begin(), own.end(), corner) != own.end(); }))
        continue;
      of_cell = true;
      if (gone(cell)) continue;
      auto& added = result_.body.triangles.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) added[i] = number_[at(nodes_[at(slot_of(cell, corners[i]))])];
      return;
    }
    if (of_cell) return;
    if (std::any_of(corners.begin(), corners.end(), [&](int corner) { return touched_[at(corner)] != 0; }))
      throw InputError("triangle " + std::to_string(number) +
                       " is no face of a cell: where it goes when the body is split there is not known");
    auto& added = result_.body.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) added[i] = number_[at(corners[i])];
  }

  void set_voronoi() {
    if (!body_.voronoi) return;
    VoronoiCells cells = *body_.voronoi;
    const int proper = result_.body.connections.proper();
    if (cells.problem.empty()) {
      const std::vector<int> from(result_.connection_from.begin(), result_.connection_from.begin() + proper);
      cells.face_area = body_.voronoi->face_area(from);
      cells.volume = body_.voronoi->volume(result_.molecule_from);
      cells.surface_area = body_.voronoi->surface_area(Eigen::all, result_.molecule_from);
      for (int c = 0; c < proper; ++c) cells.face_area[c] *= result_.connection_share[at(c)];
      for (int molecule = 0; molecule < result_.body.size(); ++molecule)
        cells.volume[molecule] *= result_.molecule_share[at(molecule)];
    }
    result_.body.voronoi = std::move(cells);
  }

  const Body& body_;
  const Positions& positions_;
  const Neighbours& cells_;
  TopologyChange change_;
  std::vector<int> nodes_;  // of the cells, with molecules that were split off
  std::vector<int> from_;   // of each molecule, those that are gone too
  std::vector<double> share_;
  std::vector<char> touched_;  // molecules whose cells or sides of cells change
  std::vector<int> number_;    // the last ones, −1 = gone
  int first_new_ = 0;
  std::vector<std::array<int, 2>> connection_ends_;
  ChangedBody result_;
};

}  // namespace

ChangedBody changed_body(const Body& body, const Positions& positions, const Neighbours& cells, TopologyChange change) {
  return TopologyBuilder(body, positions, cells, std::move(change)).build();
}

}  // namespace elastin
