#include "lab/experiment/keys.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Takes a direction from those in which a molecule is free.
void fix_along(const Vector3& direction, Matrix3& free) {
  const Vector3 left = free * direction;
  if (left.norm() > 1e-9) free = without_rounding(free - left * left.transpose() / left.squaredNorm());
}

struct SupportSetup {
  std::optional<std::vector<int>> molecules;
  std::vector<Vector3> directions;
  std::optional<Vector3> symmetry;
  std::optional<Reader> fix, symmetry_place;
};

Keys<SupportSetup> keys_of_support() {
  using S = SupportSetup;
  return {
      molecules_key("molecules", &S::molecules, "which molecules are fixed: `{rim: true}` is a clamped rim")
          .otherwise("needed without `symmetry`")
          .refused_for(
              [](const S& setup) { return setup.molecules || setup.symmetry ? "" : "key 'molecules' is missing"; }),
      Key<S>({"fix", "list of directions, or `all`", "", "", "`all`", "the directions in which they are fixed"},
             [](const Reader& value, S& setup, const Frame& frame) {
               if (value.is_text() && value.text() == "all") return;
               for (const Reader& item : value.items()) setup.directions.push_back(frame.rotation * item.direction());
               if (setup.directions.empty()) value.fail("names no direction; write all, or a list such as [x, y]");
             })
          .place(&S::fix),
      key::direction("symmetry", &S::symmetry,
                     "normal of a plane of symmetry through the origin; the body lies on one side of it, and what lies "
                     "in it stays in it")
          .place(&S::symmetry_place)
          .refused_for([](const S& setup) {
            return setup.symmetry && (setup.molecules || setup.fix)
                       ? "says itself which molecules are fixed and along what; leave out `molecules` and `fix`"
                       : "";
          })};
}

}  // namespace

std::vector<Support> read_supports(const Reader& reader, const Body& body, const Matrix3& rotation) {
  FixedMolecules fixed;
  for (const Reader& item : reader.items()) {
    const SupportSetup setup = keys_of_support().read(item, {rotation, &body});
    if (setup.symmetry) {
      setup.symmetry_place->located([&] { fix_in_planes(body, {*setup.symmetry}, fixed); });
      continue;
    }
    const std::vector<Vector3> all{rotation.col(0), rotation.col(1), rotation.col(2)};
    for (const int molecule : *setup.molecules)
      for (const Vector3& direction : setup.directions.empty() ? all : setup.directions)
        fix_along(direction, fixed.try_emplace(molecule, Matrix3::Identity()).first->second);
  }
  std::vector<Support> supports;
  for (const auto& [molecule, free] : fixed) supports.push_back({molecule, free});
  return supports;
}

std::vector<KeySection> support_keys() {
  return {{"supports", "Supports",
           "What stays where it is, in addition to the experiment's own grips. Each item of `supports` is a plane of "
           "symmetry, or some molecules with the directions in which they cannot move:",
           keys_of_support().rows()}};
}

}  // namespace elastin::lab
