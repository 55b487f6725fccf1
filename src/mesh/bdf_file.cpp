#include <charconv>
#include <map>

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
constexpr std::string_view kRefused[] = {"CPYRAM", "CQUAD"};
/// What begins with these letters stands next to the cells: bars, springs, masses, couplings.
constexpr std::string_view kLeftOut[] = {"CBAR", "CBEAM",  "CBUSH", "CDAMP", "CELAS", "CGAP", "CMASS",
                                         "CONM", "CONROD", "CROD",  "CTUBE", "MPC",   "RB",   "RROD"};

/// One entry: its name and the fields behind it, with those of the lines that continue it.
struct Entry {
  std::string name;
  std::vector<std::string_view> fields;
};

class BdfReader {
 public:
  BdfReader(Cursor in, MeshBuilder& mesh) : in_(in), mesh_(mesh) {}

  void read() {
    bool bulk = in_.data().find("BEGIN BULK") == std::string_view::npos;
    while (in_.left() > 0) {
      std::string_view line = in_.line();
      line = line.substr(0, line.find('$'));
      const std::string_view text = trimmed(line);
      if (text.empty()) continue;
      if (text.starts_with("BEGIN BULK")) {
        bulk = true;
        continue;
      }
      if (text.starts_with("ENDDATA")) break;
      if (bulk) add_line(line);
    }
    end_entry();
    // Cells may stand before their nodes.
    for (const Entry& entry : cells_) add_cell(entry);
  }

 private:
  std::size_t offset(std::string_view part) const { return static_cast<std::size_t>(part.data() - in_.data().data()); }

  /// The fields of a line: between commas, or in columns of 8, of which the middle ones are 16 wide behind a *.
  static std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    if (line.find(',') != std::string_view::npos) {
      fields = comma_fields(line);
      if (fields.size() > 9) fields.resize(9);
      return fields;
    }
    const bool wide = line.substr(0, 8).find('*') != std::string_view::npos;
    for (std::size_t from = 0; from < std::min<std::size_t>(line.size(), 72);) {
      const std::size_t width = wide && from > 0 ? 16 : 8;
      fields.push_back(trimmed(line.substr(from, width)));
      from += width;
    }
    return fields;
  }

  void add_line(std::string_view line) {
    const auto fields = fields_of(line);
    std::string_view name = fields.empty() ? "" : fields.front();
    const bool goes_on = name.empty() || name.front() == '+' || name.front() == '*';
    if (!goes_on) {
      end_entry();
      if (name.ends_with('*')) name.remove_suffix(1);
      entry_.name = upper_case(trimmed(name));
    } else if (entry_.name.empty()) {
      return;
    }
    entry_.fields.insert(entry_.fields.end(), fields.begin() + 1, fields.end());
  }

  void end_entry() {
    Entry entry = std::move(entry_);
    entry_ = {};
    if (entry.name == "GRID") return add_node(entry);
    if (entry.name == "INCLUDE")
      in_.fail(entry.fields.empty() ? 0 : offset(entry.fields[0]), "INCLUDE is not read: put the mesh into one file");
    for (const std::string_view refused : kRefused)
      if (entry.name == refused && !entry.fields.empty())
        in_.fail(offset(entry.fields[0]), entry.name + " is not used; allowed: CTETRA, CHEXA, CPENTA, CTRIA3, CTRIA6");
    for (const BdfCell& cell : bdf_cells)
      if (entry.name == cell.name) cells_.push_back(entry);
    for (const std::string_view left_out : kLeftOut)
      if (entry.name.starts_with(left_out)) return mesh_.leave_out(entry.name);
  }

  long long whole(std::string_view field, const char* what) const {
    long long value = 0;
    const auto [end, problem] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (problem != std::errc() || end != field.data() + field.size())
      in_.fail(offset(field), std::string("expected ") + what + ", found " + quoted(field));
    return value;
  }

  /// "1.5", "1.5E-3", "1.5D-3" or, as Nastran alone writes, "1.5-3". An empty field is 0.
  double real(std::string_view field) const {
    if (field.empty()) return 0;
    if (const auto value = fortran_real(field)) return *value;
    in_.fail(offset(field), "expected a coordinate, a finite number, found " + quoted(field));
  }

  void add_node(const Entry& entry) {
    if (entry.fields.size() < 3) in_.fail(in_.at(), "GRID: expected a node's number, its system and coordinates");
    const long long name = whole(entry.fields[0], "a node's number");
    if (!entry.fields[1].empty() && entry.fields[1] != "0")
      in_.fail(offset(entry.fields[1]), "GRID: coordinates of the basic system alone are read; this is one of system " +
                                            quoted(entry.fields[1]));
    if (!nodes_.emplace(name, mesh_.point_count()).second)
      in_.fail(offset(entry.fields[0]), "node " + std::to_string(name) + " stands here a second time");
    Vector3 position = Vector3::Zero();
    for (std::size_t k = 0; k < 3 && k + 2 < entry.fields.size(); ++k)
      position[static_cast<Eigen::Index>(k)] = real(entry.fields[k + 2]);
    mesh_.add_point(position);
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
        in_.fail(offset(field),
                 "cell " + std::to_string(name) + " uses node " + std::to_string(node) + ", which no GRID has");
      points.push_back(found->second);
    }
    const std::size_t at = entry.fields.empty() ? 0 : offset(entry.fields[0]);
    const CellType& type = points.size() == kind->corners ? kind->first : kind->second;
    if (points.size() != kind->corners && points.size() != kind->all)
      in_.fail(at, entry.name + ": expected " + std::to_string(kind->corners) + " or " + std::to_string(kind->all) +
                       " nodes, found " + std::to_string(points.size()));
    mesh_.admit(type, [&] {
      in_.fail(at, type.use == CellUse::face
                       ? entry.name + " is not used; allowed: CTETRA, CHEXA, CPENTA, CTRIA3, CTRIA6"
                       : "cell " + std::to_string(name) + ": a CPENTA of second order is not used; one of 6 nodes is");
    });
    const std::string problem = mesh_.add_cell(type, points);
    if (!problem.empty()) in_.fail(at, "cell " + std::to_string(name) + problem);
    if (entry.fields.size() > 1 && !entry.fields[1].empty())
      mesh_.add_to_set(std::string(entry.fields[1]), points);  // its property
  }

  Cursor in_;
  MeshBuilder& mesh_;
  Entry entry_;
  std::vector<Entry> cells_;
  std::map<long long, int> nodes_;
};

}  // namespace

void read_bdf(Cursor in, MeshBuilder& mesh) { BdfReader(in, mesh).read(); }

}  // namespace elastin::mesh::format
