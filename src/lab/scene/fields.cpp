#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "core/base/named.h"
#include "core/model/solid_cells.h"
#include "elastin/core/base/text.h"
#include "elastin/core/laws/material_law.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/scene/fields.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// What a direction is at a place, from the one that the material has.
using DirectionAt = std::function<Vector3(const Vector3& given, const Vector3& place)>;

std::string text_of(const Vector3& place) {
  return "(" + number(place.x()) + ", " + number(place.y()) + ", " + number(place.z()) + ") m";
}

enum class FieldOf { factors, values, directions, terms };

struct FieldSetup : MeshFile {
  FieldOf of = FieldOf::values;
  std::optional<Reader> expression, angle, unit;
  std::string data;
  std::optional<Reader> data_place;
  Vector3 about = Vector3::UnitZ();
};

Keys<FieldSetup> keys_of_field() {
  using S = FieldSetup;
  std::vector<std::string> endings;
  for (const mesh::MeshFormat& format : mesh::mesh_formats())
    if (format.content == mesh::MeshContent::cells_with_data) endings.push_back(format.ending);
  return {
      one_of<S>("key 'expression' is missing",
                {key::later({"expression", "formula, or list", "", "", "",
                             "[formula](#formulas) of x, y and z, the place in the body at rest; of a direction a list "
                             "of three, of any length: `[x / 1 mm, 1, 0]`; of `terms` one for each of their numbers"},
                            &S::expression),
                 Key<S>(mesh_file_key("mesh file (" + listed(endings, "or") +
                                      ") with a value for each of its cells; that of the cell whose middle is nearest "
                                      "counts; of a direction three values a cell"))
                     .optional()
                     .when([](const S& setup) { return setup.of != FieldOf::terms; }),
                 key::later({"angle", "formula", "", "", "",
                             "of a direction: the material's own is turned by this angle, `30 deg * z / 1 cm`"},
                            &S::angle)
                     .when([](const S& setup) { return setup.of == FieldOf::directions; })})
          .naming_the_second(),
      key::text("data", &S::data, "name of these data in the file")
          .needed("needed with `file`")
          .when<Reader>(&S::file)
          .place(&S::data_place),
      Key<S>(length_unit_key()).needed("needed with `file`").when<Reader>(&S::file),
      key::later(
          {"unit", "unit", "", "", "needed with `file`, but of factors and directions", "unit of the data: `kPa`"},
          &S::unit)
          .when([](const S& setup) { return setup.file && setup.of != FieldOf::directions; })
          .refused_for([](const S& setup) {
            const bool factors = setup.of == FieldOf::factors;
            return factors == !setup.unit ? ""
                   : factors              ? "these data have no unit; leave it out"
                                          : "key 'unit' is missing";
          }),
      key::direction("about", &S::about, "axis of that turn").needed("needed with `angle`").when(&S::angle)};
}

FieldSetup read_field(Reader reader, FieldOf of) {
  reader.set_section("material.fields");
  FieldSetup setup;
  setup.of = of;
  return keys_of_field().read(reader, {}, std::move(setup));
}

/// The data of a file's cells, found by place.
class FileData {
 public:
  FileData(const FieldSetup& setup, int values_per_cell, const Body* body)
      : name_(*setup.data_place), length_(setup.length_unit), data_(load(setup)), tree_(boxes()) {
    if (data_.values.rows() != values_per_cell)
      name_.fail("has " + counted(data_.values.rows(), "value") +
                 " a cell; needed: " + std::to_string(values_per_cell));
    if (body) check_covers(*body);
  }

  const Reader& name() const { return name_; }
  const Eigen::MatrixXd& values() const { return data_.values; }
  /// Of the cell whose middle is nearest.
  auto at(const Vector3& place) const { return data_.values.col(nearest(place).first); }

