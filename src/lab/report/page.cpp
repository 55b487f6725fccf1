#include "lab/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "lab/report/comparison.h"
#include "lab/report/pack.h"
#include "lab/report/page_parts.h"
#include "lab/report/study.h"
#include "lab/report/summary.h"

namespace elastin::lab {
namespace {

constexpr std::size_t kMostViewBytes = 10'000'000;  // of a page; what is beyond is left out, the best strategies last
constexpr double kWide = 600, kNarrow = 360, kFile = 760;  // px, of plots: on a page, on a phone, alone

using Colours = std::map<std::string, int>;

/// Records of one scene with all that is told of them.
struct Scenery {
  std::vector<Record> records;
  Ranking ranking;
  bool study = false;
};

std::vector<Scenery> by_scene(const std::vector<Record>& records) {
  std::vector<Scenery> scenes;
  for (const Record& record : records) {
    const auto same = [&](const Scenery& scene) { return scene.records.front().scene == record.scene; };
    auto scene = std::find_if(scenes.begin(), scenes.end(), same);
    if (scene == scenes.end()) scene = scenes.insert(scenes.end(), Scenery{});
    scene->records.push_back(record);
    scene->study |= !record.variant.empty();
  }
  for (Scenery& scene : scenes) scene.ranking = rank_strategies(scene.records);
  return scenes;
}

std::string figure(const Plot& plot, const std::string& heading, const std::string& name) {
  if (plot.series.empty()) return "";
  const auto classed = [&](double width, const char* kind) {
    return svg_text(plot, width, false).insert(4, fmt::format(" class=\"{}\"", kind));
  };
  return fmt::format(
      "<section class=\"card\"><div class=\"bar\"><h2>{0}</h2><button type=\"button\" data-save=\"svg\" "
      "data-name=\"{1}\">SVG"
      "</button><button type=\"button\" data-save=\"png\" "
      "data-name=\"{1}\">PNG</button></div><figure>{2}{3}</figure></section>\n",
      escaped(heading), escaped(name), classed(kWide, "wide"), classed(kNarrow, "narrow"));
}

std::string card(const std::string& heading, const std::string& inside) {
  return "<section class=\"card\"><h2>" + escaped(heading) + "</h2>" + inside + "</section>\n";
}

/// Whether each strategy's body stands: what the solver found out about it.
Table stability_table(const Scenery& scene) {
  Table table({"strategy", "verdict", "solver", "more"});
  for (const Record& record : scene.records) {
    const Run& run = record.run;
    if (!run.suited) continue;
    const bool sound = solved(record) && run.zero_energy_modes == 0 && !run.unstable;
    const std::string verdict = !solved(record) ? outcome_text(run)
                                : run.zero_energy_modes > 0
                                    ? "mechanism: " + counted(run.zero_energy_modes, "zero-energy mode")
                                : run.unstable            ? "not stable: an equilibrium that is no minimum"
                                : run.restarted_from_rest ? "stable, from rest: the start led nowhere"
                                                          : "stable";
    table.add({{run.strategy + (record.variant.empty() ? "" : ", " + variant_text(record))},
               {verdict, sound            ? Tone::good
                         : solved(record) ? Tone::poor
                                          : Tone::bad},
               {run.solver + (run.solver_reason.empty() ? "" : ": " + run.solver_reason), Tone::faint},
               {run.cause, Tone::faint}});
  }
  return table;
}

std::string warnings_html(const Scenery& scene) {
  std::vector<std::pair<std::string, std::vector<std::string>>> said;  // what, and of whom
  for (const Record& record : scene.records)
    for (const std::string& warning : record.warnings) {
      const auto same = [&](const auto& known) { return known.first == warning; };
      auto at = std::find_if(said.begin(), said.end(), same);
      if (at == said.end()) at = said.insert(said.end(), {warning, {}});
      if (std::find(at->second.begin(), at->second.end(), record.run.strategy) == at->second.end())
        at->second.push_back(record.run.strategy);
    }
  std::string out;
  for (const auto& [warning, strategies] : said)
    out += fmt::format("<li>{} <span class=\"faint\">({})</span></li>\n", escaped(warning),
                       escaped(fmt::format("{}", fmt::join(strategies, ", "))));
  return out.empty() ? "" : card("Warnings", "<ul class=\"warnings\">" + out + "</ul>");
}

std::string head_html(const Scenery& scene) {
  const Record& first = scene.records.front();
  const auto chip = [](const std::string& text) { return "<li>" + escaped(text) + "</li>"; };
  std::string out = fmt::format("<h1>{}</h1><p class=\"faint\">{}</p><ul class=\"chips\">", escaped(first.title),
                                escaped(first.scene));
  const auto [least, most] =
      std::minmax_element(scene.records.begin(), scene.records.end(),
                          [](const auto& a, const auto& b) { return a.molecules < b.molecules; });
  out += chip(least->molecules == most->molecules
                  ? counted(first.molecules, "molecule")
                  : fmt::format("{} to {}", least->molecules, counted(most->molecules, "molecule")));
  if (least->molecules == most->molecules) {
    out += chip(counted(first.connections, "connection"));
    if (first.cells) out += chip(counted(first.cells, "cell"));
  }
  out += chip("target: " + first.prescribed) + chip(counted(first.threads, "thread"));
  out += chip(first.repeats.size() > 1 ? fmt::format("least of {} repeats", first.repeats.size()) : "one run each");
  for (const Reference& reference : first.references) out += chip("reference: " + reference_text(reference));
  out += "</ul>\n";
  const bool advised = !scene.study && scene.records.size() > 1 && can_rank(scene.records);
  if (advised || !scene.ranking.no_reference.empty())
    out += fmt::format("<p class=\"advice{}\">{}</p>\n", scene.ranking.best ? "" : " none",
                       escaped(advice_text(scene.ranking, false)));
  return out;
}

constexpr const char* kStage = R"html(<section class="card"><div class="bar"><h2>The body</h2>
<label>strategy <select data-part="strategy"></select></label>
<label>colour <select data-part="colour"><option value="tension">tension</option><option value="strain">strain</option>
<option value="displacement">displacement</option><option value="error">distance from the best</option></select></label>
<label>displacements <select data-part="scale"></select></label>
<label><input type="checkbox" data-part="connections"> connections</label>
<label><input type="checkbox" data-part="molecules"> molecules</label>
<label><input type="checkbox" data-part="surface"> surface</label>
<button type="button" data-save="png" data-name="body">PNG</button></div>
<div class="view"><canvas tabindex="0" role="img"></canvas></div>
<div class="legend"><span data-part="title"></span><span data-part="low"></span><i data-part="ramp"></i><span data-part="high"></span>
<span class="steps" data-part="steps"><button type="button" data-part="play" aria-label="play">▶</button>
<input type="range" min="0" max="0" value="0" data-part="step" aria-label="state"></span><span data-part="at"></span></div>
<p class="note hint">Drag or arrow keys turn; wheel (after a click), two fingers, + and − zoom; shift and drag, or two fingers, move; 0 or a double click resets.{}</p>
)html";

/// What a script of the page unpacks when it is needed.
std::string packed_html(const std::string& attribute, std::string_view base64_text) {
  return fmt::format("<script type=\"application/gzip\" {}>{}</script>\n", attribute, base64_text);
}

/// The body with as many strategies as there is room for, the best first; of a study the variant with most molecules.
std::string stage_html(const Scenery& scene, const std::vector<std::string>& views, std::size_t size_left) {
  struct View {
    nlohmann::json head;
    const std::string* line;
  };
  std::map<int, std::vector<View>> bodies;  // by molecules
  for (const std::string& line : views) {
    // The arrays are long, the head is not: it ends where the first array begins.
    const auto keep = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < 2; };
    nlohmann::json head = nlohmann::json::parse(line, keep, false);
    if (head.is_object() && head.value("scene", "") == scene.records.front().scene)
      bodies[head.value("molecules", 0)].push_back({std::move(head), &line});
  }
  const std::string best = scene.ranking.best ? scene.ranking.best->run.strategy : "";
  for (auto at = bodies.rbegin(); at != bodies.rend(); ++at) {
    std::string body, states, note;
    const auto add_states = [&](const View& view) {
      const std::string html = packed_html("class=\"view\"", packed(*view.line));
      if (body.size() + states.size() + html.size() < size_left) states += html;
    };
    for (const View& view : at->second)
      if (view.head["kind"] == "body") {
        body = packed_html("class=\"view\"", packed(*view.line));
        note = view.head.value("shown", "");
      }
    std::map<std::string, const View*> latest;  // a row that was cut off and run again left two
    for (const View& view : at->second)
      if (view.head["kind"] == "states") latest[view.head.value("strategy", "")] = &view;
    if (latest.contains(best)) add_states(*latest[best]);
    for (const Record& record : scene.records)
      if (const auto view = latest.find(record.run.strategy); view != latest.end() && record.run.strategy != best) {
        add_states(*view->second);
        latest.erase(view);
      }
    if (body.empty() || states.empty()) continue;
    return fmt::format(fmt::runtime(kStage), note.empty() ? "" : " Shown: " + escaped(note) + ".") + body + states +
           "</section>\n";
  }
  return "";
}

