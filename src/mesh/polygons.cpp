#include "mesh/polygons.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>

namespace elastin::mesh::format {

Polygons read_polygons(std::string_view bytes, const std::string& ending) {
  Polygons result;
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, ending.c_str());
  if (!scene) {
    result.trouble = importer.GetErrorString();
    return result;
  }
  for (unsigned part = 0; part < scene->mNumMeshes; ++part) {
    const aiMesh& mesh = *scene->mMeshes[part];
    Polygons::Piece& piece = result.pieces.emplace_back();
    for (unsigned corner = 0; corner < mesh.mNumVertices; ++corner) {
      const aiVector3D& at = mesh.mVertices[corner];
      piece.corners.emplace_back(at.x, at.y, at.z);
    }
    for (unsigned face = 0; face < mesh.mNumFaces; ++face)
      piece.faces.emplace_back(mesh.mFaces[face].mIndices, mesh.mFaces[face].mIndices + mesh.mFaces[face].mNumIndices);
  }
  return result;
}

}  // namespace elastin::mesh::format
