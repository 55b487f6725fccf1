#pragma once

namespace elastin {

enum class LinearMethod {
  automatic,  ///< the quickest by a rule: direct for tiny bodies, multigrid for large or slender ones, else pcg
  pcg,        ///< conjugate gradients with the blocks of single molecules
  multigrid,  ///< the same with a coarse picture of the body besides
  direct,     ///< a factorisation
};

}  // namespace elastin
