#pragma once
#include <optional>
#include <vector>

#include "elastin/lab/run/experiment.h"
#include "lab/run/common_measures.h"

namespace elastin::lab {

/// What experiments share that move molecules of the body along given displacements and read the forces which that
/// takes.
class Driven : public StaticExperiment {
 public:
  int load_steps() const override { return load_steps_; }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;

 protected:
  friend class DrivenRig;
  struct Fixed {
    int molecule;
    Matrix3 free;  ///< projector on the directions in which it stays free
  };
  /// A model as its rig has it now.
  struct Held {
    Model& model;
    double factor = 1;      ///< of the load that was set last
    bool released = false;  ///< whether the driven end was released
  };

  Driven(const Body& body, int load_steps) : body_(body), load_steps_(load_steps) {}
  /// As StaticRig::measure.
  virtual Measures measure(const Held& held, const Start& start, const State& state, const StaticOptions& options,
                           StaticResult& solved) const = 0;
  /// Displacement from rest [m] of fixed molecule number `index` under a part (0 … 1) of the load; only its held part
  /// counts.
  virtual Vector3 displacement(std::size_t index, double factor) const = 0;
  /// Change of that displacement with the factor [m]. As it stands: of straight displacements.
  virtual Vector3 displacement_slope(std::size_t index, double /*factor*/) const { return displacement(index, 1); }
  /// As StaticRig::longest_step.
  virtual double longest_step() const { return 1; }
  /// The first of the fixed molecules that a release frees, and with it all after it; none: nothing can be released.
  virtual std::optional<std::size_t> first_released() const { return std::nullopt; }

  /// Holds molecules in all directions; a molecule must not be held twice.
  void fix_fully(const std::vector<int>& molecules);
  /// What the forces [N] on the fixed molecules have grown by since the start; the scene's own supports come after
  /// them.
  Positions pull_of(const Start& start, const StaticResult& solved) const {
    return (solved.reactions - start.reactions).leftCols(static_cast<Eigen::Index>(fixed_.size()));
  }
  /// Σ f xᵀ [N m] of the held molecules, at `positions`: the volume times the mean stress of a body in balance.
  Matrix3 virial(const Positions& pull, const Positions& positions) const;

  const Body& body_;
  std::vector<Fixed> fixed_;

 private:
  int load_steps_;
};

}  // namespace elastin::lab
