#include "elastin/mesh/mesh_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/shell_word.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/geometry/numbering.h"
#include "mesh/mesh_formats.h"
#include "mesh/surface_repair.h"

namespace elastin::mesh {
namespace format {
namespace {

constexpr double flat = 1e-12;  // of the longest side cubed (tetrahedra) or squared (triangles), as in inspect(Body)

double longest_side(std::span<const Vector3> corners) {
  double longest = 0;
  for (std::size_t a = 0; a < corners.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) longest = std::max(longest, (corners[a] - corners[b]).norm());
  return longest;
}

/// Marks the points of the cells: 0 = used, −1 = not.
template <std::size_t corners>
void mark_used(const std::vector<std::array<int, corners>>& cells, std::vector<int>& points) {
  for (const auto& cell : cells)
    for (const int corner : cell) points[corner] = 0;
}

template <std::size_t corners>
void renumber(const std::vector<int>& new_number, std::vector<std::array<int, corners>>& cells) {
  for (auto& cell : cells)
    for (int& corner : cell) corner = new_number[corner];
}

/// Calls `visit` with the corners of each cell, numbers of points.
template <class Visit>
void for_each_cell(const Mesh& mesh, const Visit& visit) {
  for (const auto& cell : mesh.tetrahedra) visit(std::span<const int>(cell));
  for (const auto& cell : mesh.triangles) visit(std::span<const int>(cell));
  for (const CellBlock& block : mesh.blocks)
    for (int cell = 0; cell < block.size(); ++cell) visit(block.cell(cell));
}

/// How far apart the numbers of a cell's molecules are, on average.
double mean_span(const Mesh& mesh, const std::vector<int>& number) {
  double sum = 0, cells = 0;
  for_each_cell(mesh, [&](std::span<const int> cell) {
    int least = std::numeric_limits<int>::max(), most = 0;
    for (const int corner : cell) {
      least = std::min(least, number[corner]);
      most = std::max(most, number[corner]);
    }
    sum += most - least, ++cells;
  });
  return sum / cells;
}

/// Numbers the molecules, and puts the cells, in the order of a curve that fills space, if the file's order is much
/// worse for the memory. @param number of each point, −1 of those that no cell has
void number_in_space(const std::vector<Vector3>& points, Mesh& mesh, std::vector<int>& number, int used) {
  constexpr double much = 3;
  constexpr int fits_caches = 10000;
  if (used < fits_caches) return;
  Positions positions(3, used);
  for (std::size_t point = 0; point < points.size(); ++point)
    if (number[point] >= 0) positions.col(number[point]) = points[point];
  const std::vector<int> order = order_in_space(positions);
  std::vector<int> rank(order.size()), along = number;
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<int>(i);
  for (int& own : along)
    if (own >= 0) own = rank[own];
  if (!(mean_span(mesh, number) > much * mean_span(mesh, along))) return;
  number = std::move(along);
  const auto lowest = [&](const auto& cell) {
    int least = std::numeric_limits<int>::max();
    for (const int corner : cell) least = std::min(least, number[corner]);
    return least;
  };
  const auto by_lowest = [&](const auto& a, const auto& b) { return lowest(a) < lowest(b); };
  std::stable_sort(mesh.tetrahedra.begin(), mesh.tetrahedra.end(), by_lowest);
  std::stable_sort(mesh.triangles.begin(), mesh.triangles.end(), by_lowest);
  for (CellBlock& block : mesh.blocks) {
    std::vector<int> cells(block.size()), nodes;
    std::iota(cells.begin(), cells.end(), 0);
    std::stable_sort(cells.begin(), cells.end(), [&](int a, int b) { return by_lowest(block.cell(a), block.cell(b)); });
    for (const int cell : cells) nodes.insert(nodes.end(), block.cell(cell).begin(), block.cell(cell).end());
    block.nodes = std::move(nodes);
  }
}

template <std::size_t corners>
void add_as_block(const char* name, const std::vector<std::array<int, corners>>& cells,
                  std::vector<CellBlock>& blocks) {
  if (cells.empty()) return;
  CellBlock block{&cell_kind(name), {}, {}};
  for (const auto& cell : cells) block.nodes.insert(block.nodes.end(), cell.begin(), cell.end());
  blocks.push_back(std::move(block));
}

/// Marks the cells whose nodes a cell before has too; of triangles only those that look the same way.
template <class CellAt>
std::vector<char> copies_among(int count, const CellAt& cell_at) {
  std::vector<int> own, other;
  const auto read = [&](int cell, std::vector<int>& nodes) {
    const std::span<const int> from = cell_at(cell);
    nodes.assign(from.begin(), from.end());
    if (nodes.size() == 3)
      std::rotate(nodes.begin(), std::min_element(nodes.begin(), nodes.end()), nodes.end());
    else
      std::sort(nodes.begin(), nodes.end());
  };
  std::vector<std::pair<std::uint64_t, int>> order;
  for (int cell = 0; cell < count; ++cell) {
    read(cell, own);
    std::uint64_t hash = 0;
    for (const int node : own) hash = (hash ^ static_cast<std::uint64_t>(node)) * 0x9e3779b97f4a7c15 ^ hash >> 29;
    order.emplace_back(hash, cell);
  }
  std::sort(order.begin(), order.end());
  std::vector<char> copies(count, 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || order[i].first != order[i - 1].first) continue;
    read(order[i].second, own);
    for (std::size_t before = i; before-- > 0 && order[before].first == order[i].first;) {
      read(order[before].second, other);
      if (own == other) copies[order[i].second] = 1;
    }
  }
  return copies;
}

/// Gmsh writes a cell once for each physical group that it is in. Returns how many were dropped.
template <std::size_t corners>
std::size_t drop_copies(std::vector<std::array<int, corners>>& cells) {
  const std::vector<char> copies =
      copies_among(static_cast<int>(cells.size()), [&](int cell) { return std::span<const int>(cells[cell]); });
  std::size_t number = 0;
  return std::erase_if(cells, [&](const auto&) { return copies[number++] != 0; });
}

std::size_t drop_copies(CellBlock& block) {
  const std::vector<char> copies = copies_among(block.size(), [&](int cell) { return block.cell(cell); });
  std::vector<int> nodes;
  for (int cell = 0; cell < block.size(); ++cell)
    if (!copies[cell]) nodes.insert(nodes.end(), block.cell(cell).begin(), block.cell(cell).end());
  block.nodes = std::move(nodes);
  return std::count(copies.begin(), copies.end(), 1);
}

}  // namespace

const CellType& find_cell_type(std::span<const CellType> types, long long code, std::size_t points) {
  static const CellType unknown{-1, CellUse::refused, 0, "cell of unknown type"};
  const CellType* found = &unknown;
  for (const CellType& type : types)
    if (type.code == code && (found == &unknown || static_cast<std::size_t>(type.points) == points)) found = &type;
  return *found;
}

std::string refusal(const CellType& type, long long code) {
  return std::string(" is a ") + type.name + " (type " + std::to_string(code) +
         "); allowed: triangles of 3 and 6 points, tetrahedra of 4 and 10, prisms of 6, hexahedra of 8, 20 and 27" +
         (type.use == CellUse::face ? "; this one only next to such cells of a solid" : "");
}

int dimension_of(const CellType& type) {
  if (type.use == CellUse::cell) return cell_kind(type.shape).dimensions;
  static constexpr int dimensions[] = {0, 1, 2, 2, 3, 3, 0};
  return dimensions[static_cast<std::size_t>(type.use)];
}

double reach_of_place(const std::vector<Vector3>& corners, const std::vector<char>& used) {
  constexpr double same = 1e-6;  // of the surface's extent
  constexpr double far = std::numeric_limits<double>::infinity();
  Vector3 low = Vector3::Constant(far), high = -low;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (used.empty() || used[i]) low = low.cwiseMin(corners[i]), high = high.cwiseMax(corners[i]);
  return std::max(same * (high - low).maxCoeff(), 0.);
}

int MeshBuilder::point_at(const Vector3& position, double within) {
  // Boxes that are a thousand times as wide as what is one place.
  const double width = within > 0 ? 1e3 * within : std::numeric_limits<double>::infinity();
  const auto box_of = [&](double slack) -> std::array<long, 3> {
    const Vector3 at = ((position.array() + slack) / width).floor();
    return {static_cast<long>(at.x()), static_cast<long>(at.y()), static_cast<long>(at.z())};
  };
  const std::array<long, 3> low = box_of(-within), high = box_of(within);
  for (long x = low[0]; x <= high[0]; ++x)
    for (long y = low[1]; y <= high[1]; ++y)
      for (long z = low[2]; z <= high[2]; ++z)
        if (const auto box = boxes_.find({x, y, z}); box != boxes_.end())
          for (const int point : box->second)
            if ((points_[point] - position).norm() <= within) return point;
  boxes_[box_of(0)].push_back(point_count());
  add_point(position);
  return point_count() - 1;
}

std::string MeshBuilder::add_cell(const CellType& type, std::span<const int> points) {
  Vector3 middle = Vector3::Zero();
  for (const int point : points) middle += points_[point] / static_cast<double>(points.size());
  double radius = 0;
  for (const int point : points) radius = std::max(radius, (points_[point] - middle).norm());
  places_.push_back({middle, radius, dimension_of(type)});
  switch (type.use) {
    case CellUse::tetrahedron:
      return add_tetrahedron({points[0], points[1], points[2], points[3]});
    case CellUse::triangle:
      return add_triangle({points[0], points[1], points[2]});
    case CellUse::cell:
      return add_block_cell(type, points);
    case CellUse::point:
    case CellUse::line:
    case CellUse::face:
      leave_out(type.use == CellUse::line ? "line" : type.use == CellUse::face ? "quadrangle" : type.name);
      return "";
    case CellUse::refused:
      break;
  }
  return " is not used";
}

/// The numbers of a cell's nodes when it is seen in a mirror: ξ and η change places.
std::vector<std::size_t> mirrored(const CellKind& kind) {
  std::vector<std::size_t> order;
  for (int a = 0; a < kind.nodes; ++a) {
    VectorX place = kind.reference.col(a);
    std::swap(place[0], place[1]);
    for (int b = 0; b < kind.nodes; ++b)
      if ((kind.reference.col(b) - place).norm() < 1e-9) order.push_back(b);
  }
  return order;
}

std::string MeshBuilder::add_block_cell(const CellType& type, std::span<const int> points) {
  const CellKind& kind = cell_kind(type.shape);
  std::vector<int> nodes(points.begin(), points.end());
  for (std::size_t a = 0; a < type.order.size(); ++a) nodes[a] = points[type.order[a]];
  Eigen::MatrixXd x(3, kind.nodes);
  for (int a = 0; a < kind.nodes; ++a) x.col(a) = points_[nodes[a]];
  double longest = 0, least = std::numeric_limits<double>::infinity(), most = -least;
  for (const auto& [a, b] : kind.edges) longest = std::max(longest, (x.col(a) - x.col(b)).norm());
  for (const auto& slopes : kind.slopes) {
    const Eigen::MatrixXd edges = x * slopes.transpose();
    const Vector3 first = edges.col(0), second = edges.col(1), normal = first.cross(second);
    const double measure = kind.dimensions == 2 ? normal.norm() : normal.dot(Vector3(edges.col(2)));
    least = std::min(least, measure), most = std::max(most, measure);
  }
  if (most < 0) {
    std::vector<int> turned;
    for (const std::size_t a : mirrored(kind)) turned.push_back(nodes[a]);
    nodes = std::move(turned);
    std::swap(least = -least, most = -most);
    ++reoriented_;
  }
  auto block = std::find_if(blocks_.begin(), blocks_.end(), [&](const CellBlock& own) { return own.kind == &kind; });
  if (block == blocks_.end()) block = blocks_.insert(block, CellBlock{&kind, {}, {}});
  block->nodes.insert(block->nodes.end(), nodes.begin(), nodes.end());
  if (least > flat * std::pow(longest, kind.dimensions)) return "";
  return std::string(" is a flat or folded ") + std::string(kind.name) +
         ": it has no volume at one of the points where it is integrated; remove it, or mesh again";
}

std::string MeshBuilder::add_triangle(const std::array<int, 3>& corners) {
  std::array<Vector3, 3> x;
  for (std::size_t corner = 0; corner < 3; ++corner) x[corner] = points_[corners[corner]];
  const double area = (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2;
  const double longest = longest_side(x);
  triangles_.push_back(corners);
  if (surface_ || area > flat * longest * longest) return "";
  return " is a flat triangle: its area " + number(area, 3) + " is not above 1e-12 of its longest side (" +
         number(longest, 3) + ") squared; remove it, or mesh again";
}

std::string MeshBuilder::add_polygon(std::span<const int> corners) {
  if (corners.size() < 3) {
    leave_out(corners.size() == 2 ? "line" : "point");
    return "";
  }
  constexpr std::size_t many = 1000;  // corners, for which the search for ears takes too long
  std::vector<int> left(corners.begin(), corners.end());
  Vector3 normal = Vector3::Zero();
  for (std::size_t k = 2; k < left.size(); ++k)
    normal += (points_[left[k - 1]] - points_[left[0]]).cross(points_[left[k]] - points_[left[0]]);
  const auto turn = [&](int a, int b, int c) {
    return (points_[b] - points_[a]).cross(points_[c] - points_[a]).dot(normal);
  };
  std::string problem;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    const auto at = [&](std::size_t k) { return left[k % n]; };
    const auto is_ear = [&](std::size_t k) {
      const int a = at(k - 1), b = at(k), c = at(k + 1);
      return turn(a, b, c) > 0 && std::none_of(left.begin(), left.end(), [&](int p) {
               return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
             });
    };
    std::size_t ear = 1;
    while (n <= many && ear <= n && !is_ear(ear)) ++ear;
    if (ear > n) ear = 1;
    problem += add_triangle({at(ear - 1), at(ear), at(ear + 1)});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear % n));
  }
  return problem + add_triangle({left[0], left[1], left[2]});
}

