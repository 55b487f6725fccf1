#include "core/model/check_indices.h"

#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

class IndexCheck {
 public:
  explicit IndexCheck(const Body& body) : body_(body) {}

  void check() const {
    const Connections& connections = body_.connections;
    same_count(connections.rest_length.size(), connections.ends.size(), "rest lengths", "connections");
    if (body_.connection_stiffness.size())
      same_count(static_cast<std::size_t>(body_.connection_stiffness.size()), connections.ends.size(),
                 "stiffnesses of connections", "connections");
    if (connections.cell_sides < 0 || connections.cell_sides > connections.size())
      throw InputError("the body's connections have " + std::to_string(connections.cell_sides) + " sides of cells of " +
                       std::to_string(connections.size()) + " in all");
    check_cells(connections.ends, "connection");
    check_cells(body_.triangles, "triangle");
    check_cells(body_.tetrahedra, "tetrahedron");
    check_cells(body_.cubes, "cube");
    for (std::size_t i = 0; i < body_.blocks.size(); ++i) check_block(body_.blocks[i], i);
    for (std::size_t i = 0; i < body_.cables.size(); ++i)
      if (const int one = body_.cables[i].connection; one < 0 || one >= connections.size())
        fail("cable", i, "connection", one, connections.size());
    for (std::size_t i = 0; i < body_.ties.size(); ++i) {
      check_molecule(body_.ties[i].molecule, "tie", i);
      for (const int corner : body_.ties[i].corners) check_molecule(corner, "tie", i);
    }
    for (std::size_t i = 0; i < body_.parts.size(); ++i) check_part(body_.parts[i], i);
    if (body_.between.size() > static_cast<std::size_t>(body_.size()))
      throw InputError("the body has " + counted(body_.size(), "molecule") + " and says of " +
                       std::to_string(body_.between.size()) + " what they lie between");
    for (std::size_t i = 0; i < body_.between.size(); ++i)
      for (const auto& [molecule, weight] : body_.between[i]) check_molecule(molecule, "molecule between others", i);
  }

 private:
  [[noreturn]] static void fail(const std::string& what, std::size_t number, const std::string& named, int index,
                                std::ptrdiff_t count) {
    throw InputError("the body's " + what + " " + std::to_string(number) + " has " + named + " " +
                     std::to_string(index) + "; there are " +
                     (count > 0 ? named + "s 0 to " + std::to_string(count - 1) : "no " + named + "s"));
  }
  static void same_count(std::size_t found, std::size_t wanted, const char* what, const char* of) {
    if (found != wanted)
      throw InputError("the body has " + std::to_string(wanted) + " " + of + " and " + std::to_string(found) + " " +
                       what);
  }
  void check_molecule(int molecule, const std::string& what, std::size_t number) const {
    if (molecule < 0 || molecule >= body_.size()) fail(what, number, "molecule", molecule, body_.size());
  }
  template <class List>
  void check_cells(const List& cells, const char* what) const {
    const auto size = static_cast<unsigned>(body_.size());
    for (std::size_t i = 0; i < cells.size(); ++i)
      for (const int molecule : cells[i])
        if (static_cast<unsigned>(molecule) >= size) check_molecule(molecule, what, i);
  }
  void check_block(const CellBlock& block, std::size_t number) const {
    if (!block.kind) throw InputError("the body's block " + std::to_string(number) + " has no kind of cells");
    const auto of_each = static_cast<std::size_t>(block.kind->nodes);
    if (block.nodes.size() % of_each)
      throw InputError("the body's block " + std::to_string(number) + " has " + std::to_string(block.nodes.size()) +
                       " nodes of cells of " + std::to_string(of_each));
    if (block.stiffness.size())
      same_count(static_cast<std::size_t>(block.stiffness.size()), static_cast<std::size_t>(block.size()),
                 "stiffnesses of them", "cells in a block");
    for (std::size_t i = 0; i < block.nodes.size(); ++i)
      if (const int node = block.nodes[i]; node < 0 || node >= body_.size())
        fail(std::string(block.kind->name), i / of_each, "molecule", node, body_.size());
  }
  template <class List>
  static void check_range(const CellRange& range, const List& list, const std::string& part, const char* what) {
    const auto count = static_cast<std::ptrdiff_t>(list.size());
    if (range.first < 0 || range.count < 0 || std::ptrdiff_t{range.first} + range.count > count)
      throw InputError("the body's part '" + part + "' has " + std::to_string(range.count) + " " + what + " from " +
                       std::to_string(range.first) + "; there are " + std::to_string(count));
  }
  void check_part(const Part& part, std::size_t number) const {
    if (part.first < 0 || part.count < 0 || std::ptrdiff_t{part.first} + part.count > body_.size())
      throw InputError("the body's part '" + part.name + "' has " + std::to_string(part.count) + " molecules from " +
                       std::to_string(part.first) + "; there are " + std::to_string(body_.size()));
    for (const int molecule : part.shared) check_molecule(molecule, "part", number);
    check_range(part.triangles, body_.triangles, part.name, "triangles");
    check_range(part.tetrahedra, body_.tetrahedra, part.name, "tetrahedra");
    check_range(part.cubes, body_.cubes, part.name, "cubes");
    check_range(part.blocks, body_.blocks, part.name, "blocks");
  }

  const Body& body_;
};

}  // namespace

void check_indices(const Body& body) { IndexCheck(body).check(); }

}  // namespace elastin
