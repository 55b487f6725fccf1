#include "mesh/fill.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <utility>

#include "core/base/disjoint_sets.h"
#include "core/base/random.h"
#include "core/geometry/boundary.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/triangle_tree.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "hull/delaunay.h"
#include "mesh/spaced_points.h"
#include "mesh/surface_repair.h"

namespace elastin::mesh {

/// Distances from the surface, below 0 inside.
struct FillRegion::Inside {
  TriangleTree tree;
  std::unique_ptr<WindingNumber> winding;
  double signed_distance(const Vector3& point) const {
    if (!winding) return tree.signed_distance(point);
    const double distance = tree.nearest(point).distance;
    return winding->at(point) > 0.5 ? -distance : distance;
  }
  const Positions& points() const { return tree.points(); }
  const Cells<3>& triangles() const { return tree.triangles(); }
};

namespace {

using Inside = FillRegion::Inside;

/// Molecules inside keep this part of the spacing from a surface that has molecules of its own.
constexpr double kFromSurface = 0.55;
/// Tetrahedra below this volume over the cube of the longest side are peeled off the surface: what four molecules of a
/// flat or gently curved part of it span.
constexpr double kPeel = 0.01;

double volume_inside(const Positions& points, const Cells<3>& triangles) {
  const Vector3 middle = points.rowwise().mean();
  double sum = 0;
  for (const auto& [a, b, c] : triangles)
    sum += (points.col(a) - middle).dot((points.col(b) - middle).cross(points.col(c) - middle)) / 6;
  return sum;
}

/// Of a surface that is open or crosses itself: the share of its box that lies inside, by one random point in each of
/// some 50 000 boxes, to 0.1 to 0.5 %.
double volume_by_points(const Inside& inside) {
  constexpr double points = 50000;
  const Vector3 low = inside.points().rowwise().minCoeff(), span = inside.points().rowwise().maxCoeff() - low;
  const Vector3 wide = span.cwiseMax(span.maxCoeff() / 40);  // thin ones have one layer of points
  const double side = std::cbrt(wide.prod() / points);
  const Eigen::Vector3i counts = (span.array() / side).ceil().max(1).cast<int>();
  std::mt19937_64 generator(0);
  std::vector<Vector3> positions;
  for (int z = 0; z < counts[2]; ++z)
    for (int y = 0; y < counts[1]; ++y)
      for (int x = 0; x < counts[0]; ++x) {
        Vector3 part(x, y, z);
        for (double& along : part) along += unit_random(generator);
        positions.push_back(low + (part.array() / counts.cast<double>().array() * span.array()).matrix());
      }
  std::vector<char> is_inside(positions.size());
  parallel_for(static_cast<int>(positions.size()),
               [&](int p) { is_inside[p] = inside.winding->at(positions[p]) > 0.5; });
  return span.prod() * static_cast<double>(std::count(is_inside.begin(), is_inside.end(), 1)) /
         static_cast<double>(positions.size());
}

/// Which cubes of a grid over the surface lie inside, outside or across it.
class Voxels {
 public:
  enum class Kind : char { outside, across, inside };
  Voxels(const Inside& tree, double size) : size_(size) {
    low_ = tree.points().rowwise().minCoeff();
    const Vector3 span = tree.points().rowwise().maxCoeff() - low_;
    for (int axis = 0; axis < 3; ++axis) counts_[axis] = static_cast<int>(std::ceil(span[axis] / size + 1e-9));
    kinds_.resize(static_cast<std::size_t>(counts_.cast<double>().prod()));
    parallel_for(static_cast<int>(kinds_.size()), [&](int voxel) {
      const double distance = tree.signed_distance(corner(voxel) + Vector3::Constant(size_ / 2));
      const bool far = std::abs(distance) > size_ * std::sqrt(3.) / 2;
      kinds_[voxel] = !far ? Kind::across : distance < 0 ? Kind::inside : Kind::outside;
    });
  }
  int count() const { return static_cast<int>(kinds_.size()); }
  Kind kind(int voxel) const { return kinds_[voxel]; }
  Vector3 corner(int voxel) const {
    const int line = voxel / counts_[0], layer = line / counts_[1];
    return low_ + size_ * Vector3(voxel % counts_[0], line % counts_[1], layer);
  }

