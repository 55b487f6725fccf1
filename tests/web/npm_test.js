// The npm package of the core: node npm_test.js FOLDER, where its package.json is.
'use strict';
const assert = require('node:assert'), child = require('node:child_process'), fs = require('node:fs'), path = require('node:path');
const folder = path.resolve(process.argv[2]), {load, ElastinError, Body, Surface, Simulation, Elastin} = require(folder);
const near = (value, expected, tolerance) => assert(Math.abs(value - expected) <= tolerance * Math.abs(expected), `${value} for ${expected}`);

/** A weight on one spring: m g / k lower. */
function weight_on_a_spring(elastin) {
  const body = elastin.body({positions: [0, 0, 0, 0, 0, -0.1], connections: [0, 1], masses: [1, 0.5]});
  assert.deepStrictEqual([...body.constants('uniform', {youngs_modulus: 1e3}, {constant: 200})], [200]);
  const tissue = body.simulate('uniform', {youngs_modulus: 1e3}, {stepper: 'backward_euler', parameters: {constant: 200}});
  const weight = tissue.add('gravity', {acceleration: [0, 0, -1]});
  assert.throws(() => tissue.add('gravity', {acceleration: [0, -1]}), /acceleration has 2 numbers; it takes 3/);
  tissue.set_load(weight, {acceleration_z: -9.81});
  tissue.remove_load(tissue.add('gravity', {acceleration_z: -5}));
  assert.throws(() => tissue.remove_load(7), /no load 7/);
  tissue.fix(0);
  tissue.settle();
  near(tissue.positions[5], -0.1 - 0.5 * 9.81 / 200, 1e-9);
  near(tissue.reaction(0)[2], 0.5 * 9.81 + 9.81, 1e-6);
  near(tissue.tensions[0], 0.5 * 9.81, 1e-6);
  // z = -m g / k: dz/d(ln k) = m g / k, dz/dF = 1 / k.
  assert.strictEqual(tissue.stiffness_count, 1);
  const by = tissue.vjp({positions: [0, 0, 0, 0, 0, 1]});
  near(by.stiffness[0], 0.5 * 9.81 / 200, 1e-6), near(by.forces[5], 1 / 200, 1e-9), near(by.displacement[2], 1, 1e-9);
  near(tissue.jvp({stiffness: [1]}).positions[5], 0.5 * 9.81 / 200, 1e-6);
  assert.throws(() => tissue.vjp({positions: [1]}), /positions has 1 numbers; it needs 6/);
  // [k, -k; -k, k] along z; the weight swings along it with sqrt(k / m), and across it as a pendulum of g / length.
  const {values, columns, starts} = tissue.stiffness();
  assert.deepStrictEqual([[...columns], [...starts]], [[0, 1, 0, 1], [0, 2, 4]]);
  near(values[8], 200, 1e-9), near(values[17], -200, 1e-9);
  const {frequencies, shapes} = tissue.vibrations(3), swings = [9.81 / -tissue.positions[5], 9.81 / -tissue.positions[5], 200 / 0.5];
  swings.forEach((square, i) => near(frequencies[i], Math.sqrt(square) / (2 * Math.PI), 1e-4));
  near(Math.abs(shapes[2][5]), 1 / Math.sqrt(0.5), 1e-4);
  tissue.free();
  body.free();
}

/** The lattice rule is exact: a box that is pulled between sliding grips has E. */
function modulus_of_a_lattice(elastin) {
  const n = 5, h = 1e-2, E = 2e4, strain = 1e-6, body = elastin.lattice([n, n, n], h, {density: 1000});
  const tissue = body.simulate('lattice', {youngs_modulus: E, poissons_ratio: 0.25}, {stepper: 'backward_euler'});
  const rest = body.positions(), top = (n - 1) * h, ends = [];
  near(body.masses().length, n ** 3, 0);
  for (let m = 0; m < n ** 3; ++m)
    if (rest[3 * m + 2] < 1e-9 || rest[3 * m + 2] > top - 1e-9) ends.push(m), tissue.fix(m, ['x', 'y']);
  tissue.fix(0);
  tissue.fix(n - 1, 'x');
  for (const m of ends) if (rest[3 * m + 2] > 1e-9) tissue.move_to(m, [rest[3 * m], rest[3 * m + 1], top * (1 + strain)]);
  for (let i = 0; i < 30; ++i) tissue.step(10);
  let force = 0;
  for (const m of ends) if (rest[3 * m + 2] > 1e-9) force += tissue.reaction(m)[2];
  near(force / top ** 2 / strain, E, 1e-5);
}

