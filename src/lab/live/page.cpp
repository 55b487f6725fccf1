#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/archive.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/format/vtu.h"
#include "lab/live/live.h"
#include "lab/report/page.h"
#include "lab/report/plot.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;

/// A row of a table as the page shows it in a list.
Json row(const std::string& name, const std::string& summary) { return {{"name", name}, {"summary", summary}}; }

const Parcel::NamedLoad* find_load(const Parcel& parcel, const std::string& name) {
  for (const Parcel::NamedLoad& load : parcel.loads)
    if (load.name == name) return &load;
  return nullptr;
}

double number_of(const Parcel::NamedLoad* load, const std::string& name) {
  return load && load->values.numbers.contains(name) ? load->values.numbers.at(name) : 0;
}

Json vector_json(const Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }

/// What the controls of the page begin with.
Json settings_json(const Scene& scene, const Parcel& parcel) {
  const Material& material = parcel.material;
  const Parcel::NamedLoad *gravity = find_load(parcel, "gravity"), *cells = find_load(parcel, "cell_damping");
  Json json{{"strategy", parcel.strategies.front().label},
            {"E", material.youngs_modulus},
            {"nu", material.poissons_ratio},
            {"density", material.density},
            {"phi", number_of(cells, "bulk")},
            {"psi", number_of(cells, "shear")},
            {"alpha", number_of(find_load(parcel, "rayleigh"), "mass")},
            {"gravity", vector_json(gravity ? gravity->values.vectors.at("acceleration") : Vector3(0, 0, 0))}};
  if (scene.time && scene.time->stepper) {
    json["stepper"] = (*scene.time->stepper)->name;
    if (scene.time->parameters.contains("newton_iterations"))
      json["iterations"] = scene.time->parameters.at("newton_iterations");
    if (scene.time->choice == StepChoice::fixed) json["step"] = scene.time->step;
  }
  return json;
}

/// The bodies of a scene with several materials, as far as these give them a stiffness; else none.
Json bodies_json(const Specimen& specimen) {
  Json bodies = Json::array();
  if (specimen.materials.size() < 2) return bodies;
  for (const Part& part : specimen.body.parts) {
    const Material& own = specimen.materials[static_cast<std::size_t>(part.material)];
    if (!part.rigid) bodies.push_back({{"name", part.name}, {"E", own.youngs_modulus}, {"nu", own.poissons_ratio}});
  }
  return bodies;
}

/// Why the page's test has no target, or "": what `run` says of the scene's own test, and of another one what holds
/// wherever the body is pulled.
std::string no_error(const Scene& scene, const Parcel& parcel) {
  if (!parcel.no_test.empty()) return parcel.no_test;
  if (parcel.own_test || is_stressed(scene.specimen)) return no_reference(scene);
  const std::string differs = no_one_modulus(scene.specimen);
  return differs.empty() ? make_tension(parcel.body, parcel.tension)->no_reference() : differs;
}

std::string scene_json(const Scene& scene, const Catalog& catalog, const Parcel& parcel) {
  const Material& material = parcel.material;
  const Body& body = parcel.body;
  const StaticExperiment* holding =
      scene.experiment->at_rest() ? scene.experiment->at_rest() : scene.experiment->calibration();
  Json json{{"name", scene.name},
            {"title", scene.title},
            {"experiment", scene.experiment->name()},
            {"molecules", body.size()},
            {"connections", body.connections.proper()},
            {"cells", count_cells(body)},
            {"solid", solid_cells(body) > 0 || !body.tetrahedra.empty()},
            {"viscous", !body.tetrahedra.empty() && body.blocks.empty()},  // see cell_damping
            {"membrane", !body.triangles.empty()},
            {"own_constants", material.law && !catalog.material_laws.find(material.law->law)->from_moduli},
            {"parts", body.parts.size()},
            {"bodies", bodies_json(scene.specimen)},
            {"own_load", parcel.own_load.cols() > 0},
            {"own_load_share", parcel.own_load_share},
            {"released", scene.experiment->in_time() != nullptr},
            {"held", parcel.supports.size()},
            {"axis", vector_json(parcel.tension.axis)},
            {"no_error", no_error(scene, parcel)},
            {"own_test", parcel.own_test},
            {"no_test", parcel.no_test},
            {"supports", holding && !holding->further_supports().empty()},
            {"left_out", parcel.left_out},
            {"settings", settings_json(scene, parcel)}};
  json["strategies"] = Json::array();
  for (const Parcel::Strategy& strategy : parcel.strategies)
    json["strategies"].push_back(row(strategy.label, choose_strategy(catalog, strategy.name).strategy.summary));
  json["steppers"] = Json::array();
  for (const auto& method : catalog.steppers) {
    Json one = row(method->name, method->summary);
    one["explicit"] = method->is_explicit;
    one["newton"] = std::any_of(method->parameters.begin(), method->parameters.end(),
                                [](const ParameterInfo& info) { return info.name == "newton_iterations"; });
    json["steppers"].push_back(std::move(one));
  }
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; at += 6) text.replace(at, 1, "\\u003c");
  return text;
}

std::string file_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  return text.str();
}

std::string tag(const std::string& attributes, std::string_view content) {
  return fmt::format("<script {}>{}</script>\n", attributes, content);
}

}  // namespace

WebModule load_web_module(const std::string& folder) {
  WebModule module{file_text(folder + "/elastin.js"), file_text(folder + "/elastin.wasm")};
  if (module.script.empty() || module.wasm.empty())
    throw InputError(
        "the core as WebAssembly is not in " + folder +
        ": tools/setup --web builds it, with emscripten; tools/run lab does so by itself. A folder elsewhere: "
        "--module FOLDER");
  return module;
}

std::string live_page(const Scene& scene, const Catalog& catalog, const Parcel& parcel, const WebModule& module) {
  Parcel copy = parcel;
  ByteWriter writer;
  visit(writer, copy);
  const std::vector<char> bytes = writer.take();
  Record record;
  record.scene = scene.name;
  record.molecules = parcel.body.size();
  std::string data = tag("type=\"application/json\" id=\"scene\"", scene_json(scene, catalog, parcel));
  data += tag("type=\"application/gzip\" id=\"view\"", packed(body_view(scene, record)));
  data += tag("type=\"application/gzip\" id=\"parcel\"", packed({bytes.data(), bytes.size()}));
  data += tag("type=\"application/gzip\" id=\"wasm\"", packed(module.wasm));
  data += tag("type=\"application/gzip\" id=\"three\"", base64(k_three.data(), k_three.size()));
  data += tag("type=\"text/plain\" id=\"worker\"", module.script + page_part("elastin.js") + page_part("worker.js"));
  for (const char* script : {"body.js", "colours.js", "marks.js", "graphics_painter.js", "processor_painter.js",
                             "viewer.js", "curve.js", "settings.js", "pace.js", "hand.js", "bodies.js", "lab.js"})
    data += tag("", page_part(script));
  std::string page = page_part("lab.html");
  const auto put = [&](const std::string& name, const std::string& text) {
    const std::string mark = "{{" + name + "}}";
    for (std::size_t at = 0; (at = page.find(mark, at)) != std::string::npos; at += text.size())
      page.replace(at, mark.size(), text);
  };
  put("title", escaped(scene.title));
  put("name", escaped(scene.name));
  put("css", std::string(page_part("page.css")) + page_part("lab.css"));
  put("data", data);
  return page;
}

}  // namespace elastin::lab
