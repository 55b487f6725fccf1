#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"
#include "mesh/mesh_formats.h"
#include "mesh/polygons.h"

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
double extent_of(const Polygons& polygons) {
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Polygons::Piece& piece : polygons.pieces)
    for (const Vector3& at : piece.corners) low = low.cwiseMin(at), high = high.cwiseMax(at);
  const double extent = (high - low).maxCoeff();
  return std::isfinite(extent) ? extent : 0;
}

}  // namespace

/// Corners at the same position are one molecule here.
void read_surface(const File& file, const std::string& ending, MeshBuilder& mesh) {
  const auto refuse = [&](const std::string& why) { throw InputError(SourceLocation{file.path, 0, 0}, why); };
  const Polygons polygons = read_polygons(file.bytes, ending.substr(1));
  if (!polygons.trouble.empty()) refuse("not a surface that can be read: " + polygons.trouble);
  Places places(extent_of(polygons));
  std::size_t number = 0;
  for (const Polygons::Piece& piece : polygons.pieces) {
    std::vector<int> point;
    for (const Vector3& position : piece.corners) {
      if (!position.allFinite())
        refuse("point " + std::to_string(point.size()) + " has a coordinate that is not finite");
      point.push_back(places.point_at(position, mesh));
    }
    for (const std::vector<int>& corners : piece.faces) {
      std::array<int, 4> cell{};
      for (std::size_t i = 0; i < corners.size() && i < 3; ++i) cell[i] = point[corners[i]];
      const CellUse use = corners.size() == 3   ? CellUse::triangle
                          : corners.size() == 2 ? CellUse::line
                                                : CellUse::point;
      const std::string wrong = mesh.add_cell({0, use, 0, ""}, cell);
      if (!wrong.empty()) refuse("face " + std::to_string(number) + wrong);
      ++number;
    }
  }
}

}  // namespace elastin::mesh::format
