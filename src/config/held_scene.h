#pragma once
#include <memory>
#include <string>

#include "elastin/config/held_scene.h"

namespace elastin::config {

/// The scene in memory that this path stands for, or null.
std::shared_ptr<const HeldScene::Content> held_scene(const std::string& path);

}  // namespace elastin::config
