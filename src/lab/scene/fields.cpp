#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "core/geometry/box_tree.h"
#include "elastin/core/base/text.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

using ValueAt = std::function<double(const Vector3& place)>;

/// {file: layers.vtk, data: E, unit: kPa, length_unit: mm}: the value of the cell whose middle is nearest.
ValueAt read_file(Reader& reader, const Dimension& dimension, const Range& range) {
  const Reader file = reader.at("file"), name = reader.at("data");
  const double length = reader.at("length_unit").choice<double>(length_units());
  const bool plain = dimension == dimension::none;
  const auto unit = plain ? reader.find("unit") : std::optional(reader.at("unit"));
  if (unit && plain) unit->fail("these data have no unit; leave it out");
  const double factor = unit ? unit->located([&] { return parse_quantity("1 " + unit->text(), dimension).value; }) : 1;
  const std::string path = (std::filesystem::path(file.file_path()).parent_path() / file.text()).string();
  if (std::error_code ignored; !std::filesystem::exists(path, ignored))
    file.fail("'" + file.text() + "': " + missing_file(path));
  const auto data = [&]() -> std::shared_ptr<const mesh::CellData> {
    try {
      return std::make_shared<mesh::CellData>(mesh::load_cell_data(path, name.text()));
    } catch (const InputError& error) {
      name.fail(error.what());
    }
  }();
  if (data->values.rows() != 1)
    name.fail("has " + counted(static_cast<std::size_t>(data->values.rows()), "value") + " a cell; needed: 1");
  const double low = factor * data->values.minCoeff(), high = factor * data->values.maxCoeff();
  if (low < range.low || high > range.high || (range.open_low && low == range.low))
    name.fail("has values from " + elastin::number(low) + " to " + elastin::number(high) + " " + si_unit(dimension) +
              "; they must be " + range_text(range.low, range.high, range.open_low));
  std::vector<Box> points;
  for (const Vector3 middle : data->middles.colwise()) points.push_back({length * middle, length * middle});
  return [data, length, factor, tree = BoxTree(points)](const Vector3& place) {
    const auto distance = [&](int cell) { return (length * data->middles.col(cell) - place).norm(); };
    return factor * data->values(0, tree.nearest(place, distance).first);
  };
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

}  // namespace

void set_fields(const Reader& fields, const Material& material, Body& body) {
  Reader reader = fields;
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
  if (!density) return;
  const ValueAt at = read_values(*density, dimension::density, kPositive);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    body.mass[molecule] *= at(body.rest.col(molecule)) / material.density;
}

std::vector<KeySection> field_keys() {
  return {{"material.fields",
           "",
           "Each of `fields` has an `expression`, or a `file` with `data`:",
           {{"expression", "formula", "", "", "needed, or `file`",
             "[formula](#formulas) of x, y and z, the place in the body at rest"},
            {"file", "file beside the scene", "", "", "none",
             "mesh file (.vtu, .vtk, .msh) with a value for each of its cells; that of the cell whose middle is "
             "nearest counts"},
            {"data", "text", "", "", "needed with `file`", "name of these data in the file"},
            {"length_unit", kLengthUnits, "", "", "needed with `file`", "unit of the file's coordinates"},
            {"unit", "unit", "", "", "needed with `file`, but of factors", "unit of the data: `kPa`"}}}};
}

}  // namespace elastin::lab
