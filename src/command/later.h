#pragma once
#include "contact/overlaps.h"
#include "contact/triangles_cross.h"
#include "lab/run/least_squares.h"

namespace elastin::command {

/// The functions of the module.
struct Later {
  decltype(&contact::find_overlaps) find_overlaps;
  decltype(&contact::triangles_cross) triangles_cross;
  decltype(&lab::minimise_squares) minimise_squares;
};

}  // namespace elastin::command

/// The module's only name.
extern "C" __attribute__((visibility("default"))) const elastin::command::Later elastin_later;