 private:
  double size_;
  Vector3 low_;
  Eigen::Vector3i counts_;
  std::vector<Kind> kinds_;
};

void add_lattice(const Inside& tree, const FillOptions& options, SpacedPoints& found) {
  const Vector3 low = tree.points().rowwise().minCoeff(), high = tree.points().rowwise().maxCoeff();
  Eigen::Vector3i counts;
  for (int axis = 0; axis < 3; ++axis)
    counts[axis] = 1 + static_cast<int>(std::floor((high[axis] - low[axis]) / options.spacing + 1e-6));
  const Vector3 first = (low + high) / 2 - options.spacing / 2 * (counts.cast<double>().array() - 1).matrix();
  const double least = options.follow ? kFromSurface * options.spacing : -1e-6 * options.spacing;
  std::vector<double> depths(static_cast<std::size_t>(counts.cast<double>().prod()));
  const auto position = [&](int at) -> Vector3 {
    const int line = at / counts[0], layer = line / counts[1];
    return first + options.spacing * Vector3(at % counts[0], line % counts[1], layer);
  };
  parallel_for(static_cast<int>(depths.size()), [&](int at) { depths[at] = -tree.signed_distance(position(at)); });
  for (int at = 0; at < static_cast<int>(depths.size()); ++at)
    if (depths[at] >= least) found.add(position(at));
}

/// Candidates in every cube of a grid in turn, so that no place is left bare; cubes far inside ask no distance.
void add_blue_noise(const Inside& tree, const FillOptions& options, SpacedPoints& found) {
  constexpr int rounds = 40;
  const Voxels voxels(tree, options.spacing);
  std::vector<int> open;
  for (int voxel = 0; voxel < voxels.count(); ++voxel)
    if (voxels.kind(voxel) != Voxels::Kind::outside) open.push_back(voxel);
  std::mt19937_64 generator(options.seed + 0x9e3779b97f4a7c15);
  const double least = options.follow ? kFromSurface * options.spacing : 0;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = open.size(); i > 1; --i)
      std::swap(open[i - 1], open[unit_random(generator) * static_cast<double>(i)]);
    for (const int voxel : open) {
      Vector3 position = voxels.corner(voxel);
      for (int axis = 0; axis < 3; ++axis) position[axis] += options.spacing * unit_random(generator);
      if (!found.is_free(position, 0.9 * options.spacing)) continue;
      if (voxels.kind(voxel) == Voxels::Kind::across || least > 0)
        if (!(-tree.signed_distance(position) >= least)) continue;
      found.add(position);
    }
  }
}

double flatness(const Positions& positions, const std::array<int, 4>& cell) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      longest = std::max(longest, (positions.col(cell[i]) - positions.col(cell[j])).norm());
  return signed_volume(positions, cell) / std::pow(longest, 3);
}

bool is_inside(const Inside& tree, const Positions& positions, const std::array<int, 4>& cell) {
  Vector3 middle = Vector3::Zero();
  for (const int corner : cell) middle += positions.col(corner) / 4;
  return tree.signed_distance(middle) < 0;
}

/// Delaunay's tetrahedra whose middle is inside. Flat ones between molecules on the surface do not matter: they are
/// peeled off.
Cells<4> tetrahedra_inside(const Inside& tree, const Positions& positions, int on_surface) {
  const Cells<4> cells = hull::delaunay_tetrahedra(positions, [&](const std::array<int, 4>& cell) {
    return std::any_of(cell.begin(), cell.end(), [&](int c) { return c >= on_surface; }) &&
           is_inside(tree, positions, cell);
  });
  std::vector<char> kept(cells.size());
  parallel_for(static_cast<int>(cells.size()), [&](int cell) { kept[cell] = is_inside(tree, positions, cells[cell]); });
  Cells<4> inside;
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    if (kept[cell]) inside.push_back(cells[cell]);
  return inside;
}

/// Takes nearly flat tetrahedra off the surface, until none is there; one that is a molecule's last stays.
void peel(const Positions& positions, Cells<4>& cells) {
  for (bool peeled = true; peeled;) {
    std::vector<int> uses(positions.cols(), 0);
    for (const auto& cell : cells)
      for (const int corner : cell) ++uses[corner];
    std::set<std::array<int, 3>> boundary;
    for (auto face : boundary_of(cells)) std::sort(face.begin(), face.end()), boundary.insert(face);
    const auto at_surface = [&](const std::array<int, 4>& cell) {
      for (std::size_t left_out = 0; left_out < 4; ++left_out) {
        std::array<int, 3> face{cell[(left_out + 1) % 4], cell[(left_out + 2) % 4], cell[(left_out + 3) % 4]};
        std::sort(face.begin(), face.end());
        if (boundary.contains(face)) return true;
      }
      return false;
    };
    const auto needless = [&](const std::array<int, 4>& cell) {
      if (flatness(positions, cell) >= kPeel || !at_surface(cell)) return false;
      if (std::any_of(cell.begin(), cell.end(), [&](int c) { return uses[c] < 2; })) return false;
      for (const int corner : cell) --uses[corner];
      return true;
    };
    peeled = std::erase_if(cells, needless) > 0;
  }
}

