#include "lab/report/records.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;
using Named = std::vector<std::pair<std::string, double>>;

// How single values stand in JSON. What is not finite is written as null, which comes back as NaN.

template <class Value>
Json written(const Value& value) {
  return value;
}
Json written(const Named& values) {
  Json object = Json::object();
  for (const auto& [name, value] : values) object[name] = value;
  return object;
}
Json written(const std::vector<std::pair<std::string, std::string>>& values) {
  Json object = Json::object();
  for (const auto& [name, value] : values) object[name] = value;
  return object;
}
Json written(const Gradients& gradients) {
  Json object = Json::object();
  for (const auto& [measure, slopes] : gradients) object[measure] = written(slopes);
  return object;
}
Json written(const Measures& measures) { return written(measures.all()); }
Json written(const Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }
Json written(const Stiffness6& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

template <class Value>
void read(const Json& json, Value& value) {
  json.get_to(value);
}
void read(const Json& json, double& value) {
  value = json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}
void read(const Json& json, Named& values) {
  values.clear();
  for (const auto& [name, value] : json.items())
    if (value.is_number()) values.emplace_back(name, value.get<double>());
}
void read(const Json& json, std::vector<std::pair<std::string, std::string>>& values) {
  values.clear();
  for (const auto& [name, value] : json.items()) values.emplace_back(name, value.get<std::string>());
}
void read(const Json& json, Gradients& gradients) {
  for (const auto& [measure, slopes] : json.items()) read(slopes, gradients.emplace_back(measure, Named()).second);
}
/// The present name of a measure that an earlier version may have written.
std::string present_name(const std::string& name) {
  const MeasureInfo* info = built_in_measures().find(name);
  return info ? info->name : name;
}

void read(const Json& json, Measures& measures) {
  Named values;
  read(json, values);
  for (const auto& [name, value] : values) measures.set(present_name(name), value);
}
void read(const Json& json, Vector3& vector) { vector = Vector3(json.at(0), json.at(1), json.at(2)); }
void read(const Json& json, Stiffness6& matrix) {
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      read(json.at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(column)), matrix(row, column));
}

// One list of fields serves both ways: a FieldWriter puts each into an object, a FieldReader takes it from there.

class FieldWriter {
 public:
  static constexpr bool reads = false;
  /// `whole`: also what only the journal keeps, so that a record comes back as it was.
  FieldWriter(Json& object, bool whole) : object_(object), whole_(whole) {}

  template <class Value>
  void field(const char* key, const Value& value) {
    object_[key] = written(value);
  }
  template <class Value>
  void renamed(const char* key, const char*, const Value& value) {
    field(key, value);
  }
  /// Only where it is worth it; it comes back as it is by default otherwise.
  template <class Value>
  void field_if(bool worth, const char* key, const Value& value) {
    if (worth) field(key, value);
  }
  template <class Value>
  void kept(const char* key, const Value& value) {
    if (whole_) field(key, value);
  }
  /// Follows from other fields: is written and never read.
  template <class Value>
  void derived(bool worth, const char* key, const Value& value) {
    if (worth) field(key, value);
  }
  template <class Fields>
  void object(const char* key, const Fields& fields) {
    Json& inner = object_[key];
    if (inner.is_null()) inner = Json::object();
    FieldWriter writer(inner, whole_);
    fields(writer);
  }
  template <class Value, class Fields>
  void optional(const char* key, const std::optional<Value>& value, const Fields& fields) {
    if (value) object(key, [&](FieldWriter& writer) { fields(writer, *value); });
  }
  template <class List, class Fields>
  void list(bool worth, const char* key, const List& list, const Fields& fields) {
    if (!worth) return;
    object_[key] = Json::array();
    for (const auto& item : list) {
      Json inner = Json::object();
      FieldWriter writer(inner, whole_);
      fields(writer, item);
      object_[key].push_back(std::move(inner));
    }
  }
  template <class Fields>
  void kept_object(const char* key, const Fields& fields) {
    if (whole_) object(key, fields);
  }
  Json& json() { return object_; }

 private:
  Json& object_;
  bool whole_;
};

class FieldReader {
 public:
  static constexpr bool reads = true;
  explicit FieldReader(const Json& object) : object_(object) {}

