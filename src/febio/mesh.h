#pragma once
#include <map>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"
#include "febio/element.h"
#include "febio/loads.h"

namespace elastin::febio {

/// The mesh of a model file: molecules are the nodes that cells or springs use, in the file's order.
class MeshReader {
 public:
  /// Reads <Mesh>.
  explicit MeshReader(const Element& mesh);

  /// Block number of the body for each <Elements>, by name.
  struct Domain {
    std::string name, type;
    int block = 0;
  };
  /// With its blocks, without connections, masses and radii.
  const Body& body() const { return body_; }
  const std::vector<Domain>& domains() const { return domains_; }

  /// Molecules of a set as `node_set` names it: a set of nodes, or "@surface:", "@elem_set:", "@edge:" with a name.
  /// Ascending. Nodes that nothing uses are left out.
  std::vector<int> node_set(const Element& owner, const std::string& name) const;
  /// The molecule of a node by the file's number.
  int molecule(const Element& owner, int node) const;
  std::vector<LoadedFace> surface(const Element& owner, const std::string& name) const;
  std::vector<std::array<int, 2>> discrete_set(const Element& owner, const std::string& name) const;
  /// Of lines of two nodes.
  std::vector<std::array<int, 2>> edge(const Element& owner, const std::string& name) const;

 private:
  using Numbers = std::vector<int>;

  void read_nodes(const Element& nodes);
  void read_cells(const Element& cells);
  void use_nodes();
  /// Nodes of a set, by the file's numbers.
  const Numbers& numbers(const Element& owner, const std::map<std::string, Numbers>& sets, const std::string& name,
                         const char* what) const;
  Numbers nodes_of(const Element& owner, const std::string& name) const;

  struct Facet {
    const CellKind* kind;
    Numbers nodes;
  };

  std::map<int, Vector3> places_;       // of nodes, by the file's number
  std::map<int, Numbers> cells_;        // nodes of cells, both by the file's number
  std::map<int, int> molecules_;        // by the file's number of a node
  std::vector<Numbers> block_nodes_;    // of each block, by the file's numbers
  std::vector<const CellKind*> kinds_;  // of each block
  std::map<std::string, Numbers> node_sets_, element_sets_, edges_;
  std::map<std::string, std::vector<Facet>> surfaces_;
  std::map<std::string, std::vector<std::array<int, 2>>> discrete_sets_;
  std::vector<Domain> domains_;
  Body body_;
};

}  // namespace elastin::febio
