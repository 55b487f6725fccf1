#pragma once
#include "elastin/c/elastin.h"

/* What the lab in a browser needs in addition to the C API: a scene's body from the bytes that the command has put into
 * the page, simulations of it under a hand, and the tension test of the laboratory. The rules of elastin.h hold. */

#ifdef __cplusplus
extern "C" {
#endif

typedef struct elastin_lab elastin_lab;
/* From the bytes of a parcel; see src/lab/live/parcel.h. They are copied. */
ELASTIN_API elastin_status elastin_lab_open(const void* bytes, size_t count, elastin_lab** lab);
ELASTIN_API void elastin_lab_free(elastin_lab* lab);

/* What the sliders say. */
typedef struct elastin_lab_settings {
  size_t size;            /* sizeof(elastin_lab_settings) */
  const char* strategy;   /* a label of the scene's, or a name of the catalog */
  const char* stepper;    /* of the table "steppers" */
  int newton_iterations;  /* of backward_euler in each step; 0: until it converges */
  double youngs_modulus;  /* E [Pa] > 0: that of a law with constants of its own scales them all */
  double poissons_ratio;  /* of a material that has one */
  double density;         /* [kg/m^3] > 0: multiplies all masses */
  double bulk_viscosity;  /* phi [Pa s] >= 0 of cells [Labelle 2003] */
  double shear_viscosity; /* psi [Pa s] >= 0 */
  double mass_damping;    /* alpha [1/s] >= 0: F = -alpha M V */
  double pressure;        /* [Pa] inside a closed body of triangles */
} elastin_lab_settings;

/* The body with the scene's loads, held as its experiment holds it, where it begins, at rest. */
ELASTIN_API elastin_status elastin_lab_simulate(const elastin_lab* lab, const elastin_lab_settings* settings,
                                                elastin_simulation** simulation);
/* Gives `to` the positions, velocities and the time of `from`: another strategy on the same body goes on from there. */
ELASTIN_API elastin_status elastin_lab_carry(const elastin_simulation* from, elastin_simulation* to);
/* The longest stable step of an explicit stepper about rest [s], with nothing held. */
ELASTIN_API elastin_status elastin_lab_stable_step(elastin_simulation* simulation, double* step);
/* The host's forces from the next step on: gravity [m/s^2] on all molecules, `own_load` times the load of the scene's
 * experiment, and a probe: a sphere at `centre` of `radius` [m] that pushes what is inside it out, `stiffness` [N/m]
 * times how deep it is; 0 = none. The force on the probe [N] comes back. */
ELASTIN_API elastin_status elastin_lab_push(const elastin_lab* lab, elastin_simulation* simulation,
                                            const double gravity[3], double own_load, const double centre[3],
                                            double radius, double stiffness, double force[3]);
/* Kinetic and elastic energy [J]. */
ELASTIN_API elastin_status elastin_lab_energies(const elastin_simulation* simulation, double energies[2]);
/* Von Mises stress at each molecule [Pa], of the mean stress of its share of the body, 1/V sum of q d d^T over the
 * halves of its connections, q their force densities. */
ELASTIN_API elastin_status elastin_lab_stress(const elastin_lab* lab, elastin_simulation* simulation, double density,
                                              double* values);

/* A tension test: first as the scene has it, then drawn on to `strain`. */
typedef struct elastin_lab_test elastin_lab_test;
ELASTIN_API elastin_status elastin_lab_test_begin(const elastin_lab* lab, const elastin_lab_settings* settings,
                                                  double strain, int steps, elastin_lab_test** test);
typedef struct elastin_lab_reading {
  size_t size; /* sizeof(elastin_lab_reading) */
  int own;     /* 1: a step of the test as it is; 2: its last; 0: drawn on */
  int last;    /* whether it was the last step */
  int of_law;  /* whether the targets are those of the law on cells */
  double strain, stress, effective_modulus, poissons_ratio; /* ratio: NaN where it cannot be read */
  double target_modulus, target_ratio; /* of the material at this strain, at the last step of own = 2; else NaN */
} elastin_lab_reading;
/* The next step. ELASTIN_STOPPED: no equilibrium, and the test is over; the message says why. */
ELASTIN_API elastin_status elastin_lab_test_step(elastin_lab_test* test, elastin_lab_reading* reading);
ELASTIN_API elastin_status elastin_lab_test_positions(const elastin_lab_test* test, const double** values,
                                                      size_t* count);
ELASTIN_API elastin_status elastin_lab_test_tensions(elastin_lab_test* test, const double** values, size_t* count);
ELASTIN_API void elastin_lab_test_free(elastin_lab_test* test);

#ifdef __cplusplus
}
#endif