  template <class Value>
  void field(const char* key, Value& value) {
    read(object_.at(key), value);
  }
  /// Of results of earlier versions by its former name.
  template <class Value>
  void renamed(const char* key, const char* former, Value& value) {
    field(object_.contains(key) ? key : former, value);
  }
  template <class Value>
  void field_if(bool, const char* key, Value& value) {
    if (object_.contains(key)) read(object_[key], value);
  }
  template <class Value>
  void kept(const char* key, Value& value) {
    field_if(true, key, value);
  }
  template <class Value>
  void derived(bool, const char*, const Value&) {}
  template <class Fields>
  void object(const char* key, const Fields& fields) {
    FieldReader reader(object_.at(key));
    fields(reader);
  }
  template <class Value, class Fields>
  void optional(const char* key, std::optional<Value>& value, const Fields& fields) {
    if (!object_.contains(key)) return;
    FieldReader reader(object_[key]);
    fields(reader, value.emplace());
  }
  template <class List, class Fields>
  void list(bool, const char* key, List& list, const Fields& fields) {
    if (!object_.contains(key)) return;
    for (const Json& inner : object_[key]) {
      FieldReader reader(inner);
      fields(reader, list.emplace_back());
    }
  }
  template <class Fields>
  void kept_object(const char* key, const Fields& fields) {
    if (object_.contains(key)) object(key, fields);
  }
  const Json& json() const { return object_; }

 private:
  const Json& object_;
};

void outcome_fields(FieldWriter& io, const Run& run) { io.field("outcome", outcome_name(run)); }
void outcome_fields(FieldReader& io, Run& run) {
  std::string name;
  io.field("outcome", name);
  run.suited = name != kUnsuited;
  for (int outcome = 0; outcome <= static_cast<int>(Outcome::interrupted); ++outcome)
    if (name == name_of(static_cast<Outcome>(outcome))) run.outcome = static_cast<Outcome>(outcome);
}

/// Forces by the obstacles' names, which the record has.
void obstacle_fields(FieldWriter& io, const contact::ContactReport& contact, const std::vector<std::string>& names) {
  io.json()["on_obstacles"] = Json::object();
  for (std::size_t i = 0; i < names.size(); ++i) io.json()["on_obstacles"][names[i]] = written(contact.on_obstacles[i]);
}
void obstacle_fields(FieldReader& io, contact::ContactReport& contact, std::vector<std::string>& names) {
  names.clear();
  for (const auto& [name, force] : io.json().at("on_obstacles").items()) {
    names.push_back(name);
    read(force, contact.on_obstacles.emplace_back());
  }
}

void stiffness_field(FieldWriter& io, const std::optional<Stiffness6>& matrix) {
  if (matrix) io.field("stiffness_matrix", *matrix);
}
void stiffness_field(FieldReader& io, std::optional<Stiffness6>& matrix) {
  if (io.json().contains("stiffness_matrix")) io.field("stiffness_matrix", matrix.emplace());
}

/// Of the spring constants only the least: whether there are any, and negative ones.
void least_constant_field(FieldWriter& io, const Run& run) {
  if (run.constants.size() > 0) io.kept("least_constant", run.constants.minCoeff());
}
void least_constant_field(FieldReader& io, Run& run) {
  double least = std::nan("");
  io.kept("least_constant", least);
  if (std::isfinite(least)) run.constants = VectorX::Constant(1, least);
}

/// The texts of the measures that a record has, and the axes of its response, for a page made of the journal.
void measure_fields(FieldWriter& io, const Record& record) {
  if (!record.measures) return;
  Json rows = Json::array(), response = Json::array();
  for (const MeasureInfo& info : *record.measures)
    rows.push_back({info.name,
                    {info.unit.length, info.unit.mass, info.unit.time},
                    info.text,
                    static_cast<int>(info.role),
                    info.symbol,
                    info.unit_name,
                    info.former});
  for (const ResponseAxes& axes : record.measures->response)
    response.push_back({axes.x, axes.y, axes.from_zero, axes.y_title});
  io.kept("measure_list", rows);
  io.kept("response", response);
}
void measure_fields(FieldReader& io, Record& record) {
  Json rows, response;
  io.kept("measure_list", rows);
  io.kept("response", response);
  if (rows.is_null()) return;
  MeasureList list;
  for (const Json& row : rows)
    list.add({MeasureInfo{row.at(0),
                          {row.at(1).at(0), row.at(1).at(1), row.at(1).at(2)},
                          row.at(2),
                          static_cast<MeasureRole>(row.at(3).get<int>()),
                          row.at(4),
                          row.at(5),
                          row.at(6)}});
  for (const Json& axes : response)
    list.response.push_back({axes.at(0), axes.at(1), axes.at(2), axes.size() > 3 ? axes.at(3) : Json("")});
  record.measures = std::make_shared<const MeasureList>(std::move(list));
}

