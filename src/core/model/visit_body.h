#pragma once
#include <string>

#include "core/model/visit_state.h"
#include "elastin/core/geometry/cell_kind.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

/// The one description of what a body and its material are made of, for programs that hand them over to another kind of
/// machine; see base/archive. Bytes are taken as they come: the reader must have written them.
namespace elastin {

inline auto members(VoronoiCells& cells) {
  return std::tie(cells.problem, cells.face_area, cells.volume, cells.surface_area);
}
inline auto members(CellRange& range) { return std::tie(range.first, range.count); }

template <class Archive>
void visit(Archive& archive, CellBlock& block) {
  std::string name(block.kind ? block.kind->name : std::string_view());
  archive.word(name);
  block.kind = &cell_kind(name);
  visit_each(archive, block.nodes, block.stiffness);
}

inline auto members(Part& part) {
  return std::tie(part.name, part.first, part.count, part.rigid, part.material, part.shared, part.triangles,
                  part.tetrahedra, part.cubes, part.blocks, part.voronoi);
}
inline auto members(Tie& tie) { return std::tie(tie.molecule, tie.corners, tie.weights, tie.stiffness); }
inline auto members(Cable& cable) { return std::tie(cable.connection, cable.stiffness); }
inline auto members(Body& body) {
  return std::tie(body.rest, body.mass, body.radius, body.connection_stiffness, body.cell_stiffness,
                  body.connections.rest_length, body.connections.ends, body.connections.cell_sides, body.triangles,
                  body.cables, body.tetrahedra, body.blocks, body.cubes, body.grid, body.voronoi, body.parts, body.ties,
                  body.between, body.assumed_density, body.outline);
}

template <class Archive>
void visit(Archive& archive, StressStrain& curve) {
  auto pieces = *curve.pieces_;
  pieces.resize(archive.count(pieces.size(), sizeof(StressStrain::Piece)));
  for (auto& p : pieces) visit_each(archive, p.end, p.strain, p.stress, p.c1, p.c2, p.c3, p.energy);
  curve.pieces_ = std::make_shared<const std::vector<StressStrain::Piece>>(std::move(pieces));
}

inline auto members(Fibre& fibre) { return std::tie(fibre.direction, fibre.curve); }
inline auto members(Relaxation::Term& term) { return std::tie(term.share, term.time); }
inline auto members(Relaxation& relaxation) {
  return std::tie(relaxation.terms, relaxation.instantaneous, relaxation.retardation);
}
inline auto members(Softening& softening) { return std::tie(softening.r, softening.m, softening.beta); }
inline auto members(RoundAxis& axis) { return std::tie(axis.point, axis.direction); }
/// Without its function of time: see beyond_numbers.
inline auto members(ActiveFibre& active) { return std::tie(active.direction, active.stress, active.optimal_stretch); }
/// Without its function, which with_law gives again.
inline auto members(LawConstants& law) {
  return std::tie(law.law, law.numbers, law.directions, law.words, law.terms, law.youngs_modulus);
}
inline auto members(Material& material) {
  return std::tie(material.youngs_modulus, material.poissons_ratio, material.density, material.thickness,
                  material.bending_rigidity, material.curve, material.fibre, material.law, material.relaxation,
                  material.softening, material.around, material.active);
}

/// Why the numbers of a material are not all of it; "" where they are.
inline std::string beyond_numbers(const Material& material) {
  if (material.field) return "the material varies over the body by a function";
  if (material.active && material.active->activation) return "the activation of the muscle is a function of time";
  return "";
}

}  // namespace elastin
