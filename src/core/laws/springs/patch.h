#pragma once
#include <string>

#include "elastin/core/laws/law.h"

namespace elastin {

/// How much Σ_j k L² = 12 E V counts relative to the balance where molecules have too few connections to balance.
inline constexpr double kPatchVolumeWeight = 0.3;

/// The constants k ≥ 0 with which every molecule comes nearest to passing the linear patch test: under any uniform
/// strain ε its connections balance what the surrounding solid exerts on its part A_i of the surface (outward area
/// vector [m²], 0 inside),
///   Σ_j k_ij L_ij n n n = −C : A_i,  C_ijkl = 0.4 E (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk):
/// 10 equations a molecule, solved by non-negative least squares. Where they hold exactly (cubic lattices with face
/// diagonals), E is the target and ν = ¼; the material's ν is not used. Molecules inside with fewer than 20
/// connections in the mean cannot all balance (disorder, tetrahedral meshes): the fit then also requires for each
/// molecule's share of the stiffness, Σ_j k L² = 12 E V_i of its volume V_i, since k = 0 inside would balance too. Such
/// bodies are softer than the target, a random packing by 6 %: calibrate. Where many constants pass, those nearest to
/// one constant for all are taken; k may be 0.
struct Patch {
  static constexpr std::string_view name = "patch";
  static constexpr std::string_view summary =
      "k >= 0 fitted so that every molecule passes the patch test, on any connections";
  static constexpr std::string_view source = "patch test of finite elements; Cauchy relations";
  static constexpr bool joins_molecules = true;

  /// Surface areas and volumes come from the cubes of a lattice, else from Voronoi cells, else from tetrahedra.
  static bool needs_voronoi(const Body& body) { return body.cubes.empty() && body.triangles.empty(); }
  static std::string unsuited(const Body& body);

  /// k [N/m], ≥ 0, one a connection. Seconds for 1e5 connections.
  VectorX constants(const Body& body, const Material& material) const;
};

/// Sections w ≥ 0 [m], one a connection, with which springs of tension w L P(ε) stand for fibres of nominal stress P
/// along the unit vector a: the same patch test with C = a a a a. Exact where connections run along a (all others get
/// 0) and on what else passes; on the rest the nearest there is. Needs what Patch needs.
VectorX fibre_sections(const Body& body, const Vector3& direction);

}  // namespace elastin
