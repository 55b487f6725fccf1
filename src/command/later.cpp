#include "command/later.h"

#include <dlfcn.h>

#include "elastin/core/base/error.h"

namespace elastin::command {
namespace {

const Later& later() {
  static const Later* const found = [] {
    void* module = dlopen(ELASTIN_LATER, RTLD_NOW | RTLD_LOCAL);
    const void* table = module ? dlsym(module, "elastin_later") : nullptr;
    if (!table) throw InputError(std::string("cannot load the module " ELASTIN_LATER ": ") + dlerror());
    return static_cast<const Later*>(table);
  }();
  return *found;
}

}  // namespace
}  // namespace elastin::command

// The linker takes these in place of the functions of the same names in the static libraries, and so the program does
// not need FCL and Ceres, which those functions call.

using elastin::command::later;

std::vector<elastin::contact::Overlap> elastin::contact::find_overlaps(const Body& body, const Positions& positions,
                                                                       double tolerance) {
  return later().find_overlaps(body, positions, tolerance);
}
bool elastin::contact::triangles_cross(const std::array<Vector3, 3>& one, const std::array<Vector3, 3>& other) {
  return later().triangles_cross(one, other);
}
elastin::lab::LeastSquaresResult elastin::lab::minimise_squares(const LeastSquaresProblem& problem,
                                                                const VectorX& start) {
  return later().minimise_squares(problem, start);
}
