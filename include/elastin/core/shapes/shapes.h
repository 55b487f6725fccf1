#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "elastin/core/model/body.h"
#include "elastin/core/model/share.h"

namespace elastin {

/// Which neighbours of a simple cubic lattice are joined: along its axes, its face diagonals, its space diagonals.
struct CubicPattern {
  bool axis = true, face = false, space = false;
};

/// Bodies come out with places, connections and cells; radius and mass are set by set_matter or by the caller. Counts
/// below 1, lengths and ratios that are not above 0, and axes that there are not, are an InputError.

/// Simple cubic lattice of `molecules` along x, y, z (each ≥ 1), `spacing` [m] apart, from the origin; x runs fastest.
Body cubic_lattice(const std::array<int, 3>& molecules, double spacing, const CubicPattern& pattern);

/// One process's share of it: equal numbers of layers along z, at most as many processes as layers. Its cost is that of
/// its layers.
Body cubic_lattice_share(const std::array<int, 3>& molecules, double spacing, const CubicPattern& pattern,
                         const std::shared_ptr<const Processes>& processes);

/// Body-centred cubic lattice of `cells` cubes of side `spacing` [m]; joined to the 8 nearest neighbours, and to the 6
/// second ones if `second`.
Body body_centred_lattice(const std::array<int, 3>& cells, double spacing, bool second);

/// Face-centred cubic lattice of `cells` cubes of side `spacing` [m]; joined to the 12 nearest neighbours, and to the 6
/// second ones if `second`.
Body face_centred_lattice(const std::array<int, 3>& cells, double spacing, bool second);

/// Random close packing: equal spheres whose centres fill a box from the origin, no two closer than `distance` [m].
/// Molecules are dropped at random (seeded), pushed apart, and the few that still overlap are taken out, so the
/// distance is kept exactly; centres that touch a wall lie on it. Joined within `reach` [m] (1.5 · distance is about 13
/// neighbours). The same seed gives the same body,
/// numbered by order_in_space.
Body random_packing(const Vector3& size, double distance, double reach, std::uint64_t seed);

enum class BlockKind { kuhn, alternating, body_centred };

/// A block of `cubes` cubes filled with tetrahedra: Kuhn 6 a cube, alternating 5 a cube (mirrored in every second
/// cube), body-centred 12 a cube (a molecule in the middle of each; all alike but those on the surface). The
/// connections are their edges.
Body tetrahedral_block(BlockKind kind, const std::array<int, 3>& cubes, const Vector3& size);

/// A body from given positions and pairs; rest lengths are the distances.
Body listed_body(const std::vector<Vector3>& positions, const std::vector<std::array<int, 2>>& pairs);

/// Stretches the whole body from the origin, along x, y, z; the present lengths become the rest lengths.
void stretch(Body& body, const Vector3& factors);

/// Grades the body along an axis (0, 1, 2): spacings grow smoothly along it, `ratio` (> 0) times as wide at the far end
/// as at the near one, s(u) ∝ ratio^u; both ends stay where they are and planes across the axis stay plane. The present
/// lengths become the rest lengths.
void grade(Body& body, int axis, double ratio);

/// Moves every molecule by up to ± `amount` [m] in each direction (uniform, seeded) and makes the present lengths the
/// rest lengths. Molecules on the faces of the body's bounding box stay in their face, so that grips stay plane.
void add_jitter(Body& body, double amount, std::uint64_t seed);

/// Turns the whole body by a rotation matrix about the origin.
void rotate(Body& body, const Matrix3& rotation);

/// Sets every radius [m], and masses from a density [kg/m³]: lumped from the cells where the body has any, else the
/// given volume [m³] shared equally.
void set_matter(Body& body, double radius, double density, double thickness, double volume);

}  // namespace elastin
