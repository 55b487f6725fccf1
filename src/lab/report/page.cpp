#include "lab/report/page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "lab/format/vtu.h"
#include "lab/report/comparison.h"
#include "lab/report/files.h"
#include "lab/report/machine.h"
#include "lab/report/viewer.h"

namespace elastin::lab {
namespace {

constexpr double kWide = 600, kNarrow = 360;  // px, of plots: on a page, on a phone

}  // namespace

std::string page_begin(const std::string& title, const std::string& brand) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width, initial-scale=1\"><title>" +
         escaped(title) + " — Elastin</title>\n<style>" + page_part("page.css") +
         "</style></head>\n<body>\n<header><p class=\"brand\">" + escaped(brand) + "</p>";
}

std::string page_end(const std::string& machine, const std::string& command, const std::string& note,
                     const std::string& data) {
  const std::time_t now = std::time(nullptr);
  std::tm time{};
  gmtime_r(&now, &time);
  std::string out = fmt::format("</main>\n<footer><p id=\"made\">{}, {:04}-{:02}-{:02} {:02}:{:02} UTC", program_text(),
                                time.tm_year + 1900, time.tm_mon + 1, time.tm_mday, time.tm_hour, time.tm_min);
  if (!machine.empty()) out += "; " + escaped(machine);
  out += "</p><p><code>" + escaped(command) + "</code></p>" + note + "</footer>\n" + data;
  for (const char* script : {"body.js", "colours.js", "marks.js", "graphics_painter.js", "processor_painter.js",
                             "viewer.js", "slice.js", "stage.js", "plots.js", "page.js"})
    out += fmt::format("<script>{}</script>\n", page_part(script));
  return out + "</body></html>\n";
}

std::string scene_text_html(const std::string& path) {
  std::error_code ignored;
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path, ignored)) return "";
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return "<details class=\"card\"><summary>The scene, " + escaped(path) + "</summary><pre>" + escaped(text) +
         "</pre></details>\n";
}

std::string figure_html(const Plot& plot, const std::string& heading, const std::string& name) {
  if (plot.series.empty()) return "";
  const auto classed = [&](double width, const char* kind) {
    return svg_text(plot, width, false).insert(4, fmt::format(" class=\"{}\"", kind));
  };
  return fmt::format(
      "<section class=\"card\"><div class=\"bar\"><h2>{0}</h2><button type=\"button\" data-save=\"svg\" "
      "data-name=\"{1}\">SVG"
      "</button><button type=\"button\" data-save=\"png\" "
      "data-name=\"{1}\">PNG</button></div><figure>{2}{3}</figure><script type=\"application/json\" class=\"plot\">{4}"
      "</script></section>\n",
      escaped(heading), escaped(file_name(name)), classed(kWide, "wide"), classed(kNarrow, "narrow"), plot_json(plot));
}

std::string card_html(const std::string& heading, const std::string& inside) {
  return "<section class=\"card\"><h2>" + escaped(heading) + "</h2>" + inside + "</section>\n";
}

