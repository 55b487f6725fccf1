#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/disjoint_sets.h"
#include "lab/run/body_image.h"
#include "lab/scene/parts.h"
#include "mesh/image_values.h"

namespace elastin::lab {
enum class ImageCells { hexahedra, lattice, tetrahedra, packing };

/// A label of a segmentation, and what its material has of its own.
struct ImageLabel {
  double number = 0;
  std::string name;
  std::optional<double> youngs_modulus = {}, poissons_ratio = {}, density = {};
  std::optional<Reader> ratio_place = {}, material = {};
};

struct ImageSetup : MeshFile, CellOrder {
  std::vector<ImageLabel> labels;
  std::optional<Reader> labels_place;
  std::optional<double> threshold, spacing, smoothing;
  std::optional<Reader> smoothing_place, spacing_place, threshold_place, from_place, to_place;
  std::optional<Vector3> voxel_size, from, to;
  ImageCells as = ImageCells::hexahedra;
  int ends = -1;  ///< axis of the image
  bool largest = false, close = false, fill_fraction = false;
  std::optional<Reader> youngs_modulus, density;
  std::string grey_values;  ///< file; empty where the image itself has them
  std::optional<Reader> grey_values_place;
  std::uint64_t seed = 1;
  bool parts = false;  ///< whether a label has more of its own than E, ν and density
};

/// Voxels along each axis of an image: from `first` to before `last`.
struct VoxelRange {
  std::array<int, 3> first{}, last{};
};

/// Voxels of a box along each axis.
std::array<int, 3> voxels_of_box(const mesh::ImageGrid& grid, const ImageSetup& setup);

/// Throws InputError where an image would make more boxes than memory has room for, before its data are read.
void check_boxes(const mesh::ImageGrid& grid, const ImageSetup& setup);

/// Boxes of voxels, as far as they are body. They begin where the body begins, and end where it ends: its
/// outermost voxels along each axis lie on outer sides of boxes, the last of which is from half to one and a half times
/// as long as the others.
class ImageBoxes {
 public:
  /// `grey` has the values of formulas, on the grid of `image`, which may be the same image.
  ImageBoxes(const mesh::Image& image, const mesh::Image& grey, const ImageSetup& setup, ShapeContext& context);
  Body body();
  /// Makes the body as stiff, and its molecules as heavy, as labels, fractions and grey values say.
  void set_matter(Body& body) const;
  /// Gives the material the Poisson's ratios of the labels.
  void set_ratios() const;
  /// Gives the specimen the image's grid and the materials of parts.
  void set_specimen(const Body& body) const;
  MoleculeSets sets() const;
  /// Middles of the outermost sides of the body's voxels, as Body::outline, as far as their convex hull needs them.
  Positions outline() const;

