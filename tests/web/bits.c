/* Steps bodies a thousand times (a hundred by implicit steppers) and prints a checksum of what comes out, bit by bit: bits.js does the same in the
 * module for browsers, and the lines must be the same.
 *
 *   bits [steps]      one line a case: body, strategy, stepper, checksum of positions and velocities */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elastin/c/elastin.h"

static void need(elastin_status status) {
  if (status == ELASTIN_OK) return;
  fprintf(stderr, "%s\n", elastin_message());
  exit(1);
}

/* FNV-1a of 32-bit halves, so that a language without 64-bit numbers can do it too. */
static uint32_t checksum(const double* values, size_t count, uint32_t sum) {
  const size_t words = 2 * count;
  uint32_t* halves = malloc(4 * words + 4);
  memcpy(halves, values, 4 * words);
  for (size_t i = 0; i < words; ++i) sum = (sum ^ halves[i]) * 16777619u;
  free(halves);
  return sum;
}

static elastin_body* lattice(void) {
  elastin_body* body;
  need(elastin_lattice((int[]){6, 5, 4}, (double[]){0.1, 0.1, 0.1}, ELASTIN_AXIS | ELASTIN_FACE, 1000, &body));
  return body;
}

/* 3 x 3 x 3 cubes of six tetrahedra each, along the diagonal from corner 0 to corner 7. */
static elastin_body* tetrahedra(void) {
  static double positions[3 * 64];
  static int cells[4 * 6 * 27];
  static const int order[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
  int count = 0;
  for (int m = 0; m < 64; ++m)
    for (int axis = 0; axis < 3; ++axis) positions[3 * m + axis] = 0.1 * (m >> 2 * axis & 3);
  for (int cube = 0; cube < 27; ++cube)
    for (int t = 0; t < 6; ++t) {
      const int corners[4] = {0, order[t][0], order[t][1], 7};
      for (int c = 0; c < 4; ++c)
        cells[count++] = cube % 3 + (corners[c] & 1) + 4 * (cube / 3 % 3 + (corners[c] >> 1 & 1)) +
                         16 * (cube / 9 + (corners[c] >> 2));
    }
  elastin_arrays arrays = {sizeof arrays};
  arrays.positions = positions, arrays.molecule_count = 64;
  arrays.tetrahedra = cells, arrays.tetrahedron_count = 6 * 27;
  arrays.density = 1000;
  elastin_body* body;
  need(elastin_body_from_arrays(&arrays, &body));
  return body;
}

static void run(const char* name, const elastin_body* body, const char* strategy, const char* stepper, int steps) {
  const elastin_material material = {sizeof material, 1e5, 0.25, 0, 0, NULL, NULL};
  elastin_options options = {sizeof options};
  options.stepper = stepper;
  elastin_simulation* tissue;
  if (elastin_simulate(body, strategy, &material, &options, &tissue) != ELASTIN_OK) return; /* it does not suit */
  const double *positions, *velocities;
  size_t count;
  need(elastin_body_positions(body, &positions, &count));
  for (size_t m = 0; m < count / 3; ++m)
    if (positions[3 * m + 2] == 0) need(elastin_fix(tissue, (int)m, 0));
  const elastin_value down[] = {{"acceleration_x", 2.5}, {"acceleration_z", -9.81}};
  need(elastin_add(tissue, "gravity", down, 2));
  /* Explicit steps cost little: those that solve or sweep are as many times fewer as they cost more. */
  const int is_explicit = strcmp(stepper, "velocity_verlet") == 0 || strcmp(stepper, "symplectic_euler") == 0;
  const int taken = is_explicit ? steps : steps / 10;
  for (int i = 0; i < taken; ++i) need(elastin_step(tissue, 2e-3, NULL));
  need(elastin_positions(tissue, &positions, &count));
  need(elastin_velocities(tissue, &velocities, &count));
  uint32_t sum = checksum(positions, count, 2166136261u);
  sum = checksum(velocities, count, sum);
  printf("%s %s %s %08x\n", name, strategy, stepper, sum);
  elastin_simulation_free(tissue);
}

int main(int argc, char** argv) {
  const int steps = argc > 1 ? atoi(argv[1]) : 1000;
  elastin_body* bodies[] = {lattice(), tetrahedra()};
  const char* names[] = {"lattice", "tetrahedra"};
  size_t strategies, steppers;
  need(elastin_strategy_count(&strategies));
  need(elastin_row_count("steppers", &steppers));
  for (int b = 0; b < 2; ++b)
    for (size_t s = 0; s < strategies; ++s)
      for (size_t k = 0; k < steppers; ++k) {
        const char *strategy, *stepper;
        need(elastin_strategy(s, &strategy, NULL, NULL));
        need(elastin_row("steppers", k, &stepper, NULL, NULL));
        run(names[b], bodies[b], strategy, stepper, steps);
      }
  for (int b = 0; b < 2; ++b) elastin_body_free(bodies[b]);
  return 0;
}
