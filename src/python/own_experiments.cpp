#include <pybind11/eigen.h>

#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/run/common_measures.h"
#include "python/bind.h"

namespace elastin::python {
using namespace lab;
namespace {

/// What an object of Python says of its experiment: hold(body), measure(body, positions, reactions), measures.
struct Described {
  std::shared_ptr<py::object> own;
  std::string name, summary;
  MeasureList measures;
  int load_steps;
};

/// A fixed molecule and where it is at the end of the load.
struct Moved {
  Support support;
  Vector3 displacement;  ///< [m]
};

class OwnExperiment final : public StaticExperiment {
 public:
  OwnExperiment(Described described, const Body& body) : described_(std::move(described)), size_(body.size()) {
    body_ = keep(py::cast(std::make_shared<Body>(body)));
    hold(described_.own->attr("hold")(*body_));
    const py::object forces = described_.own->attr("forces")(*body_);
    if (!forces.is_none()) forces_ = of_molecules(forces, "forces");
  }

  std::string name() const override { return described_.name; }
  MeasureList measures() const override { return described_.measures; }
  int load_steps() const override { return described_.load_steps; }
  const StaticExperiment* calibration() const override { return nullptr; }
  std::string no_reference() const override { return "an experiment of one's own prescribes no value"; }
  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    std::vector<MainMeasure> names;
    for (const MeasureInfo& info : described_.measures) names.push_back({info.name});
    return names;
  }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;

 private:
  friend class OwnRig;
  Positions of_molecules(const py::handle& given, const char* what) const {
    Positions vectors = positions_from(given, what);
    if (vectors.cols() != size_)
      throw InputError(described_.name + ": " + what + " have " + std::to_string(vectors.cols()) +
                       " rows; the body has " + std::to_string(size_) + " molecules");
    return vectors;
  }
  /// Pairs (molecules, displacement [m]) or triples with the directions that stay free.
  void hold(const py::object& held) {
    std::vector<char> seen(static_cast<std::size_t>(size_), 0);
    for (const py::handle item : held) {
      const auto parts = entry_of<py::sequence>(item, described_.name + ".hold", "(molecules, displacement[, free])");
      if (parts.size() < 2 || parts.size() > 3)
        throw InputError(described_.name + ".hold: an item has " + std::to_string(parts.size()) +
                         " parts; allowed: (molecules, displacement) or (molecules, displacement, free)");
      const std::string name = described_.name + ".hold";
      const std::vector<int> molecules = entry_of<ChosenNumbers>(parts[0], name, "numbers of molecules, or a mask")
                                             .of(static_cast<std::size_t>(size_), name, "molecule");
      const py::object displacement = parts[1];
      const bool each = py::len(displacement) != 3 || py::isinstance<py::sequence>(displacement[py::int_(0)]) ||
                        py::hasattr(displacement[py::int_(0)], "__len__");
      const Positions by = each ? positions_from(displacement, "displacement")
                                : Positions(entry_of<Vector3>(displacement, "displacement", "three numbers [m]")
                                                .replicate(1, static_cast<Eigen::Index>(molecules.size())));
      if (static_cast<std::size_t>(by.cols()) != molecules.size())
        throw InputError(described_.name + ".hold: displacement has " + std::to_string(by.cols()) + " rows for " +
                         std::to_string(molecules.size()) + " molecules");
      const Matrix3 free = parts.size() == 3 ? free_directions(parts[2]) : Matrix3(Matrix3::Zero());
      for (std::size_t i = 0; i < molecules.size(); ++i) {
        if (molecules[i] < 0 || molecules[i] >= size_)
          throw InputError(described_.name + ".hold: no molecule " + std::to_string(molecules[i]) +
                           ": the body has molecules 0 to " + std::to_string(size_ - 1));
        if (seen[static_cast<std::size_t>(molecules[i])]++)
          throw InputError(described_.name + ".hold: molecule " + std::to_string(molecules[i]) + " is held twice");
        moved_.push_back({{molecules[i], free}, by.col(static_cast<Eigen::Index>(i))});
      }
    }
  }

