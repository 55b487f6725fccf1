#include "elastin/core/simulation/parts.h"

#include <vector>

#include "c/handles.h"
#include "elastin/core/model/parts.h"

using elastin::c::given;
using elastin::c::guarded;

extern "C" {

elastin_status elastin_body_of_parts(const elastin_part* parts, size_t count, elastin_body** body) {
  return guarded([&] {
    given(parts, "parts"), given(body, "body");
    if (count == 0) throw elastin::InputError("a body of parts needs one at least");
    elastin::Body whole;
    for (size_t number = 0; number < count; ++number) {
      const elastin_part from = elastin::c::checked_element(parts, number, "elastin_part");
      elastin::Part part;
      part.name = &given(from.name, "elastin_part.name");
      part.material = from.material;
      part.rigid = from.rigid != 0;
      if (part.material < 0) throw elastin::InputError("elastin_part.material is below 0");
      elastin::add_part(whole, given(from.body, "elastin_part.body").body, std::move(part));
    }
    *body = new elastin_body{std::move(whole)};
  });
}

elastin_status elastin_tie_parts(elastin_body* body, const char* first, const char* second, double within,
                                 double stiffness) {
  return guarded([&] {
    elastin::Body tied = given(body, "body").body;
    elastin::tie_parts(tied, &given(first, "first"), &given(second, "second"), within, stiffness);
    body->body = std::move(tied);
  });
}

elastin_status elastin_simulate_parts(const elastin_body* body, const char* strategy,
                                      const elastin_material* const* materials, size_t material_count,
                                      const elastin_options* options, elastin_simulation** simulation) {
  return guarded([&] {
    given(body, "body"), given(materials, "materials"), given(simulation, "simulation");
    std::vector<elastin::Material> all;
    for (size_t number = 0; number < material_count; ++number)
      all.push_back(elastin::c::material_of(materials[number]));
    for (const elastin::Part& part : body->body.parts)
      if (static_cast<size_t>(part.material) >= all.size())
        throw elastin::InputError("part '" + part.name + "' has material " + std::to_string(part.material) +
                                  "; there are " + std::to_string(all.size()) + ", from 0");
    if (all.empty()) throw elastin::InputError("material_count is 0: there must be one material at least");
    std::unique_ptr<CallbackRunner> runner;
    elastin::SimulationOptions chosen = elastin::c::options_of(options, runner);
    const elastin::Strategy by_parts =
        elastin::in_parts(elastin::c::strategy_of(strategy), body->body, all, &elastin::c::catalog());
    elastin::Simulation made(body->body, by_parts, all.front(), std::move(chosen));
    *simulation = new elastin_simulation{std::move(runner), std::move(made), all.front().youngs_modulus};
  });
}
}
