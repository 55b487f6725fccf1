#include "febio/mesh.h"

#include <algorithm>
#include <set>

#include "lab/export/formats.h"

namespace elastin::febio {

using lab::FebioShape;

namespace {

const std::vector<FebioShape>& face_shapes() {
  static const std::vector<FebioShape> shapes{{"quad4", "quadrilateral4"},
                                              {"quad8", "quadrilateral8"},
                                              {"quad9", "quadrilateral9"},
                                              {"tri3", "triangle3"},
                                              {"tri6", "triangle6"}};
  return shapes;
}

const FebioShape& find_shape(const Element& element, const std::string& type, const std::vector<FebioShape>& shapes) {
  std::vector<std::string> names;
  for (const FebioShape& shape : shapes) {
    if (type == shape.febio) return shape;
    names.emplace_back(shape.febio);
  }
  element.fail("the shape \"" + type + "\" is not supported" + suggestion(type, names));
}

/// FEBio's numbers to those of the shape.
std::vector<int> in_order(const std::vector<int>& nodes, const FebioShape& shape) {
  if (shape.order.empty()) return nodes;
  std::vector<int> result(nodes.size());
  for (std::size_t a = 0; a < nodes.size(); ++a) result[shape.order[a]] = nodes[a];
  return result;
}

}  // namespace

MeshReader::MeshReader(const Element& mesh) {
  mesh.allow(
      {"Nodes", "Elements", "NodeSet", "ElementSet", "Edge", "Surface", "DiscreteSet", "SurfacePair", "PartList"});
  mesh.allow_attributes({});
  mesh.refuse_twice("name");
  for (const Element& child : mesh.children()) {
    const std::string kind = child.name();
    if (kind == "Nodes") read_nodes(child);
    if (kind == "Elements") read_cells(child);
    if (kind == "NodeSet") node_sets_[child.needed_attribute("name")] = child.integers();
    if (kind == "ElementSet") element_sets_[child.needed_attribute("name")] = child.integers();
    if (kind == "Edge")
      for (const Element& edge : child.children()) {
        Numbers& all = edges_[child.needed_attribute("name")];
        const Numbers own = edge.integers();
        if (edge.name() != "line2" || own.size() != 2) edge.refuse("an edge other than a line2 of two nodes");
        all.insert(all.end(), own.begin(), own.end());
      }
    if (kind == "Surface")
      for (const Element& face : child.children()) {
        const FebioShape& shape = find_shape(face, face.name(), face_shapes());
        Facet facet{&cell_kind(shape.name), face.integers()};
        if (static_cast<int>(facet.nodes.size()) != facet.kind->nodes)
          face.fail("needs " + std::to_string(facet.kind->nodes) + " nodes, not " + std::to_string(facet.nodes.size()));
        surfaces_[child.needed_attribute("name")].push_back(std::move(facet));
      }
    if (kind == "DiscreteSet")
      for (const Element& one : child.children()) {
        const Numbers ends = one.integers();
        if (ends.size() != 2) one.fail("needs two nodes");
        discrete_sets_[child.needed_attribute("name")].push_back({ends[0], ends[1]});
      }
  }
  if (domains_.empty()) mesh.fail("<Elements> is missing");
  use_nodes();
}

void MeshReader::read_nodes(const Element& nodes) {
  nodes.allow({"node"});
  Numbers own;
  for (const Element& node : nodes.children()) {
    const std::vector<double> place = node.numbers(3);
    own.push_back(node.whole_attribute("id"));
    if (!places_.emplace(own.back(), Vector3(place[0], place[1], place[2])).second)
      node.fail("there is a node " + std::to_string(own.back()) + " already");
  }
  if (!nodes.attribute("name").empty()) node_sets_[nodes.attribute("name")] = std::move(own);
}

void MeshReader::read_cells(const Element& cells) {
  cells.allow({"elem"});
  const FebioShape& shape = find_shape(cells, cells.needed_attribute("type"), lab::febio_solids());
  const CellKind& kind = cell_kind(shape.name);
  const std::string name = cells.needed_attribute("name");
  Numbers all, ids;
  for (const Element& cell : cells.children()) {
    Numbers nodes = cell.integers();
    if (static_cast<int>(nodes.size()) != kind.nodes)
      cell.fail("needs " + std::to_string(kind.nodes) + " nodes, not " + std::to_string(nodes.size()));
    for (const int node : nodes)
      if (!places_.contains(node)) cell.fail("there is no node " + std::to_string(node));
    nodes = in_order(nodes, shape);
    all.insert(all.end(), nodes.begin(), nodes.end());
    ids.push_back(cell.whole_attribute("id"));
    if (!cells_.emplace(ids.back(), std::move(nodes)).second)
      cell.fail("there is an element " + std::to_string(ids.back()) + " already");
  }
  if (all.empty()) cells.fail("has no cells");
  domains_.push_back({name, shape.febio, static_cast<int>(kinds_.size())});
  element_sets_.emplace(name, std::move(ids));
  block_nodes_.push_back(std::move(all));
  kinds_.push_back(&kind);
}

void MeshReader::use_nodes() {
  std::set<int> used;
  for (const Numbers& nodes : block_nodes_) used.insert(nodes.begin(), nodes.end());
  for (const auto& [name, ends] : discrete_sets_)
    for (const auto& pair : ends) used.insert(pair.begin(), pair.end());
  std::vector<Vector3> places;
  for (const auto& [node, place] : places_) {
    if (!used.contains(node)) continue;
    molecules_[node] = static_cast<int>(places.size());
    places.push_back(place);
  }
  body_.rest.resize(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t a = 0; a < places.size(); ++a) body_.rest.col(static_cast<Eigen::Index>(a)) = places[a];
  for (std::size_t block = 0; block < kinds_.size(); ++block) {
    CellBlock own{kinds_[block], {}, {}};
    for (const int node : block_nodes_[block]) own.nodes.push_back(molecules_.at(node));
    body_.blocks.push_back(std::move(own));
  }
}

int MeshReader::molecule(const Element& owner, int node) const {
  const auto found = molecules_.find(node);
  if (found == molecules_.end())
    owner.fail(places_.contains(node) ? "node " + std::to_string(node) + " belongs to no cell and no spring"
                                      : "there is no node " + std::to_string(node));
  return found->second;
}

const MeshReader::Numbers& MeshReader::numbers(const Element& owner, const std::map<std::string, Numbers>& sets,
                                               const std::string& name, const char* what) const {
  const auto found = sets.find(name);
  if (found != sets.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, values] : sets) names.push_back(known);
  owner.fail(std::string("there is no ") + what + " '" + name + "'" + (names.empty() ? "" : suggestion(name, names)));
}

