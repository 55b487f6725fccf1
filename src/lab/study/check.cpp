#include "lab/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "core/base/named.h"
#include "core/shapes/surfaces.h"
#include "core/simulation/fibres.h"
#include "core/solve/modes.h"
#include "core/solve/stable_step.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/simulation/parts.h"
#include "lab/report/table.h"
#include "lab/run/common_measures.h"
#include "lab/run/load_path.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

template <class List, class Name>
std::string first_few(const List& list, Name name) {
  std::string text;
  constexpr std::size_t shown = 10;
  for (std::size_t i = 0; i < std::min(shown, list.size()); ++i) text += (i ? ", " : "") + name(list[i]);
  if (list.size() > shown) text += fmt::format(" and {} more", list.size() - shown);
  return text;
}

std::string digits(int value) { return std::to_string(value); }

void add_line(std::string& out, const std::string& name, const std::string& text) {
  out += fmt::format("  {:<21} {}\n", name, text);
}

/// "5.0000 mm", or "5.0000 mm to 7.0000 mm".
std::string span(double low, double high) {
  const std::string from = readable(low, dimension::length), to = readable(high, dimension::length);
  return from == to ? from : from + " to " + to;
}

void add_shape(std::string& out, const Body& body) {
  std::vector<int> neighbours(body.size(), 0);
  const int proper = body.connections.proper();
  for (int c = 0; c < proper; ++c)
    for (const int molecule : body.connections.ends[c]) ++neighbours[molecule];
  const auto [least, most] = std::minmax_element(neighbours.begin(), neighbours.end());
  const Vector3 size = body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff();
  const auto metres = [](double value) { return readable(value, dimension::length); };
  add_line(out, "molecules",
           fmt::format("{}, radius {}, mass {}", body.size(), span(body.radius.minCoeff(), body.radius.maxCoeff()),
                       readable(body.mass.sum(), dimension::mass)));
  add_line(out, "size", fmt::format("{} × {} × {}", metres(size.x()), metres(size.y()), metres(size.z())));
  const auto& lengths = body.connections.rest_length;
  if (lengths.empty()) return add_line(out, "connections", "none");
  const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.begin() + proper);
  add_line(out, "connections",
           proper == 0 ? "none"
                       : fmt::format("{}, {} long; {} to {} a molecule, {:.1f} in the mean", proper,
                                     span(*shortest, *longest), *least, *most, 2. * proper / body.size()));
  if (body.connections.cell_sides > 0)
    add_line(out, "sides of cells only",
             fmt::format("{} more; only strategies that work on cells use them", body.connections.cell_sides));
  for (const CellBlock& block : body.blocks) add_line(out, std::string(block.kind->plural), digits(block.size()));
  if (!body.tetrahedra.empty() && !has_blocks(body, 3))
    add_line(out, "tetrahedra", digits(static_cast<int>(body.tetrahedra.size())));
  if (!body.triangles.empty() && !has_blocks(body, 2))
    add_line(out, "triangles", digits(static_cast<int>(body.triangles.size())));
}

