#include "elastin/command/command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <sstream>
#include <system_error>

#include "command/row.h"
#include "core/base/named.h"
#include "core/base/shell_word.h"
#include "elastin/core/base/error.h"
#ifdef ELASTIN_FEBIO
#include "elastin/febio/febio.h"
#endif
#include "elastin/openmp/openmp.h"
#include "lab/report/screen.h"

namespace elastin::command {
namespace {

constexpr const CommandRow* kCommands[] = {&kRun,  &kCompare, &kMerge, &kVerify, &kCheck, &kIdentify,
                                           &kList, &kPlot,    &kLab,   &kExport, &kNew};

/// The end of every help.
std::string help_foot(const std::string& program, const std::vector<const CommandRow*>& rows) {
  std::string text = "\nExamples:\n";
  for (const CommandRow* row : rows) {
    std::istringstream lines(row->examples);
    for (std::string line; std::getline(lines, line);) text += "  " + program + " " + line + "\n";
  }
  return text + "\nExit codes: 0 all expectations hold; 1 an expectation or a run failed; 2 wrong use or input.\n";
}

std::string help_of_all(const std::string& program) {
  std::string text =
      "Elastin: soft tissue as molecules and connections, and the modulus it really has.\nUsage: " + program +
      " COMMAND [OPTIONS]\n\nOptions:\n" + help_line("-h,--help", "Print this help") +
      help_line("--version", "Print name and version") + "\nCommands:\n";
  for (const CommandRow* row : kCommands) text += help_line(row->name, row->summary);
  return text + help_foot(program, {std::begin(kCommands), std::end(kCommands)});
}

/// The command of this name. Throws InputError with the nearest name.
const CommandRow& find_command(const std::string& word) {
  for (const CommandRow* row : kCommands)
    if (word == row->name) return *row;
  if (word.starts_with('-'))
    throw InputError("unknown option '" + word + "'" + suggestion(word, {"--help", "--version"}) +
                     "; the options of a command follow its name");
  if (std::error_code ignored; std::filesystem::exists(word, ignored) || word.ends_with(".yaml"))
    throw InputError("name a command before the scene: elastin run " + shell_word(word) + ", or one of " +
                     joined(kCommands, &CommandRow::name));
  throw InputError("unknown command '" + word + "'" + suggestion(word, names_of(kCommands, &CommandRow::name)));
}

int run_words(const std::string& program, const std::vector<std::string>& words, const Catalog& catalog) {
  const auto requests_help = [](const std::string& word) { return word == "-h" || word == "--help"; };
  if (words.empty())
    throw InputError("name a command: " + joined(kCommands, &CommandRow::name) + "; " + program +
                     " --help explains them");
  if (words.front() == "--version") {
    fmt::print("elastin " ELASTIN_VERSION "\n");
    return 0;
  }
  if (requests_help(words.front()) && words.size() == 1) {
    fmt::print("{}", help_of_all(program));
    return 0;
  }
  const bool help_first = requests_help(words.front());
  const CommandRow& row = find_command(words[help_first ? 1 : 0]);
  const std::string usage_name = program + " " + row.name;
  Options options;
  const Action run = row.declare(options);
  if (help_first || options.read({words.begin() + 1, words.end()}, usage_name)) {
    fmt::print("{}\n{}{}", row.summary, options.help(usage_name), help_foot(program, {&row}));
    return 0;
  }
  openmp::use_openmp();
  lab::set_screen_width(lab::terminal_width(STDOUT_FILENO));
  std::string line = program;
  for (const std::string& word : words) line += " " + shell_word(word);
  return run({catalog, line});
}

/// A standard stream that the caller has closed stays unusable: no file that the command opens may take its number and
/// be written to in its place.
void keep_standard_streams() {
  while (true) {
    const int next = open("/dev/null", O_RDONLY);
    if (next > STDERR_FILENO) close(next);
    if (next < 0 || next > STDERR_FILENO) return;
  }
}

}  // namespace

int run_command(int argc, const char* const* argv, const Catalog& catalog) {
  keep_standard_streams();
  const std::string name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "elastin";
  try {
#ifdef ELASTIN_FEBIO
    febio::add_scene_format();
#endif
    const int code = run_words(name, {argv + std::min(argc, 1), argv + argc}, catalog);
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
    lab::say(fmt::format("{}: standard output could not be written: {}\n", name, std::strerror(errno)));
    return 2;
  } catch (const std::filesystem::filesystem_error& error) {
    const char* temporary = std::getenv("TMPDIR");  // a folder that is not there comes without its name
    const std::string path = error.path1().empty() && temporary ? temporary : error.path1().string();
    lab::say(fmt::format("{}: {}{}: {}\n", name, path, temporary && path == temporary ? " (TMPDIR)" : "",
                         error.code().message()));
    return 2;
  } catch (const std::system_error& error) {  // of a print
    lab::say(fmt::format("{}: standard output could not be written: {}\n", name, error.code().message()));
    return 2;
  } catch (const std::bad_alloc&) {
    lab::say(fmt::format("{}: there is not enough memory for this body\n", name));
    return 2;
  } catch (const InputError& error) {
    lab::say(fmt::format("{}: {}\n", name, error.what()));
    return 2;
  } catch (const std::exception& error) {
    lab::say(fmt::format("{}: internal error: {}\n", name, error.what()));
    return 1;
  }
}

}  // namespace elastin::command
