#include "elastin/core/model/topology.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/model/topology_change.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

void require_plain(const Body& body, const char* what) {
  if (!body.parts.empty() || !body.ties.empty())
    throw InputError(std::string(what) + ": a body of several parts cannot change its topology; it has " +
                     std::to_string(body.parts.size()) + " parts");
  if (!body.blocks.empty())
    throw InputError(std::string(what) + ": cells of other shapes or of second order (here " +
                     std::string(body.blocks.front().kind->name) +
                     ") cannot be split; tetrahedra, cubes of a lattice and triangles can");
}

TopologyChange no_change(const Body& body, const Neighbours& cells) {
  return {std::vector<char>(cells.sides.size(), 0),
          std::vector<char>(cells.size(), 0),
          std::vector<char>(body.connections.size(), 0),
          {}};
}

void require_positions(const Body& body, const Positions& positions) {
  if (positions.cols() != body.size() || !positions.allFinite())
    throw InputError("the positions must be " + std::to_string(body.size()) + " finite ones, one a molecule");
}

/// Parts the cells on both sides of the plane across the largest stretch of a molecule, if that is large enough.
class CellTear {
 public:
  CellTear(const Body& body, const Positions& positions, const Neighbours& cells)
      : positions_(positions), cells_(cells) {
    stretch_ = VectorX::Zero(body.size());
    direction_.setZero(3, body.size());
    std::vector<Matrix3> of_cell(cells.size());
    for (int cell = 0; cell < cells.size(); ++cell) of_cell[cell] = cells.deformation(cell, body.rest, positions);
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      Matrix3 sum = Matrix3::Zero();
      double volume = 0;
      for (const int cell : cells.cells_of[molecule]) {
        sum += cells.volume[cell] * of_cell[cell];
        volume += cells.volume[cell];
      }
      if (!(volume > 0)) continue;
      const Matrix3 mean = sum / volume;
      const Eigen::SelfAdjointEigenSolver<Matrix3> principal(mean * mean.transpose());
      direction_.col(molecule) = principal.eigenvectors().col(2);
      if (has_both_sides(molecule)) stretch_[molecule] = std::sqrt(std::max(0., principal.eigenvalues()[2]));
    }
    largest_.assign(body.size(), 1);
    for (const auto& [a, b] : body.connections.ends) {
      const bool second = stretch_[b] > stretch_[a] || (stretch_[b] == stretch_[a] && b < a);
      largest_[second ? a : b] = 0;
    }
  }

  bool parts(const SharedSide& side, double strain) const {
    for (const int molecule : side.molecules) {
      if (molecule < 0 || !largest_[molecule] || !(stretch_[molecule] > 1 + strain)) continue;
      if (ahead(molecule, side.cells[0]) != ahead(molecule, side.cells[1])) return true;
    }
    return false;
  }

 private:
  bool ahead(int molecule, int cell) const {
    return direction_.col(molecule).dot(cells_.middle(cell, positions_) - positions_.col(molecule)) >= 0;
  }
  /// Nothing can open at an end that its cells lie to one side of.
  bool has_both_sides(int molecule) const {
    const auto own = cells_.cells_of[molecule];
    return std::any_of(own.begin(), own.end(),
                       [&](int cell) { return ahead(molecule, cell) != ahead(molecule, own[0]); });
  }

  const Positions& positions_;
  const Neighbours& cells_;
  VectorX stretch_;      // the largest principal one
  Positions direction_;  // where it points now
  std::vector<char> largest_;
};

}  // namespace

ChangedBody cut(const Body& body, const Positions& positions, const CutSurface& surface) {
  require_plain(body, "cut");
  require_positions(body, positions);
  const Neighbours cells(body);
  TopologyChange change = no_change(body, cells);
  change.crosses = [&surface](const Vector3& from, const Vector3& to) { return surface.crosses(from, to); };
  Positions middles(3, cells.size());
  for (int cell = 0; cell < cells.size(); ++cell) middles.col(cell) = cells.middle(cell, positions);
  for (std::size_t side = 0; side < cells.sides.size(); ++side) {
    const auto [a, b] = cells.sides[side].cells;
    change.split[side] = surface.crosses(middles.col(a), middles.col(b));
  }
  return changed_body(body, positions, cells, std::move(change));
}

ChangedBody tear(const Body& body, const Positions& positions, double strain) {
  require_plain(body, "tear");
  require_positions(body, positions);
  if (!(strain > 0)) throw InputError("tear: a strain of " + number(strain) + " is out of range: above 0");
  const Neighbours cells(body);
  TopologyChange change = no_change(body, cells);
  if (cells.of_each == 0) {
    for (int c = 0; c < body.connections.proper(); ++c) {
      const auto& [a, b] = body.connections.ends[c];
      const double rest = body.connections.rest_length[c];
      change.connections[c] = (positions.col(b) - positions.col(a)).norm() > (1 + strain) * rest;
    }
  } else {
    const CellTear crack(body, positions, cells);
    for (std::size_t side = 0; side < cells.sides.size(); ++side)
      change.split[side] = crack.parts(cells.sides[side], strain);
  }
  return changed_body(body, positions, cells, std::move(change));
}

ChangedBody without(const Body& body, const std::vector<int>& connections, const std::vector<int>& cells) {
  require_plain(body, "remove");
  const Neighbours neighbours(body);
  TopologyChange change = no_change(body, neighbours);
  const auto mark = [](const std::vector<int>& numbers, std::vector<char>& marks, const char* what) {
    for (const int one : numbers) {
      if (one < 0 || static_cast<std::size_t>(one) >= marks.size())
        throw InputError(std::string("remove: no ") + what + " " + std::to_string(one) + ": there are " +
                         std::to_string(marks.size()) + ", from 0");
      marks[one] = 1;
    }
  };
  mark(connections, change.connections, "connection");
  mark(cells, change.cells, "cell");
  return changed_body(body, body.rest, neighbours, std::move(change));
}

}  // namespace elastin
