#include "core/solve/colours.h"

#include <algorithm>
#include <vector>

namespace elastin {
namespace {

/// The first colour that no entry of `seen` gives as taken by `of`.
int first_free(const std::vector<int>& seen, int of) {
  return static_cast<int>(std::find_if(seen.begin(), seen.end(), [of](int taken_by) { return taken_by != of; }) -
                          seen.begin());
}

Rows rows_of(const std::vector<int>& colours) {
  const int count = colours.empty() ? 0 : *std::max_element(colours.begin(), colours.end()) + 1;
  return rows_by_target(count, colours);
}

}  // namespace

Rows colours_of_items(int items, int molecules, const std::function<std::span<const int>(int)>& molecules_of) {
  std::vector<std::vector<int>> used(molecules);  // colours at each molecule
  std::vector<int> colours(items), seen;
  for (int item = 0; item < items; ++item) {
    for (const int molecule : molecules_of(item))
      for (const int colour : used[molecule]) {
        if (static_cast<int>(seen.size()) <= colour) seen.resize(colour + 1, -1);
        seen[colour] = item;
      }
    const int own = colours[item] = first_free(seen, item);
    for (const int molecule : molecules_of(item)) used[molecule].push_back(own);
  }
  return rows_of(colours);
}

Rows colours_of_molecules(int molecules, int elements, const std::function<std::span<const int>(int)>& molecules_of) {
  std::vector<std::vector<int>> elements_at(molecules);
  for (int element = 0; element < elements; ++element)
    for (const int molecule : molecules_of(element)) elements_at[molecule].push_back(element);
  std::vector<int> colours(molecules, -1), seen;
  for (int molecule = 0; molecule < molecules; ++molecule) {
    for (const int element : elements_at[molecule])
      for (const int other : molecules_of(element)) {
        const int colour = colours[other];
        if (colour < 0) continue;
        if (static_cast<int>(seen.size()) <= colour) seen.resize(colour + 1, -1);
        seen[colour] = molecule;
      }
    colours[molecule] = first_free(seen, molecule);
  }
  return rows_of(colours);
}

}  // namespace elastin
