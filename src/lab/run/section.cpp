#include "lab/run/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/geometry/reference_slopes.h"
#include "core/geometry/rim.h"
#include "core/model/block_geometry.h"
#include "core/model/faces.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"

namespace elastin::lab {
namespace {

/// Part of a triangle's area [0 … 1] that lies below a height, the heights of its corners ascending.
double share_below(const std::array<double, 3>& h, double height) {
  if (height <= h[0]) return 0;
  if (height >= h[2]) return 1;
  if (height < h[1]) return (height - h[0]) / (h[1] - h[0]) * ((height - h[0]) / (h[2] - h[0]));
  return 1 - (h[2] - height) / (h[2] - h[0]) * ((h[2] - height) / (h[2] - h[1]));
}

/// The same of a tetrahedron's volume. Between its second and third corner the plane cuts four sides, at the parts a
/// and b from corner 0, c and d from corner 1; what lies below is a wedge of three tetrahedra.
double share_below(const std::array<double, 4>& h, double height) {
  if (height <= h[0]) return 0;
  if (height >= h[3]) return 1;
  const auto cube = [](double x, double p, double q, double r) { return x / p * (x / q) * (x / r); };
  if (height < h[1]) return cube(height - h[0], h[1] - h[0], h[2] - h[0], h[3] - h[0]);
  if (height >= h[2]) return 1 - cube(h[3] - height, h[3] - h[0], h[3] - h[1], h[3] - h[2]);
  const double a = (height - h[0]) / (h[2] - h[0]), b = (height - h[0]) / (h[3] - h[0]),
               c = (height - h[1]) / (h[2] - h[1]), d = (height - h[1]) / (h[3] - h[1]);
  return a * b + a * d * (1 - b) + c * d * (1 - a);
}

/// Volumes of equal slabs between two heights.
class Slabs {
 public:
  Slabs(double from, double to, int count) : from_(from), to_(to), volume_(static_cast<std::size_t>(count)) {}

  /// Spreads a simplex's volume over the slabs in which it lies.
  template <std::size_t N>
  void add(std::array<double, N> heights, double volume) {
    std::sort(heights.begin(), heights.end());
    const int last = static_cast<int>(volume_.size()) - 1, end = slab_at(heights.back());
    for (int slab = slab_at(heights.front()); slab <= end; ++slab)
      volume_[slab] += volume * (below(heights, slab + 1, slab == last) - below(heights, slab, false));
  }

  bool meet(double low, double high) const { return high > from_ && low < to_; }
  /// The slab in which all between two heights lies; −1: none.
  int around(double low, double high) const {
    const int slab = slab_at(low);
    return low >= from_ && high <= to_ && slab == slab_at(high) ? slab : -1;
  }

  std::vector<double>& volumes() { return volume_; }

  Section section() const {
    const double thickness = (to_ - from_) / static_cast<double>(volume_.size());
    Section section;
    for (const double volume : volume_) section.area += volume / (to_ - from_);
    for (const double volume : volume_)
      section.variation = std::max(section.variation, std::abs(volume / thickness / section.area - 1));
    return section;
  }

 private:
  int slab_at(double height) const {
    const auto count = static_cast<double>(volume_.size());
    return static_cast<int>(std::clamp((height - from_) / (to_ - from_) * count, 0., count - 1));
  }

  /// Part of a simplex below the lower face of a slab; `top`: below the upper end of all.
  template <std::size_t N>
  double below(const std::array<double, N>& heights, int slab, bool top) const {
    const double height = top ? to_ : from_ + (to_ - from_) * slab / static_cast<double>(volume_.size());
    return share_below(heights, height);
  }

