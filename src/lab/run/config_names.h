#pragma once
#include "config/edited_scene.h"
#include "config/keys.h"
#include "config/other_names.h"
#include "config/reader.h"
#include "config/scene_tree.h"
#include "elastin/config/scene_key.h"
#include "elastin/config/scene_source.h"

namespace elastin::lab {

// The lab speaks the language of scenes.
namespace key = config::key;
using config::any_of;
using config::Forms;
using config::Frame;
using config::HeldScene;
using config::Key;
using config::key_of;
using config::KeyGroup;
using config::Keys;
using config::KeySection;
using config::kNotNegative;
using config::kPositive;
using config::missing_file;
using config::moved_scene;
using config::one_of;
using config::open_scene;
using config::owners_of;
using config::path_text;
using config::Range;
using config::range_text;
using config::Reader;
using config::SceneFile;
using config::SceneKey;
using config::SceneSource;
using config::suggested_word;
using config::with_section;
using config::with_value;
using config::with_values;
using config::words_text;

}  // namespace elastin::lab
