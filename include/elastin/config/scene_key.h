#pragma once
#include <string>

namespace elastin::config {

/// A key that scenes may write, for lists and documents.
struct SceneKey {
  std::string name = {};      ///< with those of the maps inside: "force", "identify.degree"
  std::string type = {};      ///< "quantity", "direction", "list of vectors", or the words to choose from: "`a`, `b`"
  std::string unit = {};      ///< SI; empty = none
  std::string range = {};     ///< "> 0", "0 … 0.5"; empty = any value
  std::string fallback = {};  ///< "needed", "none", or what counts where the key is missing
  std::string text = {};      ///< what it is
  bool operator==(const SceneKey&) const = default;
};

}  // namespace elastin::config
