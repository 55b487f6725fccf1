#pragma once
#include <vector>

#include "lab/experiment/experiment.h"

namespace elastin::lab {

/// What experiments share that move molecules of the body along given ways and read the forces which that takes.
class Driven : public Experiment {
 public:
  int load_steps() const override { return load_steps_; }
  void set_up(Model& model) override;
  void set_load(Model& model, double factor) override;
  void set_load_rate(Model& model, double rate) override;

 protected:
  struct Fixed {
    int molecule;
    Matrix3 free;  ///< projector on the directions in which it stays free
  };

  Driven(const Body& body, int load_steps) : body_(body), load_steps_(load_steps) {}
  /// Way from rest [m] of held molecule number `held` under a part (0 … 1) of the load; only its held part counts.
  virtual Vector3 displacement(std::size_t index, double factor) const = 0;
  /// Change of that way with the factor [m]. As it stands: of ways that are straight.
  virtual Vector3 displacement_slope(std::size_t index, double /*factor*/) const { return displacement(index, 1); }
  /// Frees the molecules from number `first` of the held ones on.
  void free_from(Model& model, std::size_t first);

  /// Holds molecules in all directions; a molecule must not be held twice.
  void fix_fully(const std::vector<int>& molecules);
  /// What the supports' forces [N] have grown by since the start.
  static Positions pull_of(const Start& start, const StaticResult& solved) {
    return solved.reactions - start.reactions;
  }
  /// Σ f xᵀ [N m] of the held molecules, at `positions`: the volume times the mean stress of a body in balance.
  Matrix3 virial(const Positions& pull, const Positions& positions) const;
  /// Energy, and the balance of all forces relative to `scale` [N].
  static void add_state(const Model& model, const State& state, const StaticResult& solved, double scale,
                        Measures& measures);

  const Body& body_;
  std::vector<Fixed> fixed_;
  double factor_ = 1;      ///< of the load that was set last
  bool released_ = false;  ///< whether the driven end of the model that was held last was let go

 private:
  int load_steps_;
};

}  // namespace elastin::lab
