#include "lab/identify/identify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/base/named.h"
#include "elastin/core/base/text.h"
#include "lab/report/files.h"
#include "lab/report/machine.h"
#include "lab/report/page.h"
#include "lab/report/table.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> numbers_of(const VectorX& values) { return {values.begin(), values.end()}; }

std::string percent_of(double ratio) { return std::isfinite(ratio) ? fmt::format("{:.3g} %", 100 * ratio) : ""; }

/// Digits that tell a value from the ends of its interval, where five do not.
int digits_of(const FoundNumber& number) {
  constexpr int least = 5, most = 12;
  int digits = least;
  const auto text = [&](double value) { return readable(value, number.unit, digits); };
  while (digits < most && number.low < number.high &&
         (text(number.low) == text(number.value) || text(number.high) == text(number.value)))
    ++digits;
  return digits;
}

Table number_table(const Answer& answer) {
  const bool published = !answer.published_source.empty();
  std::vector<std::string> head{"number", "value", "95 % from", "to", "half width", "from"};
  if (published) head.push_back("published");
  Table table(head);
  for (const FoundNumber& number : answer.numbers) {
    const double width = (number.high - number.low) / 2 / number.scale;
    const int digits = digits_of(number);
    std::vector<TableCell> row{
        {number.name},
        number_cell(readable(number.value, number.unit, digits), number.value),
        number_cell(readable(number.low, number.unit, digits), number.low),
        number_cell(readable(number.high, number.unit, digits), number.high),
        number_cell(percent_of(width), width, number.determined ? Tone::plain : Tone::bad),
        {number.determined ? number.profiled ? "likelihood profile" : "linear model" : "not determined",
         number.determined ? Tone::faint : Tone::bad}};
    if (published)
      row.push_back(std::isfinite(number.published)
                        ? number_cell(readable(number.published, number.unit), number.published)
                        : TableCell{""});
    table.add(std::move(row));
  }
  return table;
}

/// What was found of a field: its range over the cells, with the E of the material.
Table field_table(const FoundField& field) {
  Table table({"factor of the stiffness", "value", "deviation", "at x, y, z"});
  Eigen::Index low = 0, high = 0;
  field.factors.minCoeff(&low), field.factors.maxCoeff(&high);
  for (const auto& [name, cell] : {std::pair{"lowest", low}, {"highest", high}}) {
    const Vector3 at = 1e3 * field.middles.col(cell);
    table.add({{name},
               number_cell(fmt::format("{:.4g}", field.factors[cell]), field.factors[cell]),
               number_cell(percent_of(field.deviations[cell]), field.deviations[cell]),
               {fmt::format("{:.4g}, {:.4g}, {:.4g} mm", at.x(), at.y(), at.z()), Tone::faint}});
  }
  return table;
}

std::string field_text(const FoundField& field) {
  const double mean = std::exp(field.factors.array().log().mean());
  return fmt::format("{}, geometric mean {:.4g}; smoothness {:.3g}: {}{}", counted(field.factors.size(), "cell"), mean,
                     field.smoothness, field.chosen_by,
                     field.misfit > 0 ? fmt::format("; differences {:.3g} sigma (rms)", std::sqrt(field.misfit)) : "") +
         fmt::format("; {} and {}", counted(field.equilibria, "equilibrium", "equilibria"),
                     counted(field.linear_solves, "linear solve"));
}

