#include "elastin/core/laws/material_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/dense.h"
#include "core/base/named.h"
#include "core/laws/homogeneous.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

constexpr const char* kBulkModulus = "bulk_modulus";
constexpr const char* kVolumetric = "volumetric";
struct NamedForm {
  const char* name;
  Volumetric::Form form;
};
constexpr NamedForm kForms[] = {{"logarithmic", Volumetric::Form::logarithmic},
                                {"mixed", Volumetric::Form::mixed},
                                {"quadratic", Volumetric::Form::quadratic}};

bool is_direction(const ParameterInfo& info) { return info.kind == ValueKind::direction; }

void check_terms(const MaterialLaw& row, const LawConstants& constants) {
  const std::size_t count = constants.terms.size(), most = static_cast<std::size_t>(row.most_terms);
  if (row.columns.empty() && count > 0) throw InputError("terms: " + row.name + " has no terms");
  if (!row.columns.empty() && (count < 1 || count > most))
    throw InputError("terms: " + std::to_string(count) + " given; " + row.name + " takes 1 to " + std::to_string(most));
  for (std::size_t term = 0; term < count; ++term) {
    if (constants.terms[term].size() != row.columns.size())
      throw InputError("terms: term " + std::to_string(term + 1) + " of " + row.name + " needs " +
                       std::to_string(row.columns.size()) + " numbers, not " +
                       std::to_string(constants.terms[term].size()));
    for (std::size_t column = 0; column < row.columns.size(); ++column)
      checked_parameter(row.name, row.columns, row.columns[column].name, constants.terms[term][column]);
  }
}

void complete(const MaterialLaw& row, LawConstants& constants) {
  std::vector<ParameterInfo> numbers, directions;
  for (const ParameterInfo& info : row.parameters) (is_direction(info) ? directions : numbers).push_back(info);
  constants.numbers = complete_values(row.name, numbers, constants.numbers);
  for (const auto& [name, direction] : constants.directions) {
    named(directions, name, "unknown direction '" + name + "' of " + row.name);
    if (!(std::abs(direction.norm() - 1) < 1e-9))
      throw InputError(row.name + "." + name + ": the direction has length " + number(direction.norm()) +
                       "; it must be 1");
  }
  for (const ParameterInfo& info : row.parameters)
    if (info.required &&
        (is_direction(info) ? !constants.directions.contains(info.name) : !constants.numbers.contains(info.name)))
      throw InputError(row.name + " needs '" + info.name + "': " + info.text);
  for (const auto& [name, word] : constants.words) {
    const WordInfo& info = named(row.words, name, "unknown key '" + name + "' of " + row.name);
    if (std::find(info.words.begin(), info.words.end(), word) == info.words.end())
      throw InputError(row.name + "." + name + ": '" + word + "' is not known here" + suggestion(word, info.words));
  }
  for (const WordInfo& info : row.words) constants.words.try_emplace(info.name, info.words.front());
  check_terms(row, constants);
}

/// Sets E and ν to those of the isotropic solid that is nearest to the stiffness at rest, c = 2 ∂S/∂C.
void set_moduli(const MaterialLaw& row, Material& material) {
  const TangentModuli<3> c = 2 * row.shape(material).tangent(Matrix3::Zero());
  // No change of volume: strains without a trace, orthonormal under the double product.
  Eigen::Matrix<double, 6, 5> shapes = Eigen::Matrix<double, 6, 5>::Zero();
  const double root2 = std::sqrt(0.5), root6 = std::sqrt(1. / 6);
  shapes.col(0).head<3>() << root2, -root2, 0;
  shapes.col(1).head<3>() << root6, root6, -2 * root6;
  for (int shear = 0; shear < 3; ++shear) shapes(3 + shear, 2 + shear) = 2 * root2;  // both components of the strain
  const Eigen::Matrix<double, 5, 5> stiffness = shapes.transpose() * c * shapes;
  const double softest = symmetric_eigenvalues(stiffness)[0] / 2, mu = stiffness.trace() / 10;
  if (!(softest > 0) || !std::isfinite(mu))
    throw InputError(row.name + ": these constants make the material unstable at rest: its " +
                     (std::abs(softest - mu) < 1e-6 * std::abs(mu) ? "" : "least ") + "shear modulus would be " +
                     number(softest) + " Pa, and it must be above 0");
  if (is_incompressible(row, material)) {
    material.youngs_modulus = 3 * mu, material.poissons_ratio = 0.5;
    return;
  }
  const double K = row.whole ? c.topLeftCorner<3, 3>().sum() / 9 : material.law->numbers.at(kBulkModulus);
  material.youngs_modulus = 9 * K * mu / (3 * K + mu);
  material.poissons_ratio = (3 * K - 2 * mu) / (2 * (3 * K + mu));
}

}  // namespace

