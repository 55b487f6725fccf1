#include "lab/run/ends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "core/base/dense.h"
#include "core/geometry/boundary.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

constexpr double kLeastShare = 0.5;      ///< of the section that a grip must have
constexpr double kBehind = 0.05;         ///< of the length: the slab behind a grip whose section it is compared with
constexpr double kLargestTilt = 1;       ///< [°] of an end that goes without a warning
constexpr double kLargestAskew = 2;      ///< [°] between the axis and what joins the middles of its ends, the same
constexpr double kLargestHeight = 0.02;  ///< of the length, by which an end may leave its plane without a warning
constexpr double kSameArea = 0.01;  ///< relative difference of a plane end from its section that is not worth a note

std::string in_mm(double metres) { return number(1e3 * metres, 3) + " mm"; }

/// Lowest and highest of some molecules along a direction, of all processes.
std::pair<double, double> heights_of(const Body& body, const std::vector<int>& molecules, const Vector3& direction) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const int molecule : molecules) {
    const double height = direction.dot(body.rest.col(molecule));
    low = std::min(low, height), high = std::max(high, height);
  }
  return {least_over(body, low), largest_over(body, high)};
}

std::pair<double, double> heights_of(const Body& body, const Vector3& direction) {
  const VectorX heights = body.rest.transpose() * direction;
  return {least_over(body, heights.minCoeff()), largest_over(body, heights.maxCoeff())};
}

double count_of(const Body& body, const std::vector<int>& molecules) {
  return sum_over(body, static_cast<double>(std::count_if(molecules.begin(), molecules.end(), [&](int molecule) {
                    return molecule < owned_molecules(body);
                  })));
}

/// The section of the slab behind what is held, whose lowest molecule has the height `bottom`.
double section_behind(const Body& body, const Vector3& direction, double low, double high, double bottom) {
  const double from = std::max(low, bottom - kBehind * (high - low));
  return from < bottom ? find_section(body, direction, from, bottom, 0).area
                       : find_section(body, direction, low, high, 0).area;
}

/// The least grip depth [m], to two digits, with which an end has three molecules and half of the section behind them;
/// infinite where that takes half of the body.
double sufficient_depth(const Body& body, const Vector3& direction) {
  const auto [low, high] = heights_of(body, direction);
  const auto suffices = [&, low = low, high = high](double depth) {
    const Face face = end_face(body, direction, depth);
    return count_of(body, face.molecules) >= 3 &&
           face.area >= kLeastShare * section_behind(body, direction, low, high, high - depth);
  };
  double less = 0, depth = 0.49 * (high - low);
  if (!suffices(depth)) return std::numeric_limits<double>::infinity();
  while (depth - less > 1e-3 * depth && depth > 1e-5 * (high - low)) {
    const double middle = (less + depth) / 2;
    (suffices(middle) ? depth : less) = middle;
  }
  const double digit = std::pow(10, std::floor(std::log10(depth)) - 1);
  depth = std::ceil(depth / digit) * digit;
  return depth < 0.5 * (high - low) ? depth : std::numeric_limits<double>::infinity();
}