/// Cells about the one that differs most, in the plane in which they spread most, by their factors.
Plot field_plot(const FoundField& field) {
  const Vector3 spread = field.middles.rowwise().maxCoeff() - field.middles.rowwise().minCoeff();
  int least = 0;
  spread.minCoeff(&least);
  const int right = least == 0 ? 1 : 0, up = least == 2 ? 1 : 2;
  Plot plot;
  Eigen::Index most = 0;
  (field.factors.array().log() - field.factors.array().log().mean()).abs().maxCoeff(&most);
  const double layer = field.middles(least, most);
  std::vector<Eigen::Index> cells(static_cast<std::size_t>(field.factors.size()));
  std::iota(cells.begin(), cells.end(), 0);
  std::stable_sort(cells.begin(), cells.end(), [&](auto a, auto b) {
    return std::abs(field.middles(least, a) - layer) < std::abs(field.middles(least, b) - layer);
  });
  cells.resize(std::min(cells.size(), static_cast<std::size_t>(60 + 2 * std::pow(field.factors.size(), 2. / 3))));
  plot.title = fmt::format("Factor of the stiffness of cells near {} = {:.3g} mm", "xyz"[least], 1e3 * layer);
  plot.x = {std::string(1, "xyz"[right]), "mm", false}, plot.y = {std::string(1, "xyz"[up]), "mm", false};
  const double low = std::log(field.factors.minCoeff()), high = std::log(field.factors.maxCoeff());
  constexpr int classes = 5;
  for (int i = 0; i < classes; ++i) {
    const double from = std::exp(low + (high - low) * i / classes),
                 to = std::exp(low + (high - low) * (i + 1) / classes);
    PlotSeries marks{fmt::format("{:.3g} to {:.3g}", from, to), i, PlotSeries::Kind::marks, {}};
    for (const Eigen::Index cell : cells)
      if (const double f = field.factors[cell]; (f >= from || i == 0) && (f < to || i == classes - 1))
        marks.points.push_back(
            {1e3 * field.middles(right, cell), 1e3 * field.middles(up, cell), fmt::format("{:.3g}", f)});
    if (!marks.points.empty()) plot.series.push_back(std::move(marks));
  }
  return plot;
}

/// What each smoothness leaves of the squares, over how uneven its field is.
Plot trade_off_plot(const FoundField& field) {
  Plot plot;
  plot.title = "Differences over unevenness";
  plot.x = {"unevenness of ln E", "", true}, plot.y = {"sum of squares", "", true};
  PlotSeries all{"smoothness tried", 0, PlotSeries::Kind::marks, {}}, taken{"taken", 1, PlotSeries::Kind::marks, {}};
  for (const auto& [smoothness, squares, unevenness] : field.tried)
    if (unevenness > 0)
      (smoothness == field.smoothness ? taken : all)
          .points.push_back({unevenness, squares, fmt::format("smoothness {:.3g}", smoothness)});
  for (PlotSeries* series : {&all, &taken})
    if (!series->points.empty()) plot.series.push_back(std::move(*series));
  return plot;
}

Json field_json(const FoundField& field) {
  Json tried = Json::array();
  for (const auto& [smoothness, squares, unevenness] : field.tried)
    tried.push_back({{"smoothness", smoothness}, {"squares", squares}, {"unevenness", unevenness}});
  Json middles = Json::array();
  for (const auto& middle : field.middles.colwise()) middles.push_back({middle.x(), middle.y(), middle.z()});
  return {{"smoothness", field.smoothness},
          {"chosen_by", field.chosen_by},
          {"mean_square_over_sigma", field.misfit > 0 ? Json(field.misfit) : Json()},
          {"only_ratios", field.only_ratios},
          {"equilibria", field.equilibria},
          {"linear_solves", field.linear_solves},
          {"tried", tried},
          {"stiffness", numbers_of(field.factors)},
          {"deviation", numbers_of(field.deviations)},
          {"middles", middles}};
}

std::string scale_text(const TestAnswer& test) {
  if (test.residuals == ResidualScale::absolute) return "the largest value";
  if (test.residuals == ResidualScale::relative) return "each value";
  if (std::isinf(test.constant)) return "the largest value, as they scatter";
  return "each value and " +
         readable(test.constant > 0 ? test.constant : test.data.least_scale(), test.data.up->unit, 2) +
         (test.constant > 0 ? ", as they scatter" : "");
}

Table modulus_table(const Answer& answer) {
  Table table({"modulus", "test", "value", "95 % from", "to", "points"});
  for (const TestAnswer& test : answer.tests)
    for (const WindowModulus& found : test.moduli) {
      const auto cell = [](double value) { return number_cell(readable(value, dimension::pressure), value); };
      table.add({{found.window},
                 {test.name, Tone::faint},
                 cell(found.value),
                 cell(found.low),
                 cell(found.high),
                 number_cell(std::to_string(found.rows), static_cast<double>(found.rows))});
    }
  return table;
}

