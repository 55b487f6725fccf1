#include "lab/report/machine.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <fstream>
#include <thread>

namespace elastin::lab {
namespace {

#ifdef __clang__
constexpr const char* kCompiler = "";  // its version names itself
#else
constexpr const char* kCompiler = "g++ ";
#endif

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace

Machine this_machine() {
  double load = 0;
  if (getloadavg(&load, 1) != 1) load = std::nan("");
  return {processor(), static_cast<int>(std::thread::hardware_concurrency()), load,
          std::string(kCompiler) + __VERSION__, ELASTIN_FLAGS};
}

std::string program_text() { return "Elastin " ELASTIN_VERSION; }

std::string Machine::text() const {
  return fmt::format("{}, {} cores, load {:.1f} before; {}; {}", processor, cores, load, compiler, flags);
}

}  // namespace elastin::lab
