#include "elastin/core/forces/air.h"

#include <algorithm>
#include <cmath>

#include "core/model/incidence.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

class AirDrag final : public Load {
 public:
  AirDrag(const Body& body, const Air& air) : body_(body), air_(air) {
    std::vector<int> corners;
    for (const auto& triangle : body.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
    triangles_of_ = rows_by_target(body.size(), corners);
  }

  void add_forces(const State& state, Positions& forces) const override {
    const double pressure = air_.pressure_coefficient > 0 ? caught_pressure(state) : 0;
    gather(forces, [&](int cell) -> Vector3 {
      const Flow flow(*this, state, cell);
      return force(flow) + pressure * flow.area * flow.normal;
    });
  }

  bool changes() const override { return true; }

  void add_change(const State& state, const Positions&, const Positions& dv, Positions& forces) const override {
    gather(forces, [&](int cell) -> Vector3 {
      const auto& [a, b, c] = body_.triangles[cell];
      return -slope(Flow(*this, state, cell)) * (dv.col(a) + dv.col(b) + dv.col(c)) / 3;
    });
  }

  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    for (std::size_t cell = 0; cell < body_.triangles.size(); ++cell) {
      const Matrix3 block = velocity_weight / 9 * slope(Flow(*this, state, static_cast<int>(cell)));
      for (const int a : body_.triangles[cell])
        for (const int b : body_.triangles[cell]) visit(a, b, block);
    }
  }

  bool has_energy() const override { return false; }
  bool steady() const override { return false; }
  bool acts_at_rest() const override { return air_.wind.norm() > 0; }

 private:
  struct Flow {
    Flow(const AirDrag& drag, const State& state, int cell) {
      const auto& [a, b, c] = drag.body_.triangles[cell];
      const Positions &x = state.positions, &v = state.velocities;
      const Vector3 twice = Vector3(x.col(b) - x.col(a)).cross(Vector3(x.col(c) - x.col(a)));
      area = twice.norm() / 2;
      normal = area > 0 ? Vector3(twice / (2 * area)) : Vector3::Zero();
      const Vector3 wind = drag.air_.wind - (v.col(a) + v.col(b) + v.col(c)) / 3;
      across = wind.dot(normal);
      along = wind - across * normal;
    }
    double area, across;
    Vector3 normal, along;
  };

  /// [Pa], with its sign along the normals.
  double caught_pressure(const State& state) const {
    using Sums = Eigen::Matrix<double, 5, 1>;  // area, area × wind, area × wind along the normal
    const Sums sums = ordered_sum<Sums>(
        static_cast<int>(body_.triangles.size()),
        [&](int cell) {
          const Flow flow(*this, state, cell);
          Sums term;
          term << flow.area, flow.area * (flow.along + flow.across * flow.normal), flow.area * flow.across;
          return term;
        },
        Sums(Sums::Zero()));
    const double area = sums[0], wind = area > 0 ? sums.segment<3>(1).norm() / area : 0;
    if (!(wind > 0)) return 0;
    constexpr double whole = 0.05;
    return air_.density / 2 * air_.pressure_coefficient * wind * wind *
           std::clamp(sums[4] / (wind * area) / whole, -1., 1.);
  }

  Vector3 force(const Flow& flow) const {
    return air_.density / 2 * flow.area *
           (air_.drag_coefficient * std::abs(flow.across) * flow.across * flow.normal +
            air_.skin_coefficient * flow.along.norm() * flow.along);
  }
  /// ∂F/∂w, symmetric and positive.
  Matrix3 slope(const Flow& flow) const {
    const Matrix3 normal = flow.normal * flow.normal.transpose();
    Matrix3 sum = air_.drag_coefficient * 2 * std::abs(flow.across) * normal;
    const double speed = flow.along.norm();
    if (speed > 0)
      sum += air_.skin_coefficient *
             (speed * (Matrix3::Identity() - normal) + flow.along * flow.along.transpose() / speed);
    return air_.density / 2 * flow.area * sum;
  }

  /// Adds a third of each triangle's force to its corners, each molecule's in ascending order of the triangles.
  template <class Force>
  void gather(Positions& forces, Force&& force_of) const {
    Positions thirds(3, static_cast<Eigen::Index>(body_.triangles.size()));
    parallel_for(static_cast<int>(body_.triangles.size()), [&](int cell) { thirds.col(cell) = force_of(cell) / 3; });
    parallel_for(body_.size(), [&](int molecule) {
      for (const int corner : triangles_of_[molecule]) forces.col(molecule) += thirds.col(corner / 3);
    });
  }

  const Body& body_;
  Air air_;
  Rows triangles_of_;  // each molecule's corners of triangles
};

}  // namespace

std::unique_ptr<Load> make_air(const Body& body, const Air& air) {
  if (body.triangles.empty()) throw InputError("air drags on triangles: the body has none");
  return std::make_unique<AirDrag>(body, air);
}

}  // namespace elastin
