#include "lab/experiment/driven.h"

namespace elastin::lab {

void Driven::fix_fully(const std::vector<int>& molecules) {
  for (const int molecule : molecules) fixed_.push_back({molecule, Matrix3::Zero()});
}

void Driven::set_up(Model& model) {
  released_ = false;
  for (const Fixed& fixed : fixed_) model.supports.push_back({fixed.molecule, fixed.free, Vector3::Zero()});
}

void Driven::set_load(Model& model, double factor) {
  factor_ = factor;
  for (std::size_t i = 0; i < fixed_.size(); ++i) model.supports[i].displacement = displacement(i, factor);
}

void Driven::set_load_rate(Model& model, double rate) {
  for (std::size_t i = 0; i < fixed_.size(); ++i) model.supports[i].velocity = rate * displacement_slope(i, factor_);
}

void Driven::free_from(Model& model, std::size_t first) {
  for (std::size_t i = first; i < fixed_.size(); ++i) model.supports[i].free = Matrix3::Identity();
  released_ = true;
}

Matrix3 Driven::virial(const Positions& pull, const Positions& positions) const {
  const Vector3 middle = positions.rowwise().mean();  // nearer places, less rounding; the forces' sum is zero
  Matrix3 sum = Matrix3::Zero();
  for (std::size_t i = 0; i < fixed_.size(); ++i)
    sum += pull.col(static_cast<Eigen::Index>(i)) * (positions.col(fixed_[i].molecule) - middle).transpose();
  return sum;
}

void Driven::add_state(const Model& model, const State& state, const StaticResult& solved, double scale,
                       Measures& measures) {
  if (model.has_energy() && !solved.linear) measures.set("energy", model.elastic_energy(state.positions));
  const Vector3 left = model.load_forces(state).rowwise().sum() + solved.reactions.rowwise().sum();
  measures.set("reaction_balance", left.norm() / scale);
}

}  // namespace elastin::lab