std::string MeshBuilder::add_tetrahedron(std::array<int, 4> corners) {
  Positions positions(3, 4);
  std::array<Vector3, 4> x;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    x[corner] = points_[corners[corner]];
    positions.col(static_cast<Eigen::Index>(corner)) = x[corner];
  }
  const double volume = signed_volume(positions, {0, 1, 2, 3});
  const double longest = longest_side(x);
  if (volume < 0) {
    std::swap(corners[2], corners[3]);
    ++reoriented_;
  }
  tetrahedra_.push_back(corners);
  if (std::abs(volume) > flat * longest * longest * longest) return "";
  return " is a flat tetrahedron: its volume " + number(std::abs(volume), 3) +
         " is not above 1e-12 of its longest side (" + number(longest, 3) + ") cubed; remove it, or mesh again";
}

void MeshBuilder::add_data(int cell, std::span<const double> values) {
  with_data_.push_back(cell);
  data_.insert(data_.end(), values.begin(), values.end());
}

CellData MeshBuilder::finish_data(const std::string& path) const {
  const SourceLocation location{path, 0, 0};
  const std::string name = wanted_.value_or("");
  if (data_names_.empty()) throw InputError(location, "has no data of its cells");
  if (!data_names_.contains(name))
    throw InputError(location, "has no data " + quoted(name) + " of its cells" +
                                   suggestion(name, {data_names_.begin(), data_names_.end()}));
  int dimensions = 0;
  for (const int cell : with_data_) dimensions = std::max(dimensions, places_[cell].dimensions);
  if (dimensions < 2) throw InputError(location, "has data " + quoted(name) + ", but not of tetrahedra or triangles");
  const auto components = static_cast<Eigen::Index>(data_.size() / with_data_.size());
  const Eigen::Map<const Eigen::MatrixXd> all(data_.data(), components, static_cast<Eigen::Index>(with_data_.size()));
  std::vector<int> rows, cells;
  for (std::size_t row = 0; row < with_data_.size(); ++row)
    if (places_[with_data_[row]].dimensions == dimensions)
      rows.push_back(static_cast<int>(row)), cells.push_back(with_data_[row]);
  CellData data{Positions(3, rows.size()), all(Eigen::all, rows)};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    data.middles.col(static_cast<Eigen::Index>(i)) = places_[cells[i]].middle;
    data.largest_radius = std::max(data.largest_radius, places_[cells[i]].radius);
  }
  return data;
}

