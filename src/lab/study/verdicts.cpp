#include "lab/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "elastin/core/base/stop.h"
#include "lab/report/comparison.h"
#include "lab/report/table.h"
#include "lab/run/specimen.h"

namespace elastin::lab {
namespace {

/// What a choice changes in a scene at rest and in one in time; nothing = it makes no sense there.
struct Choice {
  std::string name;
  std::vector<std::string> at_rest, in_time;
  bool plain_springs = false;
  bool with_contact = true;
};

const std::vector<Choice>& choices() {
  static const std::vector<Choice> list{
      {"explicit", {"solver.method=explicit"}, {"time.stepper=velocity_verlet", "time.step=automatic"}},
      {"implicit", {"solver.method=implicit"}, {"time.stepper=newmark"}},
      {"linear", {"solver.displacements=small"}, {}, false, false},
      {"plain springs", {}, {}, true}};
  return list;
}

/// Every stepper, in cases in time.
std::vector<Choice> choices_of_steppers(const Catalog& catalog) {
  std::vector<Choice> list;
  for (const auto& stepper : catalog.steppers) {
    Choice choice{stepper->name, {}, {"time.stepper=" + stepper->name}};
    if (stepper->is_explicit) choice.in_time.emplace_back("time.step=automatic");
    list.push_back(std::move(choice));
  }
  return list;
}

RunOptions options_of(const Scene& scene) {
  RunOptions options;
  options.statics = scene.statics;
  options.time = scene.time;
  options.problem = scene.problem;
  options.stop = &stop_requested;
  return options;
}

Record run_case(Scene& scene, const StrategyChoice& choice, const VerifyOptions& options, const std::string& doing) {
  prepare(scene.specimen, choice.strategy);
  RunOptions run_options = options_of(scene);
  run_options.keep_snapshots = options.keep_snapshots;
  if (options.progress) run_options.progress = [&](const std::string& what) { options.progress(doing + ": " + what); };
  return make_record(scene, run_strategy(scene.specimen, *scene.experiment, choice, run_options));
}

/// A scene with a checkpoint is run again from it: the result must be bitwise identical. Says what differs, or "".
std::string resumed(Scene& scene, const StrategyChoice& choice, const Record& whole) {
  if (!scene.time || scene.time->checkpoint == 0 || whole.run.outcome != Outcome::converged) return "";
  RunOptions options = options_of(scene);
  std::string saved;
  options.checkpoint = [&](const std::string& text) {
    if (saved.empty()) saved = text;
  };
  run_strategy(scene.specimen, *scene.experiment, choice, options);
  if (saved.empty()) return "there was no checkpoint to resume from";
  options.checkpoint = nullptr;
  options.restart = saved;
  const Run run = run_strategy(scene.specimen, *scene.experiment, choice, options);
  for (const auto& [name, value] : whole.run.measures.all())
    if (run.measures.get(name) != value) return "resumed from its checkpoint, " + name + " differs";
  return "";
}

std::string words(const char* outcome) {
  std::string text = outcome;
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

/// The expectation that is nearest to being broken; null if none was judged.
const Verdict* tightest(const std::vector<Verdict>& verdicts) {
  const Verdict* worst = nullptr;
  double most = -1;
  for (const Verdict& verdict : verdicts) {
    const Expectation& wanted = verdict.expectation;
    if (!verdict.judged || !wanted.outcome.empty()) continue;
    const double allowed = wanted.absolute + wanted.relative * std::abs(wanted.value);
    const double part = std::abs(verdict.measured - wanted.value) / allowed;
    if (!std::isfinite(part)) return &verdict;
    if (part > most) most = part, worst = &verdict;
  }
  return worst;
}

/// "E +0.001 %": how far off, as a difference where the answer is zero.
std::string error_text(const MeasureList& measures, const Verdict& verdict) {
  const MeasureInfo* info = measures.find(verdict.expectation.measure);  // null: of another experiment
  const std::string label = (info ? info->label() : verdict.expectation.measure) + " ";
  if (!std::isfinite(verdict.measured)) return label + "not measured";
  if (verdict.expectation.value == 0) return label + fmt::format("{:.1e}", verdict.measured);
  const double off = verdict.difference;
  return label + (std::abs(off) < 1e-7 ? fmt::format("{:+.0e}", off) : percent(off));
}

std::vector<Verdict> judged_as(const Scene& scene, const Run& run) {
  std::vector<Verdict> verdicts;
  for (const Expectation& wanted : scene.expectations)
    if (wanted.outcome.empty() && (wanted.strategy.empty() || wanted.strategy == scene.stiffness.label))
      verdicts.push_back(judge(wanted, run));
  return verdicts;
}

/// "passed", "failed: E +12 %", "stopped: inverted"; a run that converges where the case must stop has not detected it.
std::string choice_text(const Scene& scene, const Run& run) {
  if (!run.suited) return "unsuited";
  if (run.outcome != Outcome::converged) return "stopped: " + words(name_of(run.outcome));
  const std::vector<Verdict> verdicts = judged_as(scene, run);
  if (verdicts.empty())
    return std::any_of(scene.expectations.begin(), scene.expectations.end(),
                       [](const Expectation& wanted) { return !wanted.outcome.empty(); })
               ? "not detected"
               : "no expectation";
  const bool good =
      std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.passed || !v.judged; });
  if (!good) return "failed: " + error_text(*scene.measures, *tightest(verdicts));
  return run.restarted_from_rest ? "passed: restarted from rest" : "passed";
}

/// The rule without calibration, for a case that measures no modulus to calibrate to.
StrategyChoice uncalibrated_springs(const Catalog& catalog, const Body& body) {
  return choose_strategy(catalog, body.tetrahedra.empty() && body.triangles.empty() ? "standard" : "van_gelder");
}

/// Result of a case with another choice, in words.
std::string other_text(const Choice& choice, const SceneSource& source, const Catalog& catalog,
                       const VerifyOptions& options, const Scene& given) {
  const std::vector<std::string>& changes = given.time ? choice.in_time : choice.at_rest;
  if ((changes.empty() && !choice.plain_springs) || (given.specimen.contact && !choice.with_contact)) return "–";
  std::vector<std::string> overrides = options.overrides;
  overrides.insert(overrides.end(), changes.begin(), changes.end());
  const auto scene = load_scene(source, catalog, overrides);
  const std::string doing = scene->name + ", " + choice.name;
  const StrategyChoice strategy =
      choice.plain_springs ? choose_strategy(catalog, "calibrated:standard") : scene->stiffness;
  Record record = run_case(*scene, strategy, options, doing);
  if (choice.plain_springs && !record.run.suited)
    record = run_case(*scene, uncalibrated_springs(catalog, scene->specimen.body), options, doing);
  return choice_text(*scene, record.run);
}

std::vector<std::pair<std::string, std::string>> others_of(const SceneSource& source, const Catalog& catalog,
                                                           const VerifyOptions& options, const Scene& given) {
  std::vector<Choice> all;
  if (options.others) all = choices();
  if (options.steppers)
    for (Choice& choice : choices_of_steppers(catalog)) all.push_back(std::move(choice));
  std::vector<std::pair<std::string, std::string>> texts;
  for (const Choice& choice : all) {
    try {
      texts.emplace_back(choice.name, other_text(choice, source, catalog, options, given));
    } catch (const InputError&) {  // the scene itself runs: what was changed does not suit it
      texts.emplace_back(choice.name, "unsuited");
    }
  }
  return texts;
}

std::string verdict_text(const Case& a_case) {
  const Record& own = a_case.own;
  const CaseResult result = result_of(a_case);
  if (result == CaseResult::failed) return "failed";
  if (result == CaseResult::not_judged) return own.verdicts.empty() ? "no expectation" : "not reproduced";
  return own.stopped_as_expected() ? "passed: " + words(outcome_name(own.run)) : "passed";
}

/// Remark next to the verdict: the error, or why it stopped.
std::string detail_text(const Case& a_case) {
  const Record& own = a_case.own;
  if (!a_case.trouble.empty()) return a_case.trouble;
  if (own.run.outcome != Outcome::converged || !own.run.suited) return own.run.cause;
  const auto stop = std::find_if(own.verdicts.begin(), own.verdicts.end(),
                                 [](const Verdict& v) { return !v.expectation.outcome.empty(); });
  if (stop != own.verdicts.end()) return "converged, expected " + words(stop->expectation.outcome.c_str());
  const Verdict* verdict = tightest(own.verdicts);
  if (!verdict) return own.verdicts.empty() ? "" : own.verdicts.front().expectation.not_reproduced;
  return error_text(*own.measures, *verdict) + (own.run.restarted_from_rest ? "; restarted from rest" : "");
}

Tone tone_of(CaseResult result) {
  return result == CaseResult::passed ? Tone::good : result == CaseResult::failed ? Tone::bad : Tone::faint;
}

std::string cut(const std::string& text, std::size_t length) {
  return text.size() <= length ? text : text.substr(0, text.find_last_of(' ', length)) + " …";
}

/// "40 of 42 passed, 2 not judged"
std::string tally_text(const std::vector<Case>& cases) {
  const auto count = [&](CaseResult result) {
    return std::count_if(cases.begin(), cases.end(), [&](const Case& c) { return result_of(c) == result; });
  };
  const auto not_judged = count(CaseResult::not_judged);
  return fmt::format("{} of {} passed", count(CaseResult::passed), cases.size()) +
         (not_judged ? fmt::format(", {} not judged", not_judged) : "");
}

}  // namespace