 private:
  /// A file of another unit of length or place would give the body the values of its outermost cells.
  void check_covers(const Body& body) const {
    constexpr std::size_t few = 12;  // cells of a body that may well lie in one of the file's
    std::vector<Vector3> places;
    const auto add = [&](const auto& cells) {
      for (const auto& cell : cells) places.push_back(middle_of(body, cell));
    };
    add(body.tetrahedra), add(body.triangles);
    if (places.empty()) add(body.connections.ends);
    std::size_t far = 0, furthest = 0;
    double furthest_distance = 0;
    std::set<int> used;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto [cell, distance] = nearest(places[i]);
      used.insert(cell);
      far += distance > 2 * length_ * data_.largest_radius;
      if (distance > furthest_distance) furthest = i, furthest_distance = distance;
    }
    const std::string remedy = "; see that the file has the body's place, its `length_unit` and values for all of it";
    if (far > 0)
      name_.fail(
          fmt::format("does not cover the body: {} of its {} cells lie outside the cells that have a value; the "
                      "furthest, at {}, is {} m away from the nearest middle of those{}",
                      far, places.size(), text_of(places[furthest]), number(furthest_distance, 3), remedy));
    if (used.size() == 1 && places.size() > few && data_.middles.cols() > 1)
      name_.fail(fmt::format("gives all {} cells of the body the value of one of the file's {} cells{}", places.size(),
                             data_.middles.cols(), remedy));
  }
  std::pair<int, double> nearest(const Vector3& place) const {
    return tree_.nearest(place, [&](int cell) { return (length_ * data_.middles.col(cell) - place).norm(); });
  }
  static mesh::CellData load(const FieldSetup& setup) {
    try {
      return mesh::load_cell_data(setup.path, setup.data);
    } catch (const InputError& error) {
      setup.data_place->fail(error.what());
    }
  }
  std::vector<Box> boxes() const {
    std::vector<Box> boxes;
    for (const Vector3 middle : data_.middles.colwise()) boxes.push_back({length_ * middle, length_ * middle});
    return boxes;
  }

  Reader name_;
  double length_;  ///< unit of the file's coordinates [m]
  mesh::CellData data_;
  BoxTree tree_;
};

}  // namespace

ValueAt field_values(const Reader& reader, const Dimension& dimension, const Range& range, const Body* body) {
  const FieldSetup setup = read_field(reader, dimension == dimension::none ? FieldOf::factors : FieldOf::values);
  if (setup.expression) return setup.expression->of_place(dimension, range);
  const auto& unit = setup.unit;
  const double factor = unit ? unit->located([&] { return parse_quantity("1 " + unit->text(), dimension).value; }) : 1;
  const auto file = std::make_shared<const FileData>(setup, 1, body);
  const double low = factor * file->values().minCoeff(), high = factor * file->values().maxCoeff();
  if (low < range.low || high > range.high || (range.open_low && low == range.low))
    file->name().fail("has values from " + elastin::number(low) + " to " + elastin::number(high) + " " +
                      si_unit(dimension) + "; they must be " + range_text(range.low, range.high, range.open_low));
  return [file, factor](const Vector3& place) { return factor * file->at(place)[0]; };
}

