#include "config/scene_text.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/base/named.h"
#include "elastin/core/base/error.h"

namespace elastin::config {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

/// Symbols and other words for keys, without capitals, blanks, hyphens and underscores.
constexpr Pair kOtherKeys[]{
    {"e", "youngs_modulus"},
    {"young", "youngs_modulus"},
    {"youngs", "youngs_modulus"},
    {"emodulus", "youngs_modulus"},
    {"modulus", "youngs_modulus"},
    {"elasticmodulus", "youngs_modulus"},
    {"nu", "poissons_ratio"},
    {"ν", "poissons_ratio"},
    {"poisson", "poissons_ratio"},
    {"poissonratio", "poissons_ratio"},
    {"rho", "density"},
    {"ρ", "density"},
    {"massdensity", "density"},
    {"t", "thickness"},
    {"h", "thickness"},
    {"u", "displacement"},
    {"elongation", "displacement"},
    {"extension", "displacement"},
    {"f", "force"},
    {"load", "force"},
    {"p", "pressure"},
    {"epsilon", "strain"},
    {"ε", "strain"},
    {"stretch", "strain"},
    {"phi", "angle"},
    {"rotation", "rotate"},
    {"name", "title"},
    {"test", "experiment"},
    {"protocol", "experiment"},
    {"strategy", "stiffness"},
    {"model", "stiffness"},
    {"method", "strategy"},
    {"type", "kind"},
    {"geometry", "body"},
    {"specimen", "body"},
    {"box", "tetrahedra"},
    {"block", "tetrahedra"},
    {"cube", "tetrahedra"},
    {"cuboid", "tetrahedra"},
    {"surface", "fill"},
    {"particles", "molecules"},
    {"nodes", "molecules"},
    {"points", "molecules"},
    {"springs", "connections"},
    {"edges", "connections"},
    {"path", "file"},
    {"filename", "file"},
    {"unit", "length_unit"},
    {"units", "length_unit"},
    {"unitlength", "length_unit"},
    {"dt", "step"},
    {"timestep", "step"},
    {"tend", "duration"},
    {"endtime", "duration"},
    {"steps", "load_steps"},
    {"increments", "load_steps"},
    {"area", "cross_section"},
    {"gripfixed", "fixed_grip"},
    {"griploaded", "loaded_grip"},
    {"expected", "expect"},
    {"based", "extends"},
    {"include", "extends"},
    {"parameters", "values"},
    {"variables", "values"},
    {"constants", "values"},
    {"mu", "friction"},
    {"way", "method"},
    {"hold", "fixture"},
    {"hold", "fix"},
};

constexpr Pair kOtherWords[]{
    {"fixed", "clamped"},    {"glued", "clamped"},     {"encastre", "clamped"},
    {"free", "sliding"},     {"roller", "sliding"},    {"frictionless", "sliding"},
    {"uniaxial", "tension"}, {"stretch", "tension"},   {"pull", "tension"},
    {"tensile", "tension"},  {"press", "compression"}, {"simpleshear", "shear"},
    {"twist", "torsion"},    {"modal", "vibration"},   {"frequencies", "vibration"},
    {"yes", "true"},         {"on", "true"},           {"no", "false"},
    {"off", "false"},        {"linear", "small"},      {"nonlinear", "large"},
    {"bcc", "body_centred"}, {"fcc", "face_centred"},  {"sc", "cubic"},
    {"millimeter", "mm"},    {"millimetre", "mm"},     {"micron", "um"},
    {"meter", "m"},          {"metre", "m"},           {"1", "true"},
    {"0", "false"},          {"tet", "body_centred"},
};

/// Keys that have another name now, by the path of the map that they stand in; files and --set may use the former one.
struct FormerKey {
  std::string_view map, former, name;
};
constexpr FormerKey kFormerKeys[]{{"time", "integrator", "stepper"},
                                  {"time.stepper", "scheme", "method"},
                                  {"steppers", "schemes", "methods"},
                                  {"steppers.methods", "scheme", "method"}};

constexpr std::string_view kStays =
    "what stays is listed at the top level: supports: [{molecules: {side: -z}, fix: all}]; `fixed` under `experiment` "
    "is only what is held in place of that experiment's own end";

constexpr Pair kInstead[]{
    {"units", "each number has its unit behind it, for example 15 mm"},
    {"unit", "each number has its unit behind it, for example 15 mm"},
    {"g", "a shear modulus is given by E and ν: youngs_modulus: = 2 * G * (1 + nu), with G and nu under `values`"},
    {"shearmodulus", "give E and ν: youngs_modulus: = 2 * G * (1 + nu), with G and nu under `values`"},
    {"k", "a bulk modulus is given by E and ν: youngs_modulus: = 3 * K * (1 - 2 * nu), with K and nu under `values`"},
    {"bulkmodulus", "give E and ν: youngs_modulus: = 3 * K * (1 - 2 * nu), with K and nu under `values`"},
    {"grips", "write fixed_grip: clamped, loaded_grip: clamped; sliding grips are the default"},
    {"grip", "write fixed_grip: clamped, loaded_grip: clamped; sliding grips are the default"},
    {"gravity", "weight is a load at the top level: loads: [{gravity: [0, 0, -9.81 m/s2]}]"},
    {"incompressible", "write poissons_ratio: 0.499 and stiffness: neo_hookean+volume"},
    {"fixed", kStays},
    {"fix", kStays},
    {"held", kStays},
    {"anchors", kStays},
    {"constraints", kStays},
    {"boundaryconditions", kStays},
    {"bc", kStays},
};

/// Small letters and digits alone: "Young's modulus", "youngs-modulus" and "youngs_modulus" are one name.
std::string bare(std::string_view name) {
  std::string letters;
  for (const char letter : name)
    if (letter >= 'A' && letter <= 'Z')
      letters += static_cast<char>(letter - 'A' + 'a');
    else if (std::string_view(" -_'.").find(letter) == std::string_view::npos)
      letters += letter;
  return letters;
}

template <std::size_t count>
std::string meant(const Pair (&others)[count], const std::string& given, const std::vector<std::string>& known) {
  const std::string name = bare(given);
  for (const std::string& key : known)
    if (bare(key) == name) return key;
  for (const auto& [other, key] : others)
    if (other == name && std::find(known.begin(), known.end(), key) != known.end()) return std::string(key);
  return "";
}

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("+-.0123456789eE") == std::string_view::npos &&
         text.find_first_of("0123456789") != std::string_view::npos;
}

}  // namespace

