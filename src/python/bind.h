#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/within.h"
#include "elastin/config/scene_source.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/base/types.h"
#include "elastin/core/model/body.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin::python {

namespace py = pybind11;

void add_bodies(py::module_& module);
void add_surfaces(py::module_& module);
void add_strategies(py::module_& module);
void add_simulation(py::module_& module);
void add_results(py::module_& module);
void add_laboratory(py::module_& module);
void add_identify(py::module_& module);
void add_scenes(py::module_& module);
void add_laws(py::module_& module);
void add_own_loads(py::module_& module);
void add_own_experiments(py::module_& module);

/// A numpy array over memory that belongs to `owner`, which lives as long as the array does.
template <class T>
py::array view(const T* data, std::vector<py::ssize_t> shape, const py::handle& owner, bool writable = false) {
  py::array_t<T> array(std::move(shape), data, owner);
  if (!writable) py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}
/// Shape (n, 3).
inline py::array view(const Positions& positions, const py::handle& owner, bool writable = false) {
  return view(positions.data(), {positions.cols(), 3}, owner, writable);
}
inline py::array view(const VectorX& values, const py::handle& owner) {
  return view(values.data(), {values.size()}, owner);
}
template <std::size_t corners>
py::array view(const std::vector<std::array<int, corners>>& rows, const py::handle& owner) {
  return view(rows.empty() ? nullptr : rows.front().data(),
              {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(corners)}, owner);
}

/// Numbers of any shape that numpy can make of it; `name` is said in messages. Throws InputError.
Positions positions_from(const py::handle& given, const char* name);
VectorX numbers_from(const py::handle& given, const char* name);

/// The value of an entry, as what is `allowed`. Throws InputError where it is not.
template <class Value>
Value entry_of(const py::handle& given, const std::string& name, const char* allowed) {
  try {
    return given.cast<Value>();
  } catch (const py::cast_error&) {
    throw InputError(name + ": is " + py::repr(given).cast<std::string>() + "; allowed: " + allowed);
  }
}
inline double number_of(const py::handle& given, const std::string& name) {
  return entry_of<double>(given, name, "a number");
}
inline std::string word_of(const py::handle& given, const std::string& name) {
  return entry_of<std::string>(given, name, "a text");
}

/// Molecules, connections or cells as Python gives them: a number, several, or a mask, one truth value for each of them
/// all. Its type caster, below, makes numbers of a mask.
struct ChosenNumbers {
  std::vector<int> all;
  bool single = false;
  std::optional<std::size_t> mask = {};  ///< how many truth values it had

  /// The numbers; `name` is said in messages, `what` is "molecule". Throws InputError where there are not `count` truth
  /// values.
  const std::vector<int>& of(std::size_t count, const std::string& name, const std::string& what) const;
};

/// A Python object that C++ keeps, copies and releases on any thread, with or without the interpreter's lock.
template <class Object>
std::shared_ptr<Object> keep(Object object) {
  return {new Object(std::move(object)), [](Object* kept) {
            if (!Py_IsInitialized()) return;  // the interpreter has ended
            const py::gil_scoped_acquire locked;
            delete kept;
          }};
}

/// A scene as Python gives it: the path of a file, or one in memory.
using GivenScene = std::variant<std::string, std::shared_ptr<config::HeldScene>>;
inline config::SceneSource source_of(const GivenScene& given) {
  if (const auto* path = std::get_if<std::string>(&given)) return *path;
  return *std::get<std::shared_ptr<config::HeldScene>>(given);
}

/// "" or "xz" or a 3 x 3 projector: the directions in which a held molecule stays free.
Matrix3 free_directions(const py::object& given);

/// The strategy itself, or the one of this name.
Strategy strategy_from(const py::handle& given, const Catalog& catalog);

