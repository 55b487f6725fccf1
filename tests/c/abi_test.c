/* The face for C as a C compiler sees it. Prints what does not hold; exit code 1 if there is anything. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elastin/c/elastin.h"
#include "twin.h"

static int failures = 0;

#define CHECK(condition)                                     \
  do {                                                       \
    if (!(condition)) {                                      \
      printf("%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      printf("  the last message: %s\n", elastin_message()); \
      ++failures;                                            \
    }                                                        \
  } while (0)
#define OK(call) CHECK((call) == ELASTIN_OK)
#define REFUSED(call, words) CHECK((call) == ELASTIN_WRONG_INPUT && strstr(elastin_message(), words))

static const elastin_material kSoft = {sizeof(elastin_material), 5000, 0.25, 0, 0, NULL, NULL};

static elastin_body* lattice(void) {
  const int counts[3] = {3, 3, 4};
  const double spacing[3] = {1e-3, 1e-3, 1e-3};
  elastin_body* body = NULL;
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 1000, &body));
  return body;
}

static elastin_simulation* tissue(const elastin_options* options) {
  elastin_body* body = lattice();
  elastin_simulation* simulation = NULL;
  OK(elastin_simulate(body, "lattice", &kSoft, options, &simulation));
  elastin_body_free(body);
  return simulation;
}

/* Programs that were compiled with this header must go on working: offsets only ever grow at the end. */
static void layout(void) {
  CHECK(elastin_abi() == ELASTIN_ABI && ELASTIN_ABI == 1);
  CHECK(strcmp(elastin_version(), "0.2.0") == 0);
  CHECK(sizeof(elastin_status) == sizeof(int) && sizeof(elastin_outcome) == sizeof(int));
  if (sizeof(void*) != 8 || sizeof(size_t) != 8) return;
  CHECK(sizeof(elastin_arrays) == 128 && offsetof(elastin_arrays, positions) == 8);
  CHECK(offsetof(elastin_arrays, masses) == 16 && offsetof(elastin_arrays, radii) == 24);
  CHECK(offsetof(elastin_arrays, connections) == 32 && offsetof(elastin_arrays, rest_lengths) == 40);
  CHECK(offsetof(elastin_arrays, triangles) == 48 && offsetof(elastin_arrays, tetrahedra) == 56);
  CHECK(offsetof(elastin_arrays, molecule_count) == 64 && offsetof(elastin_arrays, connection_count) == 72);
  CHECK(offsetof(elastin_arrays, triangle_count) == 80 && offsetof(elastin_arrays, tetrahedron_count) == 88);
  CHECK(offsetof(elastin_arrays, density) == 96 && offsetof(elastin_arrays, thickness) == 104);
  CHECK(offsetof(elastin_arrays, growth) == 112 && offsetof(elastin_arrays, growth_count) == 120);
  CHECK(sizeof(elastin_counts) == 40 && offsetof(elastin_counts, tetrahedra) == 32);
  CHECK(sizeof(elastin_material) == 56 && offsetof(elastin_material, bending_rigidity) == 32);
  CHECK(offsetof(elastin_material, law) == 40 && offsetof(elastin_material, description) == 48);
  CHECK(sizeof(elastin_law) == 32 && offsetof(elastin_law, constants) == 16);
  CHECK(sizeof(elastin_parameter) == 72 && offsetof(elastin_parameter, fallback) == 48);
  CHECK(sizeof(elastin_value) == 16 && offsetof(elastin_value, value) == 8);
  CHECK(sizeof(elastin_part) == 32 && offsetof(elastin_part, rigid) == 28);
  CHECK(sizeof(elastin_obstacle) == 136 && offsetof(elastin_obstacle, turn) == 64);
  CHECK(sizeof(elastin_contact) == 72 && offsetof(elastin_contact, obstacles) == 56);
  CHECK(sizeof(elastin_topology_report) == 40 && offsetof(elastin_topology_report, molecules) == 24);
  CHECK(sizeof(elastin_options) == 104 && offsetof(elastin_options, stepper) == 8);
  CHECK(offsetof(elastin_options, budget) == 96);
  CHECK(offsetof(elastin_options, safety) == 16 && offsetof(elastin_options, max_substeps) == 24);
  CHECK(offsetof(elastin_options, parameters) == 32 && offsetof(elastin_options, parameter_count) == 40);
  CHECK(offsetof(elastin_options, threads) == 48 && offsetof(elastin_options, run) == 56);
  CHECK(offsetof(elastin_options, run_context) == 64 && offsetof(elastin_options, run_width) == 72);
  CHECK(offsetof(elastin_options, stepper_parameters) == 80 && offsetof(elastin_options, stepper_parameter_count) == 88);
  CHECK(sizeof(elastin_step_result) == 32 && offsetof(elastin_step_result, linear_iterations) == 20);
  CHECK(offsetof(elastin_step_result, unstable) == 24);
}

