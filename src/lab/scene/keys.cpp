#include "lab/scene/keys.h"

#include <fmt/format.h>

#include <cmath>

#include "elastin/core/base/units.h"
#include "lab/scene/identify.h"
#include "lab/scene/parts.h"
#include "lab/scene/pick.h"

namespace elastin::lab {
namespace {

/// "−0.99", as documents write it.
std::string number_text(double value) {
  const bool whole = value == std::floor(value) && std::abs(value) < 1e9;
  const std::string text = whole ? fmt::format("{:.0f}", value) : fmt::format("{:g}", value);
  return text.starts_with('-') ? "−" + text.substr(1) : text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// A cell of a Markdown table.
std::string cell(const std::string& text) { return text.empty() ? " |" : " " + replaced(text, "|", "\\|") + " |"; }

std::string unit_cell(const std::string& unit) { return cell(replaced(replaced(unit, "^2", "²"), "^3", "³")); }

std::vector<KeySection> experiment_sections(const ExperimentCatalog& experiments) {
  std::vector<std::string> names;
  for (const ExperimentInfo& info : experiments.experiments()) names.push_back(info.name);
  std::vector<KeySection> sections{{"experiment",
                                    "Experiment",
                                    "Each kind of experiment has keys of its own beside `kind`.",
                                    {{"kind", words_text(names), "", "", "needed", "what is done with the body"}}}};
  for (const ExperimentInfo& info : experiments.experiments())
    sections.push_back({"experiment." + info.name, "",
                        fmt::format("`kind: {}`: {}{}.", info.name, info.summary,
                                    info.in_time ? "; it runs in time and needs the key `time`" : ""),
                        keys_of(info)});
  return sections;
}

}  // namespace

std::string range_text(double low, double high, bool above_low) {
  if (!std::isfinite(low) && !std::isfinite(high)) return "";
  if (!std::isfinite(high)) return (above_low ? "> " : "≥ ") + number_text(low);
  if (!std::isfinite(low)) return "≤ " + number_text(high);
  return (above_low ? "> " : "") + number_text(low) + " … " + number_text(high);
}

std::string words_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "`" : ", `") + name + "`";
  return text;
}

SceneKey key_of(const ParameterInfo& info, const std::string& owner) {
  SceneKey key{owner + info.name, "", si_unit(info.unit), "", info.required ? "needed" : "none", info.text};
  switch (info.kind) {
    case ValueKind::number:
      key.type = info.unit == dimension::none ? "number" : "quantity";
      key.range = range_text(info.low, info.high, info.above_low);
      break;
    case ValueKind::whole:
      key.type = "whole";
      key.range = range_text(info.low, info.high, false);
      break;
    case ValueKind::vector:
      key.type = "vector";
      break;
    case ValueKind::direction:
      key.type = "direction";
      break;
    case ValueKind::molecules:
      key.type = "list of molecules, or [pick](#picked-molecules)";
      key.range = "0 … last molecule";
      break;
  }
  if (!std::isnan(info.fallback)) key.fallback = number_text(info.fallback);
  return key;
}

std::vector<KeySection> key_sections(const Catalog& catalog, const ExperimentCatalog& experiments) {
  std::vector<KeySection> all;
  for (const auto& sections :
       {scene_keys(), body_keys(), surface_keys(), fill_keys(), bodies_keys(), material_keys(catalog),
        strategy_keys(catalog), experiment_sections(experiments), gas_keys(), support_keys(), time_keys(catalog),
        load_keys(catalog), pick_keys(), initial_keys(), contact_keys(), solver_keys(catalog), expectation_keys(),
        study_keys(), identify_keys()})
    all.insert(all.end(), sections.begin(), sections.end());
  return all;
}

std::vector<std::string> owners_of(const std::string& key, const std::vector<KeySection>& sections) {
  std::vector<std::string> owners;
  for (const KeySection& section : sections) {
    const bool has =
        std::any_of(section.keys.begin(), section.keys.end(), [&](const SceneKey& own) { return own.name == key; });
    if (!has) continue;
    const std::string owner = section.path.starts_with("experiment.") ? "experiment"
                              : section.path.empty()                  ? "the scene"
                                                                      : section.path;
    if (std::find(owners.begin(), owners.end(), owner) == owners.end()) owners.push_back(owner);
  }
  if (owners.size() > 3) owners.resize(3);
  return owners;
}

std::string key_reference(const Catalog& catalog, const ExperimentCatalog& experiments) {
  std::string out;
  const std::vector<KeySection> sections = key_sections(catalog, experiments);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const KeySection& section = sections[i];
    if (!section.heading.empty()) out += "\n### " + section.heading + "\n";
    if (!section.text.empty()) out += "\n" + section.text + "\n";
    const bool shared =
        i + 1 < sections.size() && sections[i + 1].heading.empty() && sections[i + 1].keys == section.keys;
    if (section.keys.empty() || shared) continue;  // one table below both
    out += "\n| key | type | unit | range | default | meaning |\n|---|---|---|---|---|---|\n";
    for (const SceneKey& key : section.keys)
      out += "| `" + key.name + "` |" + cell(key.type) + unit_cell(key.unit) + cell(key.range) + cell(key.fallback) +
             cell(key.text) + "\n";
  }
  return out + "\n";
}

}  // namespace elastin::lab
