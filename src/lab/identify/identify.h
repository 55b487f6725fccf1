#pragma once
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lab/identify/field.h"
#include "lab/report/plot.h"
#include "lab/study/journal.h"

namespace elastin::lab {

/// One number that was found, SI.
struct FoundNumber {
  std::string name;
  Dimension unit;
  double value = 0, deviation = 0;
  double low = 0, high = 0;  ///< 95 % interval
  double scale = 0;          ///< what its width is over: its size, or of a position the range of the test
  bool profiled = false;     ///< its ends are those of the likelihood profile, and not of the linear model
  bool determined = true;    ///< false: the interval is wider than twice the value
  double published = std::numeric_limits<double>::quiet_NaN();  ///< what others found; NaN: the scene does not say
};

/// One test with the response of the identified material.
struct TestAnswer {
  std::string name, kind;
  MeasuredData data;
  VectorX fitted;       ///< empty where the material has no equilibrium there
  bool counted = true;  ///< false: predicted alone
  ResidualScale residuals = ResidualScale::automatic;
  VectorX scale;                                ///< what differences are over
  double constant = 0;                          ///< of that, as WeightedTest has it
  std::vector<WindowModulus> moduli;            ///< by windows of the measured curve
  double relative_rms = 0;                      ///< of differences over the scale
  double noise = 1;                             ///< that the search took for these, next to those of the other tests
  std::vector<std::pair<double, double>> line;  ///< the material's own curve through the test, if it is homogeneous
};

/// Where a law is unstable in one homogeneous test, nominal strain or amount of shear; NaN = nowhere.
struct StabilityAnswer {
  std::string test;
  bool measured = false;     ///< whether a test of this kind counted
  double low = 0, high = 0;  ///< range that was measured; of a test that was not, the range of the others
  double unstable_within = std::numeric_limits<double>::quiet_NaN();
  double unstable_beyond = std::numeric_limits<double>::quiet_NaN();  ///< within twice the range
};

/// One law of several that are compared.
struct LawAnswer {
  std::string label;
  std::size_t unknowns = 0;
  FitOutcome outcome = FitOutcome::failed;
  std::string cause;
  double criterion = 0;  ///< small-sample information criterion; less is better
  bool stable = true;    ///< over the measured range
  std::vector<std::pair<std::string, double>> relative_rms;
};

/// What was found of one scene.
struct Answer {
  std::string scene;  ///< its name, or that of the file of data, of many
  std::string title, law, strategy;
  std::string published_source;  ///< of the published numbers, where there are any
  FitOutcome outcome = FitOutcome::failed;
  std::string cause;
  std::vector<FoundNumber> numbers;
  MatrixX correlation;
  std::vector<TestAnswer> tests;
  std::vector<StabilityAnswer> stability;
  std::vector<LawAnswer> laws;  ///< of a comparison, the best first
  std::vector<std::string> warnings;
  std::string material;  ///< the block of a scene with the numbers put in, YAML
  /// What else its own scene has then, by key: data files, the strategy, friction (see with_value).
  std::vector<std::pair<std::string, std::string>> keys;
  std::optional<FoundField> field = {};  ///< in the place of numbers
  double criterion = 0, condition = 1, seconds = 0;
  int starts = 0, agreeing = 0, freedom = 0;
  bool succeeded() const {
    return outcome != FitOutcome::failed && outcome != FitOutcome::misfit && outcome != FitOutcome::not_converged;
  }
};

/// What a fit says, with intervals, stability and warnings.
/// @param profiles whether wide intervals are those of the likelihood profile, which takes a search for each end
/// @param stop called before each of these, which are then left as they are; may be empty
Answer make_answer(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests, const Fit& fit, bool profiles,
                   const std::function<bool()>& stop = {});

/// The same of a field.
Answer make_answer(const UnknownMaterial& unknown, const std::vector<WeightedTest>& tests, FoundField field);

/// Of all tests that count together.
double whole_rms(const Answer& answer);

/// Of one among several laws.
LawAnswer law_answer(const Answer& answer);

/// The `material:` block of a scene.
/// @param plain without units, for a scene in plain SI numbers
std::string material_yaml(const MaterialLaw* row, const Trial& trial, bool plain);

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

/// What each strategy makes of the same curve, or one of many curves: numbers, misfit and time, a row each.
std::string answers_text(const std::vector<Answer>& answers, bool colours);

/// The same for a spreadsheet, SI: of each number its value and the ends of its interval.
std::string numbers_csv(const std::vector<Answer>& answers);

/// {"law", "parameters": [{name, value, unit, low, high}], "correlation": [[…]], "relative_rms": {test: …}, "warnings":
/// [], …} of one answer; of several {"identifications": [{…}, …]}. SI units; what is not finite is null.
std::string identify_json(const std::vector<Answer>& answers);

/// One HTML page that needs no other file: data with fits, residuals, intervals, correlation, laws, warnings.
/// @param shown how many of the answers it shows in full
std::string identify_page(const std::vector<Answer>& answers, const std::string& command,
                          std::size_t shown = std::numeric_limits<std::size_t>::max());

/// The cells with their factors for ParaView, and for `material.fields.stiffness` of a scene.
std::string field_vtu(const Answer& answer);

/// Data and fits; the residuals of each point.
Plot fit_plot(const Answer& answer);
Plot residual_plot(const Answer& answer);
/// Misfit over the time of the fit, of strategies.
Plot strategy_plot(const std::vector<Answer>& answers);

/// Every measured point with its fit: test, prescribed, measured, fitted, residual.
std::string points_csv(const Answer& answer);

}  // namespace elastin::lab
