#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "elastin/core/base/table.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// What `elastin export` writes: a row a format.
struct ExportFormat : Descriptor {
  std::string ending;  ///< of its files: ".inp"
  /// The file of a scene with its own strategy. Throws InputError for what the format cannot say. `notes` gets what a
  /// user must know of it.
  std::string (*text)(const Scene& scene, std::vector<std::string>& notes) = nullptr;
};

const elastin::Table<ExportFormat>& export_formats();

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

}  // namespace elastin::lab
