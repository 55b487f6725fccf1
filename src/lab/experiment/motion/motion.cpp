#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>

#include "core/forces/pressure.h"
#include "core/solve/newton.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/time_function.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/keys.h"
#include "lab/run/common_measures.h"
#include "lab/run/decaying_terms.h"
#include "lab/run/load_path.h"
#include "lab/run/time_history_fits.h"
#include "lab/run/time_options.h"

namespace elastin::lab {
namespace {

enum class MotionKind {
  motion,      ///< nothing but the rows
  release,     ///< loaded, then released: free vibration; or the load put on at once, with `applied`
  creep,       ///< a load that is held
  relaxation,  ///< a displacement that grows and is held
  cyclic,      ///< a displacement that oscillates
};

/// A body held and loaded as an experiment at rest says, whose load changes in time.
struct MotionSetup {
  std::string name = "motion";  ///< of the experiment
  MotionKind kind = MotionKind::motion;
  std::unique_ptr<StaticExperiment> fixture;  ///< null: the body is free; only `motion` allows that
  TimeFunction load;                          ///< what the experiment's load is multiplied with
  bool applied = false;                       ///< of a release: the load is put on at time 0, and not gone from then on
  double ramp = 0;                            ///< [s] after which a relaxation begins
  double frequency = 0;                       ///< [Hz] of what is cyclic
  const ExperimentContext* context = nullptr;  ///< in which it is read
};

const MeasureList& motion_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  constexpr Dimension rate{0, 0, -1};
  static const MeasureList list{
      {"frequency", rate, "frequency of the free vibration: a damped cosine fitted to the displacement", Role::none, "",
       "Hz"},
      {"period", dimension::time, "period of the free vibration: between crossings of its mean in one direction"},
      {"logarithmic_decrement", none, "ln of the ratio of two peaks one period apart"},
      {"damping_ratio", none, "decay rate / undamped circular frequency of the free vibration"},
      {"first_peak", length, "displacement at its first reversal"},
      {"first_peak_time", dimension::time, "time of the first reversal"},
      {"return_time", dimension::time, "time of the second reversal"},
      {"retardation_time", dimension::time,
       "time constant of creep, or of a release that does not swing: an exponential fitted to the displacement"},
      {"relaxation_time", dimension::time,
       "time constant of relaxation: an exponential fitted to the force, after the ramp"},
      {"relaxed_ratio", none, "force in the end / at the end of the ramp, of the fit"},
      {"remaining_change", none,
       "part of the displacement of creep, or of the force at the end of the ramp, by which the fit, or the relaxation "
       "of "
       "the material if that is more, changes after the run; without both, by which it changed in the last tenth of it",
       Role::detail},
      {"settling_time", dimension::time, "time at which a fiftieth of it would remain to change, by the same",
       Role::detail},
      {"storage_modulus", pressure, "stress in phase with the strain / strain, over the last period", Role::modulus},
      {"loss_modulus", pressure, "stress a quarter period ahead of the strain / strain", Role::modulus},
      {"loss_tangent", none, "loss modulus / storage modulus"},
      {"fit_misfit", none,
       "residual of the fitted curve / variation of the time history, root mean squares: above 0.1 it gives no "
       "time constant, above 0.2 no damping, above 0.5 no frequency",
       Role::detail},
      {"cycle_change", none,
       "change of the complex modulus since the period before / its size: above 0.02 there are no moduli",
       Role::detail}};
  return list;
}

/// Misfits beyond which a curve has no time constant, no damping, no frequency: the fitted part is not all but all,
/// most, the larger part of it.
constexpr double kMostForTime = 0.1, kMostForDamping = 0.2, kMostForFrequency = 0.5;
/// Change of the complex modulus from one period to the next beyond which it is not the material's.
constexpr double kMostChange = 0.02;

/// Part of a value by which it may change after the run without a word.
constexpr double kSettled = 0.02;

/// One measure over time, from a time on, to another.
Series series_of(const std::vector<CurvePoint>& history, std::string_view name, double from = 0,
                 double to = std::numeric_limits<double>::infinity()) {
  std::vector<double> times, values;
  for (const CurvePoint& row : history)
    if (const double value = row.measures.get(name);
        row.time >= from * (1 - 1e-12) && row.time <= to * (1 + 1e-12) && std::isfinite(value)) {
      times.push_back(row.time);
      values.push_back(value);
    }
  const auto size = static_cast<Eigen::Index>(times.size());
  return {Eigen::Map<const VectorX>(times.data(), size), Eigen::Map<const VectorX>(values.data(), size)};
}

/// Starts in the equilibrium of the scene's own loads (a free body: at rest). Throws InputError if the inner experiment
/// has not what the kind needs.
class Motion final : public TimedExperiment {
 public:
  explicit Motion(MotionSetup setup) : setup_(std::move(setup)) {
    if (!setup_.fixture) return;
    response_ = setup_.fixture->response_measures();
    if (released() && !response_.released.empty()) response_.displacement = response_.released;
    const bool driven = setup_.kind == MotionKind::relaxation || setup_.kind == MotionKind::cyclic;
    if (driven && response_.resistance.empty())
      throw InputError("fixture: needs a displacement that is given, as that of tension, shear or torsion");
    const bool applied = setup_.kind == MotionKind::creep || (setup_.kind == MotionKind::release && setup_.applied);
    if (applied && !response_.resistance.empty())
      throw InputError("fixture: a load that is put on at once must be a force, not a displacement");
    if (setup_.kind != MotionKind::motion && response_.displacement.empty())
      throw InputError("fixture: a " + setup_.fixture->name() + " experiment has no displacement to watch");
    all_measures_ = measures_of(*this);
  }

