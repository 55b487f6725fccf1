#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "elastin/core/geometry/cell_kind.h"

namespace elastin {
namespace {

using MatrixXd = Eigen::MatrixXd;
using Lists = std::vector<std::vector<int>>;

// ------------------------------------------------------------------------------------------------ shape functions

/// Functions and their slopes together: column 0 N_a, then ∂N_a/∂ξ_i.
using Jet = MatrixXd;

VectorX values_of(const Jet& jet) { return jet.col(0); }
MatrixXd slopes_of(const Jet& jet) { return jet.rightCols(jet.cols() - 1).transpose(); }

/// Barycentric coordinates of a simplex, 1 − Σ ξ first.
Jet barycentric(const VectorX& at) {
  const Eigen::Index d = at.size();
  Jet jet = Jet::Zero(d + 1, d + 1);
  jet(0, 0) = 1 - at.sum();
  jet.row(0).tail(d).setConstant(-1);
  for (Eigen::Index i = 0; i < d; ++i) jet(i + 1, 0) = at[i], jet(i + 1, i + 1) = 1;
  return jet;
}

/// Quadratic functions of a simplex from its barycentric coordinates: λ (2 λ − 1) at corners, 4 λ_a λ_b between.
Jet quadratic_simplex(const VectorX& at, const std::vector<std::array<int, 2>>& edges) {
  const Jet linear = barycentric(at);
  const Eigen::Index corners = linear.rows(), columns = linear.cols();
  Jet jet(corners + static_cast<Eigen::Index>(edges.size()), columns);
  for (Eigen::Index a = 0; a < corners; ++a) {
    jet(a, 0) = linear(a, 0) * (2 * linear(a, 0) - 1);
    jet.row(a).tail(columns - 1) = (4 * linear(a, 0) - 1) * linear.row(a).tail(columns - 1);
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto [a, b] = edges[e];
    const Eigen::Index row = corners + static_cast<Eigen::Index>(e);
    jet(row, 0) = 4 * linear(a, 0) * linear(b, 0);
    jet.row(row).tail(columns - 1) =
        4 * (linear(a, 0) * linear.row(b).tail(columns - 1) + linear(b, 0) * linear.row(a).tail(columns - 1));
  }
  return jet;
}

/// Functions of one coordinate in [−1, 1] at nodes −1, 1 or −1, 0, 1, and their slopes.
std::array<double, 2> lagrange(bool quadratic, double node, double x) {
  if (!quadratic) return {(1 + node * x) / 2, node / 2};
  if (node == 0) return {1 - x * x, -2 * x};
  return {x * (x + node) / 2, x + node / 2};
}

Jet tensor_product(const VectorX& at, const MatrixXd& reference, bool quadratic) {
  const Eigen::Index d = at.size();
  Jet jet = Jet::Ones(reference.cols(), d + 1);
  for (Eigen::Index a = 0; a < reference.cols(); ++a)
    for (Eigen::Index i = 0; i < d; ++i) {
      const auto [value, slope] = lagrange(quadratic, reference(i, a), at[i]);
      jet(a, 0) *= value;
      for (Eigen::Index j = 0; j < d; ++j) jet(a, j + 1) *= i == j ? slope : value;
    }
  return jet;
}

/// Serendipity functions: Π (1 + ξ_i ξ)/2^d (Σ ξ_i ξ − d + 1) at corners, (1 − ξ²) Π (1 + ξ_i ξ)/2^(d−1) between.
Jet serendipity(const VectorX& at, const MatrixXd& reference) {
  const Eigen::Index d = at.size();
  Jet jet(reference.cols(), d + 1);
  for (Eigen::Index a = 0; a < reference.cols(); ++a) {
    std::array<double, 3> f{1, 1, 1}, df{};  // factors of each coordinate
    bool corner = true;
    double sum = 1 - static_cast<double>(d);
    for (Eigen::Index i = 0; i < d; ++i) {
      const double node = reference(i, a), x = at[i];
      const auto k = static_cast<std::size_t>(i);
      f[k] = node == 0 ? 1 - x * x : (1 + node * x) / 2, df[k] = node == 0 ? -2 * x : node / 2;
      corner &= node != 0, sum += node * x;
    }
    const double product = f[0] * f[1] * f[2];
    jet(a, 0) = corner ? product * sum : product;
    for (Eigen::Index j = 0; j < d; ++j) {
      double slope = 1;
      for (std::size_t k = 0; k < 3; ++k) slope *= k == static_cast<std::size_t>(j) ? df[k] : f[k];
      jet(a, j + 1) = corner ? slope * sum + product * reference(j, a) : slope;
    }
  }
  return jet;
}

const std::vector<std::array<int, 2>>& triangle_edges() {
  static const std::vector<std::array<int, 2>> edges{{0, 1}, {1, 2}, {2, 0}};
  return edges;
}
const std::vector<std::array<int, 2>>& tetrahedron_edges() {
  static const std::vector<std::array<int, 2>> edges{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  return edges;
}
const std::vector<std::array<int, 2>>& hexahedron_edges() {
  static const std::vector<std::array<int, 2>> edges{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                     {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  return edges;
}

/// Corners of a square or cube in VTK's order, then as requested the middles of edges, faces, cell.
MatrixXd box_nodes(int dimensions, int nodes) {
  static const double corner[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                      {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  static const double face[7][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}, {0, 0, 0}};
  MatrixXd all(3, 27);
  const int corners = dimensions == 3 ? 8 : 4, edges = dimensions == 3 ? 12 : 4;
  int count = 0;
  for (int c = 0; c < corners; ++c) all.col(count++) = Vector3(corner[c][0], corner[c][1], corner[c][2]);
  for (int e = 0; e < edges; ++e) {
    const auto [a, b] = hexahedron_edges()[e];
    all.col(count++) = (all.col(a) + all.col(b)) / 2;
  }
  for (int f = dimensions == 3 ? 0 : 6; f < 7; ++f) all.col(count++) = Vector3(face[f][0], face[f][1], face[f][2]);
  return all.topLeftCorner(dimensions, nodes);
}

template <int dimensions, int nodes>
struct BoxFunctions {
  static constexpr bool full = nodes == 27 || nodes == 9, linear = nodes == 8 - 4 * (3 - dimensions);
  static Jet jet(const VectorX& at) {
    static const MatrixXd reference = box_nodes(dimensions, nodes);
    return linear || full ? tensor_product(at, reference, full) : serendipity(at, reference);
  }
};
template <int dimensions, bool quadratic>
struct SimplexFunctions {
  static Jet jet(const VectorX& at) {
    if (!quadratic) return barycentric(at);
    return quadratic_simplex(at, dimensions == 2 ? triangle_edges() : tetrahedron_edges());
  }
};
struct PrismFunctions {
  static Jet jet(const VectorX& at) {
    const Jet triangle = barycentric(at.head(2));
    Jet jet(6, 4);
    for (int a = 0; a < 6; ++a) {
      const auto [value, slope] = lagrange(false, a < 3 ? -1 : 1, at[2]);
      jet.row(a).head(3) = value * triangle.row(a % 3);
      jet(a, 3) = slope * triangle(a % 3, 0);
    }
    return jet;
  }
};

// ----------------------------------------------------------------------------------------------------- quadrature

struct Rule {
  MatrixXd points;
  VectorX weights;
};

/// Gauss's points of [−1, 1]^d.
Rule gauss(int dimensions, int per_direction) {
  std::vector<double> x, w;
  if (per_direction == 2)
    x = {-1 / std::sqrt(3.), 1 / std::sqrt(3.)}, w = {1, 1};
  else
    x = {-std::sqrt(0.6), 0, std::sqrt(0.6)}, w = {5. / 9, 8. / 9, 5. / 9};
  int count = 1;
  for (int i = 0; i < dimensions; ++i) count *= per_direction;
  Rule rule{MatrixXd(dimensions, count), VectorX::Ones(count)};
  for (int g = 0; g < count; ++g)
    for (int i = 0, rest = g; i < dimensions; ++i, rest /= per_direction) {
      const auto k = static_cast<std::size_t>(rest % per_direction);
      rule.points(i, g) = x[k], rule.weights[g] *= w[k];
    }
  return rule;
}

/// Exact to order 2: a point near each corner, λ = b there and a at the others.
Rule simplex_rule(int dimensions, int order) {
  const int count = order == 1 ? 1 : dimensions + 1;
  const double volume = dimensions == 2 ? 0.5 : 1. / 6;
  Rule rule{MatrixXd(dimensions, count), VectorX::Constant(count, volume / count)};
  if (order == 1) {
    rule.points.setConstant(1. / (dimensions + 1));
    return rule;
  }
  const double a = dimensions == 2 ? 1. / 6 : (5 - std::sqrt(5.)) / 20, b = 1 - dimensions * a;
  rule.points.setConstant(a);
  for (int i = 0; i < dimensions; ++i) rule.points(i, i + 1) = b;
  return rule;
}

Rule prism_rule() {
  const Rule triangle = simplex_rule(2, 2), line = gauss(1, 2);
  Rule rule{MatrixXd(3, 6), VectorX(6)};
  for (int g = 0; g < 6; ++g) {
    rule.points.col(g) << triangle.points.col(g % 3), line.points(0, g / 3);
    rule.weights[g] = triangle.weights[g % 3] * line.weights[g / 3];
  }
  return rule;
}

// ----------------------------------------------------------------------------------------------------------- table

template <class Functions>
CellKind make_kind(std::string_view name, std::string_view plural, int order, int corners, int pressures, int vtk,
                   const Rule& rule, MatrixXd reference, std::vector<std::array<int, 2>> edges) {
  CellKind kind;
  kind.name = name, kind.plural = plural, kind.order = order, kind.corners = corners, kind.pressures = pressures;
  kind.vtk = vtk;
  kind.dimensions = static_cast<int>(rule.points.rows());
  kind.nodes = static_cast<int>(reference.cols());
  kind.reference = std::move(reference);
  kind.points = rule.points, kind.weights = rule.weights;
  kind.edges = std::move(edges);
  kind.functions = [](const VectorX& at) { return values_of(Functions::jet(at)); };
  kind.function_slopes = [](const VectorX& at) { return slopes_of(Functions::jet(at)); };
  kind.values.resize(kind.nodes, rule.points.cols());
  for (Eigen::Index g = 0; g < rule.points.cols(); ++g) {
    kind.values.col(g) = kind.functions(rule.points.col(g));
    kind.slopes.push_back(kind.function_slopes(rule.points.col(g)));
  }
  return kind;
}

MatrixXd simplex_nodes(int dimensions, bool quadratic) {
  const auto& edges = dimensions == 2 ? triangle_edges() : tetrahedron_edges();
  MatrixXd nodes = MatrixXd::Zero(dimensions, dimensions + 1 + (quadratic ? static_cast<int>(edges.size()) : 0));
  for (int i = 0; i < dimensions; ++i) nodes(i, i + 1) = 1;
  if (quadratic)
    for (std::size_t e = 0; e < edges.size(); ++e)
      nodes.col(dimensions + 1 + static_cast<int>(e)) = (nodes.col(edges[e][0]) + nodes.col(edges[e][1])) / 2;
  return nodes;
}

MatrixXd prism_nodes() {
  MatrixXd nodes(3, 6);
  nodes << 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, -1, -1, -1, 1, 1, 1;
  return nodes;
}

/// The faces of a hexahedron as corners, outward: the four edges' middles and the face's own follow by where they lie.
Lists box_faces(const MatrixXd& reference) {
  const Lists corners{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 3, 2, 1}, {4, 5, 6, 7}};
  Lists faces;
  const auto node_at = [&](const Vector3& place) {
    for (int a = 0; a < reference.cols(); ++a)
      if ((reference.col(a) - place).norm() < 1e-9) return a;
    return -1;
  };
  for (const auto& face : corners) {
    std::vector<int> nodes = face;
    Vector3 middle = Vector3::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3 a = reference.col(face[i]), b = reference.col(face[(i + 1) % 4]);
      middle += a / 4;
      if (const int node = node_at((a + b) / 2); node >= 0) nodes.push_back(node);
    }
    if (const int node = node_at(middle); node >= 0) nodes.push_back(node);
    faces.push_back(std::move(nodes));
  }
  return faces;
}

/// The eight parts of a hexahedron of 27 nodes, each by its faces.
std::vector<Lists> parts_of_27() {
  std::vector<Lists> parts;
  const Lists faces = box_faces(box_nodes(3, 8));
  for (const auto& corners : hexahedra_of_27()) {
    Lists own;
    for (const auto& face : faces) {
      auto& added = own.emplace_back();
      for (const int c : face) added.push_back(corners[c]);
    }
    parts.push_back(std::move(own));
  }
  return parts;
}

/// Of 20 nodes: a tetrahedron at each corner and what is left in the middle.
std::vector<Lists> parts_of_20() {
  std::vector<Lists> parts;
  const MatrixXd reference = box_nodes(3, 20);
  const Lists faces = box_faces(reference);
  Lists middle;
  std::vector<Lists> corner_triangles(8);
  for (const auto& face : faces) {  // corners 0 … 3, then the middle of the edge behind each
    middle.push_back({face[4], face[5], face[6], face[7]});
    for (std::size_t i = 0; i < 4; ++i)
      corner_triangles[face[i]].push_back({face[i], face[4 + i], face[4 + (i + 3) % 4]});
  }
  for (int c = 0; c < 8; ++c) {
    Lists& own = corner_triangles[c];
    // The triangle across: {c, next, previous} on each face runs outward; across runs through the three middles.
    std::vector<int> ring{own[0][1], own[0][2]};
    for (const auto& triangle : own)
      for (const int node : {triangle[1], triangle[2]})
        if (std::find(ring.begin(), ring.end(), node) == ring.end()) ring.push_back(node);
    const Vector3 a = reference.col(ring[0]), b = reference.col(ring[1]), d = reference.col(ring[2]);
    const bool outward = (b - a).cross(d - a).dot(a - Vector3(reference.col(c))) > 0;
    if (!outward) std::swap(ring[1], ring[2]);
    own.push_back(ring);
    middle.push_back({ring[0], ring[2], ring[1]});
    parts.push_back(own);
  }
  parts.push_back(middle);
  return parts;
}

std::vector<CellKind> all_kinds() {
  std::vector<CellKind> kinds;
  kinds.reserve(16);
  const auto by_name = [&](std::string_view name) -> CellKind* {
    for (CellKind& kind : kinds)
      if (kind.name == name) return &kind;
    return nullptr;
  };
  const auto square_edges = std::vector<std::array<int, 2>>(hexahedron_edges().begin(), hexahedron_edges().begin() + 4);
  kinds.push_back(make_kind<SimplexFunctions<2, false>>("triangle3", "triangles", 1, 3, 1, 5, simplex_rule(2, 1),
                                                        simplex_nodes(2, false), triangle_edges()));
  kinds.push_back(make_kind<SimplexFunctions<2, true>>("triangle6", "triangles of second order", 2, 3, 1, 22,
                                                       simplex_rule(2, 2), simplex_nodes(2, true), triangle_edges()));
  kinds.push_back(make_kind<BoxFunctions<2, 4>>("quadrilateral4", "quadrilaterals", 1, 4, 1, 9, gauss(2, 2),
                                                box_nodes(2, 4), square_edges));
  kinds.push_back(make_kind<BoxFunctions<2, 8>>("quadrilateral8", "quadrilaterals of 8 nodes", 2, 4, 1, 23, gauss(2, 3),
                                                box_nodes(2, 8), square_edges));
  kinds.push_back(make_kind<BoxFunctions<2, 9>>("quadrilateral9", "quadrilaterals of 9 nodes", 2, 4, 1, 28, gauss(2, 3),
                                                box_nodes(2, 9), square_edges));
  kinds.push_back(make_kind<SimplexFunctions<3, false>>("tetrahedron4", "tetrahedra", 1, 4, 1, 10, simplex_rule(3, 1),
                                                        simplex_nodes(3, false), tetrahedron_edges()));
  kinds.push_back(make_kind<SimplexFunctions<3, true>>("tetrahedron10", "tetrahedra of second order", 2, 4, 1, 24,
                                                       simplex_rule(3, 2), simplex_nodes(3, true),
                                                       tetrahedron_edges()));
  kinds.push_back(make_kind<PrismFunctions>("prism6", "prisms", 1, 6, 1, 13, prism_rule(), prism_nodes(),
                                            {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}));
  kinds.push_back(make_kind<BoxFunctions<3, 8>>("hexahedron8", "hexahedra", 1, 8, 1, 12, gauss(3, 2), box_nodes(3, 8),
                                                hexahedron_edges()));
  kinds.push_back(make_kind<BoxFunctions<3, 20>>("hexahedron20", "hexahedra of 20 nodes", 2, 8, 1, 25, gauss(3, 3),
                                                 box_nodes(3, 20), hexahedron_edges()));
  kinds.push_back(make_kind<BoxFunctions<3, 27>>("hexahedron27", "hexahedra of 27 nodes", 2, 8, 4, 29, gauss(3, 3),
                                                 box_nodes(3, 27), hexahedron_edges()));

  const auto set_faces = [&](const char* name, Lists faces, std::vector<const char*> of) {
    CellKind& kind = *by_name(name);
    for (std::size_t f = 0; f < faces.size(); ++f) kind.face_kinds.push_back(by_name(of.size() == 1 ? of[0] : of[f]));
    kind.faces = std::move(faces);
  };
  set_faces("tetrahedron4", {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, {"triangle3"});
  set_faces("tetrahedron10", {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}},
            {"triangle6"});
  set_faces("prism6", {{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
            {"triangle3", "triangle3", "quadrilateral4", "quadrilateral4", "quadrilateral4"});
  set_faces("hexahedron8", box_faces(box_nodes(3, 8)), {"quadrilateral4"});
  set_faces("hexahedron20", box_faces(box_nodes(3, 20)), {"quadrilateral8"});
  set_faces("hexahedron27", box_faces(box_nodes(3, 27)), {"quadrilateral9"});

  by_name("triangle3")->polyhedra = {{{0, 1, 2}}};
  by_name("triangle6")->polyhedra = {{{0, 3, 5}}, {{3, 1, 4}}, {{5, 4, 2}}, {{3, 4, 5}}};
  by_name("quadrilateral4")->polyhedra = {{{0, 1, 2, 3}}};
  by_name("quadrilateral9")->polyhedra = {{{0, 4, 8, 7}}, {{4, 1, 5, 8}}, {{8, 5, 2, 6}}, {{7, 8, 6, 3}}};
  by_name("quadrilateral8")->polyhedra = {{{0, 4, 7}}, {{4, 1, 5}}, {{5, 2, 6}}, {{6, 3, 7}}, {{4, 5, 6, 7}}};
  const auto tetrahedron = [](int a, int b, int c, int d) { return Lists{{a, c, b}, {a, b, d}, {b, c, d}, {a, d, c}}; };
  by_name("tetrahedron4")->polyhedra = {tetrahedron(0, 1, 2, 3)};
  by_name("tetrahedron10")->polyhedra = {tetrahedron(0, 4, 6, 7),
                                         tetrahedron(4, 1, 5, 8),
                                         tetrahedron(6, 5, 2, 9),
                                         tetrahedron(7, 8, 9, 3),
                                         {{6, 5, 4},
                                          {4, 8, 7},
                                          {5, 9, 8},
                                          {7, 9, 6},  // on the cell's faces, within
                                          {4, 7, 6},
                                          {4, 5, 8},
                                          {6, 9, 5},
                                          {7, 8, 9}}};
  by_name("prism6")->polyhedra = {by_name("prism6")->faces};
  by_name("hexahedron8")->polyhedra = {by_name("hexahedron8")->faces};
  by_name("hexahedron20")->polyhedra = parts_of_20();
  by_name("hexahedron27")->polyhedra = parts_of_27();
  return kinds;
}

}  // namespace

std::span<const CellKind> cell_kinds() {
  static const std::vector<CellKind> kinds = all_kinds();
  return kinds;
}

const CellKind& cell_kind(std::string_view name) {
  const auto kinds = cell_kinds();
  return named(kinds, name, "unknown cell shape '" + std::string(name) + "'");
}

std::vector<std::vector<int>> hexahedra_of_27() {
  const MatrixXd small = box_nodes(3, 8), all = box_nodes(3, 27);
  std::vector<std::vector<int>> parts(8);
  for (int part = 0; part < 8; ++part)
    for (int c = 0; c < 8; ++c) {
      const Vector3 place = (small.col(part) + small.col(c)) / 2;
      for (int a = 0; a < 27; ++a)
        if ((all.col(a) - place).norm() < 1e-9) parts[part].push_back(a);
    }
  return parts;
}

std::vector<std::vector<int>> simplices_of(const CellKind& kind, std::span<const int> numbers) {
  const auto before = [&](int a, int b) { return numbers[a] < numbers[b]; };
  std::vector<std::vector<int>> simplices;
  const auto add_face = [&](const std::vector<int>& face, int apex) {
    const auto first = static_cast<std::size_t>(std::min_element(face.begin(), face.end(), before) - face.begin());
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      std::vector<int> simplex{face[first], face[(first + i) % face.size()], face[(first + i + 1) % face.size()]};
      if (apex >= 0) std::swap(simplex[1], simplex[2]), simplex.push_back(apex);
      simplices.push_back(std::move(simplex));
    }
  };
  for (const auto& polyhedron : kind.polyhedra) {
    if (kind.dimensions == 2) {
      add_face(polyhedron.front(), -1);
      continue;
    }
    int apex = polyhedron.front().front();
    for (const auto& face : polyhedron)
      for (const int node : face)
        if (before(node, apex)) apex = node;
    for (const auto& face : polyhedron)
      if (std::find(face.begin(), face.end(), apex) == face.end()) add_face(face, apex);
  }
  return simplices;
}

}  // namespace elastin
