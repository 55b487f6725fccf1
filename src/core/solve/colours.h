#pragma once
#include <functional>
#include <span>

#include "core/base/rows.h"

namespace elastin {

/// Numbers 0 … items−1 in rows by colour, ascending: no two of one colour share a molecule. `molecules_of(item)` are
/// those of an item; each gets the first colour that is free. The same on any machine.
Rows colours_of_items(int items, int molecules, const std::function<std::span<const int>(int item)>& molecules_of);

/// Molecules in rows by colour: no two of one colour are in one of `elements` groups.
Rows colours_of_molecules(int molecules, int elements,
                          const std::function<std::span<const int>(int element)>& molecules_of);

}  // namespace elastin