  std::string name() const override { return setup_.name; }
  MeasureList measures() const override {
    MeasureList list = motion_measures();
    if (setup_.fixture) list.add(setup_.fixture->measures());
    std::vector<ResponseAxes> axes;
    if (setup_.kind == MotionKind::relaxation) axes.push_back({"time", response_.resistance});
    if (setup_.kind == MotionKind::cyclic) {
      const std::string stress = list.named(MeasureRole::stress);
      const auto own = std::find_if(list.response.begin(), list.response.end(),
                                    [&](const ResponseAxes& one) { return one.y == stress; });
      axes.push_back({list.named(MeasureRole::strain), stress, false, own == list.response.end() ? "" : own->y_title});
      axes.push_back({response_.displacement, response_.resistance});
    }
    for (const ResponseAxes& of_fixture : list.response)
      if (of_fixture.x == "load") axes.push_back({"time", released() ? response_.displacement : of_fixture.y});
    list.response = std::move(axes);
    return list;
  }
  std::unique_ptr<TimedRig> timed_rig(Model& model) const override;
  StaticExperiment* fixture() override { return setup_.fixture.get(); }
  bool slow() const override { return setup_.kind == MotionKind::creep || setup_.kind == MotionKind::relaxation; }
  std::optional<Vector3> axis() const override { return setup_.fixture ? setup_.fixture->axis() : std::nullopt; }
  const StaticExperiment* calibration() const override { return setup_.fixture.get(); }

  void read_history(const std::vector<CurvePoint>& history, Measures& measures) const override {
    if (setup_.kind == MotionKind::release) read_vibration(series_of(history, response_.displacement), measures);
    if (setup_.kind == MotionKind::creep) read_creep(history, measures);
    if (setup_.kind == MotionKind::relaxation) read_relaxation(history, measures);
    if (setup_.kind == MotionKind::cyclic) read_cycle(history, measures);
  }

  /// A fit sees what moves within the run, and takes a slower part for the end.
  void read_relaxation(const std::vector<CurvePoint>& history, const Relaxation& relaxation,
                       Measures& measures) const override {
    const bool creeps = setup_.kind == MotionKind::creep;
    if (!creeps && setup_.kind != MotionKind::relaxation) return;
    const double from = creeps ? 0 : setup_.ramp, duration = history.back().time;
    const DecayingTerms terms = creeps ? terms_of_displacement(relaxation) : terms_of_force(relaxation, from);
    const double left = sum_at(terms, duration - from), settled = from + time_until(terms, kSettled);
    if (!(left > kSettled) || duration < from) return;
    const auto raise = [&](const char* name, double own) {
      if (!(measures.get(name) > own)) measures.set(name, own);
    };
    if (!std::isfinite(measures.get("settling_time"))) measures.set("remaining_change", left);
    raise("remaining_change", left), raise("settling_time", settled);
  }