void read_data(Cursor& in, NumberType type, std::size_t components, int first_cell, std::size_t cells,
               MeshBuilder& mesh) {
  in.require_numbers(components * cells, "values of cells", type);
  std::vector<double> values(components);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    for (double& value : values)
      value = type.kind == NumberType::real || !in.binary() ? in.real("a cell's value", type)
                                                            : static_cast<double>(in.integer("a cell's value", type));
    mesh.add_data(first_cell + static_cast<int>(cell), values);
  }
}

/// The triangles and tetrahedra of a mesh that has all of its cells in blocks: cells with points in common are cut
/// alike.
void cut_into_simplices(Mesh& mesh) {
  if (mesh.blocks.empty()) return;
  Body simplices;
  simplices.rest = mesh.points, simplices.blocks = mesh.blocks;
  set_simplices(simplices);
  mesh.triangles = std::move(simplices.triangles), mesh.tetrahedra = std::move(simplices.tetrahedra);
}

Mesh MeshBuilder::finish(const std::string& path) const {
  const auto of = [](int dimensions) {
    return [dimensions](const CellBlock& block) { return block.kind->dimensions == dimensions; };
  };
  const bool solid = !tetrahedra_.empty() || std::any_of(blocks_.begin(), blocks_.end(), of(3));
  if (!solid && without_solid_) throw *without_solid_;
  if (tetrahedra_.empty() && triangles_.empty() && blocks_.empty()) {
    std::vector<std::string> found;
    for (const auto& [what, count] : left_out_)
      if (count > 0) found.push_back(counted(static_cast<std::ptrdiff_t>(count), what));
    if (found.empty()) found.push_back(counted(point_count(), "point"));
    throw InputError(
        SourceLocation{path, 0, 0},
        std::string("no triangles") + (surface_ ? "" : " and no cells of a solid") + "; it has " + listed(found));
  }
  Mesh mesh;
  std::copy_if(blocks_.begin(), blocks_.end(), std::back_inserter(mesh.blocks), of(solid ? 3 : 2));
  if (solid)
    mesh.tetrahedra = tetrahedra_;
  else
    mesh.triangles = triangles_;
  if (surface_) mesh.repairs = drop_flat_triangles(points_, mesh.triangles);
  std::size_t copies = drop_copies(mesh.tetrahedra) + (surface_ ? 0 : drop_copies(mesh.triangles));
  for (CellBlock& block : mesh.blocks) copies += drop_copies(block);
  if (copies > 0)
    mesh.repairs.push_back(counted(static_cast<std::ptrdiff_t>(copies), "cell") + " that stood twice dropped");
  if (surface_ && mesh.triangles.empty())
    throw InputError(SourceLocation{path, 0, 0}, "all of its triangles are without area");
  if (!mesh.blocks.empty()) {  // then they have all cells
    add_as_block("tetrahedron4", mesh.tetrahedra, mesh.blocks);
    add_as_block("triangle3", mesh.triangles, mesh.blocks);
    mesh.tetrahedra.clear(), mesh.triangles.clear();
  }

  std::vector<int> new_number(points_.size(), -1);
  mark_used(mesh.tetrahedra, new_number);
  mark_used(mesh.triangles, new_number);
  for (const CellBlock& block : mesh.blocks)
    for (const int node : block.nodes) new_number[node] = 0;
  int used = 0;
  for (int& molecule : new_number)
    if (molecule == 0) molecule = used++;
  number_in_space(points_, mesh, new_number, used);
  renumber(new_number, mesh.tetrahedra);
  renumber(new_number, mesh.triangles);
  for (CellBlock& block : mesh.blocks)
    for (int& node : block.nodes) node = new_number[node];
  mesh.points.resize(3, used);
  for (std::size_t point = 0; point < points_.size(); ++point)
    if (new_number[point] >= 0) mesh.points.col(new_number[point]) = points_[point];

  for (const auto& [name, points] : sets_)
    for (const int point : points)
      if (const int own = new_number[point]; own >= 0) mesh.sets[name].push_back(own);
  for (auto& [name, points] : mesh.sets) std::sort(points.begin(), points.end());

  std::map<std::string, std::size_t> left_out = left_out_;
  const auto also = [&](const char* what, std::size_t count) {
    if (count > 0) left_out[what] += count;
  };
  also("unused point", points_.size() - used);
  if (solid) also("triangle", triangles_.size());
  for (const CellBlock& block : blocks_)
    if (solid && block.kind->dimensions == 2) also("triangle", block.size());
  cut_into_simplices(mesh);
  std::vector<std::string> parts;
  for (const auto& [what, count] : left_out)
    parts.push_back(count == 0 ? what : counted(static_cast<std::ptrdiff_t>(count), what));
  mesh.comment = parts.empty() ? "" : listed(parts) + " left out";
  mesh.reoriented = reoriented_;
  return mesh;
}