/* A block under tension by a law and by its springs; and what is refused. */
static void laws(void) {
  const int counts[3] = {3, 3, 4};
  const double spacing[3] = {1e-3, 1e-3, 1e-3};
  const elastin_value values[] = {{"mu_1", 2e3},   {"alpha_1", 1.5},      {"mu_2", -100},
                                  {"alpha_2", -2}, {"bulk_modulus", 1e5}, {"volumetric_mixed", 1}},
                      misspelt[] = {{"alfa_1", 1}};
  elastin_law law = {sizeof law, "ogden", values, 6};
  elastin_material material = {sizeof material, 0, 0, 0, 0, &law, NULL};
  elastin_body* body = NULL;
  elastin_simulation* simulation = NULL;
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 1000, &body));
  OK(elastin_simulate(body, "lattice", &material, NULL, &simulation)); /* springs with the law's E at rest */
  elastin_simulation_free(simulation);
  REFUSED(elastin_simulate(body, "ogden", &material, NULL, &simulation), "needs tetrahedra");
  material.youngs_modulus = 1;
  REFUSED(elastin_simulate(body, "lattice", &material, NULL, &simulation), "follow from the constants");
  material.youngs_modulus = 0;
  law.constants = misspelt, law.constant_count = 1;
  REFUSED(elastin_simulate(body, "lattice", &material, NULL, &simulation), "alfa_1");
  law.name = "odgen";
  REFUSED(elastin_simulate(body, "lattice", &material, NULL, &simulation), "did you mean 'ogden'");
  elastin_body_free(body);
}

static void strategies(void) {
  size_t count = 0, parameters = 0, found = 0, i, k;
  OK(elastin_strategy_count(&count));
  CHECK(count > 10);
  for (i = 0; i < count; ++i) {
    const char *name = NULL, *summary = NULL;
    OK(elastin_strategy(i, &name, &summary, &parameters));
    CHECK(name && *name && summary && *summary);
    for (k = 0; k < parameters; ++k) {
      elastin_parameter one = {sizeof one, NULL, NULL, NULL, 1, 0, 0, NULL, 0};
      OK(elastin_strategy_parameter(i, k, &one));
      CHECK(one.name && one.unit && one.text && one.low <= one.fallback && one.fallback <= one.high);
      ++found;
    }
  }
  CHECK(found > 0);
  REFUSED(elastin_strategy(count, NULL, NULL, NULL), "there are");
  REFUSED(elastin_strategy_count(NULL), "count is null");
}

/* The constants of a connection: those that a parameter says, and E times a length. */
static void constants(void) {
  const int counts[3] = {1, 1, 2};
  const double spacing[3] = {15e-3, 15e-3, 15e-3};
  elastin_material material = {sizeof material, 5e3, 0.25, 0, 0, NULL, NULL};
  const elastin_value constant = {"constant", 200};
  double soft = 0, stiff = 0;
  elastin_body* body = NULL;
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS, 1000, &body));
  OK(elastin_strategy_constants(body, "uniform", &material, &constant, 1, &soft, 1));
  CHECK(soft == 200);
  OK(elastin_strategy_constants(body, "standard", &material, NULL, 0, &soft, 1));
  material.youngs_modulus = 10e3;
  OK(elastin_strategy_constants(body, "standard", &material, NULL, 0, &stiff, 1));
  CHECK(soft > 0 && fabs(stiff / soft - 2) < 1e-12);
  REFUSED(elastin_strategy_constants(body, "standard", &material, NULL, 0, &soft, 2), "the body has 1 connections");
  REFUSED(elastin_strategy_constants(body, "standard", &material, NULL, 0, NULL, 1), "constants is null");
  REFUSED(elastin_strategy_constants(body, "neo_hookean", &material, NULL, 0, &soft, 1), "only a spring rule");
  elastin_body_free(body);
}

/* Two tetrahedra, one of them inverted: 1/6 of a cube of 6 mm each. */
static const double kPositions[15] = {0, 0, 0, 6e-3, 0, 0, 0, 6e-3, 0, 0, 0, 6e-3, 0, 0, -6e-3};
static const int kCells[8] = {0, 1, 2, 3, 0, 1, 2, 4};

static elastin_arrays arrays(void) {
  elastin_arrays given = {sizeof given, kPositions, NULL, NULL, NULL, NULL, NULL, kCells, 5, 0, 0, 2, 1000, 0, NULL, 0};
  return given;
}

static void bodies(void) {
  elastin_arrays given = arrays();
  elastin_body* body = NULL;
  elastin_counts counts = {sizeof counts, 0, 0, 0, 0};
  const double* shown = NULL;
  const int* ends = NULL;
  size_t count = 0;
  const int wrong[4] = {0, 1, 2, 5}, twice[4] = {0, 1, 2, 2}, flat[4] = {0, 3, 4, 3};
  double masses[5] = {1, 1, 1, 1, 0};
  OK(elastin_body_from_arrays(&given, &body));
  OK(elastin_body_counts(body, &counts));
  CHECK(counts.molecules == 5 && counts.connections == 9 && counts.triangles == 0 && counts.tetrahedra == 2);
  OK(elastin_body_positions(body, &shown, &count));
  CHECK(count == 15 && memcmp(shown, kPositions, sizeof kPositions) == 0 && shown != kPositions);
  OK(elastin_body_masses(body, &shown, &count)); /* a quarter of each tetrahedron of 36 mg to each of its corners */
  CHECK(count == 5 && fabs(shown[3] - 9e-6) < 1e-15 && fabs(shown[0] - 18e-6) < 1e-15);
  OK(elastin_body_connections(body, &ends, &count));
  CHECK(count == 18 && ends[0] == 0 && ends[1] == 1 && ends[17] == 4);
  OK(elastin_body_triangles(body, &ends, &count));
  CHECK(count == 0);
  elastin_body_free(body);
  body = NULL;

  given.tetrahedra = wrong, given.tetrahedron_count = 1;
  REFUSED(elastin_body_from_arrays(&given, &body), "tetrahedra[0]: there is no molecule 5; allowed: 0 to 4");
  given.tetrahedra = twice;
  REFUSED(elastin_body_from_arrays(&given, &body), "tetrahedra[0]: names molecule 2 twice");
  given.tetrahedra = NULL;
  REFUSED(elastin_body_from_arrays(&given, &body), "tetrahedra is null");
  given = arrays(), given.masses = masses;
  REFUSED(elastin_body_from_arrays(&given, &body), "masses[4]: is 0");
  given = arrays(), given.density = 0;
  REFUSED(elastin_body_from_arrays(&given, &body), "density is 0");
  given = arrays(), given.molecule_count = 0;
  REFUSED(elastin_body_from_arrays(&given, &body), "at least one molecule");
  given = arrays(), given.molecule_count = (size_t)1 << 60;
  REFUSED(elastin_body_from_arrays(&given, &body), "too many");
  given = arrays(), given.size = 0;
  REFUSED(elastin_body_from_arrays(&given, &body), "elastin_arrays.size is 0");
  given.size = sizeof given + 8;
  REFUSED(elastin_body_from_arrays(&given, &body), "elastin_arrays.size is 136");
  given = arrays(), given.connections = flat, given.connection_count = 2, given.tetrahedron_count = 0;
  OK(elastin_body_from_arrays(&given, &body));
  elastin_body_free(body);
  body = NULL;
  REFUSED(elastin_body_from_arrays(NULL, &body), "elastin_arrays is null");
  REFUSED(elastin_body_from_arrays(&given, NULL), "body is null");
  REFUSED(elastin_body_counts(NULL, &counts), "body is null");
  CHECK(body == NULL);
  elastin_body_free(NULL);
}

