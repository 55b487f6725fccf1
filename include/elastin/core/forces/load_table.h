#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "elastin/core/base/table.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// What a load is given, by parameter name, in SI units.
struct LoadValues {
  ParameterValues numbers = {};
  std::map<std::string, Vector3> vectors = {};  ///< directions too
  std::map<std::string, std::vector<int>> molecules = {};

  bool has(const std::string& name) const;
};

/// A row of the table of loads: what acts on a body from outside, or damps it from inside, by the one name that scenes,
/// C and Python give.
struct LoadKind : Descriptor {
  /// Puts it on a model, from values that are complete and in range. `material` is the body's, null where it is
  /// not known. Throws InputError where the body does not suit.
  std::function<void(Model& model, const LoadValues& values, const Material* material)> add = {};
  /// Throws InputError where the body or the values together do not suit: what can be checked before a run.
  std::function<void(const Body& body, const LoadValues& values)> check = [](const Body&, const LoadValues&) {};
  /// False of drag and damping, which a body that does not move cannot feel.
  std::function<bool(const LoadValues& values)> acts_at_rest = [](const LoadValues&) { return true; };
  /// Whether it acts on a process's share of a body (Body::share): on owned molecules as on those of the whole.
  bool of_shares = false;
  /// Whether each of its molecules has its own force: one that a cut splits goes on with it on one of the two. Of the
  /// others, as of faces, both are among its molecules then.
  bool of_each = false;
};

/// The loads that Elastin has, a row each.
const Table<LoadKind>& built_in_loads();

/// The values with defaults, directions of length 1. Throws InputError on what is unknown, missing, not finite, out of
/// range or no molecule of the body, and where the load does not suit the body.
LoadValues checked_values(const LoadKind& load, const Body& body, LoadValues values);

/// Puts a load on a model, with its values checked.
void add_load(Model& model, const LoadKind& load, LoadValues values, const Material* material = nullptr);

}  // namespace elastin