namespace {

/// Of a page: one of a thousand molecules stays below a megabyte, larger bodies have more room. Where it is not enough,
/// strategies show fewer states, and then fewer strategies theirs, the best the last to go.
constexpr std::size_t kPageBytes = 980'000, kMostPageBytes = 10'000'000;
constexpr double kBytesOfMolecule = 950;
constexpr std::size_t kBestBytes = 60'000;    ///< of the best strategy's states, which a page of many scenes has, too
constexpr std::size_t kScriptBytes = 80'000;  // of styles and scripts, which page_text adds
constexpr double kFile = 760;                 // px, of plots alone

using Colours = std::map<std::string, int>;

/// Records of one scene with all that is reported of them.
struct Scenery {
  std::vector<Record> records;
  Ranking ranking;
  bool study = false;
};

std::vector<Scenery> by_scene(const std::vector<Record>& records) {
  std::vector<Scenery> scenes;
  for (const Record& record : records) {
    const auto same = [&](const Scenery& scene) { return scene.records.front().scene == record.scene; };
    Scenery& scene = found_or_added(scenes, same, Scenery{});
    scene.records.push_back(record);
    scene.study |= !record.variant.empty();
  }
  for (Scenery& scene : scenes) scene.ranking = rank_strategies(scene.records);
  return scenes;
}

/// Whether each strategy's body stands, and what the solver found out about it: a row for all for which it is the same.
Table stability_table(const Scenery& scene) {
  struct Finding {
    std::string verdict, solver, more;
    Tone tone;
    std::vector<std::string> runs = {};
  };
  std::vector<Finding> findings;
  for (const Record& record : scene.records) {
    const Run& run = record.run;
    if (!run.suited) continue;
    const bool sound = solved(record) && run.zero_energy_modes == 0 && !run.unstable;
    Finding finding{!solved(record)             ? outcome_text(run)
                    : run.zero_energy_modes > 0 ? "mechanism: " + counted(run.zero_energy_modes, "zero-energy mode")
                    : run.unstable              ? "not stable: an equilibrium that is no minimum"
                    : run.restarted_from_rest   ? "stable, from rest: the start led nowhere"
                                                : "stable",
                    run.solver + (run.solver_reason.empty() ? "" : ": " + run.solver_reason), run.cause,
                    sound            ? Tone::good
                    : solved(record) ? Tone::poor
                                     : Tone::bad};
    const auto same = [&](const Finding& f) {
      return f.verdict == finding.verdict && f.solver == finding.solver && f.more == finding.more;
    };
    found_or_added(findings, same, finding).runs.push_back(run_name(record));
  }
  Table table({"verdict", "solver", "more", "strategies"});
  for (const Finding& f : findings)
    table.add({{f.verdict, f.tone},
               {f.solver, Tone::faint},
               {f.more, Tone::faint},
               {fmt::format("{}", fmt::join(f.runs, ", "))}});
  return table;
}

/// Words with others that belong to each, all in the order in which they first came.
using Words = std::vector<std::pair<std::string, std::vector<std::string>>>;

void add_word(Words& words, const std::string& word, const std::string& other) {
  const auto same = [&](const auto& known) { return known.first == word; };
  const auto equal = [&](const std::string& known) { return known == other; };
  found_or_added(found_or_added(words, same, {word, {}}).second, equal, other);
}

std::string warnings_html(const Scenery& scene) {
  Words said;  // what, and of which strategies
  for (const Record& record : scene.records)
    for (const std::string& warning : record.warnings) add_word(said, warning, record.run.strategy);
  std::string out;
  for (const auto& [warning, strategies] : said)
    out += fmt::format("<li>{} <span class=\"faint\">({})</span></li>\n", escaped(warning),
                       escaped(fmt::format("{}", fmt::join(strategies, ", "))));
  return out.empty() ? "" : card_html("Warnings", "<ul class=\"warnings\">" + out + "</ul>");
}

std::string chip(const std::string& text) { return "<li>" + escaped(text) + "</li>"; }

/// What a study changes, and to what.
std::string parameter_chips(const Scenery& scene) {
  Words parameters;
  for (const Record& record : scene.records)
    for (const auto& [key, value] : record.variant) add_word(parameters, key, value);
  std::string out;
  for (const auto& [key, values] : parameters) out += chip(fmt::format("{}: {}", key, fmt::join(values, ", ")));
  return out;
}

std::string head_html(const Scenery& scene) {
  const Record& first = scene.records.front();
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
  if (have_one_target(scene.records)) out += chip("target: " + first.prescribed);
  out += parameter_chips(scene) + chip(counted(first.threads, "thread"));
  out += chip(first.repeats.size() > 1 ? fmt::format("least of {} repeats", first.repeats.size()) : "one run each");
  for (const Reference& reference : first.references)
    out += chip("reference: " + reference_text(reference, first.measure(reference.measure)));
  out += "</ul>\n";
  const bool advised = !scene.study && scene.records.size() > 1 && can_rank(scene.records);
  if (advised || !scene.ranking.no_reference.empty()) {
    const std::string advice = advice_text(scene.ranking, false);  // between line breaks, which the page would show
    out += fmt::format("<p class=\"advice{}\">{}</p>\n", scene.ranking.recommends() ? "" : " none",
                       escaped(advice.substr(1, advice.size() - 2)));
  }
  return out;
}

constexpr const char* kStage = R"html(<section class="card"><div class="bar tools"><h2>The body</h2>
<label>strategy <select data-part="strategy"></select></label>
<label>colour <select data-part="colour"></select></label>
<label>displacements <select data-part="scale"></select></label>
<label><input type="checkbox" data-part="connections"> connections</label>
<label><input type="checkbox" data-part="molecules"> molecules</label>
<label><input type="checkbox" data-part="surface"> surface</label>
<label>cut <select data-part="cut"><option value="">none</option><option>x</option><option>y</option><option>z</option></select>
<input type="range" min="0" max="1" step="0.01" value="0.5" data-part="cut_at" aria-label="place of the cut" hidden></label>
<small class="note" data-part="inside" hidden></small>
<button type="button" data-save="png" data-name="body">PNG</button></div>
<div class="view"><canvas tabindex="0" role="img"></canvas></div>
<div class="legend"><span data-part="title"></span><input data-part="low" aria-label="lowest value of the colours; empty: of itself"><i data-part="ramp"></i><input data-part="high" aria-label="highest value of the colours; empty: of itself">
<span class="steps" data-part="steps"><button type="button" data-part="play" aria-label="play">▶</button>
<input type="range" min="0" max="0" value="0" data-part="step" aria-label="state"></span><span data-part="at"></span></div>
<p class="picked" data-part="picked" role="status" hidden></p>
<p class="note hint">Drag or arrow keys turn; wheel (after a click), two fingers, + and − zoom; shift and drag, or two fingers, move; 0 or a double click resets. A click reads a molecule or a cell; the ends of the colours can be typed.{}</p>
)html";

