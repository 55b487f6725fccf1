#include <pybind11/eigen.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "core/base/named.h"
#include "core/model/check_indices.h"
#include "core/solve/rest_samples.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/prony.h"
#include "elastin/core/geometry/numbering.h"
#include "elastin/core/model/renumbered.h"
#include "elastin/core/model/surface.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/simplices.h"
#include "elastin/lab/study/laboratory.h"
#include "python/bind.h"
#include "python/pickling.h"

namespace elastin::python {
using namespace lab;
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Wholes = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::string shape_text(const py::array& array) {
  std::string text;
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis)
    text += (axis ? ", " : "") + std::to_string(array.shape(axis));
  return "(" + text + (array.ndim() == 1 ? ",)" : ")");
}

/// numpy hands out the values under a mask as if they counted.
void refuse_masked(const py::handle& given, const std::string& name) {
  if (py::hasattr(given, "mask") && py::module_::import("numpy").attr("ma").attr("is_masked")(given).cast<bool>())
    throw InputError(name + ": has masked values; leave these out (`compressed`), or fill them (`filled`)");
}

Numbers checked(const py::handle& given, const char* name, py::ssize_t columns) {
  refuse_masked(given, name);
  const Numbers array = Numbers::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw InputError(std::string(name) + ": cannot be read as an array of numbers");
  }
  const bool fits = columns == 1 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == columns;
  if (!fits)
    throw InputError(std::string(name) + ": has shape " + shape_text(array) + "; allowed: (n" +
                     (columns == 1 ? ",)" : ", " + std::to_string(columns) + ")"));
  return array;
}

/// Rows of numbers of molecules; None stands for no rows.
template <std::size_t columns>
std::vector<std::array<int, columns>> rows_from(const py::handle& given, const char* name) {
  if (given.is_none()) return {};
  refuse_masked(given, name);
  const py::array any = py::array::ensure(given);
  const bool whole = any && (any.dtype().kind() == 'i' || any.dtype().kind() == 'u');
  if (any && any.size() == 0) return {};
  if (!whole || any.ndim() != 2 || any.shape(1) != static_cast<py::ssize_t>(columns))
    throw InputError(std::string(name) + ": " +
                     (whole ? "has shape " + shape_text(any) : std::string("is no array of whole numbers")) +
                     "; allowed: whole numbers of molecules, (n, " + std::to_string(columns) + ")");
  const Wholes array = Wholes::ensure(any);
  std::vector<std::array<int, columns>> rows(static_cast<std::size_t>(array.shape(0)));
  for (py::ssize_t row = 0; row < array.shape(0); ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const std::int64_t number = array.at(row, column);
      if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
        throw InputError(std::string(name) + "[" + std::to_string(row) + "]: there is no molecule " +
                         std::to_string(number));
      rows[row][column] = static_cast<int>(number);
    }
  return rows;
}

/// Cells of a shape out of the table, (k, nodes).
CellBlock block_from(const std::string& name, const py::handle& given) {
  const CellKind* kind = nullptr;
  try {
    kind = &cell_kind(name);
  } catch (const InputError& error) {
    throw InputError(std::string("cells: ") + error.what());
  }
  CellBlock block{kind, {}, {}};
  refuse_masked(given, "cells: " + name);
  const py::array any = py::array::ensure(given);
  const bool whole = any && (any.dtype().kind() == 'i' || any.dtype().kind() == 'u');
  if (!whole || any.ndim() != 2 || any.shape(1) != block.kind->nodes)
    throw InputError("cells: " + name + (whole ? " has shape " + shape_text(any) : " is no array of whole numbers") +
                     "; allowed: whole numbers of molecules, (n, " + std::to_string(block.kind->nodes) + ")");
  const Wholes array = Wholes::ensure(any);
  for (py::ssize_t i = 0; i < array.size(); ++i) {
    const std::int64_t number = array.data()[i];
    block.nodes.push_back(number < 0 || number > std::numeric_limits<int>::max() ? -1 : static_cast<int>(number));
  }
  return block;
}