/// The molecules of an end, and all of the rigid bodies of which it has some: bone is held, or moved, as a whole.
std::vector<int> with_rigid_parts(const Body& body, const std::vector<int>& molecules) {
  std::vector<int> all = molecules;
  for (const Part& part : body.parts) {
    if (!part.rigid) continue;
    const std::vector<int> whole = molecules_of(part);
    const auto is_held = [&](int molecule) { return std::binary_search(whole.begin(), whole.end(), molecule); };
    if (std::any_of(molecules.begin(), molecules.end(), is_held)) all.insert(all.end(), whole.begin(), whole.end());
  }
  if (all.size() == molecules.size()) return all;
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

std::string area_text(double area) {
  if (!(area > 0)) return number(area) + " mm2";
  for (const auto& [unit, name, least] : {std::tuple{1., "m2", 1.}, {1e-6, "mm2", 1e-9}, {1e-12, "um2", 1e-15}})
    if (area >= least) return number(area / unit, 4) + " " + name;
  return number(area / 1e-18, 4) + " nm2";
}

Vector3 longest_axis(const Body& body) {
  const Vector3 middle = middle_of_whole(body);
  Matrix3 moments = Matrix3::Zero();
  const auto add = [&](const Vector3& arm, double weight) { moments += weight * arm * arm.transpose(); };
  if (any_over(body, !body.tetrahedra.empty())) {
    Vector3 first = Vector3::Zero();
    double volume = 0;
    for (const auto& cell : body.tetrahedra) {  // ∫ x xᵀ = V/20 (Σ x_a x_aᵀ + Σ x_a Σ x_aᵀ)
      if (lowest_in_whole(body, cell) >= owned_molecules(body)) continue;
      const double own = signed_volume(body.rest, cell);
      Vector3 sum = Vector3::Zero();
      for (const int corner : cell) {
        const Vector3 arm = body.rest.col(corner) - middle;
        sum += arm;
        add(arm, own / 20);
      }
      add(sum, own / 20);
      first += own / 4 * sum;
      volume += own;
    }
    first = vector_sum_over(body, first);
    volume = sum_over(body, volume);
    sum_over(body, {moments.data(), 9});
    add(first, -1 / volume);
  } else {
    for (int molecule = 0; molecule < owned_molecules(body); ++molecule) add(body.rest.col(molecule) - middle, 1);
    sum_over(body, {moments.data(), 9});
  }
  const SymmetricEigen3 principal = symmetric_eigen3(moments);
  if (!(std::sqrt(principal.values[1]) < 0.99 * std::sqrt(principal.values[2])))
    throw InputError("the body extends as far along another axis: give a direction, such as x or [1, 0.2, 0]");
  Vector3 axis = principal.vectors.col(2);
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0 ? Vector3(-axis) : axis;
}

Face EndFinder::find(const std::string& name, const Vector3& direction, const std::optional<std::vector<int>>& picked) {
  if (!picked) {
    Face face = end_face(body_, direction, grip_depth_);
    any_over(body_, !body_.tetrahedra.empty()) ? judge_solid(name, direction, false, face)
                                               : judge_molecules(name, direction, face);
    return face;
  }
  Face face = face_of(body_, *picked, direction);
  if (any_over(body_, !body_.tetrahedra.empty())) judge_solid(name, direction, true, face);
  return face;
}

void EndFinder::judge_solid(const std::string& name, const Vector3& direction, bool picked, const Face& face) {
  const auto [low, high] = heights_of(body_, direction);
  const auto [bottom, top] = heights_of(body_, face.molecules, direction);
  const double section = section_behind(body_, direction, low, high, bottom), count = count_of(body_, face.molecules);
  const std::string held = "the " + name + " end holds " + counted(static_cast<int>(count), "molecule") + " on " +
                           area_text(face.area) + " of a section of " + area_text(section);
  if (count < 3 || !(face.area >= kLeastShare * section)) {
    const double depth = sufficient_depth(body_, direction);
    const std::string better = (std::isfinite(depth) ? "write grip_depth: " + in_mm(depth) + ", or " : "") +
                               "pick it with `" + name + ": {set: NAME}`, a plane, a sphere or a box";
    if (picked || (grip_depth_ > 0 && count >= 3))
      findings.warnings.push_back(held + (picked ? "" : ": " + better));
    else
      throw InputError(held + ": " + better);
    return;
  }
  if (picked || grip_depth_ > 0 || !face.tilted.isZero(0) || std::abs(face.area / section - 1) > kSameArea)
    findings.notes.push_back(held + (top - bottom > 1e-6 * (high - low)
                                         ? ", up to " + in_mm(top - bottom) +
                                               (body_.outline.cols() > 0 ? " behind the furthest corner of a box"
                                                                         : " behind the furthest one")
                                         : ""));
  if (face.tilted.isZero(0)) return;
  const double tilt = std::acos(std::clamp(face.tilted.dot(direction), -1., 1.)) * 180 / std::numbers::pi;
  const auto [inner, outer] = heights_of(body_, face.molecules, face.tilted);
  if (outer - inner > kLargestHeight * (high - low))
    findings.warnings.push_back("the " + name + " end is not plane: its molecules lie up to " + in_mm(outer - inner) +
                                " behind one another, so results depend on what of it is held; write a grip_depth, or "
                                "pick it with `" +
                                name + ": {…}`");
  else if (tilt > kLargestTilt)
    findings.warnings.push_back(
        "the " + name + " end is tilted by " + number(tilt, 2) + "° from the axis" +
        (longest_ ? "" : "; where the body is to be loaded along its own, write axis: longest"));
}

void EndFinder::judge_molecules(const std::string& name, const Vector3& direction, const Face& face) {
  if (any_over(body_, !body_.triangles.empty())) return;
  const double whole = polygon_area(hull_of_whole(body_, across(direction)));
  if (face.area >= kLeastShare * whole) return;
  findings.warnings.push_back(
      "the " + name + " end holds " + counted(static_cast<int>(count_of(body_, face.molecules)), "molecule") + " on " +
      area_text(face.area) + " of the hull's " + area_text(whole) + (grip_depth_ > 0 ? "" : ": give a grip_depth"));
}

/// Tilt of ends that were picked, or have a depth, which no side of the body shows: [°] between the axis and the line
/// that joins their middles, where the body's longest axis is nearer to that line; else 0.
double askew_of(const Body& body, const Vector3& axis, const Face& fixed, const Face& loaded) {
  const Vector3 line = (middle_of(body, loaded, body.rest) - middle_of(body, fixed, body.rest)).normalized();
  const auto degrees = [&](double cosine) { return std::acos(std::clamp(cosine, -1., 1.)) * 180 / std::numbers::pi; };
  const double askew = degrees(line.dot(axis));
  if (!(askew > kLargestAskew)) return 0;
  try {
    return degrees(std::abs(line.dot(longest_axis(body)))) < askew / 2 ? askew : 0;
  } catch (const InputError&) {  // none is the longest
    return 0;
  }
}

double end_of_grip(const Body& body, const std::vector<int>& molecules, const Vector3& axis, double otherwise) {
  std::vector<char> in_grip(static_cast<std::size_t>(body.size()), 0), leads_out(in_grip);
  for (const int molecule : molecules) in_grip[molecule] = 1;
  const auto join = [&](const auto& nodes) {
    const auto is_held = [&](int node) { return in_grip[node] != 0; };
    if (std::all_of(nodes.begin(), nodes.end(), is_held)) return;
    for (const int node : nodes)
      if (is_held(node)) leads_out[node] = 1;
  };
  for (const auto& ends : body.connections.ends) join(ends);
  if (body.connections.size() == 0) {
    for (const auto& cell : body.tetrahedra) join(cell);
    for (const auto& cell : body.triangles) join(cell);
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) join(block.cell(cell));
  }
  std::array<double, 3> sums{0, 0, 0};  // of heights, of those that lead out, of all
  for (const int molecule : molecules) {
    if (molecule >= owned_molecules(body)) continue;
    sums[0] += leads_out[molecule] ? axis.dot(body.rest.col(molecule)) : 0;
    sums[1] += leads_out[molecule];
    ++sums[2];
  }
  sum_over(body, sums);
  return sums[1] == 0 || sums[1] == sums[2] ? otherwise : sums[0] / sums[1];
}

