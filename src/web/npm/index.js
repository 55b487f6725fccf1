// Elastin for JavaScript, in node and in browsers: bodies from arrays, stepped under loads, supports and a hand. What the
// C API has, with objects for handles and for structures; its header says more of every quantity. SI units; vectors are
// three numbers in a row: x0 y0 z0 x1 …
'use strict';
const make_module = require('./elastin.js'), {ElastinSimulation, ElastinError, Memory, call} = require('./face.js');

const patterns = {axis: 1, face: 2, space: 4}, axes = {x: 1, y: 2, z: 4};

/** Bits of names: `what` says of what in messages. */
function bits(names, known, what) {
  return [].concat(names).reduce((sum, name) => {
    if (!(name in known)) throw new ElastinError(`${what}: '${name}' is unknown; allowed: ${Object.keys(known).join(', ')}`);
    return sum | known[name];
  }, 0);
}

/** Refuses what is not among the known keys: a misspelt one must not become a default. */
function checked(given, known, what) {
  for (const key of Object.keys(given))
    if (!known.includes(key)) throw new ElastinError(`${what} has no '${key}'; it has: ${known.join(', ')}`);
  return given;
}

/** elastin_value[] of {name: number}, and their count; a list of numbers is the name once for each. */
function named_values(memory, values) {
  const rows = Object.entries(values).flatMap(([name, value]) => [].concat(value).map(one => [name, one]));
  const at = memory.room(16 * rows.length);
  rows.forEach(([name, value], i) => {
    memory.module.HEAPU32[at / 4 + 4 * i] = memory.text(name);
    memory.module.HEAPF64[at / 8 + 2 * i + 1] = value;
  });
  return [['word', rows.length ? at : 0], ['word', rows.length]];
}

/** The address of an array, 0 for none; every entry must be finite. */
function array(memory, values, what, whole) {
  if (values === undefined || values === null) return 0;
  if (!Array.prototype.every.call(values, Number.isFinite)) throw new ElastinError(`${what} must be finite numbers`);
  if (!whole) return memory.numbers(values);
  const at = memory.room(4 * values.length);
  memory.module.HEAP32.set(values, at / 4);
  return at;
}

/** Copies of the arrays of these lengths that a function of the C API fills; it is given numbers, or [array, its length] by names. */
function filled(simulation, name, given, lengths) {
  const {module, handle} = simulation;
  const out = new Memory(module);
  try {
    const rooms = lengths.map(length => out.room(8 * length));
    call(module, name, memory => {
      const takes = Object.entries(given).map(([what, one]) => {
        if (!Array.isArray(one)) return one;
        const [values, length] = one;
        if (values && values.length !== length) throw new ElastinError(`${what} has ${values.length} numbers; it needs ${length}`);
        return array(memory, values, what);
      });
      return [handle, ...takes, ...rooms];
    });
    return rooms.map((at, i) => module.HEAPF64.slice(at / 8, at / 8 + lengths[i]));
  } finally {
    out.release();
  }
}

/** A change of a simulation's topology, and what it did. */
function changed({module, handle}, name, arrange) {
  const out = new Memory(module);
  try {
    const at = out.structure(Array(6).fill(['whole', 0])) / 4;
    call(module, name, memory => [handle, ...arrange(memory), 4 * at]);
    const [changed, split_molecules, removed_connections, removed_cells] = module.HEAP32.slice(at + 1, at + 5);
    return {changed: changed !== 0, split_molecules, removed_connections, removed_cells};
  } finally {
    out.release();
  }
}

/** Of a law a direction [x, y, z] as C has it, a number for each axis. */
function by_axes(constants) {
  return Object.fromEntries(Object.entries(constants).flatMap(([name, value]) =>
    Array.isArray(value) ? value.map((one, axis) => [`${name}_${'xyz'[axis]}`, one]) : [[name, value]]));
}

/** elastin_material of the keys that a material has here. */
function material_of(memory, material) {
  checked(material, ['youngs_modulus', 'poissons_ratio', 'thickness', 'bending_rigidity', 'law'], 'a material');
  const {law, youngs_modulus = 0, poissons_ratio = law ? 0 : 0.25, thickness = 0, bending_rigidity = 0} = material;
  return memory.structure([['number', youngs_modulus], ['number', poissons_ratio], ['number', thickness],
    ['number', bending_rigidity],
    ['word', law ? memory.structure([['word', memory.text(law.name)], ...named_values(memory, by_axes(law.constants))]) : 0],
    ['word', 0]]);
}

