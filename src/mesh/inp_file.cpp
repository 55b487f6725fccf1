#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <list>
#include <map>
#include <numbers>
#include <optional>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

/// Element types of Abaqus and CalculiX by the first letters of their names: what follows says how they are integrated,
/// which is Elastin's own affair. Faces, lines and points stand next to the cells of a solid, and are left out.
const std::vector<CellType>& inp_cell_types() {
  struct Family {
    CellUse use;
    int points;
    const char* shape;
    std::vector<const char*> names;
  };
  static const std::vector<CellType> types = [] {
    std::vector<CellType> all;
    for (const Family& family : std::initializer_list<Family>{
             {CellUse::tetrahedron, 4, "", {"C3D4"}},
             {CellUse::cell, 10, "tetrahedron10", {"C3D10"}},
             {CellUse::cell, 6, "prism6", {"C3D6"}},
             {CellUse::cell, 8, "hexahedron8", {"C3D8"}},
             {CellUse::cell, 20, "hexahedron20", {"C3D20"}},
             {CellUse::refused, 0, "", {"C3D15", "C3D27"}},
             {CellUse::triangle, 3, "", {"CPS3", "CPE3", "S3", "M3D3", "STRI3"}},
             {CellUse::cell, 6, "triangle6", {"CPS6", "CPE6", "S6", "M3D6", "STRI65"}},
             {CellUse::face, 3, "", {"R3D3", "SFM3D3"}},
             {CellUse::face, 4, "", {"S4", "M3D4", "CPS4", "CPE4", "R3D4", "SFM3D4"}},
             {CellUse::face, 6, "", {"SFM3D6"}},
             {CellUse::face, 8, "", {"S8", "M3D8", "CPS8", "CPE8", "SFM3D8"}},
             {CellUse::face, 9, "", {"S9", "M3D9"}},
             {CellUse::line, 0, "", {"D"}},  // of CalculiX, part of a network of pipes
             {CellUse::line, 0, "", {"T2D", "T3D", "B2", "B3", "PIPE", "FRAME", "RB2D", "RB3D"}},
             {CellUse::line, 0, "", {"SPRING", "DASHPOT", "CONN", "GAP", "DCOUP", "JOINTC"}},
             {CellUse::point, 0, "", {"MASS", "ROTARYI"}}})
      for (const char* name : family.names) all.push_back({0, family.use, family.points, name, family.shape});
    return all;
  }();
  return types;
}

/// Of the longest beginning; a name of one letter is a whole one.
const CellType& find_inp_type(std::string_view name) {
  const CellType* found = &find_cell_type({}, -1);
  std::size_t longest = 0;
  for (const CellType& type : inp_cell_types())
    if (const std::size_t length = std::string_view(type.name).size();
        name.starts_with(type.name) && length > longest && (length > 1 || name.size() == 1))
      found = &type, longest = length;
  return *found;
}

bool is_left_out(const CellType& type) {
  return type.use == CellUse::face || type.use == CellUse::line || type.use == CellUse::point;
}

