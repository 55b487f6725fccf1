#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/model/visit_state.h"
#include "elastin/core/geometry/cell_kind.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

/// The one description of what a body and its material are made of, for programs that hand them over to another kind of
/// machine; see base/archive. Bytes are taken as they come: the reader must have written them.
namespace elastin {

template <class Archive>
void visit(Archive& archive, VectorX& numbers) {
  numbers.resize(static_cast<Eigen::Index>(archive.count(static_cast<std::size_t>(numbers.size()), sizeof(double))));
  archive.numbers(numbers.data(), static_cast<std::size_t>(numbers.size()));
}

template <class Archive>
void visit(Archive& archive, std::string& word) {
  archive.word(word);
}

template <class Archive, class Item, std::size_t size>
void visit(Archive& archive, std::array<Item, size>& items) {
  for (Item& item : items) visit(archive, item);
}

template <class Archive, class First, class Second>
void visit(Archive& archive, std::pair<First, Second>& pair) {
  visit(archive, pair.first);
  visit(archive, pair.second);
}

template <class Archive, class Item>
void visit(Archive& archive, std::vector<Item>& items) {
  visit_all(archive, items);
}

template <class Archive, class Item>
void visit(Archive& archive, std::optional<Item>& item) {
  int present = item.has_value();
  archive.whole(present);
  if (present && !item) item.emplace();
  if (item) visit(archive, *item);
}

template <class Archive, class Item>
void visit(Archive& archive, std::map<std::string, Item>& items) {
  std::vector<std::pair<std::string, Item>> list(items.begin(), items.end());
  visit_all(archive, list);
  items = {list.begin(), list.end()};
}

template <class Archive>
void visit(Archive& archive, VoronoiCells& cells) {
  archive.word(cells.problem);
  visit(archive, cells.face_area);
  visit(archive, cells.volume);
  visit(archive, cells.surface_area);
}

template <class Archive>
void visit(Archive& archive, CellRange& range) {
  archive.whole(range.first);
  archive.whole(range.count);
}

template <class Archive>
void visit(Archive& archive, CellBlock& block) {
  std::string name(block.kind ? block.kind->name : std::string_view());
  archive.word(name);
  block.kind = &cell_kind(name);
  visit_all(archive, block.nodes);
  visit(archive, block.stiffness);
}

template <class Archive>
void visit(Archive& archive, Part& part) {
  archive.word(part.name);
  int rigid = part.rigid;
  for (int* value : {&part.first, &part.count, &rigid, &part.material}) archive.whole(*value);
  part.rigid = rigid != 0;
  visit_all(archive, part.shared);
  for (CellRange* range : {&part.triangles, &part.tetrahedra, &part.cubes, &part.blocks}) visit(archive, *range);
  visit(archive, part.voronoi);
}

template <class Archive>
void visit(Archive& archive, Tie& tie) {
  archive.whole(tie.molecule);
  visit(archive, tie.corners);
  archive.numbers(tie.weights.data(), tie.weights.size());
  visit(archive, tie.stiffness);
}

template <class Archive>
void visit(Archive& archive, Cable& cable) {
  archive.whole(cable.connection);
  visit(archive, cable.stiffness);
}

template <class Archive>
void visit(Archive& archive, Body& body) {
  visit(archive, body.rest);
  for (VectorX* of_each : {&body.mass, &body.radius, &body.connection_stiffness, &body.cell_stiffness})
    visit(archive, *of_each);
  visit(archive, body.connections.rest_length);
  visit(archive, body.connections.ends);
  archive.whole(body.connections.cell_sides);
  visit(archive, body.triangles);
  visit(archive, body.cables);
  visit(archive, body.tetrahedra);
  visit(archive, body.blocks);
  visit(archive, body.cubes);
  visit(archive, body.grid);
  visit(archive, body.voronoi);
  visit(archive, body.parts);
  visit(archive, body.ties);
  visit(archive, body.between);
  visit(archive, body.assumed_density);
}

template <class Archive>
void visit(Archive& archive, StressStrain& curve) {
  auto pieces = *curve.pieces_;
  pieces.resize(archive.count(pieces.size(), sizeof(StressStrain::Piece)));
  for (StressStrain::Piece& p : pieces)
    for (double* value : {&p.end, &p.strain, &p.stress, &p.c1, &p.c2, &p.c3, &p.energy}) visit(archive, *value);
  curve.pieces_ = std::make_shared<const std::vector<StressStrain::Piece>>(std::move(pieces));
}

template <class Archive>
void visit(Archive& archive, Fibre& fibre) {
  visit(archive, fibre.direction);
  visit(archive, fibre.curve);
}

template <class Archive>
void visit(Archive& archive, Relaxation::Term& term) {
  visit(archive, term.share);
  visit(archive, term.time);
}

template <class Archive>
void visit(Archive& archive, Relaxation& relaxation) {
  visit_all(archive, relaxation.terms);
  int instantaneous = relaxation.instantaneous;
  archive.whole(instantaneous);
  relaxation.instantaneous = instantaneous != 0;
  visit(archive, relaxation.retardation);
}

template <class Archive>
void visit(Archive& archive, Softening& softening) {
  for (double* value : {&softening.r, &softening.m, &softening.beta}) visit(archive, *value);
}

template <class Archive>
void visit(Archive& archive, RoundAxis& axis) {
  visit(archive, axis.point);
  visit(archive, axis.direction);
}

/// Without its function of time: see beyond_numbers.
template <class Archive>
void visit(Archive& archive, ActiveFibre& active) {
  visit(archive, active.direction);
  visit(archive, active.stress);
  visit(archive, active.optimal_stretch);
}

/// Without its function, which with_law gives again.
template <class Archive>
void visit(Archive& archive, LawConstants& law) {
  archive.word(law.law);
  visit(archive, law.numbers);
  visit(archive, law.directions);
  visit(archive, law.words);
  visit(archive, law.terms);
  visit(archive, law.youngs_modulus);
}

template <class Archive>
void visit(Archive& archive, Material& material) {
  for (double* value : {&material.youngs_modulus, &material.poissons_ratio, &material.density, &material.thickness,
                        &material.bending_rigidity})
    visit(archive, *value);
  visit(archive, material.curve);
  visit(archive, material.fibre);
  visit(archive, material.law);
  visit(archive, material.relaxation);
  visit(archive, material.softening);
  visit(archive, material.around);
  visit(archive, material.active);
}

/// Why the numbers of a material are not all of it; "" where they are.
inline std::string beyond_numbers(const Material& material) {
  if (material.field) return "the material varies over the body by a function";
  if (material.active && material.active->activation) return "the activation of the muscle is a function of time";
  return "";
}

}  // namespace elastin