double area_of(const Inside& tree) {
  double sum = 0;
  for (const auto& [a, b, c] : tree.triangles()) {
    const Vector3 from = tree.points().col(a);
    sum += (tree.points().col(b) - from).cross(tree.points().col(c) - from).norm() / 2;
  }
  return sum;
}

/// Throws before anybody allocates for them.
void check_count(double molecules, const char* where, const FillOptions& options) {
  if (molecules <= options.most_molecules) return;
  char text[120];
  std::snprintf(text, sizeof text, "that is %.3g molecules %s; at most %g are taken", molecules, where,
                options.most_molecules);
  throw InputError(text);
}

/// Leaves out molecules without a tetrahedron.
void leave_out_isolated(Filling& filling) {
  std::vector<int> number(filling.positions.cols(), -1), left;
  for (const auto& cell : filling.tetrahedra)
    for (const int corner : cell) number[corner] = 0;
  int on_surface = 0;
  for (int m = 0; m < filling.positions.cols(); ++m)
    if (number[m] == 0) {
      number[m] = static_cast<int>(left.size());
      left.push_back(m);
      on_surface += m < filling.on_surface;
    }
  for (auto& cell : filling.tetrahedra)
    for (int& corner : cell) corner = number[corner];
  filling.left_out = static_cast<int>(number.size() - left.size());
  filling.on_surface = on_surface;
  filling.positions = filling.positions(Eigen::all, left).eval();
}

/// Closed or open, of triangles that hang together over points.
struct Component {
  std::vector<int> triangles;
  Box box{Vector3::Constant(std::numeric_limits<double>::infinity()),
          Vector3::Constant(-std::numeric_limits<double>::infinity())};
  Vector3 area = Vector3::Zero();  ///< Σ area vectors [m²], 0 where it is closed
  double size = 0;                 ///< Σ areas [m²]
  double volume = 0;               ///< [m³], < 0 of one that bounds a cavity
  bool is_closed() const { return area.norm() <= 1e-6 * size; }
};

std::vector<Component> components_of(const Positions& points, const Cells<3>& triangles) {
  DisjointSets sets(points.cols());
  for (const auto& [a, b, c] : triangles) sets.join(a, b), sets.join(b, c);
  std::map<int, std::size_t> numbers;
  std::vector<Component> components;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto [found, fresh] = numbers.try_emplace(sets.set_of(triangles[t][0]), components.size());
    if (fresh) components.emplace_back();
    Component& own = components[found->second];
    own.triangles.push_back(static_cast<int>(t));
    for (const int corner : triangles[t])
      own.box = {own.box.low.cwiseMin(points.col(corner)), own.box.high.cwiseMax(points.col(corner))};
  }
  for (Component& own : components)
    for (const int t : own.triangles) {
      const Vector3 a = points.col(triangles[t][0]), b = points.col(triangles[t][1]), c = points.col(triangles[t][2]);
      const Vector3 area = (b - a).cross(c - a) / 2;
      own.area += area, own.size += area.norm(), own.volume += area.dot(a - own.box.middle()) / 3;
    }
  return components;
}

/// Some triangles with their points alone.
std::pair<Positions, Cells<3>> alone(const Positions& points, const Cells<3>& triangles,
                                     const std::vector<int>& wanted) {
  std::map<int, int> numbers;
  Cells<3> own;
  for (const int t : wanted)
    for (int& corner : own.emplace_back(triangles[t]))
      corner = numbers.try_emplace(corner, static_cast<int>(numbers.size())).first->second;
  Positions positions(3, static_cast<Eigen::Index>(numbers.size()));
  for (const auto& [from, to] : numbers) positions.col(to) = points.col(from);
  return {positions, own};
}