static void drawing(void) {
  const double points[] = {1e-3, 1e-3, 1e-3, 1.5e-3, 1e-3, 1e-3, 1e-3, 1.5e-3, 1e-3};
  const int triangles[] = {0, 1, 2};
  float at[9], normals[9];
  elastin_body* body = lattice();
  elastin_simulation* simulation = NULL;
  elastin_surface* surface = NULL;
  const elastin_value moves[] = {{"acceleration_x", 2}};
  REFUSED(elastin_surface_make(body, NULL, 3, triangles, 1, &surface), "points is null");
  REFUSED(elastin_surface_make(body, points, 2, triangles, 1, &surface), "points 0 to 1");
  OK(elastin_surface_make(body, points, 3, triangles, 1, &surface));
  OK(elastin_simulate(body, "lattice", &kSoft, NULL, &simulation));
  OK(elastin_add(simulation, "gravity", moves, 1));
  OK(elastin_step(simulation, 1e-3, NULL)); /* moves as a whole, by 2 m/s2 (1 ms)2 or half of it */
  OK(elastin_surface_draw(surface, simulation, at, normals));
  CHECK(at[0] > 1.0009e-3f && at[0] < 1.0021e-3f && fabs(at[3] - at[0] - 5e-4) < 1e-9);
  CHECK(fabs(normals[2] - 1) < 1e-6 && fabs(normals[5] - 1) < 1e-6);
  OK(elastin_surface_draw(surface, simulation, at, NULL));
  REFUSED(elastin_surface_draw(surface, NULL, at, NULL), "simulation is null");
  elastin_surface_free(surface);
  elastin_surface_free(NULL);
  elastin_simulation_free(simulation);
  elastin_body_free(body);
}

/* A tetrahedron whose rest is larger than it lies becomes that large, from wherever it begins. */
static void rests(void) {
  const double corners[12] = {0, 0, 0, 1e-2, 0, 0, 0, 1e-2, 0, 0, 0, 1e-2},
               growth[18] = {1.1, 0, 0, 0, 1.2, 0, 0, 0, 1};
  const int cell[4] = {0, 1, 2, 3};
  elastin_arrays arrays = {.size = sizeof arrays};
  double begin[12];
  const double* now = NULL;
  elastin_body* body = NULL;
  elastin_simulation* simulation = NULL;
  arrays.positions = corners, arrays.molecule_count = 4, arrays.tetrahedra = cell, arrays.tetrahedron_count = 1;
  arrays.density = 1000, arrays.growth = growth, arrays.growth_count = 2;
  REFUSED(elastin_body_from_arrays(&arrays, &body), "growth: has 2 matrices; allowed: 1");
  arrays.growth_count = 0;
  REFUSED(elastin_body_from_arrays(&arrays, &body), "growth_count is 0");
  arrays.growth_count = 1;
  OK(elastin_body_from_arrays(&arrays, &body));
  OK(elastin_simulate(body, "neo_hookean", &kSoft, NULL, &simulation));
  OK(elastin_fix(simulation, 0, 0));
  OK(elastin_fix(simulation, 1, 1));
  OK(elastin_fix(simulation, 2, 3));
  OK(elastin_positions(simulation, &now, NULL));
  memcpy(begin, corners, sizeof begin);
  begin[11] = 0.9e-2;
  REFUSED(elastin_set_positions(simulation, begin, 9), "positions");
  OK(elastin_set_positions(simulation, begin, 12));
  CHECK(now[11] == 0.9e-2 && now[3] == 1e-2);
  OK(elastin_settle(simulation, NULL));
  CHECK(fabs(now[3] - 1.1e-2) < 1e-8 && fabs(now[7] - 1.2e-2) < 1e-8 && fabs(now[11] - 1e-2) < 1e-8);
  elastin_simulation_free(simulation);
  elastin_body_free(body);
}