 private:
  void set_shades(BodyImage& own) const;
  struct Box {
    int label = -1;      ///< −1: not body
    float fraction = 1;  ///< of it that is body
    float value = 0;     ///< mean of its voxels in the body
  };
  std::size_t index(std::size_t x, std::size_t y, std::size_t z) const { return x + counts_[0] * (y + counts_[1] * z); }
  std::size_t voxel(std::size_t x, std::size_t y, std::size_t z) const {
    return x + image_.size[0] * (y + image_.size[1] * z);
  }
  /// In numbers_: corner c of a box is its c % 2, c / 2 % 2, c / 4.
  std::size_t corner(const std::array<int, 3>& box, int c) const {
    const std::size_t x = box[0] + c % 2, y = box[1] + c / 2 % 2, z = box[2] + c / 4;
    return x + (counts_[0] + 1) * (y + (counts_[1] + 1) * z);
  }
  std::array<int, 3> at(std::size_t box) const {
    const std::size_t nx = counts_[0], ny = counts_[1];
    return {static_cast<int>(box % nx), static_cast<int>(box / nx % ny), static_cast<int>(box / nx / ny)};
  }
  bool is_body(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < counts_[0] && y < counts_[1] && z < counts_[2] &&
           boxes_[index(x, y, z)].label >= 0;
  }
  template <class Visit>
  void for_body(const Visit& visit) const {
    for (std::size_t box = 0; box < boxes_.size(); ++box)
      if (boxes_[box].label >= 0) visit(boxes_[box], at(box));
  }
  /// The label of the box at a place, −1: of none.
  std::function<int(const Vector3&)> label_at() const;
  void part(Body& body);
  /// Of a voxel; −1: not body.
  int label_of(int x, int y, int z) const;
  int label_of(double value) const;
  double value_of(int x, int y, int z) const { return grey_.at(before_hole(x, y, z), y, z); }
  /// The voxel itself, or of a closed hole the one before it along x.
  int before_hole(int x, int y, int z) const {
    while (!closed_.empty() && closed_[voxel(x, y, z)]) --x;
    return x;
  }
  /// Visits the voxels in range_.
  template <class Visit>
  void for_voxels(const Visit& visit) const {
    for (int z = range_.first[2]; z < range_.last[2]; ++z)
      for (int y = range_.first[1]; y < range_.last[1]; ++y)
        for (int x = range_.first[0]; x < range_.last[0]; ++x) visit(x, y, z);
  }
  std::size_t box_with(int x, int y, int z) const { return index(box_of_[0][x], box_of_[1][y], box_of_[2][z]); }
  /// Voxels of a box along an axis.
  int length(int axis, int box) const { return planes_[axis][box + 1] - planes_[axis][box]; }
  void smooth();
  std::vector<float> blurred(const std::vector<std::int16_t>& labels, int label) const;
  void find_outline();
  /// Takes voxels for which `is_kept` is false out of the body.
  template <class Kept>
  void keep(const Kept& is_kept) {
    std::vector<std::int16_t> labels(image_.voxels(), -1);
    for_voxels([&](int x, int y, int z) {
      if (is_kept(x, y, z)) labels[voxel(x, y, z)] = static_cast<std::int16_t>(label_of(x, y, z));
    });
    relabelled_ = std::move(labels);
    find_outline();
  }
  std::size_t spread(const std::array<int, 3>& from, bool body, std::vector<bool>& reached) const;
  [[noreturn]] void fail_without_body() const;
  void lay();
  void fill();
  void close_holes();
  void keep_largest_piece();
  void find_pieces();
  void warn_of_joined_pieces(DisjointSets& boxes) const;
  void cut_ends();
  void warn_of_rough_end(int side, const std::map<std::size_t, int>& outermost,
                         const std::map<std::size_t, int>& next) const;
  void find_thin_places() const;
  void report() const;
  void number_corners();
  /// Of a position in boxes.
  Vector3 place(const Vector3& at) const;
  double volume(const std::array<int, 3>& at) const;
  /// Whether the material of a label states a key of its own; constants of a law state E, too.
  bool has_own(int label, const std::string& key) const {
    if (!labels_[label].material) return false;
    const std::vector<std::string> keys = labels_[label].material->keys();
    return std::any_of(keys.begin(), keys.end(),
                       [&](const std::string& own) { return own == key || (own == "law" && key == "youngs_modulus"); });
  }
  double stiffness(const Box& box) const;
  void set_packing(Body& body) const;

  const mesh::Image &image_, &grey_;
  const ImageSetup& setup_;
  ShapeContext& context_;
  bool parts_ = false;  ///< whether each label is a part: where materials differ by more than E, ν and density, and in
                        ///< tetrahedra near ν = ½, whose volumes are kept in bodies of one stiffness
  double slack_;        ///< by which `from` and `to` may be missed: rounding [m]
  VoxelRange range_;    ///< the outline of the body
  std::array<int, 3> voxels_{}, counts_{};  ///< voxels of a box, boxes, along each axis
  std::array<std::vector<int>, 3> planes_;  ///< voxels before each plane between boxes, and at both ends
  std::array<std::vector<int>, 3> box_of_;  ///< of each voxel along the axis
  std::vector<std::int16_t> relabelled_;    ///< labels of the voxels, x first; empty where they are the image's
  std::vector<bool> closed_;                ///< voxels of closed holes that are filled; empty without any
  std::vector<Box> boxes_;
  std::vector<int> pieces_;  ///< of each box, where there are several that share no face
  std::vector<ImageLabel> labels_;
  std::vector<Material> materials_;         ///< of the labels, where they are parts
  std::vector<int> numbers_;                ///< of each corner of the grid; −1: none
  std::vector<std::array<int, 3>> halves_;  ///< places of the molecules, in halves of boxes
  std::array<int, 2> ends_{};               ///< layers of boxes at the ends
  std::function<double(double)> modulus_of_, density_of_;
};

}  // namespace elastin::lab
