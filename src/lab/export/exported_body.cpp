#include "lab/export/exported_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/forces/unstressed_lengths.h"
#include "core/shapes/orders.h"
#include "core/solve/stable_step.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/parts.h"
#include "lab/export/problem.h"
#include "lab/run/cell_stress.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

using Cell = ExportedBody::Cell;

/// Its part's material, with the numbers of the middle of its nodes.
Cell cell_of(const Specimen& specimen, const CellKind& kind, std::vector<int> nodes, std::size_t number,
             CellRange Part::*range) {
  const int which = specimen.materials.empty() ? 0 : material_of(specimen.body, static_cast<int>(number), range);
  const Material& material = specimen.materials.empty() ? specimen.material : specimen.materials[which];
  Vector3 middle = Vector3::Zero();
  for (const int node : nodes) middle += specimen.body.rest.col(node) / static_cast<double>(nodes.size());
  const auto cell = [&](const Material& own) {
    return Cell{&kind, std::move(nodes), own.youngs_modulus, own.poissons_ratio, own.density, which};
  };
  return material.field ? cell(local_material(material, middle)) : cell(material);
}

std::vector<Cell> simplices(const Specimen& specimen, const Body& body) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < body.tetrahedra.size(); ++i)
    cells.push_back(cell_of(specimen, cell_kind("tetrahedron4"), {body.tetrahedra[i].begin(), body.tetrahedra[i].end()},
                            i, &Part::tetrahedra));
  return cells;
}

/// How many times as stiff as its material each of the body's tetrahedra is: its own, then those of the blocks' cells.
std::vector<double> stiffness_of_tetrahedra(const Body& body) {
  std::vector<double> all(OwnSimplices(body).tetrahedra, 1);
  if (body.cell_stiffness.size())
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = body.cell_stiffness[static_cast<Eigen::Index>(i)];
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; block.kind->dimensions == 3 && cell < block.size(); ++cell)
      all.insert(all.end(), simplices_of(*block.kind, block.cell(cell)).size(),
                 block.stiffness.size() ? block.stiffness[cell] : 1);
  return all;
}

/// The mass that each molecule has of its cells, by the materials alone [kg].
VectorX masses_of_materials(const Specimen& specimen) {
  const auto masses = [](const Body& body, const Material& material) -> VectorX {
    return material.density * (body.blocks.empty()
                                   ? lumped_mass(body.rest, body.triangles, body.tetrahedra, 1, material.thickness)
                                   : lumped_volumes(body, material.thickness));
  };
  const Body& body = specimen.body;
  if (specimen.materials.empty()) return masses(body, specimen.material);
  VectorX all = VectorX::Zero(body.size());
  for (const Part& part : body.parts) {
    const PartAlone alone = part_alone(body, part);
    all(alone.molecules) += masses(alone.body, specimen.materials[part.material]);
  }
  return all;
}

/// Gives cells the density of their molecules, which regions, images and masses of the body's own make another than the
/// material's: as many times that as their nodes have its mass, in the mean.
void weigh(const Specimen& specimen, std::vector<Cell>& cells) {
  constexpr double rounding = 1e-9;
  const VectorX share = specimen.body.mass.cwiseQuotient(masses_of_materials(specimen));
  for (Cell& cell : cells) {
    double density = 0;
    for (const int node : cell.nodes) density += share[node] / static_cast<double>(cell.nodes.size());
    density *= (specimen.materials.empty() ? specimen.material : specimen.materials[cell.material]).density;
    if (std::isfinite(density) && std::abs(density - cell.density) > rounding * density) cell.density = density;
  }
}

void set_cells(const Specimen& specimen, ExportedBody& result) {
  const Body& body = specimen.body;
  for (std::size_t block = 0; block < body.blocks.size(); ++block)
    for (int i = 0; i < body.blocks[block].size(); ++i) {
      const auto nodes = body.blocks[block].cell(i);
      result.cells.push_back(
          cell_of(specimen, *body.blocks[block].kind, {nodes.begin(), nodes.end()}, block, &Part::blocks));
      if (body.blocks[block].stiffness.size()) result.cells.back().youngs_modulus *= body.blocks[block].stiffness[i];
    }
  const bool of_boxes = body.blocks.empty() && body.tetrahedra.empty() && !body.cubes.empty();
  result.tetrahedra =
      simplices(specimen, of_boxes && body.parts.empty() ? with_cells(body, cell_kind("hexahedron8")) : body);
  for (std::size_t i = 0; of_boxes && i < body.cubes.size(); ++i) {
    const auto& box = body.cubes[i];
    result.cells.push_back(cell_of(specimen, cell_kind("hexahedron8"),
                                   {box[0], box[1], box[3], box[2], box[4], box[5], box[7], box[6]}, i, &Part::cubes));
  }
  if (of_boxes) {
    if (has_other_stiffness(body))
      result.notes.emplace_back("regions of other stiffness are in the connections; E of the cells is the material's");
    return;
  }
  const std::vector<double> stiffness = stiffness_of_tetrahedra(body);
  for (std::size_t i = 0; i < stiffness.size(); ++i) result.tetrahedra[i].youngs_modulus *= stiffness[i];
  if (body.blocks.empty()) result.cells = result.tetrahedra;
  if (result.cells.empty())
    for (std::size_t i = 0; i < body.triangles.size(); ++i) {
      result.cells.push_back(cell_of(specimen, cell_kind("triangle3"),
                                     {body.triangles[i].begin(), body.triangles[i].end()}, i, &Part::triangles));
      if (body.cell_stiffness.size())
        result.cells.back().youngs_modulus *= body.cell_stiffness[static_cast<Eigen::Index>(i)];
    }
  weigh(specimen, result.cells);
  weigh(specimen, result.tetrahedra);
}

