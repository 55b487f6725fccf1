/** Elastin for JavaScript. SI units; vectors are three numbers in a row: x0 y0 z0 x1 … */

type Numbers = ArrayLike<number>;
type Axis = 'x' | 'y' | 'z';

/** Wrong input, or a step that was not taken. */
export class ElastinError extends Error {
  /** Whether a step was not taken, for numerical trouble: the state stays as it was. */
  stopped?: boolean;
}

export interface Arrays {
  /** At rest [m], three numbers a molecule. */
  positions: Numbers;
  /** [kg] > 0; without them from `density` and the cells or the bounding box. */
  masses?: Numbers;
  /** [m] > 0; without them half the shortest connection. */
  radii?: Numbers;
  /** Two molecules each; without them the edges of the cells. */
  connections?: Numbers;
  /** [m] > 0, one a connection; without them the distances. */
  rest_lengths?: Numbers;
  /** Three molecules each. */
  triangles?: Numbers;
  /** Four molecules each. */
  tetrahedra?: Numbers;
  /** [kg/m³] > 0 where there are no masses. */
  density?: number;
  /** [m] > 0 of triangles where there are no masses. */
  thickness?: number;
  /** F_g of each tetrahedron (of sheets: triangle), nine numbers row by row: where it is unstressed; without it as it lies at rest. */
  growth?: Numbers;
}

export interface Material {
  /** E [Pa] > 0; 0 where it follows from a law. */
  youngs_modulus?: number;
  /** ν from −0.99 to 0.5; default 0.25, and where it follows from a law none. */
  poissons_ratio?: number;
  /** Of a membrane [m]. */
  thickness?: number;
  /** D [N m] of a sheet. */
  bending_rigidity?: number;
  /** A row of the table "material_laws" and its constants: {name: 'ogden', constants: {mu_1: 630, alpha_1: 1.3, …}}; a direction is [x, y, z]. */
  law?: {name: string; constants: Record<string, number | number[]>};
}

export interface Options {
  /** A row of the table "steppers"; default symplectic_euler. */
  stepper?: string;
  /** Share of the stable step that a part of an explicit step takes, from 1e-6 to 1; default 0.8. */
  safety?: number;
  /** Of a step; more, and it is not taken; default 1000. */
  max_substeps?: number;
  /** Of the strategy. */
  parameters?: Record<string, number>;
  /** Of the stepper: newton_iterations, … */
  stepper_parameters?: Record<string, number>;
}

/** What a row of a table takes: its range with its ends, and the value where none is given. */
export interface Parameter {
  name: string;
  unit: string;
  text: string;
  low: number;
  high: number;
  kind: 'number' | 'whole number' | 'vector' | 'direction' | 'molecules';
  required: boolean;
  default?: number;
}

/** @param wasm the bytes of elastin.wasm or its address; in node it is found next to this file. */
export function load(options?: {wasm?: Uint8Array | string | URL}): Promise<Elastin>;

export class Elastin {
  readonly version: string;
  /** What has a name: 'strategies', 'steppers', 'linear_solvers', 'loads' or 'material_laws'. */
  rows(table: string): {name: string; summary: string; parameters: Parameter[]}[];
  /** A box of counts[0] × counts[1] × counts[2] molecules, `spacing` [m] apart, density [kg/m³]. */
  lattice(counts: [number, number, number], spacing: number | [number, number, number],
          options: {connections?: ('axis' | 'face' | 'space')[]; density: number}): Body;
  body(arrays: Arrays): Body;
}

/** A body at rest. */
export class Body {
  /** [m]; a copy. */
  positions(): Float64Array;
  /** [kg], one a molecule; a copy. */
  masses(): Float64Array;
  /** Two molecules of each connection. */
  connections(): Int32Array;
  /** Three molecules of each triangle. */
  triangles(): Int32Array;
  /** Three molecules of each triangle of its surface, counter-clockwise seen from outside: what a renderer draws. */
  surface_triangles(): Int32Array;
  /** Spring constants [N/m] that a rule, also calibrated:RULE, gives each connection: what other engines take. */
  constants(strategy: string, material: Material, parameters?: Record<string, number>): Float64Array;
  /** A surface that is drawn with the body: points in its shape at rest, three numbers each, and three of their numbers a triangle. */
  surface(points: ArrayLike<number>, triangles: ArrayLike<number>): Surface;
  /** @param strategy a row of the table "strategies", with +volume, +wrinkling or calibrated: where it takes them. */
  simulate(strategy: string, material: Material, options?: Options): Simulation;
  free(): void;
}

/** As fine as a picture wants it: each point moves with the cell that holds it. */
export class Surface {
  /** Where its points are in a simulation of its body, and the unit normals there; views of the module's memory. */
  draw(simulation: Simulation): {points: Float32Array, normals: Float32Array};
  free(): void;
}

