#pragma once
#include <memory>
#include <optional>

#include "elastin/core/simulation/catalog.h"
#include "lab/identify/data.h"

namespace elastin::lab {

/// What a material makes of a test at its measured points.
struct Prediction {
  VectorX values;  ///< SI, as data.y
  MatrixX slopes;  ///< ∂value/∂θ of each change of the material, points × changes
};

/// A material on its way to a test, with what the test needs of it.
struct TestedMaterial {
  const MaterialLaw* row = nullptr;  ///< of its law; null: E and ν alone
  Material material;
  std::vector<MaterialChange> changes;  ///< one a number; none: no slopes are wanted
};

/// A test that predicts its measured points for any material.
class MeasuredTest {
 public:
  explicit MeasuredTest(MeasuredData data) : data_(std::move(data)) {}
  virtual ~MeasuredTest() = default;
  const MeasuredData& data() const { return data_; }
  /// None where the material has no equilibrium; why() then says it.
  virtual std::optional<Prediction> predict(const TestedMaterial& tested) = 0;
  const std::string& why() const { return why_; }

 protected:
  MeasuredData data_;
  std::string why_;
};

/// Every point of the body in the same state. Throws InputError for a material without a law.
std::unique_ptr<MeasuredTest> make_homogeneous_test(const DataTest& test, const MaterialLaw* row,
                                                    const Material& material);

/// Stress at a strain that grows at an even rate over a ramp and is kept: σ(t) = ∫ G(t − s) dσᵉ, exact where the law's
/// stress grows evenly between 64 points of the ramp.
std::unique_ptr<MeasuredTest> make_relaxation_test(const DataTest& test, const MaterialLaw* row,
                                                   const Material& material);

/// The specimen of a scene in its grips: one equilibrium a point, started from the one that the material before had
/// there. Slopes by one linear solve a number, K dx = ∂f/∂θ at the positions kept, and the measure along dx.
/// @param strategy instead of the scene's own; empty = that
/// Throws InputError where the scene is in time, takes small displacements, or prescribes something else than the data.
std::unique_ptr<MeasuredTest> make_specimen_test(const DataTest& test, const Catalog& catalog,
                                                 const std::vector<std::string>& overrides,
                                                 const std::string& strategy);

/// That of the test's kind.
std::unique_ptr<MeasuredTest> make_measured_test(const DataTest& test, const Catalog& catalog, const MaterialLaw* row,
                                                 const Material& material, const std::vector<std::string>& overrides,
                                                 const std::string& strategy = "");

}  // namespace elastin::lab
