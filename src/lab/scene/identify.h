#pragma once
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/laws/homogeneous.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/run/config_names.h"
#include "lab/run/material_numbers.h"

namespace elastin::lab {

/// What a column of measured data may hold. The head of the column is its name with the unit: "force [N]".
struct DataQuantity {
  std::string name;
  Dimension unit;
  std::string text;
  bool ratio = false;                      ///< a plain number, so that a unit may be left out
  std::vector<std::string> measures = {};  ///< what a scene shows as it, the first one that it has
};
const std::vector<DataQuantity>& data_quantities();

/// A kind of test whose data a material can be fitted to.
struct DataTestKind {
  std::string name, text;
  std::vector<std::string> along, up;  ///< quantities that it takes: of what is prescribed, and of the response
  std::optional<HomogeneousTest> homogeneous = {};  ///< every point in the same state
  bool in_time = false;                             ///< at a strain that is kept, or that oscillates
  bool pressed = false;                             ///< whether strains and stresses are negative
  bool oscillates = false;                          ///< a small strain about rest, over the frequency
  bool points = false;                              ///< of displacements of points of the body
  bool layer = false;                               ///< an indenter in a layer, by a closed form
  /// Whether it is of a body in a scene.
  bool of_scene() const { return !homogeneous && !in_time && !layer; }
};
const std::vector<DataTestKind>& data_test_kinds();

/// How far a column counts, in the scene file's words: its dimension is known when the data are read.
using LaterQuantity = std::function<double(const Dimension&)>;

/// What differences from measured values are over: each value, but a hundred times the noise at least, so that readings
/// near zero do not rule; each value; or the largest one of the test.
enum class ResidualScale { automatic, relative, absolute };
/// Which rows of a curve that goes to and fro: `only` refuses such a curve.
enum class BranchChoice { only, loading, unloading };
/// Where what is prescribed is zero: as the file has it, where the load begins, by the steepest tangent, or in the
/// first row.
enum class ZeroChoice { as_given, found, toe, first };

/// What is pressed into a layer, and what this lies on.
enum class Indenter { sphere, cone, flat };
enum class LayerBottom { bonded, free };

/// An end of a window, a strain or a stress [Pa].
struct WindowBound {
  double value = 0;
  bool is_stress = false;
};
/// A modulus that is read off the measured curve.
struct ModulusWindow {
  enum class Kind { chord, tangent, secant } kind = Kind::chord;
  WindowBound from, to, at;
};

/// One measured test as a scene states it.
struct DataTest {
  std::string name;
  const DataTestKind* kind = nullptr;
  std::string file;                                          ///< path of the CSV file
  std::vector<std::pair<std::string, std::string>> rows;     ///< only those rows with this text in this column
  std::vector<std::pair<std::string, std::string>> columns;  ///< what heads of the file mean: "force [N]"
  LaterQuantity from, to;                                    ///< range of what is prescribed; empty = all of it
  double weight = 1;                                         ///< of its squares; 0 = predicted and not fitted
  LaterQuantity deviation;  ///< standard deviation of each reading, of a body in a scene; empty: not stated
  ResidualScale residuals = ResidualScale::automatic;
  char decimal = 0;              ///< mark of decimals; 0: as recognised
  int block = 0;                 ///< of the file, from 1; 0: the only one with the columns
  std::optional<bool> pressing;  ///< whether the columns count compression positive
  BranchChoice branch = BranchChoice::only;
  int cycle = 0;  ///< from 1, or −1 from the last; 0: the first
  bool keep_torn = false;
  std::string measure;       ///< of a specimen: that of its scene which the response is; empty: the first that is one
  bool fixed_frame = false;  ///< of points: whether the observer does not move relative to the specimen
  std::optional<ZeroChoice> zero;  ///< none: as given, or found where slack is certain
  int points = 0;                  ///< to which more rows are averaged; 0: as many as show the shape of any curve
  std::vector<ModulusWindow> moduli;
  double cross_section = 0, length = 0;              ///< [m²], [m] that make stress of force, strain of displacement
  std::optional<SceneSource> scene;                  ///< of a specimen
  HomogeneousTest held = HomogeneousTest::uniaxial;  ///< of a relaxation test
  Indenter indenter = Indenter::sphere;
  double indenter_size = 0;                                    ///< radius [m], or a cone's half angle [rad]
  double thickness = std::numeric_limits<double>::infinity();  ///< of the layer [m]
  LayerBottom bottom = LayerBottom::bonded;
  double adhesion = 0;           ///< work of adhesion where its search begins [J/m²]; 0: none, and none is sought
  bool contact_given = false;    ///< whether the indenter touches at depth 0
  double strain = 0, ramp = 0;   ///< that is kept, and the time [s] that it takes to be reached
  std::optional<double> begins;  ///< time of the file's clock [s] at which it begins to grow; none: 0, or found
  /// Of an indenter over time: the depth [m] that is reached after the ramp, how long it stays [s], and the time [s] in
  /// which it is drawn back; 0: as long as the ramp.
  double depth = 0, hold = std::numeric_limits<double>::infinity(), back = 0;
  std::function<void(const std::string&)> fail;  ///< throws InputError at the test's place
};

/// A number that is to be found. What is not stated follows from the material and the law.
struct UnknownChoice {
  std::string name;
  LaterQuantity low, high, start;
  std::function<void(const std::string&)> fail;
};

/// A number of the material that others found.
struct PublishedNumber {
  std::string name;
  LaterQuantity value;
  std::function<void(const std::string&)> fail;
};

/// A factor of the material's stiffness in each cell that is to be found, in the place of numbers.
struct FieldChoice {
  double smoothness = 0;  ///< weight of ∫ |∇ ln E|² dV / V^(1/3) in addition to the squares; 0: chosen
  double low = 1e-3, high = 1e3;
  std::function<void(const std::string&)> fail;  ///< throws InputError at its place
};

/// The `identify:` section of a scene with the material from which it starts.
struct IdentifyTask {
  SceneSource source;
  std::string name, title;
  Material material;
  std::optional<CurveNumbers> curve;  ///< by which its curve is stated
  std::string kept;                   ///< lines of its block that a search does not write again: fibres, muscle …
  bool plain = false;                 ///< whether the material is in plain SI numbers, and not in units
  std::vector<DataTest> tests;
  std::vector<UnknownChoice> unknowns;  ///< empty = all numbers of the law but those in `fixed`
  std::vector<std::string> fixed;
  std::optional<FieldChoice> field;
  std::vector<PublishedNumber> published;  ///< of the material's own law, shown next to those found
  std::string published_source;
  int starts = 0;                 ///< 0 = 8 of homogeneous tests, 1 of specimens
  std::vector<std::string> laws;  ///< that are compared; empty = the material's own
};

/// Throws InputError where the scene has no `identify:` section. The body and experiment of the scene are not built.
IdentifyTask load_identify_task(const SceneSource& source, const Catalog& catalog,
                                const std::vector<std::string>& overrides = {});

std::vector<KeySection> identify_keys();

}  // namespace elastin::lab
