#pragma once
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "lab/identify/answer.h"
#include "lab/identify/fit.h"
#include "lab/report/plot.h"
#include "lab/study/journal.h"

namespace elastin::lab {

/// How the searches of a folder ended, in DIR/fits.jsonl, so that none is made twice.
class FitJournal {
 public:
  /// `resume`: takes the searches that are there; else the file starts empty. Throws InputError with the line that is
  /// none.
  FitJournal(const std::string& folder, bool resume);
  /// That of this key, which is made of all that it follows from; none if it was not made.
  std::optional<SearchEnd> find(const std::string& key) const;
  void add(const std::string& key, const std::string& label, const SearchEnd& end);

 private:
  std::unordered_map<std::string, SearchEnd> ends_;
  LineFile file_;
};

/// The options of an identification, in addition to those of the scene.
struct IdentifyRequest {
  std::vector<std::string> overrides = {};  ///< key.path=value of the scene
  std::vector<std::string> data = {};       ///< FILE, or TEST=FILE: instead of the files that the scene names
  std::vector<std::string> tests = {};      ///< that count; the others are predicted alone. Empty = as the scene says
  std::string laws = {};                    ///< "all" or names, separated by commas; empty = as the scene says
  std::string strategies = {};              ///< of specimens, separated by commas; empty = as their scenes say
  std::function<void(const std::string& doing)> progress = {};
  std::function<bool()> stop = {};
  FitJournal* journal = nullptr;  ///< where ends of searches are noted, and found that were made before
};

/// The material of a scene's `identify:` section fitted to its measured tests; several answers where strategies are
/// compared, one each. Numerical trouble is an outcome. Throws InputError on wrong scenes, data and names.
std::vector<Answer> identify(const SceneSource& scene, const Catalog& catalog, const IdentifyRequest& request);

/// The tables of the terminal: numbers with intervals, tests, laws, warnings, the material.
std::string answer_text(const Answer& answer, bool colours);

/// What each strategy makes of the same curve: its numbers, its misfit and its time; "" of one answer.
std::string strategies_text(const std::vector<Answer>& answers, bool colours);

/// {"law", "parameters": [{name, value, unit, low, high}], "correlation": [[…]], "relative_rms": {test: …}, "warnings":
/// [], …} of one answer; of several {"identifications": [{…}, …]}. SI units; what is not finite is null.
std::string identify_json(const std::vector<Answer>& answers);

/// One HTML page that needs no other file: data with fits, residuals, intervals, correlation, laws, warnings.
std::string identify_page(const std::vector<Answer>& answers, const std::string& command);

/// Data and fits; the residuals of each point.
Plot fit_plot(const Answer& answer);
Plot residual_plot(const Answer& answer);
/// Misfit over the time of the fit, of strategies.
Plot strategy_plot(const std::vector<Answer>& answers);

/// Every measured point with its fit: test, prescribed, measured, fitted, residual.
std::string points_csv(const Answer& answer);

}  // namespace elastin::lab
