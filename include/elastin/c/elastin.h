#pragma once
#include <stddef.h>

/* Elastin for C and whatever calls C: bodies of molecules joined by connections, that move or are measured.
 *
 *   elastin_body* body;  elastin_simulation* tissue;
 *   elastin_lattice((int[]){5, 5, 5}, (double[]){1e-3, 1e-3, 1e-3}, ELASTIN_AXIS | ELASTIN_FACE, 1000, &body);
 *   elastin_simulate(body, "lattice", &material, NULL, &tissue);
 *   while (…) elastin_step(tissue, 1e-3, NULL);
 *
 * Quantities are in SI units. Vectors are three numbers in a row: x0 y0 z0 x1 y1 z1 … Molecules, connections and cells
 * count from 0. What is given is copied; what is handed out belongs to its handle and lives as long as that. Every
 * function gives a status; any other than ELASTIN_OK leaves a sentence in elastin_message() and changes nothing. No
 * exception comes out of any. A handle serves one thread at a time, different handles as many as there are.
 * Structures begin with their own size, set by the caller, so that later versions can add to them; in an array of them
 * all have one size, and lie that far from each other. elastin_value has none, and nothing will be added to it. */

#if defined(_WIN32) && defined(ELASTIN_BUILDING_C)
#define ELASTIN_API __declspec(dllexport)
#elif defined(_WIN32)
#define ELASTIN_API __declspec(dllimport)
#elif defined(ELASTIN_BUILDING_C) && defined(__GNUC__)
#define ELASTIN_API __attribute__((visibility("default")))
#else
#define ELASTIN_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Grows where a program that was compiled with an older header would no longer work. */
#define ELASTIN_ABI 1
ELASTIN_API int elastin_abi(void);
ELASTIN_API const char* elastin_version(void); /* "0.2.0" */

typedef int elastin_status;
enum {
  ELASTIN_OK = 0,
  ELASTIN_WRONG_INPUT = 1, /* an argument, a file; the message says which */
  ELASTIN_STOPPED = 2,     /* a step that was not taken: numerical trouble is an outcome */
  ELASTIN_NO_MEMORY = 3,
  ELASTIN_MISSING = 4, /* this library was built without it */
  ELASTIN_FAULT = 5    /* of Elastin's own */
};
/* What the calling thread's last call that did not end with ELASTIN_OK said; until its next one. */
ELASTIN_API const char* elastin_message(void);

/* How many threads the loops over large bodies take; 0 = one a core. One where this is not called. Results have the
 * identical bits with any number. */
ELASTIN_API elastin_status elastin_set_threads(int threads);

/* How a step or a run ended. */
typedef int elastin_outcome;
enum {
  ELASTIN_CONVERGED = 0,
  ELASTIN_LIMIT_REACHED = 1,
  ELASTIN_INVERTED = 2,
  ELASTIN_DIVERGED = 3,
  ELASTIN_MECHANISM = 4,
  ELASTIN_INTERRUPTED = 5,
  ELASTIN_UNSUITED = 100 /* the strategy cannot run on this body; of runs alone */
};

/* ---- bodies ---- */
typedef struct elastin_body elastin_body;

typedef struct elastin_arrays {
  size_t size;                /* sizeof(elastin_arrays) */
  const double* positions;    /* [m], at rest, 3 * molecules */
  const double* masses;       /* [kg] > 0, one a molecule; null: from `density` and the cells or the convex hull */
  const double* radii;        /* [m] > 0, one a molecule; null: half the shortest connection */
  const int* connections;     /* pairs of molecules; null: the edges of the cells */
  const double* rest_lengths; /* [m] > 0, one a connection, as elastin_body_connections has them; null: the distances */
  const int* triangles;       /* three molecules each */
  const int* tetrahedra;      /* four molecules each; inverted where their volume is negative */
  size_t molecule_count, connection_count, triangle_count, tetrahedron_count;
  double density;   /* [kg/m^3] > 0 where masses is null */
  double thickness; /* [m] > 0 of triangles where masses is null */
  /* Where each cell is unstressed: F_g, nine numbers row by row a tetrahedron (of sheets: a triangle), growth_count
   * cells; null: as it lies at rest. All of it acts from the start. */
  const double* growth;
  size_t growth_count;
} elastin_arrays;
ELASTIN_API elastin_status elastin_body_from_arrays(const elastin_arrays* arrays, elastin_body** body);

