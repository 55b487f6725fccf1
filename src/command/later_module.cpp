#include "command/later.h"

extern "C" const elastin::command::Later elastin_later{
    &elastin::contact::find_overlaps, &elastin::contact::triangles_cross, &elastin::lab::minimise_squares};
