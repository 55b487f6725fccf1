/* Tissue that is touched by a moving tool and cut, from C: what changes, what stays, and what is refused. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elastin/c/elastin.h"

static int failures = 0;

static void check(int good, const char* what) {
  if (good) return;
  ++failures;
  printf("failed: %s (%s)\n", what, elastin_message());
}

#define OK(call) check((call) == ELASTIN_OK, #call)
#define REFUSED(call, words) check((call) == ELASTIN_WRONG_INPUT && strstr(elastin_message(), words), #call)

static const int counts[3] = {6, 6, 6};
static const double spacing[3] = {1e-3, 1e-3, 1e-3};

static elastin_simulation* lattice_of(const char* stepper) {
  elastin_body* body = NULL;
  elastin_simulation* tissue = NULL;
  elastin_material material = {0};
  elastin_options options = {0};
  int molecule;
  material.size = sizeof material;
  material.youngs_modulus = 1e4, material.poissons_ratio = 0.25;
  options.size = sizeof options;
  options.stepper = stepper;
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 1000, &body));
  OK(elastin_simulate(body, "lattice", &material, &options, &tissue));
  elastin_body_free(body);
  for (molecule = 0; molecule < 36; ++molecule) OK(elastin_fix(tissue, molecule, 0));
  return tissue;
}

static double total_mass_times_height(elastin_simulation* tissue) {
  const double* positions = NULL;
  size_t count = 0, i;
  double sum = 0;
  OK(elastin_positions(tissue, &positions, &count));
  for (i = 2; i < count; i += 3) sum += positions[i];
  return sum;
}

/* A ball comes down on the lattice; afterwards the lattice is cut, and a load is added. */
static void run(elastin_simulation* tissue, int from, int to, int tool) {
  int step;
  for (step = from; step < to; ++step) {
    const double at[3] = {2.5e-3, 2.5e-3, 8e-3 - 2e-5 * step};
    elastin_topology_report report = {0};
    const double point[3] = {2e-3, 0, 0}, normal[3] = {1, 0, 0};
    report.size = sizeof report;
    OK(elastin_move_tool(tissue, tool, at, NULL));
    if (step == 60) {
      OK(elastin_cut_plane(tissue, point, normal, &report));
      check(report.changed && report.split_molecules == 36 && report.molecules == 252, "36 molecules were split");
    }
    OK(elastin_step(tissue, 1e-3, NULL));
  }
}

/* A soft cube and a stiff one side by side, of which gravity makes the one hang further than the other. */
static void two_materials(void) {
  elastin_body *cube = NULL, *both = NULL;
  elastin_simulation* tissue = NULL;
  elastin_material soft = {0}, stiff = {0};
  const elastin_material* materials[2];
  elastin_part parts[2] = {{0}, {0}};
  elastin_options options = {0};
  const elastin_value down = {"acceleration_z", -9.81};
  const double* positions = NULL;
  int molecule;
  soft.size = stiff.size = sizeof soft, options.size = sizeof options;
  soft.youngs_modulus = 5e3, stiff.youngs_modulus = 5e4;
  soft.poissons_ratio = stiff.poissons_ratio = 0.25;
  materials[0] = &soft, materials[1] = &stiff;
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 1000, &cube));
  parts[0].size = parts[1].size = sizeof parts[0];
  parts[0].body = parts[1].body = cube;
  parts[0].name = "soft", parts[1].name = "stiff";
  parts[1].material = 1;
  OK(elastin_body_of_parts(parts, 2, &both));
  check(elastin_simulate_parts(both, "lattice", materials, 1, NULL, &tissue) == ELASTIN_WRONG_INPUT &&
            strstr(elastin_message(), "'stiff' has material 1"),
        "a material that is missing");
  OK(elastin_simulate_parts(both, "lattice", materials, 2, &options, &tissue));
  for (molecule = 180; molecule < 216; ++molecule) {
    OK(elastin_fix(tissue, molecule, 0));
    OK(elastin_fix(tissue, 216 + molecule, 0));
  }
  OK(elastin_add(tissue, "gravity", &down, 1));
  OK(elastin_settle(tissue, NULL));
  OK(elastin_positions(tissue, &positions, NULL));
  check(fabs(positions[2] / positions[3 * 216 + 2] - 10) < 0.2, "ten times as stiff hangs a tenth as far");
  elastin_simulation_free(tissue);
  elastin_body_free(both);
  elastin_body_free(cube);
}