/* Without connections there is a rest length for each edge of the cells: longer, they push. */
static void unstressed_lengths(void) {
  const double corners[12] = {0, 0, 0, 1e-2, 0, 0, 0, 1e-2, 0, 0, 0, 1e-2};
  const int cell[4] = {0, 1, 2, 3};
  double lengths[6];
  const double *tensions = NULL, *now = NULL;
  size_t count = 0, i;
  elastin_arrays arrays = {.size = sizeof arrays};
  elastin_body* body = NULL;
  elastin_simulation* simulation = NULL;
  arrays.positions = corners, arrays.molecule_count = 4, arrays.tetrahedra = cell, arrays.tetrahedron_count = 1;
  arrays.density = 1000, arrays.rest_lengths = lengths;
  for (i = 0; i < 6; ++i) lengths[i] = 1.1e-2 * (i < 3 ? 1 : sqrt(2));
  OK(elastin_body_from_arrays(&arrays, &body));
  OK(elastin_simulate(body, "standard", &kSoft, NULL, &simulation));
  OK(elastin_tensions(simulation, &tensions, &count));
  CHECK(count == 6);
  for (i = 0; i < 6; ++i) CHECK(tensions[i] < 0);
  OK(elastin_settle(simulation, NULL));
  OK(elastin_positions(simulation, &now, NULL));
  CHECK(fabs(hypot(hypot(now[3] - now[0], now[4] - now[1]), now[5] - now[2]) - 1.1e-2) < 1e-8);
  elastin_simulation_free(simulation);
  elastin_body_free(body);
  body = NULL;
  lengths[5] = -1;
  REFUSED(elastin_body_from_arrays(&arrays, &body), "rest_lengths[5]: is -1");
}

/* What one function makes of all inputs is what each input makes of it. */
static void derivatives(void) {
  const elastin_value weight[] = {{"acceleration_z", -9.81}};
  double in[3][400], out[5][400], one = 0, other = 0;
  size_t count = 0, i;
  int molecule;
  elastin_simulation* simulation = tissue(NULL);
  OK(elastin_add(simulation, "gravity", weight, 1));
  for (molecule = 0; molecule < 9; ++molecule) OK(elastin_fix(simulation, molecule, 0));
  REFUSED(elastin_vjp(simulation, NULL, NULL, out[0], NULL, NULL), "call settle() first");
  OK(elastin_settle(simulation, NULL));
  OK(elastin_stiffness_count(simulation, &count));
  CHECK(count > 36 && count <= 400);
  for (i = 0; i < 400; ++i)
    in[0][i] = sin(1.0 + (double)i), in[1][i] = i < 27 ? 1e-3 * cos(3.0 * (double)i) : 0, in[2][i] = sin(7.0 * (double)i);
  /* m = sum of sin(i) x_i and 1e-3 cos(3 i) R_i */
  OK(elastin_vjp(simulation, in[0], in[1], out[0], out[1], out[2]));
  OK(elastin_jvp(simulation, in[2], in[1], in[2], out[3], out[4]));
  for (i = 0; i < 108; ++i) one += in[0][i] * out[3][i] + in[1][i] * out[4][i];
  for (i = 0; i < 108; ++i) other += out[0][i] * in[2][i] + out[1][i] * in[1][i];
  for (i = 0; i < count; ++i) other += out[2][i] * in[2][i];
  CHECK(fabs(one) > 0 && fabs(one - other) < 1e-9 * fabs(one));
  OK(elastin_vjp(simulation, NULL, NULL, NULL, NULL, out[2]));
  CHECK(out[2][0] == 0);
  elastin_simulation_free(simulation);
}

static void stepping(void) {
  static twin_run twin, run;
  const elastin_value weight[] = {{"acceleration_z", -9.81}}, damping[] = {{"mass", 20}};
  const double *positions = NULL, *velocities = NULL, *forces = NULL, *tensions = NULL, *again = NULL;
  double* host = NULL;
  double time = 0;
  size_t count = 0;
  int coupling = 0, molecule, step;
  const char* warnings = NULL;
  elastin_simulation* simulation = tissue(NULL);
  OK(elastin_add(simulation, "gravity", weight, 1));
  OK(elastin_add(simulation, "rayleigh", damping, 1));
  for (molecule = 0; molecule < 9; ++molecule) OK(elastin_fix(simulation, molecule, 0));
  OK(elastin_positions(simulation, &positions, &count));
  CHECK(count == 3 * 36);
  OK(elastin_couple(simulation, 35, positions + 3 * 35, 50, 0.01, &coupling));
  OK(elastin_host_forces(simulation, &host, &count));
  for (step = 0; step < kTwinSteps; ++step) {
    const double at[3] = {2e-3, 2e-3, 3e-3 + 1e-5 * step}, speed[3] = {0, 0, 1e-2}, corner[3] = {-1e-6 * step, 0, 0};
    elastin_step_result result = {sizeof result, -1, 0, -1, -1, 0};
    OK(elastin_move_coupling(simulation, coupling, at, speed));
    OK(elastin_move_to(simulation, 0, corner));
    host[3 * 20] = 1e-5;
    OK(elastin_step(simulation, 1e-3, &result));
    CHECK(result.outcome == ELASTIN_CONVERGED && result.substeps >= 1 && result.newton_iterations == 0);
  }
  OK(elastin_time(simulation, &time));
  CHECK(fabs(time - kTwinSteps * 1e-3) < 1e-12);
  OK(elastin_positions(simulation, &again, NULL));
  CHECK(again == positions);
  OK(elastin_velocities(simulation, &velocities, NULL));
  OK(elastin_forces(simulation, &forces, NULL));
  OK(elastin_tensions(simulation, &tensions, &count));
  OK(elastin_reaction(simulation, 4, run.reaction));
  OK(elastin_coupling_force(simulation, coupling, run.coupling_force));
  twin_step(&twin);
  CHECK(memcmp(positions, twin.positions, sizeof twin.positions) == 0);
  CHECK(memcmp(velocities, twin.velocities, sizeof twin.velocities) == 0);
  CHECK(memcmp(forces, twin.forces, sizeof twin.forces) == 0);
  CHECK(count == twin.tension_count && memcmp(tensions, twin.tensions, count * sizeof(double)) == 0);
  CHECK(memcmp(run.reaction, twin.reaction, sizeof run.reaction) == 0 && run.reaction[2] != 0);
  CHECK(memcmp(run.coupling_force, twin.coupling_force, sizeof run.coupling_force) == 0 && run.coupling_force[2] != 0);
  OK(elastin_decouple(simulation, coupling));
  CHECK(elastin_coupling_force(simulation, coupling, run.coupling_force) == ELASTIN_WRONG_INPUT);
  CHECK(elastin_warnings(simulation, &warnings) == ELASTIN_OK && warnings[0] == 0);
  OK(elastin_release(simulation, 0));
  elastin_simulation_free(simulation);
}

