#pragma once
#include <map>
#include <string>

#include "elastin/core/model/law_constants.h"

namespace elastin::testing {

/// Constants of each material law, all moduli times `factor`: some of soft tissue or rubber of about 10 kPa. A law that
/// is not here is not tested.
inline std::map<std::string, LawConstants> law_constants(double factor = 1) {
  const double f = factor;
  const std::map<std::string, double> bulk{{"bulk_modulus", f * 4e4}};
  const auto with_bulk = [&](std::map<std::string, double> numbers) {
    numbers.insert(bulk.begin(), bulk.end());
    return numbers;
  };
  std::map<std::string, LawConstants> all;
  const auto add = [&](LawConstants constants) { all[constants.law] = std::move(constants); };
  add({.law = "neo_hookean_log"});
  add({.law = "mooney_rivlin", .numbers = with_bulk({{"c1", f * 1.5e3}, {"c2", f * 4e2}})});
  add({.law = "yeoh", .numbers = bulk, .terms = {{f * 1.7e3}, {f * -90}, {f * 40}}});
  add({.law = "ogden",
       .numbers = bulk,
       .words = {{"volumetric", "mixed"}},
       .terms = {{f * 4e3, 1.3}, {f * 8, 5}, {f * -60, -2}}});
  return all;
}

}  // namespace elastin::testing
