#include "calculix_job.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace bench {

using elastin::Vector3;

bool calculix_is_here() { return std::system("command -v ccx > /dev/null 2>&1") == 0; }

void write_deck(const Deck& deck, const std::string& job) {
  std::ofstream file(job + ".inp");
  file << "*NODE, NSET=ALL\n";
  for (std::size_t i = 0; i < deck.positions.size(); ++i)
    file << fmt::format("{},{:.15g},{:.15g},{:.15g}\n", i + 1, deck.positions[i].x(), deck.positions[i].y(),
                        deck.positions[i].z());
  file << "*ELEMENT, TYPE=" << deck.type << ", ELSET=BODY\n";
  for (std::size_t i = 0; i < deck.cells.size(); ++i) {
    file << i + 1;
    for (std::size_t corner = 0; corner < deck.cells[i].size(); ++corner)
      file << (corner % 15 == 14 ? ",\n" : ",") << deck.cells[i][corner] + 1;  // 16 numbers a line
    file << '\n';
  }
  const auto write_sets = [&](const char* keyword, const auto& sets) {
    for (const auto& [name, numbers] : sets) {
      file << keyword << '=' << name << '\n';
      for (const int number : numbers) file << number + 1 << ",\n";
    }
  };
  write_sets("*NSET, NSET", deck.node_sets);
  write_sets("*ELSET, ELSET", deck.cell_sets);
  file << deck.rest;
  if (!file.flush()) throw std::runtime_error("cannot write " + job + ".inp");
}

void run_calculix_job(const std::string& job, int threads) {
  const std::string line = fmt::format("cd '{}' && OMP_NUM_THREADS={} ccx -i '{}' > '{}.log' 2>&1",
                                       std::filesystem::path(job).parent_path().string(), threads, job, job);
  if (std::system(line.c_str()) != 0) throw std::runtime_error("ccx failed: " + line);
}

std::map<int, Vector3> last_displacements(const std::string& job) {
  std::ifstream file(job + ".dat");
  std::map<int, Vector3> found;
  for (std::string line; std::getline(file, line);) {
    if (line.find("displacements") != std::string::npos) found.clear();
    std::istringstream numbers(line);
    int number = 0;
    double x, y, z;
    if (numbers >> number >> x >> y >> z) found[number - 1] = {x, y, z};
  }
  if (found.empty()) throw std::runtime_error("CalculiX left no answer in " + job + ".dat");
  return found;
}

}  // namespace bench
