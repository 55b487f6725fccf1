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

struct BodyItem {
  std::string name;
  std::optional<Reader> name_place, material;
  bool rigid = false;
  Matrix3 turn = Matrix3::Identity();
  Vector3 at = Vector3::Zero();
};

/// In addition to those of a body.
Keys<BodyItem> keys_of_item() {
  using S = BodyItem;
  return {
      key::text("name", &S::name, "what ties, experiments and `--set` call the body")
          .needed()
          .place(&S::name_place)
          .refused_for([](const S& setup) {
            return setup.name.empty() ? "give the body a name that ties and experiments can say" : "";
          }),
      Key<S>({"material", "map", "", "", "the scene's", "what differs from the scene's [material](#material)"},
             [](const Reader& value, S& setup, const Frame&) {
               setup.material = value;
               setup.material->set_section("material");
             }),
      key::flag("rigid", &S::rigid,
                "whether the body never deforms, and stays where it is unless the experiment moves it"),
      key::rotation("turn", &S::turn, "rotation about the origin, before `at`"),
      key::vector("at", &S::at, dimension::length, "displacement of the whole body to its position").otherwise("0")};
}

void read_one(Reader item, const elastin::Table<MaterialLaw>& laws, Specimen& specimen, Remarks remarks) {
  BodyItem setup;
  keys_of_item().read_into(item, setup);
  keys_of_item().check(item, setup);
  auto& own = setup.material;
  Material material = own ? read_material(*own, laws, &specimen.material) : specimen.material;
  Body body = read_body(item, material, remarks);
  if (own) check_material(*own, material, body);
  if (own)
    if (const auto fields = own->find("fields")) set_fields(*fields, laws, material, body);
  if (material.bending_rigidity > 0) (own ? *own : item).fail("bending needs a scene of one body, `body`");
  Material turned = material;
  const Vector3 before = body.rest.col(0);
  rotate(body, setup.turn);
  body.rest.colwise() += setup.at;
  body.outline.colwise() += setup.at;
  rotate(turned, setup.turn);
  const Vector3 moved = body.rest.col(0) - setup.turn * before;
  if (turned.around) turned.around->point += moved;
  if (turned.field) turned.field->shift += moved;
  Part part;
  part.name = setup.name;
  part.rigid = setup.rigid;
  if (own) {
    const bool whole = own->given_material("given") != nullptr;
    if (whole || own->has("fibre")) material.fibre = turned.fibre;
    if (whole || own->has("active")) material.active = turned.active;
    if (whole || own->has("law")) material.law = turned.law;
    if (whole || own->has("around")) material.around = turned.around;
    if (whole || own->has("fields")) material.field = turned.field;
    part.material = static_cast<int>(specimen.materials.size());
    specimen.materials.push_back(std::move(material));
  }
  part.thickness = (own ? specimen.materials.back() : specimen.material).thickness;
  setup.name_place->located([&] { add_part(specimen.body, body, std::move(part)); });
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

struct TieSetup {
  std::vector<Reader> between;
  double within = 0;
  std::optional<Reader> place;
};

Keys<TieSetup> keys_of_tie() {
  using S = TieSetup;
  return {Key<S>({"between", "two names", "", "", "", "the bodies that are joined"},
                 [](const Reader& value, S& setup, const Frame&) { setup.between = value.items(2); })
              .needed(),
          key::quantity("within", &S::within, dimension::length, "largest distance that is tied", kPositive).needed()};
}

void read_tie(const Reader& item, Specimen& specimen, MoleculeSets& sets, Remarks remarks) {
  const TieSetup setup = keys_of_tie().read(item);
  double modulus = 0;
  for (const Reader& name : setup.between) {
    const Part& part = name.located([&]() -> const Part& { return find_part(specimen.body, name.text()); });
    modulus = std::max(modulus, specimen.materials[part.material].youngs_modulus);
  }
  const std::string one = setup.between[0].text(), other = setup.between[1].text();
  std::vector<int> numbers;
  const TieReport report = item.located(
      [&] { return tie_parts(specimen.body, one, other, setup.within, kTieStiffness * modulus, numbers); });
  renumber(numbers, sets);
  std::string how;
  const auto add = [&](int count, const std::string& what) {
    if (count > 0) how += fmt::format("{}{} {}", how.empty() ? "" : ", ", count, what);
  };
  add(report.joined, "joined to one");
  add(report.fixed, "fixed to bone");
  add(report.tied, fmt::format("fixed to the other's surface, moved there by up to {:.3g} mm", 1e3 * report.furthest));
  if (report.tied > 0)
    how += "; the meshes differ there, which makes the body softer than one mesh, by about 1 % where they are coarse";
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
  return {
      {"bodies", "Bodies",
       "Each item of `bodies` has the keys of a [body](#body), and these. A law of cells is that of solids on bodies "
       "of solid cells and that of membranes, `neo_hookean_membrane` for `neo_hookean`, on bodies of triangles, "
       "whichever of the two `stiffness` names: a skin on a core. A `force` on an end goes to the area of the solid "
       "cells alone: pull a core with a skin by a `displacement` or `strain`.",
       keys_of_item().rows()},
      {"ties", "",
       "Each item of `ties` joins the molecules of one body to the surface of another:", keys_of_tie().rows()}};
}

}  // namespace elastin::lab