/// A name without quotes, and in capitals: names of Abaqus are the same in either case.
std::string_view unquoted(std::string_view text) {
  if (text.size() > 1 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return trimmed(text);
}
std::string key_of(std::string_view name) { return upper_case(unquoted(name)); }

using Fields = std::vector<std::string_view>;

/// Fields between commas; an empty one at the end says that the next line goes on.
Fields fields_of(std::string_view line) {
  Fields all = comma_fields(line);
  if (!all.empty() && all.back().empty()) all.pop_back();
  return all;
}

/// The rest of a keyword's line: "NSET=TOP, GENERATE".
struct Parameters {
  Fields all;
  std::optional<std::string_view> find(std::string_view key) const {
    for (const std::string_view part : all)
      if (const std::size_t equals = part.find('='); upper_case(trimmed(part.substr(0, equals))) == key)
        return equals == std::string_view::npos ? "" : trimmed(part.substr(equals + 1));
    return std::nullopt;
  }
};

class InpReader {
 public:
  InpReader(const Cursor& in, MeshBuilder& mesh) : mesh_(mesh), sources_(in) {
    part_ = &parts_.emplace_back();
    read_lines(in);
    end_section();
  }

  /// Hands all that is placed over: what stands outside of parts, and the instances, or without any the parts.
  void place() {
    const bool assembled = std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.is_instance; });
    std::vector<Part*> placed;
    std::map<std::string, int> owners;
    for (Part& part : parts_)
      if (&part == &parts_.front() || part.is_instance == assembled) placed.push_back(&part);
    for (Part* part : placed) {
      place(*part);
      for (const auto& [key, set] : part->sets) ++owners[key.second];
    }
    for (Part* part : placed)
      for (const auto& [key, members] : part->sets) {
        std::vector<int> points;
        collect(*part, members, 0, points);
        const std::string& name = spelled_.at(key.second);
        if (!part->name.empty()) mesh_.add_to_set(part->name + "." + name, points);
        if (part->name.empty() || owners[key.second] == 1) mesh_.add_to_set(name, points);
      }
    if (missing_ > 0) mesh_.leave_out("missing set member", missing_);
    if (!passed_over_.empty())
      mesh_.leave_out((passed_over_.size() == 1 ? "the keyword " : "the keywords ") + listed(passed_over_), 0);
  }

 private:
  struct Part;
  /// Numbers of nodes or elements, or the name of another set.
  struct Member {
    std::string_view text;
    long long first = 0, last = -1, step = 1;
    Part* part = nullptr;  ///< whose; null = that of the set
    bool of_nodes = true;
  };
  using Set = std::vector<Member>;
  using SetKey = std::pair<bool, std::string>;  ///< whether it is of nodes; its name in capitals
  struct Element {
    long long name;
    const CellType* type;
    std::string_view at;
    std::size_t first, count;  ///< of its nodes in `corners`
  };
  /// A part, an instance of one, or what stands outside of them.
  struct Part {
    std::string name;
    bool is_instance = false;
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    std::vector<Vector3> nodes;
    std::vector<Element> elements;
    std::vector<long long> corners;
    std::map<long long, std::size_t> node_of, element_of;  ///< by their numbers in the file
    std::map<SetKey, Set> sets;
    int first_point = 0;
  };
  using Row = void (InpReader::*)(const Fields&);
  /// What a keyword does: begins data that are read, or is refused because it would change the mesh.
  struct Keyword {
    std::string_view name;
    void (InpReader::*begin)(const Parameters&);
    const char* refusal = "";
  };

  [[noreturn]] void fail(std::string_view at, const std::string& message) const { sources_.fail(at, message); }

  template <class Number>
  Number number(std::string_view field, const char* what) const {
    std::optional<Number> value;
    if constexpr (std::is_floating_point_v<Number>) {
      value = field.empty() ? 0 : fortran_real(field);
    } else {
      value = whole_number(field);
    }
    if (!value) fail(field, std::string("expected ") + what + ", found " + quoted(field));
    return *value;
  }

  void read_lines(Cursor in) {
    while (in.left() > 0 && !ended_) {
      std::string_view text = trimmed(in.line());
      if (text.empty() || text.starts_with("**")) continue;
      if (text.front() != '*') {
        if (row_) (this->*row_)(fields_of(text));
        continue;
      }
      Parameters parameters{fields_of(text)};
      const std::string_view name = parameters.all.empty() ? text : parameters.all.front();
      while (text.ends_with(',') && in.left() > 0) {
        text = trimmed(in.line());
        const Fields more = fields_of(text);
        parameters.all.insert(parameters.all.end(), more.begin(), more.end());
      }
      begin(name, parameters);
    }
  }

  void begin(std::string_view name, const Parameters& parameters) {
    std::string word;
    for (const char letter : upper_case(name))
      if (letter != ' ') word += letter;
    const auto input = parameters.find("INPUT");
    if (word != "*INCLUDE") {
      end_section();
      here_ = name, row_ = nullptr, set_ = nullptr;
      static constexpr Keyword keywords[] = {
          {"*NODE", &InpReader::begin_nodes},
          {"*ELEMENT", &InpReader::begin_elements},
          {"*NSET", &InpReader::begin_node_set},
          {"*ELSET", &InpReader::begin_element_set},
          {"*PART", &InpReader::begin_part},
          {"*ENDPART", &InpReader::end_part},
          {"*INSTANCE", &InpReader::begin_instance},
          {"*ENDINSTANCE", &InpReader::end_part},
          {"*HEADING", &InpReader::skip},
          {"*PREPRINT", &InpReader::skip},
          {"*ASSEMBLY", &InpReader::skip},
          {"*ENDASSEMBLY", &InpReader::skip},
          {"*NGEN", nullptr, "makes nodes"},
          {"*NFILL", nullptr, "makes nodes"},
          {"*NCOPY", nullptr, "copies nodes"},
          {"*NMAP", nullptr, "moves nodes"},
          {"*SYSTEM", nullptr, "moves nodes"},
          {"*ELGEN", nullptr, "makes elements"},
          {"*ELCOPY", nullptr, "copies elements"},
          {"*IMPORT", nullptr, "takes the mesh of another analysis"},
          {"*SYMMETRICMODELGENERATION", nullptr, "copies the mesh"},
      };
      const auto known = std::find_if(std::begin(keywords), std::end(keywords),
                                      [&](const Keyword& keyword) { return keyword.name == word; });
      if (known == std::end(keywords)) {
        if (std::find(passed_over_.begin(), passed_over_.end(), word) == passed_over_.end())
          passed_over_.push_back(word);
        ended_ = word == "*STEP";
        return;
      }
      if (known->begin == nullptr)
        fail(name, word + " is not read: it " + known->refusal + "; write the mesh out in full");
      (this->*known->begin)(parameters);
    }
    if (!input) return;
    read_lines(sources_.include(unquoted(*input)));
  }

  void end_section() {
    if (corners_left_ == 0) return;
    const Element& open = part_->elements.back();
    fail(open.at, "cell " + std::to_string(open.name) + " ends before its last point");
  }

  Set* set_named(bool of_nodes, std::string_view name) {
    spelled_.try_emplace(key_of(name), unquoted(name));
    return &part_->sets[{of_nodes, key_of(name)}];
  }
  void begin_set_of_section(const Parameters& parameters, bool of_nodes) {
    if (const auto name = parameters.find(of_nodes ? "NSET" : "ELSET")) set_ = set_named(of_nodes, *name);
  }
  void add_to_set(long long name, bool of_nodes) {
    if (set_) set_->push_back({{}, name, name, 1, nullptr, of_nodes});
  }

  void begin_nodes(const Parameters& parameters) {
    const std::string system = key_of(parameters.find("SYSTEM").value_or("R"));
    if (system != "R" && system != "C")
      fail(here_, "*NODE: SYSTEM=" + system + " is not read; allowed: R (x, y, z) and C (radius, angle in degrees, z)");
    cylindrical_ = system == "C";
    row_ = &InpReader::read_node;
    begin_set_of_section(parameters, true);
  }
  void read_node(const Fields& parts) {
    Vector3 position = Vector3::Zero();
    for (std::size_t k = 0; k < 3 && k + 1 < parts.size(); ++k)
      position[static_cast<Eigen::Index>(k)] = number<double>(parts[k + 1], "a coordinate, a finite number");
    if (cylindrical_) {
      const double angle = position.y() * std::numbers::pi / 180;
      position.head<2>() = position.x() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    const auto name = number<long long>(parts[0], "a node's number");
    if (!part_->node_of.emplace(name, part_->nodes.size()).second)
      fail(parts[0], "node " + std::to_string(name) + " stands here a second time");
    part_->nodes.push_back(position);
    add_to_set(name, true);
  }
  void begin_elements(const Parameters& parameters) {
    const std::string_view name = needed_name(parameters, "TYPE");
    type_name_ = upper_case(name);
    type_ = &find_inp_type(type_name_);
    mesh_.admit(*type_, [&] {
      fail(name, "element type " + quoted(name) +
                     (type_->use == CellUse::face ? " is used next to the cells of a solid alone" : " is not used") +
                     "; allowed: C3D4, C3D10, C3D6, C3D8, C3D20, CPS3, S3, M3D3, CPS6, S6, M3D6 and their variants");
    });
    row_ = &InpReader::read_element;
    begin_set_of_section(parameters, false);
  }
  void read_element(const Fields& parts) {
    std::size_t next = 0;
    if (corners_left_ == 0) {
      const auto name = number<long long>(parts[next++], "an element's number");
      if (!part_->element_of.emplace(name, part_->elements.size()).second)
        fail(parts[0], "element " + std::to_string(name) + " stands here a second time");
      part_->elements.push_back({name, type_, parts[0], part_->corners.size(), 0});
      add_to_set(name, false);
      corners_left_ = static_cast<std::size_t>(type_->points);
      if (is_left_out(*type_)) mesh_.leave_out(type_name_ + " element");
    }
    for (; next < parts.size(); ++next) {
      if (type_->points > 0 && corners_left_ == 0)
        fail(parts[next],
             "a " + std::string(type_->name) + " has " + std::to_string(type_->points) + " nodes; here is one more");
      if (type_->points == 0 && parts[next].find_first_not_of("0123456789") != std::string_view::npos) continue;
      part_->corners.push_back(number<long long>(parts[next], "a node of an element"));
      ++part_->elements.back().count;
      if (corners_left_ > 0) --corners_left_;
    }
  }
  void begin_node_set(const Parameters& parameters) { begin_set(parameters, true); }
  void begin_element_set(const Parameters& parameters) { begin_set(parameters, false); }
  void begin_set(const Parameters& parameters, bool of_nodes) {
    set_ = set_named(of_nodes, needed_name(parameters, of_nodes ? "NSET" : "ELSET"));
    of_nodes_ = of_nodes;
    of_part_ = nullptr;
    if (const auto instance = parameters.find("INSTANCE")) of_part_ = &part_named(*instance, true);
    generated_ = parameters.find("GENERATE").has_value();
    if (const auto elements = parameters.find("ELSET"); of_nodes && elements)
      set_->push_back({*elements, 0, -1, 1, of_part_, false});
    row_ = &InpReader::read_set;
  }
  /// Numbers, or names of other sets; generated ones as first, last, step.
  void read_set(const Fields& parts) {
    if (!generated_) {
      for (const std::string_view part : parts)
        if (!part.empty()) set_->push_back({part, 0, -1, 1, of_part_, of_nodes_});
      return;
    }
    const auto whole = [&](std::size_t i) { return number<long long>(parts[i], "a member of a set"); };
    const long long first = whole(0), last = parts.size() > 1 ? whole(1) : first,
                    step = parts.size() > 2 ? whole(2) : 1;
    if (step < 1 || last < first || last - first > kMost)
      fail(parts[0], "expected first, last and step of the generated set");
    set_->push_back({{}, first, last, step, of_part_, of_nodes_});
  }

  Part& part_named(std::string_view name, bool instance) {
    std::vector<std::string> names;
    for (Part& part : parts_) {
      if (&part == &parts_.front() || part.is_instance != instance) continue;
      if (key_of(part.name) == key_of(name)) return part;
      names.push_back(part.name);
    }
    fail(name, std::string("there is no ") + (instance ? "*INSTANCE " : "*PART ") + quoted(unquoted(name)) +
                   " before this" + (names.empty() ? "" : suggestion(name, names)));
  }
  std::string_view needed_name(const Parameters& parameters, const char* key) const {
    if (const auto name = parameters.find(key); name && !name->empty()) return *name;
    fail(here_, std::string(here_) + ": expected " + key + "=…");
  }
  void begin_part(const Parameters& parameters) {
    parts_.push_back({});
    part_ = &parts_.back();
    part_->name = unquoted(needed_name(parameters, "NAME"));
  }
  void begin_instance(const Parameters& parameters) {
    if (parameters.find("LIBRARY"))
      fail(here_, "*INSTANCE: LIBRARY is not read: it takes the mesh from another model's results");
    Part instance = part_named(needed_name(parameters, "PART"), false);
    instance.is_instance = true;
    instance.name = unquoted(needed_name(parameters, "NAME"));
    parts_.push_back(std::move(instance));
    part_ = &parts_.back();
    placed_ = false;
    row_ = &InpReader::read_placement;
  }
  void skip(const Parameters&) {}
  void end_part(const Parameters&) { part_ = &parts_.front(); }
  /// An instance's displacement; in the second line two points of an axis, and the angle of the turn that follows.
  void read_placement(const Fields& parts) {
    Eigen::Matrix<double, 7, 1> values = Eigen::Matrix<double, 7, 1>::Zero();
    for (std::size_t i = 0; i < std::min<std::size_t>(parts.size(), 7); ++i)
      values[static_cast<Eigen::Index>(i)] = number<double>(parts[i], "a number of the instance's position");
    if (!placed_) {
      part_->motion.pretranslate(values.head<3>());
    } else {
      const Vector3 from = values.head<3>(), axis = values.segment<3>(3) - from;
      if (!(axis.norm() > 0)) fail(parts[0], "expected two points of the instance's axis of rotation, and the angle");
      part_->motion.pretranslate(-from);
      part_->motion.prerotate(Eigen::AngleAxisd(values[6] * std::numbers::pi / 180, axis.normalized()));
      part_->motion.pretranslate(from);
    }
    placed_ = true;
  }

  /// Hands a part's points and cells over.
  void place(Part& part) {
    part.first_point = mesh_.point_count();
    for (const Vector3& node : part.nodes) mesh_.add_point(part.motion * node);
    for (const Element& element : part.elements) {
      if (is_left_out(*element.type)) continue;
      const auto cell = [&] { return "cell " + std::to_string(element.name); };
      std::vector<int> points;
      for (std::size_t corner = 0; corner < element.count; ++corner) {
        const long long node = part.corners[element.first + corner];
        if (const auto found = part.node_of.find(node); found != part.node_of.end()) {
          points.push_back(part.first_point + static_cast<int>(found->second));
          continue;
        }
        const std::string_view data = sources_.of(element.at).data();
        std::string_view at = data.substr(static_cast<std::size_t>(element.at.data() - data.data()));
        for (std::size_t comma = 0; comma <= corner; ++comma)
          at.remove_prefix(std::min(at.find(','), at.size() - 1) + 1);
        fail(trimmed(at), cell() + " uses node " + std::to_string(node) + ", which *NODE does not have");
      }
      const std::string problem = mesh_.add_cell(*element.type, points);
      if (!problem.empty()) fail(element.at, cell() + problem);
    }
  }
  /// The points of a set's members.
  void collect(Part& part, const Set& set, int depth, std::vector<int>& points) {
    for (const Member& member : set) {
      Part* of = member.part ? member.part : &part;
      for (long long name = member.first; name <= member.last; name += member.step)
        collect_one(*of, member.of_nodes, name, points);
      std::string_view text = member.text;
      if (text.empty()) continue;
      if (const std::size_t dot = text.find('.');
          dot != std::string_view::npos && !of->sets.contains({member.of_nodes, key_of(text)})) {
        of = &part_named(text.substr(0, dot), true);
        text.remove_prefix(dot + 1);
      }
      if (text.find_first_not_of("0123456789") == std::string_view::npos) {
        collect_one(*of, member.of_nodes, number<long long>(text, "a member of a set"), points);
        continue;
      }
      const auto found = of->sets.find({member.of_nodes, key_of(text)});
      if (found == of->sets.end()) {
        std::vector<std::string> names;
        for (const auto& [key, known] : of->sets)
          if (key.first == member.of_nodes) names.push_back(spelled_.at(key.second));
        fail(text, "there is no set " + quoted(unquoted(text)) + suggestion(unquoted(text), names));
      }
      if (depth > 100) fail(text, "sets contain each other more than 100 deep");
      collect(*of, found->second, depth + 1, points);
    }
  }
  void collect_one(const Part& part, bool of_nodes, long long name, std::vector<int>& points) {
    if (of_nodes) {
      const auto node = part.node_of.find(name);
      node == part.node_of.end() ? void(++missing_)
                                 : points.push_back(part.first_point + static_cast<int>(node->second));
      return;
    }
    const auto found = part.element_of.find(name);
    if (found == part.element_of.end()) return void(++missing_);
    const Element& element = part.elements[found->second];
    for (std::size_t corner = 0; corner < element.count; ++corner)
      if (const auto node = part.node_of.find(part.corners[element.first + corner]); node != part.node_of.end())
        points.push_back(part.first_point + static_cast<int>(node->second));
  }

  static constexpr long long kMost = 10000000;  ///< that one line may make
  MeshBuilder& mesh_;
  Sources sources_;
  std::list<Part> parts_;  ///< first what stands outside of parts
  Part* part_ = nullptr;
  // The section that is being read:
  std::string_view here_;  ///< its keyword
  Row row_ = nullptr;      ///< what its lines are; null: passed over
  Set* set_ = nullptr;     ///< to which its nodes or elements belong
  Part* of_part_ = nullptr;
  bool of_nodes_ = false, generated_ = false, cylindrical_ = false, placed_ = false, ended_ = false;
  const CellType* type_ = nullptr;
  std::string type_name_;
  std::size_t corners_left_ = 0;                ///< of the last element
  std::map<std::string, std::string> spelled_;  ///< names of sets as they stand in the file, by those in capitals
  std::vector<std::string> passed_over_;
  std::size_t missing_ = 0;
};

}  // namespace

void read_inp(Cursor in, MeshBuilder& mesh) { InpReader(in, mesh).place(); }

}  // namespace elastin::mesh::format
