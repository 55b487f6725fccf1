// The program elastin: the commands of run_command, with the built-in catalog.

#include <cstdio>
#include <cstdlib>

#include "command/memory.h"
#include "elastin/command/command.h"
#include "elastin/openmp/openmp.h"
#ifdef ELASTIN_PETSC_PROGRAM
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace {

/// Replaces this process by the program with the engine petsc in the folder of this one. Returns only where that
/// program is missing.
void become_shared(char** argv) {
  std::error_code none;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", none);
  std::fflush(nullptr);
  execv((self.parent_path() / ELASTIN_PETSC_PROGRAM).c_str(), argv);
}

const char* const kMissing = "the engine petsc needs the program " ELASTIN_PETSC_PROGRAM " in the folder of this one";

/// Whether this is one of several processes of mpiexec, or its arguments name the engine petsc.
bool is_shared(char** argv, int argc) {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* count = std::getenv(name); count && std::atoi(count) > 1) return true;
  return std::any_of(argv, argv + argc, [](const char* word) {
    return std::string_view(word).find("solver.engine=petsc") != std::string_view::npos;
  });
}

/// A scene may name the engine petsc as well.
void let_scenes_share(elastin::Catalog& catalog, char** argv) {
  elastin::Table<elastin::StaticEngineKind> engines(catalog.engines.kind());
  for (const auto& row : catalog.engines) {
    elastin::StaticEngineKind kind = *row;
    if (kind.name == "petsc") {
      kind.missing = "";
      kind.make = [argv]() -> std::shared_ptr<elastin::StaticEngine> {
        become_shared(argv);
        throw elastin::InputError(kMissing);
      };
    }
    engines.add(std::move(kind));
  }
  catalog.engines = std::move(engines);
}

}  // namespace
#endif

int main(int argc, char** argv) {
  elastin::openmp::let_threads_sleep(argv);
  elastin::command::keep_memory();
  elastin::Catalog catalog = elastin::built_in_catalog();
#ifdef ELASTIN_PETSC_PROGRAM
  if (is_shared(argv, argc)) {
    become_shared(argv);
    std::fprintf(stderr, "elastin: %s\n", kMissing);
    return 2;
  }
  let_scenes_share(catalog, argv);
#endif
  const int code = elastin::command::run_command(argc, argv, catalog);
#ifndef __SANITIZE_ADDRESS__  // which looks for what is left when the tables have gone
  std::fflush(nullptr);
  std::_Exit(code);  // the system takes the tables' memory sooner than they give it back
#endif
  return code;
}