/// A point's measures stand next to its time or load factor.
void point_fields(FieldWriter& io, const CurvePoint& point) { io.json() = written(point.measures); }
void point_fields(FieldReader& io, CurvePoint& point) {
  Json row = io.json();
  for (const char* name : {"time", "step", "load_factor", "gradients"}) row.erase(name);
  read(row, point.measures);
}

template <class Io, class Point>
void curve_fields(Io& io, Point& point, bool in_time) {
  point_fields(io, point);
  io.field_if(in_time, "time", point.time);
  io.field_if(in_time, "step", point.step);
  io.field_if(!in_time, "load_factor", point.load_factor);
  io.field_if(!point.gradients.empty(), "gradients", point.gradients);
  io.kept_object("solver", [&](auto& inner) {
    inner.field("load_factor", point.load_factor);
    inner.field("newton_iterations", point.newton_iterations);
    inner.field("linear_iterations", point.linear_iterations);
    inner.field("residual", point.residual);
    inner.field("steps", point.steps);
  });
}

template <class Io, class Budget>
void budget_fields(Io& io, Budget& budget) {
  io.field("budget", budget.budget);
  io.field("effort", budget.effort);
  io.field("least", budget.least);
  io.field("median", budget.median);
  io.field("most", budget.most);
  io.field("median_seconds", budget.median_seconds);
  io.field("longest_seconds", budget.longest_seconds);
  io.field("late", budget.late);
  io.field("iteration_error", budget.iteration_error);
  io.field("motion", budget.motion);
}

template <class Io, class Time>
void time_fields(Io& io, Time& time) {
  io.renamed("stepper", "integrator", time.stepper);
  io.field("simulated", time.simulated);
  io.field("seconds", time.seconds);
  io.field("steps", time.steps);
  io.field("rejected_steps", time.rejected);
  io.field("shortest_step", time.shortest_step);
  io.field("last_step", time.last_step);
  io.derived(time.seconds > 0, "steps_per_second", time.steps / time.seconds);
  io.derived(time.seconds > 0, "real_time_factor", time.simulated / time.seconds);
  io.field_if(time.critical_step > 0 && std::isfinite(time.critical_step), "critical_step", time.critical_step);
  io.kept("frequency", time.frequency);
  io.kept("reason", time.reason);
  io.kept("resumed", time.resumed);
  io.optional("budget", time.budget, [](auto& inner, auto& budget) { budget_fields(inner, budget); });
}

template <class Io, class Engine>
void engine_fields(Io& io, Engine& engine) {
  io.field("version", engine.version);
  io.field("constants", engine.constants);
  io.field("time_step", engine.time_step);
  io.field("iterations", engine.iterations);
  io.field("steps", engine.steps);
  io.field("seconds_per_step", engine.seconds_per_step);
  io.field("name", engine.name);
}

template <class Io, class Contact, class Names>
void contact_fields(Io& io, Contact& contact, Names& obstacles) {
  io.field("pairs", contact.pairs);
  io.field("sticking", contact.sticking);
  io.field("largest_penetration", contact.largest_penetration);
  io.field("area", contact.area);
  io.field("largest_pressure", contact.largest_pressure);
  obstacle_fields(io, contact, obstacles);
  io.field("between_pieces", contact.between_pieces);
  io.field("broad_seconds", contact.broad_seconds);
  io.field("narrow_seconds", contact.narrow_seconds);
}

template <class Io, class Found>
void identified_fields(Io& io, Found& found) {
  io.field("polynomial", found.polynomial);
  io.field("up_to", found.up_to);
  io.field("misfit", found.misfit);
  io.field("standard_errors", found.standard_errors);
  io.field("load_curves", found.evaluations);
}

template <class Io, class AnyVerdict>
void verdict_fields(Io& io, AnyVerdict& verdict) {
  auto& wanted = verdict.expectation;
  io.field("strategy", wanted.strategy);
  const bool of_outcome = !wanted.outcome.empty();
  io.field_if(of_outcome, "outcome", wanted.outcome);
  io.field_if(of_outcome, "cause", wanted.cause);
  io.field_if(!of_outcome, "measure", wanted.measure);
  io.field_if(!of_outcome, "expected", wanted.value);
  io.field("source", wanted.source);
  io.field("holds", verdict.passed);
  io.derived(of_outcome, "judged", true);
  io.field_if(!of_outcome, "judged", verdict.judged);
  io.field_if(!of_outcome && std::isfinite(verdict.measured), "measured", verdict.measured);
  io.field_if(!of_outcome && std::isfinite(verdict.difference), "difference", verdict.difference);
  io.field_if(!of_outcome && !verdict.judged, "not_reproduced", wanted.not_reproduced);
  io.kept_object("kept", [&](auto& inner) {
    inner.field("run", verdict.strategy);
    inner.field("value", wanted.value);
    inner.field("relative", wanted.relative);
    inner.field("absolute", wanted.absolute);
    inner.field("not_reproduced", wanted.not_reproduced);
    inner.field("judged", verdict.judged);
    inner.field("measured", verdict.measured);
    inner.field("difference", verdict.difference);
  });
}