MeshReader::Numbers MeshReader::nodes_of(const Element& owner, const std::string& name) const {
  const std::size_t colon = name.find(':');
  if (name.empty() || name.front() != '@' || colon == std::string::npos)
    return numbers(owner, node_sets_, name, "NodeSet");
  const std::string kind = name.substr(1, colon - 1), own = name.substr(colon + 1);
  Numbers nodes;
  const auto add = [&](const Numbers& more) { nodes.insert(nodes.end(), more.begin(), more.end()); };
  if (kind == "surface") {
    const auto found = surfaces_.find(own);
    if (found == surfaces_.end()) owner.fail("there is no Surface '" + own + "'");
    for (const Facet& facet : found->second) add(facet.nodes);
  } else if (kind == "elem_set") {
    for (const int cell : numbers(owner, element_sets_, own, "ElementSet")) {
      const auto found = cells_.find(cell);
      if (found == cells_.end()) owner.fail("the ElementSet '" + own + "' names no cell " + std::to_string(cell));
      add(found->second);
    }
  } else if (kind == "edge") {
    add(numbers(owner, edges_, own, "Edge"));
  } else if (kind == "node_set") {
    add(numbers(owner, node_sets_, own, "NodeSet"));
  } else {
    owner.refuse("node_set=\"" + name + "\"", "@surface, @elem_set, @edge and @node_set are");
  }
  return nodes;
}

std::vector<int> MeshReader::node_set(const Element& owner, const std::string& name) const {
  std::vector<int> result;
  for (const int node : nodes_of(owner, name)) {
    if (!places_.contains(node)) owner.fail("the set '" + name + "' names no node " + std::to_string(node));
    const auto found = molecules_.find(node);
    if (found != molecules_.end()) result.push_back(found->second);
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

std::vector<LoadedFace> MeshReader::surface(const Element& owner, const std::string& name) const {
  const auto found = surfaces_.find(name);
  if (found == surfaces_.end()) owner.fail("there is no Surface '" + name + "'");
  std::vector<LoadedFace> faces;
  for (const Facet& facet : found->second) {
    LoadedFace face{facet.kind, {}};
    for (const int node : facet.nodes) face.nodes.push_back(molecule(owner, node));
    faces.push_back(std::move(face));
  }
  return faces;
}

std::vector<std::array<int, 2>> MeshReader::discrete_set(const Element& owner, const std::string& name) const {
  const auto found = discrete_sets_.find(name);
  if (found == discrete_sets_.end()) owner.fail("there is no DiscreteSet '" + name + "'");
  std::vector<std::array<int, 2>> result;
  for (const auto& [a, b] : found->second) result.push_back({molecule(owner, a), molecule(owner, b)});
  return result;
}

std::vector<std::array<int, 2>> MeshReader::edge(const Element& owner, const std::string& name) const {
  const Numbers& nodes = numbers(owner, edges_, name, "Edge");
  std::vector<std::array<int, 2>> result;
  for (std::size_t i = 0; i + 1 < nodes.size(); i += 2)
    result.push_back({molecule(owner, nodes[i]), molecule(owner, nodes[i + 1])});
  return result;
}

}  // namespace elastin::febio
