#include "mesh/image_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/disjoint_sets.h"
#include "core/geometry/tributary.h"
#include "core/shapes/orders.h"
#include "core/simulation/warnings.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/renumbered.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/run/body_image.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

constexpr int kUnnumbered = -2;

enum class ImageCells { hexahedra, lattice, tetrahedra, packing };

/// A label of a segmentation, and what its material has of its own.
struct Label {
  double number = 0;
  std::string name;
  std::optional<double> youngs_modulus = {}, poissons_ratio = {}, density = {};
  std::optional<Reader> ratio_place = {}, material = {};
};

struct ImageSetup : MeshFile, CellOrder {
  std::vector<Label> labels;
  std::optional<Reader> labels_place;
  std::optional<double> threshold, spacing, smoothing;
  std::optional<Reader> smoothing_place, spacing_place, threshold_place, from_place, to_place;
  std::optional<Vector3> voxel_size, from, to;
  ImageCells as = ImageCells::hexahedra;
  int ends = -1;  ///< axis of the image
  bool largest = false, close = false, fill_fraction = false;
  std::optional<Reader> youngs_modulus, density;
  std::uint64_t seed = 1;
  bool parts = false;  ///< whether a label has more of its own than E, ν and density
};

struct LabelSetup {
  std::string name;
  std::optional<Reader> material;
};

void read_labels(const Reader& value, ImageSetup& setup) {
  setup.labels_place = value;
  const auto number_of = [&](const std::string& text, const Reader& place) {
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (text.empty() || *end || !std::isfinite(number))
      place.fail("'" + text + "' is no label: labels are numbers of the image");
    return number;
  };
  if (!value.is_map()) {
    for (const Reader& item : value.items()) setup.labels.push_back({number_of(item.text(), item), item.text()});
  } else {
    const Keys<LabelSetup> keys{key::text("name", &LabelSetup::name, "name of its set").otherwise("its number"),
                                key::later({"material", "map", "", "", "the scene's",
                                            "what differs there from the scene's [material](#material)"},
                                           &LabelSetup::material)};
    const Keys<Label> numbers{
        key::quantity("youngs_modulus", &Label::youngs_modulus, dimension::pressure, "E there", kPositive),
        key::quantity("poissons_ratio", &Label::poissons_ratio, dimension::none, "ν there", {-0.99, 0.4999})
            .place(&Label::ratio_place),
        key::quantity("density", &Label::density, dimension::density, "density there", kPositive)};
    for (const auto& [key, item] : value.entries()) {
      const LabelSetup own = keys.read(item);
      setup.labels.push_back({.number = number_of(key, item), .name = own.name.empty() ? key : own.name});
      setup.labels.back().material = own.material;
      if (!own.material) continue;
      const std::vector<std::string> plain = numbers.names();
      for (const std::string& name : own.material->keys())
        setup.parts |= std::find(plain.begin(), plain.end(), name) == plain.end();
    }
    for (Label& label : setup.labels)
      if (label.material && !setup.parts) label = numbers.read(Reader(*label.material), {}, Label(label));
  }
  for (std::size_t i = 0; i < setup.labels.size(); ++i)
    for (std::size_t other = 0; other < i; ++other)
      if (setup.labels[i].number == setup.labels[other].number)
        value.fail("names the label " + number(setup.labels[i].number) + " twice");
  if (setup.labels.empty()) value.fail("names no label; leave it out where every voxel that is not 0 is body");
}

/// Voxels along each axis of an image: from `first` to before `last`.
struct VoxelRange {
  std::array<int, 3> first{}, last{};
};

/// Where `from` and `to` may leave voxels.
VoxelRange cropped(const mesh::ImageGrid& grid, const ImageSetup& setup) {
  VoxelRange range{{}, grid.size};
  if (!setup.from && !setup.to) return range;
  const Vector3 size(grid.size[0], grid.size[1], grid.size[2]);
  const auto corner = [](int c, const Vector3& low, const Vector3& high) {
    return Vector3(c & 1 ? high[0] : low[0], c & 2 ? high[1] : low[1], c & 4 ? high[2] : low[2]);
  };
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int c = 0; c < 8; ++c) {
    const Vector3 place = grid.origin + grid.steps * corner(c, Vector3::Zero(), size - Vector3::Ones());
    low = low.cwiseMin(place), high = high.cwiseMax(place);
  }
  if (setup.from) low = low.cwiseMax(*setup.from / setup.length_unit);
  if (setup.to) high = high.cwiseMin(*setup.to / setup.length_unit);
  Vector3 least = size, most = -size;
  for (int c = 0; c < 8; ++c) {
    const Vector3 voxel = grid.steps.inverse() * (corner(c, low, high) - grid.origin);
    least = least.cwiseMin(voxel), most = most.cwiseMax(voxel);
  }
  for (int axis = 0; axis < 3; ++axis) {  // a voxel more than rounding could take
    range.first[axis] = static_cast<int>(std::clamp(std::floor(least[axis] - 0.5), 0., size[axis]));
    range.last[axis] = static_cast<int>(std::clamp(std::ceil(most[axis] + 1.5), 0., size[axis]));
  }
  return range;
}

/// Voxels of a box along each axis.
std::array<int, 3> voxels_of_box(const mesh::ImageGrid& grid, const ImageSetup& setup) {
  std::array<int, 3> voxels{1, 1, 1};
  for (int axis = 0; axis < 3 && setup.spacing; ++axis) {
    const double step = setup.length_unit * grid.steps.col(axis).norm();
    voxels[axis] = std::clamp(static_cast<int>(std::lround(std::min(1e6, *setup.spacing / step))), 1, grid.size[axis]);
  }
  return voxels;
}

/// Throws InputError where an image would make more boxes than memory has room for, before its data are read.
void check_boxes(const mesh::ImageGrid& grid, const ImageSetup& setup) {
  constexpr double most = 3e8;  // some 5 GB of memory
  const VoxelRange range = cropped(grid, setup);
  const std::array<int, 3> voxels = voxels_of_box(grid, setup);
  double boxes = 1;
  for (int axis = 0; axis < 3; ++axis)
    boxes *= std::max(1., std::floor((range.last[axis] - range.first[axis]) / double(voxels[axis])));
  const bool all = setup.smoothing || setup.close;  // these work on voxels
  if (std::max(boxes, all ? static_cast<double>(grid.voxels()) : 0.) > most)
    setup.file->fail(fmt::format(
        "makes {:.3g} boxes of {:.3g} voxels; at most {:.3g} are read{}: cut the image to the "
        "body, or write `from` and `to` or a larger `spacing`",
        boxes, static_cast<double>(grid.voxels()), most, all ? ", of either with `smoothing` or `holes: close`" : ""));
}

