#include "febio/experiment.h"

#include <map>

#include "core/linear/sparse_factor.h"

namespace elastin::febio {
namespace {

/// Where the analysis stands.
struct Moment {
  double time = 0;
  int step = 0;  ///< in force on the way to this time
};

class Experiment final : public StaticExperiment {
 public:
  Experiment(const Body& body, std::shared_ptr<const ExperimentSetup> setup) : body_(body), setup_(std::move(setup)) {
    for (const DrivenComponent& driven : setup_->driven) driven_[driven.molecule].push_back(&driven);
    for (const Step& step : setup_->steps)
      increments_ += static_cast<int>(step.increments.size()), dynamic_ |= step.dynamic;
    if (setup_->steps.front().dynamic) find_first_accelerations();
  }

  std::string name() const override { return "febio"; }
  MeasureList measures() const override { return {}; }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  int load_steps() const override { return increments_; }
  std::vector<MainMeasure> main_measures(const elastin::Material&, const Measures&) const override {
    return {{"solution_norm"}, {"energy"}};
  }
  std::string no_reference() const override { return "its displacements belong to this model, not to the material"; }
  /// A body in motion needs no supports.
  bool stiffened_by_load() const override { return dynamic_; }

 private:
  friend class ExperimentRig;

  Moment moment(double factor) const {
    double left = factor * increments_;
    Moment now;
    for (std::size_t step = 0; step < setup_->steps.size(); ++step) {
      const std::vector<double>& own = setup_->steps[step].increments;
      const auto count = static_cast<double>(own.size());
      now.step = static_cast<int>(step);
      for (std::size_t i = 0; i < own.size(); ++i)
        now.time += own[i] * std::clamp(left - static_cast<double>(i), 0., 1.);
      if (left <= count * (1 + 1e-12)) break;
      left -= count;
    }
    return now;
  }

  /// The last that is in force for each component of a molecule, or null.
  std::array<const DrivenComponent*, 3> in_force(const std::vector<const DrivenComponent*>& driven, int step) const {
    std::array<const DrivenComponent*, 3> result{};
    for (const DrivenComponent* one : driven)
      if (one->step < 0 || one->step == step) result[one->axis] = one;
    return result;
  }

  /// M a = F of the loads at time 0, in the free components.
  void find_first_accelerations() {
    Positions forces = Positions::Zero(3, body_.size());
    State rest = state_at_rest(body_);
    make_dead_loads(body_, setup_->dead_loads)->add_forces(rest, forces);
    for (const SurfaceLoad& load : setup_->surface_loads) make_surface_load(body_, load)->add_forces(rest, forces);
    accelerations_ = Positions::Zero(3, body_.size());
    if (forces.isZero(0)) return;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<int> row(static_cast<std::size_t>(body_.size()), 0);
      for (const auto& [molecule, driven] : driven_)
        if (in_force(driven, 0)[axis]) row[molecule] = -1;
      std::vector<Eigen::Triplet<double>> entries;
      std::vector<char> heavy(row.size(), 0);
      for (const MassPair& pair : setup_->mass) heavy[pair.a] = 1;
      int free = 0;
      for (std::size_t a = 0; a < row.size(); ++a) row[a] = row[a] < 0 || !heavy[a] ? -1 : free++;
      if (free == 0) continue;
      for (const MassPair& pair : setup_->mass) {
        const int a = row[pair.a], b = row[pair.b];
        if (a >= 0 && b >= 0) entries.emplace_back(a, b, pair.mass);
      }
      Eigen::SparseMatrix<double> mass(free, free);
      mass.setFromTriplets(entries.begin(), entries.end());
      VectorX load(free);
      for (std::size_t a = 0; a < row.size(); ++a)
        if (row[a] >= 0) load[row[a]] = forces(axis, static_cast<Eigen::Index>(a));
      const VectorX solved = SparseFactor(mass).solve(load);
      for (std::size_t a = 0; a < row.size(); ++a)
        if (row[a] >= 0) accelerations_(axis, static_cast<Eigen::Index>(a)) = solved[row[a]];
    }
  }

