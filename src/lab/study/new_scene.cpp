#include "lab/study/study.h"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/base/dense.h"
#include "core/base/disjoint_sets.h"
#include "core/base/named.h"
#include "core/simulation/warnings.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/units.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/run/ends.h"
#include "lab/run/specimen.h"
#include "mesh/image_values.h"

namespace elastin::lab {
namespace {

constexpr double kMostCubes = 800, kMostNewMolecules = 3000;

/// What every scene ends with: the words of the material and the strategies.
constexpr const char* kMaterial = R"(
# E and nu of small strains. A law with constants of its own takes their place: `elastin list` names them.
material: {{youngs_modulus: {modulus}, poissons_ratio: {nu}, density: 1000 kg/m3}}

# `elastin run` runs the first; `elastin compare` all of these, or with --strategies all every one that there is.
stiffness: {solid}
strategies: [standard, {springs}, neo_hookean{volume}]
)";

constexpr const char* kStrip = R"(# A strip in a testing machine: both ends are clamped, one is pulled along {axis}.
# Check it with `elastin check`, run it with `elastin compare --out out`, look at out/report.html.
title: Strip of {size}, clamped at both ends

# A block along x, y, z, of cubes that are filled with tetrahedra. More cubes: nearer to the truth, and slower.
body:
  tetrahedra: {{kind: body_centred, cubes: [{cubes}], size: [{sides}]}}
{material}
# Strategies are compared with the material's own law on finer and finer cells, computed once, for a clamped strip does
# not show E. Measured forces go under `expect`, see `elastin list --keys`.
experiment:
  kind: tension
  axis: {axis}                   # the longest side
  displacement: {displacement}   # 15 % of it
  fixed_grip: clamped       # sliding: free to narrow
  loaded_grip: clamped
  load_steps: 5             # points of the stress-strain curve
)";

constexpr const char* kDogbone =
    R"(# A dog-bone specimen from a mesh: its tabs are clamped, and an extensometer reads between two planes.
# Check it with `elastin check`, run it with `elastin compare --out out`, look at out/report.html.
title: Dog-bone specimen

# Tetrahedra of Gmsh, VTK, Abaqus …
body:
  mesh: {{file: {mesh}, length_unit: {unit}}}
{material}
experiment:
  kind: tension
  axis: {axis}                   # along which the mesh is longest: {length}
{grips}  displacement: {displacement}   # of the loaded end; 5 % of the length
  fixed_grip: clamped
  loaded_grip: clamped
  gauge: [{gauge}]   # planes of the extensometer from the fixed end: the middle quarter. Set them to yours
  load_steps: 5
)";

constexpr const char* kIndentation =
    R"(# A rigid sphere pressed into a block from above, which lies on a plate that holds it.
# Check it with `elastin check`, run it with `elastin compare --out out`, look at out/report.html.
title: Indentation of a block of {size}

body:
  tetrahedra: {{kind: body_centred, cubes: [{cubes}], size: [{sides}]}}
{grade}{material}
experiment:
  kind: indentation
  indenter: {{sphere: {{radius: {radius}}}}}   # or flat: {{radius: ...}}
  depth: {depth}
  bottom: clamped           # sliding: free to spread
  load_steps: 4             # points of the force-depth curve
contact: {{friction: 0}}      # Coulomb's coefficient
)";

constexpr const char* kOrgan =
    R"(# An organ from its surface, on a bed that holds it from below, with a round tool pressed into it from above.
# Check it with `elastin check`, run it with `elastin compare --out out`, look at out/report.html.
title: Organ under a round tool

# A closed surface of triangles (.stl, .obj, .ply), filled with tetrahedra of about this spacing.
body:
  fill: {{file: {mesh}, length_unit: {unit}, spacing: {spacing}}}
{material}
experiment:
  kind: indentation
  indenter: {{sphere: {{radius: {radius}}}}}
  depth: {depth}
  bottom: clamped
  grip_depth: {grip}        # what lies so near to the lowest point is held
  load_steps: 4