template <std::size_t corners>
py::array array_of(const std::vector<std::array<int, corners>>& rows) {
  py::array_t<int> array({rows.size(), corners});
  if (!rows.empty()) std::copy_n(rows.front().data(), rows.size() * corners, array.mutable_data());
  return array;
}

/// Every cell of the body, by its shape.
py::dict cells_of(const Body& body) {
  py::dict cells;
  for (const CellBlock& block : body.blocks) {
    py::array_t<int> array({block.size(), block.kind->nodes});
    std::copy(block.nodes.begin(), block.nodes.end(), array.mutable_data());
    const py::str name{std::string(block.kind->name)};
    cells[name] = cells.contains(name)
                      ? py::module_::import("numpy").attr("concatenate")(py::make_tuple(cells[name], array))
                      : py::object(array);
  }
  if (!has_blocks(body, 3) && !body.tetrahedra.empty()) cells["tetrahedron4"] = array_of(body.tetrahedra);
  if (!has_blocks(body, 2) && body.tetrahedra.empty() && body.blocks.empty() && !body.triangles.empty())
    cells["triangle3"] = array_of(body.triangles);
  return cells;
}

py::array surface_from(const Body& body) {
  return array_of(interruptible([&] { return surface_of(body); }));
}

VectorX numbers_or_none(const py::handle& given, const char* name) {
  return given.is_none() ? VectorX() : numbers_from(given, name);
}

/// How many times as stiff as the material each cell is, in the order in which they were given; connections as the mean
/// of the cells that have both of their ends.
void set_stiffness(Body& body, const VectorX& of_cells) {
  const bool solid = !body.tetrahedra.empty();
  const std::size_t simplices = solid ? body.tetrahedra.size() : body.triangles.size();
  const std::size_t cells = body.blocks.empty() ? simplices : cells_in_blocks(body);
  if (static_cast<std::size_t>(of_cells.size()) != cells)
    throw InputError("stiffness: has " + std::to_string(of_cells.size()) + " values; the body has " +
                     std::to_string(cells) + " cells");
  if (!(of_cells.array() > 0).all() || !of_cells.allFinite())
    throw InputError("stiffness: must be finite and above 0, a factor of the material's");
  std::vector<double> factors(of_cells.begin(), of_cells.end());
  if (!body.blocks.empty()) {
    factors.clear();
    Eigen::Index next = 0;
    for (CellBlock& block : body.blocks) {
      block.stiffness = of_cells.segment(next, block.size());
      for (int cell = 0; cell < block.size(); ++cell, ++next)
        factors.insert(factors.end(), simplices_of(*block.kind, block.cell(cell)).size(), of_cells[next]);
    }
  }
  std::map<std::pair<int, int>, Eigen::Vector2d> sides;  // sums and counts
  const auto add = [&](const auto& corners, double factor) {
    for (const int a : corners)
      for (const int b : corners)
        if (a < b) sides.try_emplace({a, b}, Eigen::Vector2d::Zero()).first->second += Eigen::Vector2d(factor, 1);
  };
  for (std::size_t i = 0; i < simplices; ++i)
    solid ? add(body.tetrahedra[i], factors[i]) : add(body.triangles[i], factors[i]);
  body.cell_stiffness = Eigen::Map<const VectorX>(factors.data(), static_cast<Eigen::Index>(factors.size()));
  body.connection_stiffness = VectorX::Ones(body.connections.size());
  for (int connection = 0; connection < body.connections.size(); ++connection) {
    const auto& [a, b] = body.connections.ends[connection];
    if (const auto side = sides.find(std::minmax(a, b)); side != sides.end())
      body.connection_stiffness[connection] = side->second[0] / side->second[1];
  }
}

