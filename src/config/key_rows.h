#pragma once
#include <string>
#include <vector>

#include "elastin/config/scene_key.h"
#include "elastin/core/base/table.h"
#include "elastin/core/base/types.h"

namespace elastin::config {

/// A table of the key reference: the keys of one map of a scene.
struct KeySection {
  std::string path;     ///< of the map: "body.lattice"; "" for the scene itself
  std::string heading;  ///< "Body"; empty where the table belongs to the heading before it
  std::string text;     ///< above the table: Markdown
  std::vector<SceneKey> keys;
};

/// "−0.99", as documents write it.
std::string number_text(double value);
/// "`-z`" of an axis, else "[0, 0.6, 0.8]".
std::string direction_text(const Vector3& direction);
/// "0" of one whose components are equal, else "[0, 0, −1]".
std::string vector_text(const Vector3& vector);

/// "> 0", "≥ 0", "0 … 0.5"; "" where every number is in range. Infinite: no bound.
std::string range_text(double low, double high, bool above_low);

/// The key of a parameter; `owner` stands before its name: "newmark." or nothing.
SceneKey key_of(const ParameterInfo& info, const std::string& owner = "");

/// "`a`, `b`, `c`", of the names of rows.
std::string words_text(const std::vector<std::string>& names);

/// The maps that have a key, by their paths: "experiment", "body.lattice".
std::vector<std::string> owners_of(const std::string& key, const std::vector<KeySection>& sections);

}  // namespace elastin::config
