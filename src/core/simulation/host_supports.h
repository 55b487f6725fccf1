#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin {

/// Molecules that a host fixes and moves, in addition to the supports that the model has from elsewhere and their
/// drive.
class HostSupports {
 public:
  /// The model must outlive it, and it must stay where it is.
  explicit HostSupports(Model& model) : model_(model) {}

  /// Fixes a molecule at this position; also one that is already fixed by others.
  void fix(int molecule, const Matrix3& free, const Vector3& position);
  void release(int molecule);
  /// Where it is to be at the end of the next step; false if nothing fixes it.
  bool move_to(int molecule, const Vector3& position);
  /// The support of a molecule, null if it has none.
  const Support* find(int molecule) const;

  /// Around a step: what is to move goes there between these times [s], and stays; or is where it was.
  void begin(double start, double end);
  void jump();  ///< at once, for a static solve
  void arrive();
  void go_back();

  /// Whether something else moves supports, too: those it knows by their index in the list.
  bool has_others() const { return others_ || (model_.drive && !model_.drive.target<Driver>()); }

  void save(SimulationState& saved) const;
  void restore(const SimulationState& saved);

 private:
  struct Fixed {
    int molecule;
    Vector3 displacement;         // of its support, at the step's start
    std::optional<Vector3> next;  // at its end
  };
  struct Driver {
    HostSupports* host_supports;
    void operator()(double time, std::vector<Support>& supports) const { host_supports->drive(time, supports); }
  };
  /// Where a molecule was last seen, in the supports and in held_; −1 = nowhere.
  struct Seen {
    int support = -1, fixed = -1;
  };
  void drive(double time, std::vector<Support>& supports);
  void attach();
  void index();
  int support_of(int molecule) const;
  Support& support(const Fixed& fixed) { return model_.supports[support_of(fixed.molecule)]; }
  Fixed& entry_of(int molecule);

  Model& model_;
  std::function<void(double, std::vector<Support>&)> others_;  // what drove the supports before
  int others_supports_ = 0;                                    // they stand first
  std::vector<Fixed> fixed_;
  std::vector<Seen> seen_;  // one a molecule
  double start_ = 0, end_ = 0;
};

}  // namespace elastin
