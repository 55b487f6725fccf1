#include "lab/report/image_fields.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "lab/report/files.h"
#include "lab/run/body_image.h"

namespace elastin::lab {
namespace {

/// Tetrahedra that fill the body.
Cells<4> filling(const Body& body) {
  Cells<4> cells = body.tetrahedra;
  if (cells.empty())
    for (const auto& cube : body.cubes)
      for (const auto& [one, other] : {std::array{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}})
        cells.push_back({cube[0], cube[one], cube[other], cube[7]});
  if (cells.empty())
    throw InputError("--image: needs a body that cells fill: tetrahedra, hexahedra or a cubic lattice");
  return cells;
}

/// A grid along the axes around the body at rest and in the end.
BodyImage grid_around(const Positions& rest, const Positions& moved, double spacing) {
  BodyImage grid;
  grid.unit = grid.length_unit = 1e-3;
  const Vector3 low = rest.rowwise().minCoeff().cwiseMin(moved.rowwise().minCoeff());
  const Vector3 high = rest.rowwise().maxCoeff().cwiseMax(moved.rowwise().maxCoeff());
  double voxels = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double count = std::ceil((high[axis] - low[axis]) / spacing - 1e-6) + 1;
    voxels *= count;
    if (voxels > 1e9) throw InputError("--image-spacing: more than 1e9 voxels; needed: a larger one");
    grid.size[axis] = static_cast<int>(count);
  }
  grid.origin = low / grid.length_unit;
  grid.steps *= spacing / grid.length_unit;
  return grid;
}

/// Where the molecules are, in voxels of a grid.
Positions in_voxels(const BodyImage& grid, const Positions& places) {
  return grid.steps.inverse() * ((places / grid.length_unit).colwise() - grid.origin);
}

/// Calls visit(voxel, weights of the corners) for each voxel whose middle lies in the cell; `places` in voxels.
template <class Visit>
void for_voxels_in(const Positions& places, const std::array<int, 4>& cell, const BodyImage& grid, const Visit& visit) {
  Matrix3 edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = places.col(cell[i + 1]) - places.col(cell[0]);
  if (!(std::abs(edges.determinant()) > 1e-12)) return;
  const Matrix3 inverse = edges.inverse();
  std::array<int, 3> low{}, high{};
  for (int axis = 0; axis < 3; ++axis) {
    double least = grid.size[axis], most = -1;
    for (const int corner : cell)
      least = std::min(least, places(axis, corner)), most = std::max(most, places(axis, corner));
    low[axis] = static_cast<int>(std::ceil(std::max(0., least - 1e-9)));
    high[axis] = static_cast<int>(std::floor(std::min(grid.size[axis] - 1., most + 1e-9)));
  }
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x) {
        const Vector3 own = inverse * (Vector3(x, y, z) - places.col(cell[0]));
        const Eigen::Vector4d weights(1 - own.sum(), own[0], own[1], own[2]);
        if (weights.minCoeff() < -1e-9) continue;
        const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]);
        visit(static_cast<std::size_t>(x) + nx * (static_cast<std::size_t>(y) + ny * static_cast<std::size_t>(z)),
              weights);
      }
}

/// Green–Lagrange strains, means of the cells at each molecule by their volumes.
std::vector<Matrix3> strains_at(const Positions& rest, const Positions& moved, const Cells<4>& cells) {
  std::vector<Matrix3> strains(static_cast<std::size_t>(rest.cols()), Matrix3::Zero());
  VectorX volumes = VectorX::Zero(rest.cols());
  for (const auto& cell : cells) {
    Matrix3 before, after;
    for (int i = 0; i < 3; ++i) {
      before.col(i) = rest.col(cell[i + 1]) - rest.col(cell[0]);
      after.col(i) = moved.col(cell[i + 1]) - moved.col(cell[0]);
    }
    const double volume = std::abs(before.determinant());
    if (!(volume > 0)) continue;
    const Matrix3 gradient = after * before.inverse();
    for (const int molecule : cell) {
      strains[molecule] += volume / 2 * (gradient.transpose() * gradient - Matrix3::Identity());
      volumes[molecule] += volume;
    }
  }
  for (Eigen::Index molecule = 0; molecule < volumes.size(); ++molecule)
    if (volumes[molecule] > 0) strains[molecule] /= volumes[molecule];
  return strains;
}