/* Along what neighbours of a cubic lattice are joined; or-ed. */
enum { ELASTIN_AXIS = 1, ELASTIN_FACE = 2, ELASTIN_SPACE = 4 };
/* A cubic lattice of counts[0] * counts[1] * counts[2] molecules, spacing [m] along x, y, z, density [kg/m^3]. */
ELASTIN_API elastin_status elastin_lattice(const int counts[3], const double spacing[3], int pattern, double density,
                                           elastin_body** body);
/* A mesh file, of any kind that body.mesh of a scene reads, whose numbers are in `length_unit` [m]: 1e-3 of
 * millimetres. */
ELASTIN_API elastin_status elastin_body_from_mesh(const char* path, double length_unit, double density,
                                                  double thickness, elastin_body** body);
ELASTIN_API void elastin_body_free(elastin_body* body); /* null is allowed */

/* A part of a body that is put together from several. */
typedef struct elastin_part {
  size_t size;              /* sizeof(elastin_part) */
  const elastin_body* body; /* which is copied */
  const char* name;         /* of its own */
  int material;             /* its number in elastin_simulate_parts, from 0 */
  int rigid;                /* 1: bone, which has no stiffness and stays where it is unless something moves it */
} elastin_part;
ELASTIN_API elastin_status elastin_body_of_parts(const elastin_part* parts, size_t count, elastin_body** body);
/* Ties two parts where they are no more than `within` [m] apart: molecules that lie in one place become one, others are
 * tied to the other's surface with `stiffness` [Pa]. Numbers of molecules and connections change. */
ELASTIN_API elastin_status elastin_tie_parts(elastin_body*, const char* first, const char* second, double within,
                                             double stiffness);

typedef struct elastin_counts {
  size_t size; /* sizeof(elastin_counts) */
  size_t molecules, connections, triangles, tetrahedra;
} elastin_counts;
ELASTIN_API elastin_status elastin_body_counts(const elastin_body* body, elastin_counts* counts);
/* Positions at rest [m], 3 * molecules. */
ELASTIN_API elastin_status elastin_body_positions(const elastin_body* body, const double** positions, size_t* count);
/* [kg], one a molecule. */
ELASTIN_API elastin_status elastin_body_masses(const elastin_body* body, const double** masses, size_t* count);
/* Two molecules of each connection; three of each triangle: what a renderer draws. */
ELASTIN_API elastin_status elastin_body_connections(const elastin_body* body, const int** molecules, size_t* count);
ELASTIN_API elastin_status elastin_body_triangles(const elastin_body* body, const int** molecules, size_t* count);
/* The same of its surface, triangles counter-clockwise seen from outside: the faces of its tetrahedra, else of its
 * cubes (each cut in two), and its triangles. Found again by each call, which ends what the last one showed. */
ELASTIN_API elastin_status elastin_body_surface(const elastin_body* body, const int** molecules, size_t* count);

/* A surface that is drawn with a body and takes no part in its mechanics, as fine as a picture wants it: each of its
 * points (in the body's shape at rest [m], 3 * point_count) moves with the solid cell, or the lattice's cube, that
 * holds it or is nearest. Triangles have three numbers of points each, counter-clockwise seen from outside. */
typedef struct elastin_surface elastin_surface;
ELASTIN_API elastin_status elastin_surface_make(const elastin_body* body, const double* points, size_t point_count,
                                                const int* triangles, size_t triangle_count, elastin_surface** surface);
ELASTIN_API void elastin_surface_free(elastin_surface* surface);

/* ---- materials and strategies ---- */
/* A value by name, once in a list; of loads, vectors and molecules take a name as often as they have numbers. */
typedef struct elastin_value {
  const char* name;
  double value;
} elastin_value;

/* The constants of a law, SI: a row of the table "material_laws" and its values by name. A direction's numbers go by
 * NAME_x, NAME_y, NAME_z; those of the terms, counted from 1, by their columns: mu_1, alpha_1, mu_2 … of ogden, c_1 …
 * of yeoh; a word is a name with the value 1: volumetric_mixed, convention_abaqus. */