/// The lengths that connections want under all of the body's rest.
UnstressedLengths wanted_lengths(const Body& body) {
  UnstressedLengths lengths(body);
  if (body.unstressed) lengths.set(body.unstressed->part ? body.unstressed->part(1) : 1);
  return lengths;
}

/// Of springs with a history, which have no constants as such: k = 2 l³/L ∂q/∂s at rest after all time, before any
/// softening.
VectorX constants_after_all_time(const Body& body, ElasticTerms springs) {
  Model model(body);
  model.add(std::move(springs));
  State rest = state_at_rest(body);
  model.declare_history(rest);
  model.begin_step(rest, std::numeric_limits<double>::infinity());
  const Tangent tangent(model, rest);
  const UnstressedLengths lengths = wanted_lengths(body);
  VectorX constants(body.connections.size());
  for (int c = 0; c < constants.size(); ++c) {
    const Tangent::Link link = tangent.link(c);
    constants[c] = link.slope * std::pow(link.d.norm(), 3) / lengths[c];
  }
  return constants;
}

/// All that have a constant: sides of cells, too, where the rule gives them one.
void set_connections(const Body& body, const VectorX& constants, ExportedBody& result) {
  const UnstressedLengths lengths = wanted_lengths(body);
  int without = 0;
  for (int i = 0; i < constants.size(); ++i)
    if (constants[i] != 0)
      result.connections.push_back(
          {body.connections.ends[i][0], body.connections.ends[i][1], lengths[i], constants[i]});
    else
      without += i < body.connections.proper();
  if (without > 0) result.notes.push_back(counted(without, "connection") + " without stiffness left out");
}

/// The longest step of explicit integration [s], whatever an engine fixes: supports make it longer alone.
double explicit_step(const Body& body, const VectorX& constants) {
  if (constants.size() == 0) return INFINITY;
  Model model(body);
  model.add(make_springs(body, constants));
  return find_stable_step(model, state_at_rest(body)).step;
}

/// Leaves out what supports hold in directions askew to x, y and z.
void leave_out_askew(ExportedBody& result) {
  const auto is_free = [](const Support& support, int axis) {
    return (support.free.col(axis) - Vector3::Unit(axis)).norm() < 1e-12;
  };
  std::erase_if(result.supports, [&](Support& support) {
    bool askew = false, holds = false;
    for (int axis = 0; axis < 3; ++axis) {
      holds |= is_held(support, axis);
      if (is_held(support, axis) || is_free(support, axis)) continue;
      askew = true;
      support.displacement[axis] = 0;
    }
    result.askew += askew;
    return askew && !holds;
  });
  if (result.askew > 0)
    result.notes.push_back(counted(result.askew, "support that slides", "supports that slide") +
                           " in directions askew to x, y and z not written, as engines have none like that: leave out "
                           "`rotate`, or write `fixed_grip: clamped` and `loaded_grip: clamped`");
}

