#pragma once
#include <string>
#include <vector>

#include "lab/study/request.h"

namespace elastin::lab {

/// Puts the rows of one study together that lie in several folders of `compare --out`, and reports them as the one
/// command would have that runs them all: tables, page, files, with times as they were measured. The merged folder is
/// one of `compare --out` itself: `--resume` continues in it. Says on standard error which rows are missing, and which
/// are there twice with different numbers; of these the first folder's count.
/// @param output `out` may be empty
/// @return whether every row is there, none contradicts another, and nothing failed. Throws InputError: a folder that
/// has no study or another one than the first.
bool merge_studies(const std::vector<std::string>& folders, const Output& output);

}  // namespace elastin::lab
