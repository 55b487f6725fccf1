#pragma once
#include <functional>
#include <string>
#include <vector>

#include "lab/identify/answer.h"
#include "lab/identify/fit_journal.h"

namespace elastin::lab {

/// The options of an identification, in addition to those of the scene.
struct IdentifyRequest {
  std::vector<std::string> overrides = {};  ///< key.path=value of the scene
  std::vector<std::string> data = {};       ///< FILE, or TEST=FILE: instead of the files that the scene names
  std::vector<std::string> tests = {};      ///< that count; the others are predicted alone. Empty = as the scene says
  std::string laws = {};                    ///< "all" or names, separated by commas; empty = as the scene says
  std::string strategies = {};              ///< of specimens, separated by commas; empty = as their scenes say
  std::function<void(const std::string& doing)> progress = {};
  std::function<bool()> stop = {};
  FitJournal* journal = nullptr;  ///< where ends of searches are noted, and found that were made before
};

/// The material of a scene's `identify:` section fitted to its measured tests; several answers where strategies are
/// compared, one each. Numerical trouble is an outcome. Throws InputError on wrong scenes, data and names.
std::vector<Answer> identify(const SceneSource& scene, const Catalog& catalog, const IdentifyRequest& request);

}  // namespace elastin::lab
