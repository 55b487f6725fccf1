#pragma once
#include <cstddef>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "elastin/c/elastin.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/simulation.h"

/// A host's task system that is two C functions away.
class CallbackRunner final : public elastin::TaskRunner {
 public:
  CallbackRunner(int width, elastin_run_tasks tasks, void* context) : width_(width), run_(tasks), context_(context) {}
  int width() const noexcept override { return width_; }
  void run(int count, Task task, void* context) noexcept override { run_(context_, count, task, context); }

 private:
  int width_;
  elastin_run_tasks run_;
  void* context_;
};

struct elastin_body {
  elastin::Body body;
  mutable elastin::Cells<3> surface = {};  ///< as it was last requested
};

struct elastin_simulation {
  std::unique_ptr<CallbackRunner> runner;  ///< outlives what runs on it
  elastin::Simulation simulation;
  double youngs_modulus = 0;  ///< [Pa] of its material; 0 where it is not known
  std::string warnings = {};  ///< as they were last requested
};

namespace elastin::c {

/// Keeps the message for the calling thread; hands the status through. Allocates nothing.
elastin_status failed(elastin_status status, const char* message) noexcept;

/// Runs what may throw, and makes a status of how it ended. `work` gives nothing, or a status.
template <class Work>
elastin_status guarded(const Work& work) noexcept {
  try {
    if constexpr (std::is_same_v<decltype(work()), void>) {
      work();
      return ELASTIN_OK;
    } else {
      return work();
    }
  } catch (const InputError& error) {
    return failed(ELASTIN_WRONG_INPUT, error.what());
  } catch (const std::bad_alloc&) {
    return failed(ELASTIN_NO_MEMORY, "there is not enough memory for this");
  } catch (const std::length_error&) {
    return failed(ELASTIN_NO_MEMORY, "there is not enough memory for this");
  } catch (const std::exception& error) {
    return failed(ELASTIN_FAULT, error.what());
  } catch (...) {
    return failed(ELASTIN_FAULT, "something was thrown that is no std::exception");
  }
}

/// Throws InputError where one list of values has a name twice.
[[noreturn]] inline void refuse_twice(const std::string& list, const std::string& name) {
  throw InputError(list + ": '" + name + "' is given twice");
}

/// Throws InputError naming the argument that is null.
template <class T>
T& given(T* pointer, const char* name) {
  if (!pointer) throw InputError(std::string(name) + " is null");
  return *pointer;
}

/// A caller's structure as the present header has it: what an older one did not have is zero. Throws InputError where
/// its size says that there is no such structure.
template <class T>
T checked_copy(const T* structure, const char* name) {
  given(structure, name);
  std::size_t size = 0;
  std::memcpy(&size, structure, sizeof size);
  if (size <= sizeof size || size > sizeof(T))
    throw InputError(std::string(name) + ".size is " + std::to_string(size) + "; set it to sizeof(" + name + "), " +
                     std::to_string(sizeof(T)) + " here");
  T copy{};
  std::memcpy(&copy, structure, size);
  return copy;
}

/// The same of an array's element. The elements lie as far from each other as the caller's header has it: by the size
/// that the first one states, and all must state.
template <class T>
T checked_element(const T* array, std::size_t number, const char* name) {
  const std::size_t stride = checked_copy(array, name).size;
  const T copy = checked_copy(reinterpret_cast<const T*>(reinterpret_cast<const char*>(array) + number * stride), name);
  if (copy.size != stride)
    throw InputError(std::string(name) + ".size is " + std::to_string(copy.size) + " in element " +
                     std::to_string(number) + " of an array and " + std::to_string(stride) + " in its first one");
  return copy;
}

/// Fills a caller's structure as far as it knows it.
template <class T>
void put(const T& values, T* structure, const char* name) {
  const std::size_t size = checked_copy(structure, name).size;
  std::memcpy(reinterpret_cast<char*>(structure) + sizeof size, reinterpret_cast<const char*>(&values) + sizeof size,
              size - sizeof size);
}

/// Hands a matrix's numbers out.
template <class Matrix, class Number>
void show(Matrix& matrix, Number** values, std::size_t* count) {
  given(values, "values") = matrix.data();
  if (count) *count = static_cast<std::size_t>(matrix.size());
}

inline Vector3 position_of(const double numbers[3], const char* name) {
  given(numbers, name);
  const Vector3 position(numbers[0], numbers[1], numbers[2]);
  if (!position.allFinite()) throw InputError(std::string(name) + " must be three finite numbers");
  return position;
}

/// What this library knows by name.
const Catalog& catalog();
/// A strategy by name, with the endings that its name may have.
Strategy strategy_of(const char* name);
Material material_of(const elastin_material* given);
/// The runner, if there is one, is made and belongs to the caller.
SimulationOptions options_of(const elastin_options* given, std::unique_ptr<CallbackRunner>& runner);

}  // namespace elastin::c