class Elastin {
  constructor(module) {
    this.module = module;
    this.scratch = module._malloc(16);  // where answers are put; one call at a time
  }

  get version() { return this.module.UTF8ToString(this.module._elastin_version()); }

  /** A call whose last argument is where it puts a handle. */
  handle_of(name, arrange) {
    call(this.module, name, memory => [...arrange(memory), this.scratch]);
    return this.module.HEAPU32[this.scratch / 4];
  }

  rows(table) {
    const {module} = this, memory = new Memory(module);
    try {
      const name = memory.text(table), at = memory.room(64), one = at + 16, text = word => module.UTF8ToString(module.HEAPU32[word]);
      const check = status => { if (status) throw new ElastinError(module.UTF8ToString(module._elastin_message())); };
      check(module._elastin_row_count(name, at));
      return Array.from({length: module.HEAPU32[at / 4]}, (_, row) => {
        check(module._elastin_row(name, row, at, at + 4, at + 8));
        const parameters = Array.from({length: module.HEAPU32[at / 4 + 2]}, (_, number) => {
          module.HEAPU32[one / 4] = 48;
          check(module._elastin_row_parameter(name, row, number, one));
          const [low, high, fallback] = module.HEAPF64.slice(one / 8 + 2, one / 8 + 5), word = one / 4;
          return {name: text(word + 1), unit: text(word + 2), text: text(word + 3), low, high, kind: text(word + 10),
                  required: module.HEAP32[word + 11] !== 0, ...(Number.isNaN(fallback) ? {} : {default: fallback})};
        });
        return {name: text(at / 4), summary: text(at / 4 + 1), parameters};
      });
    } finally {
      memory.release();
    }
  }

  lattice(counts, spacing, options = {}) {
    const {connections = ['axis', 'face'], density} = checked(options, ['connections', 'density'], 'a lattice');
    const steps = [].concat(spacing), three = steps.length === 1 ? [steps[0], steps[0], steps[0]] : steps;
    return new Body(this, this.handle_of('elastin_lattice', memory => [array(memory, counts, 'counts', true),
      array(memory, three, 'spacing'), bits(connections, patterns, 'connections'), density]));
  }

  body(arrays) {
    checked(arrays, ['positions', 'masses', 'radii', 'connections', 'rest_lengths', 'triangles', 'tetrahedra', 'density',
      'thickness', 'growth'], 'a body');
    const {positions, masses, radii, connections, rest_lengths, triangles, tetrahedra, density = 0, thickness = 0, growth} = arrays;
    const count = (values, each, what) => {
      const length = values ? values.length : 0;
      if (length % each) throw new ElastinError(`${what} must be ${each} numbers each; there are ${length}`);
      return length / each;
    };
    const molecules = count(positions, 3, 'positions'), joined = count(connections, 2, 'connections');
    const many = (values, length, what) => {
      if (values && values.length !== length) throw new ElastinError(`${what} must be ${length} numbers; there are ${values.length}`);
    };
    many(masses, molecules, 'masses'), many(radii, molecules, 'radii'), many(rest_lengths, joined, 'rest_lengths');
    return new Body(this, this.handle_of('elastin_body_from_arrays', memory => [memory.structure([
      ['word', array(memory, positions, 'positions')], ['word', array(memory, masses, 'masses')], ['word', array(memory, radii, 'radii')],
      ['word', array(memory, connections, 'connections', true)], ['word', array(memory, rest_lengths, 'rest_lengths')],
      ['word', array(memory, triangles, 'triangles', true)], ['word', array(memory, tetrahedra, 'tetrahedra', true)],
      ['word', molecules], ['word', joined], ['word', count(triangles, 3, 'triangles')], ['word', count(tetrahedra, 4, 'tetrahedra')],
      ['number', density], ['number', thickness], ['word', array(memory, growth, 'growth')], ['word', count(growth, 9, 'growth')]])]));
  }
}

class Body {
  constructor(elastin, handle) {
    this.elastin = elastin;
    this.handle = handle;
  }

  view(what, heap) {
    const {module, scratch} = this.elastin, bytes = module[heap].BYTES_PER_ELEMENT;
    call(module, 'elastin_body_' + what, () => [this.handle, scratch, scratch + 4]);
    const at = module.HEAPU32[scratch / 4] / bytes;
    return module[heap].slice(at, at + module.HEAPU32[scratch / 4 + 1]);
  }

