#pragma once
#include <string>
#include <vector>

#include "config/keys.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// A box along the axes.
struct BoxCorners {
  Vector3 from = Vector3::Zero(), to = Vector3::Zero();
};
Key<BoxCorners> low_corner_key();
/// Behind that of the low corner.
Key<BoxCorners> high_corner_key();

/// The molecules that a scene picks: their numbers as a list, or a map of places, of which all must hold. `rotation`
/// is that of the scene, which the body has had. Throws InputError where none is picked.
std::vector<int> read_molecules(const Reader& reader, const Body& body, const Matrix3& rotation);

std::vector<KeySection> pick_keys();

/// A key of molecules of the frame's body.
template <class Setup, class Member>
Key<Setup> molecules_key(std::string name, Member Setup::*member, std::string text) {
  return {{std::move(name), "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule", "none",
           std::move(text)},
          [member](const Reader& value, Setup& setup, const Frame& frame) {
            setup.*member = read_molecules(value, *frame.body, frame.rotation);
          }};
}

}  // namespace elastin::lab
