#pragma once
#include <memory>
#include <vector>

#include "core/forces/blocks/volumes.h"
#include "elastin/core/laws/point_laws.h"

namespace elastin::blocks {

/// A cell's stresses at the points of its quadrature.
template <int d>
struct Stresses : Strains<d> {
  AtPoints<Tensor<d>> S;  ///< without the cell's own pressures
  AtPoints<double> p;     ///< these, where it has them
};

/// A law at the points of a block's cells: at its points those laws that see C, and what keeps the cells' volumes. It
/// has no history.
template <int d>
class ElasticPoints {
 public:
  ElasticPoints(const Body& body, const CellBlock& block, std::shared_ptr<const PointLaws<d>> laws,
                std::vector<Volumetric> volume)
      : rest_(body, block), volumes_(std::move(volume), rest_), laws_(std::move(laws)) {}
  /// The same law on a subdomain's block, which has these cells of the whole.
  ElasticPoints(const ElasticPoints& whole, const Body& body, const CellBlock& block, std::vector<int> cells)
      : ElasticPoints(body, block, whole.laws_, whole.volumes_.laws_of(cells)) {
    numbers_ = std::move(cells);
  }
  void set_rest(double part) {
    rest_.set(part);
    volumes_.set_rest(rest_);
  }

  const CellsAtRest<d>& rest() const { return rest_; }
  const CellVolumes<d>& volumes() const { return volumes_; }
  bool has_energy() const { return laws_->has_energy(); }

  /// S of the laws at all points.
  void set_stresses(int cell, const Strains<d>& now, AtPoints<Tensor<d>>& S) const {
    laws_->stresses(number(cell), span(now.A), span(S));
  }
  /// Their ∂S/∂C.
  void set_tangents(int cell, const Strains<d>& now, AtPoints<TangentModuli<d>>& D) const {
    laws_->tangents(number(cell), span(now.A), span(D));
  }
  /// Both at a point with the strain A.
  void set_at(int cell, const Tensor<d>& A, Tensor<d>& S, TangentModuli<d>& D) const {
    laws_->stresses(number(cell), {&A, 1}, {&S, 1});
    laws_->tangents(number(cell), {&A, 1}, {&D, 1});
  }
  /// Their W at one point [J/m³], [J/m²].
  double density(int cell, int g, const Strains<d>& now) const {
    const double one = 1;
    return laws_->energy(number(cell), {&now.A[g], 1}, {&one, 1});
  }
  /// Σ w W of all points [J].
  double energy(int cell, const Strains<d>& now) const {
    AtPoints<double> weights;
    for (int g = 0; g < rest_.points(); ++g) weights[g] = rest_.weight(cell, g);
    return laws_->energy(number(cell), span(now.A), {weights.data(), static_cast<std::size_t>(rest_.points())});
  }

  /// The pressures' part of S and ∂S/∂C.
  void add_pressures(Stresses<d>& now, AtPoints<TangentModuli<d>>& D) const {
    if (volumes_)
      for (int g = 0; g < rest_.points(); ++g) add_pressure<d>(now.p[g], now.A[g], now.S[g], D[g]);
  }

 private:
  template <class T>
  std::span<const T> span(const AtPoints<T>& all) const {
    return {all.data(), static_cast<std::size_t>(rest_.points())};
  }
  template <class T>
  std::span<T> span(AtPoints<T>& all) const {
    return {all.data(), static_cast<std::size_t>(rest_.points())};
  }
  /// Of a cell where laws have theirs.
  int number(int cell) const { return numbers_.empty() ? cell : numbers_[cell]; }

  CellsAtRest<d> rest_;
  CellVolumes<d> volumes_;
  std::shared_ptr<const PointLaws<d>> laws_;
  std::vector<int> numbers_;  ///< on a subdomain of the whole's cells; empty: the same
};

}  // namespace elastin::blocks
