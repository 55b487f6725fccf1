#pragma once
#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <optional>

#include "elastin/core/simulation/catalog.h"
#include "lab/identify/data.h"
#include "lab/run/material_numbers.h"

namespace elastin::lab {

/// What a material makes of a test at its measured points.
struct Prediction {
  VectorX values;  ///< SI, as data.y
  MatrixX slopes;  ///< ∂value/∂θ of each change of the material, points × changes
};

/// How readings change with the positions of molecules and the reactions of supports, to first order.
struct ReadingSlopes {
  Eigen::SparseMatrix<double> of_positions;  ///< readings × 3n; empty: they do not
  MatrixX of_reactions;                      ///< readings × 3 supports; empty: they do not
  /// What small turns and shifts of the frame change, readings × those: it goes where the weighted readings are nearest
  /// to the measured ones, so that none of this is left of any change. Empty: it stays.
  MatrixX of_frame;
};

/// One equilibrium of a specimen.
struct SpecimenStep {
  const std::vector<Eigen::Index>& rows;  ///< of the data, that were read there
  Model& model;
  const State& state;
  VectorX readings;
  std::function<ReadingSlopes()> slopes;  ///< throws InputError where readings are not of that form
};

/// A trial of a test, with what the test needs of it.
struct TestedMaterial {
  const MaterialLaw* row = nullptr;  ///< of its law; null: none
  Trial trial;
  std::vector<TrialChange> changes;  ///< one a number; none: no slopes are wanted
  /// These numbers by name, SI, in the order of `changes`; none: nobody says.
  std::vector<std::pair<std::string, double>> numbers = {};
  double accuracy = 0;  ///< unbalanced force that does, over loads and reactions; 0: as its scene says
};

/// A test that predicts its measured points for any material.
class MeasuredTest {
 public:
  explicit MeasuredTest(MeasuredData data) : data_(std::move(data)) {}
  virtual ~MeasuredTest() = default;
  const MeasuredData& data() const { return data_; }
  /// None where the material has no equilibrium; why() then says it.
  virtual std::optional<Prediction> predict(const TestedMaterial& tested) = 0;
  /// What the material answers between and beyond the measured points; none where that is no closed form.
  virtual std::optional<VectorX> line(const TestedMaterial& /*tested*/, const VectorX& /*along*/) const {
    return std::nullopt;
  }
  /// Numbers of its scene in addition to the material, and that can be unknown.
  virtual std::vector<MaterialNumber> own_numbers() const { return {}; }
  /// Numbers of its own that are always found.
  virtual std::vector<MaterialNumber> always_unknown() const { return {}; }
  /// Keys of its scene, except the material, with the trial put in: keys with their values.
  virtual std::vector<std::pair<std::string, std::string>> scene_keys(const Trial& /*trial*/, bool /*plain*/) const {
    return {};
  }
  /// The body at rest of a specimen; null: the test is of none.
  virtual const Body* body() const { return nullptr; }
  /// Changes the specimen's body and visits its equilibria, one at each load. What is returned keeps the models that
  /// were visited; null where there is no equilibrium.
  virtual std::shared_ptr<const void> visit_equilibria(const std::function<void(Body&)>& /*change*/,
                                                       const std::function<void(const SpecimenStep&)>& /*visit*/) {
    return nullptr;
  }
  const std::string& why() const { return why_; }

 protected:
  MeasuredData data_;
  std::string why_;
};

/// What a function of the trial gives, with its slopes by differences of whole values.
std::optional<Prediction> by_differences(const TestedMaterial& tested,
                                         const std::function<std::optional<VectorX>(const Trial&)>& values_of);

/// Every point of the body in the same state, of a law; or of a curve in uniaxial stress. Throws InputError for a
/// material that has neither.
std::unique_ptr<MeasuredTest> make_homogeneous_test(const DataTest& test, const MaterialLaw* row,
                                                    const Material& material);

/// Depth and force of an indenter in a layer of the material's E and ν, with the contact point as an unknown.
std::unique_ptr<MeasuredTest> make_layer_test(const DataTest& test, const Material& material);

/// Stress at a strain that grows at an even rate over a ramp and is kept: σ(t) = ∫ G(t − s) dσᵉ, exact where the law's
/// stress grows evenly between 64 points of the ramp.
std::unique_ptr<MeasuredTest> make_relaxation_test(const DataTest& test, const MaterialLaw* row,
                                                   const Material& material);

/// Storage modulus, loss modulus or loss tangent of a small oscillation about rest, over its frequency.
std::unique_ptr<MeasuredTest> make_oscillation_test(const DataTest& test, const MaterialLaw* row,
                                                    const Material& material);

/// The specimen of a scene in its grips: one equilibrium a point, started from the one that the material before had
/// there. Slopes by one linear solve a number, K dx = ∂f/∂θ at the positions kept, and the measure along dx. Where the
/// load path counts (friction, multipliers of contact) or the load is sought (an indenter's force), each curve begins
/// at rest, and slopes are differences of whole ones.
/// @param strategy instead of the scene's own; empty = that
/// Throws InputError where the scene is in time, takes small displacements, or prescribes something else than the data.
std::unique_ptr<MeasuredTest> make_specimen_test(const DataTest& test, const Catalog& catalog,
                                                 const std::vector<std::string>& overrides,
                                                 const std::string& strategy);

/// The same over other points than those of the test's file; of data without `along` x is the part of the scene's load.
std::unique_ptr<MeasuredTest> make_specimen_test(const DataTest& test, MeasuredData data, const Catalog& catalog,
                                                 const std::vector<std::string>& overrides,
                                                 const std::string& strategy);

/// The force of the specimen of a scene whose whole load comes at an even rate over a ramp and is kept: as above of the
/// forces of its equilibria on the ramp. Exact for a step, and for small displacements; after a ramp it leaves out that
/// the body's shape still changes a little while it relaxes.
std::unique_ptr<MeasuredTest> make_specimen_relaxation_test(const DataTest& test, const Catalog& catalog,
                                                            const Material& material,
                                                            const std::vector<std::string>& overrides,
                                                            const std::string& strategy);

/// Refuse a material without a law, and one that has more than it, for a closed form.
void need_law(const DataTest& test, const MaterialLaw* row);
void need_law_alone(const DataTest& test, const Material& material);

/// That of the test's kind.
std::unique_ptr<MeasuredTest> make_measured_test(const DataTest& test, const Catalog& catalog, const MaterialLaw* row,
                                                 const Material& material, const std::vector<std::string>& overrides,
                                                 const std::string& strategy = "");

}  // namespace elastin::lab