std::string scene_html(const Scenery& scene, std::size_t number, const Colours& colours, const PageMatter& matter,
                       std::size_t size_left) {
  const Record& first = scene.records.front();
  const auto mark = [&](const std::string& strategy) {
    const auto colour = colours.find(strategy);
    return plot_colour(colour == colours.end() ? -1 : colour->second);
  };
  std::string out = fmt::format("<article class=\"scene\" id=\"scene-{}\" data-best=\"{}\">", number,
                                escaped(scene.ranking.best ? scene.ranking.best->run.strategy : ""));
  out += head_html(scene);
  const std::string error = figure(error_plot(scene.records, scene.ranking, colours, matter.peers),
                                   "Error against time", first.scene + "-error");
  const Plot response = response_plot(scene.records, colours);
  out += "<div class=\"pair\">" + error +
         figure(response, response.y.title + " over " + response.x.title, first.scene + "-course") + "</div>\n";
  out += stage_html(scene, matter.views, size_left);
  if (scene.study && !scene.ranking.measures.empty())
    out += card("Time to an error", time_to_table(scene.records, scene.ranking, matter.peers).html());
  out += card("All rows", scene.study ? study_table(scene.records, scene.ranking).html(mark)
                                      : comparison_table(scene.records, scene.ranking).html(mark));
  if (const Table stability = stability_table(scene); !stability.empty())
    out += card("Stability, and the solver that was taken", stability.html(mark));
  if (const Table verdicts = verdicts_table(scene.records); !verdicts.empty())
    out += card("Held against what was expected", verdicts.html(mark));
  return out + warnings_html(scene) + "</article>\n";
}