typedef struct elastin_law {
  size_t size; /* sizeof(elastin_law) */
  const char* name;
  const elastin_value* constants;
  size_t constant_count;
} elastin_law;

typedef struct elastin_material {
  size_t size;             /* sizeof(elastin_material) */
  double youngs_modulus;   /* E [Pa] > 0; 0 where it follows from a law */
  double poissons_ratio;   /* from -0.99 to 0.5; 0 where it follows from a law */
  double thickness;        /* t [m] of a membrane */
  double bending_rigidity; /* D [N m] of a sheet; 0 = no bending stiffness */
  const elastin_law* law;  /* null: none */
  /* null, or all of it as a scene says it under `material:`, in YAML: "{law: yeoh, terms: [1 kPa], bulk_modulus: 1 MPa,
   * relaxation: {terms: [[0.5, 1 s]]}}"; the numbers above are 0 then, and law is null. Needs ELASTIN_LAB. */
  const char* description;
} elastin_material;

/* Strategies by number from 0 to *count - 1: how connections get their stiffness. A name takes the endings "+volume"
 * and "+wrinkling" where the strategy can, and a rule's the beginning "calibrated:", which fits it to the material by
 * the body's homogenised stiffness: a body of tetrahedra, or a box. Any of the outputs may be null. */
ELASTIN_API elastin_status elastin_strategy_count(size_t* count);
ELASTIN_API elastin_status elastin_strategy(size_t number, const char** name, const char** summary,
                                            size_t* parameter_count);
typedef struct elastin_parameter {
  size_t size; /* sizeof(elastin_parameter) */
  const char *name, *unit, *text;
  double low, high, fallback; /* range, ends included, and what is taken where nothing is given; NaN: nothing */
  const char* kind;           /* "number", "whole number", "vector", "direction" or "molecules" */
  int required;               /* whether it must be given */
} elastin_parameter;
ELASTIN_API elastin_status elastin_strategy_parameter(size_t strategy, size_t number, elastin_parameter* parameter);

/* The constants [N/m] that a spring rule, also "calibrated:RULE", gives each of the `count` connections of a body: what
 * other engines take. A law of cells has none, and is refused. */
ELASTIN_API elastin_status elastin_strategy_constants(const elastin_body* body, const char* strategy,
                                                      const elastin_material* material, const elastin_value* parameters,
                                                      size_t parameter_count, double* constants, size_t count);

/* All that has names, row by row: table is "strategies", "steppers" (of elastin_options.stepper), "linear_solvers" (of
 * scenes), "loads" (of elastin_add) or "material_laws" (of elastin_law). */
ELASTIN_API elastin_status elastin_row_count(const char* table, size_t* count);
ELASTIN_API elastin_status elastin_row(const char* table, size_t number, const char** name, const char** summary,
                                       size_t* parameter_count);
ELASTIN_API elastin_status elastin_row_parameter(const char* table, size_t row, size_t number,
                                                 elastin_parameter* parameter);

/* ---- simulations ---- */
typedef struct elastin_simulation elastin_simulation;
/* Where the surface's points are now, in single precision, and the unit normals there: 3 * point_count numbers each;
 * normals may be null. Of a simulation of the surface's body; a cut ends that. */
ELASTIN_API elastin_status elastin_surface_draw(const elastin_surface* surface, const elastin_simulation* simulation,
                                                float* points, float* normals);

/* A host's task system: calls task(task_context, 0) to task(task_context, count - 1), each once, on any threads, and
 * comes back when all have ended. */
typedef void (*elastin_task)(void* task_context, int number);
typedef void (*elastin_run_tasks)(void* context, int count, elastin_task task, void* task_context);

