#include "blocks.h"

#include <cmath>
#include <stdexcept>

#include "elastin/simulation/catalog.h"
#include "experiment/tension.h"

namespace bench {

using namespace elastin;

const Block kBlock1{"T1", {0.03, 0.03, 0.015}, 5e3, 1}, kBlock2{"T2", {1, 1, 0.86}, 1e5, 1000};

// dolfinx, CalculiX and GetFEM, converged.
const std::vector<BlockReference> kBlockReferences{
    {&kBlock1, "linear", 0.25, 0.00320297919, 1e-5},         {&kBlock1, "linear", 0.3, 0.00314180381, 1e-5},
    {&kBlock2, "linear", 0.25, 0.00840022538, 1e-5},         {&kBlock2, "linear", 0.3, 0.00830615765, 2e-5},
    {&kBlock1, "neo_hookean", 0.3, 0.0036002, 6e-5},         {&kBlock2, "neo_hookean", 0.3, 0.00836035, 6e-5},
    {&kBlock1, "st_venant_kirchhoff", 0.3, 0.00242709, 6e-5}};

std::array<int, 3> Block::cubes(int level) const {
  const double shortest = size.minCoeff();
  std::array<int, 3> counts;
  for (int axis = 0; axis < 3; ++axis) counts[axis] = static_cast<int>(std::lround(level * size[axis] / shortest));
  return counts;
}

BlockProblem::BlockProblem(const Block& block, BlockKind kind, int level, const std::string& law, double poissons_ratio,
                           double part)
    : body(tetrahedral_block(kind, block.cubes(level), block.size)), model(body) {
  elastin::set_matter(body, block.size.minCoeff() / level / 4, 1000, 0, 0);
  const Material material{.youngs_modulus = block.modulus, .poissons_ratio = poissons_ratio};
  TensionSetup setup;
  setup.fixed_grip = Grip::clamped;
  setup.force = part * block.force;
  experiment = make_tension(body, setup);
  model.add(built_in_catalog().find(law == "linear" ? "st_venant_kirchhoff" : law).make(body, material, {}));
  experiment->hold(model);
  experiment->set_load(model, 1);
}

double BlockProblem::elongation(bool linear, double tolerance, StaticResult* result) {
  State state = state_at_rest(body);
  const StaticOptions options{.linear = linear, .tolerance = tolerance};
  StaticResult solved = solve_static(model, state, options);
  if (solved.outcome != Outcome::converged) throw std::runtime_error(solved.cause);
  if (result) *result = solved;
  const Start start{body.rest, Positions::Zero(3, solved.reactions.cols())};
  return experiment->measure(model, start, state, options, solved).get("elongation");
}

}  // namespace bench