/* Of an older header, without the last member: arrays of them lie by their own size. */
struct older_part {
  size_t size;
  const elastin_body* body;
  const char* name;
};
struct older_obstacle {
  size_t size;
  const char* shape;
  const elastin_value* sizes;
  size_t size_count;
  int tool;
  double position[3];
};

static void arrays_of_older_structures(void) {
  elastin_body *cube = NULL, *both = NULL;
  elastin_counts of_body = {0};
  struct older_part parts[2];
  elastin_simulation* tissue = lattice_of("backward_euler");
  const elastin_value radius = {"radius", 2e-3};
  struct older_obstacle balls[2];
  elastin_contact contact = {0};
  double force[3];
  int i;
  memset(parts, 0, sizeof parts), memset(balls, 0, sizeof balls);
  OK(elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 1000, &cube));
  for (i = 0; i < 2; ++i) {
    parts[i].size = sizeof parts[i], parts[i].body = cube, parts[i].name = i ? "second" : "first";
    balls[i].size = sizeof balls[i], balls[i].shape = "sphere", balls[i].sizes = &radius, balls[i].size_count = 1;
    balls[i].position[2] = i ? 6.5e-3 : 50e-3;
    balls[i].position[0] = balls[i].position[1] = 2.5e-3;
  }
  OK(elastin_body_of_parts((const elastin_part*)parts, 2, &both));
  of_body.size = sizeof of_body;
  OK(elastin_body_counts(both, &of_body));
  check(of_body.molecules == 432, "two parts of an older header");
  contact.size = sizeof contact;
  contact.obstacles = (const elastin_obstacle*)balls, contact.obstacle_count = 2;
  OK(elastin_add_contact(tissue, &contact));
  OK(elastin_step(tissue, 1e-3, NULL));
  OK(elastin_contact_force(tissue, 0, force));
  check(force[2] == 0, "the first ball is far away");
  OK(elastin_contact_force(tissue, 1, force));
  check(force[2] > 0, "the second one presses");
  balls[1].size = sizeof balls[1] - 8;
  REFUSED(elastin_add_contact(tissue, &contact), "in element 1 of an array");
  elastin_simulation_free(tissue);
  elastin_body_free(both);
  elastin_body_free(cube);
}

/* A weight on a spring of 200 N/m: its matrix, and what swings sideways as a pendulum and along with sqrt(k / m). */
static void matrices(void) {
  const double places[6] = {0, 0, 0, 0, 0, -0.1}, masses[2] = {1, 0.5};
  const int ends[2] = {0, 1};
  const elastin_value constant = {"constant", 200}, short_one = {"acceleration", 1};
  const elastin_value down[3] = {{"acceleration", 0}, {"acceleration", 0}, {"acceleration", -9.81}};
  elastin_arrays arrays = {0};
  elastin_material material = {0};
  elastin_options options = {0};
  elastin_body* body = NULL;
  elastin_simulation* weight = NULL;
  double values[36], frequencies[5], shapes[5 * 6];
  const double pi = acos(-1);
  int columns[4], starts[3];
  size_t blocks = 0, found = 0;
  arrays.size = sizeof arrays, material.size = sizeof material, options.size = sizeof options;
  arrays.positions = places, arrays.masses = masses, arrays.connections = ends;
  arrays.molecule_count = 2, arrays.connection_count = 1;
  material.youngs_modulus = 1e3;
  options.parameters = &constant, options.parameter_count = 1;
  OK(elastin_body_from_arrays(&arrays, &body));
  OK(elastin_simulate(body, "uniform", &material, &options, &weight));
  OK(elastin_fix(weight, 0, 0));
  REFUSED(elastin_add(weight, "gravity", &short_one, 1), "acceleration has 1 numbers; it takes 3");
  OK(elastin_add(weight, "gravity", down, 3));
  OK(elastin_settle(weight, NULL));
  OK(elastin_matrix_blocks(weight, &blocks));
  check(blocks == 4, "each molecule has a block with each");
  OK(elastin_matrix(weight, values, columns, starts));
  check(starts[2] == 4 && columns[1] == 1 && fabs(values[8] - 200) < 1e-6 && fabs(values[17] + 200) < 1e-6, "k and -k");
  OK(elastin_vibrations(weight, 5, frequencies, shapes, &found));
  check(found == 3, "three ways to swing");
  check(fabs(2 * pi * frequencies[0] - sqrt(9.81 / (0.1 + 0.5 * 9.81 / 200))) < 1e-3, "a pendulum");
  check(fabs(2 * pi * frequencies[2] - 20) < 1e-3 && fabs(fabs(shapes[2 * 6 + 5]) - sqrt(2)) < 1e-3, "a spring");
  elastin_simulation_free(weight);
  elastin_body_free(body);
}