typedef struct elastin_options {
  size_t size;                     /* sizeof(elastin_options) */
  const char* stepper;             /* of the table "steppers"; null: symplectic_euler */
  double safety;                   /* share of the stable step that a part of an explicit step takes; 0 = 0.8 */
  int max_substeps;                /* of a step; more: it is not taken; 0 = 1000 */
  const elastin_value* parameters; /* of the strategy */
  size_t parameter_count;
  int threads;           /* of loops over large bodies; 0 = as elastin_set_threads says. Bitwise identical with any */
  elastin_run_tasks run; /* runs them instead; null: nothing does */
  void* run_context;
  int run_width;                           /* number of tasks that a loop is split into, >= 1 */
  const elastin_value* stepper_parameters; /* "newton_iterations" of an implicit one … */
  size_t stepper_parameter_count;
  /* By the clock, what a step may take [s]; 0: any. Of steppers that take a number of sweeps or iterations: each step
   * gets as many as the pace of the steps before leaves time for; see elastin_effort. */
  double budget;
} elastin_options;

/* A body at rest that a strategy gives its stiffness; options null = all as said there. */
ELASTIN_API elastin_status elastin_simulate(const elastin_body* body, const char* strategy,
                                            const elastin_material* material, const elastin_options* options,
                                            elastin_simulation** simulation);
/* The same of a body of parts, each with the material of its number. Its topology cannot change. */
ELASTIN_API elastin_status elastin_simulate_parts(const elastin_body* body, const char* strategy,
                                                  const elastin_material* const* materials, size_t material_count,
                                                  const elastin_options* options, elastin_simulation** simulation);
ELASTIN_API void elastin_simulation_free(elastin_simulation* simulation); /* null is allowed */

/* What acts on it, at any time between steps: a row of the table "loads" by name, as scenes have it under `loads`. A
 * vector's numbers go by NAME_x, NAME_y, NAME_z (0 where they are left out), or by NAME three times: gravity takes
 * acceleration_z; of molecules, the name once for each. */
ELASTIN_API elastin_status elastin_add(elastin_simulation* simulation, const char* load, const elastin_value* values,
                                       size_t value_count);
/* The same, and gives its number, by which it gets other values (all of them) or is taken away from the next step on.
 */
ELASTIN_API elastin_status elastin_add_load(elastin_simulation* simulation, const char* load,
                                            const elastin_value* values, size_t value_count, int* number);
ELASTIN_API elastin_status elastin_set_load(elastin_simulation* simulation, int number, const elastin_value* values,
                                            size_t value_count);
ELASTIN_API elastin_status elastin_remove_load(elastin_simulation* simulation, int number);

typedef struct elastin_step_result {
  size_t size; /* sizeof(elastin_step_result) */
  elastin_outcome outcome;
  int substeps; /* in which the step had to go */
  int newton_iterations, linear_iterations;
  int unstable; /* of elastin_settle, 1: the equilibrium has a direction of negative stiffness, the body leaves it */
} elastin_step_result;
/* Brings it forward by dt > 0 [s]. ELASTIN_STOPPED: the state stays as it was and the message says why. Allocates
 * nothing after the first step, prints nothing, locks nothing. result may be null. */
ELASTIN_API elastin_status elastin_step(elastin_simulation* simulation, double dt, elastin_step_result* result);
/* Sweeps or iterations of the last step; 0 where the stepper takes no number of them. With a budget it differs from
 * step to step and from machine to machine: record it and pass it to set_effort to reproduce the run. */
ELASTIN_API elastin_status elastin_effort(const elastin_simulation*, int* effort);
/* From now on this count (>= 1), whatever the budget says: steps are then bitwise identical again. */
ELASTIN_API elastin_status elastin_set_effort(elastin_simulation*, int effort);
/* What so few of them would do to a next step by dt > 0 [s], which is tried and taken back: the largest distance of a
 * molecule from where backward Euler's balance to the end has it, and the largest distance that it goes there [m]. NaN
 * where one of the two fails. */
ELASTIN_API elastin_status elastin_iteration_error(elastin_simulation*, double dt, double* off, double* motion);
/* Goes to the equilibrium of all that acts now, at rest: a start. Couplings rest, too: their dampers have no part in
 * it, and their velocities are 0 until elastin_move_coupling gives others. One that is no minimum is left; `unstable`
 * says where that did not succeed. */
ELASTIN_API elastin_status elastin_settle(elastin_simulation* simulation, elastin_step_result* result);
ELASTIN_API elastin_status elastin_time(const elastin_simulation* simulation, double* time); /* [s] */

