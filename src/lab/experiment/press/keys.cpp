#include "lab/experiment/press/press.h"

#include <algorithm>

#include "elastin/core/model/parts.h"
#include "lab/experiment/keys.h"

namespace elastin::lab {

namespace {

struct PressKeys : PressSetup {
  std::string moved_name, fixed_name;  ///< of bodies
};

std::vector<int> molecules_named(const std::string& name, const Body& body) {
  return molecules_of(find_part(body, name));
}

}  // namespace

ExperimentInfo press_row() {
  using S = PressKeys;
  const auto body_name = [](const char* name, std::string S::*member, const char* fallback, const char* text) {
    return Key<S>({name, "a body's name", "", "", fallback, text},
                  [member](const Reader& value, S& setup, const Frame& frame) {
                    setup.*member = value.text();
                    value.located([&] { return find_part(*frame.body, setup.*member); });
                  });
  };
  std::vector<Key<PressSetup>> loads =
      travel_keys("displacement", &PressSetup::displacement, &PressSetup::axis, "displacement of what is moved");
  loads.push_back(
      key::quantity("force", &PressSetup::force, dimension::force, "force that ends the motion", kPositive));
  return with_keys(
      {.name = "press",
       .summary =
           "a body, or the near end of one, is pressed onto what lies before it: force, contact area; needs `contact`",
       .source = "",
       .measures = press_measures()},
      Keys<S>{key::direction("axis", &S::axis, "direction of the motion"),
              one_of<S>("give one of displacement, strain and force", {loads.begin(), loads.end()}),
              body_name("move", &S::moved_name, "the near end", "what is moved"),
              body_name("fix", &S::fixed_name, "the far end, or rigid bodies", "what is fixed"),
              grip_key("grip", &S::grip, "how both are fixed across the axis"), grip_depth_key(&S::grip_depth),
              load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        const Body& body = context.body;
        if (!setup.moved_name.empty()) setup.moved = molecules_named(setup.moved_name, body);
        if (!setup.fixed_name.empty()) setup.fixed = molecules_named(setup.fixed_name, body);
        // What is rigid and is not moved stays where it is.
        const auto stays = [&](const Part& part) { return part.rigid && part.name != setup.moved_name; };
        if (setup.moved && !setup.fixed && std::any_of(body.parts.begin(), body.parts.end(), stays))
          setup.fixed.emplace();
        contact_of_scene(context);
        return make_press(body, setup);
      });
}

}  // namespace elastin::lab
