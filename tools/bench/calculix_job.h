#pragma once
#include <map>
#include <string>
#include <vector>

#include "elastin/core/base/types.h"

/// CalculiX as a peer: a process of its own on an input that is written here.
namespace bench {

/// Whether ccx can be started.
bool calculix_is_here();
inline constexpr const char* kCalculixMissing = "skipped: ccx is not here; apt-get install calculix-ccx";

/// Places and cells count from 0 here.
struct Deck {
  std::string type;  ///< C3D4, C3D8I, C3D10, C3D20R
  std::vector<elastin::Vector3> positions;
  std::vector<std::vector<int>> cells;
  std::map<std::string, std::vector<int>> node_sets, cell_sets;
  std::string rest;  ///< material, supports, steps; the body is the set BODY, "WATCHED" is printed
};

/// Writes JOB.inp.
void write_deck(const Deck& deck, const std::string& job);
/// Runs it; throws std::runtime_error if that fails.
void run_calculix_job(const std::string& job, int threads);
/// The last displacements [m] that it has printed.
std::map<int, elastin::Vector3> last_displacements(const std::string& job);

}  // namespace bench