contact: {{friction: 0.3}}    # Coulomb's coefficient
)";

constexpr const char* kScan =
    R"(# A body out of an image of voxels: its two ends are clamped, and one is pulled.
# Check it with `elastin check`, run it with `elastin compare --out out`, look at out/report.html.
title: A body out of an image

body:
  image:
    file: {mesh}
    length_unit: {unit}
{voxel}{labels}    pieces: largest         # all: what hangs together by no face, too
    spacing: {spacing}        # side of a box. Smaller: nearer to the truth, and slower
    fill_fraction: true     # a box is as stiff as it is full
    as: hexahedra           # or lattice, tetrahedra, packing
{material}
experiment:
  kind: tension
  axis: {axis}                   # along which the body is longest: {length}
  grip_depth: {grip}      # what lies so near to the furthest point of an end is held
  displacement: {displacement}   # of the loaded end; 3 % of the length
  cross_section: {section} # volume over length
  fixed_grip: clamped
  loaded_grip: clamped
  load_steps: 3
)";

struct Row {
  NewSpecimen specimen;
  const char* text;
  const char* springs;  ///< rules in addition to `standard`: under a tool lloyd and van_gelder may find no equilibrium
                        ///< at nu = 0.45; of a scan they hang on its boxes
};

constexpr const char* kSprings = "lloyd, \"calibrated:van_gelder\"";

constexpr std::array kRows{
    Row{{"strip", "a block, clamped at both ends and pulled", ""}, kStrip, kSprings},
    Row{{"dogbone", "a mesh, clamped at both ends and pulled, read between two planes", "mesh"}, kDogbone, kSprings},
    Row{{"indentation", "a block under a rigid sphere", ""}, kIndentation, "patch"},
    Row{{"organ", "a closed surface, filled, under a rigid sphere", "closed surface"}, kOrgan, "patch"},
    Row{{"scan", "an image of voxels, clamped at both ends and pulled", "image"}, kScan, ""}};

/// "12.5 mm": three digits, in the unit that keeps them readable.
std::string length_text(double metres) {
  for (const auto& [factor, unit] : {std::pair{1., "m"}, {1e-3, "mm"}, {1e-6, "um"}})
    if (metres >= factor * 0.9995) return fmt::format("{:.3g} {}", metres / factor, unit);
  return fmt::format("{:.3g} nm", metres / 1e-9);
}

/// Of a length unit [m] that a file states; "mm" where it states none.
std::string unit_name(double metres) {
  for (const auto& [factor, unit] : {std::pair{1., "m"}, {1e-2, "cm"}, {1e-6, "um"}, {1e-9, "nm"}})
    if (std::abs(metres / factor - 1) < 1e-6) return unit;
  return "mm";
}

/// "40 x 10 x 4 mm" in metres; a side without a unit has that of the last.
Vector3 sides_of(const std::string& size, const std::string& option = "--size") {
  std::vector<std::string> parts{""};
  for (std::size_t i = 0; i < size.size(); ++i)
    if (size[i] == 'x' || size[i] == '*' || size[i] == ',')
      parts.emplace_back();
    else if (size.compare(i, 2, "×") == 0)
      parts.emplace_back(), ++i;
    else
      parts.back() += size[i];
  const std::string wrong = option + ": '" + size + "' is not three lengths, such as 40 x 10 x 4 mm";
  if (parts.size() != 3) throw InputError(wrong);
  const std::string unit = parts[2].substr(std::min(parts[2].find_first_not_of(" 0123456789.+-e"), parts[2].size()));
  Vector3 sides;
  for (std::size_t k = 0; k < 3; ++k) {
    try {
      const std::string trimmed = parts[k].substr(std::min(parts[k].find_first_not_of(' '), parts[k].size()));
      Quantity side = parse_quantity(trimmed, dimension::length);
      if (!side.has_unit) side = parse_quantity(trimmed + " " + unit, dimension::length);
      sides[static_cast<Eigen::Index>(k)] = side.value;
      if (!side.has_unit || !(side.value > 0)) throw InputError(wrong);
    } catch (const InputError&) {
      throw InputError(wrong);
    }
  }
  return sides;
}

