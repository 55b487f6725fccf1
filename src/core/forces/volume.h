#pragma once
#include <memory>
#include <string>

#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// Resistance to changes of volume that no spring along a connection can give: the energy
///   W = Σ_g V_g κ/2 (J_g − 1)²,   J_g = Σ w V_T(x) / V_g,   V_g = Σ w V_T(rest),
/// over groups g of tetrahedra T with weight w. [M03's springs have ν = ¼ alone; averaged volumes: Bonet & Burton 1998]
///   * Simple cubic lattices, one group a cube: the tetrahedra of both cuts of it into five, w = ½.
///   * Bodies of tetrahedra, one group a molecule: the tetrahedra around it, w = ¼. One volume a molecule is few enough
///     that linear tetrahedra do not lock as ν → ½.
/// The volumes telescope: under uniform strain nothing acts inside, and the pressure κ (J − 1) on the surface.
///
/// `modulus` κ [Pa] may be negative. Volumes carry a sign, so that single tetrahedra may invert; a group whose whole
/// volume has is energy +∞. Throws InputError where unsuited_for_volumes says why.
std::unique_ptr<Elasticity> make_volume(const Body& body, double modulus);

/// Why a body has no volumes to speak of, or "".
std::string unsuited_for_volumes(const Body& body);

}  // namespace elastin
