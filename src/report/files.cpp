#include "report/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "contact/search.h"
#include "elastin/base/error.h"
#include "report/surface_files.h"
#include "report/vtu.h"

namespace elastin {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const std::vector<std::pair<std::string, double>>& values) {
  Json object = Json::object();
  for (const auto& [name, value] : values) object[name] = value;
  return object;
}

Json to_json(const Verdict& verdict) {
  const Expectation& expectation = verdict.expectation;
  if (!expectation.outcome.empty())
    return {{"outcome", expectation.outcome},
            {"cause", expectation.cause},
            {"source", expectation.source},
            {"holds", verdict.holds},
            {"judged", true}};
  Json object{{"measure", expectation.measure},
              {"expected", expectation.value},
              {"source", expectation.source},
              {"holds", verdict.holds},
              {"judged", verdict.judged}};
  if (std::isfinite(verdict.measured)) object["measured"] = verdict.measured;
  if (std::isfinite(verdict.difference)) object["difference"] = verdict.difference;
  if (!verdict.judged) object["not_reproduced"] = verdict.expectation.not_reproduced;
  return object;
}

Json to_json(const Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }

Json contact_json(const ContactReport& contact, const std::vector<std::string>& obstacles) {
  Json object{{"pairs", contact.pairs},
              {"sticking", contact.sticking},
              {"largest_penetration", contact.largest_penetration},
              {"area", contact.area},
              {"largest_pressure", contact.largest_pressure},
              {"on_obstacles", Json::object()},
              {"between_pieces", to_json(contact.between_pieces)},
              {"broad_seconds", contact.broad_seconds},
              {"narrow_seconds", contact.narrow_seconds}};
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    object["on_obstacles"][obstacles[i]] = to_json(contact.on_obstacles[i]);
  return object;
}

Json to_json(const Record& record) {
  const Run& run = record.run;
  Json object{{"scene", record.scene},
              {"title", record.title},
              {"strategy", run.strategy},
              {"solver", run.solver},
              {"solver_reason", run.solver_reason},
              {"outcome", outcome_name(run)},
              {"cause", run.cause},
              {"molecules", record.molecules},
              {"connections", record.connections},
              {"cell_sides", record.cell_sides},
              {"cells", record.cells},
              {"threads", record.threads},
              {"measures", to_json(run.measures.all())},
              {"errors", to_json(record.errors)},
              {"seconds", {{"build", run.build_seconds}, {"solve", run.solve_seconds}}},
              {"iterations", run.newton_iterations},
              {"linear_iterations", run.linear_iterations},
              {"cut_steps", run.cut_steps},
              {"halved_load_steps", run.halved_load_steps},
              {"residual", run.residual},
              {"zero_energy_modes", run.zero_energy_modes},
              {"warnings", record.warnings},
              {"notes", record.notes}};
  if (run.measures.stiffness_matrix) {
    object["stiffness_matrix"] = Json::array();
    for (const auto& row : run.measures.stiffness_matrix->rowwise())
      object["stiffness_matrix"].push_back(std::vector<double>(row.begin(), row.end()));
  }
  if (run.calibration_factor != 1) object["calibration_factor"] = run.calibration_factor;
  if (run.volume_modulus != 0) object["volume_modulus"] = run.volume_modulus;
  if (run.identified)
    object["identified"] = {{"polynomial", run.identified->polynomial},
                            {"up_to", run.identified->up_to},
                            {"misfit", run.identified->misfit},
                            {"standard_errors", run.identified->standard_errors},
                            {"load_curves", run.identified->evaluations}};
  if (run.time) {
    const TimeReport& time = *run.time;
    object["time"] = {{"integrator", time.scheme},       {"simulated", time.simulated},
                      {"seconds", time.seconds},         {"steps", time.steps},
                      {"rejected_steps", time.rejected}, {"shortest_step", time.shortest_step},
                      {"last_step", time.last_step}};
    if (time.seconds > 0) {
      object["time"]["steps_per_second"] = time.steps / time.seconds;
      object["time"]["real_time_factor"] = time.simulated / time.seconds;
    }
    if (time.critical_step > 0 && std::isfinite(time.critical_step))
      object["time"]["critical_step"] = time.critical_step;
  }
  if (run.contact) object["contact"] = contact_json(*run.contact, record.obstacles);
  object["curve"] = Json::array();
  for (const CurvePoint& point : run.curve) {
    Json row = to_json(point.measures.all());
    if (run.time) {
      row["time"] = point.time;
      row["step"] = point.step;
    } else {
      row["load_factor"] = point.load_factor;
    }
    object["curve"].push_back(row);
  }
  object["expectations"] = Json::array();
  for (const Verdict& verdict : record.verdicts) object["expectations"].push_back(to_json(verdict));
  return object;
}

