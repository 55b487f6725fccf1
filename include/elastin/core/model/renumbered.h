#pragma once
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// A body in another numbering, and the numbers that everything had.
struct RenumberedBody {
  Body body;
  std::vector<int> molecule_from;    ///< of each molecule its number before
  std::vector<int> connection_from;  ///< of each connection its number before
};

/// The same body numbered along a curve that fills space (see order_in_space), its connections and cells in the order
/// of their molecules: for a body that comes in no order, which an embedding program numbers so before it makes a model
/// on it, and translates by molecule_from what it hands over and reads. Passes over 10⁶ molecules at random wait for
/// the memory several times as long. Cost O(n log n). Throws InputError on bodies of parts, of ties, of a process's
/// share, and on refined ones, whose last molecules lie between others.
RenumberedBody numbered_in_space(const Body& body);

/// The body in parts, one for each label of its cells: named by the label, and with the number of its material by
/// ascending labels. Molecules that cells of several labels share belong to the lowest one's part, and cells of one
/// label come together; connections keep their numbers. A label for each cell, in the order in which they were given.
/// Throws InputError as above, but on refined bodies only where what lies between others would come before these, on
/// other counts, and on bodies without cells, with cubes next to other cells, or with a stiffness of each cell.
RenumberedBody parts_of_labels(const Body& body, const std::vector<int>& labels);

}  // namespace elastin
