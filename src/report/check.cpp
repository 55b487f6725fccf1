#include "report/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "elastin/solve/modes.h"
#include "report/table.h"

namespace elastin {
namespace {

template <class List, class Name>
std::string first_few(const List& list, Name name) {
  std::string text;
  constexpr std::size_t shown = 10;
  for (std::size_t i = 0; i < std::min(shown, list.size()); ++i) text += (i ? ", " : "") + name(list[i]);
  if (list.size() > shown) text += fmt::format(" and {} more", list.size() - shown);
  return text;
}

std::string number(int value) { return std::to_string(value); }

void add_line(std::string& out, const std::string& name, const std::string& text) {
  out += fmt::format("  {:<22}{}\n", name, text);
}

void add_shape(std::string& out, const Body& body) {
  std::vector<int> neighbours(body.size(), 0);
  for (const auto& [a, b] : body.connections.ends) ++neighbours[a], ++neighbours[b];
  const auto [least, most] = std::minmax_element(neighbours.begin(), neighbours.end());
  const Vector3 size = body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff();
  const auto metres = [](double value) { return readable(value, dimension::length); };
  add_line(out, "molecules",
           fmt::format("{}, radius {} to {}, mass {}", body.size(), metres(body.radius.minCoeff()),
                       metres(body.radius.maxCoeff()), readable(body.mass.sum(), dimension::mass)));
  add_line(out, "size", fmt::format("{} × {} × {}", metres(size.x()), metres(size.y()), metres(size.z())));
  const auto& lengths = body.connections.rest_length;
  if (lengths.empty()) return add_line(out, "connections", "none");
  const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.end());
  add_line(out, "connections",
           fmt::format("{}, {} to {} long; {} to {} a molecule, {:.1f} in the mean", body.connections.size(),
                       metres(*shortest), metres(*longest), *least, *most, 2. * body.connections.size() / body.size()));
  if (!body.tetrahedra.empty()) add_line(out, "tetrahedra", number(static_cast<int>(body.tetrahedra.size())));
  if (!body.triangles.empty()) add_line(out, "triangles", number(static_cast<int>(body.triangles.size())));
}

/// Names pieces and faults; returns whether there are none.
bool add_faults(std::string& out, const Body& body) {
  const BodyFindings findings = inspect(body);
  const auto pair_name = [&](int c) {
    const auto& [a, b] = body.connections.ends[static_cast<std::size_t>(c)];
    return fmt::format("{} ({}–{})", c, a, b);
  };
  if (findings.pieces == 1) {
    add_line(out, "pieces", "1");
  } else {
    std::map<int, std::vector<int>> members;
    for (int molecule = 0; molecule < body.size(); ++molecule)
      members[findings.piece_of[static_cast<std::size_t>(molecule)]].push_back(molecule);
    add_line(out, "PIECES", fmt::format("{}: the body hangs apart", findings.pieces));
    int shown = 0;
    for (const auto& [piece, molecules] : members)
      if (molecules.size() > 1 && ++shown <= 8)
        add_line(out, "",
                 fmt::format("piece {}: {} molecules: {}", piece, molecules.size(), first_few(molecules, number)));
  }
  const auto name_fault = [&](const char* title, const std::vector<int>& list, const auto& name) {
    if (!list.empty()) add_line(out, title, fmt::format("{}: {}", list.size(), first_few(list, name)));
  };
  name_fault("LOOSE MOLECULES", findings.loose_molecules, number);
  name_fault("NO LENGTH", findings.zero_length_connections, pair_name);
  name_fault("DUPLICATE CONNECTIONS", findings.duplicate_connections, pair_name);
  name_fault("FLAT CELLS", findings.flat_or_inverted_cells, number);
  return findings.pieces == 1 && findings.zero_length_connections.empty() && findings.duplicate_connections.empty() &&
         findings.flat_or_inverted_cells.empty();
}

void add_modes(std::string& out, Scene& scene) {
  Model model(scene.specimen.body);
  scene.experiment->hold(model);
  const ModeReport report = find_zero_energy_modes(scene.specimen.body, model.supports);
  add_line(out, "held molecules", number(static_cast<int>(model.supports.size())));
  add_line(out, "free rigid motions",
           fmt::format("{}{}", report.rigid_motions, report.rigid_motions ? " (left by the grips; no mechanism)" : ""));
  if (report.zero_energy_modes == 0 && report.counted) return add_line(out, "zero-energy modes", "0");
  add_line(out, "ZERO-ENERGY MODES",
           fmt::format("mechanism: {}{} zero-energy mode{} in {} group{}{}", report.counted ? "" : "at least ",
                       report.zero_energy_modes, report.zero_energy_modes == 1 ? "" : "s", report.modes.size(),
                       report.modes.size() == 1 ? "" : "s", report.counted ? "" : " (too large a part to count)"));
  constexpr std::size_t shown = 24;
  for (std::size_t i = 0; i < std::min(shown, report.modes.size()); ++i) add_line(out, "", report.modes[i].text);
  if (report.modes.size() > shown) add_line(out, "", fmt::format("and {} more groups", report.modes.size() - shown));
}

}  // namespace

