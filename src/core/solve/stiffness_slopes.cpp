#include "core/solve/stiffness_slopes.h"

#include "core/forces/element_forces.h"
#include "core/geometry/reference_slopes.h"
#include "core/parallel/parallel.h"

namespace elastin {
namespace {

/// Sets the force of one element on each of its molecules.
class Forces {
 public:
  Forces(const LocalElasticity& law, const Positions& at)
      : law_(law), at_(at), in_one_go_(dynamic_cast<const ElementForces*>(&law)) {}
  void set(int element, Eigen::Ref<Positions> forces) const {
    if (in_one_go_) return in_one_go_->set_element_forces(at_, element, forces);
    for (int node = 0; node < forces.cols(); ++node) {
      LocalBlock block;
      const LocalSlot slot{element, node};
      law_.add_blocks(at_, {&slot, 1}, block);
      forces.col(node) = -block.gradient;
    }
  }

 private:
  const LocalElasticity& law_;
  const Positions& at_;
  const ElementForces* in_one_go_;
};

/// Σ force·motion over the molecules of one element.
double work_of(const Eigen::Ref<const Positions>& forces, std::span<const int> molecules, const Positions& motion) {
  double sum = 0;
  for (std::size_t node = 0; node < molecules.size(); ++node)
    sum += forces.col(static_cast<Eigen::Index>(node)).dot(motion.col(molecules[node]));
  return sum;
}

}  // namespace

StiffnessSlopes::StiffnessSlopes(const LocalElasticity& law, const Positions& at) : law_(law) {
  for (int element = 0; element < law.elements(); ++element)
    starts_.push_back(starts_.back() + static_cast<int>(law.molecules_of(element).size()));
  forces_.resize(3, starts_.back());
  const Forces forces(law, at);
  parallel_for(law.elements(), [&](int element) {
    forces.set(element, forces_.middleCols(starts_[element], starts_[element + 1] - starts_[element]));
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
    const auto count = static_cast<Eigen::Index>(molecules.size());
    result[element] = work_of(forces_.middleCols(starts_[element], count), molecules, motion);
  });
  return result;
}

VectorX work_by_stiffness(const LocalElasticity& law, const Positions& at, const Positions& motion) {
  VectorX result(law.elements());
  const Forces each(law, at);
  parallel_for(
      law.elements(),
      [&](int element) {
        const auto molecules = law.molecules_of(element);
        Eigen::Matrix<double, 3, kMostNodes> room;
        auto forces = room.leftCols(static_cast<Eigen::Index>(molecules.size()));
        each.set(element, forces);
        result[element] = work_of(forces, molecules, motion);
      },
      kMoleculeThreshold);
  return result;
}

}  // namespace elastin
