#include <pybind11/eigen.h>

#include <limits>

#include "core/solve/newton.h"
#include "core/solve/steppers.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

/// (n, 3), a copy: what a function of the caller's keeps does not change under it.
py::array_t<double> copied(const Positions& vectors) {
  return py::array_t<double>({vectors.cols(), Eigen::Index{3}}, vectors.data());
}

py::dict by_name(const ParameterValues& values) {
  py::dict named;
  for (const auto& [name, value] : values) named[name.c_str()] = value;
  return named;
}

/// Vectors [unit] of as many molecules as the body has.
Positions vectors_from(const py::handle& given, const char* name, Eigen::Index molecules) {
  Positions vectors = positions_from(given, name);
  if (vectors.cols() != molecules)
    throw InputError(std::string(name) + ": has " + std::to_string(vectors.cols()) + " rows; the body has " +
                     std::to_string(molecules) + " molecules");
  return vectors;
}

/// A load that a function gives: forces(body, positions, velocities, time, parameters), and its energy where it is
/// known. Newton's method sees how the force on each molecule changes with its own position and velocity, by
/// differences; that forces of others change too costs it iterations, and not the equilibrium.
struct OwnForces {
  std::shared_ptr<py::function> forces, energy;  ///< energy: null without one
  bool of_positions, of_velocities, of_time;     ///< what the forces look at
};

class OwnLoad final : public Load {
 public:
  OwnLoad(OwnForces own, const Body& body, const ParameterValues& values)
      : own_(std::move(own)), size_(body.radius.mean()) {
    const py::gil_scoped_acquire locked;
    body_ = keep(py::cast(std::make_shared<Body>(body)));
    values_ = keep(by_name(values));
  }
  void add_forces(const State& state, Positions& forces) const override {
    forces += forces_at(state.positions, state.velocities, state.time);
  }
  double energy(const State& state) const override {
    if (!own_.energy) return 0;
    return Signals::guarded(
        [&] { return called(*own_.energy, state.positions, state.velocities, state.time).cast<double>(); },
        kNotANumber);
  }
  bool changes() const override { return own_.of_positions || own_.of_velocities; }
  bool has_energy() const override { return static_cast<bool>(own_.energy); }
  bool symmetric() const override { return has_energy(); }
  bool steady() const override { return has_energy() && !own_.of_time; }
  bool feels_velocity() const override { return own_.of_velocities; }
  void add_change(const State& state, const Positions& by_position, const Positions& by_velocity,
                  Positions& change) const override {
    const Slopes& slopes = slopes_at(state);
    for (Eigen::Index i = 0; i < change.cols(); ++i) {
      change.col(i) -= slopes.stiffness[i] * by_position.col(i);
      if (own_.of_velocities && by_velocity.cols() == change.cols())
        change.col(i) -= slopes.damping[i] * by_velocity.col(i);
    }
  }
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    const Slopes& slopes = slopes_at(state);
    for (int i = 0; i < static_cast<int>(slopes.stiffness.size()); ++i)
      visit(i, i,
            slopes.stiffness[i] + (own_.of_velocities ? velocity_weight * slopes.damping[i] : Matrix3::Zero().eval()));
  }

 private:
  struct Slopes {
    Positions positions, velocities;  ///< at which they were taken
    double time = kNotANumber;
    std::vector<Matrix3> stiffness, damping;  ///< −∂F_a/∂x_a [N/m], −∂F_a/∂v_a [N s/m]
  };

  py::object called(const py::function& function, const Positions& positions, const Positions& velocities,
                    double time) const {
    const Positions at_rest = velocities.cols() ? Positions() : Positions(Positions::Zero(3, positions.cols()));
    return function(*body_, copied(positions), copied(velocities.cols() ? velocities : at_rest), time, *values_);
  }
  Positions forces_at(const Positions& positions, const Positions& velocities, double time) const {
    return Signals::guarded(
        [&] { return vectors_from(called(*own_.forces, positions, velocities, time), "forces", positions.cols()); },
        Positions(Positions::Constant(3, positions.cols(), kNotANumber)));
  }
  const Slopes& slopes_at(const State& state) const {
    Slopes& known = slopes_;
    if (known.time == state.time && known.positions == state.positions && known.velocities == state.velocities)
      return known;
    known = {state.positions, state.velocities, state.time, {}, {}};
    const Positions velocities =
        state.velocities.cols() ? state.velocities : Positions(Positions::Zero(3, state.positions.cols()));
    const auto slopes = [&](double step, const auto& forces_with) {
      std::vector<Matrix3> blocks(static_cast<std::size_t>(state.positions.cols()), Matrix3::Zero());
      for (int axis = 0; axis < 3; ++axis) {
        Vector3 by = Vector3::Zero();
        by[axis] = step;
        const Positions difference = (forces_with(Vector3(-by)) - forces_with(by)) / (2 * step);
        for (std::size_t i = 0; i < blocks.size(); ++i)
          blocks[i].col(axis) = difference.col(static_cast<Eigen::Index>(i));
      }
      if (has_energy())
        for (Matrix3& block : blocks) block = (block + block.transpose()).eval() / 2;
      return blocks;
    };
    known.stiffness = slopes(1e-4 * size_, [&](const Vector3& by) {
      return forces_at(state.positions.colwise() + by, velocities, state.time);
    });
    if (own_.of_velocities)
      known.damping = slopes(1e-4 * (1e-3 + velocities.cwiseAbs().maxCoeff()), [&](const Vector3& by) {
        return forces_at(state.positions, velocities.colwise() + by, state.time);
      });
    return known;
  }

  OwnForces own_;
  double size_;  ///< [m], of a molecule
  std::shared_ptr<py::object> body_;
  std::shared_ptr<py::dict> values_;
  mutable Slopes slopes_;  // of the state that was requested last
};