/* Derivatives about the equilibrium that elastin_settle has found, by one linear solve each. `molecules` arrays have
 * 3 numbers a molecule, `stiffness` ones elastin_stiffness_count of them: the logarithm of the stiffness of each
 * connection or cell, law after law. Inputs that are null are zero, outputs that are null are not wanted.
 * vjp: from dm/dx and dm/dR of a function m of positions and of reactions of held molecules, that by forces on all
 * molecules, by displacements of held ones, and by stiffness. jvp: how positions and reactions change along changes of
 * these. */
ELASTIN_API elastin_status elastin_stiffness_count(const elastin_simulation*, size_t* count);
ELASTIN_API elastin_status elastin_vjp(elastin_simulation*, const double* of_positions, const double* of_reactions,
                                       double* by_forces, double* by_displacement, double* by_stiffness);
ELASTIN_API elastin_status elastin_jvp(elastin_simulation*, const double* forces, const double* displacement,
                                       const double* stiffness, double* positions, double* reactions);

/* The stiffness -d(all forces)/d(positions) [N/m] now, supports not regarded, by rows of 3 x 3 blocks: the blocks of
 * molecule a are those from starts[a] up to starts[a + 1], ascending columns, 9 numbers each, row by row. For
 * elastin_matrix_blocks of them `values` has 9 numbers and `columns` one each, `starts` one more than molecules. */
ELASTIN_API elastin_status elastin_matrix_blocks(elastin_simulation*, size_t* blocks);
ELASTIN_API elastin_status elastin_matrix(elastin_simulation*, double* values, int* columns, int* starts);
/* The `count` slowest free vibrations about the present state, an equilibrium, or as many as there are, `found`:
 * frequencies [Hz], 0 of a mechanism and NaN where it is unstable, and shapes, 3 numbers a molecule, of unit modal mass
 * [1/sqrt(kg)]; may be null. */
ELASTIN_API elastin_status elastin_vibrations(elastin_simulation*, size_t count, double* frequencies, double* shapes,
                                              size_t* found);

/* Views: one address as long as the simulation lives and its topology stays; `count` numbers, may be null. */
ELASTIN_API elastin_status elastin_positions(const elastin_simulation*, const double** values, size_t* count); /* [m] */
/* Puts the molecules there [m], 3 * molecules numbers, between steps: a body may begin elsewhere than at rest.
 * Velocities stay, and supports where they are. */
ELASTIN_API elastin_status elastin_set_positions(elastin_simulation*, const double* positions, size_t count);
ELASTIN_API elastin_status elastin_velocities(const elastin_simulation*, const double** values,
                                              size_t* count); /* [m/s] */
/* All forces on each molecule [N]; of each connection [N], pulling is positive. */
ELASTIN_API elastin_status elastin_forces(const elastin_simulation*, const double** values, size_t* count);
ELASTIN_API elastin_status elastin_tensions(const elastin_simulation*, const double** values, size_t* count);
/* The host's own [N], to be written: they act from the next step on until they are changed. */
ELASTIN_API elastin_status elastin_host_forces(elastin_simulation*, double** values, size_t* count);

/* Holds a molecule where it is: in all directions (free_axes 0), or not along x (1), y (2), z (4); or-ed. */
ELASTIN_API elastin_status elastin_fix(elastin_simulation*, int molecule, int free_axes);
ELASTIN_API elastin_status elastin_release(elastin_simulation*, int molecule);
/* Where a held molecule is to be at the end of the next step [m]. */
ELASTIN_API elastin_status elastin_move_to(elastin_simulation*, int molecule, const double position[3]);
/* Force of its support on a held molecule [N]; zero where nothing holds it. */
ELASTIN_API elastin_status elastin_reaction(const elastin_simulation*, int molecule, double force[3]);

/* A spring (stiffness > 0 [N/m]) and damper (>= 0 [N s/m]) from a molecule to a position [m]: a tool, a mouse. */
ELASTIN_API elastin_status elastin_couple(elastin_simulation*, int molecule, const double position[3], double stiffness,
                                          double damping, int* coupling);