/// Boxes of voxels, as far as they are body. They begin where the body begins, and end where it ends: its outermost
/// voxels along each axis lie on outer sides of boxes, the last of which is from half to one and a half times as long
/// as the others.
class Boxes {
 public:
  Boxes(const mesh::Image& image, const ImageSetup& setup, ShapeContext& context);
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
  std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(counts_[0]) *
               (static_cast<std::size_t>(y) + static_cast<std::size_t>(counts_[1]) * static_cast<std::size_t>(z));
  }
  std::size_t voxel(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(image_.size[0]) *
               (static_cast<std::size_t>(y) + static_cast<std::size_t>(image_.size[1]) * static_cast<std::size_t>(z));
  }
  std::array<int, 3> at(std::size_t box) const {
    const auto nx = static_cast<std::size_t>(counts_[0]), ny = static_cast<std::size_t>(counts_[1]);
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
  double value_of(int x, int y, int z) const { return image_.at(before_hole(x, y, z), y, z); }
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

  const mesh::Image& image_;
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
  std::vector<Label> labels_;
  std::vector<Material> materials_;         ///< of the labels, where they are parts
  std::vector<int> numbers_;                ///< of each corner of the grid; −1: none
  std::vector<std::array<int, 3>> halves_;  ///< places of the molecules, in halves of boxes
  std::array<int, 2> ends_{};               ///< layers of boxes at the ends
  std::function<double(double)> modulus_of_, density_of_;
};

Boxes::Boxes(const mesh::Image& image, const ImageSetup& setup, ShapeContext& context)
    : image_(image),
      setup_(setup),
      context_(context),
      slack_(1e-6 * setup.length_unit * image.steps.colwise().norm().minCoeff()),
      range_(cropped(image, setup)),
      voxels_(voxels_of_box(image, setup)),
      labels_(setup.labels) {
  if (labels_.empty()) labels_.push_back({0, setup.threshold ? "body" : "not 0"});
  const auto nearly_incompressible = [&](const Label& label) {
    return label.poissons_ratio.value_or(context.material->poissons_ratio) > kLocking;
  };
  const auto has_material = [](const Label& label) { return label.material.has_value(); };
  parts_ = setup.parts || (setup.as == ImageCells::tetrahedra && context.remarks.specimen &&
                           std::any_of(labels_.begin(), labels_.end(), has_material) &&
                           std::any_of(labels_.begin(), labels_.end(), nearly_incompressible));
  if (parts_) {
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      const Label& label = labels_[i];
      if (label.material && (!context.remarks.specimen || !context.remarks.laws))
        label.material->fail("needs a scene of one body");
      for (std::size_t other = 0; other < i; ++other)
        if (labels_[other].name == label.name) setup.labels_place->fail("names two labels '" + label.name + "'");
      materials_.push_back(label.material ? read_material(*label.material, *context.remarks.laws, context.material)
                                          : *context.material);
      for (const char* key : {"fields", "bending"})
        if (label.material && Reader(*label.material).has(key))
          Reader(*label.material).at(key).fail("belongs to the material of a whole body");
    }
    if (setup.as == ImageCells::packing)
      setup.labels_place->fail("gives materials of more than E, nu and density, and a packing has one material");
  }
  if (setup.youngs_modulus) modulus_of_ = setup.youngs_modulus->of_value(dimension::pressure, kPositive);
  if (setup.density) density_of_ = setup.density->of_value(dimension::density, kPositive);
  if (setup.smoothing) smooth();
  find_outline();
  if (setup.close) close_holes();
  if (setup.largest) keep_largest_piece();
  lay();
  find_pieces();
  cut_ends();
  find_thin_places();
  number_corners();
  report();
}

int Boxes::label_of(int x, int y, int z) const {
  x = before_hole(x, y, z);
  if (setup_.from || setup_.to) {
    const Vector3 place = setup_.length_unit * (image_.origin + image_.steps * Vector3(x, y, z));
    if ((setup_.from && (place.array() < setup_.from->array() - slack_).any()) ||
        (setup_.to && (place.array() > setup_.to->array() + slack_).any()))
      return -1;
  }
  return relabelled_.empty() ? label_of(image_.at(x, y, z)) : relabelled_[voxel(x, y, z)];
}

int Boxes::label_of(double value) const {
  if (setup_.labels.empty())
    return (setup_.threshold ? value >= *setup_.threshold : value != 0 && !std::isnan(value)) ? 0 : -1;
  for (std::size_t i = 0; i < labels_.size(); ++i)
    if (labels_[i].number == value) return static_cast<int>(i);
  return -1;
}