using Words = fmt::dynamic_format_arg_store<fmt::format_context>;

void add(Words& words, const char* name, const std::string& value) { words.push_back(fmt::arg(name, value)); }

/// Cubes that are nearly as wide as long, at least `least` of them along each side.
void add_block(Words& words, const Vector3& sides, int least) {
  double edge = std::max(sides.minCoeff() / least, std::cbrt(sides.prod() / kMostCubes));
  std::string cubes, lengths;
  for (int k = 0; k < 3; ++k) {
    const int count = std::max(least, static_cast<int>(std::lround(sides[k] / edge)));
    cubes += (k ? ", " : "") + std::to_string(count);
    lengths += (k ? ", " : "") + length_text(sides[k]);
  }
  add(words, "cubes", cubes);
  add(words, "sides", lengths);
}

/// The same under a tool on the upper face: smallest in its middle, where some 17 molecules or more come to touch a
/// sphere of the least side that goes a tenth of it deep, and larger towards what lies far from it.
void add_graded_block(Words& words, const Vector3& sides) {
  constexpr double most_growth = 3.4, most = 16;  // of a cube in the mean over the smallest; along a side
  const double least = sides.minCoeff();
  std::string cubes, lengths, grades;
  double all = INFINITY;
  for (const int base : {8, 6}) {
    if (all <= kMostCubes) break;
    cubes = lengths = grades = "", all = 1;
    for (int k = 0; k < 3; ++k) {
      const double smallest = base * sides[k] / least;  // that would fill the side
      const double wanted = std::min(most, std::max(base * std::cbrt(smallest / base), smallest / most_growth));
      const int count = std::max(base, 2 * static_cast<int>(std::lround(wanted / 2)));
      const double growth = smallest / count;
      double ratio = growth * growth;  // of the largest cube over the smallest: (r − 1) / ln r is the mean
      for (int i = 0; i < 100 && growth > 1; ++i) ratio = 1 + growth * std::log(ratio);
      cubes += (k ? ", " : "") + std::to_string(count);
      lengths += (k ? ", " : "") + length_text(sides[k]);
      if (ratio > 1.1)
        grades += fmt::format("{}{{axis: {}, ratio: {:.2g}{}}}", grades.empty() ? "" : ", ", "xyz"[k],
                              std::max(0.01, 1 / ratio),  // what `grade` takes
                              k < 2 ? ", ends: both" : "");
      all *= count;
    }
  }
  add(words, "cubes", cubes);
  add(words, "sides", lengths);
  add(words, "grade", grades.empty() ? "" : "  grade: [" + grades + "]   # smaller cubes under the sphere\n");
}

/// Points [m] and cells of a file.
Body body_of(const NewScene& wanted) {
  const mesh::Mesh mesh = mesh::load_mesh(wanted.mesh);
  const bool solid = !mesh.tetrahedra.empty();
  if (wanted.specimen == "dogbone" && !solid)
    throw InputError(wanted.mesh +
                     ": a dogbone is a mesh of cells of three dimensions, and this one has none; "
                     "elastin new organ --mesh fills a closed surface");
  if (wanted.specimen == "organ" && solid)
    throw InputError(wanted.mesh +
                     ": an organ is filled from its closed surface of triangles, and this mesh is solid; "
                     "elastin new dogbone --mesh takes solids");
  Body body;
  body.rest = parse_quantity("1 " + wanted.length_unit, dimension::length).value * mesh.points;
  body.tetrahedra = mesh.tetrahedra;
  return body;
}

/// An axis as a scene names it, and how far a body reaches along it.
struct LongAxis {
  std::string name;
  Vector3 axis;
  double length;  ///< [m]
};

