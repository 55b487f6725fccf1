#pragma once
#include <array>

#include "elastin/core/laws/law.h"

namespace elastin {

/// The same constant for every connection, given by the scene: for comparing with other programs, and for studies of
/// what negative or hand-made constants do.
struct Uniform {
  static constexpr std::string_view name = "uniform";
  static constexpr std::string_view summary = "one spring constant for all connections, given by the scene";
  static constexpr std::string_view source = "user";
  static constexpr bool takes_scale = true;
  double constant = 1;
  static constexpr std::array parameters{
      Parameter<Uniform>{"constant", &Uniform::constant, dimension::stiffness, -1e12, 1e12,
                         "spring constant k of every connection; negative values are reported"}};

  VectorX constants(const Body& body, const Material&) const {
    return VectorX::Constant(body.connections.size(), constant);
  }
};

}  // namespace elastin