/// Where a voxel has a label, or any where that is −1: 1, else 0, smoothed by a Gaussian. Beyond the image it goes on
/// as it ends.
std::vector<float> Boxes::blurred(const std::vector<std::int16_t>& labels, int label) const {
  std::vector<float> values(labels.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = label < 0 ? labels[i] >= 0 : labels[i] == label;
  for (int axis = 0, stride = 1; axis < 3; stride *= image_.size[axis++]) {
    const double deviation = *setup_.smoothing / (setup_.length_unit * image_.steps.col(axis).norm());
    const int reach = static_cast<int>(std::ceil(3 * deviation)), size = image_.size[axis];
    std::vector<float> weights, line(static_cast<std::size_t>(size));
    for (int i = -reach; i <= reach; ++i)
      weights.push_back(static_cast<float>(std::exp(-i * i / (2 * deviation * deviation))));
    const float sum = std::accumulate(weights.begin(), weights.end(), 0.f);
    for (std::size_t first = 0; first < values.size(); ++first) {
      if (first / static_cast<std::size_t>(stride) % static_cast<std::size_t>(size) != 0) continue;
      const auto at = [&](int i) -> float& {
        return values[first + static_cast<std::size_t>(i) * static_cast<std::size_t>(stride)];
      };
      for (int i = 0; i < size; ++i) line[i] = at(i);
      if (std::all_of(line.begin(), line.end(), [&](float value) { return value == line[0]; })) continue;
      for (int i = 0; i < size; ++i) {
        float own = 0;
        for (int j = -reach; j <= reach; ++j) own += weights[j + reach] * line[std::clamp(i + j, 0, size - 1)];
        at(i) = own / sum;
      }
    }
  }
  return values;
}

/// Body is then what has most of it around, as many voxels as before; a voxel has the label of which most is around.
void Boxes::smooth() {
  constexpr double most = 20;  // voxels, to which the time is in proportion
  if (*setup_.smoothing > most * setup_.length_unit * image_.steps.colwise().norm().minCoeff())
    setup_.smoothing_place->fail(fmt::format("is more than {} voxels", most));
  std::vector<std::int16_t> before;
  for (int z = 0; z < image_.size[2]; ++z)
    for (int y = 0; y < image_.size[1]; ++y)
      for (int x = 0; x < image_.size[0]; ++x)
        before.push_back(static_cast<std::int16_t>(label_of(image_.at(x, y, z))));
  const std::ptrdiff_t count =
      std::count_if(before.begin(), before.end(), [](std::int16_t label) { return label >= 0; });
  if (count == 0) return;
  const std::vector<float> body = blurred(before, -1);
  std::vector<float> sorted = body, largest(body.size(), -1);
  std::nth_element(sorted.begin(), sorted.begin() + count - 1, sorted.end(), std::greater());
  const float least = sorted[count - 1];
  relabelled_.assign(body.size(), -1);
  for (int label = 0; label < static_cast<int>(labels_.size()); ++label) {
    const std::vector<float> own = labels_.size() == 1 ? body : blurred(before, label);
    for (std::size_t i = 0; i < own.size(); ++i)
      if (body[i] >= least && own[i] > largest[i])
        largest[i] = own[i], relabelled_[i] = static_cast<std::int16_t>(label);
  }
  std::ptrdiff_t changed = 0, now = 0;
  for (std::size_t i = 0; i < body.size(); ++i) changed += relabelled_[i] != before[i], now += relabelled_[i] >= 0;
  context_.remarks.notes.push_back(fmt::format(
      "{}: smoothed over {} mm: {} of {} voxels of the body have changed, its volume is {:.4f} times as before",
      setup_.file->text(), number(1e3 * *setup_.smoothing), changed, count,
      static_cast<double>(now) / static_cast<double>(count)));
}

/// Narrows range_ to the voxels that are body.
void Boxes::find_outline() {
  VoxelRange outline{range_.last, range_.first};
  bool any = false;
  for_voxels([&](int x, int y, int z) {
    if (label_of(x, y, z) < 0) return;
    any = true;
    const std::array<int, 3> at{x, y, z};
    for (int axis = 0; axis < 3; ++axis) {
      outline.first[axis] = std::min(outline.first[axis], at[axis]);
      outline.last[axis] = std::max(outline.last[axis], at[axis] + 1);
    }
  });
  if (!any) fail_without_body();
  range_ = outline;
}

void Boxes::fail_without_body() const {
  std::set<double> values;
  bool has_body = false;
  for (int z = 0; z < image_.size[2]; ++z)
    for (int y = 0; y < image_.size[1]; ++y)
      for (int x = 0; x < image_.size[0]; ++x) {
        const double value = image_.at(x, y, z);
        has_body |= label_of(value) >= 0;
        if (!std::isnan(value) && values.size() < 20) values.insert(value);
      }
  if (has_body && (setup_.from || setup_.to)) {
    const Vector3 last(image_.size[0] - 1, image_.size[1] - 1, image_.size[2] - 1);
    const auto text = [&](const Vector3& voxel) {
      const Vector3 place = 1e3 * setup_.length_unit * (image_.origin + image_.steps * voxel);
      return fmt::format("({}, {}, {}) mm", number(place[0]), number(place[1]), number(place[2]));
    };
    (setup_.from ? setup_.from_place : setup_.to_place)
        ->fail(fmt::format("leaves no voxel of the body in {}, whose voxels lie from {} to {}", setup_.file->text(),
                           text(Vector3::Zero()), text(last)));
  }
  std::vector<std::string> found;
  for (const double value : values) found.push_back(number(value));
  (setup_.labels_place      ? *setup_.labels_place
   : setup_.threshold_place ? *setup_.threshold_place
                            : *setup_.file)
      .fail(fmt::format("leaves no voxel of {}; {}{}", setup_.file->text(),
                        found.empty() ? "none of its values is a number" : "it has the values " + listed(found),
                        values.size() < 20 ? "" : " …"));
}

/// Lays boxes over the outline, and fills them.
void Boxes::lay() {
  for (int axis = 0; axis < 3; ++axis) {
    const int first = range_.first[axis], last = range_.last[axis], step = voxels_[axis];
    std::vector<int>& planes = planes_[axis] = {first};
    while (2 * (last - planes.back()) >= 3 * step) planes.push_back(planes.back() + step);
    if (planes.back() < last) planes.push_back(last);
    counts_[axis] = static_cast<int>(planes.size()) - 1;
    box_of_[axis].assign(static_cast<std::size_t>(image_.size[axis]), 0);
    for (int box = 0; box < counts_[axis]; ++box)
      std::fill(box_of_[axis].begin() + planes[box], box_of_[axis].begin() + planes[box + 1], box);
  }
  fill();
}

void Boxes::fill() {
  boxes_.assign(static_cast<std::size_t>(counts_[0]) * static_cast<std::size_t>(counts_[1]) *
                    static_cast<std::size_t>(counts_[2]),
                {});
  std::vector<int> counts(labels_.size());
  double fullest = 0;
  for (std::size_t number = 0; number < boxes_.size(); ++number) {
    const auto [bx, by, bz] = at(number);
    std::fill(counts.begin(), counts.end(), 0);
    int all = 0, body = 0;
    double sum = 0;
    for (int z = planes_[2][bz]; z < planes_[2][bz + 1]; ++z)
      for (int y = planes_[1][by]; y < planes_[1][by + 1]; ++y)
        for (int x = planes_[0][bx]; x < planes_[0][bx + 1]; ++x, ++all) {
          const int label = label_of(x, y, z);
          if (label < 0) continue;
          ++counts[label], ++body;
          sum += value_of(x, y, z);
        }
    const double fraction = static_cast<double>(body) / all;
    fullest = std::max(fullest, fraction);
    if (!(setup_.fill_fraction ? fraction >= 0.01 : fraction >= 0.5)) continue;
    boxes_[number].label = static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
    boxes_[number].value = static_cast<float>(sum / body);
    if (setup_.fill_fraction) boxes_[number].fraction = static_cast<float>(fraction);
  }
  if (std::none_of(boxes_.begin(), boxes_.end(), [](const Box& box) { return box.label >= 0; }))
    (setup_.spacing_place ? *setup_.spacing_place : *setup_.file)
        .fail(fmt::format("leaves no box of {}: the fullest is body by {} %, of which {} % are needed; write a smaller "
                          "`spacing`{}",
                          setup_.file->text(), number(100 * fullest, 2), setup_.fill_fraction ? 1 : 50,
                          setup_.fill_fraction ? "" : ", or `fill_fraction: true`"));
}

/// Reaches all voxels of the outline that are body, or that are not, from one on over faces. Gives their number.
std::size_t Boxes::spread(const std::array<int, 3>& from, bool body, std::vector<bool>& reached) const {
  std::vector<std::array<int, 3>> next;
  std::size_t count = 0;
  const auto reach = [&](int x, int y, int z) {
    const std::array<int, 3> at{x, y, z};
    for (int axis = 0; axis < 3; ++axis)
      if (at[axis] < range_.first[axis] || at[axis] >= range_.last[axis]) return;
    if (reached[voxel(x, y, z)] || (label_of(x, y, z) >= 0) != body) return;
    reached[voxel(x, y, z)] = true, ++count;
    next.push_back(at);
  };
  reach(from[0], from[1], from[2]);
  while (!next.empty()) {
    const auto [x, y, z] = next.back();
    next.pop_back();
    for (const int step : {-1, 1}) reach(x + step, y, z), reach(x, y + step, z), reach(x, y, z + step);
  }
  return count;
}

/// Fills voxels that are no body and that no path over faces of such voxels joins to the outside.
void Boxes::close_holes() {
  std::vector<bool> outside(image_.voxels()), closed(image_.voxels());
  const auto ends_at = [&](int axis, int at) { return at == range_.first[axis] || at == range_.last[axis] - 1; };
  for_voxels([&](int x, int y, int z) {
    if (ends_at(0, x) || ends_at(1, y) || ends_at(2, z)) spread({x, y, z}, false, outside);
  });
  std::size_t count = 0;
  for_voxels([&](int x, int y, int z) {
    if (!outside[voxel(x, y, z)] && label_of(x, y, z) < 0) closed[voxel(x, y, z)] = true, ++count;
  });
  if (count == 0) return;
  closed_ = std::move(closed);
  context_.remarks.notes.push_back(fmt::format("{}: {} of closed holes filled", setup_.file->text(),
                                               counted(static_cast<std::ptrdiff_t>(count), "voxel")));
}

/// A speck in a box between others would join them, and boxes would begin at one outside.
void Boxes::keep_largest_piece() {
  std::vector<bool> reached(image_.voxels());
  std::array<int, 3> largest{};
  std::size_t most = 0, all = 0, pieces = 0;
  for_voxels([&](int x, int y, int z) {
    const std::size_t count = spread({x, y, z}, true, reached);
    if (count == 0) return;
    if (count > most) most = count, largest = {x, y, z};
    all += count, ++pieces;
  });
  if (pieces < 2) return;
  std::vector<bool> kept(image_.voxels());
  spread(largest, true, kept);
  keep([&](int x, int y, int z) { return kept[voxel(x, y, z)]; });
  context_.remarks.notes.push_back(
      fmt::format("{}: {} pieces that share no face, the largest of {} of {} voxels; the others are dropped",
                  setup_.file->path(), pieces, most, all));
}

void Boxes::find_pieces() {
  DisjointSets sets(boxes_.size());
  for_body([&](const Box&, const std::array<int, 3>& at) {
    const auto [x, y, z] = at;
    const int own = static_cast<int>(index(x, y, z));
    if (is_body(x - 1, y, z)) sets.join(own, static_cast<int>(index(x - 1, y, z)));
    if (is_body(x, y - 1, z)) sets.join(own, static_cast<int>(index(x, y - 1, z)));
    if (is_body(x, y, z - 1)) sets.join(own, static_cast<int>(index(x, y, z - 1)));
  });
  std::map<int, std::size_t> pieces;
  for_body([&](const Box&, const std::array<int, 3>& at) {
    ++pieces[sets.set_of(static_cast<int>(index(at[0], at[1], at[2])))];
  });
  if (pieces.size() < 2) return;
  const auto largest =
      std::max_element(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::size_t all = 0;
  for (const auto& [piece, count] : pieces) all += count;
  const std::string text = fmt::format("{}: {} pieces that share no face, the largest of {} of {} boxes",
                                       setup_.file->path(), pieces.size(), largest->second, all);
  if (!setup_.largest) {
    context_.remarks.warnings.push_back(text + "; `pieces: largest` keeps that alone");
    return;
  }
  for (std::size_t box = 0; box < boxes_.size(); ++box)
    if (boxes_[box].label >= 0 && sets.set_of(static_cast<int>(box)) != largest->first) boxes_[box].label = -1;
  context_.remarks.notes.push_back(text + "; the others are dropped");
  if (voxels_ == std::array{1, 1, 1}) return;
  // What is kept may begin elsewhere than what was dropped.
  const VoxelRange before = range_;
  keep([&](int x, int y, int z) { return boxes_[box_with(x, y, z)].label >= 0; });
  if (range_.first == before.first && range_.last == before.last) return;
  lay();
  find_pieces();
}

/// Of a body that grows wider from a grip on, boxes next to the grip have body next to it, which no support holds, and
/// their molecules are held: such boxes are as full as their outer sides alone.
void Boxes::cut_ends() {
  if (setup_.ends < 0) return;
  const int axis = setup_.ends, u = (axis + 1) % 3, v = (axis + 2) % 3;
  double before = 0, after = 0;
  for (const int side : {0, 1}) {
    // Voxels of each box in a layer, counted from the end on.
    const auto filled_in = [&](int layer) {
      std::map<std::size_t, int> filled;
      std::array<int, 3> voxel{};
      voxel[axis] = side ? range_.last[axis] - 1 - layer : range_.first[axis] + layer;
      for (voxel[v] = range_.first[v]; voxel[v] < range_.last[v]; ++voxel[v])
        for (voxel[u] = range_.first[u]; voxel[u] < range_.last[u]; ++voxel[u]) {
          const std::size_t box = box_with(voxel[0], voxel[1], voxel[2]);
          if (boxes_[box].label >= 0 && label_of(voxel[0], voxel[1], voxel[2]) >= 0) ++filled[box];
        }
      return filled;
    };
    const int layers = range_.last[axis] - range_.first[axis];
    int outer = 0;
    std::map<std::size_t, int> filled = filled_in(outer);  // on the outer sides
    while (filled.empty() && outer + 1 < layers) filled = filled_in(++outer);
    ends_[side] = box_of_[axis][side ? range_.last[axis] - 1 - outer : range_.first[axis] + outer];
    warn_of_rough_end(side, filled, outer + 1 < layers ? filled_in(outer + 1) : filled);
    for_body([&](const Box& box, const std::array<int, 3>& at) {
      if (at[axis] != ends_[side]) return;
      const auto found = filled.find(index(at[0], at[1], at[2]));
      Box& own = boxes_[index(at[0], at[1], at[2])];
      before += double{box.fraction} * volume(at);
      const double part = found == filled.end() ? 0 : double(found->second) / (length(u, at[u]) * length(v, at[v]));
      own.fraction = std::min(box.fraction, static_cast<float>(part));
      after += double{own.fraction} * volume(at);
      if (found == filled.end()) own.label = -1;
    });
  }
  context_.remarks.notes.push_back(
      fmt::format("{}: of the boxes at the ends {} % is not covered by them and is left out", setup_.file->text(),
                  number(100 * (1 - after / before), 3)));
}

/// A speck on an end would be all that a grip holds.
void Boxes::warn_of_rough_end(int side, const std::map<std::size_t, int>& outermost,
                              const std::map<std::size_t, int>& next) const {
  const auto voxels_in = [](const std::map<std::size_t, int>& layer) {
    int voxels = 0;
    for (const auto& [box, count] : layer) voxels += count;
    return voxels;
  };
  const int held = voxels_in(outermost), all = voxels_in(next);
  if (2 * held >= all) return;
  const char axis = "ijk"[setup_.ends];
  Eigen::Index along = 0;
  image_.steps.col(setup_.ends).cwiseAbs().maxCoeff(&along);
  context_.remarks.warnings.push_back(
      fmt::format("{}: the outermost layer at `{} {}` has {}, the next {}: the grip holds the outermost one alone; cut "
                  "it off with `{}`",
                  setup_.file->path(), side ? "high" : "low", axis, counted(held, "voxel"), all,
                  (image_.steps(along, setup_.ends) > 0) == (side == 0) ? "from" : "to"));
}

/// What lies in no cube of two boxes a side, and on none: a step of the surface is no thin place.
void Boxes::find_thin_places() const {
  std::size_t thin = 0, all = 0;
  const auto in_cube = [&](int x, int y, int z) {
    bool found = false;
    for (int corner = 0; corner < 8 && !found; ++corner) {
      found = true;
      for (int c = 0; c < 8 && found; ++c)
        found = is_body(x + c % 2 - corner % 2, y + c / 2 % 2 - corner / 2 % 2, z + c / 4 - corner / 4);
    }
    return found;
  };
  for_body([&](const Box&, const std::array<int, 3>& at) {
    const auto& [x, y, z] = at;
    ++all, thin += !(in_cube(x, y, z) || in_cube(x - 1, y, z) || in_cube(x + 1, y, z) || in_cube(x, y - 1, z) ||
                     in_cube(x, y + 1, z) || in_cube(x, y, z - 1) || in_cube(x, y, z + 1));
  });
  constexpr std::size_t few = 50;  // one in this many: single steps of a slanted surface
  if (thin > 0)
    (thin * few > all ? context_.remarks.warnings : context_.remarks.notes)
        .push_back(fmt::format(
            "{}: the body is thinner than two boxes at {} of {} boxes ({} %): it bends there as no solid does",
            setup_.file->path(), thin, all, number(100. * static_cast<double>(thin) / static_cast<double>(all), 3)));
}

void Boxes::number_corners() {
  const auto lines = [&](int axis) { return static_cast<std::size_t>(counts_[axis]) + 1; };
  numbers_.assign(lines(0) * lines(1) * lines(2), -1);
  const auto corner = [&](int x, int y, int z) -> int& {
    return numbers_[static_cast<std::size_t>(x) +
                    lines(0) * (static_cast<std::size_t>(y) + lines(1) * static_cast<std::size_t>(z))];
  };
  for_body([&](const Box&, const std::array<int, 3>& at) {
    for (int c = 0; c < 8; ++c) corner(at[0] + c % 2, at[1] + c / 2 % 2, at[2] + c / 4) = kUnnumbered;
  });
  for (int z = 0; z <= counts_[2]; ++z)
    for (int y = 0; y <= counts_[1]; ++y)
      for (int x = 0; x <= counts_[0]; ++x)
        if (int& number = corner(x, y, z); number == kUnnumbered) {
          number = static_cast<int>(halves_.size());
          halves_.push_back({2 * x, 2 * y, 2 * z});
        }
  setup_.file->check_size(static_cast<double>(halves_.size()));
}

Vector3 Boxes::place(const Vector3& at) const {
  Vector3 voxel;
  for (int axis = 0; axis < 3; ++axis) {
    const int box = std::min(static_cast<int>(at[axis]), counts_[axis] - 1);
    voxel[axis] = planes_[axis][box] + (at[axis] - box) * length(axis, box) - 0.5;
  }
  return setup_.length_unit * (image_.origin + image_.steps * voxel);
}

double Boxes::volume(const std::array<int, 3>& at) const {
  double voxels = 1;
  for (int axis = 0; axis < 3; ++axis) voxels *= length(axis, at[axis]);
  return voxels * std::abs(image_.steps.determinant()) * std::pow(setup_.length_unit, 3);
}

double Boxes::stiffness(const Box& box) const {
  const double own = (parts_ ? materials_[box.label] : *context_.material).youngs_modulus;
  const double modulus = modulus_of_ && !has_own(box.label, "youngs_modulus")
                             ? modulus_of_(double{box.value})
                             : labels_[box.label].youngs_modulus.value_or(own);
  return double{box.fraction} * modulus / own;
}

void Boxes::report() const {
  std::vector<std::size_t> counts(labels_.size(), 0);
  std::vector<double> volumes(labels_.size(), 0);
  double whole = 0, filled = 0;
  for_body([&](const Box& box, const std::array<int, 3>& at) {
    ++counts[box.label];
    volumes[box.label] += double{box.fraction} * volume(at);
    whole += volume(at), filled += double{box.fraction} * volume(at);
  });
  if (filled < 0.99 * whole && !context_.remarks.section_is_given)
    context_.remarks.warnings.push_back(fmt::format(
        "{}: sections count whole boxes, {:.3g} times what is filled: give `cross_section` where a modulus is "
        "read",
        setup_.file->path(), whole / filled));
  std::vector<std::size_t> found(labels_.size(), 0);  // voxels
  if (std::find(counts.begin(), counts.end(), std::size_t{0}) != counts.end())
    for_voxels([&](int x, int y, int z) {
      if (const int label = label_of(x, y, z); label >= 0) ++found[label];
    });
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    texts.push_back(fmt::format("{} ({} boxes, {:.4g} cm3)", labels_[i].name, counts[i], 1e6 * volumes[i]));
    if (counts[i] == 0)
      context_.remarks.warnings.push_back(
          found[i] == 0
              ? fmt::format("{}: no voxel of the body has the label {}", setup_.file->path(), labels_[i].name)
              : fmt::format("{}: no box is of the label {}, of which the body has {}: a box is of the label that most "
                            "of its voxels have; write a smaller `spacing`",
                            setup_.file->path(), labels_[i].name,
                            counted(static_cast<std::ptrdiff_t>(found[i]), "voxel")));
  }
  context_.remarks.notes.push_back(fmt::format(
      "{}: {} x {} x {} voxels, {} a box; coordinates as in the file{}; labels: {}; the surface is "
      "stepped, and stresses there are not to be read{}",
      setup_.file->text(), image_.size[0], image_.size[1], image_.size[2],
      fmt::format("{} x {} x {}", voxels_[0], voxels_[1], voxels_[2]),
      image_.space.empty() ? "" : " (" + image_.space + ")", listed(texts),
      voxels_ == std::array{1, 1, 1} ? "" : "; a computed reference has smaller boxes, down to the image's voxels"));
}

MoleculeSets Boxes::sets() const {
  MoleculeSets sets;
  if (setup_.as == ImageCells::packing) return sets;
  const auto lines = [&](int axis) { return static_cast<std::size_t>(counts_[axis]) + 1; };
  for_body([&](const Box& box, const std::array<int, 3>& at) {
    for (int c = 0; c < 8; ++c) {
      const int molecule = numbers_[static_cast<std::size_t>(at[0] + c % 2) +
                                    lines(0) * (static_cast<std::size_t>(at[1] + c / 2 % 2) +
                                                lines(1) * static_cast<std::size_t>(at[2] + c / 4))];
      sets[labels_[box.label].name].push_back(molecule);
      for (const int side : {0, 1})
        if (setup_.ends >= 0 && at[setup_.ends] == ends_[side] && (c >> setup_.ends & 1) == side)
          sets[std::string(side ? "high " : "low ") + "ijk"[setup_.ends]].push_back(molecule);
    }
  });
  for (auto& [name, members] : sets) {
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
  }
  return sets;
}

Positions Boxes::outline() const {
  const auto is_voxel = [&](int x, int y, int z) {
    return boxes_[box_with(x, y, z)].label >= 0 && label_of(x, y, z) >= 0;
  };
  // Of each layer of voxels, the points in its middle and those on either side of it, in halves of voxels.
  std::vector<std::vector<std::array<int, 2>>> layers(2 * static_cast<std::size_t>(image_.size[2]) + 1);
  for (int z = range_.first[2]; z < range_.last[2]; ++z)
    for (int y = range_.first[1]; y < range_.last[1]; ++y) {
      int first = range_.first[0], last = range_.last[0] - 1;
      while (first <= last && !is_voxel(first, y, z)) ++first;
      while (last > first && !is_voxel(last, y, z)) --last;
      if (first > last) continue;
      const auto middle = 2 * static_cast<std::size_t>(z) + 1;
      for (const int x : {first, last}) {
        for (const int side : {-1, 1}) {
          layers[middle].push_back({2 * x + side, 2 * y});
          layers[middle].push_back({2 * x, 2 * y + side});
        }
        for (const std::size_t layer : {middle - 1, middle + 1}) layers[layer].push_back({2 * x, 2 * y});
      }
    }
  std::vector<Vector3> kept;
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    Points2 points(2, static_cast<Eigen::Index>(layers[layer].size()));
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      points.col(i) << layers[layer][static_cast<std::size_t>(i)][0], layers[layer][static_cast<std::size_t>(i)][1];
    if (points.cols() == 0) continue;
    const Points2 hull = convex_hull(points);
    for (const auto& point : (hull.cols() < 3 ? points : hull).colwise())  // on one line there is no hull
      kept.emplace_back(point[0] / 2, point[1] / 2, (static_cast<double>(layer) - 1) / 2);
  }
  Positions result(3, static_cast<Eigen::Index>(kept.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i)
    result.col(i) = setup_.length_unit * (image_.origin + image_.steps * kept[static_cast<std::size_t>(i)]);
  return result;
}

/// A random close packing of the outline, as far as it lies in the body.
void Boxes::set_packing(Body& body) const {
  Vector3 first, voxels;
  for (int axis = 0; axis < 3; ++axis)
    first[axis] = range_.first[axis], voxels[axis] = range_.last[axis] - range_.first[axis];
  const Vector3 steps = setup_.length_unit * image_.steps.colwise().norm().transpose();
  const Vector3 sides = steps.cwiseProduct(voxels);
  const double distance = setup_.spacing.value_or(2 * std::cbrt(steps.prod()));
  setup_.file->check_size((sides.array() / distance + 1).prod());
  const Body whole = random_packing(sides, distance, 1.5 * distance, setup_.seed);
  const auto inside = [&](const Vector3& at) {
    std::array<int, 3> box{};
    for (int axis = 0; axis < 3; ++axis)
      box[axis] = box_of_[axis][std::clamp(range_.first[axis] + static_cast<int>(at[axis] / steps[axis]),
                                           range_.first[axis], range_.last[axis] - 1)];
    return is_body(box[0], box[1], box[2]);
  };
  std::vector<int> number(whole.size(), -1), kept;
  for (int a = 0; a < whole.size(); ++a)
    if (inside(whole.rest.col(a))) number[a] = static_cast<int>(kept.size()), kept.push_back(a);
  body.rest.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Vector3 voxel = first + whole.rest.col(kept[i]).cwiseQuotient(steps) - Vector3::Constant(0.5);
    body.rest.col(static_cast<Eigen::Index>(i)) = setup_.length_unit * (image_.origin + image_.steps * voxel);
  }
  for (const auto& [a, b] : whole.connections.ends)
    if (number[a] >= 0 && number[b] >= 0 && inside((whole.rest.col(a) + whole.rest.col(b)) / 2))
      body.connections.ends.push_back({number[a], number[b]});
  body.connections.rest_length.resize(body.connections.ends.size());
  set_present_lengths(body);
}

