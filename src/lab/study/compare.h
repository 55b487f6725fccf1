#pragma once
#include "lab/report/progress.h"
#include "lab/study/request.h"

namespace elastin::lab {

/// How progress is shown: not at all with --quiet, otherwise as standard error can show it.
Progress::Show progress_of(const Output& output);

/// Runs every chosen strategy on every scene, in every combination of a study. Of `compare` prints one table
/// a scene and, of several, a summary; of `run` one page a run. With `out` each row is on disk as soon as it is
/// finished, and a page, plots and tables in the end. Returns whether nothing failed. Throws InputError.
bool run_scenes(const Request& request, const Catalog& catalog);

}  // namespace elastin::lab
