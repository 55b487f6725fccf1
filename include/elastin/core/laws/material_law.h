#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/base/table.h"
#include "elastin/core/laws/any_law.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// A choice among words that a law's constants may make.
struct WordInfo {
  std::string name;
  std::vector<std::string> words;  ///< the first one is the default
  std::string text;                ///< what it chooses, in a sentence
};

/// A row of a catalog's material laws: what constants a law has, and the law at work. Scenes, C, Python and documents
/// come from it. `parameters` are its numbers and directions; a number without default that is not required may be
/// missing.
struct MaterialLaw : Descriptor {
  std::vector<WordInfo> words = {};
  std::vector<ParameterInfo> columns = {};  ///< of each of its terms; none: it has no terms
  int most_terms = 0;
  bool from_moduli = false;  ///< whether it follows from E and ν, so that these are given and not derived
  bool whole = false;  ///< whether its shape says of volume, too, what there is to say: there is no `bulk_modulus`
  /// The law's change of shape at work, all that does not depend on `bulk_modulus`. Throws InputError on constants that
  /// are missing or inadmissible.
  std::function<AnyPoint<3>(const Material&)> shape = {};
  /// With its volume term. Throws InputError as above, and without bulk_modulus.
  std::function<SplitPoint<AnyPoint<3>>(const Material&)> solid = {};
};

/// The material with constants of a law, and the E and ν that the law has at rest: of an anisotropic one those of the
/// nearest isotropic solid [Norris 2006]; without `bulk_modulus` it is incompressible. What may be left out gets its
/// default. Throws InputError with the nearest name on what the law does not have, on what is missing or out of range,
/// and on constants with which the law is unstable at rest.
Material with_law(const MaterialLaw& row, LawConstants constants, Material material = {});

/// Whether the law keeps the volume exactly with this material, whose bulk_modulus is missing.
bool is_incompressible(const MaterialLaw& law, const Material& material);

/// Why a strategy of the law called `law` cannot take this material, or "".
/// @param solid whether its cells are solids, which need a bulk_modulus; membranes are taken as incompressible.
std::string law_unsuited(std::string_view law, bool solid, const Material& material);

/// A law's constants as it reads them out of a material. All throw InputError on what is not there.
class ConstantsOf {
 public:
  /// @param material with constants of `law`; it must outlive this.
  ConstantsOf(const Material& material, std::string_view law);

  bool has(const std::string& number) const { return constants_->numbers.contains(number); }
  double number(const std::string& name) const;
  /// In Pa, times the material's E over that of the constants.
  double modulus(const std::string& name) const { return scale_ * number(name); }
  double scale() const { return scale_; }
  const Vector3& direction(const std::string& name) const;
  /// "" where nothing is chosen.
  std::string word(const std::string& name) const;
  const std::vector<std::vector<double>>& terms() const { return constants_->terms; }
  /// U(J) of `bulk_modulus` and `volumetric`.
  Volumetric volume() const;

 private:
  const LawConstants* constants_;
  double scale_;
};

/// What all nearly incompressible laws have, after their own numbers.
void add_bulk_modulus(MaterialLaw& row, Volumetric::Form usual = Volumetric::Form::logarithmic);

/// A law given by constants of its own: it has `constants()`, its row without name and functions, and shape(material).
template <class Law>
concept ConstantsLaw = StiffnessLaw<Law> && requires(const Law& law, const Material& material) {
  { Law::constants() } -> std::same_as<MaterialLaw>;
  { law.shape(material) } -> PointLaw<3>;
  requires SplitLaw<Law>;
};

/// A nearly incompressible law: its shape and U(J).
template <class Law>
struct NearlyIncompressible {
  auto split(const Material& material) const {
    const auto& law = static_cast<const Law&>(*this);
    using Point = SplitPoint<decltype(law.shape(material))>;
    return Point{law.shape(material), ConstantsOf(material, Law::name).volume()};
  }
  auto solid(const Material& material) const { return split(material); }
};

template <ConstantsLaw Law>
MaterialLaw material_law() {
  MaterialLaw row = Law::constants();
  row.name = Law::name, row.summary = Law::summary, row.source = Law::source;
  row.shape = [](const Material& material) { return AnyPoint<3>(Law{}.shape(material)); };
  row.solid = [](const Material& material) {
    auto own = Law{}.split(material);
    return SplitPoint<AnyPoint<3>>{AnyPoint<3>(std::move(own.shape)), own.volume};
  };
  return row;
}

}  // namespace elastin