/* Springs that push apart have no equilibrium to stay in, and no force says so. */
static void unstable(void) {
  const double constants[2] = {50, -50};
  for (int i = 0; i < 2; ++i) {
    const elastin_value constant = {"constant", constants[i]};
    elastin_options options = {sizeof options, "newmark", 0, 0, &constant, 1, 0, NULL, NULL, 0, NULL, 0, 0};
    elastin_step_result result = {sizeof result, -1, 0, -1, -1, -1}, old = {24, -1, 0, -1, -1, -1};
    elastin_body* body = lattice();
    elastin_simulation* simulation = NULL;
    OK(elastin_simulate(body, "uniform", &kSoft, &options, &simulation));
    OK(elastin_settle(simulation, &result));
    CHECK(result.outcome == ELASTIN_CONVERGED && result.unstable == i);
    OK(elastin_settle(simulation, &old)); /* of a program that was compiled with an older header */
    CHECK(old.outcome == ELASTIN_CONVERGED && old.unstable == -1);
    elastin_simulation_free(simulation);
    elastin_body_free(body);
  }
}

static void refusals(void) {
  char words[1024];
  const double position[3] = {0, 0, 0}, odd[3] = {0, NAN, 0};
  const elastin_value unknown[] = {{"vicosity", 1}}, negative[] = {{"viscosity", -1}}, nameless[] = {{NULL, 1}},
                      twice[] = {{"viscosity", 1}, {"viscosity", 7}}, parts[] = {{"divisor", 1}, {"divisor", 7}},
                      along[] = {{"acceleration_z", 1}, {"acceleration_z", 7}};
  elastin_material wrong = kSoft;
  elastin_body* body = lattice();
  elastin_simulation *simulation = NULL, *kept = tissue(NULL);
  elastin_options options = {sizeof options, "newmak", 0, 0, NULL, 0, 0, NULL, NULL, 0, NULL, 0, 0};
  elastin_step_result result = {0, 0, 0, 0, 0, 0};
  double time = 0, force[3];
  int coupling = 0;
  twin_message(0, words, sizeof words);
  CHECK(elastin_simulate(body, "latice", &kSoft, NULL, &simulation) == ELASTIN_WRONG_INPUT);
  CHECK(*words && strcmp(elastin_message(), words) == 0);
  twin_message(1, words, sizeof words);
  CHECK(elastin_simulate(body, "neo_hookean", &kSoft, NULL, &simulation) == ELASTIN_WRONG_INPUT);
  CHECK(*words && strcmp(elastin_message(), words) == 0);
  wrong.poissons_ratio = 0.6;
  REFUSED(elastin_simulate(body, "lattice", &wrong, NULL, &simulation), "poissons_ratio is 0.6; it must be");
  wrong = kSoft, wrong.youngs_modulus = NAN;
  REFUSED(elastin_simulate(body, "lattice", &wrong, NULL, &simulation), "youngs_modulus is nan");
  REFUSED(elastin_simulate(body, "lattice", &kSoft, &options, &simulation), "did you mean 'newmark'");
  options.stepper = NULL, options.parameters = unknown, options.parameter_count = 1;
  REFUSED(elastin_simulate(body, "lattice", &kSoft, &options, &simulation), "vicosity");
  options.parameters = parts, options.parameter_count = 2;
  REFUSED(elastin_simulate(body, "divided", &kSoft, &options, &simulation), "parameters: 'divisor' is given twice");
  REFUSED(elastin_simulate(body, "wrinkling", &kSoft, NULL, &simulation), "goes with a membrane law");
  REFUSED(elastin_simulate(body, NULL, &kSoft, NULL, &simulation), "strategy is null");
  REFUSED(elastin_simulate(NULL, "lattice", &kSoft, NULL, &simulation), "body is null");
  REFUSED(elastin_simulate(body, "lattice", NULL, NULL, &simulation), "elastin_material is null");
  CHECK(simulation == NULL);

  REFUSED(elastin_add(kept, "gravty", NULL, 0), "did you mean 'gravity'");
  {
    const elastin_value down[] = {{"acceleration_z", -10}}, misspelt[] = {{"aceleration_z", -10}},
                        away[] = {{"acceleration_x", 3}};
    int load = 0;
    OK(elastin_add_load(kept, "gravity", down, 1, &load));
    REFUSED(elastin_set_load(kept, load, misspelt, 1), "did you mean 'acceleration_z'");
    OK(elastin_set_load(kept, load, away, 1));
    OK(elastin_remove_load(kept, load));
    REFUSED(elastin_remove_load(kept, load), "no load");
    REFUSED(elastin_set_load(kept, 100, away, 1), "no load 100");
  }
  REFUSED(elastin_add(kept, "stokes_drag", unknown, 1), "did you mean 'viscosity'");
  REFUSED(elastin_add(kept, "stokes_drag", negative, 1), "must be at least 0");
  REFUSED(elastin_add(kept, "stokes_drag", nameless, 1), "name is null");
  REFUSED(elastin_add(kept, "stokes_drag", twice, 2), "stokes_drag: 'viscosity' is given twice");
  REFUSED(elastin_add(kept, "gravity", along, 2), "gravity: 'acceleration_z' is given twice");
  REFUSED(elastin_add(kept, "floor", NULL, 0), "floor.point is missing");
  REFUSED(elastin_add(NULL, "floor", NULL, 0), "simulation is null");
  REFUSED(elastin_fix(kept, 36, 0), "36");
  REFUSED(elastin_fix(kept, 0, 8), "free_axes is 8");
  REFUSED(elastin_move_to(kept, 0, position), "0");
  REFUSED(elastin_reaction(kept, -1, force), "molecule -1: there are 36, from 0");
  REFUSED(elastin_couple(kept, 0, position, 0, 0, &coupling), "stiffness");
  REFUSED(elastin_couple(kept, 0, odd, 1, 0, &coupling), "position must be three finite numbers");
  REFUSED(elastin_couple(kept, 0, NULL, 1, 0, &coupling), "position is null");
  REFUSED(elastin_observe(kept, 1, NULL, NULL), "see is null");
  REFUSED(elastin_step(NULL, 1e-3, NULL), "simulation is null");
  REFUSED(elastin_step(kept, 1e-3, &result), "elastin_step_result.size is 0");
  REFUSED(elastin_time(kept, NULL), "time is null");
  REFUSED(elastin_set_threads(-1), "threads is -1");
  OK(elastin_time(kept, &time));
  CHECK(time == 0);
  CHECK(elastin_step(kept, -1, NULL) == ELASTIN_STOPPED && strstr(elastin_message(), "-1 s"));
  elastin_simulation_free(kept);
  elastin_simulation_free(NULL);
  elastin_body_free(body);
}