/// Along the longest side of a body's box, or `longest` where the body lies more askew in it than that [rad].
LongAxis long_axis_of(const Body& body, double most_askew) {
  Eigen::Index longest = 0;
  (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).maxCoeff(&longest);
  LongAxis found{std::string(1, "xyz"[longest]), Vector3::Unit(longest), 0};
  constexpr double plump = 0.9;  // across its longest axis: what a scene makes of it may have another longest one
  const Positions arms = body.rest.colwise() - body.rest.rowwise().mean();
  const Vector3 moments = symmetric_eigen3(arms * arms.transpose()).values;
  try {
    if (const Vector3 own = longest_axis(body);
        own.cross(found.axis).norm() > most_askew && moments[1] < plump * plump * moments[2])
      found.axis = own, found.name = "longest";
  } catch (const InputError&) {  // no axis is the longest: that of the box
  }
  const VectorX heights = body.rest.transpose() * found.axis;
  found.length = heights.maxCoeff() - heights.minCoeff();
  return found;
}

/// The axis of a specimen of a mesh, its length, and what its grips need.
void add_bar(Words& words, const Body& body) {
  constexpr double askew = 0.01;  // some half of a degree
  const auto [name, axis, length] = long_axis_of(body, askew);
  const double depth = body.tetrahedra.empty() ? 0 : needed_grip_depth(body, axis);
  add(words, "axis", name);
  add(words, "length", length_text(length));
  add(words, "grips",
      depth > 0 ? "  grip_depth: " + length_text(depth) +
                      "   # its ends are no planes: what lies so near to the furthest point is held\n"
                : "");
  add(words, "displacement", length_text(0.05 * length));
  add(words, "gauge", length_text(0.375 * length) + ", " + length_text(0.625 * length));
}

/// In quotes, as YAML reads it.
std::string in_quotes(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

/// What is body: lines of the scene.
std::string labels_text(const mesh::Image& image, const mesh::ImageValues& values) {
  constexpr std::size_t most = 20;
  if (!values.labels)
    return fmt::format(
        "    threshold: {:.3g}          # grey value from which on a voxel is body: Otsu's. Set it to yours\n",
        values.threshold);
  if (values.counts.size() > most)
    return fmt::format("    # {} labels: every value but 0 is body; `labels: [{:g}]` would be one of them alone\n",
                       values.counts.size(), values.counts.begin()->first);
  std::string text = "    labels:\n";
  std::set<std::string> names;
  for (const auto& [value, count] : values.counts) {
    const auto own = image.names.find(value);
    std::string name = own == image.names.end() ? fmt::format("label_{:g}", value) : own->second;
    if (!names.insert(name).second) name += fmt::format(" {:g}", value);
    text += fmt::format(
        "      {:g}: {{name: {}}}   # {} voxels; with `material: {{youngs_modulus: 20 kPa}}` stiffer than "
        "the others\n",
        value, own == image.names.end() ? name : in_quotes(name), count);
  }
  return text;
}

/// Voxels next to each other along x.
struct VoxelRun {
  int begin, end, y, z;
  int size() const { return end - begin; }
};

/// Of the largest piece of a body whose voxels share faces, as `pieces: largest` keeps it.
std::vector<VoxelRun> largest_piece(const mesh::Image& image, const mesh::ImageValues& values) {
  const int nx = image.size[0], ny = image.size[1], nz = image.size[2];
  std::vector<VoxelRun> runs;
  std::vector<std::size_t> rows{0};  // where the next one's begin
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y, rows.push_back(runs.size()))
      for (int x = 0; x < nx; ++x) {
        const double value = image.at(x, y, z);
        if (std::isnan(value) || !(values.labels ? value != 0 : value >= values.threshold)) continue;
        if (runs.size() > rows.back() && runs.back().end == x)
          ++runs.back().end;
        else
          runs.push_back({x, x + 1, y, z});
      }
  DisjointSets pieces(runs.size());
  const auto join_rows = [&](std::size_t row, std::size_t other) {
    for (std::size_t a = rows[row], b = rows[other]; a < rows[row + 1] && b < rows[other + 1];) {
      if (runs[a].begin < runs[b].end && runs[b].begin < runs[a].end)
        pieces.join(static_cast<int>(a), static_cast<int>(b));
      ++(runs[a].end < runs[b].end ? a : b);
    }
  };
  for (std::size_t row = 0; row + 1 < rows.size(); ++row) {
    if (row % static_cast<std::size_t>(ny) > 0) join_rows(row, row - 1);
    if (row >= static_cast<std::size_t>(ny)) join_rows(row, row - static_cast<std::size_t>(ny));
  }
  std::vector<std::int64_t> voxels(runs.size(), 0);
  for (std::size_t run = 0; run < runs.size(); ++run) voxels[pieces.set_of(static_cast<int>(run))] += runs[run].size();
  const auto largest = static_cast<int>(std::max_element(voxels.begin(), voxels.end()) - voxels.begin());
  std::vector<VoxelRun> own;
  for (std::size_t run = 0; run < runs.size(); ++run)
    if (pieces.set_of(static_cast<int>(run)) == largest) own.push_back(runs[run]);
  return own;
}

