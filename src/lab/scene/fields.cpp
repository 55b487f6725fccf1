#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "core/geometry/box_tree.h"
#include "elastin/core/base/text.h"
#include "elastin/core/laws/material_law.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

using ValueAt = std::function<double(const Vector3& place)>;
/// What a direction is at a place, from the one that the material has.
using DirectionAt = std::function<Vector3(const Vector3& given, const Vector3& place)>;

std::string text_of(const Vector3& place) {
  return "(" + number(place.x()) + ", " + number(place.y()) + ", " + number(place.z()) + ") m";
}

/// The data of a file's cells, found by place.
struct FileData {
  Reader name;
  std::shared_ptr<const mesh::CellData> data;
  double length;  ///< unit of the file's coordinates [m]
  BoxTree tree;

  int nearest(const Vector3& place) const {
    return tree.nearest(place, [&](int cell) { return (length * data->middles.col(cell) - place).norm(); }).first;
  }
};

/// {file: layers.vtk, data: E, length_unit: mm}, of so many values a cell.
FileData open_data(Reader& reader, int values) {
  const Reader file = reader.at("file"), name = reader.at("data");
  const double length = reader.at("length_unit").choice<double>(length_units());
  const std::string path = file.existing_file();
  const auto data = [&]() -> std::shared_ptr<const mesh::CellData> {
    try {
      return std::make_shared<mesh::CellData>(mesh::load_cell_data(path, name.text()));
    } catch (const InputError& error) {
      name.fail(error.what());
    }
  }();
  if (data->values.rows() != values)
    name.fail("has " + counted(static_cast<std::size_t>(data->values.rows()), "value") +
              " a cell; needed: " + std::to_string(values));
  std::vector<Box> points;
  for (const Vector3 middle : data->middles.colwise()) points.push_back({length * middle, length * middle});
  return {name, data, length, BoxTree(points)};
}

/// {…, unit: kPa}: the value of the cell whose middle is nearest.
ValueAt read_file(Reader& reader, const Dimension& dimension, const Range& range) {
  const bool plain = dimension == dimension::none;
  const auto unit = plain ? reader.find("unit") : std::optional(reader.at("unit"));
  if (unit && plain) unit->fail("these data have no unit; leave it out");
  const double factor = unit ? unit->located([&] { return parse_quantity("1 " + unit->text(), dimension).value; }) : 1;
  const auto file = std::make_shared<const FileData>(open_data(reader, 1));
  const auto& data = file->data;
  const Reader& name = file->name;
  const double low = factor * data->values.minCoeff(), high = factor * data->values.maxCoeff();
  if (low < range.low || high > range.high || (range.open_low && low == range.low))
    name.fail("has values from " + elastin::number(low) + " to " + elastin::number(high) + " " + si_unit(dimension) +
              "; they must be " + range_text(range.low, range.high, range.open_low));
  return [file, factor](const Vector3& place) { return factor * file->data->values(0, file->nearest(place)); };
}

/// {expression: 10 kPa * (1 + z / 5 mm)} or {file: …}
ValueAt read_values(Reader reader, const Dimension& dimension, const Range& range) {
  reader.set_section("material.fields");
  if (reader.has("file")) {
    ValueAt values = read_file(reader, dimension, range);
    reader.finish();
    return values;
  }
  const Reader expression = reader.at("expression");
  reader.finish();
  return expression.of_place(dimension, range);
}

/// [x / 1 mm, 1, 0], of any length.
DirectionAt read_components(const Reader& list) {
  std::vector<ValueAt> components;
  for (const Reader& item : list.items(3)) components.push_back(item.of_place(dimension::none, {}));
  return [list, components](const Vector3&, const Vector3& place) -> Vector3 {
    const Vector3 found(components[0](place), components[1](place), components[2](place));
    if (!(found.norm() > 0)) list.fail("is no direction at " + text_of(place) + ": all three numbers are 0 there");
    return found.normalized();
  };
}

/// {expression: [x / 1 mm, 1, 0]}, {file: …} or {angle: 30 deg * z / 1 cm, about: z}
DirectionAt read_directions(Reader reader) {
  reader.set_section("material.fields");
  if (reader.has("file")) {
    const auto file = std::make_shared<const FileData>(open_data(reader, 3));
    reader.finish();
    return [file](const Vector3&, const Vector3& place) -> Vector3 {
      const Vector3 found = file->data->values.col(file->nearest(place));
      if (!(found.norm() > 0)) file->name.fail("is no direction in the cell nearest to " + text_of(place) + ": all 0");
      return found.normalized();
    };
  }
  if (const auto angle = reader.find("angle")) {
    const Vector3 axis = reader.at("about").direction();
    reader.finish();
    return [by = angle->of_place(dimension::none, {}), axis](const Vector3& given, const Vector3& place) -> Vector3 {
      return Eigen::AngleAxisd(by(place), axis) * given;
    };
  }
  const Reader expression = reader.at("expression");
  reader.finish();
  return read_components(expression);
}

