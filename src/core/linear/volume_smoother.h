#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/linear/block_inverse.h"

namespace elastin {

/// Smoothing of bodies that resist changes of volume far more than of shape. Blocks of single molecules then damp
/// nothing but these changes. With K = K̃ + Gᵀ G, G a row for each volume that resists by itself, this one damps by the
/// blocks D of K̃ as if the body were soft and keeps volumes:
///   S⁻¹ = D⁻¹ − D⁻¹ Gᵀ T⁻¹ G D⁻¹, T = 1 + G D⁻¹ Gᵀ,
/// with T⁻¹ nearly, by an even number of Chebyshev steps, so that S⁻¹ is positive.      [Braess & Sarazin 1997;
/// Schöberl 1999]
class VolumeSmoother {
 public:
  /// None where no volume resists that much.
  static std::optional<VolumeSmoother> of(const Tangent& tangent, const std::vector<Support>& supports);
  /// vectors = S⁻¹ vectors: forces [N] become motions [m].
  void apply(Positions& vectors);

 private:
  struct Part {  ///< of G, in its units √(N/m)
    int molecule;
    Eigen::Vector3f gradient;
  };
  struct Entry {
    int column;
    float value;
  };
  void set_pressures();
  void steps();

  BlockInverses inverse_;
  std::vector<int> start_, parts_start_, rows_start_;  ///< of each volume, of each molecule, of each volume
  std::vector<Part> parts_;                            ///< of each volume
  std::vector<Part> of_molecule_;                      ///< with the volume in the place of the molecule
  std::vector<Entry> rows_;                            ///< of T, each over λ T_ii
  Eigen::VectorXf weights_, right_, y_, better_, step_;
  float stiffest_ = 0;  ///< the largest of T_ii
  int steps_ = 1;
};

}  // namespace elastin