namespace {

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

DirectionAt read_directions(const Reader& reader, const Body* body) {
  const FieldSetup setup = read_field(reader, FieldOf::directions);
  if (setup.expression) return read_components(*setup.expression);
  if (setup.angle)
    return [by = setup.angle->of_place(dimension::none, {}), axis = setup.about](const Vector3& given,
                                                                                 const Vector3& place) -> Vector3 {
      return Eigen::AngleAxisd(by(place), axis) * given;
    };
  const auto file = std::make_shared<const FileData>(setup, 3, body);
  return [file](const Vector3&, const Vector3& place) -> Vector3 {
    const Vector3 found = file->at(place);
    if (!(found.norm() > 0)) file->name().fail("is no direction in the cell nearest to " + text_of(place) + ": all 0");
    return found.normalized();
  };
}

/// Of the material: each sets one of its numbers or directions to that of a place.
using Setter = std::function<void(Material& own, const Vector3& place)>;

/// {expression: [[10 kPa * (1 + z / 5 mm), 1.3], …]}: as many as the material's own terms.
Setter read_terms(const Reader& reader, const MaterialLaw& law, const Material& material) {
  const FieldSetup setup = read_field(reader, FieldOf::terms);
  const std::vector<Reader> items = setup.expression->items(material.law->terms.size());
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
void read_constants(const Reader& constants, const MaterialLaw& law, const Material& material, const Body& body,
                    std::vector<Setter>& setters) {
  for (const auto& [key, field] : constants.entries()) {
    if (key == "terms" && !law.columns.empty()) {
      setters.push_back(read_terms(field, law, material));
      continue;
    }
    std::vector<std::string> names = names_of(law.parameters);
    if (!law.columns.empty()) names.push_back("terms");
    const ParameterInfo* info = find_named(law.parameters, key);
    if (!info) field.fail("is no constant of " + law.name + suggestion(key, names));
    if (info->kind == ValueKind::direction) {
      if (!material.law->directions.contains(key)) field.fail("the material has no " + key);
      setters.push_back([name = key, at = read_directions(field, &body)](Material& own, const Vector3& place) {
        own.law->directions[name] = at(own.law->directions[name], place);
      });
    } else {
      setters.push_back(
          [name = key, at = field_values(field, info->unit, {info->low, info->high, info->above_low}, &body)](
              Material& own, const Vector3& place) { own.law->numbers[name] = at(place); });
    }
  }
}

void multiply_stiffness(const ValueAt& factor, Body& body) {
  change_stiffness(body, [&](const auto& members, double& own) { own *= factor(middle_of(body, members)); });
}

/// What the material is in some cells.
struct RegionSetup {
  std::optional<std::vector<int>> molecules;
  std::optional<double> youngs_modulus, poissons_ratio, density;
  std::optional<Reader> modulus_place, ratio_place, constants, place;
};

Keys<RegionSetup> keys_of_region() {
  using S = RegionSetup;
  return {
      molecules_key("molecules", &S::molecules, "the region is the cells all of whose molecules are among these")
          .needed(),
      key::quantity("youngs_modulus", &S::youngs_modulus, dimension::pressure, "E there, of a material without a law",
                    kPositive)
          .otherwise("the material's")
          .place(&S::modulus_place),
      key::quantity("poissons_ratio", &S::poissons_ratio, dimension::none,
                    "ν there, of a material without a law; springs ignore it", {-0.99, 0.4999})
          .otherwise("the material's")
          .place(&S::ratio_place),
      key::quantity("density", &S::density, dimension::density, "density there", kPositive).otherwise("the material's"),
      key::later({"constants", "map", "", "", "the material's",
                  "numbers of the law there by their names, `c1`, and its `terms`"},
                 &S::constants)};
}

/// Regions of other materials.
class MaterialRegions : public Regions<RegionSetup> {
 public:
  using Regions::Regions;

  /// Each molecule's mass by the volumes of its cells in the regions.
  void set_masses(double density, Body& body) const {
    VectorX volumes = VectorX::Zero(body.size()), masses = volumes;
    const auto add = [&](const auto& cell, double volume) {
      const RegionSetup* region = of(cell);
      const double own = region ? region->density.value_or(density) : density;
      for (const int molecule : cell) volumes[molecule] += volume, masses[molecule] += volume * own / density;
    };
    const std::vector<SolidCell> solids = solid_cells_of(body);
    for (const SolidCell& cell : solids) add(cell.nodes, std::abs(volume_of(cell, body.rest)));
    if (solids.empty())
      for (const auto& cell : body.triangles) {
        const Vector3 first = body.rest.col(cell[1]) - body.rest.col(cell[0]);
        add(cell, first.cross(Vector3(body.rest.col(cell[2]) - body.rest.col(cell[0]))).norm());
      }
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      if (volumes[molecule] == 0) add(std::array{molecule}, 1);  // of a body without cells
      body.mass[molecule] *= masses[molecule] / volumes[molecule];
    }
  }
};

/// Changes the stiffness and the masses of the body, and adds what sets other numbers.
void add_regions(const Reader& list, const MaterialLaw* law, const Material& material, std::vector<Setter>& setters,
                 Body& body) {
  std::vector<RegionSetup> setups;
  for (const Reader& item : list.items()) setups.push_back(keys_of_region().read(item, {Matrix3::Identity(), &body}));
  const auto regions = std::make_shared<const MaterialRegions>(body, std::move(setups));
  std::map<const RegionSetup*, LawConstants> constants;
  for (const RegionSetup& setup : regions->setups()) {
    const bool moduli = !law || law->from_moduli;
    if (setup.modulus_place && (material.curve || material.fibre))
      setup.modulus_place->fail("needs a material without curve or fibre");
    for (const auto& place : {setup.modulus_place, setup.ratio_place})
      if (place && !moduli) place->fail("follows from the constants of the law; write `constants`");
    if (!setup.constants) continue;
    if (!law || (law->parameters.empty() && law->columns.empty()))
      setup.constants->fail("are those of a `law`, and the material has none");
    for (const auto& [key, value] : setup.constants->entries()) {
      if (key == "terms" && !law->columns.empty()) {
        for (const Reader& item : value.items()) constants[&setup].terms.push_back(read_term(item, law->columns));
        if (const int count = static_cast<int>(constants[&setup].terms.size()); count < 1 || count > law->most_terms)
          value.fail("has " + counted(count, "term") + "; allowed: 1 to " + std::to_string(law->most_terms));
        continue;
      }
      std::vector<ParameterInfo> numbers = law->parameters;
      std::erase_if(numbers, [](const ParameterInfo& own) { return own.kind == ValueKind::direction; });
      const ParameterInfo* info = find_named(numbers, key);
      std::vector<std::string> names = names_of(numbers);
      if (!law->columns.empty()) names.push_back("terms");
      if (!info) value.fail("is no number of " + law->name + suggestion(key, names));
      constants[&setup].numbers[key] = value.quantity(info->unit, {info->low, info->high, info->above_low});
    }
  }
  change_stiffness(
      body,
      [&](const auto& members, double& stiffness) {
        const RegionSetup* own = regions->of(members);
        if (own && own->youngs_modulus) stiffness *= *own->youngs_modulus / material.youngs_modulus;
      },
      true);
  regions->set_masses(material.density, body);
  setters.push_back([regions, constants](Material& own, const Vector3& place) {
    const RegionSetup* region = regions->at(place);
    if (!region) return;
    if (region->poissons_ratio) own.poissons_ratio = *region->poissons_ratio;
    const auto found = constants.find(region);
    if (found == constants.end()) return;
    for (const auto& [name, value] : found->second.numbers) own.law->numbers[name] = value;
    if (!found->second.terms.empty()) own.law->terms = found->second.terms;
  });
}

struct FieldsSetup {
  std::optional<Reader> regions, stiffness, youngs_modulus, density, poissons_ratio, constants, fibre_direction,
      active_direction;
};

Keys<FieldsSetup> keys_of_fields() {
  using S = FieldsSetup;
  const auto field = [](const char* name, std::optional<Reader> S::*member, const char* text) {
    return key::later({name, "map", "", "", "none", text}, member);
  };
  return {field("stiffness", &S::stiffness, "a factor of all moduli that differs from place to place"),
          field("youngs_modulus", &S::youngs_modulus, "the same of E in Pa, of a material without a law"),
          field("density", &S::density, "the same of the density in kg/m³"),
          field("poissons_ratio", &S::poissons_ratio, "the same of ν, of a material without a law; springs ignore it"),
          key::later({"constants", "map of maps", "", "", "none",
                      "the same of the law's constants by their names, `c1`, `terms`, `direction`; springs have the E "
                      "of them"},
                     &S::constants),
          Key<S>("regions",
                 key::rows_below("regions", "list of maps",
                                 "materials of picked cells, of sets of a mesh: with the same law", keys_of_region()),
                 [](const Reader& value, S& setup, const Frame&) { setup.regions = value; }),
          field("fibre_direction", &S::fibre_direction, "a direction of fibres that differs from place to place"),
          field("active_direction", &S::active_direction, "the same of active fibres")};
}

/// What the fields say of the numbers and directions of a material.
std::vector<Setter> read_setters(const FieldsSetup& fields, const MaterialLaw* law, const Material& material,
                                 const Body& body) {
  std::vector<Setter> setters;
  if (const auto& field = fields.constants) {
    if (!law || law->parameters.empty()) field->fail("are those of a `law`, and the material has none");
    read_constants(*field, *law, material, body, setters);
  }
  if (const auto& field = fields.poissons_ratio) {
    if (law && !law->from_moduli) field->fail("follows from the constants of the law");
    setters.push_back([at = field_values(*field, dimension::none, {-0.99, 0.4999}, &body)](
                          Material& own, const Vector3& place) { own.poissons_ratio = at(place); });
  }
  const auto turn = [&](const std::optional<Reader>& field, auto member, const std::string& name) {
    if (field && !(material.*member)) field->fail("the material has no `" + name + "`");
    if (field)
      setters.push_back([member, at = read_directions(*field, &body)](Material& own, const Vector3& place) {
        (own.*member)->direction = at((own.*member)->direction, place);
      });
  };
  turn(fields.fibre_direction, &Material::fibre, "fibre");
  turn(fields.active_direction, &Material::active, "active");
  return setters;
}

/// The material's law at the middles of all cells is checked as its own is; connections get the mean E of the cells
/// around them instead, by a factor, for springs know no more of a law.
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
  VectorX factors;
  change_by_cells(body, factors, [&](std::span<const int> molecules, double& factor) {
    factor = modulus_at(middle_of(body, molecules)) / material.youngs_modulus;
  });
  if (factors.size() == 0 || factors.isOnes(1e-12)) return;
  body.connection_stiffness =
      body.connection_stiffness.size() ? body.connection_stiffness.cwiseProduct(factors).eval() : factors;
}

}  // namespace

