#pragma once
#include <memory>
#include <string>

#include "elastin/lab/scene/held_scene.h"

namespace elastin::lab {

/// The scene in memory that this path stands for, or null.
std::shared_ptr<const HeldScene::Content> held_scene(const std::string& path);

}  // namespace elastin::lab
