#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/simulation/warnings.h"
#include "elastin/core/base/text.h"
#include "lab/scene/image_boxes.h"

namespace elastin::lab {
namespace {

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
    const Keys<ImageLabel> numbers{
        key::quantity("youngs_modulus", &ImageLabel::youngs_modulus, dimension::pressure, "E there", kPositive),
        key::quantity("poissons_ratio", &ImageLabel::poissons_ratio, dimension::none, "ν there", {-0.99, 0.4999})
            .place(&ImageLabel::ratio_place),
        key::quantity("density", &ImageLabel::density, dimension::density, "density there", kPositive)};
    for (const auto& [key, item] : value.entries()) {
      const LabelSetup own = keys.read(item);
      setup.labels.push_back({.number = number_of(key, item), .name = own.name.empty() ? key : own.name});
      setup.labels.back().material = own.material;
      if (!own.material) continue;
      const std::vector<std::string> plain = numbers.names();
      for (const std::string& name : own.material->keys())
        setup.parts |= std::find(plain.begin(), plain.end(), name) == plain.end();
    }
    for (ImageLabel& label : setup.labels)
      if (label.material && !setup.parts) label = numbers.read(Reader(*label.material), {}, ImageLabel(label));
  }
  for (std::size_t i = 0; i < setup.labels.size(); ++i)
    for (std::size_t other = 0; other < i; ++other)
      if (setup.labels[i].number == setup.labels[other].number)
        value.fail("names the label " + number(setup.labels[i].number) + " twice");
  if (setup.labels.empty()) value.fail("names no label; leave it out where every voxel that is not 0 is body");
}
void warn_of_grey_values(const mesh::Image& image, const ImageSetup& setup, ShapeContext& context) {
  const mesh::ImageValues values = mesh::values_of(image);
  if (values.labels) return;
  context.remarks.warnings.push_back(fmt::format(
      "{}: the image has grey values, and each voxel that is not 0 is body; a `threshold` states from which "
      "value on it is, such as {:.3g} by Otsu's rule",
      setup.file->path(), values.threshold));
}

/// Throws InputError unless the grey values lie on the grid of the image.
void check_same_grid(const mesh::ImageGrid& grey, const mesh::Image& image, const ImageSetup& setup) {
  const auto fail = [&](const std::string& what) {
    setup.grey_values_place->fail(what + " " + setup.file->text() +
                                  "; resample one of them onto the grid of the other");
  };
  const auto size = [](const mesh::ImageGrid& grid) {
    return fmt::format("{} x {} x {} voxels", grid.size[0], grid.size[1], grid.size[2]);
  };
  if (grey.size != image.size) fail("has " + size(grey) + " for the " + size(image) + " of");
  Vector3 signs = Vector3::Ones();  // LPS for RAS, as one file in two formats has it
  for (std::size_t axis = 0; axis < 3 && grey.space.size() == 3 && image.space.size() == 3; ++axis)
    if (grey.space[axis] != image.space[axis]) signs[static_cast<Eigen::Index>(axis)] = -1;
  double furthest = 0;  // in voxels, of the corners
  for (int c = 0; c < 8; ++c) {
    Vector3 corner;
    for (int axis = 0; axis < 3; ++axis) corner[axis] = c >> axis & 1 ? image.size[axis] - 1 : 0;
    const Vector3 apart = signs.cwiseProduct(grey.origin + grey.steps * corner) - image.origin - image.steps * corner;
    furthest = std::max(furthest, (image.steps.inverse() * apart).cwiseAbs().maxCoeff());
  }
  if (furthest > 0.1) fail(fmt::format("has its voxels up to {:.3g} voxels away from those of", furthest));
}

Body make_body(const ImageSetup& setup, ShapeContext& context) {
  mesh::Image image = setup.file->located([&] {
    return mesh::load_image(setup.path, [&](mesh::ImageGrid grid) {
      if (setup.voxel_size) grid.steps = (grid.steps * (*setup.voxel_size / setup.length_unit).asDiagonal()).eval();
      check_boxes(grid, setup);
    });
  });
  std::optional<mesh::Image> grey;
  if (setup.grey_values_place) {
    grey = setup.grey_values_place->located([&] { return mesh::load_image(setup.grey_values); });
    if (!grey->has_steps || !image.has_steps) grey->steps = image.steps, grey->origin = image.origin;
    check_same_grid(*grey, image, setup);
  }
  if (image.has_steps && setup.voxel_size)
    setup.file->fail("the file states the size of its voxels; leave `voxel_size` out");
  if (!image.has_steps && !setup.voxel_size)
    setup.file->fail("the file does not state the size of its voxels; write `voxel_size: [1 mm, 1 mm, 1 mm]`");
  if (setup.voxel_size) image.steps = (image.steps * (*setup.voxel_size / setup.length_unit).asDiagonal()).eval();
  if (!image.contradiction.empty()) context.remarks.warnings.push_back(setup.file->path() + ": " + image.contradiction);
  if (image.unit > 0 && std::abs(image.unit / setup.length_unit - 1) > 1e-6)
    context.remarks.warnings.push_back(setup.file->path() +
                                       ": the file states another unit of length than `length_unit`, which counts");
  if (setup.labels.empty() && !setup.threshold) warn_of_grey_values(image, setup, context);
  ImageBoxes boxes(image, grey ? *grey : image, setup, context);
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

std::string refused_of_packing(const ImageSetup& setup, bool given) {
  return given && setup.as == ImageCells::packing ? "goes with `as: hexahedra`, `lattice` and `tetrahedra`: the "
                                                    "springs of a packing have one material"
                                                  : "";
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
          Key<S>(key::flag("fill_fraction", &S::fill_fraction,
                           "whether a box is as stiff and heavy as the part of its voxels that is body; otherwise it "
                           "is body where half of it is"))
              .refused_for([](const S& setup) { return refused_of_packing(setup, setup.fill_fraction); }),
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
          Key<S>(
              key::later({"youngs_modulus", "formula of `value`", "Pa", "> 0", "the material's",
                          "E from the grey value, of labels that state none of their own: `2 kPa * (value / 100)^2`"},
                         &S::youngs_modulus))
              .refused_for([](const S& setup) { return refused_of_packing(setup, setup.youngs_modulus.has_value()); }),
          key::later({"density", "formula of `value`", "kg/m³", "> 0", "the material's",
                      "density from the grey value, of labels that state none of their own"},
                     &S::density),
          key::file("grey_values", &S::grey_values,
                    "an image on the grid of `file` that has the grey values of these formulas: the scan, where `file` "
                    "is its segmentation")
              .place(&S::grey_values_place)
              .refused_for([](const S& setup) {
                return setup.grey_values_place && !setup.youngs_modulus && !setup.density
                           ? "goes with a formula of `value` as `youngs_modulus` or `density`"
                           : "";
              }),
          seed_key(&S::seed)},
      make_body);
}

}  // namespace elastin::lab