/// A number with all its digits, or nothing: files never hold NaN.
std::string cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

/// "elongation [m]"
std::string headed(const MeasureInfo& info) {
  const std::string unit = info.unit_text();
  return std::string(info.name) + (unit.empty() ? "" : " [" + unit + "]");
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

/// One row a frame, with the measures that the run has.
std::string course_csv_text(const std::vector<CurvePoint>& rows) {
  std::vector<const MeasureInfo*> columns;
  for (const MeasureInfo& info : measure_list())
    if (std::any_of(rows.begin(), rows.end(),
                    [&](const CurvePoint& row) { return std::isfinite(row.measures.get(info.name)); }))
      columns.push_back(&info);
  std::string out = "time [s]";
  for (const MeasureInfo* info : columns) out += "," + headed(*info);
  out += ",step [s],steps,newton_iterations,linear_iterations\n";
  for (const CurvePoint& row : rows) {
    out += cell(row.time);
    for (const MeasureInfo* info : columns) out += "," + cell(row.measures.get(info->name));
    out += fmt::format(",{},{},{},{}\n", cell(row.step), row.steps, row.newton_iterations, row.linear_iterations);
  }
  return out;
}

}  // namespace

void write_whole(const std::string& path, const std::string& text) {
  const std::filesystem::path target(path);
  std::error_code problem;
  if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), problem);
  if (problem) throw InputError(path + ": cannot make its folder: " + problem.message());
  // A pipe or a device is not replaced by a file.
  const bool special = std::filesystem::exists(target, problem) && !std::filesystem::is_regular_file(target, problem);
  const std::string draft = special ? path : path + ".part";
  problem.clear();
  std::ofstream stream(draft, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream)
    problem = std::error_code(errno, std::generic_category());
  else if (!special)
    std::filesystem::rename(draft, target, problem);
  if (!problem) return;
  std::error_code ignored;
  if (!special) std::filesystem::remove(draft, ignored);
  throw InputError(path + ": cannot write: " + problem.message());
}

