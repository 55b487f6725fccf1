#include "elastin/config/scene_source.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

#include "config/scene_tree.h"
#include "elastin/core/base/error.h"

namespace elastin::config {
namespace {

std::string bytes_of(const std::string& path) {
  const SourceLocation location{path};
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) throw InputError(location, missing_file(path));
  if (std::filesystem::is_directory(path, ignored)) throw InputError(location, "is a folder; name a scene file in it");
  if (std::filesystem::is_character_file(path, ignored) || std::filesystem::is_block_file(path, ignored))
    throw InputError(location, "is a device; a scene is a file or a pipe");
  std::ifstream stream(path);
  if (!stream) throw InputError(location, std::string("cannot read the scene: ") + std::strerror(errno));
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

struct SceneSource::Files {
  std::mutex busy = {};
  std::map<std::string, std::string> texts = {};  ///< by path, of the files that were read
};

SceneSource::SceneSource(std::string path) : path_(std::move(path)), files_(std::make_shared<Files>()) {}

SceneSource::SceneSource(HeldScene scene)
    : path_("scene"), held_(std::make_shared<HeldScene>(std::move(scene))), files_(std::make_shared<Files>()) {}

SceneSource SceneSource::of_text(const std::string& name, std::string text) {
  SceneSource source(name);
  source.files_->texts.emplace(name, std::move(text));
  return source;
}

const std::string& SceneSource::text() const {
  if (held_) return held_->yaml;
  const std::lock_guard turn(files_->busy);
  auto found = files_->texts.find(path_);
  if (found == files_->texts.end()) found = files_->texts.emplace(path_, bytes_of(path_)).first;
  return found->second;
}

SceneSource SceneSource::other(std::string path) const {
  SceneSource source(*this);
  source.path_ = std::move(path);
  source.held_.reset();
  return source;
}

}  // namespace elastin::config