/// What was recognised in the data files and done with their rows, a line each.
std::vector<std::string> data_notes(const Answer& answer) {
  std::vector<std::string> notes;
  for (const TestAnswer& test : answer.tests)
    if (!test.data.notes.empty()) {
      const std::string note = test.data.file + ": " + fmt::format("{}", fmt::join(test.data.notes, "; "));
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
    }
  return notes;
}

Table test_table(const Answer& answer) {
  Table table({"test", "kind", "points", "rms", "of", ""});
  for (const TestAnswer& test : answer.tests)
    table.add({{test.name},
               {test.kind, Tone::faint},
               number_cell(std::to_string(test.data.y.size()), static_cast<double>(test.data.y.size())),
               number_cell(percent_of(test.relative_rms), test.relative_rms),
               {scale_text(test), Tone::faint},
               {test.counted ? "fitted" : "predicted", test.counted ? Tone::faint : Tone::poor}});
  return table;
}

Table law_table(const Answer& answer) {
  std::vector<std::string> head{"law", "unknowns", "AICc", "more than the best"};
  if (!answer.laws.empty())
    for (const auto& [test, rms] : answer.laws.front().relative_rms) head.push_back(test);
  head.push_back("");
  Table table(head);
  for (const LawAnswer& law : answer.laws) {
    const double more = law.criterion - answer.laws.front().criterion;
    std::vector<TableCell> row{{law.label, &law == &answer.laws.front() ? Tone::bold : Tone::plain},
                               number_cell(std::to_string(law.unknowns), static_cast<double>(law.unknowns)),
                               number_cell(fmt::format("{:.1f}", law.criterion), law.criterion),
                               number_cell(fmt::format("{:+.1f}", more), more)};
    for (const auto& [test, rms] : law.relative_rms) row.push_back(number_cell(percent_of(rms), rms));
    row.resize(head.size() - 1);
    const bool sound = law.stable && law.outcome == FitOutcome::converged;
    row.push_back({!law.stable ? "unstable (Drucker) where it was measured"
                   : sound     ? ""
                               : name_of(law.outcome),
                   sound ? Tone::faint : Tone::bad});
    table.add(std::move(row));
  }
  return table;
}

Table stability_table(const Answer& answer) {
  Table table({"test", "range", "stable there", "and up to twice that"});
  for (const StabilityAnswer& stability : answer.stability) {
    const auto verdict = [](double at) {
      return TableCell{std::isfinite(at) ? fmt::format("unstable from {:.3g}", at) : "stable",
                       std::isfinite(at) ? Tone::bad : Tone::good};
    };
    table.add(
        {{stability.test + (stability.measured ? "" : " (not measured)"),
          stability.measured ? Tone::plain : Tone::faint},
         {fmt::format("{:.3g} … {:.3g}", stability.low, stability.high)},
         verdict(stability.unstable_within),
         verdict(std::isfinite(stability.unstable_within) ? stability.unstable_within : stability.unstable_beyond)});
  }
  return table;
}

Table strategy_table(const std::vector<Answer>& answers) {
  Table table({answers.front().strategy.empty() ? "scene" : "strategy", "numbers", "rms", "time", ""});
  for (const Answer& answer : answers) {
    const std::string numbers = joined(answer.numbers, [](const FoundNumber& number) {
      return number.name + " " + readable(number.value, number.unit);
    });
    table.add(
        {{answer.strategy.empty() ? answer.scene : answer.strategy},
         {numbers},
         number_cell(percent_of(whole_rms(answer)), whole_rms(answer)),
         number_cell(readable_seconds(answer.seconds), answer.seconds),
         {answer.outcome == FitOutcome::converged ? "" : name_of(answer.outcome) + (": " + answer.cause), Tone::bad}});
  }
  return table;
}