template <class Io, class Errors>
void direction_fields(Io& io, Errors& errors) {
  io.field_if(!errors.measured(), "not_measured", errors.trouble);
  if (!errors.measured()) return;
  io.object("youngs_modulus", [&](auto& inner) {
    inner.field("x", errors.youngs[0]);
    inner.field("y", errors.youngs[1]);
    inner.field("z", errors.youngs[2]);
    inner.field("least", errors.least_youngs);
    inner.field("largest", errors.largest_youngs);
  });
  io.object("shear_modulus", [&](auto& inner) {
    inner.field("least", errors.least_shear);
    inner.field("largest", errors.largest_shear);
  });
}

/// What distinguishes a run of a study from another, and what its error is compared with.
template <class Io, class AnyRecord>
void study_fields(Io& io, AnyRecord& record) {
  io.field("asked", record.prescribed);
  io.field("spacing", record.spacing);
  io.list(!record.main_measures.empty(), "main_measures", record.main_measures, [](auto& inner, auto& measure) {
    inner.field("measure", measure.name);
    inner.field("prescribed", measure.prescribed);
    inner.field_if(std::isfinite(measure.strain), "strain", measure.strain);
  });
  io.list(!record.references.empty(), "references", record.references, [](auto& inner, auto& reference) {
    inner.field("measure", reference.measure);
    inner.field("value", reference.value);
    inner.field("uncertainty", reference.uncertainty);
    inner.field("source", reference.source);
    inner.field_if(reference.computed, "computed", reference.computed);
    inner.field_if(reference.computed, "seconds", reference.seconds);
    inner.field_if(reference.scatter > 0, "scatter", reference.scatter);
    inner.field_if(!reference.points.empty(), "along", reference.along);
    inner.field_if(!reference.points.empty(), "points", reference.points);
  });
  io.field_if(!record.variant.empty(), "variant", record.variant);
  io.field_if(!record.repeats.empty(), "repeats", record.repeats);
  io.object("seconds", [&](auto& inner) { inner.derived(!record.repeats.empty(), "median", record.median_seconds()); });
  auto& run = record.run;
  io.field_if(!run.remark.empty(), "remark", run.remark);
  io.field_if(record.apparent, "apparent", record.apparent);
  io.field_if(!record.no_reference.empty(), "no_reference", record.no_reference);
  io.field_if(run.unstable, "unstable", run.unstable);
  io.field_if(run.restarted_from_rest, "untangled", run.restarted_from_rest);
  io.field_if(run.uses_cells, "uses_cells", run.uses_cells);
}

