#pragma once
#include <string>
#include <vector>

#include "elastin/core/simulation/catalog.h"
#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// All tables in the order of the reference.
std::vector<KeySection> key_sections(const Catalog& catalog, const ExperimentCatalog& experiments);

/// The key reference, Markdown, as it stands in scenes/README.md.
std::string key_reference(const Catalog& catalog, const ExperimentCatalog& experiments);

}  // namespace elastin::lab