CheckReport check_scene(Scene& scene, const Catalog& catalog) {
  const Body& body = scene.specimen.body;
  CheckReport report;
  report.text = fmt::format("{}  {}\n", scene.name, scene.title);
  add_shape(report.text, body);
  report.sound = add_faults(report.text, body);
  add_modes(report.text, scene);
  std::vector<std::string> suited, unsuited;
  for (const Strategy& strategy : catalog.strategies()) {
    const std::string why = strategy.unsuited(body);
    if (why.empty())
      suited.push_back(strategy.name);
    else
      unsuited.push_back(strategy.name + " (" + why + ")");
  }
  add_line(report.text, "strategies", fmt::format("{}", fmt::join(suited, ", ")));
  if (!unsuited.empty()) add_line(report.text, "not on this body", fmt::format("{}", fmt::join(unsuited, ", ")));
  std::string objects = fmt::format("{} experiment, 1 elasticity", scene.experiment->name());
  if (!scene.specimen.loads.empty())
    objects += fmt::format(", {} load{}", scene.specimen.loads.size(), scene.specimen.loads.size() == 1 ? "" : "s");
  add_line(report.text, "the scene builds",
           objects + (scene.statics.linear ? "; small displacements" : "; large displacements"));
  for (const std::string& warning : scene.warnings) add_line(report.text, "warning", warning);
  return report;
}

std::string catalog_text(const Catalog& catalog, bool colours) {
  std::string out = painted("Stiffness strategies", Tone::bold, colours) + "\n";
  Table strategies({"name", "kind", "what it does", "source"});
  Table parameters({"parameter", "unit", "range", "default", "meaning"});
  for (const Strategy& strategy : catalog.strategies()) {
    strategies.add(
        {{strategy.name, Tone::good}, {name_of(strategy.kind)}, {strategy.summary}, {strategy.source, Tone::faint}});
    for (const ParameterInfo& info : strategy.parameters)
      parameters.add({{strategy.name + "." + info.name},
                      {si_unit(info.unit)},
                      {fmt::format("{:g} … {:g}", info.low, info.high)},
                      {fmt::format("{:g}", info.fallback), Tone::plain, true},
                      {info.text, Tone::faint}});
  }
  out += strategies.text(colours) + "\n" + painted("Their parameters", Tone::bold, colours) + "\n" +
         parameters.text(colours);
  Table measures({"measure", "unit", "meaning"});
  for (const MeasureInfo& info : measure_list())
    measures.add({{std::string(info.name)}, {si_unit(info.unit)}, {std::string(info.text), Tone::faint}});
  return out + "\n" + painted("Measures", Tone::bold, colours) + "\n" + measures.text(colours);
}

}  // namespace elastin
