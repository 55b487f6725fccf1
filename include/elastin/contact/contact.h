#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "elastin/contact/obstacle.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin::contact {

/// As what a body touches.
enum class ContactSurface {
  spheres,    ///< its molecules' spheres
  triangles,  ///< the surface of its cells, cubes or triangles, through the molecules' centres
};

struct ContactOptions {
  ContactSurface surface = ContactSurface::spheres;
  /// Pressure over depth [Pa/m], > 0: a sample that stands for an area A resists with stiffness · A [N/m]. See
  /// default_contact_stiffness.
  double stiffness = 0;
  double friction = 0;     ///< μ ≥ 0, Coulomb's
  double restitution = 1;  ///< of two molecules, or one and an obstacle, that meet alone: 0 < e ≤ 1; 1 = no damping
  /// Largest depth that may remain [m], by augmented Lagrange multipliers, one for each molecule; 0 = what the penalty
  /// leaves. Of triangles it is the mean over a molecule's share of the surface: on a round obstacle points between the
  /// molecules lie as much deeper as flat triangles must. Of equilibria and implicit steps.
  double penetration = 0;
  bool self = false;  ///< whether a piece touches itself
  /// Work of adhesion w ≥ 0 [J/m²] of the body's surface to obstacles: over a gap g the surface is pulled on with the
  /// traction stiffness · g up to its peak 2 w / range, and from there with one that falls linearly to nothing at g =
  /// range > 0 [m]. Small ranges tend to Johnson, Kendall and Roberts' limit of soft spheres, large ones to Derjaguin,
  /// Muller and Toporov's. [Maugis 1992] The surface must resolve the rim over which it parts;
  /// sides cut by a plane of symmetry count as surface.
  double adhesion = 0, adhesion_range = 0;
  std::vector<Obstacle> obstacles;
};

/// 10 E / d: a molecule of diameter d resists as ten columns of tissue of its own size [Pa/m].
double default_contact_stiffness(const Body& body, double youngs_modulus);

/// What touches in one state.
struct ContactReport {
  int pairs = 0;                             ///< that are pressed together
  int sticking = 0;                          ///< of these, those that do not slide
  double largest_penetration = 0;            ///< [m]
  double area = 0;                           ///< of the samples that touch [m²]
  double largest_pressure = 0;               ///< [Pa]
  std::vector<Vector3> on_obstacles;         ///< force of the body on each obstacle [N]
  Vector3 between_pieces = Vector3::Zero();  ///< the largest force of two pieces, on that of lower number [N]
  Positions forces;                          ///< of contact on each molecule [N], 3 × n
  VectorX pressure;                          ///< on each molecule's part of the surface [Pa], 0 where nothing touches
  double broad_seconds = 0, narrow_seconds = 0;  ///< spent so far
};

/// Contact of a body with obstacles, of its pieces with each other and, if requested, with themselves: normal force by
/// penalty, or augmented; Coulomb friction F_f = −μ |F_N| t with a regime that sticks, by elastic slip that is returned
/// to the cone [M03; Wriggers 2006, ch. 5 and 10]. Bitwise identical on any number of threads. Friction between two
/// spheres acts at their centres, for they have no spin: momentum is kept, angular momentum is not.
class Contact : public Load {
 public:
  virtual ContactReport report(const State& state) const = 0;
  virtual const std::vector<Obstacle>& obstacles() const = 0;
  /// Of an experiment at rest: the moment at which the obstacles' motions are asked, its load factor. Before this is
  /// called they follow the state's time.
  virtual void set_moment(double moment) = 0;
  /// Where each obstacle is: at the moment that was set, else at this time [s].
  virtual std::vector<Pose> poses(double time) const = 0;
};

/// Throws InputError on options out of range, or a body without triangles where the surface needs them.
std::unique_ptr<Contact> make_contact(const Body& body, const ContactOptions& options);

/// Force of a simulation's body on each obstacle by its name [N], what a device gets that holds the obstacle's tool:
/// of all contacts that act on it, in order. Searches once more, and allocates. Steps of order 2 that are long for the
/// contact leave it swinging about its force from one step to the next: take the mean of two, or backward_euler.
std::vector<std::pair<std::string, Vector3>> forces_on_obstacles(const Simulation& simulation);
/// The same of its torque [N m], about where the obstacle, or its tool, is now.
std::vector<std::pair<std::string, Vector3>> torques_on_obstacles(const Simulation& simulation);

}  // namespace elastin::contact