std::vector<Case> verify_scene(const SceneSource& source, const Catalog& catalog, const VerifyOptions& options) {
  const auto scene = load_scene(source, catalog, options.overrides);
  std::vector<StrategyChoice> strategies{scene->stiffness};
  for (const Expectation& wanted : scene->expectations)
    if (!wanted.strategy.empty() && !find_strategy(strategies, wanted.strategy)) {
      const StrategyChoice* known = find_strategy(scene->strategies, wanted.strategy);
      strategies.push_back(known ? *known : choose_strategy(catalog, wanted.strategy));
    }
  std::vector<Case> cases;
  for (const StrategyChoice& choice : strategies) {
    cases.push_back({run_case(*scene, choice, options, scene->name + ", " + choice.label), {}, {}});
    cases.back().trouble = resumed(*scene, choice, cases.back().own);
    if (options.finished) options.finished(*scene, cases.back().own);
  }
  cases.front().others = others_of(source, catalog, options, *scene);
  return cases;
}

CaseResult result_of(const Case& a_case) {
  const Record& own = a_case.own;
  if (!own.good() || !a_case.trouble.empty()) return CaseResult::failed;
  if (std::any_of(own.verdicts.begin(), own.verdicts.end(), [](const Verdict& v) { return v.judged; }))
    return CaseResult::passed;
  return solved(own) ? CaseResult::not_judged : CaseResult::failed;
}