/** A block that is cut in two: nothing is lost, and each half falls or stays by itself. */
function a_cut(elastin) {
  const body = elastin.lattice([5, 3, 3], 1e-2, {density: 1000});
  const tissue = body.simulate('lattice', {youngs_modulus: 1e4}, {stepper: 'backward_euler'});
  const mass = of => of.masses().reduce((sum, one) => sum + one, 0), before = body.surface_triangles().length;
  const report = tissue.cut_plane([0.015, 0.01, 0.01], [1, 0, 0]);
  assert(report.changed && report.split_molecules === 9, JSON.stringify(report));
  const halves = tissue.body();
  near(mass(halves), mass(body), 1e-12);
  assert.strictEqual(tissue.origin.length, 45 + 9);
  assert(halves.surface_triangles().length > before);
  body.positions().forEach((x, i) => { if (i % 3 === 0 && x === 0) tissue.fix(i / 3); });
  tissue.add('gravity', {acceleration: [0, 0, -9.81]});
  for (let i = 0; i < 10; ++i) tissue.step(1e-3);
  near(tissue.velocities[3 * 4 + 2], -9.81 * 1e-2, 1e-9);
  assert(!tissue.tear(1e3).changed);
  assert.throws(() => tissue.cut_blade([0, 0, 0], [1, 1, 1]), /6 numbers/);
  assert.throws(() => tissue.remove({connections: [0]}), /side of cells/);
  assert.strictEqual(tissue.remove({cells: [0]}).removed_cells, 1);
  [halves, tissue, body].forEach(one => one.free());
}

/** A triangle within a block moves with it, in single precision. */
function a_surface_that_is_drawn(elastin) {
  const body = elastin.lattice([3, 3, 3], 1e-2, {density: 1000});
  const surface = body.surface([0.005, 0.005, 0.005, 0.015, 0.005, 0.005, 0.005, 0.015, 0.005], [0, 1, 2]);
  const tissue = body.simulate('lattice', {youngs_modulus: 1e4}, {stepper: 'backward_euler'});
  tissue.add('gravity', {acceleration_z: -1});
  for (let i = 0; i < 10; ++i) tissue.step(0.01);
  const {points, normals} = surface.draw(tissue), fallen = tissue.positions[2];
  for (const at of [2, 5, 8]) near(points[at], 0.005 + fallen, 1e-5), near(normals[at], 1, 1e-5);
  assert.throws(() => body.surface([0, 0, 0], [0, 1, 2]), ElastinError);
  surface.free();
  tissue.free();
  body.free();
}

function a_cell_law_from_arrays(elastin) {
  const body = elastin.body({positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1].map(x => 0.01 * x), tetrahedra: [0, 1, 2, 3], density: 1000});
  assert.strictEqual(body.connections().length, 12);
  const tissue = body.simulate('mooney_rivlin', {law: {name: 'mooney_rivlin', constants: {c1: 1e3, c2: 500, bulk_modulus: 1e5}}});
  tissue.velocities.set([0.01, 0, 0]);
  tissue.step(1e-4);
  const state = tissue.save();
  for (let i = 0; i < 50; ++i) tissue.step(1e-4);
  const ahead = Array.from(tissue.positions), time = tissue.time;
  tissue.restore(state);
  near(tissue.time, 1e-4, 1e-12);
  for (let i = 0; i < 50; ++i) tissue.step(1e-4);
  assert.deepStrictEqual(Array.from(tissue.positions), ahead);
  assert.strictEqual(tissue.time, time);
}

/** A tetrahedron whose rest is larger than it lies becomes that large, from wherever it begins. */
function a_rest_of_its_own(elastin) {
  const corners = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1].map(x => 0.01 * x), cells = {positions: corners, tetrahedra: [0, 1, 2, 3], density: 1000};
  assert.throws(() => elastin.body({...cells, growth: [1, 0, 0]}), /growth must be 9 numbers each/);
  const body = elastin.body({...cells, growth: [1.1, 0, 0, 0, 1.2, 0, 0, 0, 1]});
  const tissue = body.simulate('neo_hookean', {youngs_modulus: 1e3});
  tissue.fix(0), tissue.fix(1, 'x'), tissue.fix(2, ['x', 'y']);
  tissue.positions = corners.map((x, i) => i === 11 ? 0.009 : x);
  assert.strictEqual(tissue.positions[11], 0.009);
  tissue.settle();
  near(tissue.positions[3], 0.011, 1e-6), near(tissue.positions[7], 0.012, 1e-6), near(tissue.positions[11], 0.01, 1e-6);
  assert.throws(() => { tissue.positions = [0, 0, 0]; }, /positions/);
}