  std::string remark(const Measures& measures) const override {
    const double misfit = measures.get("fit_misfit"), change = measures.get("cycle_change");
    const auto missing = [&](const char* measure) { return !std::isfinite(measures.get(measure)); };
    const auto because = [&](const char* curve, double most) {
      return std::isfinite(misfit) ? std::string("the time history is no ") + curve + " (fit_misfit " + number(misfit) +
                                         ", at most " + number(most) + ")"
                                   : std::string("the time history shows no ") + curve;
    };
    switch (setup_.kind) {
      case MotionKind::release:
        if (missing("frequency") && !missing("retardation_time"))
          return "no frequency: the body is overdamped or nearly so, it goes over without swinging, with a time "
                 "constant of " +
                 number(measures.get("retardation_time"), 3) + " s (retardation_time)";
        if (missing("frequency")) return "no frequency and no damping: " + because("damped cosine", kMostForFrequency);
        return missing("damping_ratio") ? "no damping: " + because("damped cosine", kMostForDamping) : "";
      case MotionKind::creep:
        return joined(missing("retardation_time") ? "no retardation time: " + because("exponential", kMostForTime) : "",
                      still_changes("the displacement", measures));
      case MotionKind::relaxation:
        return joined(missing("relaxation_time") ? "no relaxation time: " + because("exponential", kMostForTime) : "",
                      still_changes("the force", measures));
      case MotionKind::cyclic:
        if (!missing("loss_tangent")) return "";
        if (std::isfinite(change))
          return "no moduli: the cycle is not steady yet (cycle_change " + number(change) + ", at most " +
                 number(kMostChange) + ")";
        return "no moduli: the duration has no two whole periods with eight frames each";
      case MotionKind::motion:
        break;
    }
    return "";
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    if (setup_.kind == MotionKind::release)
      return {{"frequency"}, {"logarithmic_decrement"}, {"first_peak"}, {"energy_drift"}};
    if (setup_.kind == MotionKind::creep) return {{"retardation_time"}, {response_.displacement}};
    if (setup_.kind == MotionKind::cyclic) return {{"storage_modulus"}, {"loss_modulus"}, {"loss_tangent"}};
    if (setup_.kind == MotionKind::relaxation) return {{"relaxation_time"}, {"relaxed_ratio"}};
    if (setup_.fixture && !response_.displacement.empty()) return {{response_.displacement}, {"energy_drift"}};
    return {{"speed"}, {"largest_strain"}, {"energy_drift"}};
  }

 private:
  friend class MotionRig;
  /// Whether the load is there before time 0 and gone from then on.
  bool released() const { return setup_.kind == MotionKind::release && !setup_.applied; }
  /// Balances mean nothing in motion, and moduli nothing once the load is gone.
  bool is_reported(const std::string& name) const {
    const MeasureInfo* info = all_measures_.find(name);
    return info && !(setup_.kind == MotionKind::release && is_property(info->role));
  }

  static std::string joined(const std::string& first, const std::string& second) {
    return first + (first.empty() || second.empty() ? "" : "; ") + second;
  }

  static std::string still_changes(const std::string& what, const Measures& measures) {
    const double left = measures.get("remaining_change"), settled = measures.get("settling_time");
    if (!(left > kSettled)) return "";
    const std::string percent = number(100 * left, 2) + " %";
    return what + (std::isfinite(settled)
                       ? " still changes when the run ends, by " + percent + " to come; a duration of " +
                             number(settled, 3) + " s leaves " + number(100 * kSettled, 2) + " %"
                       : " changed by " + percent + " in the last tenth of the run; a longer duration shows its end");
  }