/// What engines lack of the scene.
void add_notes(const Scene& scene, const StrategyChoice& choice, const Run& run, ExportedBody& result) {
  const Specimen& specimen = scene.specimen;
  const Strategy& strategy = choice.strategy;
  const auto say = [&](bool is_so, std::string what) {
    if (is_so) result.notes.push_back(std::move(what));
  };
  const bool springs = run.constants.size() > 0;
  say(springs && run.volume_modulus > 0,
      fmt::format(
          "the volume term, {:.6g} Pa, is not in the connections: without it the body is softer against changes "
          "of volume",
          run.volume_modulus));
  say(!springs && strategy.volume_modulus, "the pressures of the cells, which prevent locking, are not written");
  say(strategy.kind == StrategyKind::updated_spring_rule,
      "the constants are those at rest: '" + choice.label + "' updates them as the body deforms");
  say(strategy.kind == StrategyKind::cell_law && !strategy.law.empty(),
      "of the law '" + strategy.law + "' there are E and nu at small strain");
  bool curve = false, fibres = false, bends = false;
  for (const Material& material : materials_of(specimen)) {
    curve |= material.curve.has_value();
    fibres |= material.fibre || material.active;
    bends |= material.bending_rigidity > 0;
  }
  say(curve, "the springs are straight: the material's curve is not written, only its slope at no strain");
  say(fibres, "fibres and muscle are not written");
  say(bends, "the bending stiffness is not written");
  say(strategy.has_history,
      "relaxation and softening are not written: the constants are those of a body that has had all time and was never "
      "strained");
  say(!specimen.body.cables.empty(), "cables are not written");
  say(!specimen.body.ties.empty(), "ties between bodies are not written");
  say(specimen.contact.has_value(), "contact is not written");
  say(static_cast<bool>(specimen.start),
      "the start away from rest (`initial`) is in csv and json alone: the others begin at rest");
  say(scene.statics.linear,
      "the scene has small displacements, for which springs keep their directions: an engine's turn with the body, and "
      "show other forces");
  say(!scene.experiment->at_rest(), "the experiment runs in time: its supports and loads are not written");
}

}  // namespace

bool is_held(const Support& support, int axis) { return support.free.col(axis).norm() < 1e-12; }

void set_test(const Scene& scene, ExportedBody& result) {
  const Specimen& specimen = scene.specimen;
  result.forces = Positions::Zero(3, specimen.body.size());
  if (!scene.experiment->at_rest()) return;
  Model model(specimen.body);
  for (const SpecimenLoad& load : specimen.loads) load.add(model);
  const auto rig = scene.experiment->at_rest()->static_rig(model);
  rig->set_load(1);
  if (!specimen.contact) result.forces = model.load_forces(state_at_rest(specimen.body));
  for (const auto& load : model.loads())
    if (load->changes() && load->acts_at_rest()) {
      result.notes.emplace_back(
          "loads that follow the body, as pressure and a floor do, are written as the forces that they have at rest");
      break;
    }
  if (!model.viscosity().empty() ||
      std::any_of(model.loads().begin(), model.loads().end(), [](const auto& load) { return load->resists(); }))
    result.notes.emplace_back("damping and drag are not written");
  result.supports = model.supports;
}

ExportedBody exported_body(const Scene& scene, const StrategyChoice& choice) {
  Specimen specimen = scene.specimen;
  prepare(specimen, choice.strategy);
  Run run;
  RunOptions options;
  options.statics = scene.statics;
  State start = state_at_rest(specimen.body);
  if (specimen.start) specimen.start(start);
  run.cause = unsuited(specimen, *scene.experiment, choice);
  if (run.cause.empty() && specimen.given != GivenShape::at_rest) {
    const Run own = run_strategy(specimen, *scene.experiment, choice, options);
    run.cause = own.cause;
    if (own.found) specimen.body = *own.found, specimen.given = GivenShape::at_rest;
  }
  if (run.cause.empty() && specimen.body.unstressed && choice.strategy.kind == StrategyKind::cell_law)
    run.cause = "`rest` of cells is not exported; that of springs is, as rest lengths: choose a spring rule";
  std::optional<ElasticTerms> elasticity;
  if (run.cause.empty()) elasticity = make_elasticity(specimen, *scene.experiment, choice, options, run);
  if (!elasticity) throw InputError(SourceLocation{scene.source.path()}, "'" + choice.label + "': " + run.cause);
  if (choice.strategy.constants_at)
    run.constants = choice.strategy.constants_at(specimen.body, specimen.material, choice.values)(specimen.body.rest);
  if (choice.strategy.has_history && choice.strategy.kind != StrategyKind::cell_law)
    run.constants = constants_after_all_time(specimen.body, std::move(*elasticity));
  ExportedBody result;
  result.name = scene.name;
  result.title = scene.title;
  result.strategy = choice.label;
  result.positions = specimen.body.rest;
  if (start.positions != specimen.body.rest) result.start = start.positions;
  result.masses = specimen.body.mass;
  result.radii = specimen.body.radius;
  result.thickness = mean_thickness(specimen.body, specimen.material.thickness);
  result.notes = run.warnings;
  set_connections(specimen.body, run.constants, result);
  result.explicit_step = explicit_step(specimen.body, run.constants);
  set_cells(specimen, result);
  set_test(scene, result);
  leave_out_askew(result);
  add_notes(scene, choice, run, result);
  return result;
}

}  // namespace elastin::lab