Body body_from_arrays(const py::object& positions, const py::object& connections, const py::object& triangles,
                      const py::object& tetrahedra, const py::dict& cells, const py::object& rest_lengths,
                      const py::object& masses, const py::object& radii, std::optional<double> density,
                      double thickness, const py::object& growth, const py::object& stiffness) {
  BodyArrays arrays;
  arrays.positions = positions_from(positions, "positions");
  arrays.connections = rows_from<2>(connections, "connections");
  arrays.triangles = rows_from<3>(triangles, "triangles");
  arrays.tetrahedra = rows_from<4>(tetrahedra, "tetrahedra");
  for (const auto& [name, rows] : cells) arrays.blocks.push_back(block_from(word_of(name, "cells"), rows));
  arrays.rest_lengths = numbers_or_none(rest_lengths, "rest_lengths");
  arrays.masses = numbers_or_none(masses, "masses");
  arrays.radii = numbers_or_none(radii, "radii");
  arrays.density = density;
  arrays.thickness = thickness;
  if (!growth.is_none()) {
    refuse_masked(growth, "growth");
    const Numbers all = Numbers::ensure(growth);
    PyErr_Clear();
    if (!all || all.ndim() != 3 || all.shape(1) != 3 || all.shape(2) != 3)
      throw InputError("growth: has shape " + (all ? shape_text(all) : "of no array of numbers") +
                       "; allowed: (n, 3, 3), a matrix a cell");
    for (py::ssize_t cell = 0; cell < all.shape(0); ++cell)
      arrays.growth.emplace_back(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(all.data() + 9 * cell));
  }
  const VectorX factors = numbers_or_none(stiffness, "stiffness");
  return interruptible([&] {
    Body body = make_body(arrays);
    if (factors.size()) set_stiffness(body, factors);
    return body;
  });
}

std::string body_text(const Body& body) {
  const auto counted = [](std::size_t count, const char* what) {
    return count ? ", " + std::to_string(count) + " " + what : std::string();
  };
  return "<elastin.Body: " + std::to_string(body.size()) + " molecules, " + std::to_string(body.connections.proper()) +
         " connections" + counted(body.triangles.size(), "triangles") + counted(body.tetrahedra.size(), "tetrahedra") +
         counted(body.parts.size(), "parts") + ">";
}

double in_range(const char* name, double value, double low, double high, const char* unit) {
  if (value >= low && value <= high) return value;
  char text[200];
  std::snprintf(text, sizeof text, "%s: is %.6g; allowed: %g to %g%s", name, value, low, high, unit);
  throw InputError(text);
}

double positive(const char* name, double value, const char* unit) {
  if (value > 0 && std::isfinite(value)) return value;
  char text[200];
  std::snprintf(text, sizeof text, "%s: is %.6g; allowed: finite numbers above 0%s", name, value, unit);
  throw InputError(text);
}

/// {"law": "ogden", "terms": [[mu, alpha], …], "bulk_modulus": …}, as a scene's material, SI.
Material with_given_law(const py::dict& given, const Material& material) {
  static const Catalog catalog = built_in_catalog();
  if (!given.contains("law")) throw InputError("law: the dict needs a 'law', its name");
  const auto row = py::isinstance<Strategy>(given["law"]) ? given["law"].cast<const Strategy&>().own_law
                                                          : catalog.material_laws.find(word_of(given["law"], "law"));
  if (!row) throw InputError("law: '" + given["law"].cast<const Strategy&>().name + "' has no constants of a material");
  LawConstants constants{.law = row->name};
  for (const auto& [key, value] : given) {
    const std::string name = word_of(key, "a key of the law");
    const ParameterInfo* info = find_named(row->parameters, name);
    if (name == "law") continue;
    if (name == "terms") {
      for (const py::handle& term : value)
        constants.terms.push_back(py::isinstance<py::sequence>(term)
                                      ? entry_of<std::vector<double>>(term, name, "lists of numbers")
                                      : std::vector{number_of(term, name)});
    } else if (info && info->kind == ValueKind::direction) {
      const auto direction = entry_of<Vector3>(value, name, "three numbers");
      positive(name.c_str(), direction.norm(), "");
      constants.directions[name] = direction.normalized();
    } else if (py::isinstance<py::str>(value)) {
      constants.words[name] = py::cast<std::string>(value);
    } else {
      constants.numbers[name] = number_of(value, name);
    }
  }
  return with_law(*row, std::move(constants), material);
}