/// The number of the label, or of the part from 1, of each cell.
std::vector<double> labels_of(const Body& body, const Positions& rest, const Cells<4>& cells, const BodyImage* image) {
  std::vector<double> labels(cells.size(), 1);
  for (std::size_t part = 0; part < body.parts.size(); ++part) {
    const auto& own = body.parts[part];
    const CellRange range =
        body.tetrahedra.empty() ? CellRange{6 * own.cubes.first, 6 * own.cubes.count} : own.tetrahedra;
    std::fill_n(labels.begin() + range.first, range.count, static_cast<double>(part + 1));
  }
  if (image)
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      labels[cell] = image->number(rest(Eigen::all, cells[cell]).rowwise().mean());
  return labels;
}

}  // namespace

void check_image(const std::string& path, double spacing, const Scene& scene) {
  if (!scene.specimen.image && !(spacing > 0))
    throw InputError("--image: the body is not made of an image, whose grid would count; add --image-spacing '1 mm'");
  if (scene.specimen.body.share) throw InputError("--image: needs one process that has the whole body");
  filling(scene.specimen.body);
  mesh::image_text(path, {}, mesh::ImageContent::values, {0});
}

void write_image(const std::string& path, double spacing, const Scene& scene, const Run& run) {
  const Body& body = scene.specimen.body;
  const BodyImage* image = scene.specimen.image.get();
  const Matrix3 back = scene.rotation.transpose();
  const Positions rest = back * body.rest, moved = back * run.snapshots.back().positions;
  const Cells<4> cells = filling(body);
  BodyImage grid = spacing > 0 ? grid_around(rest, moved, spacing) : *image;
  grid.unit = grid.length_unit;
  const std::vector<Matrix3> strains = strains_at(rest, moved, cells);
  const std::vector<double> labels = labels_of(body, rest, cells, image);
  std::vector<float> displacement(3 * grid.voxels()), strain(grid.voxels()), label(grid.voxels());
  const Positions at_rest = in_voxels(grid, rest), in_the_end = in_voxels(grid, moved);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    for_voxels_in(at_rest, cells[cell], grid, [&](std::size_t voxel, const Eigen::Vector4d& weights) {
      Vector3 displaced = Vector3::Zero();
      Matrix3 mean = Matrix3::Zero();
      for (int i = 0; i < 4; ++i) {
        const int molecule = cells[cell][i];
        displaced += weights[i] / grid.length_unit * (moved.col(molecule) - rest.col(molecule));
        mean += weights[i] * strains[molecule];
      }
      for (std::size_t i = 0; i < 3; ++i)
        displacement[3 * voxel + i] = static_cast<float>(displaced[static_cast<int>(i)]);
      strain[voxel] = static_cast<float>(
          Eigen::SelfAdjointEigenSolver<Matrix3>(mean, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
    });
    for_voxels_in(in_the_end, cells[cell], grid,
                  [&](std::size_t voxel, const Eigen::Vector4d&) { label[voxel] = static_cast<float>(labels[cell]); });
  }
  const auto write = [&](const std::string& suffix, mesh::ImageContent content, const std::vector<float>& values) {
    const std::size_t dot = path.ends_with(".gz") ? path.rfind('.', path.size() - 4) : path.rfind('.');
    std::string own = path;
    if (dot != std::string::npos) own.insert(dot, suffix);
    write_whole(own, mesh::image_text(own, grid, content, values));
  };
  write("", mesh::ImageContent::displacements, displacement);
  write("-strain", mesh::ImageContent::values, strain);
  write("-label", mesh::ImageContent::labels, label);
}

}  // namespace elastin::lab