// The readers, each next to its format.
using ReadMesh = void(Cursor in, MeshBuilder& mesh);
ReadMesh read_gmsh, read_vtk, read_inp, read_bdf, read_unv, read_stl, read_obj, read_off, read_ply;

namespace {

struct KnownFormat : MeshFormat {
  ReadMesh* read;
};

const KnownFormat kFormats[] = {{{".msh", "1, 2 and 4.1", MeshContent::cells_with_data}, read_gmsh},
                                {{".vtk", "", MeshContent::cells_with_data}, read_vtk},
                                {{".vtu", "", MeshContent::cells_with_data}, read_vtu},
                                {{".inp", "", MeshContent::cells}, read_inp},
                                {{".bdf", "", MeshContent::cells}, read_bdf},
                                {{".nas", "", MeshContent::cells}, read_bdf},
                                {{".fem", "", MeshContent::cells}, read_bdf},
                                {{".unv", "", MeshContent::cells}, read_unv},
                                {{".stl", "", MeshContent::surface}, read_stl},
                                {{".obj", "", MeshContent::surface}, read_obj},
                                {{".off", "", MeshContent::surface}, read_off},
                                {{".ply", "", MeshContent::surface}, read_ply}};

/// Files that are not read, by the command that converts them: < is the file, > the converted one. Gmsh and meshio are
/// free programs.
struct Converter {
  std::vector<std::string_view> endings;
  std::string_view command, to;
};
const Converter kConverters[] = {
    {{".xdmf", ".xmf", ".e", ".exo", ".xml", ".node", ".ele"}, "meshio convert < >", ".vtu"},
    {{".med", ".cgns", ".mesh"}, "gmsh -save -o > <", ".msh"},
    {{".geo", ".step", ".stp", ".brep"}, "gmsh -3 -o > <", ".msh"},
    {{".feb"}, "elastin export < --to gmsh --out >", ".msh"}};

/// Of other kinds of files: no slips of the endings that are read.
constexpr std::string_view kOthers[] = {".3mf", ".cdb", ".csv", ".diff", ".iges", ".igs",
                                        ".k",   ".key", ".pcd", ".txt",  ".xyz"};

/// With its dot, in small letters; "" where the name has none.
std::string ending_of(const std::string& path) {
  const std::string name = path.substr(path.find_last_of('/') + 1);
  std::string ending = name.find('.') == std::string::npos ? "" : name.substr(name.rfind('.'));
  for (char& letter : ending) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return ending;
}

const KnownFormat& format_of(const std::string& path) {
  const std::string ending = ending_of(path);
  std::vector<std::string> allowed;
  for (const KnownFormat& format : kFormats) {
    if (ending == format.ending) return format;
    allowed.push_back(format.ending);
  }
  for (const Converter& by : kConverters) {
    if (std::find(by.endings.begin(), by.endings.end(), ending) == by.endings.end()) continue;
    std::string command;
    for (const char letter : by.command)
      command += letter == '<'   ? shell_word(path)
                 : letter == '>' ? shell_word(path.substr(0, path.size() - ending.size()) + std::string(by.to))
                                 : std::string(1, letter);
    throw InputError(SourceLocation{path, 0, 0}, ending + " files are not read; convert it: " + command);
  }
  for (const char* image : {".nii", ".gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm", ".ima", ".tif", ".tiff"})
    if (ending == image)
      throw InputError(SourceLocation{path, 0, 0}, "is an image, no mesh: give it as `body: {image: …}`");
  const bool other = std::find(std::begin(kOthers), std::end(kOthers), ending) != std::end(kOthers);
  throw InputError(SourceLocation{path, 0, 0},
                   "unknown ending " + quoted(ending) + suggestion(other ? "" : ending, allowed));
}

}  // namespace

