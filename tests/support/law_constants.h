#pragma once
#include <map>
#include <string>

#include "elastin/core/model/law_constants.h"
#include "elastin/core/simulation/catalog.h"
#include "support/cells.h"

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
  add({.law = "veronda_westmann", .numbers = with_bulk({{"c1", f * 1.4e3}, {"c2", 2.5}})});
  add({.law = "arruda_boyce", .numbers = with_bulk({{"mu", f * 3e3}, {"N", 4}})});
  add({.law = "transversely_isotropic",
       .numbers = with_bulk(
           {{"c1", f * 1.2e3}, {"c2", f * 3e2}, {"c3", f * 9e2}, {"c4", 12}, {"c5", f * 4e4}, {"lambda_max", 1.12}}),
       .directions = {{"direction", Vector3(2, -1, 2) / 3}}});
  add({.law = "holzapfel_gasser_ogden",
       .numbers = with_bulk({{"c", f * 3e3}, {"k1", f * 5e3}, {"k2", 0.8}, {"kappa", 0.1}, {"angle", 0.7}}),
       .directions = {{"direction", Vector3(1, 2, 2) / 3}, {"across", Vector3(2, 1, -2) / 3}},
       .words = {{"volumetric", "quadratic"}}});
  add({.law = "fung_orthotropic",
       .numbers = with_bulk({{"c", f * 4e3},
                             {"E1", f * 9e3},
                             {"E2", f * 6e3},
                             {"E3", f * 1.2e4},
                             {"G12", f * 2.5e3},
                             {"G23", f * 3e3},
                             {"G31", f * 4e3},
                             {"nu12", 0.3},
                             {"nu23", 0.2},
                             {"nu31", 0.4}}),
       .directions = {{"axis_1", Vector3(2, -1, 2) / 3}, {"axis_2", Vector3(-1, 2, 2) / 3}}});
  return all;
}

inline const Catalog kCatalog = built_in_catalog();

/// A material of 5 kPa and ν = 0.3, but for what its law's constants say.
inline Material material_with(const LawConstants& constants) {
  return with_law(*kCatalog.material_laws.find(constants.law), constants, material_of(5e3, 0.3));
}

}  // namespace elastin::testing