Material material_from(std::optional<double> youngs_modulus, double poissons_ratio, double density, double thickness,
                       double bending_rigidity, const std::optional<std::vector<std::pair<double, double>>>& curve,
                       const std::optional<Vector3>& fibre_direction, std::optional<double> fibre_modulus,
                       const std::optional<py::dict>& law,
                       const std::optional<std::vector<std::pair<double, double>>>& relaxation, bool instantaneous) {
  Material material;
  if (law && curve) throw InputError("law: there is a curve already; give one of them");
  if (curve) {
    std::vector<StressStrain::Point> points;
    for (const auto& [strain, stress] : *curve) points.push_back({strain, stress});
    material.curve = StressStrain::through(points);
    if (youngs_modulus) throw InputError("youngs_modulus: there is a curve already; give one of them");
    youngs_modulus = material.curve->modulus(0);
  }
  if (!youngs_modulus && !law) throw InputError("give youngs_modulus [Pa], a curve or a law");
  if (youngs_modulus) material.youngs_modulus = positive("youngs_modulus", *youngs_modulus, " Pa");
  material.poissons_ratio = in_range("poissons_ratio", poissons_ratio, -0.99, 0.5, "");
  if (law) {
    const Material derived = with_given_law(*law, material);
    if (youngs_modulus && derived.youngs_modulus != *youngs_modulus)
      throw InputError("youngs_modulus: it follows from the constants of the law; leave it out");
    material = derived;
  }
  material.density = positive("density", density, " kg/m^3");
  material.thickness = in_range("thickness", thickness, 0, 1e30, " m");
  material.bending_rigidity = in_range("bending_rigidity", bending_rigidity, 0, 1e30, " N m");
  if (instantaneous && !relaxation) throw InputError("instantaneous: there is no relaxation");
  if (relaxation) {
    material.relaxation = Relaxation{{}, instantaneous};
    for (const auto& [share, time] : *relaxation) material.relaxation->terms.push_back({share, time});
    check_relaxation(*material.relaxation);
  }
  if (fibre_direction.has_value() != fibre_modulus.has_value())
    throw InputError("fibres need both fibre_direction and fibre_modulus");
  if (fibre_direction) {
    positive("length of fibre_direction", fibre_direction->norm(), "");
    positive("fibre_modulus", *fibre_modulus, " Pa");
    material.fibre = Fibre{fibre_direction->normalized(), StressStrain::linear(*fibre_modulus)};
  }
  return material;
}

std::string material_text(const Material& material) {
  char text[160];
  std::snprintf(text, sizeof text, "<elastin.Material: E = %g Pa, nu = %g, %g kg/m^3%s%s>", material.youngs_modulus,
                material.poissons_ratio, material.density, material.curve ? ", stress-strain curve" : "",
                material.fibre ? ", fibres" : "");
  return text;
}

py::tuple material_state(const Material& material) {
  if (const std::string why = beyond_numbers(material); !why.empty())
    throw py::type_error("this material cannot be pickled: " + why);
  static const std::vector<std::string> laws = built_in_catalog().material_laws.names();
  if (material.law && std::find(laws.begin(), laws.end(), material.law->law) == laws.end())
    throw py::type_error("this material cannot be pickled: its law '" + material.law->law +
                         "' is one's own; pickle the law and the constants");
  return py::make_tuple(packed(material));
}

Material material_of(const py::tuple& state) {
  Material material = *unpacked<Material>(state[0].cast<py::bytes>(), "Material");
  if (material.law) {
    static const Catalog catalog = built_in_catalog();
    const Material given = material;
    material = with_law(*catalog.material_laws.find(material.law->law), *material.law, material);
    material.law->youngs_modulus = given.law->youngs_modulus;
    material.youngs_modulus = given.youngs_modulus, material.poissons_ratio = given.poissons_ratio;
  }
  return material;
}

