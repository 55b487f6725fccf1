#pragma once
#include <map>
#include <string>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// The constants of a law that Young's modulus and Poisson's ratio do not give, under the names of its row among the
/// material laws (see MaterialLaw). In SI units. with_law() checks them and puts them into a material.
struct LawConstants {
  std::string law;  ///< name of the row
  std::map<std::string, double> numbers = {};
  std::map<std::string, Vector3> directions = {};  ///< unit vectors, at rest
  std::map<std::string, std::string> words = {};
  std::vector<std::vector<double>> terms = {};
  /// E at rest [Pa] that follows from these constants. Over it the material's own E multiplies all moduli of the law:
  /// of stiffer regions, of a fit. 0: not known, and the constants count as they are.
  double youngs_modulus = 0;
};

}  // namespace elastin