/// What Python wants to say in the middle of work in C++ without the interpreter's lock: Ctrl-C, looked for every 50
/// ms, and what a function of the caller's raised. It ends the work (StopScope) and comes out behind it.
class Signals {
 public:
  Signals() : outer_(std::exchange(innermost_, this)) {}
  ~Signals() { innermost_ = outer_; }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  bool raised() {
    if (trouble_ || Clock::now() - looked_ < std::chrono::milliseconds(50)) return static_cast<bool>(trouble_);
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) trouble_ = std::make_exception_ptr(py::error_already_set());
    looked_ = Clock::now();
    return static_cast<bool>(trouble_);
  }
  /// Raises it where the work has ended. With the interpreter's lock.
  void rethrow() {
    if (trouble_) std::rethrow_exception(std::exchange(trouble_, nullptr));
  }
  /// Calls a function of the caller's, which needs the interpreter's lock; what it raises ends the work of this thread,
  /// and is answered by `otherwise`, as is every call after it.
  template <class Call, class Value>
  static Value guarded(const Call& call, Value otherwise) {
    if (innermost_ && innermost_->trouble_) return otherwise;
    const py::gil_scoped_acquire locked;
    try {
      return call();
    } catch (...) {
      if (!innermost_) throw;
      innermost_->trouble_ = std::current_exception();
      return otherwise;
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  inline static thread_local Signals* innermost_ = nullptr;
  Signals* outer_;
  Clock::time_point looked_ = Clock::now();
  std::exception_ptr trouble_ = {};
};
/// Does it without the interpreter's lock; Ctrl-C ends it within a solve, and comes out.
template <class Do>
auto interruptible(Do&& act) {
  Signals signals;
  const auto run = [&] {
    const py::gil_scoped_release others_run;
    const StopScope stop([&] { return signals.raised(); });
    return act();
  };
  try {
    if constexpr (std::is_void_v<decltype(act())>) {
      run();
      signals.rethrow();
    } else {
      auto result = run();
      signals.rethrow();
      return result;
    }
  } catch (...) {
    signals.rethrow();  // in place of what stopping led to
    throw;
  }
}
/// Calls a Python function, where there is one, with what is being done, and lets Ctrl-C through.
std::function<void(const std::string& doing)> progress_of(const std::optional<py::function>& progress);
/// Lets Ctrl-C through. The interpreter's lock must be held.
inline void check_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// A simulation as Python has it. Its methods let other threads run, and take turns.
struct Moving {
  explicit Moving(Simulation made) : simulation(std::move(made)) {}
  Simulation simulation;
  std::recursive_mutex busy;  ///< observers, which run within a step, may ask it things
  /// How to make it again, for pickle: a callable, its arguments and keywords, and a list of calls since that added
  /// something: a method's name and keywords.
  std::shared_ptr<py::tuple> recipe = {};
  /// What keeps arrays alive that views show whose topology is no longer the simulation's: each view holds its own.
  struct Generation {
    std::shared_ptr<const void> kept = {};
  };
  std::shared_ptr<Generation> generation = std::make_shared<Generation>();
  void begin_generation(std::shared_ptr<const void> before) {
    generation->kept = std::move(before);
    generation = std::make_shared<Generation>();
  }
  void record(const char* method, const py::dict& keywords) {
    if (recipe) (*recipe)[3].cast<py::list>().append(py::make_tuple(method, keywords));
  }
  bool stepping = false;
  bool in_use = false;  ///< by a turn that may call functions of the caller's; not while its observers run

  /// Does it without the interpreter's lock, in its turn. Not within a turn, from a load, law or stepper of the
  /// caller's: it would change, or compute once more, what is being computed. Throws std::runtime_error.
  template <class Do>
  auto in_turn(Do&& act) {
    return look([&](Simulation& own) {
      if (in_use)
        throw std::runtime_error(
            "a load or stepper must not use the simulation that calls it, but for its positions, "
            "velocities and time: do it before the step or after it");
      const Within within(in_use);
      return act(own);
    });
  }
  /// The same for what only shows the state reached; at any time.
  template <class Do>
  auto look(Do&& act) {
    return interruptible([&] {
      const std::lock_guard turn(busy);
      return act(simulation);
    });
  }
};

using MovingClass = py::class_<Moving, std::shared_ptr<Moving>>;
void add_topology(py::module_& module, MovingClass& simulation);
void add_contact(MovingClass& simulation);
void add_state(MovingClass& simulation);

/// A stepper by its name, or itself.
using GivenStepper = std::variant<std::string, std::shared_ptr<StepperKind>>;
/// As keyword arguments give them.
SimulationOptions simulation_options(const Catalog& catalog, const GivenStepper& stepper, double safety,
                                     int max_substeps, ParameterValues stepper_parameters, ParameterValues parameters);

}  // namespace elastin::python

namespace pybind11::detail {

template <>
struct type_caster<elastin::python::ChosenNumbers> {
  PYBIND11_TYPE_CASTER(elastin::python::ChosenNumbers, (make_caster<std::variant<int, std::vector<int>>>::name));
  bool load(handle source, bool convert);
};

}  // namespace pybind11::detail
