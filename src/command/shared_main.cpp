// The program with the engine petsc, which replaces the process of main.cpp: PETSc brings a hundred shared libraries,
// and loading them takes longer than solving many scenes.

#include <unistd.h>

#include <cstdio>

#include "command/processes.h"
#include "elastin/command/command.h"
#include "elastin/openmp/openmp.h"
#include "elastin/petsc/petsc.h"

namespace {

std::FILE* kept_words = nullptr;  // of a process that is not the first
int own_stderr = -1;

/// Keeps the messages of a process other than the first until it is known whether the first has printed the same.
void keep_words() {
  kept_words = std::tmpfile();
  if (!kept_words) return;
  own_stderr = dup(STDERR_FILENO);
  dup2(fileno(kept_words), STDERR_FILENO);
}
void say_kept_words() {
  if (!kept_words) return;
  std::fflush(stderr);
  std::rewind(kept_words);
  char text[4096];
  while (const std::size_t size = std::fread(text, 1, sizeof text, kept_words))
    if (write(own_stderr, text, size) < 0) return;
}

int run_shared(int argc, char** argv, const elastin::Catalog& catalog, const elastin::petsc::Launch& launch) {
  elastin::petsc::start();
  if (launch.rank > 0) keep_words();
  int code = 2;
  try {
    const std::vector<std::string> words =
        elastin::command::shared_arguments({argv, argv + argc}, launch.rank, launch.count);
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    code = elastin::command::run_command(static_cast<int>(arguments.size()), arguments.data(), catalog);
  } catch (const elastin::InputError& error) {
    std::fprintf(stderr, "elastin: %s\n", error.what());
  }
  return elastin::petsc::end(code, say_kept_words);
}

}  // namespace

int main(int argc, char** argv) {
  elastin::openmp::let_threads_sleep(argv);
  elastin::Catalog catalog = elastin::built_in_catalog();
  elastin::petsc::add_to(catalog);
  const elastin::petsc::Launch launch = elastin::petsc::launch();
  if (launch.count > 1) return run_shared(argc, argv, catalog, launch);
  return elastin::petsc::end(elastin::command::run_command(argc, argv, catalog));
}