  positions() { return this.view('positions', 'HEAPF64'); }
  masses() { return this.view('masses', 'HEAPF64'); }
  connections() { return this.view('connections', 'HEAP32'); }
  triangles() { return this.view('triangles', 'HEAP32'); }
  surface_triangles() { return this.view('surface', 'HEAP32'); }

  surface(points, triangles) { return new Surface(this, points, triangles); }

  constants(strategy, material, parameters = {}) {
    const {module} = this.elastin, memory = new Memory(module), count = this.connections().length / 2;
    try {
      const at = memory.room(8 * count);
      call(module, 'elastin_strategy_constants', inner => {
        const [[, values], [, named]] = named_values(inner, parameters);
        return [this.handle, inner.text(strategy), material_of(inner, material), values, named, at, count];
      });
      return module.HEAPF64.slice(at / 8, at / 8 + count);
    } finally {
      memory.release();
    }
  }

  simulate(strategy, material, options = {}) {
    checked(options, ['stepper', 'safety', 'max_substeps', 'parameters', 'stepper_parameters', 'scheme', 'scheme_parameters'], 'options');
    const {scheme, scheme_parameters = {}} = options;  // former names
    const {stepper = scheme, safety = 0, max_substeps = 0, parameters = {}, stepper_parameters = scheme_parameters} = options;
    return new Simulation(this, this.elastin.handle_of('elastin_simulate', memory => [this.handle, memory.text(strategy),
      material_of(memory, material),
      memory.structure([['word', stepper ? memory.text(stepper) : 0], ['number', safety], ['whole', max_substeps],
        ...named_values(memory, parameters), ['whole', 0], ['word', 0], ['word', 0], ['whole', 0], ...named_values(memory, stepper_parameters)])]));
  }

  free() {
    this.elastin.module._elastin_body_free(this.handle);
    this.handle = 0;
  }
}

class Surface {
  constructor(body, points, triangles) {
    this.elastin = body.elastin;
    this.handle = this.elastin.handle_of('elastin_surface_make', memory => [body.handle, array(memory, points, 'points'), points.length / 3,
      array(memory, triangles, 'triangles', true), triangles.length / 3]);
    this.count = points.length;
    this.room = this.elastin.module._malloc(8 * this.count);
  }

  draw(simulation) {
    const {module} = this.elastin, at = this.room / 4, normals = this.room + 4 * this.count;
    call(module, 'elastin_surface_draw', () => [this.handle, simulation.handle, this.room, normals]);
    return {points: module.HEAPF32.subarray(at, at + this.count), normals: module.HEAPF32.subarray(at + this.count, at + 2 * this.count)};
  }

  free() {
    this.elastin.module._free(this.room);
    this.elastin.module._elastin_surface_free(this.handle);
    this.handle = 0;
  }
}

class Simulation extends ElastinSimulation {
  constructor(body, handle) {
    super(body.elastin.module, handle);
    this.elastin = body.elastin;
  }

  add(load, values = {}) {
    call(this.module, 'elastin_add_load', memory => {
      const [[, at], [, count]] = named_values(memory, values);
      return [this.handle, memory.text(load), at, count, this.scratch];
    });
    return this.module.HEAP32[this.scratch / 4];
  }

  set_load(load, values = {}) {
    call(this.module, 'elastin_set_load', memory => {
      const [[, at], [, count]] = named_values(memory, values);
      return [this.handle, load, at, count];
    });
  }

  remove_load(load) { this.check(this.module._elastin_remove_load(this.handle, load)); }

  fix(molecule, free = []) { super.fix(molecule, bits(free, axes, 'free')); }
  move_to(molecule, position) { this.check(this.module._elastin_move_to(this.handle, this.number(molecule), this.vector(position))); }

  reaction(molecule) {
    this.check(this.module._elastin_reaction(this.handle, this.number(molecule), this.scratch));
    return this.read(3);
  }

  get positions() { return this.view('positions'); }
  set positions(values) { call(this.module, 'elastin_set_positions', memory => [this.handle, array(memory, values, 'positions'), values.length]); }
  get velocities() { return this.view('velocities'); }
  get forces() { return this.view('forces'); }
  get tensions() { return this.view('tensions'); }
  get host_forces() { return this.view('host_forces'); }

  get stiffness_count() {
    this.check(this.module._elastin_stiffness_count(this.handle, this.scratch));
    return this.module.HEAPU32[this.scratch / 4];
  }

  vjp({positions, reactions} = {}) {
    const length = this.positions.length;
    const [forces, displacement, stiffness] = filled(this, 'elastin_vjp',
      {positions: [positions, length], reactions: [reactions, length]}, [length, length, this.stiffness_count]);
    return {forces, displacement, stiffness};
  }

