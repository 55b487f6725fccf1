#pragma once
#include <stddef.h>

/* What the C++ face makes of the same: the last bit is compared. */
#ifdef __cplusplus
extern "C" {
#endif

enum { kTwinSteps = 40 };

/* A lattice of 3 x 3 x 4 molecules 1 mm apart, E = 5 kPa, one end held, the other pulled by a grip, weight, damping. */
typedef struct twin_run {
  double positions[3 * 36], velocities[3 * 36], forces[3 * 36], reaction[3], coupling_force[3];
  double tensions[512];
  size_t tension_count;
} twin_run;
void twin_step(twin_run* run);

/* Forces [N] after two steps of the lattice, or of a sheet of two triangles with bending stiffness, with a strategy;
 * Poisson's ratio 0.4, the last molecule pulled along z. */
enum { kTwinStrategies = 5 };
void twin_prepared(const char* strategy, int sheet, double* forces);

/* What the C++ face says, with the number: 0 a strategy that is not known, 1 a body that the strategy cannot run on, 2
 * a scene that is not there, 3 a scene with a key that is not known. */
void twin_message(int number, char* message, size_t capacity);

/* scenes/tension/table1-b.yaml with the strategy `angles`: its effective modulus [Pa]. */
double twin_modulus(void);

#ifdef __cplusplus
}
#endif