static void steps_of(elastin_simulation* simulation, int count, double* positions) {
  const double* now = NULL;
  size_t numbers = 0;
  while (count-- > 0) OK(elastin_step(simulation, 1e-3, NULL));
  OK(elastin_positions(simulation, &now, &numbers));
  memcpy(positions, now, numbers * sizeof *now);
}

/* A tetrahedron on three fixed corners that sinks under gravity: its loose corner after some steps. */
static void sinking(const char* strategy, const elastin_material* material, double corner[3]) {
  static const double places[12] = {0, 0, 0, 1e-2, 0, 0, 0, 1e-2, 0, 0, 0, 1e-2};
  static const int tetrahedra[4] = {0, 1, 2, 3};
  const elastin_value down[] = {{"acceleration_z", -9.81}};
  elastin_arrays given = {sizeof given, places, NULL, NULL, NULL, NULL, NULL, tetrahedra, 4, 0, 0, 1, 1000, 0, NULL, 0};
  elastin_body* body = NULL;
  elastin_simulation* simulation = NULL;
  double all[12] = {0};
  int molecule;
  OK(elastin_body_from_arrays(&given, &body));
  OK(elastin_simulate(body, strategy, material, NULL, &simulation));
  OK(elastin_add(simulation, "gravity", down, 1));
  for (molecule = 0; molecule < 3; ++molecule) OK(elastin_fix(simulation, molecule, 0));
  steps_of(simulation, 20, all);
  memcpy(corner, all + 9, 3 * sizeof *corner);
  elastin_simulation_free(simulation);
  elastin_body_free(body);
}

/* A material as a scene describes it is the one of the same constants, and relaxes and softens besides. */
static void described(void) {
  const elastin_value constants[] = {{"c_1", 1e3}, {"bulk_modulus", 1e5}};
  const elastin_law law = {sizeof law, "yeoh", constants, 2};
  const elastin_material by_law = {sizeof by_law, 0, 0, 0, 0, &law, NULL};
  elastin_material in_words = {sizeof in_words,
                               0,
                               0,
                               0,
                               0,
                               NULL,
                               "{law: yeoh, terms: [1 kPa], bulk_modulus: 100 kPa, softening: {r: 2, m: 9 Pa},"
                               " relaxation: {terms: [[0.5, 1 s]]}}"};
  double one[3], other[3], relaxing[3];
  elastin_body* body = NULL;
  elastin_simulation* simulation = NULL;
  const int counts[3] = {2, 2, 2};
  const double spacing[3] = {1e-3, 1e-3, 1e-3};
  sinking("yeoh", &by_law, one);
  sinking("yeoh", &in_words, other);
  sinking("prony:mullins:yeoh", &in_words, relaxing);
  CHECK(one[2] < 1e-2 && memcmp(one, other, sizeof one) == 0);
  CHECK(relaxing[2] > one[2] && relaxing[2] < 1e-2); /* the given moduli are those after a long time */
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 1000, &body));
  REFUSED(elastin_simulate(body, "prony:lattice", &by_law, NULL, &simulation), "relaxation");
  in_words.description = "{law: yeoh, terns: [1 kPa], bulk_modulus: 100 kPa}";
  REFUSED(elastin_simulate(body, "lattice", &in_words, NULL, &simulation), "terns");
  in_words.youngs_modulus = 5;
  REFUSED(elastin_simulate(body, "lattice", &in_words, NULL, &simulation), "leave the other values 0");
  elastin_body_free(body);
}