Body Boxes::body() {
  Body body;
  if (setup_.as == ImageCells::packing) {
    set_packing(body);
    return body;
  }
  body.rest.resize(3, static_cast<Eigen::Index>(halves_.size()));
  for (std::size_t i = 0; i < halves_.size(); ++i)
    body.rest.col(static_cast<Eigen::Index>(i)) = place(Vector3(halves_[i][0], halves_[i][1], halves_[i][2]) / 2);
  const auto lines = [&](int axis) { return static_cast<std::size_t>(counts_[axis]) + 1; };
  const int mirrored = image_.steps.determinant() < 0 ? 1 : 0;
  Cells<8> cubes;
  for_body([&](const Box&, const std::array<int, 3>& at) {
    auto& cube = cubes.emplace_back();
    for (int c = 0; c < 8; ++c)
      cube[c] = numbers_[static_cast<std::size_t>(at[0] + c % 2) +
                         lines(0) * (static_cast<std::size_t>(at[1] + c / 2 % 2) +
                                     lines(1) * static_cast<std::size_t>(at[2] + (c / 4 ^ mirrored)))];
  });
  if (setup_.as == ImageCells::hexahedra) {
    body.blocks.emplace_back().kind = &cell_kind("hexahedron8");
    for (const auto& cube : cubes)
      for (const int corner : {0, 1, 3, 2, 4, 5, 7, 6}) body.blocks.back().nodes.push_back(cube[corner]);
    set_simplices(body);
  } else if (setup_.as == ImageCells::tetrahedra) {
    for (const auto& cube : cubes)
      for (const auto& [one, other] : {std::array{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}})
        body.tetrahedra.push_back({cube[0], cube[one], cube[other], cube[7]});
    body.connections = connections_of_cells(body.rest, {}, body.tetrahedra);
  } else {
    auto& ends = body.connections.ends;
    for (const auto& cube : cubes)
      for (int a = 0; a < 8; ++a)
        for (int b = a + 1; b < 8; ++b)
          if ((a ^ b) != 7) ends.push_back({std::min(cube[a], cube[b]), std::max(cube[a], cube[b])});
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    body.connections.rest_length.resize(ends.size());
    set_present_lengths(body);
    body.cubes = cubes;
  }
  if (setup_.order == 2) body = setup_.order_place->located([&] { return with_order(body, 2); });
  for (const MoleculeBetween& between : body.between) {
    Vector3 sum = Vector3::Zero();
    for (const auto& [of, weight] : between) sum += weight * Vector3(halves_[of][0], halves_[of][1], halves_[of][2]);
    halves_.push_back({static_cast<int>(std::lround(sum[0])), static_cast<int>(std::lround(sum[1])),
                       static_cast<int>(std::lround(sum[2]))});
  }
  if (parts_) part(body);
  return body;
}

