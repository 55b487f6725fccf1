// The body of the boxes of an image: its molecules, cells and matter.

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/tributary.h"
#include "core/shapes/orders.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/renumbered.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/scene/image_boxes.h"

namespace elastin::lab {

double ImageBoxes::stiffness(const Box& box) const {
  const double own = (parts_ ? materials_[box.label] : *context_.material).youngs_modulus;
  const double modulus = modulus_of_ && !has_own(box.label, "youngs_modulus")
                             ? modulus_of_(double{box.value})
                             : labels_[box.label].youngs_modulus.value_or(own);
  return double{box.fraction} * modulus / own;
}
MoleculeSets ImageBoxes::sets() const {
  MoleculeSets sets;
  if (setup_.as == ImageCells::packing) return sets;
  for_body([&](const Box& box, const std::array<int, 3>& at) {
    for (int c = 0; c < 8; ++c) {
      const int molecule = numbers_[corner(at, c)];
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

Positions ImageBoxes::outline() const {
  const auto is_voxel = [&](int x, int y, int z) {
    return boxes_[box_with(x, y, z)].label >= 0 && label_of(x, y, z) >= 0;
  };
  // Of each layer of voxels, the points in its middle and those on either side of it, in halves of voxels.
  std::vector<std::vector<std::array<int, 2>>> layers(2 * image_.size[2] + 1);
  for (int z = range_.first[2]; z < range_.last[2]; ++z)
    for (int y = range_.first[1]; y < range_.last[1]; ++y) {
      int first = range_.first[0], last = range_.last[0] - 1;
      while (first <= last && !is_voxel(first, y, z)) ++first;
      while (last > first && !is_voxel(last, y, z)) --last;
      if (first > last) continue;
      const int middle = 2 * z + 1;
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
    for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) << layers[layer][i][0], layers[layer][i][1];
    if (points.cols() == 0) continue;
    const Points2 hull = convex_hull(points);
    for (const auto& point : (hull.cols() < 3 ? points : hull).colwise())  // on one line there is no hull
      kept.emplace_back(point[0] / 2, point[1] / 2, (static_cast<double>(layer) - 1) / 2);
  }
  Positions result(3, static_cast<Eigen::Index>(kept.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i)
    result.col(i) = setup_.length_unit * (image_.origin + image_.steps * kept[i]);
  return result;
}

/// A random close packing of the outline, as far as it lies in the body.
void ImageBoxes::set_packing(Body& body) const {
  Vector3 first, voxels;
  for (int axis = 0; axis < 3; ++axis)
    first[axis] = range_.first[axis], voxels[axis] = range_.last[axis] - range_.first[axis];
  const Vector3 steps = setup_.length_unit * image_.steps.colwise().norm().transpose();
  const Vector3 sides = steps.cwiseProduct(voxels);
  const double distance = setup_.spacing.value_or(2 * std::cbrt(steps.prod()));
  setup_.file->check_size((sides.array() / distance + 1).prod());
  const Body whole = random_packing(sides, distance, 1.5 * distance, setup_.seed);
  const auto box_at = [&](const Vector3& at) {
    std::array<int, 3> box{};
    for (int axis = 0; axis < 3; ++axis)
      box[axis] = box_of_[axis][std::clamp(range_.first[axis] + static_cast<int>(at[axis] / steps[axis]),
                                           range_.first[axis], range_.last[axis] - 1)];
    return index(box[0], box[1], box[2]);
  };
  const auto inside = [&](const Vector3& at) { return boxes_[box_at(at)].label >= 0; };
  const auto in_one_piece = [&](int a, int b) {
    return pieces_.empty() || pieces_[box_at(whole.rest.col(a))] == pieces_[box_at(whole.rest.col(b))];
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
    if (number[a] >= 0 && number[b] >= 0 && in_one_piece(a, b) && inside((whole.rest.col(a) + whole.rest.col(b)) / 2))
      body.connections.ends.push_back({number[a], number[b]});
  body.connections.rest_length.resize(body.connections.ends.size());
  set_present_lengths(body);
}

Body ImageBoxes::body() {
  Body body;
  if (setup_.as == ImageCells::packing) {
    set_packing(body);
    return body;
  }
  body.rest.resize(3, static_cast<Eigen::Index>(halves_.size()));
  for (std::size_t i = 0; i < halves_.size(); ++i)
    body.rest.col(static_cast<Eigen::Index>(i)) = place(Vector3(halves_[i][0], halves_[i][1], halves_[i][2]) / 2);
  const int mirrored = image_.steps.determinant() < 0 ? 4 : 0;
  Cells<8> cubes;
  for_body([&](const Box&, const std::array<int, 3>& at) {
    auto& cube = cubes.emplace_back();
    for (int c = 0; c < 8; ++c) cube[c] = numbers_[corner(at, c ^ mirrored)];
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
void ImageBoxes::part(Body& body) {
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

void ImageBoxes::set_matter(Body& body) const {
  double all = 0;
  VectorX volumes = VectorX::Zero(body.size());
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
    for (int c = 0; c < 8; ++c) volumes[numbers_[corner(at, c)]] += of_box / 8;
  });
  if (setup_.as == ImageCells::packing) volumes.setConstant(all / body.size());
  context_.volumes = volumes;
  if (!varied) return;
  if (setup_.as == ImageCells::packing)
    (setup_.labels_place ? *setup_.labels_place : *setup_.file)
        .fail(
            "labels differ in stiffness, and the springs of a packing have one material; write "
            "`as: hexahedra`, `lattice` or `tetrahedra`");
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

void ImageBoxes::set_ratios() const {
  const auto own = std::find_if(labels_.begin(), labels_.end(), [](const ImageLabel& one) { return one.ratio_place; });
  if (parts_ || own == labels_.end()) return;
  if (context_.material->law) own->ratio_place->fail("needs a material without a law");
  if (!context_.remarks.field) own->ratio_place->fail("needs a scene of one body");
  std::vector<double> ratios;
  for (const ImageLabel& one : labels_)
    ratios.push_back(one.poissons_ratio.value_or(context_.material->poissons_ratio));
  *context_.remarks.field = MaterialField{[ratios, at = label_at()](Material& material, const Vector3& place) {
    if (const int label = at(place); label >= 0) material.poissons_ratio = ratios[label];
  }};
}

std::function<int(const Vector3&)> ImageBoxes::label_at() const {
  std::vector<std::int16_t> label_of;
  for (const Box& box : boxes_) label_of.push_back(static_cast<std::int16_t>(box.label));
  return [=, unit = setup_.length_unit, origin = image_.origin, steps = image_.steps.inverse().eval(), range = range_,
          box_of = box_of_, counts = counts_](const Vector3& place) {
    const Vector3 voxel = steps * (place / unit - origin);
    std::size_t box = 0;
    for (int axis = 2; axis >= 0; --axis)
      box = box * counts[axis] + box_of[axis][static_cast<std::size_t>(
                                     std::clamp(voxel[axis] + 0.5, double(range.first[axis]), range.last[axis] - 0.5))];
    return label_of[box];
  };
}

/// Of at most 96 voxels along each axis.
void ImageBoxes::set_shades(BodyImage& own) const {
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
        values.push_back(grey_.at(x, y, z));
        if (std::isfinite(values.back())) low = std::min(low, values.back()), high = std::max(high, values.back());
      }
  for (const double value : values)
    own.shades.push_back(high > low && value > low ? static_cast<std::uint8_t>(std::lround(
                                                         255 * (std::min(value, high) - low) / (high - low)))
                                                   : std::uint8_t{0});
}

void ImageBoxes::set_specimen(const Body& body) const {
  Specimen* specimen = context_.remarks.specimen;
  if (!specimen) return;
  std::vector<double> numbers;
  for (const ImageLabel& label : labels_) numbers.push_back(setup_.labels.empty() ? 1 : label.number);
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

}  // namespace elastin::lab
