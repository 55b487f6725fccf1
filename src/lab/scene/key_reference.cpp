#include "lab/scene/scene.h"

#include <fmt/format.h>

#include "core/base/named.h"
#include "elastin/core/base/units.h"
#include "lab/scene/identify.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// A cell of a Markdown table.
std::string cell(const std::string& text) { return text.empty() ? " |" : " " + replaced(text, "|", "\\|") + " |"; }

std::string unit_cell(const std::string& unit) { return cell(replaced(replaced(unit, "^2", "²"), "^3", "³")); }

std::vector<KeySection> experiment_sections(const ExperimentCatalog& experiments) {
  std::vector<KeySection> sections{
      {"experiment",
       "Experiment",
       "Each kind of experiment has keys of its own in addition to `kind`.",
       {{"kind", words_text(names_of(experiments.experiments())), "", "", "needed", "what is done with the body"}}}};
  for (const ExperimentInfo& info : experiments.experiments())
    sections.push_back({"experiment." + info.name, "",
                        fmt::format("`kind: {}`: {}{}.", info.name, info.summary,
                                    info.in_time ? "; it runs in time and needs the key `time`" : ""),
                        keys_of(info)});
  return sections;
}

std::vector<KeySection> gas_sections() {
  return {{"gas", "",
           "The `gas` of `kind: inflation`, which fills the membrane in proportion to the load:", gas_keys().rows()}};
}

}  // namespace

std::vector<KeySection> key_sections(const Catalog& catalog, const ExperimentCatalog& experiments) {
  std::vector<KeySection> all;
  for (const auto& sections :
       {scene_keys(), body_keys(), bodies_keys(), material_keys(catalog), rest_keys(), strategy_keys(catalog),
        experiment_sections(experiments), gas_sections(), support_keys(), time_keys(catalog), load_keys(catalog),
        std::vector{time_function_section()}, pick_keys(), initial_keys(), contact_keys(), solver_keys(catalog),
        expectation_keys(catalog), study_keys(catalog), identify_keys()})
    all.insert(all.end(), sections.begin(), sections.end());
  return all;
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
