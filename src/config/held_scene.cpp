#include "config/held_scene.h"

#include <map>
#include <mutex>
#include <utility>

namespace elastin::config {
namespace {

/// Scenes are read again by their path, on any thread: for references, verdicts and studies.
struct HeldScenes {
  std::mutex busy = {};
  std::map<std::string, std::shared_ptr<const HeldScene::Content>> by_path = {};
  long made = 0;
};

HeldScenes& held_scenes() {
  static HeldScenes scenes;
  return scenes;
}

}  // namespace

HeldScene::HeldScene(Content content) {
  HeldScenes& scenes = held_scenes();
  auto shared = std::make_shared<const Content>(std::move(content));
  const std::lock_guard turn(scenes.busy);
  path_ = "<in memory " + std::to_string(++scenes.made) + ">/scene";
  scenes.by_path.emplace(path_, std::move(shared));
}

HeldScene::~HeldScene() {
  HeldScenes& scenes = held_scenes();
  const std::lock_guard turn(scenes.busy);
  scenes.by_path.erase(path_);
}

std::shared_ptr<const HeldScene::Content> held_scene(const std::string& path) {
  HeldScenes& scenes = held_scenes();
  const std::lock_guard turn(scenes.busy);
  const auto found = scenes.by_path.find(path);
  return found == scenes.by_path.end() ? nullptr : found->second;
}

}  // namespace elastin::config