ELASTIN_API elastin_status elastin_move_coupling(elastin_simulation*, int coupling, const double position[3],
                                                 const double velocity[3]); /* velocity [m/s] may be null */
/* On the molecule [N]. Under newmark and energy_momentum that of a stiff coupling swings about its mean from one step
 * to the next, where the step is long for the coupling's own vibration: take backward_euler or generalized_alpha there.
 */
ELASTIN_API elastin_status elastin_coupling_force(const elastin_simulation*, int coupling, double force[3]);
ELASTIN_API elastin_status elastin_decouple(elastin_simulation*, int coupling);

/* A rigid thing that the host moves, an instrument, by a number from 1. turn: rotation, row by row; null: none. */
ELASTIN_API elastin_status elastin_add_tool(elastin_simulation*, const double position[3], const double turn[9],
                                            int* tool);
/* Where it is to be at the end of the next step: it goes there at constant speed and spin, and stays; null: unturned.
 */
ELASTIN_API elastin_status elastin_move_tool(elastin_simulation*, int tool, const double position[3],
                                             const double turn[9]);

/* A rigid thing that the body cannot pass. */
typedef struct elastin_obstacle {
  size_t size;                /* sizeof(elastin_obstacle) */
  const char* shape;          /* "plane" (z < 0), "box", "sphere", "cylinder" or "capsule", about its own origin */
  const elastin_value* sizes; /* [m] > 0: x, y, z of a box; radius; radius and length along z */
  size_t size_count;
  int tool;           /* that moves it; 0: it stays where `position` and `turn` say */
  double position[3]; /* [m] */
  double turn[9];     /* rotation, row by row; all zero: none */
} elastin_obstacle;

typedef struct elastin_contact {
  size_t size;        /* sizeof(elastin_contact) */
  int spheres;        /* 1: of its molecules' spheres, which a cut leaves without a force; 0: of its surface */
  double stiffness;   /* pressure over depth [Pa/m]; 0: ten times E over a molecule's diameter */
  double friction;    /* Coulomb's, >= 0 */
  double restitution; /* 0.01 to 1; 0 = 1, no damping */
  double penetration; /* largest depth that may remain [m]; 0: what the stiffness leaves */
  int self;           /* whether a piece touches itself */
  const elastin_obstacle* obstacles;
  size_t obstacle_count;
} elastin_contact;
/* Contact with obstacles and between pieces, at any time between steps. */
ELASTIN_API elastin_status elastin_add_contact(elastin_simulation*, const elastin_contact* contact);
/* Force of the body on an obstacle [N], counted through all that elastin_add_contact was given, from 0. */
ELASTIN_API elastin_status elastin_contact_force(const elastin_simulation*, size_t obstacle, double force[3]);
/* The same of its torque [N m], about where the obstacle, or its tool, is now. */
ELASTIN_API elastin_status elastin_contact_torque(const elastin_simulation*, size_t obstacle, double torque[3]);

/* ---- topology ---- */
typedef struct elastin_topology_report {
  size_t size; /* sizeof(elastin_topology_report) */
  int changed; /* 0: nothing was split */
  int split_molecules, removed_connections, removed_cells;
  size_t molecules, connections; /* of the body now */
} elastin_topology_report;
/* These part the body in its present positions, between its cells, or between molecules where it has none: a body of
 * tetrahedra, a lattice, a sheet of triangles, springs. Volume and mass stay. Molecules keep their numbers, those that
 * were split off come last. Views must be requested again: earlier ones are no longer valid. The next step takes
 * longer. report may be null. ELASTIN_WRONG_INPUT, and nothing changed, where something cannot follow: the message says
 * what. */
ELASTIN_API elastin_status elastin_cut_plane(elastin_simulation*, const double point[3], const double normal[3],
                                             elastin_topology_report* report);
/* What a straight blade sweeps whose two ends go from one position to another: 6 numbers [m] each. */
ELASTIN_API elastin_status elastin_cut_blade(elastin_simulation*, const double from[6], const double to[6],
                                             elastin_topology_report* report);
/* Triangles of points [m]: 3 numbers, and 3 corners, each. */
ELASTIN_API elastin_status elastin_cut_triangles(elastin_simulation*, const double* points, size_t point_count,
                                                 const int* triangles, size_t triangle_count,
                                                 elastin_topology_report* report);