/// Names pieces and faults; returns whether the body is free of them.
bool add_faults(std::string& out, const Body& body, const std::string& name) {
  const BodyFindings findings = inspect(body);
  const auto pair_name = [&](int c) {
    const auto& [a, b] = body.connections.ends[c];
    return fmt::format("{} ({}–{})", c, a, b);
  };
  if (findings.pieces == 1) {
    add_line(out, "pieces" + name, "1");
  } else {
    std::map<int, std::vector<int>> members;
    for (int molecule = 0; molecule < body.size(); ++molecule) members[findings.piece_of[molecule]].push_back(molecule);
    add_line(out, "PIECES" + name, fmt::format("{}: the body is not connected", findings.pieces));
    int shown = 0;
    for (const auto& [piece, molecules] : members)
      if (molecules.size() > 1 && ++shown <= 8)
        add_line(out, "",
                 fmt::format("piece {}: {} molecules: {}", piece, molecules.size(), first_few(molecules, digits)));
  }
  const auto name_fault = [&](const char* title, const std::vector<int>& list, const auto& words) {
    if (!list.empty()) add_line(out, title, fmt::format("{}: {}", list.size(), first_few(list, words)));
  };
  name_fault("ISOLATED MOLECULES", findings.isolated_molecules, digits);
  name_fault("NO LENGTH", findings.zero_length_connections, pair_name);
  name_fault("DUPLICATE CONNECTIONS", findings.duplicate_connections, pair_name);
  name_fault("FLAT CELLS", findings.flat_or_inverted_cells, digits);
  const std::vector<int> flat = flat_triangles(body, body.rest);
  name_fault("FLAT TRIANGLES", flat, digits);
  return findings.pieces == 1 && findings.zero_length_connections.empty() && findings.duplicate_connections.empty() &&
         findings.flat_or_inverted_cells.empty() && flat.empty();
}

/// Each of several bodies, and whether all are sound. Molecules and connections go by the body's own numbers.
bool add_parts(std::string& out, const Specimen& specimen) {
  bool sound = true;
  for (const Part& part : specimen.body.parts) {
    const Body body = part_alone(specimen.body, part).body;
    std::string text = fmt::format("{} from {} on, mass {}", counted(part.count, "molecule"), part.first,
                                   readable(specimen.body.mass.segment(part.first, part.count).sum(), dimension::mass));
    if (!part.shared.empty()) text += fmt::format(", {} more by ties", part.shared.size());
    if (part.rigid) text += ", rigid";
    add_line(out, "body '" + part.name + "'", text);
    if (!part.rigid) sound &= add_faults(out, body, " of '" + part.name + "'");
  }
  if (!specimen.body.ties.empty())
    add_line(out, "ties",
             fmt::format("{} on triangles", counted(static_cast<int>(specimen.body.ties.size()), "molecule")));
  return sound;
}

/// Spheres that overlap at rest: no fault of a model that has no contact, but the user should know.
void add_overlaps(std::string& out, const std::vector<contact::Overlap>& overlaps) {
  if (overlaps.empty()) return;
  double deepest = 0;
  for (const contact::Overlap& overlap : overlaps) deepest = std::max(deepest, overlap.depth);
  const auto name = [](const contact::Overlap& overlap) { return fmt::format("{}–{}", overlap.first, overlap.second); };
  add_line(out, "overlapping spheres",
           fmt::format("{} not joined by a connection, up to {} deep: {}",
                       counted(static_cast<int>(overlaps.size()), "pair"), readable(deepest, dimension::length),
                       first_few(overlaps, name)));
}

void add_modes(std::string& out, Scene& scene) {
  Model model(scene.specimen.body);
  for (const SpecimenLoad& load : scene.specimen.loads) load.add(model);
  const auto rig = scene.experiment->rig(model);
  fix_rigid_parts(model);
  const Connections& connections = scene.specimen.body.connections;
  std::vector<char> stiff(static_cast<std::size_t>(connections.size()), 0);
  std::fill_n(stiff.begin(), connections.proper(), 1);
  ModeReport report = find_modes_in_parts(scene.specimen.body, model.supports, stiff);
  add_line(out, "fixed molecules", digits(static_cast<int>(model.supports.size())));
  add_line(out, "free rigid motions",
           fmt::format("{}{}", report.rigid_motions, report.rigid_motions ? " (left by the grips; no mechanism)" : ""));
  std::string but;
  if (report.out_of_plane > 0 &&
      stays_in_plane(scene.specimen, *scene.experiment, scene.time ? scene.time->duration : 0)) {
    but = fmt::format(" in the plane of the flat body ({} out of it, where nothing acts)", report.out_of_plane);
    report.zero_energy_modes -= report.out_of_plane;
    const Vector3 normal = plane_normal(scene.specimen.body);
    std::erase_if(report.modes,
                  [&](const ZeroEnergyMode& mode) { return std::abs(mode.direction.dot(normal)) > 1 - 1e-6; });
  }
  if (report.zero_energy_modes == 0 && report.counted) return add_line(out, "zero-energy modes", "0" + but);
  add_line(out, "ZERO-ENERGY MODES",
           fmt::format("mechanism: {}{}{} in {}{}", report.counted ? "" : "at least ",
                       counted(report.zero_energy_modes, "zero-energy mode"), but,
                       counted(static_cast<int>(report.modes.size()), "group"),
                       report.counted ? "" : " (the body is too large to count them)"));
  constexpr std::size_t shown = 24;
  for (std::size_t i = 0; i < std::min(shown, report.modes.size()); ++i) add_line(out, "", report.modes[i].text);
  if (report.modes.size() > shown)
    add_line(out, "", "and " + counted(static_cast<int>(report.modes.size() - shown), "more group"));
}

