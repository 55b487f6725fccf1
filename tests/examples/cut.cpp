// A surgeon in small: a moving block of tissue is cut half through, its flap is lifted, and a probe presses on it.
#include <cmath>
#include <cstdio>

#include "elastin/contact/contact.h"
#include "elastin/core/model/surface.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"

using namespace elastin;

int main() {
  // 40 × 20 × 10 mm of tetrahedra, 1000 kg/m³, held at its bottom.
  Body body = tetrahedral_block(BlockKind::kuhn, {16, 8, 4}, {0.04, 0.02, 0.01});
  set_matter(body, 1e-3, 1000, 0, 0);
  const double mass = body.mass.sum();
  SimulationOptions options;
  options.stepper = {"backward_euler", {{"newton_iterations", 2}}};
  Simulation tissue(std::move(body), built_in_catalog().find("neo_hookean"),
                    Material{.youngs_modulus = 8e3, .poissons_ratio = 0.4}, options);
  for (int molecule = 0; molecule < tissue.body().size(); ++molecule)
    if (tissue.body().rest(2, molecule) == 0) tissue.fix(molecule);

  // What acts goes by functions of the model, so that it can follow a cut.
  const ToolId probe = tissue.add_tool({.position = {0.03, 0.01, 0.02}});
  tissue.add([](Model& model) {
    model.add(make_gravity(model.body(), {0, 0, -9.81}));
    model.add(make_mass_damping(model.body(), 20));
  });
  contact::ContactOptions touch;
  touch.surface = contact::ContactSurface::triangles, touch.stiffness = 2e7;
  touch.obstacles.push_back({"probe", contact::shape::Sphere{4e-3}, {}, tissue.tool_motion(probe)});
  tissue.add([touch](Model& model) { model.add(contact::make_contact(model.body(), touch)); });

  int corner = 0;  // the free one of the flap to be
  (tissue.body().rest.colwise() - Vector3(0, 0, 0.01)).colwise().norm().minCoeff(&corner);
  Cells<3> drawn = surface_of(tissue.body());
  CouplingId hook = 0;
  for (int frame = 0; frame < 120; ++frame) {
    if (frame == 20) {  // a blade goes in from one side, 5 mm below the top, as far as the middle
      const TopologyReport cut = tissue.cut(CutSurface::blade({Vector3(-0.001, -1, 0.005), Vector3(-0.001, 1, 0.005)},
                                                              {Vector3(0.02, -1, 0.005), Vector3(0.02, 1, 0.005)}));
      const std::size_t before = drawn.size();
      drawn = surface_of(tissue.body());
      std::printf("%d molecules split, %zu triangles more to draw\n", cut.split_molecules, drawn.size() - before);
      hook = tissue.couple(corner, tissue.positions().col(corner), 50, 0.05);
    }
    if (hook) tissue.move_coupling(hook, {-1e-3, 0, 0.01 + 1e-4 * (frame - 20)});
    tissue.move_tool(probe, {0.03, 0.01, 0.0135 - 1e-3 * std::sin(frame * 0.02)});
    if (const StepResult result = tissue.step(2e-3); result.outcome != Outcome::converged) {
      std::printf("frame %d: %s\n", frame, result.cause.c_str());
      return 1;
    }
  }
  const double lifted = 1e3 * (tissue.positions()(2, corner) - 0.01);
  const auto [touched, pressed] = contact::forces_on_obstacles(tissue).front();
  std::printf("flap lifted by %.2f mm with %.1f mN, the %s pressed with %.1f mN\n", lifted,
              1e3 * tissue.coupling_force(hook).norm(), touched.c_str(), 1e3 * pressed.norm());
  return lifted > 1 && pressed.z() > 0 && std::abs(tissue.body().mass.sum() / mass - 1) < 1e-13 ? 0 : 1;
}
