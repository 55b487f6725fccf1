#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>

#include "elastin/core/base/error.h"
#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// Element types of Abaqus and CalculiX by the first letters of their names: what follows says how they are integrated,
// which is Elastin's own affair. The longest beginning counts.
constexpr std::pair<std::string_view, CellType> inp_cell_types[] = {
    {"C3D4", {0, CellUse::tetrahedron, 4, "C3D4"}},
    {"C3D10", {0, CellUse::cell, 10, "C3D10", "tetrahedron10"}},
    {"C3D6", {0, CellUse::cell, 6, "C3D6", "prism6"}},
    {"C3D8", {0, CellUse::cell, 8, "C3D8", "hexahedron8"}},
    {"C3D20", {0, CellUse::cell, 20, "C3D20", "hexahedron20"}},
    {"C3D27", {0, CellUse::refused, 27, "C3D27"}},
    {"CPS3", {0, CellUse::triangle, 3, "CPS3"}},
    {"CPE3", {0, CellUse::triangle, 3, "CPE3"}},
    {"S3", {0, CellUse::triangle, 3, "S3"}},
    {"M3D3", {0, CellUse::triangle, 3, "M3D3"}},
    {"STRI3", {0, CellUse::triangle, 3, "STRI3"}},
    {"CPS6", {0, CellUse::cell, 6, "CPS6", "triangle6"}},
    {"CPE6", {0, CellUse::cell, 6, "CPE6", "triangle6"}},
    {"S6", {0, CellUse::cell, 6, "S6", "triangle6"}},
    {"M3D6", {0, CellUse::cell, 6, "M3D6", "triangle6"}},
    {"STRI65", {0, CellUse::cell, 6, "STRI65", "triangle6"}},
    {"T3D2", {0, CellUse::line, 2, "T3D2"}},
    {"B31", {0, CellUse::line, 2, "B31"}},
};

std::string upper_case(std::string_view text) {
  std::string result(text);
  for (char& letter : result) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  return result;
}

class InpReader {
 public:
  InpReader(Cursor in, MeshBuilder& mesh) : in_(in), mesh_(mesh) {}

  void read() {
    while (in_.left() > 0) {
      const std::string_view line = in_.line(), text = trimmed(line);
      if (text.empty() || text.starts_with("**")) continue;
      if (text.front() == '*')
        begin_section(text);
      else if (section_ == Section::nodes)
        read_node(line);
      else if (section_ == Section::elements)
        read_element(line);
      else if (section_ == Section::node_set || section_ == Section::element_set)
        read_set(line);
    }
    if (!nodes_of_cell_.empty()) in_.fail(in_.at(), "cell " + std::to_string(name_) + " ends before its last point");
  }

 private:
  enum class Section { other, nodes, elements, node_set, element_set };

  /// "TOP" of "*NSET, NSET=TOP"; "" where the line has no such part.
  static std::string value_of(const std::vector<std::string_view>& parts, std::string_view key) {
    for (const std::string_view part : parts) {
      const std::size_t equals = part.find('=');
      if (equals != std::string_view::npos && upper_case(trimmed(part.substr(0, equals))) == key)
        return std::string(trimmed(part.substr(equals + 1)));
    }
    return "";
  }

  std::size_t offset(std::string_view part) const { return static_cast<std::size_t>(part.data() - in_.data().data()); }

