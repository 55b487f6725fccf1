#include "lab/scene/image_boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "core/simulation/warnings.h"
#include "elastin/core/base/text.h"

namespace elastin::lab {
namespace {

constexpr int kUnnumbered = -2;

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

}  // namespace

std::array<int, 3> voxels_of_box(const mesh::ImageGrid& grid, const ImageSetup& setup) {
  std::array<int, 3> voxels{1, 1, 1};
  for (int axis = 0; axis < 3 && setup.spacing; ++axis) {
    const double step = setup.length_unit * grid.steps.col(axis).norm();
    voxels[axis] = std::clamp(static_cast<int>(std::lround(std::min(1e6, *setup.spacing / step))), 1, grid.size[axis]);
  }
  return voxels;
}

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
ImageBoxes::ImageBoxes(const mesh::Image& image, const mesh::Image& grey, const ImageSetup& setup,
                       ShapeContext& context)
    : image_(image),
      grey_(grey),
      setup_(setup),
      context_(context),
      slack_(1e-6 * setup.length_unit * image.steps.colwise().norm().minCoeff()),
      range_(cropped(image, setup)),
      voxels_(voxels_of_box(image, setup)),
      labels_(setup.labels) {
  if (labels_.empty()) labels_.push_back({0, setup.threshold ? "body" : "not 0"});
  const auto nearly_incompressible = [&](const ImageLabel& label) {
    return label.poissons_ratio.value_or(context.material->poissons_ratio) > kLocking;
  };
  const auto has_material = [](const ImageLabel& label) { return label.material.has_value(); };
  parts_ = setup.parts || (setup.as == ImageCells::tetrahedra && context.remarks.specimen &&
                           std::any_of(labels_.begin(), labels_.end(), has_material) &&
                           std::any_of(labels_.begin(), labels_.end(), nearly_incompressible));
  if (parts_) {
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      const ImageLabel& label = labels_[i];
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

int ImageBoxes::label_of(int x, int y, int z) const {
  x = before_hole(x, y, z);
  if (setup_.from || setup_.to) {
    const Vector3 place = setup_.length_unit * (image_.origin + image_.steps * Vector3(x, y, z));
    if ((setup_.from && (place.array() < setup_.from->array() - slack_).any()) ||
        (setup_.to && (place.array() > setup_.to->array() + slack_).any()))
      return -1;
  }
  return relabelled_.empty() ? label_of(image_.at(x, y, z)) : relabelled_[voxel(x, y, z)];
}

int ImageBoxes::label_of(double value) const {
  if (setup_.labels.empty())
    return (setup_.threshold ? value >= *setup_.threshold : value != 0 && !std::isnan(value)) ? 0 : -1;
  for (std::size_t i = 0; i < labels_.size(); ++i)
    if (labels_[i].number == value) return static_cast<int>(i);
  return -1;
}

/// Where a voxel has a label, or any where that is −1: 1, else 0, smoothed by a Gaussian. Beyond the image it goes on
/// as it ends.
std::vector<float> ImageBoxes::blurred(const std::vector<std::int16_t>& labels, int label) const {
  std::vector<float> values(labels.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = label < 0 ? labels[i] >= 0 : labels[i] == label;
  for (int axis = 0, stride = 1; axis < 3; stride *= image_.size[axis++]) {
    const double deviation = *setup_.smoothing / (setup_.length_unit * image_.steps.col(axis).norm());
    const int reach = static_cast<int>(std::ceil(3 * deviation)), size = image_.size[axis];
    std::vector<float> weights, line(size);
    for (int i = -reach; i <= reach; ++i)
      weights.push_back(static_cast<float>(std::exp(-i * i / (2 * deviation * deviation))));
    const float sum = std::accumulate(weights.begin(), weights.end(), 0.f);
    for (std::size_t first = 0; first < values.size(); ++first) {
      if (first / stride % size != 0) continue;
      const auto at = [&](std::size_t i) -> float& { return values[first + i * stride]; };
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
void ImageBoxes::smooth() {
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
void ImageBoxes::find_outline() {
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

void ImageBoxes::fail_without_body() const {
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
void ImageBoxes::lay() {
  for (int axis = 0; axis < 3; ++axis) {
    const int first = range_.first[axis], last = range_.last[axis], step = voxels_[axis];
    std::vector<int>& planes = planes_[axis] = {first};
    while (2 * (last - planes.back()) >= 3 * step) planes.push_back(planes.back() + step);
    if (planes.back() < last) planes.push_back(last);
    counts_[axis] = static_cast<int>(planes.size()) - 1;
    box_of_[axis].assign(image_.size[axis], 0);
    for (int box = 0; box < counts_[axis]; ++box)
      std::fill(box_of_[axis].begin() + planes[box], box_of_[axis].begin() + planes[box + 1], box);
  }
  fill();
}

void ImageBoxes::fill() {
  boxes_.assign(std::size_t{1} * counts_[0] * counts_[1] * counts_[2], {});
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
std::size_t ImageBoxes::spread(const std::array<int, 3>& from, bool body, std::vector<bool>& reached) const {
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
void ImageBoxes::close_holes() {
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
void ImageBoxes::keep_largest_piece() {
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

void ImageBoxes::find_pieces() {
  DisjointSets sets(boxes_.size());
  for_body([&](const Box&, const std::array<int, 3>& at) {
    const auto [x, y, z] = at;
    const int own = static_cast<int>(index(x, y, z));
    if (is_body(x - 1, y, z)) sets.join(own, static_cast<int>(index(x - 1, y, z)));
    if (is_body(x, y - 1, z)) sets.join(own, static_cast<int>(index(x, y - 1, z)));
    if (is_body(x, y, z - 1)) sets.join(own, static_cast<int>(index(x, y, z - 1)));
  });
  if (voxels_ != std::array{1, 1, 1} && !setup_.largest) warn_of_joined_pieces(sets);
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
    for (std::size_t box = 0; box < boxes_.size(); ++box) pieces_.push_back(sets.set_of(static_cast<int>(box)));
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

/// Boxes of several voxels close gaps between pieces of the image, in which they are half or more body.
void ImageBoxes::warn_of_joined_pieces(DisjointSets& boxes) const {
  struct VoxelRun {
    int first, last;  ///< voxels along x, of which the last is not in it
  };
  const int rows = range_.last[1] - range_.first[1];
  std::vector<VoxelRun> runs;
  std::vector<std::size_t> begin{0};  // of each row of voxels
  for (int z = range_.first[2]; z < range_.last[2]; ++z)
    for (int y = range_.first[1]; y < range_.last[1]; ++y) {
      for (int x = range_.first[0]; x < range_.last[0]; ++x) {
        if (label_of(x, y, z) < 0) continue;
        if (runs.size() > begin.back() && runs.back().last == x)
          ++runs.back().last;
        else
          runs.push_back({x, x + 1});
      }
      begin.push_back(runs.size());
    }
  DisjointSets pieces(runs.size());
  const auto join_rows = [&](std::size_t row, std::size_t before) {
    for (std::size_t a = begin[row], b = begin[before]; a < begin[row + 1] && b < begin[before + 1];) {
      if (runs[a].first < runs[b].last && runs[b].first < runs[a].last)
        pieces.join(static_cast<int>(a), static_cast<int>(b));
      runs[a].last < runs[b].last ? ++a : ++b;
    }
  };
  const auto in_layer = static_cast<std::size_t>(rows);
  for (std::size_t row = 0; row + 1 < begin.size(); ++row) {
    if (row % in_layer > 0) join_rows(row, row - 1);
    if (row >= in_layer) join_rows(row, row - in_layer);
  }
  std::map<int, std::map<int, std::size_t>> found;  // of each piece of voxels, how many lie in each piece of boxes
  std::size_t all = 0;
  for (std::size_t row = 0; row + 1 < begin.size(); ++row)
    for (std::size_t run = begin[row]; run < begin[row + 1]; ++run)
      for (int x = runs[run].first; x < runs[run].last; ++x, ++all) {
        const std::size_t box = box_with(x, range_.first[1] + static_cast<int>(row % in_layer),
                                         range_.first[2] + static_cast<int>(row / in_layer));
        if (boxes_[box].label >= 0) ++found[pieces.set_of(static_cast<int>(run))][boxes.set_of(static_cast<int>(box))];
      }
  constexpr std::size_t speck = 100;  // a piece of less than one in this many voxels
  std::map<int, int> joined;          // pieces of voxels, by the piece of boxes that most of each lies in
  for (const auto& [piece, in_boxes] : found) {
    std::size_t own = 0;
    for (const auto& [boxes_piece, count] : in_boxes) own += count;
    const auto most = std::max_element(in_boxes.begin(), in_boxes.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (own * speck >= all) ++joined[most->first];
  }
  int separate = 0;
  for (const auto& [piece, count] : joined) separate += count;
  if (separate == static_cast<int>(joined.size())) return;
  context_.remarks.warnings.push_back(fmt::format(
      "{}: {} pieces of the image that share no face make {} of the body: boxes of {} x {} x {} voxels close the gaps "
      "between them; write a smaller `spacing`, or `pieces: largest` to keep one of them",
      setup_.file->path(), separate, counted(static_cast<std::ptrdiff_t>(joined.size()), "piece"), voxels_[0],
      voxels_[1], voxels_[2]));
}

/// Of a body that grows wider from a grip on, boxes next to the grip have body next to it, which no support holds, and
/// their molecules are held: such boxes are as full as their outer sides alone.
void ImageBoxes::cut_ends() {
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
void ImageBoxes::warn_of_rough_end(int side, const std::map<std::size_t, int>& outermost,
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
void ImageBoxes::find_thin_places() const {
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

void ImageBoxes::number_corners() {
  numbers_.assign((std::size_t{1} + counts_[0]) * (1 + counts_[1]) * (1 + counts_[2]), -1);
  for_body([&](const Box&, const std::array<int, 3>& at) {
    for (int c = 0; c < 8; ++c) numbers_[corner(at, c)] = kUnnumbered;
  });
  for (int z = 0; z <= counts_[2]; ++z)
    for (int y = 0; y <= counts_[1]; ++y)
      for (int x = 0; x <= counts_[0]; ++x)
        if (int& number = numbers_[corner({x, y, z}, 0)]; number == kUnnumbered) {
          number = static_cast<int>(halves_.size());
          halves_.push_back({2 * x, 2 * y, 2 * z});
        }
  setup_.file->check_size(static_cast<double>(halves_.size()));
}

Vector3 ImageBoxes::place(const Vector3& at) const {
  Vector3 voxel;
  for (int axis = 0; axis < 3; ++axis) {
    const int box = std::min(static_cast<int>(at[axis]), counts_[axis] - 1);
    voxel[axis] = planes_[axis][box] + (at[axis] - box) * length(axis, box) - 0.5;
  }
  return setup_.length_unit * (image_.origin + image_.steps * voxel);
}

double ImageBoxes::volume(const std::array<int, 3>& at) const {
  double voxels = 1;
  for (int axis = 0; axis < 3; ++axis) voxels *= length(axis, at[axis]);
  return voxels * std::abs(image_.steps.determinant()) * std::pow(setup_.length_unit, 3);
}
void ImageBoxes::report() const {
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
      voxels_ == std::array{1, 1, 1}
          ? ""
          : "; a computed reference has smaller boxes, down to the image's voxels as far as its time allows"));
}

}  // namespace elastin::lab