  /// How far from its end a history is, as part of `whole`: by the fit, or by its last tenth.
  static void read_end(const Series& series, const std::optional<ExponentialFit>& fit, double whole,
                       Measures& measures) {
    const Eigen::Index last = series.times.size() - 1;
    const double duration = series.times[last], now = series.values[last];
    if (fit && fit->misfit <= kMostForTime) {
      const double left = std::abs((fit->end - now) / whole);
      measures.set("remaining_change", left);
      measures.set("settling_time", std::max(0., duration + fit->time * std::log(left / kSettled)));
      return;
    }
    Eigen::Index before = last;
    while (before > 0 && series.times[before] > 0.9 * duration) --before;
    measures.set("remaining_change", std::abs((now - series.values[before]) / whole));
  }

  /// From where on a start twice as late gives the same time constant: before, the body still comes to what it shows at
  /// once, swinging or by some short steps. Where that is nowhere (of several time constants), behind the first
  /// hundredth of the time or the first start from which it is near one exponential, as long as the body creeps there
  /// by more than a hundredth of what it has moved.
  void read_creep(const std::vector<CurvePoint>& history, Measures& measures) const {
    constexpr double first = 0.01, last = 0.35, same = 0.003, exact = 0.01;
    std::optional<ExponentialFit> found;
    double before = 0;  // time constant
    Series from;
    for (double share = first; share < last; share *= 2) {
      Series series = series_of(history, response_.displacement, share * history.back().time);
      if (series.times.size() == 0 || (from.times.size() > 0 && series.times[0] == from.times[0])) continue;
      const auto fit = fit_exponential(series);
      const auto [low, high] = std::minmax_element(series.values.begin(), series.values.end());
      const bool creeps = *high - *low >= 0.01 * std::max(std::abs(*low), std::abs(*high));
      if (from.times.size() > 0 && (!fit || !creeps)) break;
      from = std::move(series);
      if (!fit) break;
      const bool near = fit->misfit <= kMostForTime;
      const bool settled = fit->misfit < exact && before > 0 && std::abs(fit->time / before - 1) < same;
      before = near ? fit->time : 0;
      if (!found || found->misfit > kMostForTime || settled) found = fit;
      if (settled) break;
    }
    if (from.times.size() > 1) {
      const double now = from.values[from.values.size() - 1];
      read_end(from, found, found && found->misfit <= kMostForTime ? found->end : now, measures);
    }
    if (!found) return;
    measures.set("fit_misfit", found->misfit);
    if (found->misfit <= kMostForTime) measures.set("retardation_time", found->time);
  }

  /// Behind the row at the ramp's end, where the body still moves. The slowest part alone: from where a twentieth of
  /// the fall is left, faster ones are gone; at least the last moments, for where the parts lie decades apart one
  /// exponential is a poor guess of the end.
  void read_relaxation(const std::vector<CurvePoint>& history, Measures& measures) const {
    const Series all = series_of(history, response_.resistance, setup_.ramp * (1 + 1e-9));
    const auto whole = fit_exponential(all);
    if (all.times.size() > 1) read_end(all, std::nullopt, all.values[0], measures);
    if (!whole) return;
    measures.set("fit_misfit", whole->misfit);
    if (whole->misfit > kMostForFrequency) return;  // it swings: a piece of that would look like the end of a fall
    constexpr Eigen::Index fewest = 6;
    double late = all.times[0];
    for (Eigen::Index i = 0; i < all.times.size(); ++i)
      if (std::abs(all.values[i] - whole->end) > 0.05 * std::abs(all.values[0] - whole->end)) late = all.times[i];
    if (all.times.size() >= fewest) late = std::min(late, all.times[all.times.size() - fewest]);
    const Series last = all.times.size() < fewest ? all : series_of(history, response_.resistance, late);
    auto end = fit_exponential(last);
    const double since = end ? last.times[0] - setup_.ramp : 0;
    if (!end) end = whole;  // of a run that ends early the last moments are straight
    measures.set("fit_misfit", end->misfit);
    if (end->misfit > kMostForTime) return;
    // The first moments after the ramp have the wave of its sudden stop: a single exponential says what is under it, or
    // the row at the ramp's end, before it.
    const Series on_ramp = series_of(history, response_.resistance, setup_.ramp * (1 - 1e-9));
    const bool has_end = setup_.ramp > 0 && on_ramp.times.size() > all.times.size();
    const bool single = std::abs(whole->time - end->time) < 0.1 * end->time;
    const double start =
        single ? end->end + (end->start - end->end) * std::exp(since / end->time) : (has_end ? on_ramp : all).values[0];
    read_end(all, end, start, measures);
    measures.set("relaxation_time", end->time);
    measures.set("relaxed_ratio", end->end / start);
  }