/// What a script of the page unpacks when it is needed.
std::string packed_html(const std::string& attribute, std::string_view base64_text) {
  return fmt::format("<script type=\"application/gzip\" {}>{}</script>\n", attribute, base64_text);
}

/// A line of a view file: its text, and its head without the arrays, which are long.
struct View {
  nlohmann::json head;
  const std::string* line;
};

/// The states with at most this number of frames, evenly spread, the last among them.
std::string thinned(const std::string& line, std::size_t most) {
  nlohmann::json states = nlohmann::json::parse(line);
  nlohmann::json& frames = states["frames"];
  if (frames.size() <= most) return line;
  nlohmann::json kept = nlohmann::json::array();
  for (std::size_t i = 0; i < most; ++i) kept.push_back(frames[i * (frames.size() - 1) / (most - 1)]);
  frames = std::move(kept);
  return states.dump();
}

/// States of these strategies, as many of each as fit; the rest is omitted.
std::string states_html(const std::vector<const View*>& views, std::size_t room) {
  std::string out;
  for (const std::size_t most : {25, 13, 7, 4, 2}) {
    out.clear();
    for (std::size_t i = 0; i < views.size(); ++i) {
      const std::string html = packed_html("class=\"view\"", packed(thinned(*views[i]->line, most)));
      if (out.size() + html.size() <= room)
        out += html;
      else if (most > 2)
        break;
      if (i + 1 == views.size()) return out;
    }
  }
  return out;
}

