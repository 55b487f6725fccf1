#pragma once

namespace elastin::command {

/// For the start of a program, where the C library is GNU's: what large bodies take comes from one region, in pages of
/// 2 MB where the system lends them, and is kept when it is freed. Each large array would otherwise be taken from the
/// system again, which clears it page by page: nearly half of the processor time of a static run on 10⁵ molecules.
void keep_memory();

}  // namespace elastin::command