/// Of components that do not cross: each with the one whose cavity it bounds.
void join_cavities(const Positions& points, const Cells<3>& triangles, const std::vector<Component>& components,
                   DisjointSets& shells) {
  const auto count = static_cast<int>(components.size());
  std::vector<std::vector<int>> holders(components.size());
  for (int outer = 0; outer < count; ++outer) {
    const Component& own = components[outer];
    std::unique_ptr<TriangleTree> tree;
    for (int inner = 0; inner < count; ++inner) {
      const Component& other = components[inner];
      if (inner == outer || (other.box.low.array() < own.box.low.array()).any() ||
          (other.box.high.array() > own.box.high.array()).any())
        continue;
      if (!tree) {
        auto [own_points, own_triangles] = alone(points, triangles, own.triangles);
        tree = std::make_unique<TriangleTree>(std::move(own_points), std::move(own_triangles));
      }
      constexpr std::size_t samples = 64;
      double furthest = 0;  // corners of shells that touch lie at 0
      for (std::size_t i = 0; i < other.triangles.size(); i += 1 + other.triangles.size() / samples)
        if (const double distance = tree->signed_distance(points.col(triangles[other.triangles[i]][0]));
            std::abs(distance) > std::abs(furthest))
          furthest = distance;
      if ((own.volume < 0 ? -furthest : furthest) < 0) holders[inner].push_back(outer);
    }
  }
  for (int inner = 0; inner < count; ++inner)
    for (const int outer : holders[inner])
      if (holders[inner].size() % 2 == 1 && holders[outer].size() + 1 == holders[inner].size())
        shells.join(inner, outer);
}

/// Of components that may cross or stay open: those whose boxes touch, and all that are open.
void join_near(const std::vector<Component>& components, DisjointSets& shells) {
  std::vector<int> closed;
  Box open{Vector3::Constant(std::numeric_limits<double>::infinity()),
           Vector3::Constant(-std::numeric_limits<double>::infinity())};
  int first_open = -1;
  for (int own = 0; own < static_cast<int>(components.size()); ++own) {
    if (components[own].is_closed()) {
      closed.push_back(own);
      continue;
    }
    if (first_open < 0) first_open = own;
    shells.join(first_open, own);
    open = {open.low.cwiseMin(components[own].box.low), open.high.cwiseMax(components[own].box.high)};
  }
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const Box& own = components[closed[i]].box;
    if (first_open >= 0 && !(own.distance(open) > 0)) shells.join(closed[i], first_open);
    for (std::size_t other = 0; other < i; ++other)
      if (!(own.distance(components[closed[other]].box) > 0)) shells.join(closed[i], closed[other]);
  }
}

Filling fill_shell(const Inside& tree, const FillOptions& options) {
  Filling filling;
  filling.surface_volume = tree.winding ? volume_by_points(tree) : volume_inside(tree.points(), tree.triangles());
  const Vector3 box = tree.points().rowwise().maxCoeff() - tree.points().rowwise().minCoeff();
  check_count((box.array() / options.spacing + 1).prod(), "in the surface's box", options);
  if (options.follow) check_count(area_of(tree) / options.spacing / options.spacing, "on the surface", options);
  SpacedPoints found(options.spacing);
  if (options.follow) add_surface_points(tree.points(), tree.triangles(), options.spacing, options.seed, found);
  filling.on_surface = found.size();
  options.packing == FillPacking::lattice ? add_lattice(tree, options, found) : add_blue_noise(tree, options, found);
  filling.positions.resize(3, found.size());
  for (int m = 0; m < found.size(); ++m) filling.positions.col(m) = found.positions()[m];
  if (found.size() >= 4) filling.tetrahedra = tetrahedra_inside(tree, filling.positions, filling.on_surface);
  peel(filling.positions, filling.tetrahedra);
  if (filling.tetrahedra.empty()) return filling;
  leave_out_isolated(filling);
  const VectorX masses = lumped_mass(filling.positions, {}, filling.tetrahedra, 1, 0);
  filling.volume = masses.sum();
  if (tree.winding && !(filling.surface_volume > 0)) filling.surface_volume = filling.volume;
  filling.share = masses / filling.volume;
  return filling;
}

