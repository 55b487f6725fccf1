#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"
#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

/// Corners that are no further apart than this share of the surface's extent are one: programs write each triangle by
/// itself, and what they compute twice differs by rounding.
constexpr double kSamePlace = 1e-6;

/// Finds points again by their place, in boxes that are a thousand times as wide as what is one place.
class Places {
 public:
  explicit Places(double extent)
      : within_(kSamePlace * extent), box_(extent > 0 ? 1e3 * within_ : std::numeric_limits<double>::infinity()) {}

  /// The mesh's point at this place; adds it if there is none.
  int point_at(const Vector3& position, MeshBuilder& mesh) {
    const auto box_of = [&](double slack) -> std::array<long, 3> {
      const Vector3 at = ((position.array() + slack) / box_).floor();
      return {static_cast<long>(at.x()), static_cast<long>(at.y()), static_cast<long>(at.z())};
    };
    const std::array<long, 3> low = box_of(-within_), high = box_of(within_);
    for (long x = low[0]; x <= high[0]; ++x)
      for (long y = low[1]; y <= high[1]; ++y)
        for (long z = low[2]; z <= high[2]; ++z)
          if (const auto box = boxes_.find({x, y, z}); box != boxes_.end())
            for (const auto& [point, place] : box->second)
              if ((place - position).norm() <= within_) return point;
    boxes_[box_of(0)].emplace_back(mesh.point_count(), position);
    mesh.add_point(position);
    return mesh.point_count() - 1;
  }

 private:
  double within_, box_;
  std::map<std::array<long, 3>, std::vector<std::pair<int, Vector3>>> boxes_;
};

/// The longest side of the box around all corners.
double extent_of(const aiScene& scene) {
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (unsigned part = 0; part < scene.mNumMeshes; ++part)
    for (unsigned corner = 0; corner < scene.mMeshes[part]->mNumVertices; ++corner) {
      const aiVector3D& at = scene.mMeshes[part]->mVertices[corner];
      low = low.cwiseMin(Vector3(at.x, at.y, at.z));
      high = high.cwiseMax(Vector3(at.x, at.y, at.z));
    }
  const double extent = (high - low).maxCoeff();
  return std::isfinite(extent) ? extent : 0;
}

}  // namespace

/// Assimp hands out a corner once for each face or normal that it has; corners at the same position are one molecule
/// here. It keeps places in single precision: 6e-8 of their size. Polygons become triangles.
void read_surface(const File& file, const std::string& ending, MeshBuilder& mesh) {
  const auto refuse = [&](const std::string& why) { throw InputError(SourceLocation{file.path, 0, 0}, why); };
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(file.bytes.data(), file.bytes.size(), aiProcess_Triangulate,
                                                     ending.substr(1).c_str());
  if (!scene) refuse(std::string("not a surface that can be read: ") + importer.GetErrorString());
  Places places(extent_of(*scene));
  std::size_t number = 0;
  for (unsigned part = 0; part < scene->mNumMeshes; ++part) {
    const aiMesh& piece = *scene->mMeshes[part];
    std::vector<int> point(piece.mNumVertices);
    for (unsigned corner = 0; corner < piece.mNumVertices; ++corner) {
      const aiVector3D& at = piece.mVertices[corner];
      const Vector3 position(at.x, at.y, at.z);
      if (!position.allFinite()) refuse("point " + std::to_string(corner) + " has a coordinate that is not finite");
      point[corner] = places.point_at(position, mesh);
    }
    for (unsigned face = 0; face < piece.mNumFaces; ++face, ++number) {
      const aiFace& corners = piece.mFaces[face];
      std::array<int, 4> cell{};
      for (unsigned i = 0; i < corners.mNumIndices && i < 3; ++i) cell[i] = point[corners.mIndices[i]];
      const CellUse use = corners.mNumIndices == 3   ? CellUse::triangle
                          : corners.mNumIndices == 2 ? CellUse::line
                                                     : CellUse::point;
      const std::string wrong = mesh.add_cell({0, use, 0, ""}, cell);
      if (!wrong.empty()) refuse("face " + std::to_string(number) + wrong);
    }
  }
}

}  // namespace elastin::mesh::format
