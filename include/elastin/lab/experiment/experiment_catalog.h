#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "elastin/config/scene_key.h"
#include "elastin/contact/contact.h"
#include "elastin/core/laws/parameters.h"
#include "elastin/lab/run/experiment.h"

namespace elastin::config {
class Reader;
}

namespace elastin::lab {

class ExperimentCatalog;

/// What an experiment needs to know of its scene. Directions of the scene are turned with it.
struct ExperimentContext {
  const Body& body;  ///< rotated; must outlive the experiment
  const Material& material;
  Matrix3 rotation;  ///< of the scene
  StaticOptions statics;
  const ExperimentCatalog& experiments;  ///< where a fixture is looked up
  /// Of the scene; null if it has none. Experiments add obstacles of their own.
  contact::ContactOptions* contact = nullptr;
  Findings* findings = nullptr;  ///< gets those of the experiment and of its fixture; null: nobody wants them
};

/// One kind of experiment. A host's own has parameters and `make`; one whose keys are more than numbers has `keys` and
/// `read`.
struct ExperimentInfo {
  std::string name, summary;  ///< name: its `kind` in scenes
  std::string source = {};    ///< "" where there is nothing to cite
  bool in_time = false;       ///< whether it runs through time
  bool of_shares = false;     ///< whether it measures a body of which several processes have shares (Body::share)
  std::vector<ParameterInfo> parameters = {};
  /// From the parameters' values, all there, in SI units. Throws InputError if the body does not suit.
  std::function<std::unique_ptr<Experiment>(const ExperimentContext&, const ParameterValues&)> make = {};
  MeasureList measures = {};                ///< as Experiment::measures, without those of a fixture
  std::vector<config::SceneKey> keys = {};  ///< in addition to `kind`
  std::function<std::unique_ptr<Experiment>(config::Reader&, const ExperimentContext&)> read = {};
};

/// The keys of an experiment in addition to `kind`, those of its parameters too.
std::vector<config::SceneKey> keys_of(const ExperimentInfo& info);

/// All kinds of experiments that scenes may name.
class ExperimentCatalog {
 public:
  /// Throws InputError where the name is taken, or nothing says how to make one.
  void add(ExperimentInfo info);
  const std::vector<ExperimentInfo>& experiments() const { return experiments_; }
  /// Throws InputError with the nearest name and the list of what there is.
  const ExperimentInfo& find(const std::string& name) const;

 private:
  std::vector<ExperimentInfo> experiments_;
};

/// The experiments that come with Elastin.
const ExperimentCatalog& built_in_experiments();

/// The measures of all experiments of a catalog and of their runs; of several with one name the first.
MeasureList measures_of(const ExperimentCatalog& catalog);
/// The measures of the experiments that come with Elastin.
const MeasureList& built_in_measures();
/// One of them. Throws InputError with the nearest name.
const MeasureInfo& find_measure(const std::string& name);

}  // namespace elastin::lab
