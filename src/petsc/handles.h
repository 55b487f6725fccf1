#pragma once
#include <petscksp.h>

#include <utility>

namespace elastin::petsc {

/// Throws std::runtime_error with PETSc's words where a call has failed.
void check(PetscErrorCode code);

/// An object of PETSc that ends with its owner.
template <class Object, PetscErrorCode (*destroy)(Object*)>
class Handle {
 public:
  Handle() = default;
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() {
    if (object_) destroy(&object_);
  }
  operator Object() const { return object_; }
  /// For calls that make one.
  Object* out() {
    if (object_) destroy(&object_);
    return &object_;
  }

 private:
  Object object_ = nullptr;
};
using Vector = Handle<Vec, VecDestroy>;
using Matrix = Handle<Mat, MatDestroy>;
using Solver = Handle<KSP, KSPDestroy>;
using PreconditionerHandle = Handle<PC, PCDestroy>;

}  // namespace elastin::petsc