void add_material(py::module_& module) {
  py::class_<Material>(module, "Material", "What a body should behave like; SI units.")
      .def(py::init(&material_from), py::arg("youngs_modulus") = py::none(), py::arg("poissons_ratio") = 0.25,
           py::arg("density") = 1000., py::kw_only(), py::arg("thickness") = 0., py::arg("bending_rigidity") = 0.,
           py::arg("curve") = py::none(), py::arg("fibre_direction") = py::none(),
           py::arg("fibre_modulus") = py::none(), py::arg("law") = py::none(), py::arg("relaxation") = py::none(),
           py::arg("instantaneous") = false,
           "youngs_modulus [Pa] > 0 or `curve`, pairs (strain, stress [Pa]) in uniaxial stress; poissons_ratio from "
           "-0.99 to 0.5; density [kg/m^3]; of sheets their thickness [m] and bending_rigidity [N m]; of fibres their "
           "direction and modulus [Pa]; law: a dict of the law's name and its constants as scenes have them, {'law': "
           "'ogden', "
           "'terms': [[6.3e5, 1.3]], 'bulk_modulus': 1e9}, and youngs_modulus and poissons_ratio follow; a law of "
           "one's own stands there itself, {'law': mine, 'k': 3e4, 'direction': (0, 0, 1)}; relaxation: "
           "pairs (share, time [s]) "
           "of strategies 'prony:NAME', of long-term moduli or of instantaneous ones.")
      .def_readonly("youngs_modulus", &Material::youngs_modulus,
                    "E [Pa]; of a curve its slope at no strain, of a law at rest.")
      .def_readonly("poissons_ratio", &Material::poissons_ratio, "Poisson's ratio.")
      .def_readonly("density", &Material::density, "[kg/m^3]")
      .def_readonly("thickness", &Material::thickness, "[m], of a membrane.")
      .def_readonly("bending_rigidity", &Material::bending_rigidity, "[N m]; 0 = no bending stiffness.")
      .def_property_readonly(
          "law", [](const Material& m) { return m.law ? std::optional(m.law->law) : std::nullopt; },
          "Name of the law whose constants it has, or None.")
      .def(py::pickle(&material_state, &material_of))
      .def("__repr__", &material_text);
}

/// A property whose array belongs to the body.
template <class Part>
auto part_of_body(Part part) {
  return [part](const py::object& self) { return view(part(self.cast<const Body&>()), self); };
}

}  // namespace

Positions positions_from(const py::handle& given, const char* name) {
  const Numbers array = checked(given, name, 3);
  return Eigen::Map<const Positions>(array.data(), 3, array.shape(0));
}

VectorX numbers_from(const py::handle& given, const char* name) {
  const Numbers array = checked(given, name, 1);
  return Eigen::Map<const VectorX>(array.data(), array.shape(0));
}

const std::vector<int>& ChosenNumbers::of(std::size_t count, const std::string& name, const std::string& what) const {
  if (mask && *mask != count)
    throw InputError(name + ": is a mask of " + std::to_string(*mask) + " truth values; a mask has one for each " +
                     what + " of the body, which has " + std::to_string(count));
  return all;
}

