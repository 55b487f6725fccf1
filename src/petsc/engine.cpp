#include <cstdint>
#include <cstring>
#include <utility>

#include "core/forces/sharing.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/solve/engine.h"
#include "elastin/petsc/petsc.h"
#include "petsc/equilibrium.h"
#include "petsc/processes.h"

namespace elastin::petsc {
namespace {

/// Distinguishes one body from another that stands at the same address later. [Fowler, Noll & Vo]
std::uint64_t mark_of(const Body& body) {
  std::uint64_t mark = 14695981039346656037U;
  const auto mix = [&](std::uint64_t number) { mark = (mark ^ number) * 1099511628211U; };
  for (Eigen::Index i = 0; i < body.rest.size(); ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, body.rest.data() + i, sizeof bits);
    mix(bits);
  }
  for (const auto& [a, b] : body.connections.ends)
    mix((static_cast<std::uint64_t>(a) << 32) + static_cast<std::uint64_t>(b));
  mix(body.tetrahedra.size()), mix(body.triangles.size()), mix(body.cubes.size());
  return mark;
}

class Engine final : public StaticEngine {
 public:
  Engine() { start(); }

  std::shared_ptr<const Processes> processes() const override { return make_processes(); }

  void complete(const Model& model, Positions& forces) override {
    if (model.has_complete_rows()) return model.spread(forces);
    const SharedBody& body = setting(model).body;
    body.add_up(forces);
    body.spread(forces);
  }

  std::string unsuited(const Model& model) const override {
    return model.has_complete_rows() ? unsuited_for_any(model) : unsuited_for_balance(model);
  }

  StaticResponse respond(Model& model, const Positions& at, const Positions& load_change, const Positions& displacement,
                         const StaticOptions& options) override {
    return petsc::respond(model, setting(model), at, load_change, displacement, options);
  }

  StaticResult balance(Model& model, State& state, const StaticOptions& options) override {
    return petsc::balance(model, setting(model), state, options);
  }

  Model::Spread spreading(const Body& share) override {
    if (!share.share) return nullptr;
    return [setting = setting(share)](Positions& values) { setting->body.spread(values); };
  }

  StaticResult balance_step(Model& model, State& state, const StaticOptions& options,
                            const Kinematics& kinematics) override {
    if (!setting_ || &setting_->body.given() != &model.body()) setting(model.body());  // else spreading() made it
    return petsc::balance(model, *setting_, state, options, &kinematics);
  }

 private:
  /// Why it can take no part in equilibria or steps of a model; "" if it can.
  static std::string unsuited_for_any(const Model& model) {
    const Body& body = model.body();
    int processes = 1;
    MPI_Comm_size(PETSC_COMM_WORLD, &processes);
    if (molecules_of_whole(body) < processes)
      return "engine petsc: " + counted(body.size(), "molecule") + " cannot be shared out among " +
             counted(processes, "process", "processes");
    Subdomain nothing;
    nothing.whole = &body;
    nothing.body = std::make_shared<const Body>();
    for (const auto& term : model.elasticity())  // a share's model has only what can be
      if (!body.share && !term->on_subdomain(nothing)) return std::string("engine petsc: ") + kNotShared;
    if (!model.conservative()) return "engine petsc: the law or a load has no energy, by which equilibria are found";
    return "";
  }

  /// The same of an equilibrium.
  static std::string unsuited_for_balance(const Model& model) {
    for (const auto& load : model.loads())
      if (load->changes() && load->acts_at_rest())
        return "engine petsc: a load changes as the body moves, and equilibria are shared out under dead ones only: "
               "gravity, forces, prescribed displacements";
    return unsuited_for_any(model);
  }

  SharedSetting& setting(const Model& model) {
    const std::string why = unsuited_for_balance(model);
    if (!why.empty()) throw InputError(why);
    return *setting(model.body());
  }

  /// The last one, if it is of the same body.
  const std::shared_ptr<SharedSetting>& setting(const Body& body) {
    const std::uint64_t mark = mark_of(body);
    if (any_over(body, !setting_ || &setting_->body.given() != &body || mark != mark_)) {
      setting_ = std::make_shared<SharedSetting>(body);
      mark_ = mark;
    }
    return setting_;
  }

  std::shared_ptr<SharedSetting> setting_;
  std::uint64_t mark_ = 0;
};

}  // namespace

std::shared_ptr<StaticEngine> make_engine() { return std::make_shared<Engine>(); }

void add_to(Catalog& catalog) {
  Table<StaticEngineKind> engines(catalog.engines.kind());
  for (const auto& row : catalog.engines) {
    StaticEngineKind kind = *row;
    if (kind.name == "petsc") kind.make = make_engine, kind.missing = "";
    engines.add(std::move(kind));
  }
  catalog.engines = std::move(engines);
}

}  // namespace elastin::petsc
