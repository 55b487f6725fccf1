#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "elastin/config/scene_source.h"
#include "elastin/lab/run/experiment.h"
#include "lab/run/choice.h"
#include "lab/run/run.h"

namespace elastin::lab {

using config::SceneSource;

/// A model file of FEBio as the laboratory runs it: its body with its loads, its domains' laws as a strategy of their
/// own, and its steps as an experiment.
struct FebioModel {
  std::string title;
  Specimen specimen;
  StrategyChoice stiffness;  ///< "febio": each domain with its own material
  /// The steps on the specimen's body, which must outlive it.
  std::function<std::unique_ptr<StaticExperiment>(const Body& body)> make_experiment;
  std::vector<std::string> warnings, notes;
};

/// Whether a file is one by its name: *.feb.
bool is_febio_model(const std::string& path);

/// Reads a model of the format 4.0, module solid. Numbers count as SI. What has no equal here, or is not known, throws
/// InputError with the file, the line and the element's name; only output, plot settings and the settings of FEBio's
/// solver are passed over.                                             [Maas et al. 2012; FEBio User's Manual 4.0]
FebioModel load_febio_model(const SceneSource& source);

}  // namespace elastin::lab
