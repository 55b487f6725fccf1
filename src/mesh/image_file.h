#pragma once
#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin::mesh {

/// Where the voxels of an image are.
struct ImageGrid {
  std::array<int, 3> size{1, 1, 1};     ///< voxels along its axes
  Vector3 origin = Vector3::Zero();     ///< middle of the first voxel, in the file's own length unit
  Matrix3 steps = Matrix3::Identity();  ///< from a voxel to the next along each axis: columns, independent
  double unit = 0;                      ///< that the file states for these [m]; 0 if it states none
  std::string space;  ///< what x, y and z mean where the file says it: "RAS", "LAS", "LPS" …, or its text
  std::size_t voxels() const;
};

/// Numbers on a grid of voxels in space: labels of a segmentation, or grey values of a scan. They stay as the file has
/// them, so that an image takes as much memory as its data.
class Image : public ImageGrid {
 public:
  bool has_steps = true;  ///< false: the format knows none
  enum class Number { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };
  Number number = Number::uint8;
  bool swapped = false;                  ///< whether the bytes of a number stand the other way round
  double slope = 1, intercept = 0;       ///< value = slope · number + intercept
  std::array<std::size_t, 3> strides{};  ///< in numbers
  std::string data;                      ///< strides fit into it
  std::string contradiction;             ///< of its header, and which side of it counts; empty without one
  std::map<double, std::string> names;   ///< of labels, where the file states them: a segmentation of 3D Slicer

  double at(int x, int y, int z) const;
};

/// Reads NIfTI-1 and -2 (.nii, .nii.gz, .hdr with .img), NRRD (.nrrd, .nhdr with its data file; raw, gzip, ascii),
/// MetaImage (.mhd, .mha; plain and compressed) and NumPy's arrays (.npy). Throws InputError with the file and what is
/// needed: another ending, a header that is cut or contradicts itself, more or fewer than three dimensions, colours,
/// vectors and complex numbers, fewer data than the header promises, axes in one plane. Allocates no more than the
/// file's data unpack to. `check` gets what the header says before the data are read, and may throw.
Image load_image(const std::string& path, const std::function<void(const ImageGrid&)>& check = {});

/// What the numbers of an image that is written are: one a voxel, or three in the directions of the grid's space.
enum class ImageContent { labels, values, displacements };

/// An image file (.nii, .nii.gz, .nrrd) with these numbers, of each voxel one after the other, x fastest: labels as
/// whole numbers. NIfTI has x, y and z of RAS, so that x and y of a grid in LPS change their sign. Throws InputError
/// on another ending.
std::string image_text(const std::string& path, const ImageGrid& grid, ImageContent content,
                       const std::vector<float>& values);

/// The endings of these files, with their dots.
const char* image_endings();

}  // namespace elastin::mesh
