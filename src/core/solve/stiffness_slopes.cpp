#include "core/solve/stiffness_slopes.h"

#include "core/parallel/parallel.h"

namespace elastin {

StiffnessSlopes::StiffnessSlopes(const LocalElasticity& law, const Positions& at) : law_(law) {
  for (int element = 0; element < law.elements(); ++element)
    starts_.push_back(starts_.back() + static_cast<int>(law.molecules_of(element).size()));
  forces_.resize(3, starts_.back());
  parallel_for(law.elements(), [&](int element) {
    for (int column = starts_[element]; column < starts_[element + 1]; ++column) {
      LocalBlock block;
      const LocalSlot slot{element, column - starts_[element]};
      law.add_blocks(at, {&slot, 1}, block);
      forces_.col(column) = -block.gradient;
    }
  });
}

void StiffnessSlopes::add_forces(const VectorX& changes, Positions& forces) const {
  for (int element = 0; element < law_.elements(); ++element) {
    const auto molecules = law_.molecules_of(element);
    for (std::size_t node = 0; node < molecules.size(); ++node)
      forces.col(molecules[node]) += changes[element] * forces_.col(starts_[element] + static_cast<int>(node));
  }
}

VectorX StiffnessSlopes::work(const Positions& motion) const {
  VectorX result(law_.elements());
  parallel_for(law_.elements(), [&](int element) {
    const auto molecules = law_.molecules_of(element);
    double sum = 0;
    for (std::size_t node = 0; node < molecules.size(); ++node)
      sum += forces_.col(starts_[element] + static_cast<int>(node)).dot(motion.col(molecules[node]));
    result[element] = sum;
  });
  return result;
}

}  // namespace elastin
