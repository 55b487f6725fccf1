#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/model/ties.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Stiffness of a tie over E, times the root of the surface that a molecule stands for: it gives way by a hundredth of
/// what a layer of cells does, and does not slow the solver much.
constexpr double kTieStiffness = 100;

/// Where the body stands: turned about the origin, then moved. Returns the rotation.
Matrix3 pose_body(Reader& reader, Body& body) {
  const auto turn = reader.find("turn");
  const Matrix3 rotation = turn ? turn->rotation() : Matrix3(Matrix3::Identity());
  if (turn) rotate(body, rotation);
  if (auto at = reader.find("at")) body.rest.colwise() += at->vector(dimension::length);
  return rotation;
}

/// {name: cartilage, at: [0, 0, 1 mm], turn: {axis: z, angle: 1}, material: {…}, rigid: true} and what a body has.
void read_one(Reader item, const elastin::Table<MaterialLaw>& laws, Specimen& specimen, Remarks remarks) {
  Part part;
  const Reader name = item.at("name");
  part.name = name.text();
  if (part.name.empty()) name.fail("give the body a name that ties and experiments can say");
  auto own = item.find("material");
  if (own) own->set_section("material");
  Material material = own ? read_material(*own, laws, &specimen.material) : specimen.material;
  if (auto rigid = item.find("rigid")) part.rigid = rigid->choice<bool>({{"true", true}, {"false", false}});
  for (const char* key : {"at", "turn"}) item.has(key);
  Body body = read_body(item, material, remarks);
  if (own) check_material(*own, material, body);
  if (own)
    if (const auto fields = own->find("fields")) set_fields(*fields, laws, material, body);
  if (material.bending_rigidity > 0) (own ? *own : item).fail("bending needs a scene of one body, `body`");
  Material turned = material;
  const Vector3 before = body.rest.col(0);
  const Matrix3 rotation = pose_body(item, body);
  rotate(turned, rotation);
  const Vector3 moved = body.rest.col(0) - rotation * before;
  if (turned.around) turned.around->point += moved;
  if (turned.field) turned.field->shift += moved;
  const bool whole = own && own->given_material("given");
  if (own && (whole || own->has("fibre"))) material.fibre = turned.fibre;
  if (own && (whole || own->has("active"))) material.active = turned.active;
  if (own && (whole || own->has("law"))) material.law = turned.law;
  if (own && (whole || own->has("around"))) material.around = turned.around;
  if (own && (whole || own->has("fields"))) material.field = turned.field;
  if (own) {
    part.material = static_cast<int>(specimen.materials.size());
    specimen.materials.push_back(std::move(material));
  }
  name.located([&] { add_part(specimen.body, body, std::move(part)); });
}

/// Puts the sets of a body whose molecules begin at `first` to those of the bodies before it.
void add_sets(const MoleculeSets& own, int first, MoleculeSets& sets) {
  for (const auto& [name, members] : own)
    for (const int member : members) sets[name].push_back(first + member);
}

void renumber(const std::vector<int>& numbers, MoleculeSets& sets) {
  if (numbers.empty()) return;
  for (auto& [name, members] : sets) {
    for (int& member : members) member = numbers[member];
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
  }
}

/// {between: [femur, cartilage], within: 0.5 mm}
void read_tie(Reader item, Specimen& specimen, MoleculeSets& sets, Remarks remarks) {
  const std::vector<Reader> names = item.at("between").items(2);
  double modulus = 0;
  for (const Reader& name : names) {
    const Part& part = name.located([&]() -> const Part& { return find_part(specimen.body, name.text()); });
    modulus = std::max(modulus, specimen.materials[part.material].youngs_modulus);
  }
  const double within = item.at("within").quantity(dimension::length, kPositive);
  item.finish();
  const std::string one = names[0].text(), other = names[1].text();
  std::vector<int> numbers;
  const TieReport report =
      item.located([&] { return tie_parts(specimen.body, one, other, within, kTieStiffness * modulus, numbers); });
  renumber(numbers, sets);
  std::string how;
  const auto add = [&](int count, const std::string& what) {
    if (count > 0) how += fmt::format("{}{} {}", how.empty() ? "" : ", ", count, what);
  };
  add(report.joined, "joined to one");
  add(report.fixed, "fixed to bone");
  add(report.tied, fmt::format("fixed to the other's surface, moved there by up to {:.3g} mm", 1e3 * report.furthest));
  remarks.notes.push_back(fmt::format("{} and {} are tied: of the molecules {}", one, other, how));
}

}  // namespace

void read_bodies(const Reader& list, std::optional<Reader> ties, const elastin::Table<MaterialLaw>& laws,
                 Specimen& specimen, Remarks remarks) {
  specimen.materials = {specimen.material};
  const std::vector<Reader> items = list.items();
  if (items.empty()) list.fail("names no body; write a list of them");
  MoleculeSets sets;
  Reader file = list;
  for (const Reader& item : items) {
    MoleculeSets own;
    file.set_mesh_sets({});
    const int first = specimen.body.size();
    remarks.sets = &own;
    read_one(item, laws, specimen, remarks);
    add_sets(own, first, sets);
  }
  if (ties)
    for (const Reader& item : ties->items()) read_tie(item, specimen, sets, remarks);
  file.set_mesh_sets(std::move(sets));
}

std::vector<KeySection> bodies_keys() {
  return {{"bodies",
           "Bodies",
           "Each item of `bodies` has the keys of a [body](#body), and these:",
           {{"name", "text", "", "", "needed", "what ties, experiments and `--set` call the body"},
            {"material", "map", "", "", "the scene's", "what differs from the scene's [material](#material)"},
            {"rigid", "`true`, `false`", "", "", "`false`", "whether the body never deforms"},
            {"turn", "rotation", "", "", "none", "rotation about the origin, before `at`"},
            {"at", "vector", "m", "", "0", "displacement of the whole body to its position"}}},
          {"ties",
           "",
           "Each item of `ties` joins the molecules of one body to the surface of another:",
           {{"between", "two names", "", "", "needed", "the bodies that are joined"},
            {"within", "quantity", "m", "> 0", "needed", "largest distance that is tied"}}}};
}

}  // namespace elastin::lab