std::string head_text(const Answer& answer) {
  std::string text = answer.field ? "stiffness by cell" : answer.law.empty() ? "E and nu" : answer.law;
  if (!answer.strategy.empty()) text += ", " + answer.strategy;
  text += fmt::format(": {}", name_of(answer.outcome));
  if (answer.starts > 1)
    text += fmt::format("; {} of {} searches end at the same least", answer.agreeing, answer.starts);
  return text + fmt::format("; {}", readable_seconds(answer.seconds));
}

Json moduli_json(const TestAnswer& test) {
  Json list = Json::array();
  for (const WindowModulus& found : test.moduli)
    list.push_back({{"window", found.window},
                    {"value", found.value},
                    {"low", found.low},
                    {"high", found.high},
                    {"points", found.rows}});
  return list;
}

/// What is not finite becomes null.
Json json_of(const Answer& answer) {
  Json json{{"scene", answer.scene}, {"title", answer.title}, {"law", answer.law}};
  if (!answer.strategy.empty()) json["strategy"] = answer.strategy;
  json["outcome"] = name_of(answer.outcome), json["cause"] = answer.cause;
  json["parameters"] = Json::array();
  for (const FoundNumber& number : answer.numbers)
    json["parameters"].push_back({{"name", number.name},
                                  {"value", number.value},
                                  {"unit", si_unit(number.unit)},
                                  {"low", number.low},
                                  {"high", number.high},
                                  {"standard_deviation", number.deviation},
                                  {"interval", number.profiled ? "profile" : "linear"},
                                  {"determined", number.determined},
                                  {"published", number.published}});
  if (answer.field) json["field"] = field_json(*answer.field);
  if (!answer.published_source.empty()) json["published_source"] = answer.published_source;
  json["correlation"] = Json::array();
  for (const auto& row : answer.correlation.rowwise()) json["correlation"].push_back(numbers_of(row.transpose()));
  json["relative_rms"] = Json::object();
  for (const TestAnswer& test : answer.tests) json["relative_rms"][test.name] = test.relative_rms;
  json["warnings"] = answer.warnings, json["notes"] = data_notes(answer);
  json["tests"] = Json::array();
  for (const TestAnswer& test : answer.tests)
    json["tests"].push_back({{"name", test.name},
                             {"kind", test.kind},
                             {"fitted", test.counted},
                             {"residuals", test.residuals == ResidualScale::automatic  ? "automatic"
                                           : test.residuals == ResidualScale::relative ? "relative"
                                                                                       : "absolute"},
                             {"noise", test.data.noise},
                             {"zero", test.data.zero},
                             {"moduli", moduli_json(test)},
                             {test.data.along->name, numbers_of(test.data.x)},
                             {"measured_" + test.data.up->name, numbers_of(test.data.y)},
                             {"fitted_" + test.data.up->name, numbers_of(test.fitted)}});
  json["stability"] = Json::array();
  for (const StabilityAnswer& stability : answer.stability)
    json["stability"].push_back({{"test", stability.test},
                                 {"measured", stability.measured},
                                 {"low", stability.low},
                                 {"high", stability.high},
                                 {"unstable_within", stability.unstable_within},
                                 {"unstable_within_twice", stability.unstable_beyond}});
  json["laws"] = Json::array();
  for (const LawAnswer& law : answer.laws) {
    Json rms = Json::object();
    for (const auto& [test, value] : law.relative_rms) rms[test] = value;
    json["laws"].push_back({{"law", law.label},
                            {"unknowns", law.unknowns},
                            {"outcome", name_of(law.outcome)},
                            {"aicc", law.criterion},
                            {"stable", law.stable},
                            {"relative_rms", rms}});
  }
  json["aicc"] = answer.criterion, json["condition"] = answer.condition;
  json["searches"] = answer.starts, json["searches_at_the_least"] = answer.agreeing;
  json["seconds"] = answer.seconds, json["material"] = answer.material;
  return json;
}