/* Parts it where it is strained above `strain` > 0; a crack through cells grows by one molecule a call. */
ELASTIN_API elastin_status elastin_tear(elastin_simulation*, double strain, elastin_topology_report* report);
/* Removes connections and cells by number, with the cells' mass; molecules that lose all are gone, and those behind
 * them are renumbered. */
ELASTIN_API elastin_status elastin_remove(elastin_simulation*, const int* connections, size_t connection_count,
                                          const int* cells, size_t cell_count, elastin_topology_report* report);
/* Of each molecule its number in the body that the simulation was made of: a view. */
ELASTIN_API elastin_status elastin_origin(const elastin_simulation*, const int** molecules, size_t* count);
/* A copy of the body as it is now, to be freed: what a renderer draws after a cut. */
ELASTIN_API elastin_status elastin_current_body(const elastin_simulation*, elastin_body** body);

/* What makes its results doubtful, a line each, "" for nothing: pieces, cells given twice, negative spring constants,
 * mechanisms, cells that lock, a missing thickness, a budget that is not kept. Looks at the whole body: not for every
 * step. */
ELASTIN_API elastin_status elastin_warnings(elastin_simulation* simulation, const char** text);

/* Calls `see` after every `every` steps that succeeded, with the simulation and the context; it must not step. */
typedef void (*elastin_observer)(void* context, const elastin_simulation* simulation);
ELASTIN_API elastin_status elastin_observe(elastin_simulation*, int every, elastin_observer see, void* context);

/* The state, to go on from, bitwise identically: *needed bytes. Without room for them (buffer may be null) only *needed
 * is set, and the status is ELASTIN_WRONG_INPUT unless capacity is 0. Read back on the same kind of machine alone. */
ELASTIN_API elastin_status elastin_save(const elastin_simulation*, void* buffer, size_t capacity, size_t* needed);
/* Refuses what another body's molecules at rest, or the sum of its spring constants before a cut, show to be its; other
 * materials, connections and cells are not noticed. */
ELASTIN_API elastin_status elastin_restore(elastin_simulation*, const void* buffer, size_t bytes);

/* ---- scenes ---- */
typedef struct elastin_scene elastin_scene;
typedef struct elastin_result elastin_result;
/* A scene file with overrides "key.path=value", as the command's --set. */
ELASTIN_API elastin_status elastin_scene_load(const char* path, const char* const* overrides, size_t override_count,
                                              elastin_scene** scene);
ELASTIN_API void elastin_scene_free(elastin_scene* scene); /* null is allowed */
/* Its experiment with a strategy by name (calibrated:angles, lattice+volume); null = the scene's own. A run that
 * stopped is a result: see its outcome. */
ELASTIN_API elastin_status elastin_scene_run(elastin_scene* scene, const char* strategy, elastin_result** result);
/* The body with its loads, held and loaded in full as the experiment does it, to be stepped. It may outlive the scene.
 */
ELASTIN_API elastin_status elastin_scene_simulate(elastin_scene* scene, const char* strategy,
                                                  const elastin_options* options, elastin_simulation** simulation);

ELASTIN_API void elastin_result_free(elastin_result* result); /* null is allowed */
/* Why it stopped, "" if it did not; both outputs may be null. */
ELASTIN_API elastin_status elastin_result_outcome(const elastin_result*, elastin_outcome* outcome, const char** cause);
/* Measures by number, and one by name; a name that was not measured is ELASTIN_WRONG_INPUT. */
ELASTIN_API elastin_status elastin_result_count(const elastin_result*, size_t* measures);
ELASTIN_API elastin_status elastin_result_measure(const elastin_result*, size_t number, const char** name,
                                                  const char** unit, double* value);
ELASTIN_API elastin_status elastin_result_get(const elastin_result*, const char* measure, double* value);
ELASTIN_API elastin_status elastin_result_positions(const elastin_result*, const double** values, size_t* count);
ELASTIN_API elastin_status elastin_result_tensions(const elastin_result*, const double** values, size_t* count);

#ifdef __cplusplus
}
#endif
