#pragma once
#include <string>
#include <vector>

#include "elastin/contact/overlaps.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// The output of `elastin check` for a scene.
struct CheckReport {
  std::string text;
  bool sound = true;  ///< false: isolated molecules, several pieces, connections without length, flat cells
};

/// Counts, neighbours, pieces, faults by number, zero-energy modes by name, what the scene builds, and which strategies
/// can run on the body. `overlaps` are those of the body at rest.
CheckReport check_scene(Scene& scene, const Catalog& catalog, const std::vector<contact::Overlap>& overlaps);

/// The output of `elastin list`.
std::string catalog_text(const Catalog& catalog, const ExperimentCatalog& experiments, bool colours);

}  // namespace elastin::lab