/// Makes a part of each label; molecules get other numbers.
void Boxes::part(Body& body) {
  std::vector<int> labels;
  const int each = setup_.as == ImageCells::tetrahedra ? 6 : 1;
  for_body([&](const Box& box, const std::array<int, 3>&) { labels.insert(labels.end(), each, box.label); });
  RenumberedBody parted = parts_of_labels(body, labels);
  std::vector<int> number(parted.molecule_from.size());
  const auto halves = halves_;
  for (std::size_t at = 0; at < number.size(); ++at) {
    number[parted.molecule_from[at]] = static_cast<int>(at);
    halves_[at] = halves[parted.molecule_from[at]];
  }
  for (int& own : numbers_)
    if (own >= 0) own = number[own];
  body = std::move(parted.body);
  for (Part& part : body.parts) {
    const int label = std::stoi(part.name);
    part.name = labels_[label].name, part.material = label + 1;
  }
}

void Boxes::set_matter(Body& body) const {
  double all = 0;
  VectorX volumes = VectorX::Zero(body.size());
  const auto lines = [&](int axis) { return static_cast<std::size_t>(counts_[axis]) + 1; };
  bool varied = false;
  std::vector<double> factors(boxes_.size());
  std::size_t boxes = 0;
  for_body([&](const Box&, const std::array<int, 3>&) { ++boxes; });
  std::vector<int> next(body.blocks.size(), 0);          // cell of each block
  std::vector<std::size_t> block_of(labels_.size(), 0);  // of the labels that are parts
  for (std::size_t i = 0; i < body.parts.size(); ++i) block_of[body.parts[i].material - 1] = i;
  VectorX shares;  // of the molecules of a cell
  if (!body.blocks.empty()) shares = body.blocks[0].kind->values.cwiseAbs2() * body.blocks[0].kind->weights;
  if (!body.blocks.empty())
    shares *= static_cast<double>(boxes) / static_cast<double>(cells_in_blocks(body)) / shares.sum();
  for_body([&](const Box& box, const std::array<int, 3>& at) {
    const double own = context_.material->density;
    const double of_label = parts_ ? materials_[box.label].density : labels_[box.label].density.value_or(own);
    const double density = density_of_ && !has_own(box.label, "density") ? density_of_(double{box.value}) : of_label;
    const double of_box = double{box.fraction} * volume(at) * density / own;
    all += of_box;
    varied |= (factors[index(at[0], at[1], at[2])] = stiffness(box)) != 1;
    if (setup_.as == ImageCells::packing) return;
    if (setup_.order == 2) {
      const std::size_t block = parts_ ? block_of[box.label] : 0;
      for (std::size_t i = 0; i < cells_in_blocks(body) / boxes; ++i) {
        const auto nodes = body.blocks[block].cell(next[block]++);
        for (int a = 0; a < shares.size(); ++a) volumes[nodes[a]] += of_box * shares[a];
      }
      return;
    }
    for (int c = 0; c < 8; ++c)
      volumes[numbers_[static_cast<std::size_t>(at[0] + c % 2) +
                       lines(0) * (static_cast<std::size_t>(at[1] + c / 2 % 2) +
                                   lines(1) * static_cast<std::size_t>(at[2] + c / 4))]] += of_box / 8;
  });
  if (setup_.as == ImageCells::packing) volumes.setConstant(all / body.size());
  context_.volumes = volumes;
  if (!varied) return;
  if (setup_.as == ImageCells::packing)
    setup_.file->fail(
        "a packing has one stiffness: leave out materials of labels, `youngs_modulus` and `fill_fraction`");
  for (const Material& material : parts_ ? materials_ : std::vector{*context_.material})
    if (material.curve || material.fibre)
      setup_.file->fail("stiffness that varies needs a material without curve or fibre");
  // What lies on a face or edge has the mean of the boxes around it.
  change_stiffness(body, [&](const auto& molecules, double& factor) {
    std::array<int, 3> low = halves_[*molecules.begin()], high = low;
    for (const int molecule : molecules)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], halves_[molecule][axis]);
        high[axis] = std::max(high[axis], halves_[molecule][axis]);
      }
    const auto first = [&](int axis) { return (low[axis] - (low[axis] == high[axis])) >> 1; };
    double sum = 0;
    int count = 0;
    for (int z = first(2); z <= low[2] >> 1; ++z)
      for (int y = first(1); y <= low[1] >> 1; ++y)
        for (int x = first(0); x <= low[0] >> 1; ++x)
          if (is_body(x, y, z)) sum += factors[index(x, y, z)], ++count;
    if (count > 0) factor *= sum / count;
  });
}