  /// Resistance over displacement in the period that begins at `from`: the part in phase with the displacement, and
  /// the part a quarter period ahead of it. None of a period with fewer than eight frames.
  std::optional<std::complex<double>> complex_stiffness(const std::vector<CurvePoint>& history, double from) const {
    const double w = 2 * M_PI * setup_.frequency, to = from + 1 / setup_.frequency;
    const Series moved = series_of(history, response_.displacement, from, to),
                 resists = series_of(history, response_.resistance, from, to);
    if (from < 0 || moved.times.size() < 8 || resists.times.size() < 8) return std::nullopt;
    const VibrationFit by = fit_sine(moved, w), of = fit_sine(resists, w);
    return std::complex(of.cosine, -of.sine) / std::complex(by.cosine, -by.sine);
  }

  /// Of the last period, unless the one before says otherwise.
  void read_cycle(const std::vector<CurvePoint>& history, Measures& measures) const {
    const double period = 1 / setup_.frequency, from = history.back().time - period;
    // A duration of two periods has them to rounding.
    const double before = std::abs(from - period) < 1e-9 * period ? 0 : from - period;
    const auto last = complex_stiffness(history, from), earlier = complex_stiffness(history, before);
    if (!last || !earlier) return;
    const double change = std::abs(*last - *earlier) / std::abs(*last);
    measures.set("cycle_change", change);
    if (!(change <= kMostChange)) return;
    measures.set("loss_tangent", last->imag() / last->real());
    const CurvePoint* largest = nullptr;
    for (const CurvePoint& row : history) {
      const double own = std::abs(row.measures.get(response_.displacement));
      if (row.time >= from && std::isfinite(own) &&
          (!largest || own > std::abs(largest->measures.get(response_.displacement))))
        largest = &row;
    }
    // The modulus of a row is its resistance over its displacement, times what the body's shape gives.
    for (const MeasureRole role : {MeasureRole::youngs_modulus, MeasureRole::shear_modulus})
      if (const double own = largest->measures.get(all_measures_.named(role)); std::isfinite(own)) {
        const double shape =
            own * largest->measures.get(response_.displacement) / largest->measures.get(response_.resistance);
        measures.set("storage_modulus", shape * last->real());
        measures.set("loss_modulus", shape * last->imag());
      }
  }

  /// What goes over without swinging, to its end: an exponential is nearer than a damped cosine, or this one leaves
  /// less than a hundredth of a peak one period later.
  static std::optional<ExponentialFit> overdamped(const Series& series, const std::optional<VibrationFit>& swings) {
    constexpr double lost = 0.01, ended = 3;  // time constants
    const auto goes_over = fit_exponential(series);
    const double duration = series.times.size() > 0 ? series.times[series.times.size() - 1] : 0;
    if (!goes_over || goes_over->misfit > kMostForTime || ended * goes_over->time > duration) return std::nullopt;
    const bool dies = !swings || goes_over->misfit <= swings->misfit ||
                      2 * M_PI * swings->decay_rate > -std::log(lost) * swings->circular_frequency;
    return dies ? goes_over : std::nullopt;
  }

  /// Higher modes that die in the first periods pull a fit of all: it begins a period later as long as that halves the
  /// misfit and finds the same frequency. Where it finds another one the body swings otherwise at other sizes.
  static VibrationFit without_first_swings(Series series, VibrationFit fit) {
    constexpr double exact = 0.01, same = 0.01;
    constexpr int most_periods = 4;
    for (int period = 0; period < most_periods && fit.misfit > exact; ++period) {
      const double from = series.times[0] + 2 * M_PI / fit.circular_frequency;
      const Eigen::Index left = (series.times.array() >= from).count();
      series = {series.times.tail(left).eval(), series.values.tail(left).eval()};
      if (left < 8) break;
      const auto later = fit_vibration(series);
      if (!later || !(later->misfit < 0.5 * fit.misfit) ||
          !(std::abs(later->circular_frequency / fit.circular_frequency - 1) < same))
        break;
      fit = *later;
    }
    return fit;
  }

