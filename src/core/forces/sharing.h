#pragma once

namespace elastin {

/// Why a process's share of a body cannot have an elasticity.
inline constexpr const char* kNotShared =
    "this strategy on this body cannot be shared out among processes; those that can are spring rules, laws on "
    "triangles, tetrahedra and, where each process has a share of the body alone, on the cells of blocks, and their "
    "volume terms, on one body, without relaxation, softening or updated constants";

}  // namespace elastin
