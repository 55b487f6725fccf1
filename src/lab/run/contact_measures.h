#pragma once
#include "elastin/contact/contact.h"
#include "elastin/core/forces/model.h"
#include "elastin/lab/run/measures.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// The model's contact, or null.
contact::Contact* contact_of(const Model& model);

/// "the obstacle 'tool' is 3 mm away": how far the nearest one is from the body's molecules; "" without obstacles.
std::string gap_text(const contact::Contact& contact, const Body& body, const State& state);

/// Number of the obstacle of that name, or −1.
int find_obstacle(const std::vector<contact::Obstacle>& obstacles, const std::string& name);

/// The largest force on one obstacle; where none is pressed, of two pieces on each other [N].
double largest_force(const contact::ContactReport& report);

/// Adds what touches to the measures; of the whole body, which is `copies` times what is modelled.
void note_contact(const contact::ContactReport& report, double copies, Measures& measures);

/// A state to be looked at, with what touches in it.
Snapshot snapshot_of(const Model& model, const State& state, double at, int number);

/// Keeps it with the run as far as the options request it.
void keep_snapshot(const Model& model, const State& state, double at, int number, const RunOptions& options, Run& run);

/// Finds the displacement at which something meets a wanted resistance: secants from equilibrium to
/// equilibrium.
class ForceControl {
 public:
  ForceControl() = default;
  /// `wanted` [N], > 0; `first` [m], > 0: a first displacement.
  ForceControl(double wanted, double first) : wanted_(wanted), displacement_(first) {}
  /// From now on `part` (0 … 1) of the force is wanted. Sets the displacement by extrapolation of the last points.
  void aim(double fraction);
  /// Takes the force [N] at this displacement. True: the force is not met yet, and the displacement has changed.
  bool adjust(double force);
  double displacement() const { return displacement_; }  ///< [m]

 private:
  double towards(double force) const;
  double wanted_ = 0, displacement_ = 0, fraction_ = 0;
  double before_displacement_ = 0, before_force_ = 0, last_displacement_ = 0,
         last_force_ = 0;  // the two points known last
};

}  // namespace elastin::lab
