#pragma once
#include "lab/identify/identify.h"
#include "lab/study/request.h"

namespace elastin::command {

/// `identify`: fits the material of each scene to its measured tests; prints tables, and with --out writes the page,
/// JSON, every point, and the scene with the numbers put in. Returns whether every search ended. Throws InputError.
bool identify_scenes(const lab::Request& request, lab::IdentifyRequest wanted, const Catalog& catalog);

}  // namespace elastin::command
