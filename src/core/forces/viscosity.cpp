#include "elastin/core/forces/viscosity.h"

#include <utility>

#include "core/base/unsuited_error.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/cells.h"

namespace elastin {
namespace {

class ConnectionDamping final : public Viscosity {
 public:
  explicit ConnectionDamping(double coefficient) : coefficient_(coefficient) {}

  void add_force_densities(const VectorX& squared_lengths, const VectorX& rates, VectorX& force_densities,
                           Workspace&) const override {
    parallel_for(static_cast<int>(squared_lengths.size()), [&](int c) {
      if (squared_lengths[c] > 0) force_densities[c] += coefficient_ * rates[c] / (2 * squared_lengths[c]);
    });
  }
  void add_own_slopes(const VectorX& squared_lengths, const VectorX& rates, double rate_weight,
                      VectorX& slopes) const override {
    parallel_for(static_cast<int>(squared_lengths.size()), [&](int c) {
      if (squared_lengths[c] > 0)
        slopes[c] += coefficient_ * (rate_weight - rates[c] / squared_lengths[c]) / (2 * squared_lengths[c]);
    });
  }

 private:
  double coefficient_;
};

/// q = β Σ (∂q/∂s) ṡ with the slopes that laws have at rest.
class RestDamping : public Viscosity {
 public:
  RestDamping(const Body& body, ElasticTerms laws, double time) : laws_(std::move(laws.terms)), time_(time) {
    own_slopes_ = VectorX::Zero(body.connections.size());
    for (const auto& law : laws_) {
      const auto* edges = dynamic_cast<const EdgeDensities*>(law.get());
      if (!edges)
        throw UnsuitedError(
            "damping by the stiffness at rest (`stiffness` of `rayleigh`) works on springs, tetrahedra and triangles "
            "of "
            "first order; use damping of connections or of mass on other cells");
      coupled_ |= edges->coupled();
      slopes_.push_back(edges->slopes());
      slopes_.back()->linearise_at(body.rest);
      slopes_.back()->add_own_slopes(own_slopes_);
    }
    own_slopes_ *= time;
  }

  void add_force_densities(const VectorX&, const VectorX& rates, VectorX& force_densities,
                           Workspace& workspace) const override {
    force_densities += own_slopes_.cwiseProduct(rates);
    if (coupled_) add_change(rates, force_densities, workspace);
  }
  void add_own_slopes(const VectorX&, const VectorX&, double rate_weight, VectorX& slopes) const override {
    slopes += rate_weight * own_slopes_;
  }
  bool coupled() const override { return coupled_; }
  void add_change(const VectorX& change_of_rates, VectorX& change_of_force_densities,
                  Workspace& workspace) const override {
    workspace.scaled = time_ * change_of_rates;
    for (const auto& slopes : slopes_) slopes->add_change(workspace.scaled, change_of_force_densities, workspace);
  }
  void visit_cells(const EdgeSlopes::CellVisitor& visit) const override {
    for (const auto& slopes : slopes_)
      slopes->visit_cells([&](CellSlopes cells) {
        cells.factor *= time_;
        visit(cells);
      });
  }

 private:
  std::vector<std::unique_ptr<Elasticity>> laws_;
  std::vector<std::unique_ptr<EdgeSlopes>> slopes_;  // of these, at rest
  bool coupled_ = false;
  double time_;
  VectorX own_slopes_;  // times β
};

class StiffnessDamping final : public RestDamping, public GrowsWithStiffness {
 public:
  using RestDamping::RestDamping;
};

/// The law whose slopes are those of Labelle's damping; its stress is of no use.
struct LabelleDamping {
  static constexpr std::string_view name = "cell_damping", summary = "viscous stress of solids", source = "[L03]";
  double bulk = 0, shear = 0;

  StVenantKirchhoff::Solid solid(const Material&) const { return {bulk, shear}; }
};

}  // namespace

std::unique_ptr<Viscosity> make_damping(double coefficient) { return std::make_unique<ConnectionDamping>(coefficient); }

std::unique_ptr<Viscosity> make_cell_damping(const Body& body, double bulk, double shear) {
  return std::make_unique<RestDamping>(body, make_cells<3>(body, Material{}, LabelleDamping{bulk, shear}), 1);
}

std::unique_ptr<Viscosity> make_stiffness_damping(const Body& body, const Elasticity& law, double time) {
  return std::make_unique<StiffnessDamping>(body, law.clone(), time);
}

}  // namespace elastin
