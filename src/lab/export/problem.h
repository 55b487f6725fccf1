#pragma once
#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/base/error.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// Cells of one shape and one material of a problem.
struct ExportedCells {
  const CellKind* kind = nullptr;
  std::vector<int> nodes;  ///< molecules, kind->nodes each
  int material = 0;
  int size() const { return static_cast<int>(nodes.size()) / kind->nodes; }
};

/// A component of a molecule's displacement that is prescribed, [m] at the end of each step.
struct DrivenComponent {
  int molecule = 0, axis = 0;
  std::vector<double> displacements;
};

/// An equilibrium problem without anything of Elastin's own in it: what other programs are given. It refers to a scene.
struct StaticProblem {
  const Scene* scene = nullptr;
  std::vector<ExportedCells> cells;
  std::vector<Material> materials;
  std::string law;                 ///< the strategy's, without ending: "neo_hookean"
  bool whole_cell = false;         ///< the volume is kept by pressures of the whole cell
  bool small = false;              ///< small displacements
  std::vector<double> steps;       ///< the part of the load at the end of each, 0 … 1
  std::vector<Matrix3> growths;    ///< of each material, where cells are unstressed [Rest]; empty: at rest
  std::vector<double> rest_parts;  ///< of it, at the end of each step
  std::vector<DrivenComponent> driven;
  std::vector<Positions> forces;   ///< dead forces on the molecules [N] at the end of each step
  std::vector<std::string> notes;  ///< what was done to the problem so that another program takes it
  const Body& body() const { return scene->specimen.body; }
};

/// The problem of a scene with its own strategy. Throws InputError, with the scene's path, for what is
/// not exported: springs, membranes, contact, ties, cables, fibres, muscle, regions, supports askew to the axes, loads
/// that follow the body, a rest that differs within a cell, runs in time.
StaticProblem problem_of(const Scene& scene);

/// Number of the material of a cell, by its number in one of the body's lists.
int material_of(const Body& body, int cell, CellRange Part::*range);

/// Components that hold the whole body in those of its three translations and three rotations that the problem leaves
/// free; they bear no force. Programs that factor the stiffness need them.
std::vector<DrivenComponent> missing_supports(const StaticProblem& problem);

/// A text that grows, and the refusal of what its program does not support.
class Deck {
 protected:
  Deck(const char* program, const StaticProblem& problem) : program_(program), scene_(*problem.scene) {}

  template <class... Args>
  void write(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(SourceLocation{scene_.source.path()}, std::string(program_) + ": " + what);
  }

  std::string out_;

 private:
  const char* program_;
  const Scene& scene_;
};

}  // namespace elastin::lab
