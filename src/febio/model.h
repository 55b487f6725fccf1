#pragma once
#include <memory>

#include "elastin/config/scene_source.h"
#include "lab/scene/scene.h"

namespace elastin::febio {

/// A model file as a scene: its body with its loads, its domains' laws as the strategy "febio", and its steps as an
/// experiment. See add_scene_format.
std::unique_ptr<lab::Scene> load_model(const config::SceneSource& source);

}  // namespace elastin::febio