/// All of a record but its states and its constants, of which the journal's lines hold the least.
template <class Io, class AnyRecord>
void record_fields(Io& io, AnyRecord& record) {
  auto& run = record.run;
  io.field("scene", record.scene);
  io.field("title", record.title);
  if constexpr (Io::reads)
    io.field("strategy", run.strategy);
  else  // of an engine that whose constants it had
    io.field("strategy", run.engine && !run.engine->constants.empty() ? run.engine->constants : run.strategy);
  io.derived(run.engine.has_value(), "engine", run.strategy);
  io.optional("engine_run", run.engine, [&](auto& inner, auto& engine) {
    engine_fields(inner, engine);
    if constexpr (Io::reads) run.strategy = engine.name;
  });
  io.field("solver", run.solver);
  io.field("solver_reason", run.solver_reason);
  outcome_fields(io, run);
  io.field("cause", run.cause);
  io.field("molecules", record.molecules);
  io.field("connections", record.connections);
  io.field("cell_sides", record.cell_sides);
  io.field("cells", record.cells);
  io.field("threads", record.threads);
  io.field("measures", run.measures);
  io.field_if(!run.gradients.empty(), "gradients", run.gradients);
  io.field_if(!record.spreads.empty(), "uncertainty", record.spreads);
  io.field("errors", record.errors);
  io.object("seconds", [&](auto& inner) {
    inner.field("build", run.build_seconds);
    inner.field("solve", run.solve_seconds);
  });
  io.field("iterations", run.newton_iterations);
  io.field("linear_iterations", run.linear_iterations);
  io.field("cut_steps", run.cut_steps);
  io.field("halved_load_steps", run.bisected_load_steps);
  io.field("residual", run.residual);
  io.field("zero_energy_modes", run.zero_energy_modes);
  io.field("warnings", record.warnings);
  io.field("notes", record.notes);
  study_fields(io, record);
  stiffness_field(io, run.measures.stiffness_matrix);
  io.field_if(run.calibration_factor != 1, "calibration_factor", run.calibration_factor);
  io.field_if(run.calibrated_to_reference, "calibrated_to_reference", run.calibrated_to_reference);
  io.field_if(run.volume_modulus != 0, "volume_modulus", run.volume_modulus);
  io.optional("identified", run.identified, [](auto& inner, auto& found) { identified_fields(inner, found); });
  io.optional("direction_errors", record.directions,
              [](auto& inner, auto& errors) { direction_fields(inner, errors); });
  io.optional("time", run.time, [](auto& inner, auto& time) { time_fields(inner, time); });
  io.optional("contact", run.contact,
              [&](auto& inner, auto& contact) { contact_fields(inner, contact, record.obstacles); });
  io.list(true, "curve", run.curve,
          [&](auto& inner, auto& point) { curve_fields(inner, point, run.time.has_value()); });
  io.list(true, "expectations", record.verdicts, [](auto& inner, auto& verdict) { verdict_fields(inner, verdict); });
  io.kept("path", record.path);
  io.kept("order", run.order);
  io.kept("obstacles", record.obstacles);
  io.kept("extent", record.extent);
  io.kept("run_warnings", run.warnings);
  io.kept_object("neighbours", [&](auto& inner) {
    inner.field("mean", record.neighbours.mean);
    inner.field("least", record.neighbours.least);
  });
  least_constant_field(io, run);
  measure_fields(io, record);
}

Json object_of(const Record& record, bool whole) {
  Json object = Json::object();
  FieldWriter writer(object, whole);
  record_fields(writer, record);
  return object;
}

/// Each reference of each scene once.
Json references_of(const std::vector<Record>& records) {
  Json all = Json::array();
  for (const Record& record : records)
    for (const Reference& reference : record.references) {
      Json one{{"scene", record.scene},
               {"measure", reference.measure},
               {"value", written(reference.value)},
               {"uncertainty", reference.uncertainty},
               {"source", reference.source},
               {"seconds", reference.seconds}};
      if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(std::move(one));
    }
  return all;
}

/// Without what differs from run to run of one and the same row.
Json without_times(const Json& json) {
  constexpr std::array<std::string_view, 8> circumstances{"seconds",          "repeats",       "steps_per_second",
                                                          "real_time_factor", "broad_seconds", "narrow_seconds",
                                                          "threads",          "path"};
  Json kept = json.is_object() ? Json::object() : json.is_array() ? Json::array() : json;
  if (json.is_array())
    for (const Json& item : json) kept.push_back(without_times(item));
  if (json.is_object())
    for (const auto& [key, value] : json.items())
      if (std::find(circumstances.begin(), circumstances.end(), key) == circumstances.end())
        kept[key] = without_times(value);
  return kept;
}

}  // namespace

std::string json_text(const std::vector<Record>& records) {
  Json runs = Json::array();
  for (const Record& record : records) runs.push_back(object_of(record, false));
  return Json{{"runs", runs}, {"references", references_of(records)}}.dump(1, ' ', false,
                                                                           Json::error_handler_t::replace) +
         "\n";
}

std::string json_line(const Record& record) {
  return object_of(record, true).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Record record_of_json(const std::string& line) {
  try {
    const Json object = Json::parse(line);
    Record record;
    FieldReader reader(object);
    record_fields(reader, record);
    return record;
  } catch (const Json::exception& error) {
    throw InputError(std::string("not an Elastin run record: ") + error.what());
  }
}

std::string disagreement(const Record& one, const Record& other) {
  const Json first = without_times(object_of(one, true)).flatten(),
             second = without_times(object_of(other, true)).flatten();
  const auto value_of = [](const Json& json, const std::string& path) {
    return json.contains(path) ? json.at(path).dump(-1, ' ', false, Json::error_handler_t::replace) : "nothing";
  };
  for (const Json* json : {&first, &second})
    for (const auto& [path, value] : json->items())
      if (const std::string a = value_of(first, path), b = value_of(second, path); a != b)
        return path.substr(1) + ": " + a + " and " + b;
  return "";
}

}  // namespace elastin::lab
