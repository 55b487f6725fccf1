#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/simulation/simulation.h"

namespace elastin {

/// A number that an experiment has read off a body, SI units.
struct Measured {
  std::string name, unit;  ///< "effective_modulus", "Pa"; unit "" of a ratio
  double value = 0;
};

/// What came of one strategy on a scene.
struct LaboratoryResult {
  std::string strategy;
  Outcome outcome = Outcome::converged;
  bool suited = true;              ///< false: the strategy cannot run on this body
  std::string cause;               ///< why it did not converge or is unsuited; empty if it did
  std::vector<Measured> measures;  ///< of the last load step, or of the course of a run in time
  /// One row a load step or frame: its load factor (time [s] of a run in time) and what was measured there.
  struct Row {
    double at = 0;
    std::vector<Measured> measures;
  };
  std::vector<Row> curve;
  Positions positions;  ///< [m], 3 × n, of the last state; empty where none was reached
  VectorX tensions;     ///< [N], one a connection, pulling is positive; as positions
  std::vector<std::string> warnings;
  double build_seconds = 0, solve_seconds = 0;
  /// The measure of this name; NaN if it was not taken.
  double get(const std::string& name) const;
};

/// A scene file, read, checked and built: the laboratory for programs of their own.
class Laboratory {
 public:
  /// `overrides` are "key.path=value", as the command's --set. Throws InputError as the command says it:
  /// file:line:column.
  explicit Laboratory(const std::string& scene, const std::vector<std::string>& overrides = {});
  /// With a catalog that the program has added to; it must outlive the laboratory.
  Laboratory(const std::string& scene, const Catalog& catalog, const std::vector<std::string>& overrides = {});
  ~Laboratory();
  Laboratory(Laboratory&&) noexcept;
  Laboratory& operator=(Laboratory&&) noexcept;

  const std::string& name() const;
  const std::string& title() const;
  const Body& body() const;
  const Material& material() const;
  std::string strategy() const;                 ///< the scene's own: what run takes
  std::vector<std::string> strategies() const;  ///< those that the scene compares
  /// Values that the scene holds the measures against.
  std::vector<Measured> references() const;

  /// Runs the experiment with a strategy by name ("calibrated:angles", "lattice+volume"); "" takes the scene's own.
  /// Equal to the command's numbers to the last bit. Throws InputError; numerical trouble is an outcome.
  LaboratoryResult run(const std::string& strategy = "");
  /// The scene's body, its strategy, its loads and damping, held and loaded in full as the experiment does it, to be
  /// stepped.
  Simulation simulation(const std::string& strategy = "", SimulationOptions options = {});

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace elastin