void set_fields(const Reader& fields, const elastin::Table<MaterialLaw>& laws, Material& material, Body& body) {
  const FieldsSetup setup = keys_of_fields().read(fields);
  const auto row = material.law ? laws.find(material.law->law) : nullptr;
  std::vector<Setter> setters = read_setters(setup, row.get(), material, body);
  const auto &stiffness = setup.stiffness, &modulus = setup.youngs_modulus, &density = setup.density;
  for (const auto& field : {stiffness, modulus})
    if (field && (material.curve || material.fibre)) field->fail("needs a material without curve or fibre");
  if (modulus && material.law)
    modulus->fail("follows from the constants of the law; write `stiffness`, a factor of all its moduli");
  if (stiffness) multiply_stiffness(field_values(*stiffness, dimension::none, {1e-12, 1e12, false}, &body), body);
  if (modulus)
    multiply_stiffness([&, at = field_values(*modulus, dimension::pressure, kPositive, &body)](
                           const Vector3& place) { return at(place) / material.youngs_modulus; },
                       body);
  if (setup.regions) add_regions(*setup.regions, row.get(), material, setters, body);
  if (!setters.empty()) {
    material.field = MaterialField{[setters, before = material.field](Material& own, const Vector3& place) {
      if (before) before->set(own, place);
      for (const Setter& set : setters) set(own, place);
    }};
    check_at_all_places(fields, row.get(), material, body);
  }
  if (!density) return;
  const ValueAt at = field_values(*density, dimension::density, kPositive, &body);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    body.mass[molecule] *= at(body.rest.col(molecule)) / material.density;
}

std::vector<SceneKey> rows_of_fields() { return key::rows_below("fields", "", "", keys_of_fields()); }

std::vector<KeySection> field_keys() {
  return {{"material.fields", "",
           "Each of `fields` has an `expression`, or a `file` with `data`; a direction may have an `angle` instead. A "
           "cell has what is there at its middle:",
           keys_of_field().rows()}};
}

}  // namespace elastin::lab