  void read_vibration(const Series& series, Measures& measures) const {
    const auto fit = fit_vibration(series);
    if (const auto goes_over = overdamped(series, fit)) {
      measures.set("fit_misfit", goes_over->misfit);
      measures.set("retardation_time", goes_over->time);
      return;
    }
    const Series turns = turning_points(series);
    const bool is_length = all_measures_.at(response_.displacement).unit == dimension::length;
    if (turns.times.size() > 0) {
      if (is_length) measures.set("first_peak", turns.values[0]);
      measures.set("first_peak_time", turns.times[0]);
    }
    if (turns.times.size() > 1) measures.set("return_time", turns.times[1]);
    if (!fit) return;
    measures.set("fit_misfit", fit->misfit);
    if (!(fit->misfit <= kMostForFrequency)) return;
    measures.set("frequency", fit->circular_frequency / (2 * M_PI));
    if (const auto period = period_of(series, fit->mean)) measures.set("period", *period);
    if (!(fit->misfit <= kMostForDamping)) return;
    const VibrationFit later = without_first_swings(series, *fit);
    const double w = later.circular_frequency, d = later.decay_rate;
    measures.set("logarithmic_decrement", 2 * M_PI * d / w);
    measures.set("damping_ratio", d / std::hypot(d, w));
  }

  MotionSetup setup_;
  ResponseMeasures response_;
  MeasureList all_measures_;  // with those that every run in time has
};

class MotionRig final : public TimedRig {
 public:
  MotionRig(const Motion& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), model_(model) {
    if (!setup_.fixture) return;
    const std::size_t others = model.loads().size();
    fixture_ = setup_.fixture->static_rig(model);
    if (setup_.load.constant()) return;
    for (std::size_t i = others; i < model.loads().size(); ++i) {
      if (auto* load = dynamic_cast<PointLoads*>(model.loads()[i].get())) load->set_varying();
      if (auto* load = dynamic_cast<Pressure*>(model.loads()[i].get())) load->set_varying();
    }
  }

  StaticResult start(State& state, const StaticOptions& options) override {
    start_ = {state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model_.supports.size()))};
    if (!fixture_) return {};
    fixture_->withdraw();
    fixture_->set_load(0);
    StaticResult result;
    if (any_over(model_.body(), !model_.load_forces(state).isZero(0))) {
      result = solve_static(model_, state, options);
      if (result.outcome != Outcome::converged) return result;
      start_ = {state.positions, result.reactions};
    }
    fixture_->meet(state.positions);
    if (experiment_.released()) return load_and_release(state, options);
    fixture_->set_load(setup_.load.value(0));
    // What is displaced at once does so in the first step: that is work, too.
    const bool displaced = std::any_of(model_.supports.begin(), model_.supports.end(),
                                       [](const Support& one) { return !one.displacement.isZero(0); });
    if (setup_.load.constant() && !any_over(model_.body(), displaced)) return result;
    model_.drive = [this](double time, std::vector<Support>&) {
      fixture_->set_load(setup_.load.value(time));
      fixture_->set_load_rate(setup_.load.rate(time));
    };
    return result;
  }

  Measures read(const State& state) const override {
    if (!fixture_) return {};
    Positions forces;
    model_.set_forces(state, forces);
    StaticResult held;
    held.reactions = -fixed_components(model_.supports, forces);
    for (std::size_t i = 0; i < model_.supports.size(); ++i)  // those of ghosts are their owners'
      if (model_.supports[i].molecule >= owned_molecules(model_.body()))
        held.reactions.col(static_cast<Eigen::Index>(i)).setZero();
    const Measures all = fixture_->measure(start_, state, {}, held);
    Measures kept;
    for (const auto& [name, value] : all.all())
      if (experiment_.is_reported(name)) kept.set(name, value);
    return kept;
  }

 private:
  StaticResult load_and_release(State& state, const StaticOptions& options) {
    LoadPath path(model_, *fixture_, options, state);
    StaticResult result, all;
    const int steps = setup_.fixture->load_steps();
    for (int step = 1; step <= steps; ++step) {
      result = path.advance(setup_.fixture->load_factor(step));
      all.newton_iterations += result.newton_iterations;
      all.linear_iterations += result.linear_iterations;
      if (result.outcome != Outcome::converged) return result;
    }
    state.positions = path.state().positions;
    fixture_->release(state);
    result.newton_iterations = all.newton_iterations;
    result.linear_iterations = all.linear_iterations;
    return result;
  }

  const Motion& experiment_;
  const MotionSetup& setup_;
  Model& model_;
  std::unique_ptr<StaticRig> fixture_;  // null: the body is free
  Start start_;
};

