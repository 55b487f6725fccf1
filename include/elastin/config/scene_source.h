#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

namespace elastin::config {

/// A scene that a program has in memory. Files that it names are found from the working directory; messages call it
/// "scene": scene:line:column.
struct HeldScene {
  /// As a scene file. Plain numbers are in SI units here, also next to values with units.
  std::string yaml;
  /// What `given: NUMBER` means in place of a body's shape: the body as it is. `given_shape: NUMBER` gets its masses
  /// and radii from the scene, as other shapes.
  std::vector<std::shared_ptr<const Body>> bodies = {};
  /// What `given: NUMBER` means in a material; other keys next to it change it.
  std::vector<std::shared_ptr<const Material>> materials = {};
};

/// Where the text of a scene comes from: a file, or the memory of a program. Every file is read once, when its text is
/// first needed: copies share what was read, and so do the sources of other files that a scene names. References,
/// verdicts and studies therefore see the same scene, even if its file changes while they run. For several threads.
class SceneSource {
 public:
  SceneSource() : SceneSource(std::string()) {}  ///< no scene; its path is empty
  SceneSource(std::string path);
  SceneSource(const char* path) : SceneSource(std::string(path)) {}
  SceneSource(HeldScene scene);
  /// A text that is not held by a program; `name` stands for its file in messages.
  static SceneSource of_text(const std::string& name, std::string text);

  /// The file as messages name it; "scene" for one in memory.
  const std::string& path() const { return path_; }
  /// The bytes. Throws InputError if there is no such file, or it is a folder or a device.
  const std::string& text() const;
  /// Another scene file, which shares with this one what is read.
  SceneSource other(std::string path) const;
  /// The scene in memory; null for a file.
  const HeldScene* held() const { return held_.get(); }
  /// The same file, or the same scene in memory.
  bool operator==(const SceneSource& other) const { return path_ == other.path_ && held_ == other.held_; }

 private:
  struct Files;
  std::string path_;
  std::shared_ptr<const HeldScene> held_ = {};
  std::shared_ptr<Files> files_;
};

}  // namespace elastin::config
