#include <cmath>
#include <map>
#include <numbers>

#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// The bulk data of Nastran: MSC Nastran quick reference guide, "Format of bulk data entries". Where a cell of second
// order has its middles in another order than VTK, `order` says so.
constexpr int kNastranHexahedron20[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15};
struct BdfCell {
  std::string_view name;
  std::size_t corners, all;  ///< nodes without and with those of second order
  CellType first, second;
};
const BdfCell bdf_cells[] = {
    {"CTETRA", 4, 10, {0, CellUse::tetrahedron, 4, "CTETRA"}, {0, CellUse::cell, 10, "CTETRA", "tetrahedron10"}},
    {"CHEXA",
     8,
     20,
     {0, CellUse::cell, 8, "CHEXA", "hexahedron8"},
     {0, CellUse::cell, 20, "CHEXA", "hexahedron20", kNastranHexahedron20}},
    {"CPENTA", 6, 15, {0, CellUse::cell, 6, "CPENTA", "prism6"}, {0, CellUse::refused, 15, "CPENTA"}},
    {"CTRIA3", 3, 3, {0, CellUse::triangle, 3, "CTRIA3"}, {0, CellUse::triangle, 3, "CTRIA3"}},
    {"CTRIA6", 3, 6, {0, CellUse::triangle, 3, "CTRIA6"}, {0, CellUse::cell, 6, "CTRIA6", "triangle6"}},
    {"CTRIAR", 3, 3, {0, CellUse::triangle, 3, "CTRIAR"}, {0, CellUse::triangle, 3, "CTRIAR"}},
    {"CQUAD4", 4, 4, {0, CellUse::face, 4, "CQUAD4"}, {0, CellUse::face, 4, "CQUAD4"}},
    {"CQUADR", 4, 4, {0, CellUse::face, 4, "CQUADR"}, {0, CellUse::face, 4, "CQUADR"}},
    {"CQUAD8", 4, 8, {0, CellUse::face, 4, "CQUAD8"}, {0, CellUse::face, 8, "CQUAD8"}},
};
/// What begins with these letters stands next to the cells: bars, springs, masses, couplings, panels of shear, faces
/// that take heat.
constexpr std::string_view kLeftOut[] = {"CBAR",   "CBEAM", "CBEND", "CBUSH", "CDAMP",  "CELAS", "CFAST",
                                         "CGAP",   "CHBDY", "CMASS", "CONM",  "CONROD", "CROD",  "CSEAM",
                                         "CSHEAR", "CTUBE", "CVISC", "CWELD", "MPC",    "RB",    "RROD"};
/// What begins with these letters names nodes as elements do, and is none.
constexpr std::string_view kNoElements[] = {"CAERO", "CONCT", "CONV", "CSET", "CSUP", "CYAX", "CYJOIN", "CYSUP"};

/// One entry: its name and the fields behind it, with those of the lines that continue it.
struct Entry {
  std::string name;
  std::string_view at;  ///< where it stands
  std::vector<std::string_view> fields;
};

class BdfReader {
 public:
  BdfReader(const Cursor& in, MeshBuilder& mesh) : mesh_(mesh), sources_(in) {
    bulk_ = upper_case(in.data()).find("BEGIN BULK") == std::string::npos;
    read_lines(in);
    end_entry();
    // Nodes may stand before their coordinate systems, and cells before their nodes.
    for (const Entry& entry : grid_) add_node(entry);
    for (const Entry& entry : others_) refuse_element(entry);
    for (const Entry& entry : cells_) add_cell(entry);
  }

 private:
  void read_lines(Cursor in) {
    while (in.left() > 0 && !ended_) {
      std::string_view line = in.line();
      line = line.substr(0, line.find('$'));
      const std::string_view text = trimmed(line);
      const std::string word = upper_case(text.substr(0, 10));
      if (word.starts_with("BEGIN BULK")) {
        bulk_ = true;
      } else if (word.starts_with("INCLUDE")) {
        std::string_view name = trimmed(text.substr(7));
        if (name.size() > 1 && (name.front() == '\'' || name.front() == '"') && name.back() == name.front())
          name = name.substr(1, name.size() - 2);
        read_lines(sources_.include(name));
      } else if (word.starts_with("ENDDATA")) {
        ended_ = true;
      } else if (bulk_ && !text.empty()) {
        add_line(line);
      }
    }
  }

  [[noreturn]] void fail(std::string_view at, const std::string& message) const { sources_.fail(at, message); }