/// A bar from low to high about each value, over the value: what is longer than twice the value ends at the frame.
std::string interval_html(const Answer& answer) {
  constexpr double width = 320, half = width / 2;
  std::string out = "<div class=\"scroll\" tabindex=\"0\"><table><tbody>";
  for (const FoundNumber& number : answer.numbers) {
    const int digits = digits_of(number);
    const auto at = [&](double value) {
      const double ratio = (value - number.value) / number.scale;
      return std::isfinite(ratio) ? half + half * std::clamp(ratio, -2., 2.) / 2 : value > 0 ? width : 0;
    };
    out += fmt::format(
        "<tr><th>{}</th><td class=\"n\">{}</td><td><svg viewBox=\"0 0 {} 18\" width=\"{}\" role=\"img\" "
        "aria-label=\"95 % "
        "interval\"><line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"9\" y2=\"9\" stroke=\"{}\" stroke-width=\"5\" "
        "stroke-linecap=\"round\"/><circle cx=\"{}\" cy=\"9\" r=\"5\" fill=\"currentColor\"/></svg></td><td>{} … "
        "{}</td></tr>",
        escaped(number.name), escaped(readable(number.value, number.unit, digits)), width, width, at(number.low),
        at(number.high), number.determined ? "var(--good)" : "var(--bad)", half,
        escaped(readable(number.low, number.unit, digits)), escaped(readable(number.high, number.unit, digits)));
  }
  return out +
         "</tbody></table></div><p class=\"note\">95 % intervals; a bar as wide as the frame is twice the value to "
         "either side.</p>";
}

std::string correlation_html(const Answer& answer) {
  std::string out = "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr><td></td>";
  for (const FoundNumber& number : answer.numbers) out += "<th>" + escaped(number.name) + "</th>";
  out += "</tr></thead><tbody>";
  for (std::size_t i = 0; i < answer.numbers.size(); ++i) {
    out += "<tr><th>" + escaped(answer.numbers[i].name) + "</th>";
    for (std::size_t j = 0; j < answer.numbers.size(); ++j) {
      const double value = answer.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      out +=
          fmt::format("<td class=\"n\" style=\"background:color-mix(in srgb, {} {:.0f}%, transparent)\">{:+.3f}</td>",
                      value < 0 ? "var(--bad)" : "var(--accent)", 35 * std::abs(value), value);
    }
    out += "</tr>";
  }
  return out + "</tbody></table></div>";
}

bool has_curves(const Answer& answer) {
  return std::any_of(answer.tests.begin(), answer.tests.end(), [](auto& test) { return test.data.axes.empty(); });
}

/// Computed over measured displacements.
Plot points_plot(const TestAnswer& test) {
  Plot plot;
  plot.title = test.name + ": displacements of points";
  plot.x = {"measured", "mm", false}, plot.y = {"computed", "mm", false};
  for (int axis = 0; axis < 3; ++axis) {
    PlotSeries marks{std::string("u") + "xyz" [axis], axis, PlotSeries::Kind::marks, {}};
    for (Eigen::Index i = 0; i < test.fitted.size(); ++i)
      if (test.data.axes[i] == axis) marks.points.push_back({1e3 * test.data.y[i], 1e3 * test.fitted[i], marks.name});
    if (!marks.points.empty()) plot.series.push_back(std::move(marks));
  }
  const double low = 1e3 * test.data.y.minCoeff(), high = 1e3 * test.data.y.maxCoeff();
  plot.series.push_back({"alike", 4, PlotSeries::Kind::dashed, {{low, low, ""}, {high, high, ""}}});
  return plot;
}

/// What is missed of one point, over its readings in all directions and states.
struct MissedPoint {
  Eigen::Index reading = 0;  ///< the first of it
  double squares = 0;        ///< sum over the readings [m²]
  int readings = 0;
  double rms() const { return std::sqrt(squares / readings); }
};

std::vector<MissedPoint> missed_points(const TestAnswer& test) {
  std::map<std::array<double, 3>, MissedPoint> points;
  for (Eigen::Index i = 0; i < test.fitted.size(); ++i) {
    std::array<double, 3> place;
    for (int axis = 0; axis < 3; ++axis) {
      const double at = test.data.places(axis, i);
      place[axis] = std::isnan(at) ? 0 : at;  // a file without this coordinate
    }
    MissedPoint& point = points[place];
    if (point.readings++ == 0) point.reading = i;
    point.squares += std::pow(test.fitted[i] - test.data.y[i], 2);
  }
  std::vector<MissedPoint> list;
  for (const auto& [place, point] : points) list.push_back(point);
  return list;
}

