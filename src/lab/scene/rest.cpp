#include "elastin/core/model/rest.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "elastin/core/base/text.h"
#include "lab/scene/fields.h"

namespace elastin::lab {
namespace {

/// What is stated of lengths without stress, of the whole body or of a region.
struct RestSetup {
  std::optional<std::vector<int>> molecules;
  std::optional<ValueAt> swelling, growth, prestretch, expansion, heating;
  std::vector<ValueAt> growths;  ///< along three axes
  bool along_fibres = false, unloaded = false;
  std::optional<Vector3> along;
  std::optional<RoundAxis> around;
  std::optional<Reader> place, factor, regions, along_place, in_place;
};

/// A number, a formula of the place, or a map that names a file.
ValueAt rest_value(const Reader& value, const Range& range, const Frame& frame) {
  return value.is_map() ? field_values(value, dimension::none, range, frame.body)
                        : value.of_place(dimension::none, range);
}

Key<RestSetup> rest_value_key(std::string name, std::optional<ValueAt> RestSetup::*member, std::string text,
                              const Range& range = kPositive) {
  return {{std::move(name), "number, [formula](#formulas) of x, y, z, or map as in `fields`", "",
           range_text(range.low, range.high, range.open_low), "none", std::move(text)},
          [=](const Reader& value, RestSetup& setup, const Frame& frame) {
            setup.*member = rest_value(value, range, frame);
          }};
}

Keys<RestSetup> rest_thermal_keys() {
  return {rest_value_key("expansion", &RestSetup::expansion, "coefficient of expansion [1/K]", {}).needed(),
          rest_value_key("change", &RestSetup::heating, "change of the temperature [K]", {}).needed()};
}

/// Keys of one map, of the body or of a region, behind others.
Keys<RestSetup> rest_keys_with(std::vector<Keys<RestSetup>::Entry> others) {
  std::vector<Keys<RestSetup>::Entry> all{
      rest_value_key("swelling", &RestSetup::swelling, "factor of all lengths: 1.001 makes them 0.1 % longer"),
      Key<RestSetup>(
          {"growth", "as `swelling`, or list of three", "", "> 0", "none",
           "factor of the lengths `along` one direction, or of all; or of those along x, y and z, with `around` "
           "along radius, circumference and axis"},
          [](const Reader& value, RestSetup& setup, const Frame& frame) {
            if (value.is_text() || value.is_map()) {
              setup.growth = rest_value(value, kPositive, frame);
            } else {
              for (const Reader& item : value.items(3)) setup.growths.push_back(rest_value(item, kPositive, frame));
            }
          }),
      rest_value_key(
          "prestretch", &RestSetup::prestretch,
          "how many times as long as without stress the body at rest is, `along` one direction or along all"),
      Key<RestSetup>("thermal",
                     key::rows_below("thermal", "map", "lengths × (1 + `expansion` × `change`)", rest_thermal_keys()),
                     [](const Reader& value, RestSetup& setup, const Frame&) {
                       RestSetup own = rest_thermal_keys().read(value);
                       setup.expansion = std::move(own.expansion), setup.heating = std::move(own.heating);
                     }),
      Key<RestSetup>({"along", "`fibres`, or direction", "", "", "all directions",
                      "direction along which `growth` and `prestretch` act; `fibres`: those of the material"},
                     [](const Reader& value, RestSetup& setup, const Frame&) {
                       setup.along_place = value;
                       setup.along_fibres = value.is_text() && value.text() == "fibres";
                       if (!setup.along_fibres) setup.along = value.direction();
                     }),
      key::map("around", &RestSetup::around, around_keys("the factors of `growth` are"))};
  all.insert(all.end(), std::make_move_iterator(others.begin()), std::make_move_iterator(others.end()));
  return Keys<RestSetup>(all);
}

Keys<RestSetup> keys_of_rest_region() {
  return rest_keys_with({molecules_key("molecules", &RestSetup::molecules,
                                       "the region is the cells and connections all of whose molecules are among these")
                             .needed()});
}

Key<RestSetup> rest_regions_key() {
  return Key<RestSetup>(
      "regions",
      key::rows_below("regions", "list of maps",
                      "picked cells with factors of their own in place of the body's; of several the last counts",
                      keys_of_rest_region()),
      [](const Reader& value, RestSetup& setup, const Frame&) { setup.regions = value; });
}

Keys<RestSetup> keys_of_prestrain() { return rest_keys_with({rest_regions_key()}); }

Keys<RestSetup> keys_of_rest() {
  return rest_keys_with(
      {Key<RestSetup>(
           {"unloaded_from", "`loads`", "", "", "none",
            "in place of all other keys: the body as described is under the scene's `loads`, or, without any that "
            "act before the experiment's, under that; each run finds the shape without them first"},
           [](const Reader& value, RestSetup& setup, const Frame&) {
             setup.unloaded = value.choice<bool>({{"loads", true}});
           }),
       Key<RestSetup>({"prestrain_in_place", "number, [formula](#formulas), or map of the keys above and `regions`", "",
                       "> 0", "none",
                       "in place of all other keys: the prestretch, along all directions or as the map says, that the "
                       "body as described has. Each run first changes it so that the body keeps its shape, under loads "
                       "as of `unloaded_from` or without any"},
                      [](const Reader& value, RestSetup& setup, const Frame&) { setup.in_place = value; }),
       key::later({"factor", "number, list of pairs, or [time function](#functions-of-time)", "", "",
                   "the part of the load, and 1 in time",
                   "the part of it that acts: in time a function of it; at rest `[[0, 0], [0.5, 1]]`, straight between "
                   "parts of the load, or a number, which acts before the experiment's load"},
                  &RestSetup::factor),
       rest_regions_key()});
}

Matrix3 stretch_of(const RestSetup& setup, double factor, const Material& material, const Vector3& middle) {
  if (!setup.along && !setup.along_fibres) return factor * Matrix3::Identity();
  const Vector3 a = setup.along ? *setup.along : local_material(material, middle).fibre->direction;
  return Matrix3::Identity() + (factor - 1) * a * a.transpose();
}

/// F_g
Matrix3 rest_metric(const RestSetup& setup, const Material& material, const Vector3& place, const Vector3& middle) {
  double all = setup.swelling ? (*setup.swelling)(place) : 1;
  if (setup.expansion) all *= 1 + (*setup.expansion)(place) * (*setup.heating)(place);
  if (!(all > 0))
    setup.place->fail("shrinks lengths to " + number(all) + " times themselves; the factor must be above 0");
  Matrix3 F = all * Matrix3::Identity();
  if (setup.growth) F *= stretch_of(setup, (*setup.growth)(place), material, middle);
  if (!setup.growths.empty()) {
    Vector3 factors;
    for (int axis = 0; axis < 3; ++axis) factors[axis] = setup.growths[static_cast<std::size_t>(axis)](place);
    const Matrix3 axes = setup.around ? frame_at(*setup.around, place) : Matrix3(Matrix3::Identity());
    F *= axes * factors.asDiagonal() * axes.transpose();
  }
  if (setup.prestretch) F *= stretch_of(setup, 1 / (*setup.prestretch)(place), material, middle);
  return F;
}

void check_rest_setup(const RestSetup& setup, const Material& material) {
  if (!setup.swelling && !setup.growth && setup.growths.empty() && !setup.prestretch && !setup.expansion &&
      !setup.regions)
    setup.place->fail(
        "states nothing; give swelling, growth, prestretch, thermal, regions, unloaded_from or prestrain_in_place");
  if (setup.along_fibres && !material.fibre) setup.along_place->fail("the material has no `fibre`");
  if (setup.along_place && !setup.growth && !setup.prestretch)
    setup.along_place->fail(setup.growths.empty() ? "is the direction of `growth` or `prestretch`; give one of them"
                                                  : "goes with one factor; `growth` has three, along x, y and z");
  if (setup.around && setup.growths.empty())
    setup.place->fail("`around` goes with three factors, growth: [radius, circumference, axis]");
}

/// At rest: a number, or [[part of the load, factor], …].
TimeFunction part_function(const Reader& factor) {
  if (factor.is_map()) return read_time_function(factor);
  if (factor.is_text()) return TimeFunction({{0, factor.quantity(dimension::none, kNotNegative)}});
  std::vector<std::pair<double, double>> points;
  for (const Reader& item : factor.items()) {
    const std::vector<Reader> pair = item.items(2);
    points.emplace_back(pair[0].quantity(dimension::none, {0, 1}), pair[1].quantity(dimension::none, kNotNegative));
  }
  return factor.located([&] { return TimeFunction(std::move(points)); });
}

}  // namespace

void set_rest(const Reader& reader, Specimen& specimen) {
  const Material& material = specimen.material;
  Body& body = specimen.body;
  const Frame frame{Matrix3::Identity(), &body};
  RestSetup setup = keys_of_rest().read(reader, frame);
  if ((setup.unloaded || setup.in_place) && reader.keys().size() > 1)
    reader.fail(setup.unloaded ? "`unloaded_from` stands alone: without its loads the body is free of stress"
                               : "`prestrain_in_place` stands alone: factors of lengths go below it");
  specimen.given = setup.unloaded ? GivenShape::loaded : setup.in_place ? GivenShape::in_place : GivenShape::at_rest;
  if (setup.unloaded) return;
  if (const std::optional<Reader> place = setup.in_place) {
    setup = place->is_text() ? RestSetup() : keys_of_prestrain().read(*place, frame);
    if (place->is_text()) setup.prestretch = rest_value(*place, kPositive, {}), setup.place = *place;
  }
  check_rest_setup(setup, material);
  std::shared_ptr<const Regions<RestSetup>> regions;
  if (setup.regions) {
    std::vector<RestSetup> own;
    for (const Reader& item : setup.regions->items()) {
      own.push_back(keys_of_rest_region().read(item, frame));
      check_rest_setup(own.back(), material);
    }
    regions = std::make_shared<const Regions<RestSetup>>(body, std::move(own));
  }
  Rest rest;
  rest.metric = [setup, regions, material](const Vector3& place, const Vector3& middle) {
    const RestSetup* own = regions ? regions->at(middle) : nullptr;
    return rest_metric(own ? *own : setup, material, place, middle);
  };
  if (regions)
    rest.length = [setup, regions, material](const Vector3& first, const Vector3& second) {
      const RestSetup* own = regions->at(first, second);
      const Vector3 middle = (first + second) / 2;
      return (rest_metric(own ? *own : setup, material, middle, middle) * (second - first)).norm() /
             (second - first).norm();
    };
  if (setup.factor) rest.part = [function = part_function(*setup.factor)](double at) { return function.value(at); };
  const auto check_at = [&](const auto& members) {  // what is out of range is said here
    const Vector3 middle = middle_of(body, members);
    rest.metric(middle, middle);
  };
  for (const auto& [a, b] : body.connections.ends) {
    if (rest.length && body.rest.col(a) != body.rest.col(b)) rest.length(body.rest.col(a), body.rest.col(b));
    check_at(std::array{a, b});
  }
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) check_at(block.cell(cell));
  for (const auto& cell : body.tetrahedra) check_at(cell);
  for (const auto& cell : body.triangles) check_at(cell);
  body.unstressed = std::make_shared<const Rest>(std::move(rest));
}

void check_rest(const Reader& rest, bool timed) {
  Reader map = rest;
  for (const char* key : {"unloaded_from", "prestrain_in_place"})
    if (const auto found = map.find(key); found && timed) found->fail("goes with experiments at rest");
  const auto factor = map.find("factor");
  if (!factor || factor->is_text()) return;
  if (factor->is_map() && !timed)
    factor->fail("an experiment at rest has no time; write a number, or [[part of the load, factor], …]");
  if (!factor->is_map() && timed)
    factor->fail("an experiment in time takes a function of it, for example factor: {ramp: {duration: 1 s}}");
}

std::vector<KeySection> rest_keys() {
  return {{"rest", "Rest",
           "Lengths without stress, over those of the body as it is described; they multiply. Springs get them as rest "
           "lengths, cells as a growth F_g, of which laws see F F_g⁻¹; masses, spring constants and thicknesses stay. "
           "x, y and z are where bodies stand after `turn` and `at`; those of a material's `fields` are before these.",
           keys_of_rest().rows()}};
}

}  // namespace elastin::lab