/// Of the material: each sets one of its numbers or directions to that of a place.
using Setter = std::function<void(Material& own, const Vector3& place)>;

/// {expression: [[10 kPa * (1 + z / 5 mm), 1.3], …]}: as many as the material's own terms.
Setter read_terms(Reader reader, const MaterialLaw& law, const Material& material) {
  reader.set_section("material.fields");
  const Reader list = reader.at("expression");
  reader.finish();
  const std::vector<Reader> items = list.items(material.law->terms.size());
  std::vector<std::vector<ValueAt>> values;
  for (const Reader& item : items) {
    const bool alone = law.columns.size() == 1;
    const std::vector<Reader> columns = alone ? std::vector{item} : item.items(law.columns.size());
    values.emplace_back();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const ParameterInfo& info = law.columns[i];
      values.back().push_back(columns[i].of_place(info.unit, {info.low, info.high, info.above_low}));
    }
  }
  return [values](Material& own, const Vector3& place) {
    for (std::size_t term = 0; term < values.size(); ++term)
      for (std::size_t column = 0; column < values[term].size(); ++column)
        own.law->terms[term][column] = values[term][column](place);
  };
}

/// {c1: {expression: …}, direction: {file: …}, terms: {expression: …}}
void read_constants(const Reader& constants, const MaterialLaw& law, const Material& material,
                    std::vector<Setter>& setters) {
  for (const auto& [key, field] : constants.entries()) {
    if (key == "terms" && !law.columns.empty()) {
      setters.push_back(read_terms(field, law, material));
      continue;
    }
    std::vector<std::string> names;
    for (const ParameterInfo& info : law.parameters) names.push_back(info.name);
    if (!law.columns.empty()) names.push_back("terms");
    const auto info = std::find_if(law.parameters.begin(), law.parameters.end(),
                                   [&key = key](const ParameterInfo& own) { return own.name == key; });
    if (info == law.parameters.end()) field.fail("is no constant of " + law.name + suggestion(key, names));
    if (info->kind == ValueKind::direction) {
      if (!material.law->directions.contains(key)) field.fail("the material has no " + key);
      setters.push_back([name = key, at = read_directions(field)](Material& own, const Vector3& place) {
        own.law->directions[name] = at(own.law->directions[name], place);
      });
    } else {
      setters.push_back([name = key, at = read_values(field, info->unit, {info->low, info->high, info->above_low})](
                            Material& own, const Vector3& place) { own.law->numbers[name] = at(place); });
    }
  }
}

/// What the fields say of the numbers and directions of a material.
std::vector<Setter> read_setters(Reader& reader, const MaterialLaw* law, const Material& material) {
  std::vector<Setter> setters;
  if (const auto constants = reader.find("constants")) {
    if (!law || law->from_moduli) constants->fail("are those of a `law`, and the material has none");
    read_constants(*constants, *law, material, setters);
  }
  if (const auto field = reader.find("poissons_ratio")) {
    if (law && !law->from_moduli) field->fail("follows from the constants of the law");
    setters.push_back([at = read_values(*field, dimension::none, {-0.99, 0.4999, false})](
                          Material& own, const Vector3& place) { own.poissons_ratio = at(place); });
  }
  if (const auto field = reader.find("fibre_direction")) {
    if (!material.fibre) field->fail("the material has no `fibre`");
    setters.push_back([at = read_directions(*field)](Material& own, const Vector3& place) {
      own.fibre->direction = at(own.fibre->direction, place);
    });
  }
  if (const auto field = reader.find("active_direction")) {
    if (!material.active) field->fail("the material has no `active`");
    setters.push_back([at = read_directions(*field)](Material& own, const Vector3& place) {
      own.active->direction = at(own.active->direction, place);
    });
  }
  return setters;
}

template <class Members>
Vector3 middle_of(const Body& body, const Members& members) {
  Vector3 sum = Vector3::Zero();
  for (const int molecule : members) sum += body.rest.col(molecule);
  return sum / static_cast<double>(members.size());
}