/// The body with its strategies' states, the best first; of a study the variant with most molecules.
/// `taken`: bytes of the rest of the page.
std::string stage_html(const Scenery& scene, const std::vector<std::string>& views, std::size_t scenes,
                       std::size_t taken) {
  std::map<int, std::vector<View>> bodies;  // by molecules
  for (const std::string& line : views) {
    // The head ends where the first array begins.
    const auto keep = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < 2; };
    nlohmann::json head = nlohmann::json::parse(line, keep, false);
    if (head.is_object() && head.value("scene", "") == scene.records.front().scene)
      bodies[head.value("molecules", 0)].push_back({std::move(head), &line});
  }
  const std::string best = scene.ranking.best ? scene.ranking.best->run.strategy : "";
  bool has_states = false;
  for (auto at = bodies.rbegin(); at != bodies.rend(); ++at) {
    const auto wanted = static_cast<std::size_t>(kBytesOfMolecule * at->first);
    const std::size_t all = std::min(std::max(kPageBytes, wanted), kMostPageBytes) / scenes;
    std::string body, note;
    for (const View& view : at->second)
      if (view.head["kind"] == "body") {
        body = packed_html("class=\"view\"", packed(*view.line));
        note = view.head.value("shown", "");
      }
    std::map<std::string, const View*> latest;  // a run that was cut off and run again left two
    for (const View& view : at->second)
      if (view.head["kind"] == "states") latest[view.head.value("strategy", "")] = &view;
    has_states |= !latest.empty();
    std::vector<const View*> order;
    if (latest.contains(best)) order.push_back(latest[best]);
    for (const Record& record : scene.records)
      if (const auto view = latest.find(record.run.strategy); view != latest.end() && record.run.strategy != best) {
        order.push_back(view->second);
        latest.erase(view);
      }
    const std::size_t left = all - std::min(all, taken + body.size());
    const std::string states = states_html(order, scenes > 1 ? std::max(left, kBestBytes) : left);
    if (body.empty() || states.empty()) continue;
    return fmt::format(fmt::runtime(kStage), note.empty() ? "" : " Shown: " + escaped(note) + ".") + body + states +
           "</section>\n";
  }
  if (bodies.empty()) return "";
  return fmt::format("<p class=\"note\">The body is not drawn here: {}.</p>\n",
                     has_states ? "the page has no room for it" : "no run has come as far as that");
}

/// What a page filters the runs by.
constexpr const char* kFilter =
    R"html(<p class="bar filter"><label>outcome <select data-filter="outcome"><option value="">all</option></select></label>
<label>strategy <input type="search" data-filter="text" placeholder="part of its name"></label><span data-filter="count" role="status"></span></p>
)html";

std::string scene_html(const Scenery& scene, std::size_t number, const Colours& colours, const PageMatter& matter,
                       std::size_t scenes) {
  const Record& first = scene.records.front();
  const auto mark = [&](const std::string& series) {
    const auto colour = colours.find(series);
    return plot_colour(colour == colours.end() ? -1 : colour->second);
  };
  std::string out = fmt::format("<article class=\"scene\" id=\"scene-{}\" data-best=\"{}\" data-best-word=\"{}\">",
                                number, escaped(scene.ranking.best ? scene.ranking.best->run.strategy : ""),
                                scene.ranking.recommends() ? "best" : "nearest");
  out += head_html(scene);
  const std::string error = figure_html(error_plot(scene.records, scene.ranking, colours, matter.peers),
                                        "Error against time", first.scene + "-error");
  out += "<div class=\"pair\">" + error;
  for (std::size_t i = 0;; ++i) {
    const Plot response = response_plot(scene.records, colours, i);
    if (response.series.empty()) break;
    out += figure_html(response, response.y.title + "–" + response.x.title + " curve",
                       first.scene + "-response" + (i ? fmt::format("-{}", i + 1) : ""));
  }
  out += "</div>\n";
  if (scene.study) {
    out += "<div class=\"pair\">";
    int number_of_plot = 0;
    for (const Plot& plot : parameter_plots(scene.records, scene.ranking, colours))
      out += figure_html(plot, plot.y.title + " over " + plot.x.title,
                         fmt::format("{}-parameter-{}", first.scene, ++number_of_plot));
    out += "</div>\n";
  }
  const std::size_t before = out.size();
  if (scene.study && !scene.ranking.measures.empty())
    out += card_html("Time to an error", time_to_table(scene.records, scene.ranking, matter.peers).html());
  const Table runs =
      scene.study ? study_table(scene.records, scene.ranking) : comparison_table(scene.records, scene.ranking);
  out += card_html("All runs", (scene.records.size() > 1 ? kFilter : "") + runs.html(mark));
  if (const Table change = change_table(scene.records, matter.baseline); !change.empty())
    out += card_html("Change since " + matter.baseline_name, change.html(mark));
  if (const Table stability = stability_table(scene); !stability.empty())
    out += card_html("Stability and solver", stability.html());
  if (const Table verdicts = verdicts_table(scene.records); !verdicts.empty())
    out += card_html("Compared with expectations", verdicts.html(mark));
  out += warnings_html(scene) + scene_text_html(first.path);
  const std::size_t taken = out.size() + (k_three.size() * 4 / 3 + kScriptBytes) / scenes;
  out.insert(before, stage_html(scene, matter.views, scenes, taken));
  return out + "</article>\n";
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
  const auto card = [](const std::string& title, const std::string& html) {
    return "<details class=\"card\" open><summary>" + title + "</summary>" + html + "</details>\n";
  };
  const Table scattered = scatter_table(matter.records);
  return (scattered.empty() ? "" : card("All experiments: error over the scatter of the specimens", scattered.html())) +
         card("All scenes: errors by strategy; time of the solve over that of standard, medians", table.html(mark));
}

}  // namespace

