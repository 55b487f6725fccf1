#pragma once
#include <string>

#include "lab/live/parcel.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// Bodies of more connections are no page: a browser could not move them.
inline constexpr int kMostLiveConnections = 60'000;

/// The scene's body with all that the lab in a browser needs of it: its strategies that suit, loads, supports, the
/// state in which its experiment begins, and the tension test, that of the scene or one along the body's longest side.
/// Throws InputError of a body that is too large or one molecule, or that cannot be brought to where its experiment
/// begins.
Parcel make_parcel(const Scene& scene, const Catalog& catalog);

/// The core as WebAssembly, as tools/setup --web has built it.
struct WebModule {
  std::string script;  ///< that loads it
  std::string wasm;    ///< bytes
};
/// Reads elastin.js and elastin.wasm of a folder. Throws InputError that says how they are made.
WebModule load_web_module(const std::string& folder);

/// The lab in a browser, of the scene's parcel: one HTML file that loads nothing else.
std::string live_page(const Scene& scene, const Catalog& catalog, const Parcel& parcel, const WebModule& module);

}  // namespace elastin::lab