  Described described_;
  int size_;
  std::shared_ptr<py::object> body_;
  std::vector<Moved> moved_;
  Positions forces_;  ///< [N]; empty: none
};

class OwnRig final : public StaticRig {
 public:
  OwnRig(const OwnExperiment& experiment, Model& model) : experiment_(experiment), model_(model) {
    for (const Moved& moved : experiment.moved_) model.supports.push_back(moved.support);
    if (experiment.forces_.cols() == 0) return;
    std::vector<int> all(static_cast<std::size_t>(model.body().size()));
    for (int molecule = 0; molecule < model.body().size(); ++molecule) all[molecule] = molecule;
    auto loads = std::make_unique<PointLoads>(model.body(), all, experiment.forces_);
    loads_ = loads.get();
    model.add(std::move(loads));
  }
  void set_load(double factor) override {
    for (std::size_t i = 0; i < experiment_.moved_.size(); ++i)
      model_.supports[i].displacement = factor * experiment_.moved_[i].displacement;
    if (loads_) loads_->set_factor(factor);
  }
  void release(const State& /*loaded*/) override { set_load(0); }
  Measures measure(const Start&, const State& state, const StaticOptions&, StaticResult& solved) const override {
    Positions reactions = Positions::Zero(3, state.positions.cols());
    for (std::size_t i = 0; i < model_.supports.size(); ++i)
      reactions.col(model_.supports[i].molecule) = solved.reactions.col(static_cast<Eigen::Index>(i));
    Measures measures;
    Signals::guarded(
        [&] {
          const auto array = [](const Positions& vectors) {
            return py::array_t<double>({vectors.cols(), Eigen::Index{3}}, vectors.data());
          };
          const Described& described = experiment_.described_;
          const auto found = entry_of<py::dict>(
              described.own->attr("measure")(*experiment_.body_, array(state.positions), array(reactions)),
              described.name + ".measure", "a dict, a number by the name of its measure");
          for (const auto& [name, value] : found)
            measures.set(described.measures.at(word_of(name, "a measure")).name, number_of(value, "a measure"));
          return true;
        },
        false);
    add_state(model_, state, solved, std::max(reactions.norm(), solved.scale), measures);
    return measures;
  }

 private:
  const OwnExperiment& experiment_;
  Model& model_;
  PointLoads* loads_ = nullptr;
};

std::unique_ptr<StaticRig> OwnExperiment::make_rig(Model& model) const {
  return std::make_unique<OwnRig>(*this, model);
}

/// The quantity of an SI unit; of a torque the unit's own name is kept.
MeasureInfo measure_in(const std::string& name, const std::string& unit, const std::string& owner) {
  using namespace dimension;
  if (unit == "N m") return {.name = name, .unit = energy, .text = "of " + owner, .unit_name = unit};
  std::string allowed = "N m";
  for (const Dimension& known : {none, length, area, volume, mass, time, force, pressure, density, velocity,
                                 acceleration, stiffness, damping, viscosity, energy, Dimension{0, 0, -1}}) {
    if (si_unit(known) == unit) return {.name = name, .unit = known, .text = "of " + owner};
    allowed += ", '" + si_unit(known) + "'";
  }
  throw InputError(owner + ".measures: '" + unit + "' of " + name + " is no SI unit known here; allowed: " + allowed);
}

ExperimentInfo make_experiment(const py::object& own, const std::string& name, const std::string& summary,
                               const std::vector<std::pair<std::string, std::string>>& measures, int load_steps) {
  if (load_steps < 1) throw InputError(name + ".load_steps: is " + std::to_string(load_steps) + "; allowed: 1 or more");
  if (measures.empty()) throw InputError(name + ".measures: names nothing that is measured");
  Described described{keep(own), name, summary, {}, load_steps};
  for (const auto& [measure, unit] : measures) described.measures.add(MeasureList{{measure_in(measure, unit, name)}});
  described.measures.response = {{"load", measures.front().first, false}};
  return {.name = name,
          .summary = summary,
          .make = [described](const ExperimentContext& context,
                              const ParameterValues&) -> std::unique_ptr<lab::Experiment> {
            const py::gil_scoped_acquire locked;
            return std::make_unique<OwnExperiment>(described, context.body);
          },
          .measures = described.measures};
}

}  // namespace

void add_own_experiments(py::module_& module) {
  py::class_<ExperimentInfo>(module, "_Experiment")
      .def(py::init(&make_experiment), py::arg("own"), py::arg("name"), py::arg("summary"), py::arg("measures"),
           py::arg("load_steps"));
}

}  // namespace elastin::python