/* What a strategy or a material needs is prepared as in C++. */
static void preparing(void) {
  static const char* const names[] = {"lattice+volume", "calibrated:standard", "calibrated:angles+volume", "voronoi",
                                      NULL};
  static const double sheet[12] = {0, 0, 0, 1e-2, 0, 0, 0, 1e-2, 0, 1e-2, 1e-2, 0};
  static const int triangles[6] = {0, 1, 2, 1, 3, 2};
  static double twin[3 * 36];
  elastin_arrays given = {sizeof given, sheet, NULL, NULL, NULL, NULL, triangles, NULL, 4, 0, 2, 0,
                          1000,         1e-3,  NULL, 0};
  elastin_material material = {sizeof material, 5000, 0.4, 1e-3, 0, NULL, NULL};
  int number, at;
  for (number = 0; number < kTwinStrategies; ++number) {
    const char* name = names[number] ? names[number] : "st_venant_kirchhoff_membrane";
    elastin_body* body = NULL;
    elastin_simulation* simulation = NULL;
    const double* forces = NULL;
    double* host = NULL;
    size_t count = 0, shown = 0;
    if (names[number]) {
      body = lattice();
    } else {
      OK(elastin_body_from_arrays(&given, &body));
      material.bending_rigidity = 1e-4;
    }
#ifndef ELASTIN_C_LAB
    if (number == 3) { /* Voronoi cells are of elastin::mesh */
      REFUSED(elastin_simulate(body, name, &material, NULL, &simulation), "Voronoi cells");
      elastin_body_free(body);
      continue;
    }
#endif
    OK(elastin_simulate(body, name, &material, NULL, &simulation));
    elastin_body_free(body);
    if (!simulation) continue;
    OK(elastin_host_forces(simulation, &host, &count));
    host[count - 1] = 1e-4;
    OK(elastin_step(simulation, 1e-4, NULL));
    OK(elastin_step(simulation, 1e-4, NULL));
    OK(elastin_forces(simulation, &forces, &shown));
    twin_prepared(name, names[number] == NULL, twin);
    CHECK(shown == count && memcmp(forces, twin, count * sizeof *twin) == 0);
    for (at = 0; at < (int)count; ++at) CHECK(isfinite(twin[at]));
    elastin_simulation_free(simulation);
  }
}

static void saving(void) {
  double first[3 * 36], second[3 * 36];
  const double position[3] = {2e-3, 2e-3, 4e-3};
  char* bytes = NULL;
  size_t needed = 0, more = 0, at;
  int coupling = 0;
  elastin_simulation* simulation = tissue(NULL);
  elastin_arrays given = arrays();
  elastin_body* body = NULL;
  elastin_simulation* other = NULL;
  OK(elastin_fix(simulation, 0, 0));
  OK(elastin_couple(simulation, 35, position, 20, 0, &coupling));
  steps_of(simulation, 5, first);
  OK(elastin_save(simulation, NULL, 0, &needed));
  CHECK(needed > 2 * sizeof first);
  bytes = malloc(needed + 1);
  if (!bytes) abort();
  REFUSED(elastin_save(simulation, bytes, needed - 1, &more), "the state takes");
  OK(elastin_save(simulation, bytes, needed, &more));
  CHECK(more == needed);
  steps_of(simulation, 5, first);
  OK(elastin_restore(simulation, bytes, needed));
  steps_of(simulation, 5, second);
  CHECK(memcmp(first, second, sizeof first) == 0);

  REFUSED(elastin_restore(simulation, bytes, needed - 1), "cut off");
  REFUSED(elastin_restore(simulation, bytes, 4), "no saved state");
  bytes[needed] = 0;
  REFUSED(elastin_restore(simulation, bytes, needed + 1), "followed by 1 bytes");
  bytes[0] = 1;
  REFUSED(elastin_restore(simulation, bytes, needed), "version 1; version 6 is read");
  bytes[0] = 6, bytes[5] = 'X';
  REFUSED(elastin_restore(simulation, bytes, needed), "no saved state, or that of another kind of machine");
  bytes[5] = 'a';
  for (at = 0; at < needed; ++at) { /* a single bit that has changed */
    bytes[at] = (char)(bytes[at] ^ (1 << at % 8));
    CHECK(elastin_restore(simulation, bytes, needed) == ELASTIN_WRONG_INPUT);
    bytes[at] = (char)(bytes[at] ^ (1 << at % 8));
  }
  OK(elastin_restore(simulation, bytes, needed));
  steps_of(simulation, 5, second);
  CHECK(memcmp(first, second, sizeof first) == 0);
  OK(elastin_body_from_arrays(&given, &body));
  OK(elastin_simulate(body, "standard", &kSoft, NULL, &other));
  CHECK(elastin_restore(other, bytes, needed) == ELASTIN_WRONG_INPUT);
  elastin_simulation_free(other);
  elastin_body_free(body);
  elastin_simulation_free(simulation);
  free(bytes);
}