  jvp({forces, displacement, stiffness} = {}) {
    const length = this.positions.length;
    const [positions, reactions] = filled(this, 'elastin_jvp', {forces: [forces, length],
      displacement: [displacement, length], stiffness: [stiffness, this.stiffness_count]}, [length, length]);
    return {positions, reactions};
  }

  stiffness() {
    const {module} = this, memory = new Memory(module), molecules = this.positions.length / 3;
    try {
      this.check(module._elastin_matrix_blocks(this.handle, this.scratch));
      const blocks = module.HEAPU32[this.scratch / 4];
      const values = memory.room(72 * blocks), columns = memory.room(4 * blocks), starts = memory.room(4 * (molecules + 1));
      this.check(module._elastin_matrix(this.handle, values, columns, starts));
      return {values: module.HEAPF64.slice(values / 8, values / 8 + 9 * blocks), columns: module.HEAP32.slice(columns / 4, columns / 4 + blocks),
              starts: module.HEAP32.slice(starts / 4, starts / 4 + molecules + 1)};
    } finally {
      memory.release();
    }
  }

  vibrations(count = 6) {
    const length = this.positions.length, most = Math.min(count, length);
    const [frequencies, shapes, found] = filled(this, 'elastin_vibrations', [most], [most, most * length, 1]);
    const many = new Uint32Array(found.buffer)[0];
    return {frequencies: frequencies.slice(0, many), shapes: Array.from({length: many}, (_, i) => shapes.slice(i * length, (i + 1) * length))};
  }

  cut_plane(point, normal) {
    return changed(this, 'elastin_cut_plane', () => [this.vector(point), this.vector(normal, this.scratch + 24)]);
  }

  cut_blade(from, to) {
    return changed(this, 'elastin_cut_blade', memory => [from, to].map(ends => {
      if (ends?.length !== 6) throw new ElastinError(`the ends of a blade are 6 numbers, not ${JSON.stringify(ends)}`);
      return array(memory, ends, 'ends of a blade');
    }));
  }

  cut_triangles(points, triangles) {
    return changed(this, 'elastin_cut_triangles', memory => [array(memory, points, 'points'), points.length / 3,
      array(memory, triangles, 'triangles', true), triangles.length / 3]);
  }

  tear(strain) { return changed(this, 'elastin_tear', () => [strain]); }

  remove({connections = [], cells = []}) {
    return changed(this, 'elastin_remove', memory => [array(memory, connections, 'connections', true), connections.length,
      array(memory, cells, 'cells', true), cells.length]);
  }

  get origin() {
    this.check(this.module._elastin_origin(this.handle, this.scratch, this.scratch + 4));
    const [at, count] = this.module.HEAPU32.subarray(this.scratch / 4, this.scratch / 4 + 2);
    return this.module.HEAP32.slice(at / 4, at / 4 + count);
  }

  body() { return new Body(this.elastin, this.elastin.handle_of('elastin_current_body', () => [this.handle])); }

  save() {
    this.check(this.module._elastin_save(this.handle, 0, 0, this.scratch));
    const count = this.module.HEAPU32[this.scratch / 4], at = this.module._malloc(count);
    try {
      this.check(this.module._elastin_save(this.handle, at, count, this.scratch));
      return this.module.HEAPU8.slice(at, at + count);
    } finally {
      this.module._free(at);
    }
  }

  restore(bytes) {
    const at = this.module._malloc(bytes.length);
    try {
      this.module.HEAPU8.set(bytes, at);
      this.check(this.module._elastin_restore(this.handle, at, bytes.length));
    } finally {
      this.module._free(at);
    }
  }
}

async function load({wasm} = {}) {
  let bytes = wasm;
  if (!bytes && typeof process !== 'undefined' && process.versions?.node)
    bytes = require('fs').readFileSync(require('path').join(__dirname, 'elastin.wasm'));
  else if (!bytes || typeof bytes === 'string' || bytes instanceof URL) {
    const answer = await fetch(bytes || 'elastin.wasm');
    if (!answer.ok) throw new ElastinError(`there is no ${answer.url}: give load({wasm}) its address or its bytes`);
    bytes = new Uint8Array(await answer.arrayBuffer());
  }
  return new Elastin(await make_module({wasmBinary: bytes}));
}

module.exports = {load, Elastin, Body, Simulation, Surface, ElastinError};