Mesh read_mesh(const File& file) {
  const KnownFormat& format = format_of(file.path);
  MeshBuilder mesh(format.content == MeshContent::surface);
  format.read(Cursor(file), mesh);
  return mesh.finish(file.path);
}

}  // namespace format

bool is_mesh_file(const std::string& path) {
  const std::string ending = format::ending_of(path);
  return std::any_of(std::begin(format::kFormats), std::end(format::kFormats),
                     [&](const MeshFormat& known) { return ending == known.ending; });
}

std::vector<MeshFormat> mesh_formats() { return {std::begin(format::kFormats), std::end(format::kFormats)}; }

Mesh load_mesh(const std::string& path) {
  format::format_of(path);  // an unknown ending is reported first, whether the file exists or not
  return format::read_mesh(format::load_file(path));
}

int join_points(Mesh& mesh, double distance) {
  std::vector<int> first(mesh.points.cols());
  std::iota(first.begin(), first.end(), 0);
  for (const auto& [a, b] : connections_within(mesh.points, distance).ends) {
    int low = a, high = b;
    while (first[low] != low) low = first[low];
    while (first[high] != high) high = first[high];
    first[std::max(low, high)] = std::min(low, high);
  }
  int kept = 0;
  for (std::size_t point = 0; point < first.size(); ++point)
    if (first[point] == static_cast<int>(point)) {
      mesh.points.col(kept) = mesh.points.col(static_cast<Eigen::Index>(point));
      first[point] = kept++;
    } else {
      first[point] = first[first[point]];  // a lower one, which has its new number
    }
  const int taken = static_cast<int>(first.size()) - kept;
  mesh.points.conservativeResize(3, kept);
  format::renumber(first, mesh.tetrahedra);
  format::renumber(first, mesh.triangles);
  for (CellBlock& block : mesh.blocks)
    for (int& node : block.nodes) node = first[node];
  format::for_each_cell(mesh, [&](std::span<const int> cell) {
    std::vector<int> corners(cell.begin(), cell.end());
    std::sort(corners.begin(), corners.end());
    if (std::adjacent_find(corners.begin(), corners.end()) != corners.end())
      throw InputError("two corners of a cell lie within that distance; give a smaller one");
  });
  format::cut_into_simplices(mesh);
  for (auto& [name, points] : mesh.sets) {
    for (int& point : points) point = first[point];
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
  }
  return taken;
}

CellData load_cell_data(const std::string& path, const std::string& name) {
  const format::KnownFormat& known = format::format_of(path);
  if (known.content != MeshContent::cells_with_data) {
    std::vector<std::string> endings;
    for (const MeshFormat& other : format::kFormats)
      if (other.content == MeshContent::cells_with_data) endings.push_back(other.ending);
    throw InputError(SourceLocation{path, 0, 0}, "data of cells are read from " + listed(endings));
  }
  const format::File file = format::load_file(path);
  format::MeshBuilder mesh;
  mesh.want_data(name);
  known.read(format::Cursor(file), mesh);
  return mesh.finish_data(path);
}

}  // namespace elastin::mesh