/// "connection 12 (3–9)", "cell 7": what sets the longest stable step.
std::string culprit_of(const StableStep& found, const Body& body) {
  if (found.cell >= 0) return fmt::format("cell {}", found.cell);
  if (found.connection < 0) return "nothing";
  const auto& [a, b] = body.connections.ends[found.connection];
  return fmt::format("connection {} ({}–{})", found.connection, a, b);
}

/// How each strategy of the scene would go through time, and how far an explicit step may go.
void add_steps_in_time(std::string& out, Scene& scene) {
  for (const StrategyChoice& choice : scene.strategies) {
    Run run;
    run.strategy = choice.label;
    if (!unsuited(scene.specimen, *scene.experiment, choice).empty()) continue;
    const std::optional<HeldModel> held = make_model(scene.specimen, *scene.experiment, choice, {}, run);
    if (!held) continue;
    const auto [method, reason] = chosen_stepper(*scene.time, *scene.experiment->in_time(), scene.specimen,
                                                 needs_cells(choice.strategy, scene.specimen.body));
    std::string text = method->name;
    if (!reason.empty()) text += " by default (" + reason + ")";
    const StableStep found = explained_stable_step(*held->model, state_at_rest(scene.specimen.body));
    text +=
        std::isfinite(found.step)
            ? fmt::format("; dt_crit {} of an explicit step, ω_max {:.5g} rad/s{}, set by {}",
                          readable_seconds(found.step), found.frequency,
                          found.damping_rate > 0 ? fmt::format(" and damping of {:.4g} /s", found.damping_rate) : "",
                          culprit_of(found, scene.specimen.body))
            : "; nothing limits an explicit step";
    add_line(out, "in time, " + choice.label, text);
  }
}

/// What each strategy of the scene builds in addition to the body.
void add_built(std::string& out, Scene& scene) {
  std::map<std::string, std::vector<std::string>> built;
  const Body& body = scene.specimen.body;
  for (const StrategyChoice& choice : scene.strategies) {
    const Strategy& strategy = choice.strategy;
    if (!unsuited(scene.specimen, *scene.experiment, choice).empty()) continue;
    std::string what = strategy.constants            ? "one constant for each connection"
                       : needs_cells(strategy, body) ? "the constants of each cell"
                                                     : "force densities from positions alone";
    if (strategy.needs_voronoi(body)) what += ", Voronoi cells";
    if (strategy.volume_modulus) what += ", volume groups";
    if (choice.name.calibrated) what += ", measured by linear solves";
    built[what].push_back(choice.label);
  }
  for (const auto& [what, names] : built)
    add_line(out, "built for it", fmt::format("{}: {}", what, fmt::join(names, ", ")));
}

}  // namespace