void note_stated(const std::string& key, const std::string& refer, double stated, const std::vector<double>& own,
                 const std::function<std::string(double)>& text, Findings& findings) {
  constexpr double far = 2;
  const auto [least, most] = std::minmax_element(own.begin(), own.end());
  if (!(stated < *least / far) && !(stated > far * *most)) return;
  findings.notes.push_back(key + ": " + text(stated) + " is given, where the body's own is " + text(own.front()) +
                           ": " + refer + " refer to what is given");
}

void note_stated_section(const Body& body, const Vector3& axis, double stated, double section, Findings& findings) {
  if (!(stated > 0) || !(section > 0)) return;
  const Points2 hull = hull_of_whole(body, across(axis));
  double girth = 0;
  for (Eigen::Index i = 0; i < hull.cols(); ++i) girth += (hull.col((i + 1) % hull.cols()) - hull.col(i)).norm();
  const double area = polygon_area(hull), radius = largest_over(body, body.radius.mean());
  std::vector<double> own{section};
  if (area > 0) own.insert(own.end(), {area, area + radius * (girth + std::numbers::pi * radius)});
  note_stated("cross_section", "stress and modulus", stated, own, area_text, findings);
}

void note_cavities(const Body& body, Findings& findings) {
  for (const Part& part : body.parts)
    if (part.rigid)
      throw InputError("the whole surface is to follow the strain, which the rigid body '" + part.name + "' cannot");
  if (body.share || body.tetrahedra.empty()) return;
  const Cells<3> walls = boundary_of(body.tetrahedra);
  std::vector<int> piece(static_cast<std::size_t>(body.size()));  // of each molecule of a wall, another one
  std::iota(piece.begin(), piece.end(), 0);
  const auto first_of = [&](int molecule) {
    while (piece[molecule] != molecule) molecule = piece[molecule] = piece[piece[molecule]];
    return molecule;
  };
  for (const auto& [a, b, c] : walls) piece[first_of(a)] = first_of(b), piece[first_of(b)] = first_of(c);
  std::map<int, double> volumes;  // enclosed: below 0 where the body lies outside
  for (const auto& [a, b, c] : walls)
    volumes[first_of(a)] += body.rest.col(a).dot(Vector3(body.rest.col(b)).cross(Vector3(body.rest.col(c)))) / 6;
  const auto is_cavity = [](const auto& one) { return one.second < 0; };
  if (const auto count = std::count_if(volumes.begin(), volumes.end(), is_cavity))
    findings.warnings.push_back("the walls of " + std::to_string(count) +
                                (count == 1 ? " cavity move" : " cavities move") +
                                " as the surface does: these are the moduli of the material between them, not those of "
                                "the body with its holes");
}

