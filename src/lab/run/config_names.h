#pragma once
#include "config/keys.h"
#include "config/reader.h"
#include "config/scene_text.h"
#include "config/scene_tree.h"
#include "elastin/config/scene_key.h"
#include "elastin/config/scene_source.h"

namespace elastin::lab {

// The lab speaks the language of scenes.
namespace key = config::key;
using namespace config;
using config::key_of;  // next to those of the lab
using config::range_text;

}  // namespace elastin::lab