CheckReport check_scene(Scene& scene, const Catalog& catalog, const std::vector<contact::Overlap>& overlaps) {
  for (const Strategy& strategy : catalog.strategies()) prepare(scene.specimen, strategy);
  const Body& body = scene.specimen.body;
  CheckReport report;
  report.text = scene.name + (scene.title == scene.name ? "" : "  " + scene.title) + "\n";
  add_shape(report.text, body);
  report.sound = body.parts.empty() ? add_faults(report.text, body, "") : add_parts(report.text, scene.specimen);
  add_overlaps(report.text, overlaps);
  add_modes(report.text, scene);
  std::vector<std::string> suited;
  std::map<std::string, std::vector<std::string>> unsuited;  // by what they lack
  for (const Strategy& one : catalog.strategies()) {
    if (!has_constants(one, materials_of(scene.specimen))) continue;
    const Strategy strategy = in_parts(one, body, scene.specimen.materials, &catalog);
    std::string why = strategy.unsuited(body);
    if (why.empty() && !strategy.by_parts) why = material_unsuited(strategy, body, scene.specimen.material);
    (why.empty() ? suited : unsuited[why]).push_back(strategy.name);
  }
  add_line(report.text, "strategies", fmt::format("{}", fmt::join(suited, ", ")));
  for (const auto& [why, names] : unsuited)
    add_line(report.text, "not on this body", fmt::format("{} ({})", fmt::join(names, ", "), why));
  if (scene.time) add_steps_in_time(report.text, scene);
  std::string objects = fmt::format("{} experiment, 1 elasticity{}", scene.experiment->name(),
                                    scene.specimen.material.fibre ? " and the material's fibres" : "");
  if (!scene.specimen.loads.empty()) objects += ", " + counted(static_cast<int>(scene.specimen.loads.size()), "load");
  if (const auto& contact = scene.specimen.contact) {
    objects += fmt::format(
        ", contact of its {}{}{}", contact->surface == contact::ContactSurface::spheres ? "spheres" : "surface",
        contact->obstacles.empty() ? "" : " with ", joined(contact->obstacles, &contact::Obstacle::name));
  }
  add_line(report.text, "the scene builds",
           objects + (scene.statics.linear ? "; small displacements" : "; large displacements"));
  add_built(report.text, scene);
  for (const std::string& note : scene.notes) add_line(report.text, "note", note);
  for (const std::string& warning : scene.warnings) add_line(report.text, "warning", warning);
  return report;
}

namespace {

/// Without the marks of Markdown: of a link [words](address) the words stay.
std::string plain(std::string text) {
  std::erase(text, '`');
  for (std::size_t open = 0; (open = text.find('[', open)) != std::string::npos; ++open) {
    const std::size_t middle = text.find("](", open),
                      end = middle == std::string::npos ? middle : text.find(')', middle);
    if (end == std::string::npos) break;
    text = text.substr(0, open) + text.substr(open + 1, middle - open - 1) + text.substr(end + 1);
  }
  return text;
}

/// Type, unit, range, default and meaning of a key below its owner's name.
void add_key(const std::string& owner, const SceneKey& key, Table& keys) {
  keys.add({{owner.empty() ? key.name : owner + "." + key.name},
            {plain(key.type)},
            {key.unit},
            {key.range},
            {plain(key.fallback)},
            {plain(key.text), Tone::faint}});
}

void add_parameters(const Descriptor& row, Table& parameters) {
  for (const ParameterInfo& info : row.parameters) add_key(row.name, key_of(info), parameters);
}

/// Whether a title has a word, whatever its capitals.
bool has_word(const std::string& title, const std::string& word) {
  std::string own;
  for (const char letter : title + " ") {
    if (std::isalpha(static_cast<unsigned char>(letter))) {
      own += letter;
      continue;
    }
    if (std::equal(own.begin(), own.end(), word.begin(), word.end(),
                   [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); }))
      return true;
    own.clear();
  }
  return false;
}

Table parameter_table() { return Table({"parameter", "type", "unit", "range", "default", "meaning"}); }