Points2 hull_of_section(const Body& body, const Face& fixed, const Eigen::Matrix<double, 3, 2>& plane) {
  if (fixed.tilted.isZero(0)) return hull_of_whole(body, plane);
  Points2 seen(2, static_cast<Eigen::Index>(fixed.molecules.size()));
  Eigen::Index count = 0;
  for (const int molecule : fixed.molecules)
    if (molecule < owned_molecules(body)) seen.col(count++) = plane.transpose() * body.rest.col(molecule);
  return hull_over(body, seen.leftCols(count));
}

double needed_grip_depth(const Body& body, const Vector3& axis) {
  try {
    if (Ends(body, axis, {}).findings.warnings.empty()) return 0;
  } catch (const InputError&) {
  }
  const double depth = std::max(sufficient_depth(body, axis), sufficient_depth(body, -axis));
  return std::isfinite(depth) ? depth : 0;
}

Ends::Ends(const Body& body, const Vector3& axis, const GripSetup& setup) {
  EndFinder finder(body, setup.grip_depth, setup.longest);
  loaded = finder.find("loaded", axis, setup.loaded);
  fixed = finder.find("fixed", -axis, setup.fixed);
  findings = std::move(finder.findings);
  std::vector<int> both;
  std::set_intersection(fixed.molecules.begin(), fixed.molecules.end(), loaded.molecules.begin(),
                        loaded.molecules.end(), std::back_inserter(both));
  std::tie(low, high) = heights_of(body, axis);
  const double whole = high - low;
  const bool behind = setup.grip_depth > 0;
  if (setup.fixed || behind || !fixed.tilted.isZero(0)) low = heights_of(body, fixed.molecules, axis).second;
  if (setup.loaded || behind || !loaded.tilted.isZero(0)) high = heights_of(body, loaded.molecules, axis).first;
  const bool meet = any_over(body, !both.empty());
  if ((meet || !(low < high)) && !setup.fixed && !setup.loaded && !(setup.grip_depth > 0)) {
    const double depth = std::max(sufficient_depth(body, axis), sufficient_depth(body, -axis));
    throw InputError(
        "the body has no two ends across this axis, for the sides that look along it reach as far as those that look "
        "the other way: write another axis, such as axis: longest, " +
        (std::isfinite(depth) ? "or grip_depth: " + in_mm(depth) + ", " : std::string()) +
        "or pick them with `fixed: {…}` and `loaded: {…}`");
  }
  if (meet)
    throw InputError("the fixed end and the loaded one have " +
                     counted(static_cast<int>(count_of(body, both)), "molecule") +
                     " in common; give a smaller grip_depth, or other molecules");
  if (!(low < high)) throw InputError("the fixed end must lie below the loaded one along the axis");
  slanted = !setup.fixed && !setup.loaded && !behind && whole - (high - low) > 0.25 * (whole + (high - low)) / 2;
  held = with_rigid_parts(body, fixed.molecules), moved = with_rigid_parts(body, loaded.molecules);
  if (held.size() + moved.size() > fixed.molecules.size() + loaded.molecules.size() &&
      std::find_first_of(held.begin(), held.end(), moved.begin(), moved.end()) != held.end())
    throw InputError("one rigid body reaches from the fixed end to the loaded one: nothing is left to be measured");
  if (setup.longest || !(setup.fixed || setup.loaded || behind) || any_over(body, body.tetrahedra.empty())) return;
  if (const double askew = askew_of(body, axis, fixed, loaded); askew > 0)
    findings.warnings.push_back("the line between the middles of the ends is tilted by " + number(askew, 2) +
                                "° from the axis; where the body is to be loaded along its own, write axis: longest");
}

}  // namespace elastin::lab