std::shared_ptr<LoadKind> make_load(const Descriptor& row, const py::function& forces,
                                    const std::optional<py::function>& energy, bool of_positions, bool of_velocities,
                                    bool of_time) {
  const OwnForces own{keep(forces), energy ? keep(*energy) : nullptr, of_positions, of_velocities, of_time};
  auto kind = std::make_shared<LoadKind>();
  static_cast<Descriptor&>(*kind) = row;
  kind->add = [own](Model& model, const LoadValues& values, const Material*) {
    model.add(std::make_unique<OwnLoad>(own, model.body(), values.numbers));
  };
  return kind;
}

/// A step that a function makes: step(body, positions, velocities, forces, masses, dt, time, parameters) gives
/// positions and velocities at its end. Supports then have what is theirs.
class OwnStepper final : public Stepper {
 public:
  OwnStepper(std::shared_ptr<py::function> step, const ParameterValues& values) : step_(std::move(step)) {
    const py::gil_scoped_acquire locked;
    values_ = keep(by_name(values));
  }

  StepResult advance(Model& model, State& state, double dt) override {
    model.declare_history(state);
    State next = state;
    next.time = state.time + dt;
    next.accelerations.resize(3, 0);
    model.begin_step(state, next.time);
    if (model.drive) model.drive(next.time, model.supports);
    StepResult result;
    if (!step(model, state, dt, next)) {
      result.outcome = Outcome::interrupted;
      result.cause = "its function raised an exception";
    } else {
      apply_supports(model, next.positions);
      move_with_supports(model.supports, next.velocities);
      if (!next.positions.allFinite() || !next.velocities.allFinite()) {
        result.outcome = Outcome::diverged;
        result.cause = "the next step has no finite positions and velocities: the step is too long";
      } else if (!model.admissible(next.positions)) {
        result.outcome = Outcome::inverted;
        result.cause = inverted_text(model.body(), next.positions);
      } else if (model.max_step_fraction(state, next) < 1) {
        result.outcome = Outcome::limit_reached;
        result.cause = "something would be passed through: the step is too long";
      } else {
        model.commit_step(next);
        std::swap(state, next);
        return result;
      }
    }
    if (model.drive) model.drive(state.time, model.supports);
    return result;
  }