void add_bodies(py::module_& module) {
  add_material(module);
  py::class_<Body, std::shared_ptr<Body>>(module, "Body",
                                          "A piece of tissue at rest: molecules joined by connections. It never "
                                          "changes; its arrays are views that cannot be written to.")
      .def(
          py::init(&body_from_arrays), py::arg("positions"), py::arg("connections") = py::none(), py::kw_only(),
          py::arg("triangles") = py::none(), py::arg("tetrahedra") = py::none(), py::arg("cells") = py::dict(),
          py::arg("rest_lengths") = py::none(), py::arg("masses") = py::none(), py::arg("radii") = py::none(),
          py::arg("density") = py::none(), py::arg("thickness") = 0., py::arg("growth") = py::none(),
          py::arg("stiffness") = py::none(),
          "positions (n, 3) [m]; connections (m, 2), numbers of molecules, by default the sides of the cells; "
          "triangles (k, 3); tetrahedra (k, 4); cells of other shapes by name, {'hexahedron8': (k, 8), …}, nodes as in "
          "VTK; rest_lengths (m,) [m], by default the distances; masses (n,) [kg], by "
          "default from density [kg/m^3], by default that of the material with which the body is used, and the cells "
          "(triangles: thickness [m]) or the convex hull; radii (n,) [m], "
          "by default half the shortest connection; growth (n, 3, 3), where each cell is unstressed, F_g, by default "
          "as "
          "it lies at rest: all of it acts from the start; stiffness (k,), how many times as stiff as the material "
          "each cell "
          "is, by default 1: moduli[labels] / E of an array of labels. Arrays are copied.")
      .def_property_readonly("positions", part_of_body([](const Body& b) -> auto& { return b.rest; }),
                             "Positions at rest [m], (n, 3).")
      .def_property_readonly("masses", part_of_body([](const Body& b) -> auto& { return b.mass; }), "[kg], (n,).")
      .def_property_readonly("radii", part_of_body([](const Body& b) -> auto& { return b.radius; }), "[m], (n,).")
      .def_property_readonly("connections", part_of_body([](const Body& b) -> auto& { return b.connections.ends; }),
                             "The two molecules of each connection, (m, 2); sides of cells only come last.")
      .def_property_readonly(
          "rest_lengths",
          [](const py::object& self) {
            const auto& lengths = self.cast<const Body&>().connections.rest_length;
            return view(lengths.data(), {static_cast<py::ssize_t>(lengths.size())}, self);
          },
          "Unstressed lengths of the connections [m], (m,).")
      .def_property_readonly("triangles", part_of_body([](const Body& b) -> auto& { return b.triangles; }), "(k, 3).")
      .def_property_readonly("tetrahedra", part_of_body([](const Body& b) -> auto& { return b.tetrahedra; }),
                             "(k, 4), turned to positive volume.")
      .def_property_readonly("surface", &surface_from,
                             "Triangles of its surface, (k, 3), counter-clockwise seen from outside: the faces of its "
                             "solid cells, else of a lattice's cubes, and its triangles; a copy. A cut makes another.")
      .def_property_readonly("cells", &cells_of,
                             "Every cell by its shape: {'tetrahedron4': (k, 4), 'hexahedron20': (k, 20), …}, copies; "
                             "triangles only where there are no solids.")
      .def_property_readonly(
          "proper_connections", [](const Body& b) { return b.connections.proper(); },
          "How many connections are more than sides of cells; they come first.")
      .def("__len__", &Body::size)
      .def(py::pickle(
          [](const Body& body) -> py::object {
            if (!body.unstressed) return packed(body);
            const auto& part = body.unstressed->part;
            if (part && !(part(0) == 1 && part(1) == 1))
              throw py::type_error("a body whose growth changes in time cannot be pickled: make it again");
            return py::make_tuple(packed(body), packed(sampled_rest(body, body.rest, 1)), static_cast<bool>(part));
          },
          [](const py::object& state) {
            const bool grown = py::isinstance<py::tuple>(state);
            auto body = unpacked<Body>((grown ? state.cast<py::tuple>()[0] : state).cast<py::bytes>(), "Body");
            check_indices(*body);
            if (!grown) return body;
            const auto all = state.cast<py::tuple>();
            Rest rest = rest_of(*body, std::move(*unpacked<SampledRest>(all[1].cast<py::bytes>(), "growth")));
            if (!all[2].cast<bool>()) rest.part = {};
            body->unstressed = std::make_shared<const Rest>(std::move(rest));
            return body;
          }))
      .def("__repr__", &body_text);
  module.def(
      "order_in_space",
      [](const py::object& positions) {
        const Positions points = positions_from(positions, "positions");
        if (!points.allFinite()) throw InputError("positions: has numbers that are not finite");
        const std::vector<int> order = interruptible([&] { return order_in_space(points); });
        return py::array_t<int>(static_cast<py::ssize_t>(order.size()), order.data());
      },
      py::arg("positions"),
      "The order in which points (n, 3) lie along a curve that fills space, (n,): a large body whose molecules are "
      "numbered like this, positions[order], is passed over several times as fast as one numbered at random.");
  module.def(
      "numbered_in_space",
      [](const Body& body) {
        RenumberedBody ordered = interruptible([&] { return numbered_in_space(body); });
        const auto numbers = [](const std::vector<int>& list) {
          return py::array_t<int>(static_cast<py::ssize_t>(list.size()), list.data());
        };
        return py::make_tuple(std::make_shared<Body>(std::move(ordered.body)), numbers(ordered.molecule_from),
                              numbers(ordered.connection_from));
      },
      py::arg("body"),
      "The body with its molecules in the order of order_in_space, and the number that each molecule (n,) and each "
      "connection (c,) had: what is known of the old body goes over by x[molecule_from]. Bodies of parts keep theirs.");
  module.def(
      "of_labels",
      [](const Body& body, const std::vector<int>& labels) {
        RenumberedBody parted = interruptible([&] { return parts_of_labels(body, labels); });
        return py::make_tuple(
            std::make_shared<Body>(std::move(parted.body)),
            py::array_t<int>(static_cast<py::ssize_t>(parted.molecule_from.size()), parted.molecule_from.data()));
      },
      py::arg("body"), py::arg("labels"),
      "The body in parts, one for each label of its cells (k,), whole numbers as a mesh's cell_data has them, and the "
      "number that each molecule had (n,). Simulation then takes a material for each label, ascending: "
      "Simulation(body, 'neo_hookean', [fat, muscle]). Cells of a material that states another law than the first one "
      "have that law, all others the strategy. Molecules that labels share are the lowest one's, and have its density "
      "where the materials say it.");
  module.def("_cell_kinds", [] {
    py::dict numbers;
    for (const CellKind& kind : cell_kinds()) numbers[py::str(std::string(kind.name))] = kind.vtk;
    return numbers;
  });
  module.def(
      "_material_of_scene",
      [](const lab::HeldScene& held, const std::shared_ptr<Catalog>& catalog) {
        return lab::make_material(held, catalog ? *catalog : built_in_catalog());
      },
      py::arg("held"), py::arg("catalog"));
  module.def(
      "_material_of_scene", [](const std::string& yaml) { return lab::make_material(yaml); }, py::arg("yaml"));
  const auto body_of = [](const auto& scene, const Material& material, bool assumed) {
    std::vector<std::string> warnings, notes;
    Body body = interruptible([&] { return lab::make_body(scene, material, warnings, notes); });
    if (assumed) body.assumed_density = material.density;
    return std::tuple(std::make_shared<Body>(std::move(body)), warnings, notes);
  };
  module.def(
      "_body_of_scene",
      [body_of](const lab::HeldScene& held, const Material& material, bool assumed) {
        return body_of(held, material, assumed);
      },
      py::arg("held"), py::arg("material"), py::arg("assumed"));
  module.def(
      "_body_of_scene",
      [body_of](const std::string& yaml, const Material& material, bool assumed) {
        return body_of(yaml, material, assumed);
      },
      py::arg("yaml"), py::arg("material"), py::arg("assumed"));
}

}  // namespace elastin::python

namespace pybind11::detail {

bool type_caster<elastin::python::ChosenNumbers>::load(handle source, bool convert) {
  value = {};
  if (const array mask = array::ensure(source); mask && mask.dtype().kind() == 'b') {
    if (mask.ndim() != 1) return false;
    const auto truths = array_t<bool>::ensure(mask);
    value.mask = static_cast<std::size_t>(truths.size());
    for (ssize_t i = 0; i < truths.size(); ++i)
      if (truths.at(i)) value.all.push_back(static_cast<int>(i));
    return true;
  }
  using Given = std::variant<int, std::vector<int>>;
  make_caster<Given> given;
  if (!given.load(source, convert)) return false;
  const Given read = cast_op<Given>(std::move(given));
  value.single = std::holds_alternative<int>(read);
  value.all = value.single ? std::vector<int>{std::get<int>(read)} : std::get<std::vector<int>>(read);
  return true;
}

}  // namespace pybind11::detail