  const Body& body_;
  std::shared_ptr<const ExperimentSetup> setup_;
  std::map<int, std::vector<const DrivenComponent*>> driven_;  // by molecule
  int increments_ = 0;
  bool dynamic_ = false;
  Positions accelerations_;
};

class ExperimentRig final : public StaticRig {
 public:
  ExperimentRig(const Experiment& experiment, Model& model) : experiment_(experiment), model_(model) {
    const ExperimentSetup& setup = *experiment.setup_;
    const Body& body = experiment.body_;
    for (const auto& [molecule, driven] : experiment.driven_) model.supports.push_back({molecule});
    *setup.clock = {};
    stiffness_ = 1e3 * model.elastic_forces(1.001 * body.rest).norm();
    if (!setup.dead_loads.empty()) add(make_dead_loads(body, setup.dead_loads));
    for (const SurfaceLoad& load : setup.surface_loads) add(make_surface_load(body, load));
    if (!setup.springs.empty()) add(make_linear_springs(body, setup.springs));
    for (std::size_t i = 0; i < setup.gaps.size(); ++i)
      add(make_gap_constraint(body, setup.gaps[i], static_cast<int>(i)));
    for (const DilatationConstraint& dilatation : setup.dilatations) add(make_dilatation_constraint(body, dilatation));
    for (std::size_t i = 0; i < setup.volumes.size(); ++i)
      add(make_volume_constraint(body, setup.volumes[i], static_cast<int>(i)));
    if (!experiment.dynamic_) return;
    auto inertia = make_inertia(
        body, setup.mass,
        experiment.accelerations_.size() ? experiment.accelerations_ : Positions(Positions::Zero(3, body.size())));
    inertia_ = inertia.get();
    add(std::move(inertia));
  }

  void set_load(double factor) override {
    now_ = experiment_.moment(factor);
    const Step& step = experiment_.setup_->steps[now_.step];
    *experiment_.setup_->clock = {now_.time, step.dynamic ? step.integration.alpha_force : 1};
    for (TimedLoad* load : loads_) {
      load->set_step(now_.step);
      load->set_time(now_.time);
      if (factor == 0) load->remove();
    }
    if (inertia_) inertia_->set_integration(step.dynamic ? &step.integration : nullptr);
    std::size_t support = 0;
    for (const auto& [molecule, all] : experiment_.driven_) {
      Support& own = model_.supports[support++];
      own.free = Matrix3::Identity();
      const auto driven = experiment_.in_force(all, now_.step);
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        if (const DrivenComponent* one = driven[axis]) {
          own.free(axis, axis) = 0;
          own.displacement[axis] = one->at(now_.time);
        }
    }
  }

  /// FEBio does not look for another branch.
  bool leaves_saddles() const override { return false; }

  Measures measure(const Start&, const State& state, const StaticOptions&, StaticResult& solved) const override {
    Measures measures;
    const bool stressed = solved.scale > 1e-12 * stiffness_;
    if (!stressed) solved.residual = 0;  // of rounding alone: a body that moves as a whole, or falls
    Positions free = state.positions - experiment_.body_.rest;
    for (const Support& support : model_.supports)
      free.col(support.molecule) = (support.free * free.col(support.molecule)).eval();
    measures.set("solution_norm", free.norm());
    if (model_.has_energy()) measures.set("energy", model_.elastic_energy(state.positions));
    const bool moving = experiment_.setup_->steps[now_.step].dynamic;
    if (!moving && stressed) {
      const Vector3 left = model_.load_forces(state).rowwise().sum() + solved.reactions.rowwise().sum();
      measures.set("reaction_balance", left.norm() / solved.scale);
    }
    return measures;
  }

 private:
  void add(std::unique_ptr<TimedLoad> load) {
    loads_.push_back(load.get());
    model_.add(std::move(load));
  }

  const Experiment& experiment_;
  Model& model_;
  std::vector<TimedLoad*> loads_;  // owned by the model
  Inertia* inertia_ = nullptr;     // one of them
  Moment now_;
  double stiffness_ = 0;  ///< [N] a strain, of the body as a whole
};

std::unique_ptr<StaticRig> Experiment::make_rig(Model& model) const {
  return std::make_unique<ExperimentRig>(*this, model);
}

}  // namespace

std::unique_ptr<StaticExperiment> make_experiment(const Body& body, std::shared_ptr<const ExperimentSetup> setup) {
  return std::make_unique<Experiment>(body, std::move(setup));
}

}  // namespace elastin::febio
