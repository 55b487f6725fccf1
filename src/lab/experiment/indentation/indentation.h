#pragma once
#include <optional>
#include <string>
#include <vector>

#include "elastin/contact/contact.h"
#include "elastin/lab/run/experiment.h"
#include "lab/experiment/tension/tension.h"

namespace elastin::lab {

enum class IndenterShape {
  sphere,
  flat,      ///< the end of a cylinder
  obstacle,  ///< one of the scene's own
};

/// A rigid indenter is pressed into a body that stands on the far end.
struct IndentationSetup {
  Vector3 axis = -Vector3::UnitZ();  ///< the indenter's way, unit
  IndenterShape shape = IndenterShape::sphere;
  double radius = 0;            ///< [m]
  std::string obstacle;         ///< its name, of IndenterShape::obstacle; it begins where the scene has it
  std::optional<Vector3> at;    ///< a place on the indenter's axis [m]; none: the middle of the body, in the planes
  std::optional<double> depth;  ///< [m] from first touch, > 0
  std::optional<double> force;  ///< or until this resists [N], > 0, of the whole body
  Grip bottom = Grip::clamped;
  double grip_depth = 0;
  std::vector<Vector3> symmetry;  ///< unit normals of planes through the origin, across each other and the axis
  int load_steps = 1;
};

/// Adds its indenter to the obstacles. The modulus that it measures is Hertz's of a sphere on a half-space, E* = 3 F /
/// (4 √R d^1.5), or that of a flat punch, E* = F / (2 a d) [Johnson 1985, ch. 3, 4], times 1 − ν². Throws InputError on
/// a setup that does not suit the body.
std::unique_ptr<StaticExperiment> make_indentation(const Body& body, const IndentationSetup& setup,
                                                   const Material& material, contact::ContactOptions& contact);

const MeasureList& indentation_measures();

}  // namespace elastin::lab
