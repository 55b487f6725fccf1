#include "elastin/core/simulation/simulation.h"

#include <pybind11/eigen.h>

#include <algorithm>
#include <variant>

#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/simulation/saved_state.h"
#include "elastin/core/solve/sensitivity.h"
#include "elastin/core/solve/trajectory.h"
#include "elastin/mesh/voronoi.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

using GivenMaterial = std::variant<Material, std::vector<Material>, py::dict, py::str>;

/// Words are read as those of a scene's material.
struct ReadMaterial {
  using Read = std::variant<Material, std::vector<Material>>;
  Read operator()(const Material& material) const { return material; }
  Read operator()(const std::vector<Material>& of_parts) const { return of_parts; }
  Read operator()(const py::object& words) const {
    return py::module_::import("elastin").attr("material")(words).cast<Material>();
  }
};

std::shared_ptr<Moving> make_simulation(const std::shared_ptr<Body>& body, const py::object& strategy,
                                        const GivenMaterial& given_material, const GivenStepper& stepper, double safety,
                                        int max_substeps, const ParameterValues& stepper_parameters,
                                        const ParameterValues& parameters, double budget,
                                        const std::shared_ptr<Catalog>& given) {
  const Catalog catalog = given ? *given : built_in_catalog();
  SimulationOptions options =
      simulation_options(catalog, stepper, safety, max_substeps, stepper_parameters, parameters);
  options.budget = budget;
  const auto material = std::visit(ReadMaterial(), given_material);
  const Strategy chosen = strategy_from(strategy, catalog);
  const py::object chosen_by = py::isinstance<py::str>(strategy) && given ? py::cast(chosen) : strategy;
  const py::dict keywords(py::arg("stepper") = stepper, py::arg("safety") = safety,
                          py::arg("max_substeps") = max_substeps, py::arg("stepper_parameters") = stepper_parameters,
                          py::arg("parameters") = parameters, py::arg("budget") = budget);
  const auto recipe = keep(py::make_tuple(py::module_::import("elastin._elastin").attr("Simulation"),
                                          py::make_tuple(body, chosen_by, material), keywords, py::list()));
  const auto* of_parts = std::get_if<std::vector<Material>>(&material);
  if (of_parts && of_parts->empty()) throw InputError("material: the list of the parts' materials is empty");
  if (of_parts && of_parts->size() > 1 && body->parts.empty())
    throw InputError("material: a list of " + std::to_string(of_parts->size()) +
                     " for a body without parts, which has one; of_parts makes bodies that have several");
  std::vector<std::string> warnings;
  auto made = interruptible([&] {
    const Strategy at_work = of_parts ? in_parts(chosen, *body, *of_parts, &catalog) : chosen;
    const Material& first = of_parts ? of_parts->front() : std::get<Material>(material);
    Body own = *body;
    if (of_parts) take_density(own, *of_parts);
    auto simulation = std::make_shared<Moving>(Simulation(std::move(own), at_work, first, options));
    warnings = simulation->simulation.warnings(false);
    return simulation;
  });
  made->recipe = recipe;
  for (const std::string& warning : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  return made;
}

/// How to make it again, and the state that it is in.
py::tuple reduced_simulation(Moving& self) {
  if (!self.recipe) throw py::type_error("nobody has said how to make this simulation again");
  const std::vector<char> bytes = self.in_turn([](Simulation& s) { return bytes_of(s.save()); });
  return py::make_tuple(py::module_::import("elastin._again").attr("simulation"),
                        py::make_tuple(*self.recipe, py::bytes(bytes.data(), bytes.size())));
}

py::object simulation_again(const py::tuple& recipe, const py::bytes& state) {
  const py::object made = recipe[0](*recipe[1].cast<py::tuple>(), **recipe[2].cast<py::dict>());
  for (const py::handle call : recipe[3]) {
    const auto [method, keywords] = call.cast<std::pair<std::string, py::dict>>();
    made.attr(method.c_str())(**keywords);
  }
  const auto text = static_cast<std::string>(state);
  made.cast<Moving&>().in_turn([&](Simulation& s) { s.restore(simulation_state_of(text.data(), text.size())); });
  return made;
}

/// Raises StepError with the result, unless all went well or the caller looks for himself.
template <class Result>
Result checked(Result result, bool check) {
  if (!check || result.outcome == Outcome::converged) return result;
  const py::object type = py::module_::import("elastin._elastin").attr("StepError");
  const py::object error = type(std::string(elastin::name_of(result.outcome)) + ": " + result.cause);
  error.attr("result") = py::cast(result);
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

/// Steps until one fails, a function of the caller's raises or Ctrl-C comes.
StepResult step(Moving& self, double dt, int count, bool check) {
  if (count < 1) throw InputError("count: is " + std::to_string(count) + "; allowed: 1 or more");
  if (!(dt > 0)) throw InputError("dt: is " + std::to_string(dt) + "; allowed: above 0 s");
  const StepResult last = self.in_turn([&](Simulation& simulation) {
    if (self.stepping) throw InputError("an observer must not step the simulation that it observes");
    StepResult result;
    self.stepping = true;
    for (int i = 0; i < count && result.outcome == Outcome::converged; ++i) {
      result = simulation.step(dt);
      if (count > 1 && stop_requested()) break;
    }
    self.stepping = false;
    return result;
  });
  return checked(last, check);
}

void observe(Moving& self, py::function see, int every) {
  const auto call = [&self, kept = keep(std::move(see))](const Simulation&) {
    const Within between_steps(self.in_use, false);
    Signals::guarded([&] { return (*kept)(py::cast(&self)), true; }, true);
  };
  self.in_turn([&](Simulation& simulation) { simulation.observe(every, call); });
}

/// The values of a load as keywords give them.
LoadValues load_values(const LoadKind& load, const py::kwargs& given, std::size_t molecules) {
  LoadValues values;
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    const ValueKind kind = named(load.parameters, name, load.name + " has no '" + name + "'").kind;
    if (kind == ValueKind::molecules)
      values.molecules[name] = entry_of<ChosenNumbers>(value, name, "a list of numbers of molecules, or a mask")
                                   .of(molecules, name, "molecule");
    else if (kind == ValueKind::vector || kind == ValueKind::direction)
      values.vectors[name] = entry_of<Vector3>(value, name, "three numbers");
    else
      values.numbers[name] = number_of(value, name);
  }
  return values;
}

/// A method that changes the simulation, in its turn.
template <class Act>
auto in_turn(Act act) {
  return [act](Moving& self) { return self.in_turn(act); };
}

/// What a view holds on to: the simulation, and its arrays of the present topology.
py::capsule owner_of_views(const py::object& self) {
  using Owner = std::pair<py::object, std::shared_ptr<Moving::Generation>>;
  auto owner = std::make_unique<Owner>(self, self.cast<Moving&>().generation);
  return {owner.release(), [](void* held) { delete static_cast<Owner*>(held); }};
}

/// A view of what a simulation shows; `show` may have to compute it.
template <class Show>
auto shown(Show show) {
  return [show](const py::object& self) {
    auto& moving = self.cast<Moving&>();
    const auto* values = moving.in_turn([&](Simulation& simulation) { return &show(simulation); });
    return view(*values, owner_of_views(self));
  };
}

/// A view of what need not be computed.
template <class Show>
auto known(Show show) {
  return [show](const py::object& self) {
    const auto* values = self.cast<Moving&>().look([&](Simulation& simulation) { return &show(simulation); });
    return view(*values, owner_of_views(self));
  };
}

using Class = MovingClass;

void add_views(Class& simulation) {
  simulation
      .def_property_readonly("body",
                             [](const std::shared_ptr<Moving>& self) {
                               using Owner = std::pair<std::shared_ptr<Moving>, std::shared_ptr<Moving::Generation>>;
                               const auto owner = std::make_shared<Owner>(self, self->generation);
                               return std::shared_ptr<Body>(owner, const_cast<Body*>(&self->simulation.body()));
                             })
      .def_property_readonly(
          "time", [](const Moving& self) { return self.simulation.time(); }, "[s]")
      .def_property(
          "positions", known([](Simulation & s) -> auto& { return s.positions(); }),
          [](Moving& self, const py::object& positions) {
            const Positions values = positions_from(positions, "positions");
            self.in_turn([&](Simulation& s) { s.set_positions(values); });
          },
          "[m], (n, 3): a view that changes with each step. To be set between steps where the body is to "
          "be elsewhere: velocities stay, and supports where they are.")
      .def_property(
          "velocities", known([](Simulation & s) -> auto& { return s.velocities(); }),
          [](Moving& self, const py::object& velocities) {
            const Positions values = positions_from(velocities, "velocities");
            self.in_turn([&](Simulation& s) { s.set_velocities(values); });
          },
          "[m/s], (n, 3): a view that changes with each step. May be set between steps.")
      .def_property_readonly("forces", shown([](Simulation & s) -> auto& { return s.forces(); }),
                             "All forces of the state reached [N], (n, 3): a view. Asking for it fills it: a view that "
                             "was requested before a step shows that earlier state until it is requested again.")
      .def_property_readonly("tensions", shown([](Simulation & s) -> auto& { return s.tensions(); }),
                             "Of each connection [N], pulling is positive, (m,): a view, as forces.")
      .def_property_readonly(
          "host_forces",
          [](const py::object& self) {
            Positions& forces = *self.cast<Moving&>().in_turn([](Simulation& s) { return &s.host_forces(); });
            return view(forces, owner_of_views(self), true);
          },
          "Forces of one's own [N], (n, 3): a view to write to. They act from the next step on until changed.");
}

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Does it with each of them, in one turn; nothing where one of them is no molecule.
template <class Act>
void for_each(Moving& self, const ChosenNumbers& molecules, const Act& act) {
  self.in_turn([&](Simulation& s) {
    const std::vector<int>& all = molecules.of(static_cast<std::size_t>(s.body().size()), "molecule", "molecule");
    for (const int molecule : all)
      if (molecule < 0 || molecule >= s.body().size())
        throw InputError("no molecule " + std::to_string(molecule) + ": the body has molecules 0 to " +
                         std::to_string(s.body().size() - 1));
    for (const int molecule : all) act(s, molecule);
  });
}

void add_hands(Class& simulation) {
  simulation
      .def(
          "fix",
          [](Moving& self, const ChosenNumbers& molecule, const py::object& free) {
            const Matrix3 directions = free_directions(free);
            for_each(self, molecule, [&](Simulation& s, int one) { s.fix(one, directions); });
          },
          py::arg("molecule"), py::arg("free") = "",
          "Holds a molecule, or each of an array or a mask of them, where it is, but in the directions that `free` "
          "names: 'z', "
          "'xy', "
          "or a 3 x 3 projector.")
      .def(
          "release",
          [](Moving& self, const ChosenNumbers& molecule) {
            for_each(self, molecule, [](Simulation& s, int one) { s.release(one); });
          },
          py::arg("molecule"), "Releases a fixed molecule, or each of an array of them.")
      .def(
          "move_to",
          [](Moving& self, const ChosenNumbers& molecule, const py::object& position) {
            const Positions places = molecule.single
                                         ? Positions(entry_of<Vector3>(position, "position", "three numbers"))
                                         : positions_from(position, "position");
            const std::size_t wanted = molecule.all.size();
            if (static_cast<std::size_t>(places.cols()) != wanted)
              throw InputError("position: has " + std::to_string(places.cols()) + " rows for " +
                               std::to_string(wanted) + " molecules");
            Eigen::Index next = 0;
            for_each(self, molecule, [&](Simulation& s, int one) { s.move_to(one, places.col(next++)); });
          },
          py::arg("molecule"), py::arg("position"),
          "Where a held molecule is to be at the end of the next step [m]; of an array of them (k, 3).")
      .def(
          "reaction",
          [](Moving& self, const ChosenNumbers& molecule) -> py::object {
            Positions reactions(3, 0);
            for_each(self, molecule, [&](Simulation& s, int one) {
              reactions.conservativeResize(3, reactions.cols() + 1);
              reactions.rightCols<1>() = s.reaction(one);
            });
            if (molecule.single) return py::cast(Vector3(reactions.col(0)));
            return py::cast(Rows(reactions.transpose()));
          },
          py::arg("molecule"),
          "Force of its support on a held molecule [N]; zero where nothing holds it. Of an array of them (k, 3).")
      .def(
          "couple",
          [](Moving& self, int molecule, const Vector3& position, double stiffness, double damping) {
            return self.in_turn([&](Simulation& s) { return s.couple(molecule, position, stiffness, damping); });
          },
          py::arg("molecule"), py::arg("position"), py::arg("stiffness"), py::arg("damping") = 0.,
          "A spring [N/m] and damper [N s/m] between a molecule and a position [m]: a tool. Gives the coupling's "
          "number.")
      .def(
          "move_coupling",
          [](Moving& self, CouplingId coupling, const Vector3& position, const Vector3& velocity) {
            self.in_turn([&](Simulation& s) { s.move_coupling(coupling, position, velocity); });
          },
          py::arg("coupling"), py::arg("position"), py::arg("velocity") = Vector3(Vector3::Zero()), "[m], [m/s]")
      .def(
          "coupling_force",
          [](Moving& self, CouplingId coupling) {
            return self.in_turn([&](Simulation& s) { return s.coupling_force(coupling); });
          },
          py::arg("coupling"),
          "Force of the coupling on its molecule [N] in the state reached. Under newmark and energy_momentum that of a "
          "stiff coupling swings about its mean from one step to the next, where the step is long for the coupling's "
          "own vibration: take backward_euler or generalized_alpha there.")
      .def(
          "decouple",
          [](Moving& self, CouplingId coupling) { self.in_turn([&](Simulation& s) { s.decouple(coupling); }); },
          py::arg("coupling"));
}

template <class Act>
auto with_sensitivity(Moving& self, const Act& act) {
  return self.in_turn([&](Simulation& s) {
    Sensitivity sensitivity = s.sensitivity();
    return act(s, sensitivity);
  });
}

Positions given_or_zero(const py::object& given, const char* name, const Moving& self) {
  const int molecules = self.simulation.body().size();
  if (given.is_none()) return Positions::Zero(3, molecules);
  Positions values = positions_from(given, name);
  if (values.cols() != molecules)
    throw InputError(std::string(name) + ": " + std::to_string(values.cols()) + " rows; the body has " +
                     std::to_string(molecules) + " molecules");
  return values;
}

void check_solve(const StaticResult& result) {
  if (result.outcome != Outcome::converged) throw InputError("no derivative at this equilibrium: " + result.cause);
}

/// Equal steps from a simulation's state, on its model, which is another one where its topology has changed.
struct KeptTrajectory {
  std::shared_ptr<Moving> of;
  std::shared_ptr<Moving::Generation> generation;
  Trajectory run;
};

py::dict trajectory_vjp(KeptTrajectory& self, const py::object& positions, const py::object& velocities) {
  const Positions of_positions = given_or_zero(positions, "positions", *self.of),
                  of_velocities = given_or_zero(velocities, "velocities", *self.of);
  const TrajectoryAdjoint found = self.of->in_turn([&](Simulation& s) {
    if (self.generation != self.of->generation) throw InputError("the body's topology has changed since these steps");
    TrajectoryAdjoint adjoint = self.run.adjoint([&](int number, const State&, Positions& of_x, Positions& of_v) {
      if (number == self.run.steps()) of_x += of_positions, of_v += of_velocities;
    });
    s.model().begin_step(s.state(), s.state().time);
    return adjoint;
  });
  return py::dict(py::arg("positions") = Rows(found.positions.transpose()),
                  py::arg("velocities") = Rows(found.velocities.transpose()),
                  py::arg("forces") = Rows(found.forces.transpose()), py::arg("stiffness") = found.stiffness);
}

void add_trajectory(py::module_& module, Class& simulation) {
  py::class_<KeptTrajectory>(module, "Trajectory", "Equal steps that can be differentiated, see Simulation.trajectory.")
      .def_property_readonly(
          "positions", [](const KeptTrajectory& self) { return Rows(self.run.end().positions.transpose()); },
          "Of the end [m], (n, 3).")
      .def_property_readonly(
          "velocities", [](const KeptTrajectory& self) { return Rows(self.run.end().velocities.transpose()); },
          "Of the end [m/s], (n, 3).")
      .def("vjp", &trajectory_vjp, py::arg("positions") = py::none(), py::arg("velocities") = py::none(),
           "What a function of the end changes with, by one sweep backward: from its derivatives by positions and "
           "velocities there, each (n, 3) or None, a dict of those by 'positions' and 'velocities' at the start and by "
           "'forces' on molecules throughout, each (n, 3), and a list, 'stiffness', as that of Simulation.vjp, whose "
           "arrays are empty where `rayleigh` damps by the stiffness.");
  simulation.def(
      "trajectory",
      [](const std::shared_ptr<Moving>& self, double dt, int steps, const std::string& stepper,
         const ParameterValues& parameters, const std::optional<std::string>& scheme) {
        return self->in_turn([&](Simulation& s) {
          StepperOptions options{scheme.value_or(stepper), parameters};
          options.newton.tolerance = 1e-12;
          KeptTrajectory kept{self, self->generation, Trajectory(s.model(), s.state(), dt, steps, options)};
          s.model().begin_step(s.state(), s.state().time);
          return kept;
        });
      },
      py::arg("dt"), py::arg("steps"), py::arg("stepper") = "symplectic_euler",
      py::arg("parameters") = ParameterValues(), py::kw_only(), py::arg("scheme") = py::none(),
      "Takes equal steps by dt [s] from the present state, which stays as it is, so that their end can be "
      "differentiated. Steppers: symplectic_euler, velocity_verlet, backward_euler, newmark, generalized_alpha, with "
      "their parameters by name; explicit ones must be given steps short enough, for no step is split. Nothing that "
      "acts on the body may change until the last vjp(). scheme: former name of stepper.");
}

void add_derivatives(Class& simulation) {
  simulation
      .def(
          "jvp",
          [](Moving& self, const py::object& forces, const py::object& displacement,
             const std::vector<VectorX>& stiffness) {
            Positions by = given_or_zero(forces, "forces", self);
            const Positions moved = given_or_zero(displacement, "displacement", self);
            Positions reactions = Positions::Zero(3, by.cols());
            const StaticResponse found = with_sensitivity(self, [&](Simulation& s, Sensitivity& sensitivity) {
              const auto& laws = s.model().elasticity();
              if (stiffness.size() > laws.size())
                throw InputError("stiffness: the body has " + counted(std::ssize(laws), "law"));
              for (std::size_t law = 0; law < stiffness.size(); ++law)
                if (stiffness[law].size() > 0) by += sensitivity.forces_by_stiffness(*laws[law], stiffness[law]);
              StaticResponse response = sensitivity.forward(by, moved);
              for (std::size_t i = 0; i < s.model().supports.size(); ++i)
                reactions.col(s.model().supports[i].molecule) =
                    response.result.reactions.col(static_cast<Eigen::Index>(i));
              return response;
            });
            check_solve(found.result);
            return py::make_tuple(Rows(found.motion.transpose()), Rows(reactions.transpose()));
          },
          py::kw_only(), py::arg("forces") = py::none(), py::arg("displacement") = py::none(),
          py::arg("stiffness") = std::vector<VectorX>(),
          "How positions and reactions, each (n, 3), of the equilibrium that settle() has found change with forces on "
          "all molecules and displacements of fixed ones, (n, 3), and the logarithms of the stiffness of all elements, "
          "a list as vjp() gives it: a derivative along these.")
      .def(
          "vjp",
          [](Moving& self, const py::object& positions, const py::object& reactions) {
            const Positions of_positions = given_or_zero(positions, "positions", self),
                            of_reactions = given_or_zero(reactions, "reactions", self);
            std::vector<VectorX> stiffness;
            const Adjoint found = with_sensitivity(self, [&](Simulation& s, Sensitivity& sensitivity) {
              Adjoint adjoint = sensitivity.adjoint(of_positions, of_reactions);
              for (const auto& law : s.model().elasticity())
                stiffness.push_back(sensitivity.by_stiffness(*law, adjoint));
              return adjoint;
            });
            check_solve(found.result);
            return py::dict(py::arg("forces") = Rows(found.forces.transpose()),
                            py::arg("displacement") = Rows(found.displacement.transpose()),
                            py::arg("stiffness") = stiffness);
          },
          py::arg("positions") = py::none(), py::arg("reactions") = py::none(),
          "What a function of the equilibrium that settle() has found changes with, by one linear solve: from its "
          "derivatives by positions and by reactions of fixed molecules, each (n, 3) or None, a dict of those by "
          "'forces' on molecules (n, 3), by the 'displacement' of fixed molecules (n, 3), and a list, 'stiffness', of "
          "arrays, one a law: by the logarithm of each element's stiffness, which is k dm/dk of a spring, and of a "
          "cell "
          "E dm/dE. An array is empty where a law is no sum of elements.");
}

void add_loads(Class& simulation) {
  simulation.def(
      "add_load",
      [](Moving& self, const std::variant<std::string, std::shared_ptr<LoadKind>>& load, const py::kwargs& values) {
        const auto* name = std::get_if<std::string>(&load);
        const LoadKind kind = name ? *built_in_loads().find(*name) : *std::get<std::shared_ptr<LoadKind>>(load);
        const LoadValues given = load_values(kind, values, static_cast<std::size_t>(self.simulation.body().size()));
        const LoadId id = self.in_turn([&](Simulation& s) { return s.add_load(kind, given); });
        values["load"] = load;
        self.record("add_load", values);
        return id;
      },
      py::arg("load").none(false),
      "Adds a load or damping, one of loads() or one's own (see elastin.load), at any time between steps: "
      "add_load('gravity', acceleration=(0, 0, -9.81)). Gives its number for set_load and remove_load.");
  simulation.def(
      "set_load",
      [](Moving& self, LoadId load, const py::kwargs& values) {
        const LoadValues given = load_values(self.simulation.load_kind(load), values,
                                             static_cast<std::size_t>(self.simulation.body().size()));
        self.in_turn([&](Simulation& s) { s.set_load(load, given); });
        values["load"] = load;
        self.record("set_load", values);
      },
      py::arg("load"), "Gives a load other values from the next step on, by its number: all of them, as add_load.");
  simulation.def(
      "remove_load",
      [](Moving& self, LoadId load) {
        self.in_turn([&](Simulation& s) { s.remove_load(load); });
        self.record("remove_load", py::dict(py::arg("load") = load));
      },
      py::arg("load"), "Takes a load away, by its number.");
}

}  // namespace

