#include "lab/experiment/indentation/indentation.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

namespace {

Keys<IndentationSetup> form_keys(IndenterShape shape, const char* text) {
  return {key::quantity("radius", &IndentationSetup::radius, dimension::length, text, kPositive)
              .needed()
              .then([shape](const Reader&, IndentationSetup& setup) { setup.shape = shape; })};
}

/// sphere: {radius: 5 mm}, flat: {radius: 5 mm}, or an obstacle's name.
Key<IndentationSetup> indenter_key() {
  const Keys<IndentationSetup> forms{
      one_of<IndentationSetup>("write {sphere: {radius: 5 mm}}, {flat: {radius: 5 mm}}, or the name of an obstacle",
                               {key::below("sphere", form_keys(IndenterShape::sphere, "radius of a sphere")),
                                key::below("flat", form_keys(IndenterShape::flat, "radius of a flat punch"))})};
  const Key<IndentationSetup> form = key::below("indenter", forms, "what is pressed into the body");
  std::vector<SceneKey> rows = form.rows();
  rows.front().type = "map, or an obstacle's name";
  return Key<IndentationSetup>("indenter", rows,
                               [form](const Reader& value, IndentationSetup& setup, const Frame& frame) {
                                 if (!value.is_text()) return form.read(value, setup, frame);
                                 setup.shape = IndenterShape::obstacle;
                                 setup.obstacle = value.text();
                               })
      .needed();
}

}  // namespace

ExperimentInfo indentation_row() {
  std::vector<Key<IndentationSetup>> loads =
      travel_keys("depth", &IndentationSetup::depth, &IndentationSetup::axis, "depth from the first contact point");
  loads.push_back(key::quantity("force", &IndentationSetup::force, dimension::force,
                                "force, of the whole body, that ends the motion; not of an obstacle", kPositive)
                      .refused_for([](const IndentationSetup& setup) {
                        return setup.force && setup.shape == IndenterShape::obstacle ? "of an obstacle give the depth"
                                                                                     : "";
                      }));
  return with_keys(
      {.name = "indentation",
       .summary = "a rigid indenter is pressed into a body that stands on its far end: force, indentation modulus; "
                  "needs `contact`",
       .source = "Johnson 1985, ch. 3, 4",
       .measures = indentation_measures()},
      Keys<IndentationSetup>{
          key::direction("axis", &IndentationSetup::axis, "direction of the motion"), indenter_key(),
          one_of("give one of depth, strain and force", loads),
          key::vector("at", &IndentationSetup::at, dimension::length,
                      "a position on the indenter's axis; not of an obstacle")
              .otherwise("the middle")
              .refused_for([](const IndentationSetup& setup) {
                return setup.at && setup.shape == IndenterShape::obstacle ? "an obstacle begins where the scene has it"
                                                                          : "";
              }),
          grip_key("bottom", &IndentationSetup::bottom, "how the far end is fixed"),
          grip_depth_key(&IndentationSetup::grip_depth),
          symmetry_key(&IndentationSetup::symmetry).then([](const Reader& value, IndentationSetup& setup) {
            for (const Vector3& normal : setup.symmetry)
              if (std::abs(normal.dot(setup.axis)) > 1e-9) value.fail("must be perpendicular to the indenter's axis");
          }),
          load_steps_key(&IndentationSetup::load_steps)},
      [](const ExperimentContext& context, const IndentationSetup& setup) {
        return make_indentation(context.body, setup, context.material, contact_of_scene(context));
      });
}

}  // namespace elastin::lab