  /// The fields between commas; an empty one at the end says that the next line goes on.
  static std::vector<std::string_view> fields(std::string_view line) {
    std::vector<std::string_view> all;
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t to = std::min(line.find(',', from), line.size());
      all.push_back(trimmed(line.substr(from, to - from)));
      from = to + 1;
    }
    if (!all.empty() && all.back().empty()) all.pop_back();
    return all;
  }

  template <class Number>
  Number number(std::string_view field, const char* what) const {
    Number value{};
    const std::string_view digits = field.starts_with('+') ? field.substr(1) : field;
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    bool is_finite = true;
    if constexpr (std::is_floating_point_v<Number>) is_finite = std::isfinite(value);
    if (problem != std::errc() || end != digits.data() + digits.size() || !is_finite)
      in_.fail(offset(field), std::string("expected ") + what + ", found " + quoted(field));
    return value;
  }

  void begin_section(std::string_view text) {
    if (!nodes_of_cell_.empty())
      in_.fail(offset(text), "cell " + std::to_string(name_) + " ends before its last point");
    const auto parts = fields(text);
    const std::string keyword = upper_case(parts.front());
    section_ = keyword == "*NODE"      ? Section::nodes
               : keyword == "*ELEMENT" ? Section::elements
               : keyword == "*NSET"    ? Section::node_set
               : keyword == "*ELSET"   ? Section::element_set
                                       : Section::other;
    set_ = value_of(parts, keyword == "*NODE" || keyword == "*NSET" ? "NSET" : "ELSET");
    generated_ =
        std::any_of(parts.begin(), parts.end(), [](std::string_view part) { return upper_case(part) == "GENERATE"; });
    if (keyword == "*INCLUDE") in_.fail(offset(text), "*INCLUDE is not read: put the mesh into one file");
    if (section_ != Section::elements) return;
    type_ = nullptr;
    for (const std::string_view part : parts) {
      const std::size_t equals = part.find('=');
      if (equals == std::string_view::npos || upper_case(trimmed(part.substr(0, equals))) != "TYPE") continue;
      const std::string_view name = trimmed(part.substr(equals + 1));
      std::size_t longest = 0;
      for (const auto& [beginning, type] : inp_cell_types)
        if (upper_case(name).starts_with(beginning) && beginning.size() > longest)
          longest = beginning.size(), type_ = &type;
      if (!type_ || type_->use == CellUse::refused)
        in_.fail(offset(name), "element type " + quoted(name) +
                                   " is not used; allowed: C3D4, C3D10, C3D6, C3D8, C3D20, CPS3, S3, M3D3, CPS6, S6, "
                                   "M3D6 and their variants");
    }
    if (!type_) in_.fail(offset(text), "*ELEMENT: expected TYPE=…");
  }

  /// Numbers, or names of sets before; generated ones as first, last, step.
  void read_set(std::string_view line) {
    const auto parts = fields(line);
    std::vector<long long> members;
    for (const std::string_view part : parts) {
      const bool digits = part.find_first_not_of("0123456789") == std::string_view::npos;
      if (digits && !part.empty()) members.push_back(number<long long>(part, "a member of a set"));
    }
    if (generated_ && members.size() >= 2) {
      const long long first = members[0], last = members[1], step = members.size() > 2 ? members[2] : 1;
      if (step < 1 || last < first || last - first > 100000000)
        in_.fail(offset(line), "expected first, last and step of the generated set");
      members.clear();
      for (long long member = first; member <= last; member += step) members.push_back(member);
    }
    for (const long long member : members)
      if (section_ == Section::node_set) {
        const auto found = nodes_.find(member);
        if (found != nodes_.end()) mesh_.add_to_set(set_, {&found->second, 1});
      } else if (const auto found = elements_.find(member); found != elements_.end()) {
        mesh_.add_to_set(set_, found->second);
      }
  }

  void read_node(std::string_view line) {
    const auto parts = fields(line);
    if (parts.size() < 4) in_.fail(offset(line), "expected a node's number and its three coordinates");
    const auto name = number<long long>(parts[0], "a node's number");
    if (!nodes_.emplace(name, mesh_.point_count()).second)
      in_.fail(offset(parts[0]), "node " + std::to_string(name) + " stands here a second time");
    Vector3 position;
    for (std::size_t k = 0; k < 3; ++k)
      position[static_cast<Eigen::Index>(k)] = number<double>(parts[k + 1], "a coordinate, a finite number");
    mesh_.add_point(position);
    if (const int point = mesh_.point_count() - 1; !set_.empty()) mesh_.add_to_set(set_, {&point, 1});
  }

  void read_element(std::string_view line) {
    auto parts = fields(line);
    std::size_t first = 0;
    if (nodes_of_cell_.empty()) {
      name_ = number<long long>(parts[0], "an element's number");
      at_ = offset(parts[0]), first = 1;
    }
    for (std::size_t i = first; i < parts.size(); ++i) {
      const auto node = number<long long>(parts[i], "a node of an element");
      const auto found = nodes_.find(node);
      if (found == nodes_.end())
        in_.fail(offset(parts[i]), "cell " + std::to_string(name_) + " uses node " + std::to_string(node) +
                                       ", which *NODE does not have");
      if (static_cast<int>(nodes_of_cell_.size()) == type_->points)
        in_.fail(offset(parts[i]), "a " + std::string(type_->name) + " has " + std::to_string(type_->points) +
                                       " nodes; here is one more");
      nodes_of_cell_.push_back(found->second);
    }
    if (static_cast<int>(nodes_of_cell_.size()) < type_->points) return;
    const std::string problem = mesh_.add_cell(*type_, nodes_of_cell_);
    if (!problem.empty()) in_.fail(at_, "cell " + std::to_string(name_) + problem);
    if (!set_.empty()) mesh_.add_to_set(set_, nodes_of_cell_);
    elements_[name_] = std::move(nodes_of_cell_);
    nodes_of_cell_.clear();
  }

  Cursor in_;
  MeshBuilder& mesh_;
  Section section_ = Section::other;
  const CellType* type_ = nullptr;
  std::map<long long, int> nodes_;
  std::map<long long, std::vector<int>> elements_;  ///< for sets of them
  std::string set_;                                 ///< to which the section's nodes or elements belong
  bool generated_ = false;                          ///< the set is told by first, last, step
  long long name_ = 0;                              ///< of the element that is being read
  std::size_t at_ = 0;                              ///< where it starts
  std::vector<int> nodes_of_cell_;                  ///< its nodes so far, where some are still to come
};

}  // namespace

void read_inp(Cursor in, MeshBuilder& mesh) { InpReader(in, mesh).read(); }

}  // namespace elastin::mesh::format
