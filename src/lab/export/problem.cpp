#include "lab/export/problem.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "elastin/core/base/text.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/simulation/strategy_name.h"
#include "lab/scene/fields.h"

namespace elastin::lab {
namespace {

[[noreturn]] void refuse(const Scene& scene, const std::string& what) {
  throw InputError(SourceLocation{scene.source.path()}, what);
}

/// Why a scene's body or surroundings are beyond other programs, or "".
std::string trouble(const Scene& scene) {
  const Specimen& specimen = scene.specimen;
  const Body& body = specimen.body;
  if (!scene.experiment->at_rest()) return "a run in time is not exported; experiments at rest are";
  if (identification_of(*scene.experiment)) return "the experiment is there to find the material";
  if (specimen.contact) return "contact is not exported";
  if (!body.ties.empty()) return "bodies that are tied where their molecules do not meet are not exported";
  if (!body.cables.empty()) return "cables are not exported";
  if (specimen.start) return "a start away from rest is not exported";
  if (specimen.given != GivenShape::at_rest)
    return "a `rest` that runs find is not exported; `run --out` writes the unloaded shape as a mesh";
  if (body.connection_stiffness.size() || body.cell_stiffness.size())
    return "regions of other stiffness are not exported";
  for (const Material& material : materials_of(specimen))
    if (material.field) return "a material that differs from place to place is not exported";
  for (const Part& part : body.parts)
    if (part.rigid) return "rigid bodies are not exported ('" + part.name + "')";
  for (const Material& material : materials_of(specimen))
    if (material.fibre || material.active) return "fibres in addition to the material's law are not exported";
  const Strategy& strategy = scene.stiffness.strategy;
  const std::string label = "'" + scene.stiffness.label + "'";
  if (strategy.kind != StrategyKind::cell_law)
    return label + " are springs, which other programs lack: choose a law of cells, --set stiffness=neo_hookean_log";
  if (strategy.dimensions != 3) return label + " is a law of membranes; solids are exported";
  if (strategy.has_history) return label + ": relaxation and softening are not exported";
  if (body.tetrahedra.empty() && !has_blocks(body, 3)) return "the body has no cells of three dimensions";
  return strategy.unsuited(body);
}

std::vector<ExportedCells> cells_of(const Body& body) {
  std::vector<ExportedCells> all;
  if (!has_blocks(body, 3)) {
    for (std::size_t cell = 0; cell < body.tetrahedra.size(); ++cell) {
      const int material = material_of(body, static_cast<int>(cell), &Part::tetrahedra);
      if (all.empty() || all.back().material != material) all.push_back({&cell_kind("tetrahedron4"), {}, material});
      const auto& nodes = body.tetrahedra[cell];
      all.back().nodes.insert(all.back().nodes.end(), nodes.begin(), nodes.end());
    }
    return all;
  }
  for (std::size_t block = 0; block < body.blocks.size(); ++block)
    if (body.blocks[block].kind->dimensions == 3)
      all.push_back({body.blocks[block].kind, body.blocks[block].nodes,
                     material_of(body, static_cast<int>(block), &Part::blocks)});
  return all;
}

/// Distinct values of a rest that are exported at most.
constexpr std::size_t kMostGrowths = 1000;

/// Gives cells that are unstressed elsewhere than at rest materials of their own, by what F_g they have.
void split_by_growth(const Scene& scene, StaticProblem& problem) {
  const Body& body = problem.body();
  std::vector<ExportedCells> all;
  std::vector<Material> materials;
  for (const ExportedCells& cells : problem.cells) {
    const std::size_t first = all.size();
    for (int cell = 0; cell < cells.size(); ++cell) {
      const std::span nodes(cells.nodes.data() + std::ptrdiff_t{cell} * cells.kind->nodes, cells.kind->nodes);
      const Vector3 middle = middle_of(body, nodes);
      const Matrix3 growth = body.unstressed->metric(middle, middle);
      for (const int node : nodes)
        if ((body.unstressed->metric(body.rest.col(node), middle) - growth).norm() > 1e-9)
          refuse(scene, "a `rest` that differs within a cell is not exported; one that differs from cell to cell is");
      std::size_t own = first;
      while (own < all.size() && (problem.growths[own] - growth).norm() > 1e-12) ++own;
      if (own == all.size()) {
        if (own == kMostGrowths)
          refuse(scene, "a `rest` of more than " + std::to_string(kMostGrowths) + " values is not exported");
        all.push_back({cells.kind, {}, static_cast<int>(own)});
        materials.push_back(problem.materials[static_cast<std::size_t>(cells.material)]);
        problem.growths.push_back(growth);
      }
      all[own].nodes.insert(all[own].nodes.end(), nodes.begin(), nodes.end());
    }
  }
  problem.cells = std::move(all), problem.materials = std::move(materials);
  for (const double step : problem.steps)
    problem.rest_parts.push_back(body.unstressed->part ? body.unstressed->part(step) : step);
}

/// What the experiment does with the body: read off the supports and loads of a model at every load step.
class ProblemReading {
 public:
  ProblemReading(const Scene& scene, StaticProblem& problem) : problem_(problem), model_(scene.specimen.body) {
    for (const SpecimenLoad& load : scene.specimen.loads) load.add(model_);
    rig_ = scene.experiment->at_rest()->static_rig(model_);
    for (const auto& load : model_.loads())
      if (load->changes() && load->acts_at_rest())
        refuse(scene, "a load that changes with the body (a pressure, a floor) is not exported");
    set_driven(scene);
    read_steps(*scene.experiment->at_rest());
  }