/// One filling of several, whose molecules on the surface come first.
Filling together(const std::vector<Filling>& all) {
  Filling whole;
  Eigen::Index molecules = 0;
  for (const Filling& own : all) {
    if (own.tetrahedra.empty()) {
      ++whole.empty_shells;
      continue;
    }
    molecules += own.positions.cols();
    whole.on_surface += own.on_surface, whole.left_out += own.left_out;
    whole.surface_volume += own.surface_volume, whole.volume += own.volume;
  }
  whole.positions.resize(3, molecules);
  whole.share.resize(molecules);
  whole.shell.resize(molecules);
  int on_surface = 0, inside = whole.on_surface;
  for (std::size_t shell = 0; shell < all.size(); ++shell) {
    const Filling& own = all[shell];
    if (own.tetrahedra.empty()) continue;
    std::vector<int> numbers;
    for (int m = 0; m < own.positions.cols(); ++m) {
      const int number = m < own.on_surface ? on_surface++ : inside++;
      numbers.push_back(number);
      whole.positions.col(number) = own.positions.col(m);
      whole.share[number] = own.share[m] * (own.surface_volume / whole.surface_volume);
      whole.shell[number] = static_cast<int>(shell);
    }
    for (auto cell : own.tetrahedra) {
      for (int& corner : cell) corner = numbers[corner];
      whole.tetrahedra.push_back(cell);
    }
  }
  return whole;
}

}  // namespace

FillRegion::FillRegion(const Positions& points, const Cells<3>& triangles, bool by_winding_number) {
  const std::vector<Component> components = components_of(points, triangles);
  DisjointSets sets(components.size());
  by_winding_number ? join_near(components, sets) : join_cavities(points, triangles, components, sets);
  std::map<int, std::vector<int>> shells;
  std::map<int, int> bodies;
  for (int own = 0; own < static_cast<int>(components.size()); ++own) {
    std::vector<int>& all = shells[sets.set_of(own)];
    all.insert(all.end(), components[own].triangles.begin(), components[own].triangles.end());
    if (by_winding_number && components[own].is_closed() && components[own].volume > 0)
      filled_as_one_ = std::max(filled_as_one_, ++bodies[sets.set_of(own)]);
  }
  for (const auto& [set, own] : shells) {
    auto [own_points, own_triangles] =
        shells.size() == 1 ? std::pair(points, triangles) : alone(points, triangles, own);
    std::unique_ptr<WindingNumber> winding;
    if (by_winding_number) winding = std::make_unique<WindingNumber>(own_points, own_triangles);
    shells_.emplace_back(new Inside{TriangleTree(std::move(own_points), std::move(own_triangles)), std::move(winding)});
  }
}
FillRegion::~FillRegion() = default;

Filling FillRegion::fill(const FillOptions& options) const {
  std::vector<Filling> all;
  FillOptions own = options;
  for (const auto& shell : shells_) {
    all.push_back(fill_shell(*shell, own));
    own.most_molecules -= static_cast<double>(all.back().positions.cols());
  }
  Filling filling = together(all);
  if (filling.tetrahedra.empty()) {
    double longest = 0;
    for (const auto& shell : shells_)
      longest =
          std::max(longest, (shell->points().rowwise().maxCoeff() - shell->points().rowwise().minCoeff()).maxCoeff());
    throw InputError("the spacing of " + number(options.spacing) +
                     " m is too wide: no tetrahedron fits inside the surface, whose longest side is " +
                     number(longest) + " m");
  }
  filling.slivers = hull::count_slivers(filling.positions, filling.tetrahedra);
  return filling;
}

Connections FillRegion::connections_within(const Filling& filling, double reach) const {
  const Connections near = elastin::connections_within(filling.positions, reach);
  const std::vector<std::array<int, 2>> sides = sides_of(filling.tetrahedra);
  VectorX depth(filling.positions.cols());
  parallel_for(static_cast<int>(depth.size()),
               [&](int m) { depth[m] = -shells_[filling.shell[m]]->signed_distance(filling.positions.col(m)); });
  std::vector<char> kept(near.ends.size());
  parallel_for(near.size(), [&](int c) {
    const auto& [a, b] = near.ends[c];
    const double length = near.rest_length[c];
    const Vector3 from = filling.positions.col(a), segment = filling.positions.col(b) - from;
    bool sees = filling.shell[a] == filling.shell[b];
    constexpr int parts = 8;
    if (depth[a] + depth[b] < length)  // else the way lies in two spheres that are inside
      for (int part = 1; part < parts && sees; ++part)
        sees = shells_[filling.shell[a]]->signed_distance(from + segment * part / parts) <= 0.05 * length;
    kept[c] = sees || std::binary_search(sides.begin(), sides.end(), std::array{a, b});
  });
  Connections connections;
  for (int c = 0; c < near.size(); ++c)
    if (kept[c]) {
      connections.ends.push_back(near.ends[c]);
      connections.rest_length.push_back(near.rest_length[c]);
    }
  return connections;
}

}  // namespace elastin::mesh