Material with_law(const MaterialLaw& row, LawConstants constants, Material material) {
  if (constants.law.empty()) constants.law = row.name;
  if (constants.law != row.name)
    throw InputError("the constants are those of " + constants.law + ", the law is " + row.name);
  complete(row, constants);
  constants.youngs_modulus = 0;
  material.curve.reset();
  material.law = std::move(constants);
  if (row.from_moduli) {
    if (!(material.youngs_modulus > 0)) throw InputError(row.name + " needs youngs_modulus");
    row.shape(material);
  } else {
    material.youngs_modulus = 0;
    set_moduli(row, material);
  }
  material.law->youngs_modulus = material.youngs_modulus;
  material.law->uniaxial_stress = [row](const Material& own, const Vector3& direction,
                                        double strain) -> std::optional<double> {
    const auto state =
        homogeneous_state(row, own, HomogeneousTest::uniaxial, strain, rotation_between(Vector3::UnitX(), direction));
    return state ? std::optional(state->stress) : std::nullopt;
  };
  return material;
}

bool is_incompressible(const MaterialLaw& law, const Material& material) {
  return !law.from_moduli && !law.whole && !material.law->numbers.contains(kBulkModulus);
}

std::string law_unsuited(std::string_view law, bool solid, const Material& material) {
  if (!material.law || material.law->law != law)
    return "needs its constants: `law: " + std::string(law) + "` in the material";
  if (solid && !material.law->numbers.contains(kBulkModulus))
    return "needs a `bulk_modulus` in the material: without one it is incompressible";
  return "";
}

ConstantsOf::ConstantsOf(const Material& material, std::string_view law) {
  if (!material.law || material.law->law != law)
    throw InputError("the material has no constants of " + std::string(law));
  constants_ = &*material.law;
  scale_ = constants_->youngs_modulus > 0 ? material.youngs_modulus / constants_->youngs_modulus : 1;
}

double ConstantsOf::number(const std::string& name) const {
  const auto found = constants_->numbers.find(name);
  if (found == constants_->numbers.end()) throw InputError(constants_->law + " needs '" + name + "'");
  return found->second;
}

const Vector3& ConstantsOf::direction(const std::string& name) const {
  const auto found = constants_->directions.find(name);
  if (found == constants_->directions.end()) throw InputError(constants_->law + " needs the direction '" + name + "'");
  return found->second;
}

std::string ConstantsOf::word(const std::string& name) const {
  const auto found = constants_->words.find(name);
  return found == constants_->words.end() ? "" : found->second;
}

Volumetric ConstantsOf::volume() const {
  const std::string chosen = word(kVolumetric);
  Volumetric result{kForms[0].form, modulus(kBulkModulus)};
  for (const NamedForm& form : kForms)
    if (form.name == chosen) result.form = form.form;
  return result;
}

void add_bulk_modulus(MaterialLaw& row, Volumetric::Form usual) {
  const double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
  row.parameters.push_back({kBulkModulus, dimension::pressure, 0, inf, none,
                            "bulk modulus κ; without one incompressible, for membranes alone", true});
  WordInfo volumetric{kVolumetric, {}, "U(J): κ/2 (ln J)², κ/4 (J² − 1 − 2 ln J) or κ/2 (J − 1)²"};
  for (const auto& [name, form] : kForms)
    volumetric.words.insert(form == usual ? volumetric.words.begin() : volumetric.words.end(), name);
  row.words.push_back(std::move(volumetric));
}

}  // namespace elastin
