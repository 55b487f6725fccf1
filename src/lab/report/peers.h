#pragma once
#include <string>
#include <vector>

namespace elastin::lab {

/// A solution by another program, to be compared with Elastin's.
struct Peer {
  std::string scene;  ///< whose problem it solves; empty = of every scene
  std::string name;
  double seconds = 0, error = 0;  ///< error relative to the same reference
};

/// Reads the columns method, minimum_s, error, and scene if there is one, of a CSV file; rows without both numbers are
/// left out. Throws InputError: file:line.
std::vector<Peer> load_peers(const std::string& path);

}  // namespace elastin::lab
