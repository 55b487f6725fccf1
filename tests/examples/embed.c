/* A block of soft tissue hangs from its upper face and is pulled aside by a tool: what a simulator does in C. */
#include <math.h>
#include <stdio.h>

#include "elastin/c/elastin.h"

static int stop(void) {
  fprintf(stderr, "%s\n", elastin_message());
  return 1;
}

int main(void) {
  const int counts[3] = {5, 5, 9};
  const double spacing[3] = {2.5e-3, 2.5e-3, 2.5e-3}; /* [m] */
  const elastin_material fat = {sizeof fat, 5000 /* Pa */, 0.25, 0, 0, NULL, NULL};
  const elastin_value weight[] = {{"acceleration_z", -9.81}}, drag[] = {{"mass", 10}};
  elastin_body* body = NULL;
  elastin_simulation* tissue = NULL;
  const double *positions, *tensions;
  double force[3], greatest = 0;
  size_t connections, i;
  int tool;

  if (elastin_lattice(counts, spacing, ELASTIN_AXIS | ELASTIN_FACE, 950 /* kg/m^3 */, &body) ||
      elastin_simulate(body, "lattice", &fat, NULL, &tissue) || elastin_add(tissue, "gravity", weight, 1) ||
      elastin_add(tissue, "rayleigh", drag, 1) || elastin_positions(tissue, &positions, NULL))
    return stop();
  for (i = 200; i < 225; ++i)
    if (elastin_fix(tissue, (int)i, 0)) return stop();
  if (elastin_couple(tissue, 12, positions + 3 * 12, 20 /* N/m */, 0.05 /* N s/m */, &tool)) return stop();

  for (i = 0; i < 500; ++i) { /* half a second at 1 kHz; `positions` shows each state */
    const double at[3] = {5e-3 + 1e-5 * (double)i, 5e-3, 0};
    if (elastin_move_coupling(tissue, tool, at, NULL) || elastin_step(tissue, 1e-3, NULL)) return stop();
  }
  if (elastin_coupling_force(tissue, tool, force) || elastin_tensions(tissue, &tensions, &connections)) return stop();
  for (i = 0; i < connections; ++i) greatest = fmax(greatest, tensions[i]);
  printf("the tool pulls with %.2f mN; the greatest tension is %.2f mN\n", 1e3 * force[0], 1e3 * greatest);
  elastin_simulation_free(tissue);
  elastin_body_free(body);
  return 0;
}
