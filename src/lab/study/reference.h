#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "lab/scene/scene.h"

namespace elastin::lab {

/// Result of computing the references of a scene.
struct ComputedReferences {
  std::vector<Reference> references;  ///< one a main measure that has a limit
  std::string trouble;                ///< why none was computed; empty if some were
  bool operator==(const ComputedReferences&) const = default;
};

/// Computed references by what they are references of, in a file that other runs read back.
class ReferenceStore {
 public:
  /// Of FOLDER/references.json; an empty folder stands for memory alone. A file that is no such one, or of another
  /// version of the program, counts as empty.
  explicit ReferenceStore(const std::string& folder = "");
  /// Null without a reference.
  const ComputedReferences* find(const std::string& key) const;
  /// Writes the file again. Throws InputError naming the path.
  void add(const std::string& key, ComputedReferences found);
  /// Adds those of another store that are not here. Throws InputError naming the path.
  void add(const ReferenceStore& other);

 private:
  void write() const;
  std::string path_;
  std::map<std::string, ComputedReferences> known_;
};

/// Whether references are to be computed for a scene: as it says itself, or as `option` does, the command's
/// --reference: "" (the scene's), "computed" or "none".
bool wants_computed_references(const Scene& scene, const std::string& option);

/// Solves the scene's own problem with the material's own law on finer and finer cells: those of the body, each halved
/// along its sides again and again; in the cubes of a lattice and between the molecules of a packing tetrahedra that
/// are made for it; of an image smaller boxes, down to its voxels. From what the main measures are there follow their
/// limits (see limit_of). It ends where all that have a unit are known to the uncertainty that the scene states, or at
/// its limits of size and time. Each body begins where the one before it led to, as long as nothing depends on the load
/// path.
/// @param overrides as the scene was loaded with; @param progress called before each body; may be empty.
ComputedReferences compute_references(const Scene& scene, const Catalog& catalog,
                                      const std::vector<std::string>& overrides, ReferenceStore& store,
                                      const std::function<void(const std::string&)>& progress,
                                      const std::function<bool()>& stop);

}  // namespace elastin::lab
