#pragma once
#include <memory>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// What one of several processes has of a body: the molecules that it owns, the elements that it computes, and the
/// molecules of others that these reach (ghosts). Every molecule has one owner and every element is computed once, so
/// that forces, energies and tangents summed over all subdomains are those of the whole.
struct Subdomain {
  const Body* whole = nullptr;
  /// Molecules that it owns, ascending in the whole, then ghosts, ascending. Connections of the whole between any of
  /// them; triangles and tetrahedra that it computes. It has no blocks, parts or grid.
  std::shared_ptr<const Body> body;
  int owned = 0;                           ///< molecules
  std::vector<int> molecules;              ///< number in the whole of each of its molecules
  std::vector<int> connections;            ///< number in the whole of each of its connections
  std::vector<char> computes;              ///< of each connection: whether it is one of those that it computes
  std::vector<int> triangles, tetrahedra;  ///< numbers in the whole of its cells

  /// Its own number of a molecule of the whole, −1 where it does not have it. Cost O(log n).
  int local(int molecule) const;
  bool owns(int molecule) const {
    const int own = local(molecule);
    return own >= 0 && own < owned;
  }
  /// Values of the whole's connections, zero for those that are computed elsewhere.
  VectorX computed(const VectorX& of_whole) const;
};

/// The owner (0 … parts − 1) of each molecule: halves of equal numbers across the longest side, and halves of these.
/// Always the same for the same positions.                                                     [Berger & Bokhari 1987]
std::vector<int> bisect(const Positions& positions, int parts);

/// The subdomain of owner `own`. A connection is computed by the owner of its first molecule, a cell by that of its
/// lowest; ghosts are the other molecules of these elements, of the tetrahedra around owned molecules, and of the cubes
/// whose lowest molecule is owned. `body` must outlive it.
Subdomain make_subdomain(const Body& body, const std::vector<int>& owners, int own);

}  // namespace elastin