void multiply_stiffness(const ValueAt& factor, Body& body) {
  const auto multiply = [&](std::size_t count, const auto& members, VectorX& factors) {
    const auto size = static_cast<Eigen::Index>(count);
    if (factors.size() == 0) factors = VectorX::Ones(size);
    for (Eigen::Index i = 0; i < size; ++i) factors[i] *= factor(middle_of(body, members(static_cast<std::size_t>(i))));
  };
  const auto each = [](const auto& list) {
    return [&list](std::size_t i) -> const auto& { return list[i]; };
  };
  multiply(body.connections.ends.size(), each(body.connections.ends), body.connection_stiffness);
  body.tetrahedra.empty() ? multiply(body.triangles.size(), each(body.triangles), body.cell_stiffness)
                          : multiply(body.tetrahedra.size(), each(body.tetrahedra), body.cell_stiffness);
  for (CellBlock& block : body.blocks)
    multiply(
        static_cast<std::size_t>(block.size()), [&](std::size_t cell) { return block.cell(static_cast<int>(cell)); },
        block.stiffness);
}

/// The material's law at the middles of all cells is checked as its own is; connections get the E of their middle
/// instead, by a factor, for springs know no more of a law.
void check_at_all_places(const Reader& fields, const MaterialLaw* law, const Material& material, Body& body) {
  const auto modulus_at = [&](const Vector3& place) {
    try {
      Material own = material;
      material.field->set(own, place);
      if (!law) return own.youngs_modulus;
      LawConstants constants = *own.law;
      return with_law(*law, std::move(constants), std::move(own)).youngs_modulus;
    } catch (const InputError& error) {
      if (error.has_location()) throw;
      fields.fail("at " + text_of(place) + ": " + error.what());
    }
  };
  const auto check = [&](const auto& cells) {
    for (const auto& cell : cells) modulus_at(middle_of(body, cell));
  };
  check(body.tetrahedra), check(body.triangles);
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell) modulus_at(middle_of(body, block.cell(cell)));
  VectorX factors(body.connections.size());
  for (Eigen::Index i = 0; i < factors.size(); ++i)
    factors[i] = modulus_at(middle_of(body, body.connections.ends[i])) / material.youngs_modulus;
  if (factors.size() == 0 || factors.isOnes(1e-12)) return;
  body.connection_stiffness =
      body.connection_stiffness.size() ? body.connection_stiffness.cwiseProduct(factors).eval() : factors;
}

}  // namespace

void set_fields(const Reader& fields, const elastin::Table<MaterialLaw>& laws, Material& material, Body& body) {
  Reader reader = fields;
  const auto row = material.law ? laws.find(material.law->law) : nullptr;
  const std::vector<Setter> setters = read_setters(reader, row.get(), material);
  const auto stiffness = reader.find("stiffness"), modulus = reader.find("youngs_modulus"),
             density = reader.find("density");
  reader.finish();
  for (const auto& field : {stiffness, modulus})
    if (field && (material.curve || material.fibre)) field->fail("needs a material without curve or fibre");
  if (modulus && material.law)
    modulus->fail("follows from the constants of the law; write `stiffness`, a factor of all its moduli");
  if (stiffness) multiply_stiffness(read_values(*stiffness, dimension::none, {1e-12, 1e12, false}), body);
  if (modulus)
    multiply_stiffness([&, at = read_values(*modulus, dimension::pressure, kPositive)](
                           const Vector3& place) { return at(place) / material.youngs_modulus; },
                       body);
  if (!setters.empty()) {
    material.field = MaterialField{[setters](Material& own, const Vector3& place) {
      for (const Setter& set : setters) set(own, place);
    }};
    check_at_all_places(fields, row.get(), material, body);
  }
  if (!density) return;
  const ValueAt at = read_values(*density, dimension::density, kPositive);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    body.mass[molecule] *= at(body.rest.col(molecule)) / material.density;
}

std::vector<KeySection> field_keys() {
  return {
      {"material.fields",
       "",
       "Each of `fields` has an `expression`, or a `file` with `data`; a direction may have an `angle` instead. A cell "
       "has what is there at its middle:",
       {{"expression", "formula, or list", "", "", "needed, or `file`",
         "[formula](#formulas) of x, y and z, the place in the body at rest; of a direction a list of three, of any "
         "length: `[x / 1 mm, 1, 0]`; of `terms` one for each of their numbers"},
        {"file", "file beside the scene", "", "", "none",
         "mesh file (.vtu, .vtk, .msh) with a value for each of its cells; that of the cell whose middle is "
         "nearest counts; of a direction three values a cell"},
        {"data", "text", "", "", "needed with `file`", "name of these data in the file"},
        {"length_unit", kLengthUnits, "", "", "needed with `file`", "unit of the file's coordinates"},
        {"unit", "unit", "", "", "needed with `file`, but of factors and directions", "unit of the data: `kPa`"},
        {"angle", "formula", "", "", "none",
         "of a direction: the material's own is turned by this angle, `30 deg * z / 1 cm`"},
        {"about", "direction", "", "", "needed with `angle`", "axis of that turn"}}}};
}

}  // namespace elastin::lab