function wrong_input(elastin) {
  const body = elastin.lattice([3, 3, 3], 0.1, {density: 1000});
  const says = (action, words) => assert.throws(action, problem => problem instanceof ElastinError && words.test(problem.message) || assert.fail(problem));
  says(() => body.simulate('standart', {youngs_modulus: 1e3}), /standard/);
  says(() => body.simulate('standard', {E: 1e3}), /no 'E'.*youngs_modulus/);
  says(() => body.simulate('standard', {youngs_modulus: -1}), /youngs_modulus/);
  says(() => elastin.lattice([3, 3, 3], 0.1, {density: 1000, connections: ['axes']}), /axis, face, space/);
  says(() => elastin.body({positions: [0, 0], density: 1}), /3 numbers each/);
  says(() => elastin.body({positions: [0, 0, 0, 1, 0, NaN], connections: [0, 1], density: 1}), /finite/);
  says(() => elastin.body({positions: [0, 0, 0, 1, 0, 0], connections: [0, 2], density: 1}), /2/);
  const tissue = body.simulate('standard', {youngs_modulus: 1e3});
  says(() => tissue.add('gravitation'), /gravity/);
  says(() => tissue.fix(27), /27/);
  says(() => tissue.fix(), /number of a molecule/);
  tissue.fix(0);
  says(() => tissue.move_to(0, [1, 2]), /three finite numbers/);
  const hook = tissue.couple(1, [0.1, 0, 0], 10, 0);
  says(() => tissue.move_coupling(hook, [0.1, 0]), /three finite numbers/);
  tissue.decouple(hook);
  says(() => tissue.coupling_force(hook), /taken off/);
  says(() => tissue.restore(new Uint8Array(3)), /./);
  tissue.host_forces[3] = 1e300;
  assert.throws(() => tissue.step(1), problem => problem.stopped);
}

/** ν is 0.25 where nothing is said, as in every other language: the same motion to the last bit. */
function poissons_ratio(elastin) {
  const body = elastin.lattice([3, 3, 3], 0.1, {density: 1000});
  const moved = material => {
    const tissue = body.simulate('lattice', material);
    tissue.velocities[0] = 0.1;
    tissue.step(1e-3);
    return Array.from(tissue.positions);
  };
  assert.deepStrictEqual(moved({youngs_modulus: 1e3}), moved({youngs_modulus: 1e3, poissons_ratio: 0.25}));
}

function warnings(elastin) {
  const body = elastin.body({positions: [0, 0, 0, 1, 0, 0, 3, 0, 0, 4, 0, 0], connections: [0, 1, 2, 3], density: 1000});
  assert.match(body.simulate('standard', {youngs_modulus: 1e3}).warnings[0], /not connected: 2 pieces/);
}

/** What the types name is there, and what is there they name. */
function types() {
  const text = fs.readFileSync(path.join(folder, 'index.d.ts'), 'utf8');
  for (const type of [Elastin, Body, Surface, Simulation]) {
    const part = text.match(new RegExp(`export class ${type.name} \\{([^]*?)\\n\\}`))[1];
    const named = [...part.matchAll(/^ {2}(?:readonly |[gs]et )?(\w+)[(:]/gm)].map(found => found[1]);
    const there = new Set();
    for (let one = type.prototype; one !== Object.prototype; one = Object.getPrototypeOf(one)) Object.getOwnPropertyNames(one).forEach(name => there.add(name));
    for (const name of named) assert(there.has(name), `${type.name} has no ${name}`);
    const own = {Elastin: ['handle_of'], Body: ['view'], Surface: ['elastin', 'handle'], Simulation: ['check', 'view', 'vector', 'read', 'number']}[type.name];
    for (const name of there) assert(name === 'constructor' || own.includes(name) || named.includes(name), `the types lack ${type.name}.${name}`);
  }
}

/** The example of the package's page runs as it stands: 1000 molecules that hang from one side. */
function example_of_the_page() {
  const shown = fs.readFileSync(path.join(folder, 'README.md'), 'utf8').match(/(?:^ {4}.*\n|^\n)+/gm).find(text => text.includes('import {load}'));
  const {status, stdout, stderr} = child.spawnSync('node', ['--input-type=module', '-e', shown], {cwd: folder, encoding: 'utf8'});
  assert(status === 0 && /Float64Array\(3\)/.test(stdout) && /'lattice'/.test(stdout), stderr || stdout);
}

(async () => {
  const elastin = await load();
  assert.match(elastin.version, /^\d+\.\d+/);
  assert(elastin.rows('steppers').some(row => row.name === 'newmark'));
  const divisor = elastin.rows('strategies').find(row => row.name === 'divided').parameters[0], gravity = elastin.rows('loads')[0].parameters;
  assert.deepStrictEqual([divisor.name, divisor.default, divisor.low, divisor.kind], ['divisor', 3.75, 1e-6, 'number']);
  assert.deepStrictEqual([gravity[0].name, gravity[0].kind, gravity[0].unit], ['acceleration', 'vector', 'm/s^2']);
  for (const check of [weight_on_a_spring, modulus_of_a_lattice, a_cut, a_surface_that_is_drawn, a_cell_law_from_arrays, a_rest_of_its_own, wrong_input, poissons_ratio, warnings, types, example_of_the_page]) check(elastin);
  const same = await import('file://' + path.join(folder, 'node.mjs'));
  assert.strictEqual(same.load, load);
})().catch(problem => {
  console.error(problem);
  process.exit(1);
});
