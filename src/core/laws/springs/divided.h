#pragma once
#include <array>

#include "core/laws/springs/standard.h"

namespace elastin {

/// k = E A / (L C), C given by the scene: the paper's correction by hand, k/3.75 on the cube of 1000. [M03]
struct Divided {
  static constexpr std::string_view name = "divided";
  static constexpr std::string_view summary = "standard divided by a number given by the scene";
  static constexpr std::string_view source = "[M03] §4";
  double divisor = 3.75;
  static constexpr std::array parameters{
      Parameter<Divided>{"divisor", &Divided::divisor, dimension::none, 1e-6, 1e6, "divisor C of k = E A / (L C)"}};

  VectorX constants(const Body& body, const Material& material) const {
    return Standard{}.constants(body, material) / divisor;
  }
};

}  // namespace elastin