 private:
  bool step(Model& model, const State& state, double dt, State& next) const {
    return Signals::guarded(
        [&] {
          // The function of the forces may outlive the step; what it needs does not.
          const auto within = std::make_shared<bool>(true);
          State at = next;
          const py::cpp_function forces([&, within](const py::object& positions, const py::object& velocities) {
            if (!*within) throw InputError("forces: may be called within the step alone");
            at.positions = vectors_from(positions, "positions", state.positions.cols());
            at.velocities = vectors_from(velocities, "velocities", state.positions.cols());
            Positions all(3, at.positions.cols());
            {
              const py::gil_scoped_release others_run;
              model.set_forces(at, all);
              keep_free(model.supports, all);
            }
            return copied(all);
          });
          const VectorX& mass = model.body().mass;
          const py::array_t<double> masses({mass.size()}, mass.data());
          const struct End {
            bool& within;
            ~End() { within = false; }
          } end{*within};
          const auto [positions, velocities] = entry_of<std::pair<py::object, py::object>>(
              (*step_)(std::make_shared<Body>(model.body()), copied(state.positions), copied(state.velocities), forces,
                       masses, dt, state.time, *values_),
              "what the step returns", "positions and velocities, (n, 3) each");
          next.positions = vectors_from(positions, "positions", state.positions.cols());
          next.velocities = vectors_from(velocities, "velocities", state.positions.cols());
          return true;
        },
        false);
  }

  std::shared_ptr<py::function> step_;
  std::shared_ptr<py::dict> values_;
};

std::shared_ptr<StepperKind> make_stepper(const Descriptor& row, const py::function& step, bool is_explicit,
                                          int order) {
  auto stepper = std::make_shared<StepperKind>();
  static_cast<Descriptor&>(*stepper) = row;
  stepper->is_explicit = is_explicit;
  stepper->order = order;
  stepper->make = [kept = keep(step)](const ParameterValues& values, const StaticOptions&) {
    return std::make_unique<OwnStepper>(kept, values);
  };
  return stepper;
}

Descriptor descriptor(const std::string& name, const std::vector<ParameterInfo>& parameters, const std::string& summary,
                      const std::string& source) {
  return {name, summary, source, parameters};
}

}  // namespace

void add_own_loads(py::module_& module) {
  py::class_<LoadKind, Descriptor, std::shared_ptr<LoadKind>>(module, "Load", py::dynamic_attr(),
                                                              "A load of one's own, see elastin.load.")
      .def("__reduce__", [](const py::object& self) { return self.attr("_made_by"); });
  py::class_<StepperKind, Descriptor, std::shared_ptr<StepperKind>>(module, "Stepper", py::dynamic_attr(),
                                                                    "A stepper of one's own, see elastin.stepper.")
      .def("__reduce__", [](const py::object& self) { return self.attr("_made_by"); });
  module.def("_load",
             [](const std::string& name, const std::vector<ParameterInfo>& parameters, const std::string& summary,
                const std::string& source, const py::function& forces, const std::optional<py::function>& energy,
                bool of_positions, bool of_velocities, bool of_time) {
               return make_load(descriptor(name, parameters, summary, source), forces, energy, of_positions,
                                of_velocities, of_time);
             });
  module.def("_stepper",
             [](const std::string& name, const std::vector<ParameterInfo>& parameters, const std::string& summary,
                const std::string& source, const py::function& step, bool is_explicit, int order) {
               return make_stepper(descriptor(name, parameters, summary, source), step, is_explicit, order);
             });
}

}  // namespace elastin::python
