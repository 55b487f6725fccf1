#pragma once
#include <string>
#include <string_view>

namespace elastin {

/// What a number measures, as powers of metre, kilogram and second. A plane angle or a ratio has no power at all.
struct Dimension {
  int length = 0, mass = 0, time = 0;
  bool operator==(const Dimension&) const = default;
};

namespace dimension {
inline constexpr Dimension none{}, length{1, 0, 0}, area{2, 0, 0}, volume{3, 0, 0}, mass{0, 1, 0}, time{0, 0, 1},
    force{1, 1, -2}, pressure{-1, 1, -2}, density{-3, 1, 0}, velocity{1, 0, -1}, acceleration{1, 0, -2},
    stiffness{0, 1, -2}, damping{0, 1, -1}, viscosity{-1, 1, -1}, energy{2, 1, -2};
}  // namespace dimension

/// A number with what stood behind it.
struct Quantity {
  double value = 0;       ///< in SI units
  bool has_unit = false;  ///< false: a plain number, taken as SI
};

/// Reads "15 mm", "9 cm^2", "9 cm2", "1000 kg/m3", "2 N s/m", "30 deg", "0.2 %" or a plain number, and checks that its
/// unit has the wanted dimension. Prefixes n µ u m c d h k M G. Throws InputError: what was given, which units are
/// allowed.
Quantity parse_quantity(std::string_view text, const Dimension& wanted);

/// "m", "N", "Pa", "kg/m^3" …: the SI unit of a dimension; "" for none.
std::string si_unit(const Dimension& dimension);

/// Examples of what parse_quantity takes for a dimension: "15 mm, 2 cm, 0.1 m".
std::string unit_examples(const Dimension& dimension);

}  // namespace elastin