/** What a cut did. */
export interface Change {
  changed: boolean;
  split_molecules: number;
  removed_connections: number;
  removed_cells: number;
}

/** A body that moves. The arrays are views of the module's memory: read them at once, or copy them. */
export class Simulation {
  readonly time: number;
  /** What makes its results doubtful, a sentence each: pieces, cells given twice, mechanisms. Looks at the whole body. */
  readonly warnings: string[];
  /** [m]; to be set between steps where the body is to be elsewhere: velocities stay, and supports where they are. */
  get positions(): Float64Array;
  set positions(values: Numbers);
  /** [m/s] */
  readonly velocities: Float64Array;
  /** All forces on each molecule [N]. */
  readonly forces: Float64Array;
  /** Of each connection [N]; pulling is positive. */
  readonly tensions: Float64Array;
  /** The host's own forces [N], to be written: they act until they are changed. */
  readonly host_forces: Float64Array;
  /** A row of the table "loads", at any time between steps: add('gravity', {acceleration: [0, 0, -9.81]}), or {acceleration_z: -9.81}. */
  add(load: string, values?: Record<string, number | number[]>): number;
  /** Other values of a load, all of them, by the number that add gave. */
  set_load(load: number, values?: Record<string, number | number[]>): void;
  remove_load(load: number): void;
  /** Brings it forward by dt [s]. */
  step(dt: number): void;
  /** Goes to the equilibrium of all that acts now. One that has a direction of negative stiffness is unstable: the body leaves it. */
  settle(): {unstable: boolean};
  /** Connections and cells with a stiffness each, law after law. */
  readonly stiffness_count: number;
  /** About the equilibrium that settle() has found: from the derivatives of a function by positions and by reactions of held
   *  molecules, three numbers a molecule, those by forces on all molecules, by displacements of held ones, and by the
   *  logarithm of each stiffness. */
  vjp(of: {positions?: ArrayLike<number>, reactions?: ArrayLike<number>}):
    {forces: Float64Array, displacement: Float64Array, stiffness: Float64Array};
  /** How positions and reactions change along changes of these. */
  jvp(along: {forces?: ArrayLike<number>, displacement?: ArrayLike<number>, stiffness?: ArrayLike<number>}):
    {positions: Float64Array, reactions: Float64Array};
  /** The stiffness −d(all forces)/d(positions) [N/m] now, without supports: the 3 × 3 blocks of molecule a are those from starts[a]
   *  up to starts[a + 1], each in the column of its molecule, 9 numbers row by row. */
  stiffness(): {values: Float64Array, columns: Int32Array, starts: Int32Array};
  /** The slowest free vibrations about the present state, an equilibrium: frequencies [Hz], and shapes of unit modal mass. */
  vibrations(count?: number): {frequencies: Float64Array, shapes: Float64Array[]};
  /** These part the body in its present positions, between its cells. Molecules keep their numbers, and those that are split off
   *  come last; views must be requested again, and body() has the surface that is then to be drawn. */
  cut_plane(point: Numbers, normal: Numbers): Change;
  /** What a straight blade sweeps whose two ends, 6 numbers, go from one place to another. */
  cut_blade(from: ArrayLike<number>, to: ArrayLike<number>): Change;
  cut_triangles(points: ArrayLike<number>, triangles: ArrayLike<number>): Change;
  /** Where it is strained above this limit. */
  tear(strain: number): Change;
  /** Connections and cells by their numbers. */
  remove(what: {connections?: ArrayLike<number>, cells?: ArrayLike<number>}): Change;
  /** Of each molecule its number in the body that the simulation was made of. */
  readonly origin: Int32Array;
  /** A copy of the body as it is now; free() it. */
  body(): Body;
  /** Holds a molecule where it is, but for the axes that are free. */
  fix(molecule: number, free?: Axis | Axis[]): void;
  release(molecule: number): void;
  /** Where a held molecule is to be at the end of the next step [m]. */
  move_to(molecule: number, position: Numbers): void;
  /** Force of its support on a held molecule [N]. */
  reaction(molecule: number): [number, number, number];
  /** A spring [N/m] and damper [N s/m] from a molecule to a position; gives its number. */
  couple(molecule: number, position: Numbers, stiffness: number, damping: number): number;
  move_coupling(coupling: number, position: Numbers): void;
  coupling_force(coupling: number): [number, number, number];
  decouple(coupling: number): void;
  /** The state, to go on from bit by bit. */
  save(): Uint8Array;
  restore(bytes: Uint8Array): void;
  free(): void;
}

declare const elastin: {load: typeof load; Elastin: typeof Elastin; Body: typeof Body; Simulation: typeof Simulation;
                        ElastinError: typeof ElastinError};
export default elastin;