void Boxes::set_ratios() const {
  const auto own = std::find_if(labels_.begin(), labels_.end(), [](const Label& one) { return one.ratio_place; });
  if (parts_ || own == labels_.end()) return;
  if (context_.material->law) own->ratio_place->fail("needs a material without a law");
  if (!context_.remarks.field) own->ratio_place->fail("needs a scene of one body");
  std::vector<double> ratios;
  for (const Label& one : labels_) ratios.push_back(one.poissons_ratio.value_or(context_.material->poissons_ratio));
  *context_.remarks.field = MaterialField{[ratios, at = label_at()](Material& material, const Vector3& place) {
    if (const int label = at(place); label >= 0) material.poissons_ratio = ratios[label];
  }};
}

std::function<int(const Vector3&)> Boxes::label_at() const {
  std::vector<std::int16_t> label_of;
  for (const Box& box : boxes_) label_of.push_back(static_cast<std::int16_t>(box.label));
  return [=, unit = setup_.length_unit, origin = image_.origin, steps = image_.steps.inverse().eval(), range = range_,
          box_of = box_of_, counts = counts_](const Vector3& place) {
    const Vector3 voxel = steps * (place / unit - origin);
    std::size_t box = 0;
    for (int axis = 2; axis >= 0; --axis)
      box = box * static_cast<std::size_t>(counts[axis]) +
            static_cast<std::size_t>(box_of[axis][static_cast<std::size_t>(
                std::clamp(voxel[axis] + 0.5, double(range.first[axis]), range.last[axis] - 0.5))]);
    return label_of[box];
  };
}