  /// The name and 8 fields of a line, or 4 behind a *: between commas, or in columns of 8, of which the middle ones are
  /// 16 wide behind a *; a tab goes on to the next multiple of 8.
  static std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    if (line.find(',') != std::string_view::npos) {
      fields = comma_fields(line);
      const std::size_t most = fields[0].find('*') == std::string_view::npos ? 9 : 5;  // behind them: a continuation
      if (fields.size() > most) fields.resize(most);
      return fields;
    }
    const bool wide = line.substr(0, 8).find('*') != std::string_view::npos;
    std::size_t from = 0, edge = 8, column = 0;
    const auto end_field = [&](std::size_t to) {
      fields.push_back(trimmed(line.substr(from, to - from)));
      from = to, edge += wide ? 16 : 8;
    };
    for (std::size_t at = 0; at < line.size() && column < 72; ++at) {
      while (column >= edge) end_field(at);
      column += line[at] == '\t' ? 8 - column % 8 : 1;
      if (column >= 72) end_field(at + 1);
    }
    if (column < 72) end_field(line.size());
    return fields;
  }

  void add_line(std::string_view line) {
    const auto fields = fields_of(line);
    std::string_view name = fields.empty() ? "" : fields.front();
    const bool goes_on = name.empty() || name.front() == '+' || name.front() == '*';
    if (!goes_on) {
      end_entry();
      if (name.ends_with('*')) name.remove_suffix(1);
      entry_.at = name;
      entry_.name = upper_case(trimmed(name));
    } else if (entry_.name.empty()) {
      return;
    }
    entry_.fields.insert(entry_.fields.end(), fields.begin() + 1, fields.end());
  }

  void end_entry() {
    Entry entry = std::move(entry_);
    entry_ = {};
    if (entry.name == "GRID") return grid_.push_back(std::move(entry));
    if (entry.name.starts_with("CORD")) return add_system(entry);
    if (entry.name == "GRDSET") {
      if (entry.fields.size() > 1) usual_system_ = entry.fields[1];
      return;
    }
    for (const BdfCell& cell : bdf_cells)
      if (entry.name == cell.name) return cells_.push_back(std::move(entry));
    for (const std::string_view left_out : kLeftOut)
      if (entry.name.starts_with(left_out)) return mesh_.leave_out(entry.name);
    for (const std::string_view none : kNoElements)
      if (entry.name.starts_with(none)) return;
    if (entry.name.starts_with('C')) others_.push_back(std::move(entry));
  }

  /// What has a number, a property and three nodes or more is an element: programs have many of their own.
  void refuse_element(const Entry& entry) const {
    std::size_t nodes = 0;
    for (std::size_t i = 2; i < entry.fields.size() && !entry.fields[i].empty(); ++i) {
      const auto node = whole_number(entry.fields[i]);
      if (!node || !nodes_.contains(*node)) break;
      ++nodes;
    }
    if (nodes >= 3 && whole_number(entry.fields[0]))
      fail(entry.at, entry.name + " is not used; allowed: CTETRA, CHEXA, CPENTA, CTRIA3, CTRIA6");
  }

  long long whole(std::string_view field, const char* what) const {
    if (const auto value = whole_number(field)) return *value;
    fail(field, std::string("expected ") + what + ", found " + quoted(field));
  }

  /// "1.5", "1.5E-3", "1.5D-3" or, as Nastran alone writes, "1.5-3". An empty field is 0.
  double real(std::string_view field) const {
    if (field.empty()) return 0;
    if (const auto value = fortran_real(field)) return *value;
    fail(field, "expected a coordinate, a finite number, found " + quoted(field));
  }

  /// A coordinate system by three points: its origin, one on its z axis, one in its plane of x and z.
  struct System {
    Entry entry;
    Matrix3 axes = Matrix3::Zero();  ///< columns; 0: not known yet
    Vector3 origin = Vector3::Zero();
  };

  void add_system(const Entry& entry) {
    const bool known = entry.name == "CORD2R" || entry.name == "CORD2C" || entry.name == "CORD2S";
    if (!known) fail(entry.at, entry.name + " is not read; allowed: CORD2R, CORD2C, CORD2S");
    if (entry.fields.size() < 9) fail(entry.at, entry.name + ": expected a number, a system and three points");
    systems_[whole(entry.fields[0], "a system's number")].entry = entry;
  }

  Vector3 numbers(const Entry& entry, std::size_t from) const {
    Vector3 values = Vector3::Zero();
    for (std::size_t k = 0; k < 3 && k + from < entry.fields.size(); ++k)
      values[static_cast<Eigen::Index>(k)] = real(entry.fields[k + from]);
    return values;
  }

  /// The place of coordinates of a system: x, y, z, or R, θ [°], z, or R, θ from the z axis, φ about it.
  Vector3 place_of(std::string_view system, const Vector3& at, int depth = 0) {
    if (system.empty() || system == "0") return at;
    const auto found = systems_.find(whole(system, "a coordinate system's number"));
    if (found == systems_.end()) fail(system, "there is no coordinate system " + quoted(system));
    System& own = found->second;
    const Entry& entry = own.entry;
    if (own.axes.isZero(0)) {
      if (depth > 100) fail(entry.at, "coordinate systems refer to each other more than 100 deep");
      std::array<Vector3, 3> points;
      for (std::size_t i = 0; i < 3; ++i) points[i] = place_of(entry.fields[1], numbers(entry, 2 + 3 * i), depth + 1);
      own.origin = points[0];
      const Vector3 z = points[1] - points[0], y = z.cross(points[2] - points[0]);
      if (!(y.norm() > 1e-12 * z.squaredNorm())) fail(entry.at, entry.name + ": its three points lie on a line");
      own.axes << y.cross(z).normalized(), y.normalized(), z.normalized();
    }
    const auto turned = [](double degrees) { return degrees * std::numbers::pi / 180; };
    const char kind = entry.name.back();
    Vector3 local = at;
    if (kind == 'C') local << at[0] * std::cos(turned(at[1])), at[0] * std::sin(turned(at[1])), at[2];
    if (kind == 'S')
      local << at[0] * std::sin(turned(at[1])) * std::cos(turned(at[2])),
          at[0] * std::sin(turned(at[1])) * std::sin(turned(at[2])), at[0] * std::cos(turned(at[1]));
    return own.origin + own.axes * local;
  }

  void add_node(const Entry& entry) {
    if (entry.fields.empty()) fail(entry.at, "GRID: expected a node's number");
    const long long name = whole(entry.fields[0], "a node's number");
    if (!nodes_.emplace(name, mesh_.point_count()).second)
      fail(entry.fields[0], "node " + std::to_string(name) + " stands here a second time");
    const bool own = entry.fields.size() > 1 && !entry.fields[1].empty();
    mesh_.add_point(place_of(own ? entry.fields[1] : usual_system_, numbers(entry, 2)));
  }

  void add_cell(const Entry& entry) {
    const BdfCell* kind = nullptr;
    for (const BdfCell& cell : bdf_cells)
      if (entry.name == cell.name) kind = &cell;
    const long long name = entry.fields.empty() ? 0 : whole(entry.fields[0], "an element's number");
    std::vector<int> points;
    for (std::size_t i = 2; i < entry.fields.size() && points.size() < kind->all; ++i) {
      const std::string_view field = entry.fields[i];
      if (field.empty()) break;
      if (points.size() == kind->corners && field.find('.') != std::string_view::npos) break;  // an angle or thickness
      const long long node = whole(field, "a node of an element");
      const auto found = nodes_.find(node);
      if (found == nodes_.end())
        fail(field, "cell " + std::to_string(name) + " uses node " + std::to_string(node) + ", which no GRID has");
      points.push_back(found->second);
    }
    const std::string_view at = entry.fields.empty() ? entry.at : entry.fields[0];
    if (kind->first.use != CellUse::triangle && kind->first.use != CellUse::face && points.size() == kind->all)
      for (std::size_t i = 2 + kind->all; i < entry.fields.size(); ++i)
        if (whole_number(entry.fields[i]))
          fail(entry.fields[i], "cell " + std::to_string(name) + ": behind the " + std::to_string(kind->all) +
                                    " nodes of its " + entry.name +
                                    " stand more: is the line of the next one missing?");
    if (kind->first.use == CellUse::face && points.size() > kind->corners)
      points.resize(kind->corners);  // some of its middles may be missing
    const CellType& type = points.size() == kind->corners ? kind->first : kind->second;
    if (points.size() != kind->corners && points.size() != kind->all)
      fail(at, entry.name + ": expected " + std::to_string(kind->corners) + " or " + std::to_string(kind->all) +
                   " nodes, found " + std::to_string(points.size()));
    mesh_.admit(type, [&] {
      fail(at, type.use == CellUse::face
                   ? entry.name + " is not used; allowed: CTETRA, CHEXA, CPENTA, CTRIA3, CTRIA6"
                   : "cell " + std::to_string(name) + ": a CPENTA of second order is not used; one of 6 nodes is");
    });
    const std::string problem = mesh_.add_cell(type, points);
    if (!problem.empty()) fail(at, "cell " + std::to_string(name) + problem);
    if (entry.fields.size() > 1 && !entry.fields[1].empty())
      mesh_.add_to_set(std::string(entry.fields[1]), points);  // its property
  }

  MeshBuilder& mesh_;
  Sources sources_;
  bool bulk_ = false, ended_ = false;
  Entry entry_;
  std::vector<Entry> grid_, cells_, others_;  ///< others: perhaps elements
  std::string_view usual_system_;             ///< of nodes that name none
  std::map<long long, System> systems_;
  std::map<long long, int> nodes_;
};

}  // namespace

void read_bdf(Cursor in, MeshBuilder& mesh) { BdfReader(in, mesh); }

}  // namespace elastin::mesh::format
