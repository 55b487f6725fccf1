#include <fmt/format.h>
#include <fmt/os.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>

#include "peers.h"
#include "support/temporary_folder.h"

namespace bench {
namespace {

using namespace elastin;

bool has(const char* program) {
  return std::system(fmt::format("command -v {} > /dev/null 2>&1", program).c_str()) == 0;
}

/// Springs of the same k and L, to nine digits, are one type of bond.
struct BondTypes {
  std::vector<int> of_connection;
  std::vector<std::array<double, 2>> constant_and_length;

  BondTypes(const Body& body, const VectorX& constants) {
    std::map<std::array<std::string, 2>, int> known;
    for (int c = 0; c < body.connections.size(); ++c) {
      const double k = constants[c], length = body.connections.rest_length[c];
      const auto [at, is_new] =
          known.try_emplace({fmt::format("{:.8e}", k), fmt::format("{:.8e}", length)}, static_cast<int>(known.size()));
      if (is_new) constant_and_length.push_back({k, length});
      of_connection.push_back(at->second + 1);
    }
  }
};

void write_data(const Start& start, const BondTypes& types, const std::string& path) {
  const Body& body = start.body;
  const Vector3 low = start.positions.rowwise().minCoeff(), high = start.positions.rowwise().maxCoeff();
  const Vector3 margin = Vector3::Constant(0.1 * (high - low).maxCoeff());
  auto file = fmt::output_file(path);
  file.print("springs\n\n{} atoms\n{} bonds\n1 atom types\n{} bond types\n", body.size(), body.connections.size(),
             types.constant_and_length.size());
  for (int axis = 0; axis < 3; ++axis)
    file.print("{} {} {}lo {}hi\n", low[axis] - margin[axis], high[axis] + margin[axis], "xyz"[axis], "xyz"[axis]);
  file.print("26 extra bond per atom\n\nMasses\n\n1 {}\n\nAtoms\n\n", body.mass[0]);
  for (int i = 0; i < body.size(); ++i)
    file.print("{} 1 1 {} {} {}\n", i + 1, start.positions(0, i), start.positions(1, i), start.positions(2, i));
  file.print("\nBonds\n\n");
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    file.print("{} {} {} {}\n", c + 1, types.of_connection[c], a + 1, b + 1);
  }
}

/// @param source how the atoms come in. Ghosts reach as far as the longest spring may.
void write_input(const Start& start, const BondTypes& types, const std::string& source, const std::string& run,
                 const std::string& path) {
  double longest = 0;
  for (const double length : start.body.connections.rest_length) longest = std::max(longest, length);
  auto file = fmt::output_file(path);
  file.print(
      "units lj\natom_style bond\nboundary s s s\nnewton on\nspecial_bonds lj/coul 1 1 1\n{}\n"
      "pair_style none\nbond_style harmonic\n",
      source);
  for (std::size_t type = 0; type < types.constant_and_length.size(); ++type)  // its energy is K (l − L)²
    file.print("bond_coeff {} {} {}\n", type + 1, types.constant_and_length[type][0] / 2,
               types.constant_and_length[type][1]);
  file.print(
      "comm_modify cutoff {}\nneighbor 0 bin\nneigh_modify every 1000000 delay 1000000 check no once yes\n"
      "fix 1 all nve\ntimestep {}\nthermo 1000000\n{}\n",
      1.5 * longest, start.dt, run);
}

/// Runs LAMMPS on an input file and returns its last loop time [s].
double loop_time(const TemporaryFolder& folder, const char* input, int ranks) {
  const std::string launch =
      ranks == 1 ? "lmp" : fmt::format("mpirun --allow-run-as-root --oversubscribe -np {} lmp", ranks);
  const std::string line =
      fmt::format("cd '{}' && OMP_NUM_THREADS=1 {} -log run.log -screen none -in {} > out.log 2>&1", folder.path(""),
                  launch, input);
  if (std::system(line.c_str()) != 0) throw std::runtime_error("LAMMPS failed: " + line);
  std::ifstream log(folder.path("run.log"));
  double seconds = 0;
  for (std::string text; std::getline(log, text);)
    if (text.starts_with("Loop time of ")) seconds = std::stod(text.substr(13));
  if (!(seconds > 0)) throw std::runtime_error("LAMMPS gave no loop time: " + line);
  return seconds;
}

}  // namespace

std::string lammps_missing(int ranks) {
  if (!has("lmp")) return "skipped: lmp is not here; apt-get install lammps";
  if (ranks > 1 && !has("mpirun")) return "skipped: mpirun is not here; apt-get install openmpi-bin";
  return "";
}

std::function<double(int)> make_lammps(const Start& start, int ranks) {
  const auto folder = std::make_shared<TemporaryFolder>();
  const auto types = std::make_shared<BondTypes>(start.body, start.constants);
  write_data(start, *types, folder->path("springs.data"));
  // Text is read once; later runs start from a binary file.
  write_input(start, *types, "read_data springs.data extra/special/per/atom 100",
              "run 1\nwrite_restart springs.restart", folder->path("first.in"));
  loop_time(*folder, "first.in", 1);
  std::filesystem::remove(folder->path("springs.data"));
  return [start, folder, types, ranks](int steps) {
    write_input(start, *types, "read_restart springs.restart", fmt::format("run {}\nrun {}", steps / 4 + 1, steps),
                folder->path("run.in"));
    return loop_time(*folder, "run.in", ranks);
  };
}

}  // namespace bench