/// Of at most 96 voxels along each axis.
void Boxes::set_shades(BodyImage& own) const {
  std::array<int, 3> step{};
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = (image_.size[axis] + 95) / 96;
    own.shown[axis] = (image_.size[axis] + step[axis] - 1) / step[axis];
  }
  std::vector<double> values;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int z = 0; z < image_.size[2]; z += step[2])
    for (int y = 0; y < image_.size[1]; y += step[1])
      for (int x = 0; x < image_.size[0]; x += step[0]) {
        values.push_back(image_.at(x, y, z));
        if (std::isfinite(values.back())) low = std::min(low, values.back()), high = std::max(high, values.back());
      }
  for (const double value : values)
    own.shades.push_back(high > low && value > low ? static_cast<std::uint8_t>(std::lround(
                                                         255 * (std::min(value, high) - low) / (high - low)))
                                                   : std::uint8_t{0});
}

void Boxes::set_specimen(const Body& body) const {
  Specimen* specimen = context_.remarks.specimen;
  if (!specimen) return;
  std::vector<double> numbers;
  for (const Label& label : labels_) numbers.push_back(setup_.labels.empty() ? 1 : label.number);
  auto own = std::make_shared<BodyImage>();
  static_cast<mesh::ImageGrid&>(*own) = image_;
  own->length_unit = setup_.length_unit;
  own->number = [numbers, at = label_at()](const Vector3& place) {
    const int label = at(place);
    return label < 0 ? 0 : numbers[label];
  };
  if (voxels_ != std::array{1, 1, 1} && setup_.as != ImageCells::packing) own->finer_spacing = *setup_.spacing / 2;
  set_shades(*own);
  specimen->image = std::move(own);
  if (!parts_) return;
  specimen->materials = {*context_.material};
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    if (labels_[i].material) check_material(*labels_[i].material, materials_[i], body);
    specimen->materials.push_back(materials_[i]);
  }
}