int main(void) {
  elastin_simulation *tissue = lattice_of("backward_euler"), *other = lattice_of("backward_euler");
  const double above[3] = {2.5e-3, 2.5e-3, 8e-3};
  const elastin_value radius = {"radius", 2e-3}, wrong = {"radios", 2e-3};
  elastin_obstacle ball = {0};
  elastin_contact contact = {0};
  elastin_simulation* both[2];
  int tools[2], i;
  double force[3], torque[3];
  size_t bytes = 0, count = 0;
  char* saved;
  const int *origin = NULL, *surface = NULL;
  elastin_body* now = NULL;
  elastin_counts of_body = {0};
  both[0] = tissue, both[1] = other;
  ball.size = sizeof ball, contact.size = sizeof contact, of_body.size = sizeof of_body;
  ball.shape = "sphere", ball.sizes = &radius, ball.size_count = 1;
  contact.obstacles = &ball, contact.obstacle_count = 1;
  for (i = 0; i < 2; ++i) {
    OK(elastin_step(both[i], 1e-3, NULL)); /* contact comes at run time */
    OK(elastin_add_tool(both[i], above, NULL, &tools[i]));
    ball.tool = tools[i];
    OK(elastin_add_contact(both[i], &contact));
  }
  run(tissue, 0, 60, tools[0]);
  OK(elastin_contact_force(tissue, 0, force));
  check(force[2] > 0, "the lattice pushes the ball up");
  OK(elastin_contact_torque(tissue, 0, torque));
  check(fabs(torque[0]) + fabs(torque[1]) < 1e-9 * force[2], "a ball without friction is not turned");
  REFUSED(elastin_contact_force(tissue, 1, force), "obstacle 1: there are 1");
  run(tissue, 60, 80, tools[0]);
  OK(elastin_origin(tissue, &origin, &count));
  check(count == 252 && origin[0] == 0 && origin[216] < 216, "where molecules come from");
  OK(elastin_current_body(tissue, &now));
  OK(elastin_body_counts(now, &of_body));
  check(of_body.molecules == 252, "the body as it is now");
  OK(elastin_body_surface(now, &surface, &count));
  check(count == 3 * 2 * 25 * 8, "the cut has given the cube's six sides two more");
  elastin_body_free(now);

  OK(elastin_save(tissue, NULL, 0, &bytes));
  saved = malloc(bytes);
  OK(elastin_save(tissue, saved, bytes, &bytes));
  run(tissue, 80, 90, tools[0]);
  OK(elastin_restore(other, saved, bytes)); /* which was never cut */
  run(other, 80, 90, tools[1]);
  check(total_mass_times_height(other) == total_mass_times_height(tissue), "a cut is restored bitwise");
  free(saved);

  ball.sizes = &wrong;
  REFUSED(elastin_add_contact(tissue, &contact), "radios");
  ball.sizes = &radius, ball.shape = "spere";
  REFUSED(elastin_add_contact(tissue, &contact), "sphere");
  ball.shape = "sphere", ball.tool = 7;
  REFUSED(elastin_add_contact(tissue, &contact), "no tool 7");
  REFUSED(elastin_tear(tissue, -1, NULL), "strain of -1");
  REFUSED(elastin_cut_plane(tissue, above, (double[3]){0, 0, 0}, NULL), "normal");
  elastin_simulation_free(tissue);
  elastin_simulation_free(other);
  two_materials();
  arrays_of_older_structures();
  matrices();
  return failures != 0;
}