std::unique_ptr<TimedRig> Motion::timed_rig(Model& model) const { return std::make_unique<MotionRig>(*this, model); }

}  // namespace

namespace {

/// The keys that a kind of motion has, with its fixture's first.
ExperimentInfo motion(ExperimentInfo info, MotionKind kind, const char* fixture,
                      std::vector<Key<MotionSetup>> own = {}) {
  Key<MotionSetup> first = fixture_key<MotionSetup>(fixture);
  std::vector<Keys<MotionSetup>::Entry> entries{kind == MotionKind::motion ? std::move(first).otherwise("free body")
                                                                           : std::move(first).needed()};
  entries.insert(entries.end(), own.begin(), own.end());
  info.in_time = info.of_shares = true;
  const std::string name = info.name;
  return with_keys(std::move(info), Keys<MotionSetup>(entries), [=](const ExperimentContext&, MotionSetup setup) {
    setup.name = name;
    setup.kind = kind;
    return std::make_unique<Motion>(std::move(setup));
  });
}

}  // namespace

ExperimentInfo motion_row() {
  return motion({.name = "motion",
                 .summary = "a body, free or fixed and loaded by a fixture, is observed as it moves",
                 .measures = motion_measures()},
                MotionKind::motion, "how the body is fixed and loaded",
                {{{"in_time", "time function", "", "", "constant", "factor of the fixture's load"},
                  [](const Reader& value, MotionSetup& setup, const Frame&) {
                    if (!setup.fixture) value.fail("there is no load to change: key 'fixture' is missing");
                    setup.load = read_time_function(value);
                  }}});
}

ExperimentInfo release_row() {
  return motion({.name = "release",
                 .summary = "a loaded body is released, or loaded at once: free vibration, its frequency and damping",
                 .measures = motion_measures()},
                MotionKind::release, "how the body is fixed, and loaded before it is released",
                {key::choice("load", &MotionSetup::applied, {{"removed", false}, {"applied", true}},
                             "whether the load is taken away at time 0, or put on at once")});
}

ExperimentInfo creep_row() {
  return motion({.name = "creep",
                 .summary = "a force is applied and stays: displacement over time, retardation time",
                 .measures = motion_measures()},
                MotionKind::creep, "how the body is fixed, with the force that stays");
}

ExperimentInfo relaxation_row() {
  return motion(
      {.name = "relaxation",
       .summary = "a displacement grows and stays: force over time, relaxation time",
       .measures = motion_measures()},
      MotionKind::relaxation, "how the body is fixed, with the displacement that stays",
      {key::quantity("ramp", &MotionSetup::ramp, dimension::time, "time in which the displacement grows", kPositive)
           .needed()
           .then([](const Reader& value, MotionSetup& setup) {
             value.note(setup.load = TimeFunction::ramp(setup.ramp));
           })});
}

ExperimentInfo cyclic_row() {
  return motion(
      {.name = "cyclic",
       .summary = "a displacement oscillates: storage and loss modulus over the last period",
       .measures = motion_measures()},
      MotionKind::cyclic, "how the body is fixed, with the displacement that is the amplitude",
      {key::quantity("frequency", &MotionSetup::frequency, {0, 0, -1}, "frequency of the oscillation", kPositive)
           .needed()
           .then([](const Reader& value, MotionSetup& setup) {
             value.note(setup.load = TimeFunction::sine(setup.frequency));
           })});
}

}  // namespace elastin::lab
