#pragma once
#include <functional>
#include <string>
#include <vector>

namespace fuzz {

struct Seed {
  std::string ending;  ///< of the file's name: ".msh"
  std::string bytes;
};

/// A kind of file that Elastin reads.
struct Kind {
  std::string name;
  std::vector<Seed> seeds;
  /// Reads the file. Whatever comes out of it but an InputError is a find.
  std::function<void(const std::string& path)> read;
  /// Whether every message about the file must name it.
  bool names_file = true;
};

/// All kinds, with seeds from the tree at `source`; `folder` is where the files to read will stand, and what they name
/// stands next to them.
std::vector<Kind> all_kinds(const std::string& source, const std::string& folder);

}  // namespace fuzz
