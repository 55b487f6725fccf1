#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "elastin/core/base/table.h"
#include "lab/export/engine_run.h"
#include "lab/export/exported_body.h"
#include "lab/export/problem.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

struct ExportedFile {
  std::string name, text;
};

/// What `elastin export` writes: a row a format.
struct ExportFormat : Descriptor {
  std::string ending;  ///< of its one file: ".inp"; of an engine, which gets a folder, ""
  /// The file of a scene with its own strategy. Throws InputError for what the format cannot say. `notes` gets what a
  /// user must know of it.
  std::string (*text)(const Scene& scene, std::vector<std::string>& notes) = nullptr;
  /// Of an engine: the files of its folder.
  std::vector<ExportedFile> (*files)(const ExportedBody& body) = nullptr;
  enum class Takes { connections, either } takes = Takes::either;  ///< either: cells where there are no springs
  bool takes_negative = true;                                      ///< spring constants
  bool writes_loads = true;  ///< of an engine: forces and prescribed displacements of the experiment
  bool one_youngs_modulus = false, one_poissons_ratio = false;  ///< of an engine: for all cells of a body
  /// Sentences of the folder's README.md: what the constants are there, and what to know of its solver.
  std::string constants = {}, advice = {};
};

const elastin::Table<ExportFormat>& export_formats();

/// Adds the rows of engines: their files are made of the body with its constants alone.
void add_engine_formats(elastin::Table<ExportFormat>& rows);

/// The folder of an engine: its files and a README.md. Throws InputError for what the engine cannot take.
std::vector<ExportedFile> engine_files(const ExportFormat& format, const ExportedBody& body);

/// The body as one JSON object, with a line for each molecule, connection and cell: the file of --to json, and what
/// engines are given in a comparison.
std::string json_of_body(const ExportedBody& body);

/// The problem as an input of CalculiX (and, but for its output requests, of Abaqus): cells, materials, supports, loads
/// and steps. Laws: `neo_hookean`, `neo_hookean_log` and `st_venant_kirchhoff` under small displacements, where they
/// are one; st_venant_kirchhoff, mooney_rivlin, yeoh and ogden with a quadratic U(J) under large ones.
///                                                                             [Dhondt, CalculiX CrunchiX User's
///                                                                             Manual]
std::string calculix_text(const Scene& scene, std::vector<std::string>& notes);

/// The problem as a model of FEBio, format 4.0, which `elastin run` takes too: neo_hookean_log, st_venant_kirchhoff,
/// mooney_rivlin, yeoh, ogden, transversely_isotropic; large displacements alone.            [FEBio User's Manual 4.0]
std::string febio_text(const Scene& scene, std::vector<std::string>& notes);

/// FEBio's name of a shape of the table of shapes.
struct FebioShape {
  const char* febio;
  std::string_view name;
  /// Position of each node of the file among those of the shape, where the orders differ.
  std::vector<int> order = {};
};

/// FEBio's solids, for writing and for reading.
const std::vector<FebioShape>& febio_solids();

/// How a problem is written for CalculiX.
struct CalculixOptions {
  /// Whether its own neo-Hookean law, κ/2 (J − 1)² in addition to the isochoric part, may stand for neo_hookean and
  /// neo_hookean_log, which are others beyond small strain; else they are refused.
  bool nearest_law = false;
  bool result_files = true;  ///< stresses and displacements for viewers, in addition to the printed displacements
};

/// The input of CalculiX. It prints the displacements of all molecules (set ALL) and the forces on the held ones (HELD)
/// at the end of each step. Throws InputError; adds to problem.notes what CalculiX does differently.
std::string calculix_deck(StaticProblem& problem, const CalculixOptions& options);

/// What the row of CalculiX is called in a comparison.
inline constexpr const char* kCalculix = "calculix";

/// Throws InputError unless `ccx` can be started.
void check_calculix();

/// Solves the scene's problem by CalculiX, on the scene's cells with second order (tetrahedra of 10 nodes; of a lattice
/// the hexahedra of 20 in its boxes), with the material's own law: where CalculiX has none the nearest, which is said.
/// A problem that it cannot take is unsuited, and a process that fails diverges: the run says why. Its process is
/// ended, and the run interrupted, where `stop` gives true.
OtherRun run_calculix(const Scene& scene, const Catalog& catalog, const std::vector<std::string>& overrides,
                      const std::function<bool()>& stop);

}  // namespace elastin::lab
