// What few tables need, in the program that tools/run builds first: each part of it becomes the whole program.

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "command/row.h"
#include "elastin/core/base/error.h"
#include "elastin/febio/febio.h"
#include "lab/scene/scene.h"

namespace elastin::command {
namespace {

/// Replaces this process by the script in the folder of this program, which builds the whole program and starts it with
/// the same words.
[[noreturn]] void become_whole() {
  std::ifstream line("/proc/self/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(line, word, '\0');) words.push_back(word);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::filesystem::path script = std::filesystem::read_symlink("/proc/self/exe").parent_path() / ELASTIN_WHOLE;
  std::fflush(nullptr);
  execv(script.c_str(), argv.data());
  throw InputError("cannot start " + script.string() + ", which builds the whole program");
}

std::unique_ptr<lab::Scene> read_by_whole(const lab::SceneSource&) { become_whole(); }
Action declare_whole(Options&) { become_whole(); }

}  // namespace

const CommandRow kIdentify{"identify", "", "", declare_whole}, kLab{"lab", "", "", declare_whole};

}  // namespace elastin::command

void elastin::febio::add_scene_format() {
  lab::scene_formats().add({{"febio", "model of FEBio", ""}, ".feb", command::read_by_whole});
}