/// Where the points lie in the plane in which they spread most, by how far each is missed: the root mean square of its
/// readings, so that one reading does not stand for all.
Plot missed_plot(const TestAnswer& test) {
  const Positions& places = test.data.places;
  const Vector3 spread = places.rowwise().maxCoeff() - places.rowwise().minCoeff();
  int least = 0;
  spread.minCoeff(&least);
  const int right = least == 0 ? 1 : 0, up = least == 2 ? 1 : 2;
  const double rms = std::sqrt((test.fitted - test.data.y).squaredNorm() / static_cast<double>(test.fitted.size()));
  const std::vector<MissedPoint> points = missed_points(test);
  Plot plot;
  plot.title = test.name + ": where points are missed, rms " + readable(rms, dimension::length);
  plot.x = {std::string(1, "xyz"[right]), "mm", false}, plot.y = {std::string(1, "xyz"[up]), "mm", false};
  for (const auto& [name, from, to] : {std::tuple{"below the rms", 0., 1.},
                                       {"up to twice", 1., 2.},
                                       {"more", 2., std::numeric_limits<double>::infinity()}}) {
    PlotSeries marks{name, static_cast<int>(plot.series.size()), PlotSeries::Kind::marks, {}};
    for (const MissedPoint& point : points)
      if (point.rms() >= from * rms && point.rms() < to * rms)
        marks.points.push_back({1e3 * places(right, point.reading), 1e3 * places(up, point.reading),
                                fmt::format("rms {} of {}", readable(point.rms(), dimension::length),
                                            counted(point.readings, "reading"))});
    if (!marks.points.empty()) plot.series.push_back(std::move(marks));
  }
  return plot;
}

std::string answer_html(const Answer& answer) {
  std::string out = fmt::format("<section><h1>{}</h1><p class=\"faint\">{}</p><p class=\"advice{}\">{}</p>\n",
                                escaped(answer.title), escaped(answer.scene),
                                answer.outcome == FitOutcome::converged ? "" : " none", escaped(head_text(answer)));
  out += "<div class=\"pair\">" + figure_html(fit_plot(answer), "Measured and fitted", answer.scene + "-fit") +
         figure_html(residual_plot(answer), "Residuals", answer.scene + "-residuals") + "</div>\n";
  for (std::size_t i = has_curves(answer) ? 0 : 1; i < answer.tests.size(); ++i)
    if (const TestAnswer& test = answer.tests[i]; !test.data.axes.empty() && test.fitted.size() > 0)
      out += "<div class=\"pair\">" +
             figure_html(points_plot(test), "Displacements of points", answer.scene + "-" + test.name) +
             figure_html(missed_plot(test), "Where points are missed", answer.scene + "-" + test.name + "-missed") +
             "</div>\n";
  if (answer.field)
    out += "<div class=\"pair\">" +
           figure_html(field_plot(*answer.field), "Stiffness by cell", answer.scene + "-field") +
           figure_html(trade_off_plot(*answer.field), "Choice of the smoothness", answer.scene + "-smoothness") +
           "</div>\n" +
           card_html("Stiffness by cell", field_table(*answer.field).html() + "<p class=\"note\">" +
                                              escaped(field_text(*answer.field)) + "</p>");
  if (!answer.numbers.empty())
    out += card_html("Numbers of the law",
                     interval_html(answer) + number_table(answer).html() +
                         (answer.published_source.empty()
                              ? ""
                              : "<p class=\"note\">Published: " + escaped(answer.published_source) + "</p>")) +
           card_html("Correlation of the numbers", correlation_html(answer));
  std::string notes;
  for (const std::string& note : data_notes(answer)) notes += "<p class=\"note\">" + escaped(note) + "</p>";
  out += card_html("Tests", test_table(answer).html() + notes);
  if (const Table moduli = modulus_table(answer); !moduli.empty())
    out += card_html("Moduli of the measured curves", moduli.html());
  if (!answer.laws.empty())
    out += card_html("Laws, by the information criterion for small samples", law_table(answer).html());
  if (!answer.stability.empty()) out += card_html("Stability (Drucker)", stability_table(answer).html());
  std::string warnings;
  for (const std::string& warning : answer.warnings) warnings += "<li>" + escaped(warning) + "</li>\n";
  if (!warnings.empty()) out += card_html("Warnings", "<ul class=\"warnings\">" + warnings + "</ul>");
  if (!answer.material.empty())
    out += card_html("The material, as scenes write it", "<pre>" + escaped(answer.material) + "</pre>");
  return out + "</section>\n";
}

}  // namespace

