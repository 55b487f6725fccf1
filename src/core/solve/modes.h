#pragma once
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"

namespace elastin {

/// A motion of some molecules that no connection resists, to first order.
struct ZeroEnergyMode {
  std::vector<int> molecules;           ///< those that move, most first where they differ
  int count = 1;                        ///< independent modes of this group of molecules
  Vector3 direction = Vector3::Zero();  ///< common direction if all move alike, else zero
  std::string text;                     ///< "molecules 9, 10, 11 slide together along x"
};

/// The zero-energy modes of a supported body at rest: what the springs with constants ≠ 0 leave free.
struct ModeReport {
  int rigid_motions =
      0;  ///< motions that the supports leave to the body, or to pieces that nothing joins: no mechanism
  int zero_energy_modes = 0;  ///< all others: mechanisms
  int out_of_plane = 0;  ///< of these, motions out of the plane of a flat body, where nothing lies that resists them
  bool counted = true;   ///< false: the undecided part of the body is too large to factorise; at least this many
  std::vector<ZeroEnergyMode> modes;  ///< grouped by the molecules that move together; text for each group
};

/// The unit normal of the plane in which a body lies; zero of one that lies in none, on a line, or has parts.
Vector3 plane_normal(const Body& body);

/// Motions as a whole that supports leave to molecules at rest [m], 3 × n; a turn about the line that they lie on is
/// none.
int free_rigid_motions(const Positions& rest, const std::vector<Support>& supports);

/// Counts zero-energy modes exactly, as (free directions) − rank, in three steps, each exact: rigid motions of the
/// whole body are fixed by pins that act on them alone; directions that connections to fixed ones determine are
/// removed, over and over (O(n), which settles most bodies); what is left falls into independent groups whose rank is
/// found by eigenvalues (below 1e-9 of the largest is zero). `stiff[c]` says which connections count; empty = all.
/// Assumes no negative constants: those can make modes that this does not see.
ModeReport find_zero_energy_modes(const Body& body, const std::vector<Support>& supports,
                                  const std::vector<char>& stiff = {});

/// The same, but of a body of several parts those of each part by itself, bone left out: a part that is free to move as
/// a whole, until a tie or contact stops it, is no mechanism. Rigid motions are those of what ties join. Texts go by
/// the part's name and its own numbers.
ModeReport find_modes_in_parts(const Body& body, const std::vector<Support>& supports, const std::vector<char>& stiff);

}  // namespace elastin