std::string page_text(const PageMatter& matter) {
  const std::vector<Scenery> scenes = by_scene(matter.records);
  const Colours colours = strategy_colours(matter.records);
  const std::string title =
      scenes.empty() ? "" : scenes.front().records.front().title + (scenes.size() > 1 ? " and others" : "");
  std::string out = page_begin(title, "Elastin · speed against error");
  if (scenes.size() > 1) out += scene_choice(scenes) + summary_html(matter, colours);
  out += "</header>\n<main>\n";
  for (std::size_t i = 0; i < scenes.size(); ++i) out += scene_html(scenes[i], i, colours, matter, scenes.size());
  return out +
         page_end(
             matter.machine, matter.command,
             "<p>Times: build and solve of each strategy, its body given; the least of all repeats. The best is near "
             "enough (0.1 %, or the least there is), with nothing to warn of, and then the fastest; where the "
             "measures do not distinguish strategies, the simplest.</p><p>Bodies are drawn by three.js (MIT "
             "licence).</p>",
             packed_html("id=\"three\"", base64(k_three.data(), k_three.size())));
}

std::string viewer_text(const std::vector<std::string>& views, const std::vector<Record>& records) {
  const std::vector<Scenery> scenes = by_scene(records);  // rankings point into them
  const Scenery& scene = scenes.front();
  return page_begin(scene.records.front().title, "Elastin") +
         "</header><style>header,footer{display:none}</style>\n<main><article class=\"scene\" id=\"scene-0\" "
         "data-best=\"\">" +
         stage_html(scene, views, 1, 0) + "</article>\n" +
         page_end("", "", "", packed_html("id=\"three\"", base64(k_three.data(), k_three.size())));
}

std::vector<std::pair<std::string, std::string>> plot_files(const std::vector<Record>& records,
                                                            const std::vector<Peer>& peers) {
  const Colours colours = strategy_colours(records);
  std::vector<std::pair<std::string, std::string>> files;
  for (const Scenery& scene : by_scene(records)) {
    const std::string name = file_name(scene.records.front().scene);
    for (const auto& [kind, plot] : {std::pair{"error", error_plot(scene.records, scene.ranking, colours, peers)},
                                     std::pair{"response", response_plot(scene.records, colours)}})
      if (!plot.series.empty()) files.emplace_back(name + "-" + kind + ".svg", svg_text(plot, kFile, true));
  }
  return files;
}

}  // namespace elastin::lab