std::string answer_text(const Answer& answer, bool colours) {
  std::string out = painted(answer.title, Tone::bold, colours) + "\n" + head_text(answer) + "\n";
  if (!answer.cause.empty()) out += painted(answer.cause, Tone::bad, colours) + "\n";
  const auto add = [&](const Table& table) {
    if (!table.empty()) out += "\n" + table.text(colours);
  };
  if (answer.field) {
    add(field_table(*answer.field));
    out += field_text(*answer.field) + "\n";
  } else {
    add(number_table(answer));
  }
  if (!answer.published_source.empty()) out += "published: " + answer.published_source + "\n";
  add(test_table(answer));
  for (const std::string& note : data_notes(answer)) out += "  " + note + "\n";
  add(modulus_table(answer)), add(law_table(answer)), add(stability_table(answer));
  if (!answer.warnings.empty()) out += "\n";
  for (const std::string& warning : answer.warnings)
    out += painted("  warning: ", Tone::poor, colours) + warning + "\n";
  if (!answer.material.empty()) out += "\n" + answer.material;
  return out + "\n";
}

std::string answers_text(const std::vector<Answer>& answers, bool colours) {
  return answers.empty() ? "" : strategy_table(answers).text(colours) + "\n";
}

std::string numbers_csv(const std::vector<Answer>& answers) {
  std::vector<std::string> names;
  for (const Answer& answer : answers)
    for (const FoundNumber& number : answer.numbers)
      if (const std::string name = number.name + " [" + si_unit(number.unit) + "]";
          std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
  std::string out = "curve";
  for (const std::string& name : names) out += "," + name + "," + name + " from," + name + " to";
  out += ",rms,outcome,cause\n";
  for (const Answer& answer : answers) {
    out += csv_field(answer.scene);
    for (const std::string& name : names) {
      const auto found = std::find_if(answer.numbers.begin(), answer.numbers.end(), [&](const FoundNumber& number) {
        return name == number.name + " [" + si_unit(number.unit) + "]";
      });
      for (double FoundNumber::*value : {&FoundNumber::value, &FoundNumber::low, &FoundNumber::high})
        out += "," + (found == answer.numbers.end() ? "" : csv_number((*found).*value));
    }
    out += fmt::format(",{},{},{}\n", answer.tests.empty() ? "" : csv_number(whole_rms(answer)),
                       name_of(answer.outcome), csv_field(answer.cause));
  }
  return out;
}

std::string identify_json(const std::vector<Answer>& answers) {
  if (answers.size() == 1) return json_of(answers.front()).dump(1) + "\n";
  Json list = Json::array();
  for (const Answer& answer : answers) list.push_back(json_of(answer));
  return Json{{"identifications", list}}.dump(1) + "\n";
}

std::string identify_page(const std::vector<Answer>& answers, const std::string& command, std::size_t shown) {
  std::string out =
      page_begin(answers.empty() ? "" : answers.front().title, "Elastin · from a measured curve to the material");
  out += "</header>\n<main class=\"scene\">\n";
  if (answers.size() > 1)
    out += figure_html(strategy_plot(answers), "Misfit over time of the fit", "strategies") +
           card_html("All fits", strategy_table(answers).html());
  for (const Answer& answer : answers)
    if (shown-- > 0)
      out += answer_html(answer);
    else
      break;
  return out + page_end(this_machine().text(), command);
}

std::string field_vtu(const Answer& answer) {
  const FoundField& field = *answer.field;
  return cells_vtu_text(*field.shape, {{"stiffness", field.factors}, {"deviation", field.deviations}});
}

Plot fit_plot(const Answer& answer) {
  if (!answer.tests.empty() && !has_curves(answer)) return points_plot(answer.tests.front());
  Plot plot;
  plot.title = answer.title;
  int colour = 0;
  for (const TestAnswer& test : answer.tests) {
    if (!test.data.axes.empty()) continue;
    if (colour == 0)
      plot.x = {test.data.along->name, si_unit(test.data.along->unit), false},
      plot.y = {test.data.up->name, si_unit(test.data.up->unit), false};
    PlotSeries marks{test.name, colour, PlotSeries::Kind::marks, {}}, line{"", colour, PlotSeries::Kind::line, {}};
    if (!test.counted) line.kind = PlotSeries::Kind::dashed;
    for (Eigen::Index i = 0; i < test.data.y.size(); ++i) {
      marks.points.push_back({test.data.x[i], test.data.y[i], test.name});
      if (test.line.empty() && test.fitted.size() > 0) line.points.push_back({test.data.x[i], test.fitted[i], ""});
    }
    for (const auto& [x, y] : test.line) line.points.push_back({x, y, ""});
    plot.series.push_back(std::move(marks));
    plot.series.push_back(std::move(line));
    ++colour;
  }
  return plot;
}

Plot residual_plot(const Answer& answer) {
  if (!answer.tests.empty() && !has_curves(answer)) return missed_plot(answer.tests.front());
  Plot plot;
  plot.title = answer.title + ": residuals";
  plot.y = {"fitted less measured, over " + (answer.tests.empty() ? "each value" : scale_text(answer.tests.front())),
            "%", false};
  int colour = 0;
  for (const TestAnswer& test : answer.tests) {
    if (!test.data.axes.empty()) continue;
    if (colour == 0) plot.x = {test.data.along->name, si_unit(test.data.along->unit), false};
    PlotSeries marks{test.name, colour++, PlotSeries::Kind::marked_line, {}};
    for (Eigen::Index i = 0; i < test.fitted.size(); ++i)
      marks.points.push_back({test.data.x[i], (test.fitted[i] - test.data.y[i]) / test.scale[i], test.name});
    plot.series.push_back(std::move(marks));
  }
  plot.level = 0;
  return plot;
}

Plot strategy_plot(const std::vector<Answer>& answers) {
  Plot plot;
  plot.title = "Misfit over time of the fit";
  plot.x = {"time", "s", true}, plot.y = {"rms", "%", true};
  int colour = 0;
  for (const Answer& answer : answers) {
    const std::string name = answer.strategy.empty() ? answer.scene : answer.strategy;
    if (answer.succeeded())
      plot.series.push_back({name, colour++, PlotSeries::Kind::marks, {{answer.seconds, whole_rms(answer), name}}});
  }
  return plot;
}

std::string points_csv(const Answer& answer) {
  std::string out = "test,quantity,prescribed,response,measured,fitted,residual,x,y,z,direction\n";
  for (const TestAnswer& test : answer.tests)
    for (Eigen::Index i = 0; i < test.fitted.size(); ++i) {
      out += fmt::format("{},{},{:.9g},{},{:.9g},{:.9g},{:.9g},", test.name, test.data.along->name, test.data.x[i],
                         test.data.up->name, test.data.y[i], test.fitted[i], test.fitted[i] - test.data.y[i]);
      if (test.data.axes.empty())
        out += ",,,\n";
      else
        out += fmt::format("{:.9g},{:.9g},{:.9g},{}\n", test.data.places(0, i), test.data.places(1, i),
                           test.data.places(2, i), "xyz"[test.data.axes[i]]);
    }
  return out;
}

}  // namespace elastin::lab