/// Each measure with the experiments of which its text is true; "" of every run.
std::vector<std::pair<MeasureInfo, std::string>> described_measures(const ExperimentCatalog& experiments) {
  std::vector<std::pair<MeasureInfo, std::string>> rows;
  for (const ExperimentInfo& experiment : experiments.experiments())
    for (const MeasureInfo& info : experiment.measures) {
      const auto same = std::find_if(rows.begin(), rows.end(), [&](const auto& row) {
        return row.first.name == info.name && row.first.text == info.text;
      });
      if (same == rows.end())
        rows.emplace_back(info, experiment.name);
      else
        same->second += ", " + experiment.name;
    }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first.name < b.first.name; });
  for (const MeasureInfo& info : common_measures()) rows.emplace_back(info, "");
  return rows;
}

}  // namespace

std::string catalog_text(const Catalog& catalog, const ExperimentCatalog& experiments, bool colours,
                         const std::string& word) {
  std::string out;
  bool whole = word.empty();  // a table whose title has the word stays whole, with the tables that belong to it
  const auto add = [&](const std::string& title, Table table) {
    if (!word.empty() && !title.empty() && !title.starts_with("Their")) whole = has_word(title, word);
    if (!whole) table.keep_rows_with(word);
    if (table.empty()) return;
    out += (out.empty() ? "" : "\n") + (title.empty() ? "" : painted(title, Tone::bold, colours) + "\n") +
           table.text(colours);
  };
  const auto add_rows = [&](const std::string& title, const auto& rows) {
    Table names({"name", "what it does", "source"}), parameters = parameter_table();
    for (const auto& row : rows) {
      names.add({{row->name, Tone::good}, {row->summary}, {row->source, Tone::faint}});
      add_parameters(*row, parameters);
    }
    add(title, std::move(names));
    add("", std::move(parameters));
  };
  Table strategies({"name", "kind", "what it does", "source"}), parameters = parameter_table();
  for (const Strategy& strategy : catalog.strategies()) {
    strategies.add(
        {{strategy.name, Tone::good}, {name_of(strategy.kind)}, {strategy.summary}, {strategy.source, Tone::faint}});
    add_parameters(strategy, parameters);
  }
  add("Stiffness strategies", std::move(strategies));
  add("Their parameters", std::move(parameters));
  add_rows("Steppers (time.stepper)", catalog.steppers);
  add_rows("Linear solvers (solver.linear_solver)", catalog.linear_solvers);
  add_rows("Engines (solver.engine)", catalog.engines);
  add_rows("Loads (loads)", scene_loads(catalog));
  Table kinds({"experiment", "in time", "what it does", "source"}), keys = parameter_table();
  for (const ExperimentInfo& info : experiments.experiments()) {
    kinds.add({{info.name, Tone::good}, {info.in_time ? "yes" : ""}, {info.summary}, {info.source, Tone::faint}});
    for (const SceneKey& key : keys_of(info)) add_key(info.name, key, keys);
  }
  add("Experiments", std::move(kinds));
  add("Their keys", std::move(keys));
  Table measures({"measure", "unit", "meaning", "of"});
  for (const auto& [info, of] : described_measures(experiments))
    measures.add({{info.name}, {info.unit_text()}, {info.text, Tone::faint}, {of, Tone::faint}});
  add("Measures", std::move(measures));
  if (word.empty()) return out;
  // All keys of all maps would be longer than the rest: `elastin list --keys` has them.
  Table of_scenes = parameter_table();
  for (const KeySection& section : key_sections(catalog, experiments)) {
    const bool shown_above = section.path.starts_with("experiment.") || section.path == "loads";
    for (const SceneKey& key : section.keys)
      if (!shown_above) add_key(section.path, key, of_scenes);
  }
  add("Keys of a scene", std::move(of_scenes));
  return out;
}

}  // namespace elastin::lab
