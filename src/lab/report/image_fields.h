#pragma once
#include <string>

#include "lab/scene/scene.h"

namespace elastin::lab {

/// Writes the last state of a run as images on the grid of the image that the body was made of, or on one along the
/// axes with this spacing [m], which all bodies but those need: the displacement at rest as FILE, in the unit of the
/// grid; next to it FILE-strain, the largest principal strain (Green–Lagrange, means of the cells at each molecule),
/// and FILE-label, the labels, or numbers of parts from 1, where the body is in the end. 0 outside the body.
void write_image(const std::string& path, double spacing, const Scene& scene, const Run& run);
/// Throws InputError where write_image cannot: where no cells fill the body, without a grid, and on an ending that
/// images do not have.
void check_image(const std::string& path, double spacing, const Scene& scene);

}  // namespace elastin::lab
