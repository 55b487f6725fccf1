#include "lab/scene/moved_scene.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace elastin::lab {
namespace {

namespace fs = std::filesystem;

/// The line (from 0) of each value that names a file beside the scene.
void find_files(const YAML::Node& node, const fs::path& folder, std::vector<std::pair<int, std::string>>& found) {
  if (node.IsScalar()) {
    const std::string& name = node.Scalar();
    std::error_code ignored;
    if (!name.empty() && fs::path(name).is_relative() && fs::is_regular_file(folder / name, ignored))
      found.emplace_back(node.Mark().line, name);
  }
  for (const auto& child : node)
    if (node.IsMap())
      find_files(child.second, folder, found);
    else
      find_files(child, folder, found);
}

/// Where a value stands in its line, whole and not as a part of another.
std::size_t position_of(const std::string& name, const std::string& line) {
  const std::string around = " \t\r,:[]{}\"'";
  for (std::size_t at = line.find(name); at != std::string::npos; at = line.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || around.find(line[at - 1]) != std::string::npos) &&
        (end == line.size() || around.find(line[end]) != std::string::npos))
      return at;
  }
  return std::string::npos;
}

}  // namespace

std::string moved_scene(const std::string& text, const std::string& from_folder, const std::string& to_folder) {
  const fs::path from = fs::absolute(from_folder.empty() ? "." : from_folder), to = fs::absolute(to_folder);
  std::vector<std::pair<int, std::string>> found;
  find_files(YAML::Load(text), from, found);
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  for (const auto& [number, name] : found) {
    std::string& line = lines.at(static_cast<std::size_t>(number));
    const std::size_t at = position_of(name, line);
    if (at == std::string::npos) continue;
    std::string moved = (from / name).lexically_normal().lexically_relative(to.lexically_normal()).generic_string();
    const bool quoted = at > 0 && (line[at - 1] == '"' || line[at - 1] == '\'');
    if (!quoted && moved.find_first_of(" ,:[]{}#&*!|>'\"%@`") != std::string::npos) moved = "\"" + moved + "\"";
    line.replace(at, name.size(), moved);
  }
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) out += (i > 0 ? "\n" : "") + lines[i];
  return out;
}

}  // namespace elastin::lab
