#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <string>

#include "elastin/core/base/error.h"
#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {

/// Assimp hands out a corner once for each face or normal that it has; corners at the same position are one molecule
/// here. It keeps places in single precision: 6e-8 of their size. Polygons become triangles.
void read_surface(const File& file, const std::string& ending, MeshBuilder& mesh) {
  const auto refuse = [&](const std::string& why) { throw InputError(SourceLocation{file.path, 0, 0}, why); };
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(file.bytes.data(), file.bytes.size(), aiProcess_Triangulate,
                                                     ending.substr(1).c_str());
  if (!scene) refuse(std::string("not a surface that can be read: ") + importer.GetErrorString());
  std::size_t number = 0;
  for (unsigned part = 0; part < scene->mNumMeshes; ++part) {
    const aiMesh& piece = *scene->mMeshes[part];
    std::vector<int> point(piece.mNumVertices);
    for (unsigned corner = 0; corner < piece.mNumVertices; ++corner) {
      const aiVector3D& at = piece.mVertices[corner];
      const Vector3 position(at.x, at.y, at.z);
      if (!position.allFinite()) refuse("point " + std::to_string(corner) + " has a coordinate that is not finite");
      point[corner] = mesh.point_at(position);
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
