#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// Keys that many experiments have.
inline const SceneKey kDepthKey{"grip_depth", "quantity",      "m",
                                "> 0",        "the end plane", "molecules that are so near to an end belong to it"};
inline const SceneKey kStepsKey{"load_steps", "whole", "", "1 … 100000", "1", "equal steps in which the load grows"};
inline const SceneKey kSymmetryKey{
    "symmetry", "list of directions",
    "",         "",
    "none",     "normals of planes through the origin that cut the body, each perpendicular to the others"};

/// Of read_travel.
inline SceneKey travel_strain_key(const std::string& length, const std::string& fallback) {
  return {"strain", "number", "",
          "> 0",    fallback, "`" + length + "` over the height along the axis of the body, of all bodies together"};
}

/// Fails on a length that is given in percent.
void refuse_percent(const Reader& length);

/// How far something is moved [m]: `key`, or `strain` times the body's height along `axis` (unit), that of all bodies
/// together. None: neither is given.
std::optional<double> read_travel(Reader& reader, const char* key, const Body& body, const Vector3& axis);

/// Rows of the table, each list beside the functions that read them.
std::vector<ExperimentInfo> static_experiments();
std::vector<ExperimentInfo> bubble_experiments();
std::vector<ExperimentInfo> contact_experiments();
std::vector<ExperimentInfo> timed_experiments();

/// {kind: NAME, …}, of the context's catalog. Throws InputError with source location and key.
std::unique_ptr<Experiment> read_experiment(Reader reader, const ExperimentContext& context);

/// "motion, release and creep": those that run through time.
std::string timed_experiment_names(const ExperimentCatalog& catalog);

}  // namespace elastin::lab
