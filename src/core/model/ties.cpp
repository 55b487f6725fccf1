#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>
#include <utility>

#include "core/geometry/triangle_tree.h"
#include "core/model/ties.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/surface.h"

namespace elastin {
namespace {

/// Molecules at one position are no further apart than this part of the longest connection at them: more than single
/// precision, in which surfaces are kept, leaves between two files of one position.
constexpr double kSamePosition = 1e-4;

/// What a part shows to a tie: its surface, in the numbers of the whole body.
struct Side {
  const Part* part;
  Cells<3> triangles;
  std::vector<int> molecules;  ///< on the surface, ascending; all where it has none
};

Side side_of(const Body& body, const Part& part) {
  Side side{&part, surface_of(with_cells_of(body, part)), {}};
  for (const auto& triangle : side.triangles)
    side.molecules.insert(side.molecules.end(), triangle.begin(), triangle.end());
  std::sort(side.molecules.begin(), side.molecules.end());
  side.molecules.erase(std::unique(side.molecules.begin(), side.molecules.end()), side.molecules.end());
  if (side.molecules.empty()) side.molecules = molecules_of(part);
  return side;
}

/// The longest connection at each molecule [m].
VectorX longest_connections(const Body& body) {
  VectorX longest = VectorX::Zero(body.size());
  for (int c = 0; c < body.connections.size(); ++c)
    for (const int end : body.connections.ends[c])
      longest[end] = std::max(longest[end], body.connections.rest_length[c]);
  return longest;
}

/// A third of the triangles around each molecule [m²].
VectorX surface_shares(const Body& body, const Cells<3>& triangles) {
  VectorX areas = VectorX::Zero(body.size());
  for (const auto& [a, b, c] : triangles) {
    const Vector3 ab = body.rest.col(b) - body.rest.col(a), ac = body.rest.col(c) - body.rest.col(a);
    for (const int corner : {a, b, c}) areas[corner] += ab.cross(ac).norm() / 6;
  }
  return areas;
}

/// Pairs of molecules of the two sides that lie at one position, those of the first part first.
std::vector<std::array<int, 2>> pairs_at_one_position(const Body& body, const Side& one, const Side& other) {
  const VectorX longest = longest_connections(body);
  const double reach = kSamePosition * std::max(longest(one.molecules).maxCoeff(), longest(other.molecules).maxCoeff());
  std::vector<int> both = one.molecules;
  both.insert(both.end(), other.molecules.begin(), other.molecules.end());
  const auto firsts = static_cast<int>(one.molecules.size());
  std::vector<std::array<int, 2>> pairs;
  if (!(reach > 0)) return pairs;
  for (const auto& [a, b] : connections_within(body.rest(Eigen::all, both), reach).ends) {
    if (a >= firsts || b < firsts || both[a] == both[b]) continue;
    const int from = both[a], to = both[b];
    const double apart = (body.rest.col(from) - body.rest.col(to)).norm();
    if (apart <= kSamePosition * std::min(longest[from], longest[to])) pairs.push_back({from, to});
  }
  return pairs;
}

/// Numbers that molecules get when some of them become others: kept[m] is the one that m becomes.
std::vector<int> new_numbers(const std::vector<int>& kept) {
  std::vector<int> number(kept.size());
  int next = 0;
  for (std::size_t m = 0; m < kept.size(); ++m)
    if (kept[m] == static_cast<int>(m)) number[m] = next++;
  for (std::size_t m = 0; m < kept.size(); ++m) number[m] = number[kept[m]];
  return number;
}

/// Leaves the first of connections of one pair; says which number each gets.
std::vector<int> renumber_connections(Body& body, const std::vector<int>& number) {
  Connections kept;
  std::set<std::array<int, 2>> known;
  std::unordered_map<long long, int> number_of;
  std::vector<int> now, left;
  for (int c = 0; c < body.connections.size(); ++c) {
    auto [a, b] = body.connections.ends[c];
    a = number[a], b = number[b];
    const long long key = static_cast<long long>(std::min(a, b)) << 32 | std::max(a, b);
    const auto [found, fresh] = number_of.try_emplace(key, kept.size());
    now.push_back(found->second);
    if (!fresh) continue;
    kept.ends.push_back({a, b});
    kept.rest_length.push_back(body.connections.rest_length[c]);
    kept.cell_sides += c >= body.connections.proper();
    left.push_back(c);
  }
  if (body.connection_stiffness.size()) body.connection_stiffness = body.connection_stiffness(left).eval();
  body.connections = std::move(kept);
  return now;
}

void renumber_parts(Body& body, const std::vector<int>& kept, const std::vector<int>& number) {
  for (Part& part : body.parts) {
    std::set<int> shared;
    for (const int molecule : part.shared) shared.insert(number[molecule]);
    int first = -1, count = 0;
    for (int m = part.first; m < part.first + part.count; ++m) {
      const int now = number[m];
      if (kept[m] != m) {
        shared.insert(now);
        continue;
      }
      if (count++ == 0) first = now;
    }
    part.first = first, part.count = count;
    part.shared.assign(shared.begin(), shared.end());
    if (part.voronoi && part.voronoi->problem.empty()) part.voronoi.reset();
  }
  int next = 0;  // of a part that has no molecule of its own left
  for (Part& part : body.parts) {
    if (part.count == 0) part.first = next;
    next = part.first + part.count;
    std::erase_if(part.shared, [&](int m) { return m >= part.first && m < part.first + part.count; });
  }
}

/// Returns the new number of each molecule.
std::vector<int> join(Body& body, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<int> kept(body.size());
  for (std::size_t m = 0; m < kept.size(); ++m) kept[m] = static_cast<int>(m);
  for (const auto& [a, b] : pairs) kept[std::max(a, b)] = std::min(a, b);
  for (int& molecule : kept)
    while (kept[molecule] != molecule) molecule = kept[molecule];
  std::vector<int> left;
  for (int m = 0; m < body.size(); ++m)
    if (kept[m] == m)
      left.push_back(m);
    else
      body.mass[kept[m]] += body.mass[m];
  const std::vector<int> number = new_numbers(kept);
  const auto renumber = [&](auto& cells) {
    for (auto& cell : cells)
      for (int& corner : cell) corner = number[corner];
  };
  renumber(body.triangles), renumber(body.tetrahedra), renumber(body.cubes);
  for (CellBlock& block : body.blocks)
    for (int& node : block.nodes) node = number[node];
  const std::vector<int> connection = renumber_connections(body, number);
  for (Cable& cable : body.cables) cable.connection = connection[cable.connection];
  for (Tie& tie : body.ties) {
    tie.molecule = number[tie.molecule];
    for (int& corner : tie.corners) corner = number[corner];
  }
  renumber_parts(body, kept, number);
  body.rest = body.rest(Eigen::all, left).eval();
  body.mass = body.mass(left).eval(), body.radius = body.radius(left).eval();
  return number;
}

/// Distance of the side's molecules from a surface, and where on it.
std::vector<TriangleTree::Nearest> nearest_on(const Body& body, const Side& side, const TriangleTree& tree) {
  std::vector<TriangleTree::Nearest> found;
  for (const int molecule : side.molecules) found.push_back(tree.nearest(body.rest.col(molecule)));
  return found;
}

int count_near(const std::vector<TriangleTree::Nearest>& found, double within) {
  return static_cast<int>(
      std::count_if(found.begin(), found.end(), [&](const auto& one) { return one.distance <= within; }));
}

std::string nearest_text(double distance, double within) {
  char text[120];
  std::snprintf(text, sizeof text, "no molecules lie within %.4g mm of each other; the nearest are %.4g mm apart",
                1e3 * within, 1e3 * distance);
  return text;
}

/// Fixes molecules of `side` to a rigid part.
void fix(Body& body, Part& rigid, const Side& side, double within, TieReport& report) {
  const Side bone = side_of(body, rigid);
  std::set<int> shared(rigid.shared.begin(), rigid.shared.end());
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](int molecule, double distance) {
    least = std::min(least, distance);
    const bool own = molecule >= rigid.first && molecule < rigid.first + rigid.count;
    if (distance <= within && !own) report.fixed += shared.insert(molecule).second;
  };
  if (!bone.triangles.empty()) {
    const TriangleTree tree(body.rest, bone.triangles);
    for (const int molecule : side.molecules) take(molecule, tree.nearest(body.rest.col(molecule)).distance);
  } else {
    for (const int molecule : side.molecules)
      for (const int other : bone.molecules) take(molecule, (body.rest.col(molecule) - body.rest.col(other)).norm());
  }
  if (least > within) throw InputError(nearest_text(least, within));
  rigid.shared.assign(shared.begin(), shared.end());
}

/// Moves molecules of `slaves` that are no corners of the other surface onto it, and ties them there.
void tie_to(Body& body, const Side& slaves, const std::vector<TriangleTree::Nearest>& nearest, const Side& masters,
            double within, double stiffness, TieReport& report) {
  std::vector<char> taken(body.size(), 0);
  for (const int molecule : masters.molecules) taken[molecule] = 1;
  for (const Tie& tie : body.ties) taken[tie.molecule] = 1;
  const VectorX areas = surface_shares(body, slaves.triangles);
  for (std::size_t i = 0; i < slaves.molecules.size(); ++i) {
    const int molecule = slaves.molecules[i];
    const auto& [triangle, on, distance] = nearest[i];
    if (distance > within || taken[molecule]) continue;
    const double area = slaves.triangles.empty() ? 4 * std::pow(body.radius[molecule], 2) : areas[molecule];
    body.ties.push_back({molecule, masters.triangles[triangle], on.weights, stiffness * std::sqrt(area)});
    body.rest.col(molecule) = on.position;
    report.furthest = std::max(report.furthest, distance);
    ++report.tied;
  }
  std::vector<char> moved(body.size(), 0);
  for (const Tie& tie : body.ties) moved[tie.molecule] = 1;
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    if (moved[a] || moved[b]) body.connections.rest_length[c] = (body.rest.col(b) - body.rest.col(a)).norm();
  }
}

