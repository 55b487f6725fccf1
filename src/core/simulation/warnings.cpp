#include "core/simulation/warnings.h"

#include <algorithm>

#include "core/simulation/simulation_impl.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// Cells of this process whose nodes are another's.
int cells_given_twice(const Body& body) {
  std::vector<std::vector<int>> cells;
  const auto add = [&](const auto& all) {
    for (const auto& cell : all)
      if (lowest_in_whole(body, cell) < owned_molecules(body)) cells.emplace_back(cell.begin(), cell.end());
  };
  if (body.blocks.empty()) add(body.tetrahedra), add(body.triangles);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) {
      const auto nodes = block.cell(cell);
      cells.emplace_back(nodes.begin(), nodes.end());
    }
  for (std::vector<int>& cell : cells) std::sort(cell.begin(), cell.end());
  std::sort(cells.begin(), cells.end());
  int count = 0;
  for (std::size_t cell = 1; cell < cells.size(); ++cell) count += cells[cell] == cells[cell - 1];
  return count;
}

double largest_in(const Body& body, const std::vector<Material>& materials) {
  double most = -1;
  for (const Material& material : materials) most = std::max(most, largest_poissons_ratio(material, body));
  return most;
}

constexpr double kSamePlace = 1e-6;  ///< of the body's extent

}  // namespace

std::string warning_of_pieces(const Body& body, const std::string& name) {
  const BodyFindings findings = inspect(body);
  if (findings.pieces <= 1) return "";
  const auto isolated = findings.isolated_molecules.size();
  const double extent = (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).maxCoeff();
  const std::size_t same = extent > 0 ? connections_within(body.rest, kSamePlace * extent).ends.size() : 0;
  return name + " is not connected: " + std::to_string(findings.pieces) + " pieces" +
         (isolated == 0   ? ""
          : isolated == 1 ? ", one of them an isolated molecule"
                          : ", " + std::to_string(isolated) + " of them isolated molecules") +
         (same == 0 ? ""
                    : "; " + counted(static_cast<std::ptrdiff_t>(same), "pair") +
                          " of molecules at the same place (of a mesh, `join` makes one of each)");
}

std::string warning_of_doubles(const Body& body, bool uses_cells) {
  const int doubles = static_cast<int>(sum_over(body, cells_given_twice(body)));
  if (doubles == 0) return "";
  return counted(doubles, "cell") + (doubles == 1 ? " is" : " are") + " given twice" +
         (uses_cells ? ": there the body is twice as stiff" : "");
}

std::string warning_of_modes(const ModeReport& report) {
  if (report.zero_energy_modes == 0) return "";
  return "mechanism: " + std::string(report.counted ? "" : "at least ") +
         counted(report.zero_energy_modes, "zero-energy mode", "zero-energy modes");
}

double largest_poissons_ratio(const Material& material, const Body& body) {
  double most = material.poissons_ratio;
  for (int molecule = 0; material.field && molecule < body.size(); ++molecule)
    most = std::max(most, local_material(material, body.rest.col(molecule)).poissons_ratio);
  return most;
}

bool may_lock(const Body& body, const std::vector<Material>& materials, const Strategy& strategy) {
  return strategy.kind == StrategyKind::cell_law && strategy.dimensions == 3 && !strategy.volume_modulus &&
         largest_in(body, materials) > kLocking;
}

std::string warning_of_locking(const Body& body, const std::vector<Material>& materials, const Strategy& strategy) {
  const bool can = strategy.make_without_volume || strategy.make_mixed, blocks = has_blocks(body, 3);
  if (!may_lock(body, materials, strategy) || (!can && blocks)) return "";
  StrategyName with_volume(strategy.name);
  with_volume.volume = true;
  const std::string with = "stiffness: " + with_volume.text(),
                    found = "nu = " + number(largest_in(body, materials), 4) +
                            ": cells without a volume term may lock, and are then too stiff; ";
  if (strategy.make_without_volume || (strategy.make_mixed && blocks)) return found + "write " + with;
  if (strategy.make_mixed) return found + "write `order: 2` in the body and " + with;
  return found + (strategy.has_history ? "give the law behind the colon one: neo_hookean+volume"
                                       : "neo_hookean+volume has one");
}

std::vector<std::string> Simulation::warnings(bool mechanisms) const {
  constexpr double few = 0.1;
  const Impl& in = *impl_;
  std::vector<std::string> all;
  const auto add = [&](std::string text) {
    if (!text.empty()) all.push_back(std::move(text));
  };
  if (in.body.parts.empty()) add(warning_of_pieces(in.body, "the body"));
  for (const Part& part : in.body.parts)
    if (!part.rigid) add(warning_of_pieces(part_alone(in.body, part).body, "body '" + part.name + "'"));
  const bool cells = in.strategy && in.strategy->kind == StrategyKind::cell_law;
  add(warning_of_doubles(in.body, cells));
  if (cells && in.strategy->dimensions == 2 && !(in.material->thickness > 0))
    add("the material has no thickness: a membrane without one has no stiffness");
  if (in.strategy && in.body.parts.empty()) add(warning_of_locking(in.body, {*in.material}, *in.strategy));
  if (mechanisms && !(in.material && in.material->bending_rigidity > 0)) {
    std::vector<char> stiff(in.body.connections.ends.size(), 1);
    if (in.strategy && !cells) std::fill(stiff.begin() + in.body.connections.proper(), stiff.end(), 0);
    const VectorX constants = in.recipe.constants ? in.recipe.constants(in) : in.constants;
    for (Eigen::Index c = 0; c < constants.size(); ++c) stiff[c] = constants[c] != 0;
    add(warning_of_modes(find_modes_in_parts(in.body, in.model.supports, stiff)));
  }
  if (in.late_steps > few * in.timed_steps)
    add("the budget of " + number(in.options.budget) + " s is not kept: " + std::to_string(in.late_steps) + " of " +
        counted(in.timed_steps, "step") + " took longer with one sweep or iteration alone");
  return all;
}

}  // namespace elastin