std::string scene_choice(const std::vector<Scenery>& scenes) {
  std::string out = "<p class=\"bar\"><label>scene <select id=\"scene\">";
  for (std::size_t i = 0; i < scenes.size(); ++i)
    out += fmt::format("<option value=\"scene-{}\">{}: {}</option>", i, escaped(scenes[i].records.front().scene),
                       escaped(scenes[i].records.front().title));
  return out + "</select></label></p>\n";
}

/// By strategy over all scenes: how near it came.
std::string summary_html(const PageMatter& matter, const Colours& colours) {
  const auto mark = [&](const std::string& strategy) {
    return plot_colour(colours.contains(strategy) ? colours.at(strategy) : -1);
  };
  Table table({"strategy", "ran on", "E, median", "E, worst", "on", "Poisson's ratio, median", "worst", "time"});
  for (const StrategySummary& s : summarise(matter.records).strategies) {
    const int ran = s.bodies - s.unsuited - s.failed;
    const auto ratio = [](double v) { return number_cell(std::isfinite(v) ? fmt::format("{:.4f}", v) : "", v); };
    table.add({{s.strategy},
               number_cell(std::to_string(ran), ran),
               number_cell(percent(s.modulus.median), s.modulus.median, tone_of_error(s.modulus.median)),
               number_cell(percent(s.modulus.worst), s.modulus.worst, tone_of_error(s.modulus.worst)),
               {s.modulus.worst_scene, Tone::faint},
               ratio(s.ratio.median),
               ratio(s.ratio.worst),
               number_cell(std::isfinite(s.solve) ? fmt::format("{:.1f}", s.solve) : "", s.solve)});
  }
  return "<details class=\"card\"><summary>All scenes: errors by strategy; time of the solve over that of standard, "
         "medians</summary>" +
         table.html(mark) + "</details>\n";
}

}  // namespace

std::string page_text(const PageMatter& matter) {
  const std::vector<Scenery> scenes = by_scene(matter.records);
  const Colours colours = strategy_colours(matter.records);
  const std::string title =
      scenes.empty() ? "" : scenes.front().records.front().title + (scenes.size() > 1 ? " and others" : "");
  std::string out =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><title>" +
      escaped(title) + " — Elastin</title>\n<style>" + k_page_css +
      "</style></head>\n<body>\n<header><p class=\"brand\">Elastin · speed against error</p>";
  if (scenes.size() > 1) out += scene_choice(scenes) + summary_html(matter, colours);
  out += "</header>\n<main>\n";
  for (std::size_t i = 0; i < scenes.size(); ++i)
    out += scene_html(scenes[i], i, colours, matter, kMostViewBytes / scenes.size());
  out += fmt::format(
      "</main>\n<footer><p>{}</p><p><code>{}</code></p><p>Times: build and solve of each strategy, its body given; the "
      "least of all repeats. The best is near enough (0.1 %, or the least there is), with nothing to warn of, "
      "and then the fastest; where the measures do not tell strategies apart, the simplest.</p><p>Bodies are drawn by "
      "three.js (MIT licence).</p></footer>\n",
      escaped(matter.machine), escaped(matter.command));
  out += packed_html("id=\"three\"", base64(k_three.data(), k_three.size()));
  for (const char* script : {k_body_js, k_colours_js, k_marks_js, k_viewer_js, k_stage_js, k_page_js})
    out += fmt::format("<script>{}</script>\n", script);
  out += "</body></html>\n";
  return out;
}

std::vector<std::pair<std::string, std::string>> plot_files(const std::vector<Record>& records,
                                                            const std::vector<Peer>& peers) {
  const Colours colours = strategy_colours(records);
  std::vector<std::pair<std::string, std::string>> files;
  for (const Scenery& scene : by_scene(records)) {
    const std::string name = scene.records.front().scene;
    for (const auto& [kind, plot] : {std::pair{"error", error_plot(scene.records, scene.ranking, colours, peers)},
                                     std::pair{"course", response_plot(scene.records, colours)}})
      if (!plot.series.empty()) files.emplace_back(name + "-" + kind + ".svg", svg_text(plot, kFile, true));
  }
  return files;
}

}  // namespace elastin::lab