void tie_soft(Body& body, const Part& first, const Part& second, double within, double stiffness, TieReport& report,
              std::vector<int>& numbers) {
  const std::string one_name = first.name, other_name = second.name;
  const auto pairs = pairs_at_one_position(body, side_of(body, first), side_of(body, second));
  report.joined = static_cast<int>(pairs.size());
  if (!pairs.empty()) numbers = join(body, pairs);
  Side slaves = side_of(body, find_part(body, one_name)), masters = side_of(body, find_part(body, other_name));
  if (slaves.triangles.empty() && masters.triangles.empty()) {
    if (pairs.empty()) throw InputError("neither has a surface to tie to: give one of them cells: delaunay");
    return;
  }
  std::vector<TriangleTree::Nearest> nearest, back;
  if (!masters.triangles.empty()) nearest = nearest_on(body, slaves, {body.rest, masters.triangles});
  if (!slaves.triangles.empty()) back = nearest_on(body, masters, {body.rest, slaves.triangles});
  if (count_near(nearest, within) < count_near(back, within)) std::swap(slaves, masters), std::swap(nearest, back);
  double least = std::numeric_limits<double>::infinity();
  for (const auto& one : nearest) least = std::min(least, one.distance);
  if (least > within) throw InputError(nearest_text(least, within));
  tie_to(body, slaves, nearest, masters, within, stiffness, report);
}

}  // namespace

TieReport tie_parts(Body& body, const std::string& first, const std::string& second, double within, double stiffness) {
  std::vector<int> numbers;
  return tie_parts(body, first, second, within, stiffness, numbers);
}

TieReport tie_parts(Body& body, const std::string& first, const std::string& second, double within, double stiffness,
                    std::vector<int>& numbers) {
  numbers.clear();
  const Part &one = find_part(body, first), &other = find_part(body, second);
  if (&one == &other) throw InputError("'" + first + "' cannot be tied to itself");
  if (one.rigid && other.rigid) throw InputError("'" + first + "' and '" + second + "' are both rigid");
  TieReport report;
  if (one.rigid || other.rigid) {
    Part& rigid = body.parts[(one.rigid ? &one : &other) - body.parts.data()];
    fix(body, rigid, side_of(body, one.rigid ? other : one), within, report);
  } else {
    tie_soft(body, one, other, within, stiffness, report, numbers);
  }
  return report;
}

}  // namespace elastin
