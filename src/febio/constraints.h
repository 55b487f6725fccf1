#pragma once
#include <memory>
#include <vector>

#include "febio/loads.h"

namespace elastin::febio {

/// How multipliers are found: after each equilibrium each grows by its penalty's force, until their norm changes by no
/// more than `tolerance` of itself. Without them a constraint is kept by its penalty alone.
struct Augmentation {
  bool on = false;
  double tolerance = 0.01;
  int least = 0, most = 10;  ///< augmentations of an increment
};

/// A sum of displacements that is to be 0: start + Σ coefficient (u + offset).
struct Gap {
  struct Term {
    int molecule, axis;
    double coefficient;
    double offset = 0;  ///< [m] to be added to u: of positions, where these are meant
  };
  std::vector<Term> terms;
  double weight = 1;  ///< of its force
  double start = 0;   ///< [m] of the sum
};

struct GapConstraint {
  std::vector<Gap> gaps;
  double penalty = 1;  ///< [N/m], over the weight
  Augmentation augmentation;
  bool one_sided = false;  ///< a gap may be below 0
  Value shift = {};        ///< [m], added to all gaps
};
/// Forces −weight (λ + penalty gap) coefficient, of one-sided ones not below 0; multipliers λ are history. [Hestenes
/// 1969]
/// @param number names its history.
std::unique_ptr<TimedLoad> make_gap_constraint(const Body& body, GapConstraint constraint, int number);

/// Multipliers of the cells of a block in addition to U(J̄) of their mean dilatation J̄: energy Σ V λ ln J̄, λ grows by κ
/// ln J̄.
struct DilatationConstraint {
  int block = 0;
  double modulus = 0;  ///< κ [Pa]
  Augmentation augmentation;
};
std::unique_ptr<TimedLoad> make_dilatation_constraint(const Body& body, const DilatationConstraint& constraint);

/// The volume V that closed faces enclose, kept as it was when the constraint came into force, by the pressure
/// p = λ + ε (V − V₀) on them: forces p ∂V/∂x; λ grows by ε (V − V₀).
struct VolumeConstraint {
  std::vector<LoadedFace> faces;  ///< closed; normals all outwards or all inwards
  double penalty = 0;             ///< ε [Pa/m³], < 0 with normals outwards
  Augmentation augmentation;
  int step = -1;  ///< in which alone it is in force, or -1: in all
};
/// @param number names its history.
std::unique_ptr<TimedLoad> make_volume_constraint(const Body& body, VolumeConstraint constraint, int number);

}  // namespace elastin::febio