  double from_, to_;
  std::vector<double> volume_;
};

/// Six tetrahedra of a cube, corner c at (c & 1, c >> 1 & 1, c >> 2): those of neighbours meet side to side.
constexpr std::array<std::array<std::size_t, 4>, 6> kTetrahedraOfCube{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

void add_cell(const std::array<int, 4>& cell, const Positions& rest, const VectorX& heights, Slabs& slabs,
              double scale = 1) {
  slabs.add(std::array{heights[cell[0]], heights[cell[1]], heights[cell[2]], heights[cell[3]]},
            scale * std::abs(signed_volume(rest, cell)));
}

/// Visits the cells of solids: the tetrahedra of a body without blocks, or by kind and nodes the cells of its blocks,
/// with a function that gives the Jacobians at the quadrature points of these nodes.
template <class Tetrahedron, class Cell>
void for_each_solid(const Body& body, const Tetrahedron& tetrahedron, const Cell& cell) {
  if (!has_blocks(body, 3))
    for (const auto& corners : body.tetrahedra) tetrahedron(corners);
  for (const CellBlock& block : body.blocks) {
    if (block.kind->dimensions != 3) continue;
    const ReferenceSlopes<3> slopes(*block.kind);
    PointGradients<3> edges;
    for (int own = 0; own < block.size(); ++own)
      cell(*block.kind, block.cell(own), [&](const auto& nodes) -> const PointGradients<3>& {
        slopes.gradients(positions_of(body.rest, nodes), edges);
        return edges;
      });
  }
}

/// Adds the cells of solids. The simplices of a cell whose sides are curved have its own volume together; a cell that
/// lies in one slab needs none.
template <class Counts>
void add_cells(const Body& body, const VectorX& heights, const Counts& counts, Slabs& slabs) {
  const auto add = [&](const auto& cell) {
    if (counts(cell)) add_cell(cell, body.rest, heights, slabs);
  };
  for_each_solid(body, add, [&](const CellKind& kind, const auto& nodes, const auto& slopes) {
    const auto [low, high] =
        std::minmax_element(nodes.begin(), nodes.end(), [&](int a, int b) { return heights[a] < heights[b]; });
    if (!counts(nodes) || !slabs.meet(heights[*low], heights[*high])) return;
    const PointGradients<3>& edges = slopes(nodes);
    double volume = 0;
    for (std::size_t g = 0; g < kind.slopes.size(); ++g) volume += kind.weights[g] * edges[g].determinant();
    if (const int slab = slabs.around(heights[*low], heights[*high]); slab >= 0) {
      slabs.volumes()[slab] += volume;
      return;
    }
    double flat = 0;  // simplices behind a side that bulges inwards are inverted
    Cells<4> cells;
    for (const auto& simplex : simplices_of(kind, nodes)) {
      cells.push_back({nodes[simplex[0]], nodes[simplex[1]], nodes[simplex[2]], nodes[simplex[3]]});
      flat += std::abs(signed_volume(body.rest, cells.back()));
    }
    for (const auto& cell : cells) add_cell(cell, body.rest, heights, slabs, volume / flat);
  });
}

/// Whether every molecule is a corner of one of the cells.
template <class CellList>
bool fill(const Body& body, const CellList& cells) {
  if (!any_over(body, !cells.empty())) return false;
  std::vector<char> met(static_cast<std::size_t>(body.size()), 0);
  for (const auto& cell : cells)
    for (const int molecule : cell) met[molecule] = 1;
  const auto end = met.begin() + owned_molecules(body);
  return !any_over(body, std::find(met.begin(), end, 0) != end);
}

bool has_own_thickness(const Body& body) {
  return any_over(body, std::any_of(body.parts.begin(), body.parts.end(),
                                    [](const Part& part) { return part.thickness > 0 && part.triangles.count > 0; }));
}

double hull_area(const Body& body, const Eigen::Matrix<double, 3, 2>& plane, const VectorX& heights, double from,
                 double to) {
  const double near = 1e-9 * (largest_over(body, heights.maxCoeff()) - least_over(body, heights.minCoeff()));
  std::vector<int> inside;
  for (int molecule = 0; molecule < owned_molecules(body); ++molecule)
    if (heights[molecule] >= from - near && heights[molecule] <= to + near) inside.push_back(molecule);
  Points2 seen(2, static_cast<Eigen::Index>(inside.size()));
  for (std::size_t i = 0; i < inside.size(); ++i)
    seen.col(static_cast<Eigen::Index>(i)) = plane.transpose() * body.rest.col(inside[i]);
  return any_over(body, !inside.empty()) ? polygon_area(hull_over(body, seen)) : 0;
}

Section hull_section(const Body& body, const Vector3& axis, const VectorX& heights, double from, double to) {
  const auto plane = across(axis);
  Section section;
  section.of_hull = true;
  section.area = hull_area(body, plane, heights, from, to);
  if (!(section.area > 0))
    section.area =
        hull_area(body, plane, heights, least_over(body, heights.minCoeff()), largest_over(body, heights.maxCoeff()));
  const int connections = body.connections.proper();
  double mean = 0;
  if (body.share) {
    const auto [sum, count] = lengths_of_whole(body);
    mean = count > 0 ? sum / count : 0;
  } else {
    for (int c = 0; c < connections; ++c) mean += body.connections.rest_length[c] / connections;
  }
  const int slabs = mean > 0 ? static_cast<int>(std::min(10., (to - from) / (2 * mean))) : 0;
  if (slabs < 3) return section;
  std::vector<double> areas;
  double sum = 0;
  for (int slab = 0; slab < slabs; ++slab) {
    areas.push_back(
        hull_area(body, plane, heights, from + (to - from) * slab / slabs, from + (to - from) * (slab + 1) / slabs));
    sum += areas.back();
  }
  for (const double area : areas) section.variation = std::max(section.variation, std::abs(area * slabs / sum - 1));
  return section;
}

}  // namespace

Section find_section(const Body& body, const Vector3& axis, double from, double to, double thickness) {
  const VectorX heights = body.rest.transpose() * axis;
  Slabs slabs(from, to, 10);
  const auto counts = [&](const auto& cell) { return lowest_in_whole(body, cell) < owned_molecules(body); };
  if (fill(body, body.tetrahedra)) {
    add_cells(body, heights, counts, slabs);
  } else if (fill(body, body.cubes)) {
    for (const auto& cube : body.cubes)
      for (const auto& t : kTetrahedraOfCube)
        if (counts(cube)) add_cell({cube[t[0]], cube[t[1]], cube[t[2]], cube[t[3]]}, body.rest, heights, slabs);
  } else if ((thickness > 0 || has_own_thickness(body)) && fill(body, body.triangles)) {
    const std::vector<double> own = thicknesses(body, thickness);
    for (std::size_t number = 0; number < own.size(); ++number) {
      const auto& triangle = body.triangles[number];
      if (!counts(triangle)) continue;
      const auto& [a, b, c] = triangle;
      const Vector3 first = body.rest.col(b) - body.rest.col(a), second = body.rest.col(c) - body.rest.col(a);
      slabs.add(std::array{heights[a], heights[b], heights[c]}, own[number] * first.cross(second).norm() / 2);
    }
  } else {
    return hull_section(body, axis, heights, from, to);
  }
  sum_over(body, slabs.volumes());
  return slabs.section();
}

std::optional<Eigen::Matrix2d> second_moments_of_cells(const Body& body, const Eigen::Matrix<double, 3, 2>& plane,
                                                       double area) {
  if (!fill(body, body.tetrahedra)) return std::nullopt;
  const Points2 seen = plane.transpose() * (body.rest.colwise() - body.rest.col(0));
  std::array<double, 6> sums{};  // volume, volume times y, and times y yᵀ
  const auto add = [&](double volume, const Eigen::Vector2d& y, const Eigen::Matrix2d& square) {
    const std::array terms{1., y.x(), y.y(), square(0, 0), square(0, 1), square(1, 1)};
    for (std::size_t i = 0; i < terms.size(); ++i) sums[i] += volume * terms[i];
  };
  const auto counts = [&](const auto& cell) { return lowest_in_whole(body, cell) < owned_molecules(body); };
  const auto add_tetrahedron = [&](const auto& cell) {
    if (!counts(cell)) return;
    const Points2 y = seen(Eigen::all, std::vector<int>(cell.begin(), cell.end()));
    const Eigen::Vector2d sum = y.rowwise().sum();
    add(std::abs(signed_volume(body.rest, {cell[0], cell[1], cell[2], cell[3]})), sum / 4,
        (y * y.transpose() + sum * sum.transpose()) / 20);
  };
  for_each_solid(body, add_tetrahedron, [&](const CellKind& kind, const auto& nodes, const auto& slopes) {
    if (nodes.size() == 4) return add_tetrahedron(nodes);
    if (!counts(nodes)) return;
    const PointGradients<3>& edges = slopes(nodes);
    const Points2 at = seen(Eigen::all, std::vector<int>(nodes.begin(), nodes.end())) * kind.values;
    for (Eigen::Index g = 0; g < kind.weights.size(); ++g)
      add(kind.weights[g] * edges[g].determinant(), at.col(g), at.col(g) * at.col(g).transpose());
  });
  sum_over(body, sums);
  const Eigen::Vector2d middle = Eigen::Vector2d(sums[1], sums[2]) / sums[0];
  Eigen::Matrix2d moments;
  moments << sums[3], sums[4], sums[4], sums[5];
  return area * (moments / sums[0] - middle * middle.transpose());
}

std::optional<WallSection> wall_section(const Body& body, const Vector3& axis, const Eigen::Matrix<double, 3, 2>& plane,
                                        double from, double to, double thickness) {
  if (fill(body, body.tetrahedra) || fill(body, body.cubes) || !fill(body, body.triangles)) return std::nullopt;
  WallSection wall;
  if (!(thickness > 0) && !has_own_thickness(body)) return wall;
  wall.section = find_section(body, axis, from, to, thickness);
  const std::vector<double> own = thicknesses(body, thickness);
  const auto each = [&](const auto& visit) {
    for (std::size_t number = 0; number < own.size(); ++number) {
      if (lowest_in_whole(body, body.triangles[number]) >= owned_molecules(body)) continue;
      const Eigen::Matrix3d corners = positions_of(body.rest, body.triangles[number]);
      const Vector3 area = Vector3(corners.col(1) - corners.col(0)).cross(Vector3(corners.col(2) - corners.col(0))) / 2;
      visit(own[number], area.norm(), Vector3(area.normalized()), Points2(plane.transpose() * corners));
    }
  };
  std::array<double, 5> first{}, second{};
  each([&](double t, double area, const Vector3& /*normal*/, const Points2& corners) {
    const Eigen::Vector2d middle = corners.rowwise().mean();
    first[0] += area, first[1] += t * area, first[2] += t * area * middle.x(), first[3] += t * area * middle.y();
  });
  sum_over(body, first);
  const Eigen::Vector2d middle(first[2] / first[1], first[3] / first[1]);
  double nearest = std::numeric_limits<double>::infinity(), furthest = 0, thin = nearest, thick = 0, tilt = 0;
  each([&](double t, double area, const Vector3& normal, const Points2& corners) {
    const Points2 arms = corners.colwise() - middle;
    const Eigen::Vector2d sum = arms.rowwise().sum();
    const Eigen::Matrix2d moment = t * area / 12 * (arms * arms.transpose() + sum * sum.transpose());
    const double arm = std::abs(sum.dot(plane.transpose() * normal)) / 3;
    second[0] += moment(0, 0), second[1] += moment(0, 1), second[2] += moment(1, 1), second[3] += t * area * arm * arm;
    nearest = std::min(nearest, arm), furthest = std::max(furthest, arm);
    thin = std::min(thin, t), thick = std::max(thick, t), tilt = std::max(tilt, std::abs(axis.dot(normal)));
  });
  sum_over(body, second);
  nearest = least_over(body, nearest), furthest = largest_over(body, furthest);
  const double along = wall.section.area / first[1];  // one over the length
  wall.second_moment << second[0], second[1], second[1], second[2];
  wall.second_moment *= along;
  wall.torsion = second[3] * along;
  bool slit = false;
  for (const auto& [a, b] : boundary_of(body.triangles)) {
    const Vector3 side = body.rest.col(b) - body.rest.col(a);
    slit |= std::min(a, b) < owned_molecules(body) && std::abs(axis.dot(side)) > 0.1 * side.norm();
  }
  constexpr double alike = 0.02;
  if (largest_over(body, tilt) > alike) return wall;
  if (wall.second_moment.determinant() <= 1e-9 * std::pow(wall.second_moment.trace(), 2)) {
    wall.kind = WallSection::Kind::strip;
  } else if (furthest <= (1 + alike) * nearest && largest_over(body, thick) <= (1 + alike) * least_over(body, thin) &&
             std::abs(first[0] * along / (2 * std::numbers::pi * nearest) - 1) < 0.05 && !any_over(body, slit)) {
    wall.kind = WallSection::Kind::tube;
  }
  return wall;
}

double mean_thickness(const Body& body, double thickness) {
  if (!has_own_thickness(body)) return thickness;
  const std::vector<double> own = thicknesses(body, thickness);
  double volume = 0, area = 0;
  for (std::size_t number = 0; number < own.size(); ++number) {
    const auto& [a, b, c] = body.triangles[number];
    const double part = Vector3(body.rest.col(b) - body.rest.col(a)).cross(body.rest.col(c) - body.rest.col(a)).norm();
    area += part, volume += own[number] * part;
  }
  return volume / area;
}

double shear_modulus(const Material& material) { return material.youngs_modulus / (2 * (1 + material.poissons_ratio)); }

double bulk_modulus(const Material& material) {
  return material.youngs_modulus / (3 * (1 - 2 * material.poissons_ratio));
}

std::string no_isotropic_moduli(const Material& material, double strain) {
  constexpr double tiny = 1e-9, same = 0.05;
  if (material.fibre) return "the material has fibres";
  if (material.active) return "muscle is at work";
  if (material.law && !material.law->directions.empty()) return "the law " + material.law->law + " has directions";
  if (!material.curve) return "";
  const double at = std::max(strain, tiny), tension = material.curve->secant(at),
               compression = material.curve->secant(-at), E = material.youngs_modulus;
  if (std::abs(tension - E) <= same * E && std::abs(compression - E) <= same * E) return "";
  return "the material's curve has a secant modulus of " + number(1e-3 * tension, 3) + " kPa in tension and " +
         number(1e-3 * compression, 3) + " kPa in compression at a strain of " + number(100 * at, 2) + " %";
}

double torsion_constant(double a, double b) {
  if (a < b) std::swap(a, b);
  double sum = 0;
  for (int n = 1; n < 40; n += 2) sum += std::tanh(n * std::numbers::pi * a / (2 * b)) / std::pow(n, 5);
  return a * b * b * b * (1. / 3 - 64 * b / (std::pow(std::numbers::pi, 5) * a) * sum);
}

}  // namespace elastin::lab
