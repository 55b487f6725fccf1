#include "lab/report/json.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "elastin/core/base/error.h"

namespace elastin::lab {
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
    return {{"strategy", expectation.strategy}, {"outcome", expectation.outcome}, {"cause", expectation.cause},
            {"source", expectation.source},     {"holds", verdict.passed},        {"judged", true}};
  Json object{{"strategy", expectation.strategy}, {"measure", expectation.measure}, {"expected", expectation.value},
              {"source", expectation.source},     {"holds", verdict.passed},        {"judged", verdict.judged}};
  if (std::isfinite(verdict.measured)) object["measured"] = verdict.measured;
  if (std::isfinite(verdict.difference)) object["difference"] = verdict.difference;
  if (!verdict.judged) object["not_reproduced"] = verdict.expectation.not_reproduced;
  return object;
}

Json to_json(const Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }

Json contact_json(const contact::ContactReport& contact, const std::vector<std::string>& obstacles) {
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

/// What tells a row of a study from another, and what its error is held against.
void add_of_study(Json& object, const Record& record) {
  object["asked"] = record.prescribed;
  object["spacing"] = record.spacing;
  for (const auto& [name, prescribed] : record.main_measures)
    object["main_measures"].push_back({{"measure", name}, {"prescribed", prescribed}});
  for (const Reference& reference : record.references)
    object["references"].push_back({{"measure", reference.measure},
                                    {"value", reference.value},
                                    {"uncertainty", reference.uncertainty},
                                    {"source", reference.source}});
  for (const auto& [key, value] : record.variant) object["variant"][key] = value;
  for (const auto& [build, solve] : record.repeats) object["repeats"].push_back({build, solve});
  if (!record.repeats.empty()) object["seconds"]["median"] = record.median_seconds();
  const Run& run = record.run;
  if (!run.remark.empty()) object["remark"] = run.remark;
  for (const auto& [name, holds] :
       {std::pair{"unstable", run.unstable}, {"untangled", run.restarted_from_rest}, {"uses_cells", run.uses_cells}})
    if (holds) object[name] = true;
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
              {"halved_load_steps", run.bisected_load_steps},
              {"residual", run.residual},
              {"zero_energy_modes", run.zero_energy_modes},
              {"warnings", record.warnings},
              {"notes", record.notes}};
  add_of_study(object, record);
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

/// Null and what is missing come back as NaN.
double number(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::pair<std::string, double>> numbers(const Json& object) {
  std::vector<std::pair<std::string, double>> values;
  for (const auto& [name, value] : object.items())
    if (value.is_number()) values.emplace_back(name, value.get<double>());
  return values;
}

Measures measures_of(const Json& object) {
  Measures measures;
  for (const auto& [name, value] : numbers(object)) measures.set(name, value);
  return measures;
}

/// A point's measures stand beside when it was.
Measures measures_of_point(Json row) {
  for (const char* name : {"time", "step", "load_factor"}) row.erase(name);
  return measures_of(row);
}

Verdict verdict_of(const Json& object, const std::string& strategy) {
  Verdict verdict;
  verdict.expectation.strategy = object.value("strategy", "");
  verdict.expectation.measure = object.value("measure", "");
  verdict.expectation.outcome = object.value("outcome", "");
  verdict.expectation.cause = object.value("cause", "");
  verdict.expectation.value = number(object, "expected");
  verdict.expectation.source = object.value("source", "");
  verdict.expectation.not_reproduced = object.value("not_reproduced", "");
  verdict.strategy = strategy;
  verdict.measured = number(object, "measured");
  verdict.difference = number(object, "difference");
  verdict.passed = object.at("holds");
  verdict.judged = object.at("judged");
  return verdict;
}

void read_outcome(const Json& object, Run& run) {
  const std::string name = object.at("outcome");
  run.suited = name != kUnsuited;
  for (int outcome = 0; outcome <= static_cast<int>(Outcome::interrupted); ++outcome)
    if (name == name_of(static_cast<Outcome>(outcome))) run.outcome = static_cast<Outcome>(outcome);
  run.cause = object.value("cause", "");
  run.unstable = object.value("unstable", false);
  run.restarted_from_rest = object.value("untangled", false);
  run.uses_cells = object.value("uses_cells", false);
  run.remark = object.value("remark", "");
}

void read_time(const Json& object, Run& run) {
  TimeReport time;
  time.scheme = object.at("integrator");
  time.simulated = number(object, "simulated");
  time.seconds = number(object, "seconds");
  time.steps = object.at("steps");
  time.rejected = object.at("rejected_steps");
  time.shortest_step = number(object, "shortest_step");
  time.last_step = number(object, "last_step");
  if (object.contains("critical_step")) time.critical_step = number(object, "critical_step");
  run.time = time;
}

void read_contact(const Json& object, Record& record) {
  const auto vector = [](const Json& list) { return Vector3(list.at(0), list.at(1), list.at(2)); };
  contact::ContactReport contact;
  contact.pairs = object.at("pairs");
  contact.sticking = object.at("sticking");
  contact.largest_penetration = number(object, "largest_penetration");
  contact.area = number(object, "area");
  contact.largest_pressure = number(object, "largest_pressure");
  for (const auto& [name, force] : object.at("on_obstacles").items()) {
    record.obstacles.push_back(name);
    contact.on_obstacles.push_back(vector(force));
  }
  contact.between_pieces = vector(object.at("between_pieces"));
  contact.broad_seconds = number(object, "broad_seconds");
  contact.narrow_seconds = number(object, "narrow_seconds");
  record.run.contact = std::move(contact);
}

Run run_of(const Json& object) {
  Run run;
  run.strategy = object.at("strategy");
  run.solver = object.value("solver", "");
  run.solver_reason = object.value("solver_reason", "");
  read_outcome(object, run);
  run.measures = measures_of(object.at("measures"));
  run.build_seconds = number(object.at("seconds"), "build");
  run.solve_seconds = number(object.at("seconds"), "solve");
  run.newton_iterations = object.at("iterations");
  run.linear_iterations = object.at("linear_iterations");
  run.cut_steps = object.value("cut_steps", 0);
  run.bisected_load_steps = object.value("halved_load_steps", 0);
  run.residual = number(object, "residual");
  run.zero_energy_modes = object.value("zero_energy_modes", 0);
  if (object.contains("calibration_factor")) run.calibration_factor = object["calibration_factor"];
  if (object.contains("volume_modulus")) run.volume_modulus = object["volume_modulus"];
  if (object.contains("time")) read_time(object["time"], run);
  for (const Json& row : object.at("curve")) {
    CurvePoint point;
    point.measures = measures_of_point(row);
    point.load_factor = number(row, "load_factor");
    point.time = row.contains("time") ? number(row, "time") : 0;
    point.step = row.contains("step") ? number(row, "step") : 0;
    run.curve.push_back(std::move(point));
  }
  return run;
}

void read_what_it_stands_for(const Json& object, Record& record) {
  record.prescribed = object.value("asked", "");
  record.spacing = number(object, "spacing");
  if (object.contains("main_measures"))
    for (const Json& measure : object["main_measures"])
      record.main_measures.push_back({find_measure(measure.at("measure")).name, number(measure, "prescribed")});
  if (object.contains("references"))
    for (const Json& reference : object["references"])
      record.references.push_back({reference.at("measure"), number(reference, "value"), reference.at("source"),
                                   number(reference, "uncertainty")});
  if (object.contains("variant"))
    for (const auto& [key, value] : object["variant"].items()) record.variant.emplace_back(key, value);
  if (object.contains("repeats"))
    for (const Json& seconds : object["repeats"]) record.repeats.push_back({seconds.at(0), seconds.at(1)});
}

}  // namespace

std::string json_text(const std::vector<Record>& records) {
  Json runs = Json::array();
  for (const Record& record : records) runs.push_back(to_json(record));
  return Json{{"runs", runs}}.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string json_line(const Record& record) {
  return to_json(record).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Record record_of_json(const std::string& line) {
  try {
    const Json object = Json::parse(line);
    Record record;
    record.scene = object.at("scene");
    record.title = object.at("title");
    record.run = run_of(object);
    record.molecules = object.at("molecules");
    record.connections = object.at("connections");
    record.cell_sides = object.at("cell_sides");
    record.cells = object.at("cells");
    record.threads = object.at("threads");
    record.errors = numbers(object.at("errors"));
    record.warnings = object.at("warnings").get<std::vector<std::string>>();
    record.notes = object.value("notes", record.notes);
    if (object.contains("contact")) read_contact(object["contact"], record);
    read_what_it_stands_for(object, record);
    for (const Json& verdict : object.at("expectations"))
      record.verdicts.push_back(verdict_of(verdict, record.run.strategy));
    return record;
  } catch (const Json::exception& error) {
    throw InputError(std::string("no run of ours: ") + error.what());
  }
}

}  // namespace elastin::lab
