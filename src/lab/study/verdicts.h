#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// A case that a strategy or a solver may fail on: one scene with one strategy, compared with what the scene expects;
/// and the same with other choices.
struct Case {
  Record own;
  std::string trouble;  ///< another fault: a resumed run that differs; empty = none
  /// Other choices by name, and their verdicts in words; empty = not requested.
  std::vector<std::pair<std::string, std::string>> others;
};

struct VerifyOptions {
  std::vector<std::string> overrides;  ///< KEY.PATH=VALUE, of every scene
  bool others = false;    ///< also run explicit steps, implicit steps, small displacements and plain springs
  bool steppers = false;  ///< also run cases in time with every stepper
  bool keep_snapshots = false;
  std::function<void(const std::string& doing)> progress = {};
  /// Called after each run of a case's own; may write files of it.
  std::function<void(const Scene&, Record&)> finished = {};
};

/// Runs a scene with its own strategy and with each that an expectation names. Throws InputError on wrong input.
std::vector<Case> verify_scene(const SceneSource& source, const Catalog& catalog, const VerifyOptions& options);

/// What a case is worth. Not judged: the run converged, and the scene has no expectation of it that is judged.
enum class CaseResult { passed, failed, not_judged };
CaseResult result_of(const Case& a_case);
inline bool passed(const Case& a_case) { return result_of(a_case) == CaseResult::passed; }

/// One line for each case: verdict, error against the known result, time; then how many passed. `markdown`: the table
/// alone, for a page.
std::string verdicts_text(const std::vector<Case>& cases, bool colours, bool markdown);

}  // namespace elastin::lab