void warn_of_grey_values(const mesh::Image& image, const ImageSetup& setup, ShapeContext& context) {
  const mesh::ImageValues values = mesh::values_of(image);
  if (values.labels) return;
  context.remarks.warnings.push_back(fmt::format(
      "{}: the image has grey values, and each voxel that is not 0 is body; a `threshold` states from which "
      "value on it is, such as {:.3g} by Otsu's rule",
      setup.file->path(), values.threshold));
}

Body make_body(const ImageSetup& setup, ShapeContext& context) {
  mesh::Image image = setup.file->located([&] {
    return mesh::load_image(setup.path, [&](mesh::ImageGrid grid) {
      if (setup.voxel_size) grid.steps = (grid.steps * (*setup.voxel_size / setup.length_unit).asDiagonal()).eval();
      check_boxes(grid, setup);
    });
  });
  if (image.has_steps && setup.voxel_size)
    setup.file->fail("the file states the size of its voxels; leave `voxel_size` out");
  if (!image.has_steps && !setup.voxel_size)
    setup.file->fail("the file does not state the size of its voxels; write `voxel_size: [1 mm, 1 mm, 1 mm]`");
  if (setup.voxel_size) image.steps = (image.steps * (*setup.voxel_size / setup.length_unit).asDiagonal()).eval();
  if (image.unit > 0 && std::abs(image.unit / setup.length_unit - 1) > 1e-6)
    context.remarks.warnings.push_back(setup.file->path() +
                                       ": the file states another unit of length than `length_unit`, which counts");
  if (setup.labels.empty() && !setup.threshold) warn_of_grey_values(image, setup, context);
  Boxes boxes(image, setup, context);
  Body body = boxes.body();
  MoleculeSets sets = boxes.sets();
  if (context.remarks.sets) *context.remarks.sets = sets;
  context.map.set_mesh_sets(std::move(sets));
  boxes.set_matter(body);
  boxes.set_ratios();
  boxes.set_specimen(body);
  if (setup.as != ImageCells::packing) body.outline = boxes.outline();
  return body;
}

}  // namespace

Shape image_shape() {
  using S = ImageSetup;
  return shape(
      "image", ", the voxels of a segmentation or scan",
      Keys<S>{
          Key<S>(mesh_file_key(std::string("an image: ") + mesh::image_endings())), length_unit_key(),
          Key<S>({"labels", "list of numbers, or map of number to `{name, material}`", "", "", "every value but 0",
                  "the labels that are body; each is a set of that name; one with more than E, ν and density in its "
                  "`material`, a `law` for instance, makes each of them a body of its own, joined to the others"},
                 [](const Reader& value, S& setup, const Frame&) { read_labels(value, setup); }),
          Key<S>(key::quantity("threshold", &S::threshold, dimension::none, "grey value from which on a voxel is body"))
              .otherwise("none")
              .place(&S::threshold_place)
              .refused_for([](const S& setup) {
                return setup.threshold && !setup.labels.empty() ? "does not go with `labels`" : "";
              }),
          key::choice("as", &S::as,
                      {{"hexahedra", ImageCells::hexahedra},
                       {"lattice", ImageCells::lattice},
                       {"tetrahedra", ImageCells::tetrahedra},
                       {"packing", ImageCells::packing}},
                      "a cell a box, its edges and face diagonals as connections, six tetrahedra a box, or molecules "
                      "at random"),
          key::vector("voxel_size", &S::voxel_size, dimension::length, "of files that do not state it", kPositive),
          key::quantity("spacing", &S::spacing, dimension::length,
                        "side of the boxes, rounded to whole voxels; distance of the molecules of a packing", kPositive)
              .otherwise("a voxel; of a packing two")
              .place(&S::spacing_place),
          key::flag("fill_fraction", &S::fill_fraction,
                    "whether a box is as stiff and heavy as the part of its voxels that is body; otherwise it is body "
                    "where half of it is"),
          Key<S>(key::quantity(
                     "smoothing", &S::smoothing, dimension::length,
                     "standard deviation of a Gaussian that smooths the labels, the volume of the body being kept; at "
                     "most 20 voxels",
                     kPositive))
              .otherwise("none")
              .place(&S::smoothing_place),
          Key<S>(order_key()).refused_for([](const S& setup) {
            return setup.order && (setup.as == ImageCells::lattice || setup.as == ImageCells::packing)
                       ? "goes with `as: hexahedra` and `as: tetrahedra`"
                       : "";
          }),
          key::choice(
              "ends", &S::ends, {{"i", 0}, {"j", 1}, {"k", 2}},
              "axis of the image at whose ends grips hold the sets `low k` and `high k` (or of i, j): boxes there "
              "are as stiff as their outer sides are filled")
              .otherwise("none")
              .refused_for([](const S& setup) {
                return setup.ends >= 0 && !setup.fill_fraction ? "goes with `fill_fraction: true`" : "";
              }),
          key::choice("pieces", &S::largest, {{"all", false}, {"largest", true}},
                      "which pieces that share faces are kept"),
          key::choice("holes", &S::close, {{"keep", false}, {"close", true}}, "whether closed holes are filled"),
          key::vector("from", &S::from, dimension::length, "lowest coordinates of voxels that are read")
              .place(&S::from_place),
          key::vector("to", &S::to, dimension::length, "highest coordinates of voxels that are read")
              .place(&S::to_place),
          key::later({"youngs_modulus", "formula of `value`", "Pa", "> 0", "the material's",
                      "E from the grey value, of labels that state none of their own: `2 kPa * (value / 100)^2`"},
                     &S::youngs_modulus),
          key::later({"density", "formula of `value`", "kg/m³", "> 0", "the material's",
                      "density from the grey value, of labels that state none of their own"},
                     &S::density),
          seed_key(&S::seed)},
      make_body);
}

}  // namespace elastin::lab
