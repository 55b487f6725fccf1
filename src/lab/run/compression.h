#pragma once
#include <string>

#include "elastin/core/forces/tension.h"
#include "elastin/core/model/material.h"

namespace elastin::lab {

/// "3 of 40 triangles in compression (most: …): a membrane would wrinkle there; …".
std::string compression_text(const Model& model, const Positions& positions, const Compression& found,
                             const Material& material);

}  // namespace elastin::lab