std::string json_text(const std::vector<Record>& records) {
  Json runs = Json::array();
  for (const Record& record : records) runs.push_back(to_json(record));
  return Json{{"runs", runs}}.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string csv_text(const std::vector<Record>& records) {
  std::vector<std::string> errors;
  for (const Record& record : records)
    for (const auto& [name, value] : record.errors)
      if (std::find(errors.begin(), errors.end(), name) == errors.end()) errors.push_back(name);
  std::string out = "scene,strategy,solver,outcome,molecules,connections,cells,threads";
  for (const MeasureInfo& info : measure_list()) out += "," + headed(info);
  for (const std::string& name : errors) out += ",error " + name;
  out += ",build [s],solve [s],iterations,linear_iterations,residual,zero_energy_modes,warnings\n";
  for (const Record& record : records) {
    const Run& run = record.run;
    out += fmt::format("{},{},{},{},{},{},{},{}", csv_field(record.scene), csv_field(run.strategy), run.solver,
                       outcome_name(run), record.molecules, record.connections, record.cells, record.threads);
    for (const MeasureInfo& info : measure_list()) out += "," + cell(run.measures.get(info.name));
    for (const std::string& name : errors) out += "," + cell(record.error(name));
    std::string notes = run.cause;
    for (const std::string& warning : record.warnings) notes += (notes.empty() ? "" : "; ") + warning;
    out +=
        fmt::format(",{},{},{},{},{},{},{}\n", cell(run.build_seconds), cell(run.solve_seconds), run.newton_iterations,
                    run.linear_iterations, cell(run.residual), run.zero_energy_modes, csv_field(notes));
  }
  return out;
}

std::string curve_csv_text(const Record& record) {
  if (record.run.time) return course_csv_text(record.run.curve);
  std::string out = "load_factor";
  for (const MeasureInfo& info : measure_list()) out += "," + headed(info);
  out += ",newton_iterations,linear_iterations,residual\n";
  for (const CurvePoint& point : record.run.curve) {
    out += cell(point.load_factor);
    for (const MeasureInfo& info : measure_list()) out += "," + cell(point.measures.get(info.name));
    out += fmt::format(",{},{},{}\n", point.newton_iterations, point.linear_iterations, cell(point.residual));
  }
  return out;
}

std::string vtu_text(const Body& body, const Snapshot& shot, const VectorX& constants) {
  const int n = body.size(), m = body.connections.size();
  const auto& [ends, rest_length, _] = body.connections;
  const Positions& positions = shot.positions;
  VectorX length(m);
  Positions force = Positions::Zero(3, n);
  for (int c = 0; c < m; ++c) {
    const Vector3 d = positions.col(ends[c][1]) - positions.col(ends[c][0]);
    length[c] = d.norm();
    force.col(ends[c][0]) += shot.densities[c] * d;
    force.col(ends[c][1]) -= shot.densities[c] * d;
  }
  std::string out = vtu_head(n, m) + "<Points>\n";
  VtuArrays arrays(out);
  arrays.add("positions", "Float64", 3, n, [&](int i, int k) { return positions(k, i); });
  out += "</Points>\n<PointData Vectors=\"displacement\">\n";
  arrays.add("displacement", "Float64", 3, n, [&](int i, int k) { return positions(k, i) - body.rest(k, i); });
  arrays.add("elastic_force", "Float64", 3, n, [&](int i, int k) { return force(k, i); });
  arrays.add("radius", "Float64", 1, n, [&](int i, int) { return body.radius[i]; });
  arrays.add("mass", "Float64", 1, n, [&](int i, int) { return body.mass[i]; });
  if (shot.contact_pressure.size()) {
    arrays.add("contact_pressure", "Float64", 1, n, [&](int i, int) { return shot.contact_pressure[i]; });
    arrays.add("contact_force", "Float64", 3, n, [&](int i, int k) { return shot.contact_forces(k, i); });
  }
  out += "</PointData>\n<CellData Scalars=\"strain\">\n";
  arrays.add("strain", "Float64", 1, m,
             [&](int c, int) { return rest_length[c] > 0 ? length[c] / rest_length[c] - 1 : 0; });
  arrays.add("tension", "Float64", 1, m, [&](int c, int) { return shot.densities[c] * length[c]; });
  arrays.add("force_density", "Float64", 1, m, [&](int c, int) { return shot.densities[c]; });
  if (constants.size()) arrays.add("constant", "Float64", 1, m, [&](int c, int) { return constants[c]; });
  out += "</CellData>\n<Cells>\n";
  arrays.add("connectivity", "Int32", 2, m, [&](int c, int k) { return ends[c][k]; });
  arrays.add("offsets", "Int32", 1, m, [&](int c, int) { return 2 * c + 2; });
  arrays.add("types", "UInt8", 1, m, [](int, int) { return 3; });
  return out + "</Cells>\n" + kVtuEnd;
}

void write_states(const std::string& folder, const std::string& name, const Body& body, const Run& run,
                  const std::vector<Obstacle>& obstacles) {
  std::string collection = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  const auto file_of = [&](const char* part, std::size_t number) {
    return fmt::format("{}{}-{:03}.vtu", name, part, number);
  };
  int part = 0;
  const auto list = [&](double at, const std::string& file) {
    const std::string number = part ? fmt::format(" part=\"{}\"", part) : "";
    collection += fmt::format("<DataSet timestep=\"{}\"{} file=\"{}\"/>\n", at, number, file);
  };
  const auto write = [&](double at, const std::string& file, const std::string& text) {
    write_whole(folder + "/" + file, text);
    list(at, file);
  };
  // A run that goes on from a restart file shows the frames before as well, where they still stand.
  const std::size_t first = run.snapshots.empty() ? 0 : static_cast<std::size_t>(run.snapshots.front().number);
  constexpr const char* parts[] = {"", "-surface", "-obstacles"};
  for (std::size_t frame = 0; run.time && frame < std::min(first, run.curve.size()); ++frame)
    for (part = 0; part < 3; ++part)
      if (std::filesystem::exists(folder + "/" + file_of(parts[part], frame)))
        list(run.curve[frame].time, file_of(parts[part], frame));
  // Of every frame of a run in time that would be as much again; contact is worth it.
  const bool contact = !run.snapshots.empty() && run.snapshots.front().contact_pressure.size() > 0;
  const Cells<3> surface = contact || !run.time ? surface_triangles(body) : Cells<3>{};
  for (const Snapshot& shot : run.snapshots) {
    const auto number = static_cast<std::size_t>(shot.number);
    part = 0;
    write(shot.at, file_of(parts[part], number), vtu_text(body, shot, run.constants));
    part = 1;
    if (!surface.empty()) write(shot.at, file_of(parts[part], number), surface_vtu_text(body, surface, shot));
    part = 2;
    const Vector3 low = shot.positions.rowwise().minCoeff(), high = shot.positions.rowwise().maxCoeff();
    if (!shot.obstacles.empty())
      write(shot.at, file_of(parts[part], number), obstacles_vtu_text(obstacles, shot.obstacles, low, high));
  }
  write_whole(folder + "/" + name + ".pvd", collection + "</Collection>\n</VTKFile>\n");
}

}  // namespace elastin
