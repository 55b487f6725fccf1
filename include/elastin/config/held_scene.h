#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

namespace elastin::config {

/// A scene that a program has in memory. As long as it lives, path() stands for a file wherever a scene's path is
/// taken: Laboratory, references, verdicts, identification. Files that it names are found from the working directory.
class HeldScene {
 public:
  struct Content {
    /// As a scene file. Plain numbers are in SI units here, also next to values with units.
    std::string yaml;
    /// What `given: NUMBER` means in place of a body's shape: the body as it is. `given_shape: NUMBER` gets its masses
    /// and radii from the scene, as other shapes.
    std::vector<std::shared_ptr<const Body>> bodies = {};
    /// What `given: NUMBER` means in a material; other keys next to it change it.
    std::vector<std::shared_ptr<const Material>> materials = {};
  };

  explicit HeldScene(Content content);
  ~HeldScene();
  HeldScene(const HeldScene&) = delete;
  HeldScene& operator=(const HeldScene&) = delete;

  /// Messages have the text's own places, under the name "scene": scene:line:column.
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace elastin::config
