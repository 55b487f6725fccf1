#include <algorithm>
#include <cmath>

#include "elastin/core/base/error.h"
#include "lab/experiment/symmetry.h"
#include "lab/scene/parts.h"
#include "lab/scene/pick.h"

namespace elastin::lab {
namespace {

/// Takes a direction from those in which a molecule is free.
void fix_along(const Vector3& direction, Matrix3& free) {
  const Vector3 left = free * direction;
  if (left.norm() > 1e-9) free -= left * left.transpose() / left.squaredNorm();
}

/// "all", or a list of directions.
std::vector<Vector3> read_fixed(const std::optional<Reader>& reader, const Matrix3& rotation) {
  if (!reader || (reader->is_text() && reader->text() == "all"))
    return {rotation.col(0), rotation.col(1), rotation.col(2)};
  std::vector<Vector3> directions;
  for (const Reader& item : reader->items()) directions.push_back(rotation * item.direction());
  if (directions.empty()) reader->fail("names no direction; write all, or a list such as [x, y]");
  return directions;
}

}  // namespace

std::vector<Support> read_supports(const Reader& reader, const Body& body, const Matrix3& rotation) {
  FixedMolecules fixed;
  for (Reader item : reader.items()) {
    const auto symmetry = item.find("symmetry");
    const auto molecules = symmetry ? item.find("molecules") : std::optional(item.at("molecules"));
    const auto directions = item.find("fix");
    item.finish();
    if (symmetry && (molecules || directions))
      symmetry->fail("says itself which molecules are fixed and along what; leave out `molecules` and `fix`");
    if (symmetry) {
      symmetry->located([&] {
        fix_in_planes(body, {rotation * symmetry->direction()}, fixed);
        return 0;
      });
      continue;
    }
    const std::vector<Vector3> along = read_fixed(directions, rotation);
    for (const int molecule : read_molecules(*molecules, body, rotation))
      for (const Vector3& direction : along)
        fix_along(direction, fixed.try_emplace(molecule, Matrix3::Identity()).first->second);
  }
  std::vector<Support> supports;
  for (const auto& [molecule, free] : fixed) supports.push_back({molecule, free});
  return supports;
}

std::vector<KeySection> support_keys() {
  return {
      {"supports",
       "Supports",
       "What stays where it is, besides the experiment's own grips. Each item of `supports` is a plane of symmetry, "
       "or some molecules with the directions in which they cannot move:",
       {{"molecules", "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule",
         "needed without `symmetry`", "which molecules are fixed: `{rim: true}` is a clamped rim"},
        {"fix", "list of directions, or `all`", "", "", "`all`", "the directions in which they are fixed"},
        {"symmetry", "direction", "", "", "none",
         "normal of a plane of symmetry through the origin; the body lies on one side of it, and what lies in it "
         "stays in it"}}}};
}

}  // namespace elastin::lab