void add_scan(Words& words, const NewScene& wanted, const mesh::Image& image) {
  if (image.has_steps && !wanted.voxel_size.empty())
    throw InputError("--voxel-size: " + wanted.mesh + " states the size of its voxels itself");
  if (!image.has_steps && wanted.voxel_size.empty())
    throw InputError(wanted.mesh +
                     ": does not state the size of its voxels; give --voxel-size, such as '1 x 1 x 2 mm'");
  const double unit = parse_quantity("1 " + wanted.length_unit, dimension::length).value;
  Matrix3 steps = unit * image.steps;
  std::string voxel_size;
  if (!image.has_steps) {
    const Vector3 sides = sides_of(wanted.voxel_size, "--voxel-size");
    steps = image.steps * sides.asDiagonal();
    voxel_size = fmt::format("    voxel_size: [{}, {}, {}]\n", length_text(sides[0]), length_text(sides[1]),
                             length_text(sides[2]));
  }
  add(words, "voxel", voxel_size);
  const mesh::ImageValues values = mesh::values_of(image);
  constexpr double kSeen = 1e5, askew = 0.05;  // of a body that lies along the voxels, within some 3 degrees
  const std::vector<VoxelRun> runs = largest_piece(image, values);
  double voxels = 0;
  for (const VoxelRun& run : runs) voxels += run.size();
  if (voxels == 0) throw InputError(wanted.mesh + ": all its voxels are 0");
  std::vector<Vector3> places;
  const auto every = static_cast<std::int64_t>(voxels / kSeen) | 1;
  std::int64_t number = 0;
  for (const VoxelRun& run : runs)
    for (int x = run.begin; x < run.end; ++x)
      if (number++ % every == 0) places.emplace_back(steps * Vector3(x, run.y, run.z));
  Body body;
  body.rest = Eigen::Map<const Positions>(places.front().data(), 3, static_cast<Eigen::Index>(places.size()));
  const LongAxis along = long_axis_of(body, askew);
  const double length = along.length + (steps.transpose() * along.axis).cwiseAbs().maxCoeff(),
               voxel = std::abs(steps.determinant());
  add(words, "labels", labels_text(image, values));
  add(words, "axis", along.name);
  add(words, "length", length_text(length));
  const double spacing = std::cbrt(voxel * std::max(1., voxels / kMostNewMolecules));
  // A body whose boxes are filled in part has no one modulus to calibrate to.
  const bool filled = std::lround(spacing / steps.colwise().norm().minCoeff()) <= 1;
  add(words, "springs", filled ? "\"calibrated:patch\"" : "patch");
  add(words, "spacing", length_text(spacing));
  add(words, "grip", length_text(0.15 * length));
  add(words, "displacement", length_text(0.03 * length));
  add(words, "section", area_text(voxels * voxel / length));
}