std::string verdicts_text(const std::vector<Case>& cases, bool colours, bool markdown) {
  std::vector<std::string> head{"case", "strategy", "verdict", "error, or cause", "time"};
  const auto others = std::find_if(cases.begin(), cases.end(), [](const Case& c) { return !c.others.empty(); });
  if (others != cases.end())
    for (const auto& [choice, text] : others->others) head.push_back(choice);
  std::vector<std::vector<TableCell>> rows;
  for (const Case& a_case : cases) {
    const Run& run = a_case.own.run;
    rows.push_back({{markdown ? a_case.own.title : a_case.own.scene, Tone::bold},
                    {run.strategy},
                    {verdict_text(a_case), tone_of(result_of(a_case))},
                    {cut(detail_text(a_case), 64)},
                    {readable_seconds(run.build_seconds + run.solve_seconds), Tone::plain, true}});
    for (const auto& [choice, text] : a_case.others)
      rows.back().push_back({text, text.starts_with("passed")   ? Tone::good
                                   : text.starts_with("failed") ? Tone::bad
                                                                : Tone::poor});
  }
  if (markdown) {
    std::string out, rule;
    for (const std::string& name : head) out += "| " + name + " ", rule += "|---";
    out += "|\n" + rule + "|\n";
    for (const auto& row : rows) {
      for (const TableCell& cell : row) out += "| " + cell.text + " ";
      for (std::size_t i = row.size(); i < head.size(); ++i) out += "| ";
      out += "|\n";
    }
    return out;
  }
  Table table(head);
  for (auto& row : rows) table.add(std::move(row));
  return table.text(colours) + "\n  " + tally_text(cases) + "\n";
}

}  // namespace elastin::lab