static void see(void* context, const elastin_simulation* simulation) {
  double time = 0;
  OK(elastin_time(simulation, &time));
  ((double*)context)[0] += 1;
  ((double*)context)[1] = time;
}

static void run_tasks(void* context, int count, elastin_task task, void* task_context) {
  int number;
  for (number = count - 1; number >= 0; --number) task(task_context, number);
  ++*(int*)context;
}

/* An observer that does what it must not. */
static void steps(void* context, const elastin_simulation* simulation) {
  union {
    const elastin_simulation* seen;
    elastin_simulation* own;
  } both;
  both.seen = simulation;
  *(elastin_status*)context = elastin_step(both.own, 1e-3, NULL);
}

static void hooks(void) {
  elastin_status inner = ELASTIN_OK;
  double seen[2] = {0, 0}, plain[3 * 36], run[3 * 36];
  int runs = 0;
  elastin_options options = {sizeof options, "velocity_verlet", 0, 0, NULL, 0, 0, NULL, NULL, 0, NULL, 0, 0};
  elastin_simulation* simulation = tissue(&options);
  OK(elastin_observe(simulation, 2, see, seen));
  OK(elastin_fix(simulation, 0, 4));
  OK(elastin_fix(simulation, 1, 0));
  steps_of(simulation, 5, plain);
  CHECK(seen[0] == 2 && fabs(seen[1] - 4e-3) < 1e-12);
  elastin_simulation_free(simulation);
  options.run = run_tasks, options.run_context = &runs;
  REFUSED(elastin_simulate(NULL, "lattice", &kSoft, &options, &simulation), "body is null");
  simulation = tissue(NULL);
  OK(elastin_observe(simulation, 1, steps, &inner));
  OK(elastin_step(simulation, 1e-3, NULL));
  CHECK(inner == ELASTIN_STOPPED);
  elastin_simulation_free(simulation);
  options.run_width = 3;
  simulation = tissue(&options);
  OK(elastin_fix(simulation, 0, 4));
  OK(elastin_fix(simulation, 1, 0));
  steps_of(simulation, 5, run);
  CHECK(memcmp(plain, run, sizeof run) == 0);
  elastin_simulation_free(simulation);
}

#ifdef ELASTIN_C_LAB
static void scenes(void) {
  char words[1024];
  const char* unknown[] = {"bdy=1"};
  const char *name = NULL, *unit = NULL, *cause = NULL;
  double modulus = 0, value = 0;
  size_t count = 0, i, found = 0;
  elastin_outcome outcome = -1;
  elastin_scene* scene = NULL;
  elastin_result* result = NULL;
  elastin_simulation* simulation = NULL;
  const double* numbers = NULL;
  twin_message(2, words, sizeof words);
  CHECK(elastin_scene_load(ELASTIN_SOURCE_DIR "/scenes/tension/table1-e.yaml", NULL, 0, &scene) == ELASTIN_WRONG_INPUT);
  CHECK(*words && strcmp(elastin_message(), words) == 0);
  twin_message(3, words, sizeof words);
  CHECK(elastin_scene_load(ELASTIN_SOURCE_DIR "/scenes/tension/table1-b.yaml", unknown, 1, &scene) != ELASTIN_OK);
  CHECK(*words && strcmp(elastin_message(), words) == 0 && scene == NULL);

  OK(elastin_scene_load(ELASTIN_SOURCE_DIR "/scenes/tension/table1-b.yaml", NULL, 0, &scene));
  OK(elastin_scene_run(scene, "angles", &result));
  OK(elastin_result_outcome(result, &outcome, &cause));
  CHECK(outcome == ELASTIN_CONVERGED && cause && !*cause);
  OK(elastin_result_get(result, "effective_modulus", &modulus));
  CHECK(modulus == twin_modulus() && fabs(modulus / 5000 - 1) < 0.5);
  OK(elastin_result_count(result, &count));
  for (i = 0; i < count; ++i) {
    OK(elastin_result_measure(result, i, &name, &unit, &value));
    if (strcmp(name, "effective_modulus") == 0) found += strcmp(unit, "Pa") == 0 && value == modulus;
  }
  CHECK(found == 1);
  OK(elastin_result_positions(result, &numbers, &count));
  CHECK(count == 3 * 27);
  OK(elastin_result_tensions(result, &numbers, &count));
  CHECK(count == 54);
  REFUSED(elastin_result_get(result, "efective_modulus", &value), "did you mean 'effective_modulus'");
  REFUSED(elastin_scene_run(scene, "angels", &result), "did you mean 'angles'");
  OK(elastin_scene_simulate(scene, NULL, NULL, &simulation));
  elastin_scene_free(scene);
  OK(elastin_step(simulation, 1e-5, NULL));
  elastin_simulation_free(simulation);
  elastin_result_free(result);
  elastin_scene_free(NULL);
  elastin_result_free(NULL);
}
#else
static void scenes(void) {
  elastin_scene* scene = NULL;
  CHECK(elastin_scene_load("a", NULL, 0, &scene) == ELASTIN_MISSING);
}
#endif

int main(void) {
  layout();
  strategies();
  constants();
  laws();
  unstable();
#ifdef ELASTIN_C_LAB
  described();
#endif
  bodies();
  drawing();
  rests();
  unstressed_lengths();
  derivatives();
  stepping();
  refusals();
  preparing();
  saving();
  hooks();
  scenes();
  return failures > 0;
}