void add_specimen(Words& words, const NewScene& wanted, bool from_file) {
  Body body;
  if (from_file) body = body_of(wanted);
  const Vector3 sides =
      from_file ? Vector3(body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()) : sides_of(wanted.size);
  const std::string name = wanted.specimen;
  const double least = sides.minCoeff();
  if (name == "strip") {
    int longest = 0;
    const double length = sides.maxCoeff(&longest);
    add_block(words, sides, 2);
    add(words, "axis", std::string(1, "xyz"[longest]));
    add(words, "displacement", length_text(0.15 * length));
  } else if (name == "dogbone") {
    add_bar(words, body);
  } else if (name == "indentation") {
    constexpr double slender = 3;
    if (sides[2] > slender * least)
      throw InputError("--size: a block of " + wanted.size +
                       " stands on its end and would bend aside under the sphere: write the longest length first, or a "
                       "height, which is the last, of at most three times the least width");
    add_graded_block(words, sides);
    add(words, "radius", length_text(least));
    add(words, "depth", length_text(0.1 * least));
  } else {
    const double spacing = std::cbrt(sides.prod() / kMostNewMolecules), depth = 0.1 * least,
                 contact = 1.7 * spacing;  // its radius: some nine molecules
    add(words, "spacing", length_text(spacing));
    add(words, "radius", length_text(std::max(0.2 * least, contact * contact / depth)));
    add(words, "depth", length_text(depth));
    add(words, "grip", length_text(0.1 * sides[2]));
  }
}

}  // namespace

const std::vector<NewSpecimen>& new_specimens() {
  static const std::vector<NewSpecimen> specimens = [] {
    std::vector<NewSpecimen> list;
    for (const Row& row : kRows) list.push_back(row.specimen);
    return list;
  }();
  return specimens;
}

namespace {

void check_modulus(const std::string& text) {
  try {
    if (const Quantity modulus = parse_quantity(text, dimension::pressure); modulus.has_unit && modulus.value > 0)
      return;
  } catch (const InputError&) {  // said below
  }
  throw InputError("--modulus: '" + text + "' is not a modulus above 0 with its unit, such as 20 kPa");
}

}  // namespace

std::string new_scene_text(const NewScene& given, const std::string& folder) {
  NewScene wanted = given;
  named(new_specimens(), wanted.specimen, "new: no specimen '" + wanted.specimen + "'");
  const auto row =
      std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return wanted.specimen == r.specimen.name; });
  check_modulus(wanted.modulus);
  if (!(wanted.poissons_ratio >= 0 && wanted.poissons_ratio < 0.5))
    throw InputError(fmt::format("--poissons-ratio: {} is not from 0 to below 0.5", wanted.poissons_ratio));
  std::optional<mesh::Image> image;
  if (wanted.specimen == "scan") image = mesh::load_image(wanted.mesh);
  if (wanted.length_unit.empty()) wanted.length_unit = image ? unit_name(image->unit) : "mm";
  Words words;
  const bool soft_volume = wanted.poissons_ratio > kLocking;
  add(words, "modulus", wanted.modulus);
  add(words, "nu", fmt::format("{:g}", wanted.poissons_ratio));
  add(words, "solid", soft_volume ? "neo_hookean+volume" : "neo_hookean");
  add(words, "volume", soft_volume ? ", neo_hookean+volume" : "");
  if (*row->springs) add(words, "springs", row->springs);
  add(words, "size", wanted.size);
  add(words, "unit", wanted.length_unit);
  if (row->specimen.from_file())
    add(words, "mesh", std::filesystem::proximate(wanted.mesh, folder.empty() ? "." : folder).string());
  if (image)
    add_scan(words, wanted, *image);
  else
    add_specimen(words, wanted, row->specimen.from_file());
  const std::string material = fmt::vformat(kMaterial, words);
  add(words, "material", material);
  return fmt::vformat(row->text, words);
}

}  // namespace elastin::lab