Matrix3 free_directions(const py::object& given) {
  if (!py::isinstance<py::str>(given)) return entry_of<Matrix3>(given, "free", "letters of xyz, or a 3 x 3 projector");
  Matrix3 free = Matrix3::Zero();
  for (const char axis : given.cast<std::string>()) {
    if (axis < 'x' || axis > 'z')
      throw InputError(std::string("free: '") + axis + "' is no axis; allowed: letters of xyz, or a 3 x 3 projector");
    free(axis - 'x', axis - 'x') = 1;
  }
  return free;
}

SimulationOptions simulation_options(const Catalog& catalog, const GivenStepper& stepper, double safety,
                                     int max_substeps, ParameterValues stepper_parameters, ParameterValues parameters) {
  SimulationOptions options;
  if (const auto* name = std::get_if<std::string>(&stepper))
    options.stepper.method = catalog.steppers.find(*name);
  else
    options.stepper.method = std::shared_ptr<const StepperKind>(std::get<std::shared_ptr<StepperKind>>(stepper));
  options.stepper.parameters = std::move(stepper_parameters);
  options.safety = safety;
  options.max_substeps = max_substeps;
  options.parameters = std::move(parameters);
  options.make_voronoi = mesh::voronoi_cells;
  return options;
}

void add_simulation(py::module_& module) {
  add_results(module);
  module.attr("StepError") = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      "elastin.StepError",
      "A step that failed, or an equilibrium that was not found: outcome and cause. `result` is the StepResult or "
      "StaticResult.",
      PyExc_RuntimeError, nullptr));
  module.def("_simulation_again", &simulation_again, py::arg("recipe"), py::arg("state"));
  Class simulation(module, "Simulation",
                   "A body that moves. Steps let other Python threads run; each simulation may run in a thread of its "
                   "own. Views never copy: they stay where they are, and keep the simulation alive.");
  simulation
      .def(py::init([](const std::shared_ptr<Body>& body, const py::object& strategy, const GivenMaterial& material,
                       const GivenStepper& stepper, double safety, int max_substeps,
                       const ParameterValues& stepper_parameters, const ParameterValues& parameters, double budget,
                       const std::shared_ptr<Catalog>& catalog, const std::optional<GivenStepper>& scheme,
                       const std::optional<ParameterValues>& scheme_parameters) {
             return make_simulation(body, strategy, material, scheme.value_or(stepper), safety, max_substeps,
                                    scheme_parameters.value_or(stepper_parameters), parameters, budget, catalog);
           }),
           py::arg("body").none(false), py::arg("strategy"), py::arg("material"), py::kw_only(),
           py::arg("stepper").none(false) = "symplectic_euler", py::arg("safety") = 0.8, py::arg("max_substeps") = 1000,
           py::arg("stepper_parameters") = ParameterValues{}, py::arg("parameters") = ParameterValues{},
           py::arg("budget") = 0., py::arg("catalog") = py::none(), py::arg("scheme") = py::none(),
           py::arg("scheme_parameters") = py::none(),
           "material: one, or of a body of parts (see of_parts) a list, which the parts count from 0. "
           "strategy: a name ('lattice', 'lattice+volume', 'calibrated:patch') or a Strategy. calibrated: fits a rule "
           "to "
           "the material by the body's homogenised stiffness, as the experiment `material` of a scene does; the body "
           "is of tetrahedra, or a box. What strategy and material need of the body is added: pairs of molecules for "
           "bending_rigidity, sides of cells, Voronoi cells. stepper: one of steppers() or one's own (see "
           "elastin.stepper), and "
           "stepper_parameters its own by name: {'newton_iterations': 1}. Explicit steppers part a step so that each "
           "part is at most `safety` of the "
           "body's stable step; a step that would take more than max_substeps is not taken. "
           "parameters: of the strategy, by name. budget: by the clock, what a step may take [s]; 0: any. Of steppers "
           "that take a number of sweeps or iterations: each step gets as many as the pace of the steps before leaves "
           "time for; see effort. scheme, scheme_parameters: former names of stepper, stepper_parameters.")
      .def("step", &step, py::arg("dt"), py::arg("count") = 1, py::kw_only(), py::arg("check") = true,
           "Brings the body forward by dt [s], `count` times, and gives the last step's result. A step that fails "
           "leaves the state as it was and raises StepError; with check=False its result says so, and no step "
           "follows.")
      .def(
          "settle",
          [](Moving& self, bool check) {
            return checked(self.in_turn([](Simulation& s) { return s.settle(); }), check);
          },
          py::kw_only(), py::arg("check") = true,
          "Goes to the equilibrium of all that acts now, at rest: a start. Couplings rest, too: their dampers have no "
          "part in it, and their velocities are 0 until move_coupling gives others. One that is no minimum is left; "
          "the result's "
          "`unstable` says where that did not succeed. Raises StepError where none is found, unless check=False.")
      .def_property_readonly(
          "effort", [](const Moving& self) { return self.simulation.effort(); },
          "Sweeps or iterations of the last step; 0 where the stepper takes no number of them. With a budget it "
          "differs "
          "from step to step and from machine to machine: record it and pass it to set_effort to reproduce the run.")
      .def(
          "set_effort", [](Moving& self, int effort) { self.in_turn([&](Simulation& s) { s.set_effort(effort); }); },
          py::arg("effort"),
          "From now on this count, whatever the budget says: steps are then bitwise identical again.")
      .def(
          "iteration_error",
          [](Moving& self, double dt) { return self.in_turn([&](Simulation& s) { return s.iteration_error(dt); }); },
          py::arg("dt"),
          "What so few sweeps or iterations would do to a next step by dt [s], which is tried and taken back: the "
          "largest "
          "distance of a molecule from where backward Euler's balance to the end has it, and the largest distance that "
          "it goes there [m]. NaN where one of the two fails.")
      .def_property_readonly(
          "warnings", [](Moving& self) { return self.in_turn([](Simulation& s) { return s.warnings(); }); },
          "What makes its results doubtful, a sentence each: pieces, cells given twice, negative spring constants, "
          "mechanisms, cells that lock, a missing thickness, a budget that is not kept. Looks at the whole body: not "
          "for every step.")
      .def("observe", &observe, py::arg("see"), py::arg("every") = 1,
           "Calls see(simulation) after every `every` steps that succeeded. It must not step; what it raises ends the "
           "step() that it came from.")
      .def("save", in_turn([](Simulation& s) { return s.save(); }), "The state to go on from, bitwise identically.")
      .def(
          "restore",
          [](Moving& self, const SimulationState& saved) {
            if (auto before = self.in_turn([&](Simulation& s) { return s.restore(saved); }))
              self.begin_generation(std::move(before));
          },
          py::arg("saved"),
          "Goes back, or on, to a saved state; across cuts, too. Raises InputError where other positions at rest, or "
          "another sum of spring constants before a cut, show that it is another body's; other materials, "
          "connections and cells are not noticed.")
      .def("__reduce__", &reduced_simulation)
      .def("__repr__", [](const Moving& self) {
        return "<elastin.Simulation: " + std::to_string(self.simulation.body().size()) + " molecules at " +
               py::str(py::float_(self.simulation.time())).cast<std::string>() + " s>";
      });
  add_views(simulation);
  add_hands(simulation);
  add_derivatives(simulation);
  add_trajectory(module, simulation);
  add_loads(simulation);
  add_state(simulation);
  add_contact(simulation);
  add_topology(module, simulation);
}

}  // namespace elastin::python