 private:
  void set_driven(const Scene& scene) {
    for (const Support& support : model_.supports)
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 free = support.free.col(axis);
        if ((free - Vector3::Unit(axis)).norm() < 1e-12) continue;
        if (free.norm() > 1e-12)
          refuse(scene, "a support that is free askew to x, y and z is not exported; turn the body, not the supports");
        problem_.driven.push_back({support.molecule, axis, {}});
        supports_.push_back(&support - model_.supports.data());
      }
  }
  void read_steps(const StaticExperiment& experiment) {
    const State rest = state_at_rest(model_.body());
    double before = 0;
    for (int step = 1; step <= experiment.load_steps(); ++step) {
      const double after = experiment.load_factor(step);
      // Other programs go straight: where supports turn, in substeps that are short enough for that.
      const double parts = problem_.small ? 1 : std::ceil(std::abs(after - before) / rig_->longest_step() - 1e-9);
      for (double part = 1; part <= parts; ++part)
        problem_.steps.push_back(part == parts ? after : before + (after - before) * part / parts);
      before = after;
    }
    for (const double factor : problem_.steps) {
      rig_->set_load(factor);
      for (std::size_t i = 0; i < supports_.size(); ++i) {
        const Support& support = model_.supports[supports_[i]];
        problem_.driven[i].displacements.push_back(support.displacement[problem_.driven[i].axis]);
      }
      problem_.forces.push_back(model_.load_forces(rest));
    }
  }

  StaticProblem& problem_;
  Model model_;
  std::unique_ptr<StaticRig> rig_;
  std::vector<std::ptrdiff_t> supports_;  ///< of each driven component
};

}  // namespace

int material_of(const Body& body, int cell, CellRange Part::*range) {
  for (const Part& part : body.parts)
    if (cell >= (part.*range).first && cell < (part.*range).first + (part.*range).count) return part.material;
  return 0;
}

StaticProblem problem_of(const Scene& scene) {
  if (const std::string why = trouble(scene); !why.empty()) refuse(scene, why);
  StaticProblem problem;
  problem.scene = &scene;
  problem.cells = cells_of(scene.specimen.body);
  problem.materials = materials_of(scene.specimen);
  for (const Material& material : problem.materials)
    if (states_own_law(material, problem.materials))
      refuse(scene, "a part with a law of its own, " + material.law->law + ", is not exported");
  problem.law = StrategyName(scene.stiffness.strategy.name).rule;
  problem.whole_cell = static_cast<bool>(scene.stiffness.strategy.volume_modulus);
  problem.small = scene.statics.linear;
  ProblemReading(scene, problem);
  if (scene.specimen.body.unstressed) split_by_growth(scene, problem);
  if (auto more = missing_supports(problem); !more.empty()) {
    problem.notes.push_back(
        counted(static_cast<int>(more.size()), "component") +
        " of displacement fixed in addition to the experiment's, without force, where it leaves the body "
        "free to move as a whole");
    problem.driven.insert(problem.driven.end(), more.begin(), more.end());
  }
  return problem;
}

std::vector<DrivenComponent> missing_supports(const StaticProblem& problem) {
  const Positions& rest = problem.body().rest;
  const Vector3 middle = rest.rowwise().mean();
  const double size = std::sqrt((rest.colwise() - middle).colwise().squaredNorm().maxCoeff());
  using Six = Eigen::Matrix<double, 6, 1>;
  // The effect of a rigid motion, three translations and three rotations, on a component.
  const auto row = [&](int molecule, int axis) {
    const Vector3 arm = (rest.col(molecule) - middle) / size;
    Six result;
    result << Vector3::Unit(axis), arm.cross(Vector3(Vector3::Unit(axis)));
    return result;
  };
  // By rows of length 1 that are square to each other; what is left of another row says whether it adds anything.
  std::vector<Six> held;
  const auto left = [&](Six own) {
    for (int twice = 0; twice < 2; ++twice)
      for (const Six& other : held) own -= own.dot(other) * other;
    return own;
  };
  const auto hold = [&](const Six& own, double least) {
    const Six more = left(own);
    if (more.norm() > least && held.size() < 6) held.push_back(more.normalized());
  };
  for (const DrivenComponent& driven : problem.driven) hold(row(driven.molecule, driven.axis), 1e-6);
  std::vector<DrivenComponent> more;
  while (held.size() < 6) {
    DrivenComponent best;
    double most = 0;
    for (int molecule = 0; molecule < rest.cols(); ++molecule)
      for (int axis = 0; axis < 3; ++axis)
        if (const double gain = left(row(molecule, axis)).norm(); gain > most * (1 + 1e-9))
          most = gain, best = {molecule, axis, {}};
    if (!(most > 1e-6)) break;  // all molecules on one line
    best.displacements.assign(problem.steps.size(), 0);
    hold(row(best.molecule, best.axis), 0);
    more.push_back(std::move(best));
  }
  return more;
}

}  // namespace elastin::lab