std::string present_name(std::string_view map, const std::string& key) {
  for (const FormerKey& one : kFormerKeys)
    if (map == one.map && key == one.former) return std::string(one.name);
  return key;
}

std::string meant_key(const std::string& given, const std::vector<std::string>& known) {
  const std::string other = meant(kOtherKeys, given, known);
  if (!other.empty() || !nearest_name(given, known).empty()) return other;
  for (const FormerKey& one : kFormerKeys)
    if (std::find(known.begin(), known.end(), one.name) != known.end() &&
        !nearest_name(given, {std::string(one.former)}).empty())
      return std::string(one.name);
  return "";
}

std::string suggested_word(const std::string& word, const std::vector<std::string>& names) {
  const std::string bare_word = word.substr(0, word.find_first_of(" ;,#/"));
  if (bare_word.size() < word.size() && std::find(names.begin(), names.end(), bare_word) != names.end())
    return "; write " + bare_word + " alone; a comment begins with a blank and #";
  const std::string other = meant(kOtherWords, word, names);
  if (other.empty() || !nearest_name(word, names).empty()) return suggestion(word, names);
  return "; did you mean '" + other + "'? (" + suggestion("", names).substr(2) + ")";
}

std::string instead_of_key(const std::string& given) {
  for (const auto& [key, instead] : kInstead)
    if (key == bare(given)) return std::string(instead);
  return "";
}

std::string as_list(const std::string& text) {
  std::vector<std::string> values(1);
  for (std::size_t at = 0; at < text.size(); ++at) {
    const bool times = text.substr(at, 2) == "×";
    const bool sign = times || std::string_view(" ,;xX*").find(text[at]) != std::string_view::npos;
    if (!sign)
      values.back() += text[at];
    else if (!values.back().empty())
      values.emplace_back();
    at += times ? 1 : 0;
  }
  if (values.back().empty()) values.pop_back();
  // Words behind a number are its unit, and the last one's where the others have none.
  std::vector<std::string> list;
  for (const std::string& value : values)
    if (is_number(value))
      list.push_back(value);
    else if (list.empty())
      return "";
    else if (const std::size_t letters = value.find_first_not_of("+-.0123456789");
             letters > 0 && letters != std::string::npos)
      list.push_back(value.substr(0, letters) + " " + value.substr(letters));
    else
      list.back() += " " + value;
  if (list.size() < 2) return "";
  const std::size_t unit = list.back().find(' ');
  for (std::string& value : list)
    if (unit != std::string::npos && value.find(' ') == std::string::npos) value += list.back().substr(unit);
  return "[" + joined(list) + "]";
}

std::string with_decimal_points(const std::vector<std::string>& given, std::size_t count) {
  if (given.size() != count + 1) return "";
  for (std::size_t i = 0; i + 1 < given.size(); ++i) {
    const bool whole = !given[i].empty() && given[i].find_first_not_of("-0123456789") == std::string::npos;
    const bool fraction = !given[i + 1].empty() && given[i + 1][0] >= '0' && given[i + 1][0] <= '9' &&
                          (!is_number(given[i + 1]) || i + 2 == given.size());
    if (!whole || !fraction) continue;
    std::vector<std::string> mended(given.begin(), given.begin() + static_cast<std::ptrdiff_t>(i));
    mended.push_back(given[i] + "." + given[i + 1]);
    mended.insert(mended.end(), given.begin() + static_cast<std::ptrdiff_t>(i) + 2, given.end());
    return "; is one comma a decimal one? Write [" + joined(mended) + "]";
  }
  return "";
}

}  // namespace elastin::config
