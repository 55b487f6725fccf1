// Elastin for JavaScript: the module's C functions as two classes. Needs the module that emscripten makes; knows nothing
// of pages and workers. Quantities are in SI units, vectors three numbers in a row.
'use strict';

/** What a C function said about wrong input. `stopped`: a step that was not taken, for numerical trouble. */
class ElastinError extends Error {
  constructor(message, stopped) {
    super(message);
    this.stopped = stopped;
  }
}

/** The module's memory: structures and strings go in, arrays come out. Nothing is kept between calls. */
class Memory {
  constructor(module) {
    this.module = module;
    this.held = [];
  }

  /** Memory of this many bytes until release(), a multiple of 8. */
  room(bytes) {
    const at = this.module._malloc(Math.max(8, bytes));
    if (!at) throw new ElastinError('there is not enough memory for this');
    this.held.push(at);
    return at;
  }

  text(text) {
    const bytes = this.module.lengthBytesUTF8(text) + 1, at = this.room(bytes);
    this.module.stringToUTF8(text, at, bytes);
    return at;
  }

  numbers(values) {
    const at = this.room(8 * values.length);
    this.module.HEAPF64.set(values, at / 8);
    return at;
  }

  /** A structure of the C API: its size, then its fields as [kind, value] in order, each where C has it. */
  structure(fields) {
    const size = {word: 4, whole: 4, number: 8};
    let end = 4;
    const places = fields.map(([kind]) => {
      const at = Math.ceil(end / size[kind]) * size[kind];
      end = at + size[kind];
      return at;
    });
    end = fields.some(([kind]) => kind === 'number') ? Math.ceil(end / 8) * 8 : end;
    const at = this.room(end);
    this.module.HEAPU32[at / 4] = end;
    fields.forEach(([kind, value], i) => {
      const place = at + places[i];
      if (kind === 'number') this.module.HEAPF64[place / 8] = value;
      else this.module.HEAP32[place / 4] = value;
    });
    return at;
  }

  release() {
    for (const at of this.held) this.module._free(at);
    this.held = [];
  }
}

/** Calls a C function with the memory that it needs; throws its message. */
function call(module, name, arrange) {
  const memory = new Memory(module);
  try {
    const values = arrange(memory), status = module['_' + name](...values);
    if (status !== 0) throw new ElastinError(module.UTF8ToString(module._elastin_message()), status === 2);
  } finally {
    memory.release();
  }
}

/** A body that moves. */
class ElastinSimulation {
  constructor(module, handle) {
    this.module = module;
    this.handle = handle;
    this.scratch = module._malloc(64);
  }

  /** Calls a function of this simulation that takes numbers alone, without touching the memory: for every step. */
  check(status) {
    if (status !== 0) throw new ElastinError(this.module.UTF8ToString(this.module._elastin_message()), status === 2);
  }

  step(dt) { this.check(this.module._elastin_step(this.handle, dt, 0)); }

  settle() {
    const at = this.scratch / 4;  // an elastin_step_result
    this.module.HEAPU32[at] = 24;
    this.check(this.module._elastin_settle(this.handle, this.scratch));
    return {unstable: this.module.HEAPU32[at + 5] !== 0};
  }

  get time() {
    this.check(this.module._elastin_time(this.handle, this.scratch));
    return this.module.HEAPF64[this.scratch / 8];
  }

  /** A view of the module's memory: of `positions`, `velocities`, `forces` or `tensions`; read it at once. */
  view(what) {
    this.check(this.module['_elastin_' + what](this.handle, this.scratch, this.scratch + 4));
    const [at, count] = this.module.HEAPU32.subarray(this.scratch / 4, this.scratch / 4 + 2);
    return this.module.HEAPF64.subarray(at / 8, at / 8 + count);
  }

  vector(numbers, at = this.scratch) {
    if (numbers?.length !== 3 || !Array.prototype.every.call(numbers, Number.isFinite))
      throw new ElastinError(`a position or vector must be three finite numbers, not ${JSON.stringify(numbers)}`);
    this.module.HEAPF64.set(numbers, at / 8);
    return at;
  }

  /** A molecule's or coupling's number: what is missing must not become 0. */
  number(given) {
    if (!Number.isInteger(given)) throw new ElastinError(`a number of a molecule or coupling is needed, not ${given}`);
    return given;
  }

  /** What makes its results doubtful, a sentence each; looks at the whole body. */
  get warnings() {
    this.check(this.module._elastin_warnings(this.handle, this.scratch));
    return this.module.UTF8ToString(this.module.HEAPU32[this.scratch / 4]).split('\n').filter(Boolean);
  }

  read(count, at = this.scratch) { return Array.from(this.module.HEAPF64.subarray(at / 8, at / 8 + count)); }

  fix(molecule, free_axes = 0) { this.check(this.module._elastin_fix(this.handle, this.number(molecule), free_axes)); }

  release(molecule) { this.check(this.module._elastin_release(this.handle, this.number(molecule))); }

  couple(molecule, position, stiffness, damping) {
    const at = this.vector(position);
    this.check(this.module._elastin_couple(this.handle, this.number(molecule), at, stiffness, damping, at + 24));
    return this.module.HEAP32[(at + 24) / 4];
  }

  move_coupling(coupling, position) {
    this.check(this.module._elastin_move_coupling(this.handle, this.number(coupling), this.vector(position), 0));
  }

  coupling_force(coupling) {
    this.check(this.module._elastin_coupling_force(this.handle, this.number(coupling), this.scratch));
    return this.read(3);
  }

  decouple(coupling) { this.check(this.module._elastin_decouple(this.handle, this.number(coupling))); }

  free() {
    this.module._elastin_simulation_free(this.handle);
    this.module._free(this.scratch);
    this.handle = 0;
  }
}

/** A scene's body, from the bytes of a page's parcel. */
class ElastinLab {
  constructor(module, bytes) {
    this.module = module;
    const room = module._malloc(bytes.length);
    module.HEAPU8.set(bytes, room);
    try {
      this.handle = this.handle_of('elastin_lab_open', () => [room, bytes.length]);
    } finally {
      module._free(room);
    }
  }

  /** Calls a function whose last argument is where it puts a handle. */
  handle_of(name, arrange) {
    const out = this.module._malloc(8);
    try {
      call(this.module, name, memory => [...arrange(memory), out]);
      return this.module.HEAPU32[out / 4];
    } finally {
      this.module._free(out);
    }
  }

  /** elastin_lab_settings of {strategy, stepper, iterations, E, nu, density, phi, psi, alpha, pressure}. */
  settings(memory, s) {
    return memory.structure([['word', memory.text(s.strategy)], ['word', memory.text(s.stepper)], ['whole', s.iterations || 0],
      ...[s.E, s.nu, s.density, s.phi, s.psi, s.alpha, s.pressure || 0].map(value => ['number', value])]);
  }

  simulate(settings) {
    return new ElastinSimulation(this.module,
      this.handle_of('elastin_lab_simulate', memory => [this.handle, this.settings(memory, settings)]));
  }

  /** Positions, velocities and time of one simulation become those of another. */
  carry(from, to) { to.check(this.module._elastin_lab_carry(from.handle, to.handle)); }

  stable_step(simulation) {
    simulation.check(this.module._elastin_lab_stable_step(simulation.handle, simulation.scratch));
    return simulation.read(1)[0];
  }

  /** Gravity, the experiment's own load and a probe {centre, radius, stiffness}; gives the force on the probe [N]. */
  push(simulation, gravity, own_load, probe) {
    const at = simulation.scratch;
    simulation.vector(gravity, at);
    simulation.vector(probe.centre, at + 24);
    simulation.check(this.module._elastin_lab_push(this.handle, simulation.handle, at, own_load, at + 24, probe.radius,
      probe.stiffness, at));
    return simulation.read(3);
  }

  energies(simulation) {
    simulation.check(this.module._elastin_lab_energies(simulation.handle, simulation.scratch));
    return simulation.read(2);
  }

  /** Von Mises stress of each molecule [Pa]. */
  stress(simulation, density, molecules) {
    const at = this.module._malloc(8 * molecules);
    try {
      simulation.check(this.module._elastin_lab_stress(this.handle, simulation.handle, density, at));
      return Float32Array.from(this.module.HEAPF64.subarray(at / 8, at / 8 + molecules));
    } finally {
      this.module._free(at);
    }
  }

  /** The tension test: an object with step(), which gives {own, own_end, last, of_law, strain, stress, modulus, ratio,
   *  target, target_ratio}, the targets at the last step of the test as it is, and free(). */
  test(settings, strain, steps) {
    const {module} = this, at = module._malloc(64);
    const handle = this.handle_of('elastin_lab_test_begin', memory => [this.handle, this.settings(memory, settings), strain, steps]);
    const checked = status => {
      if (status !== 0) throw new ElastinError(module.UTF8ToString(module._elastin_message()), status === 2);
    };
    const view = what => {
      checked(module['_elastin_lab_test_' + what](handle, at, at + 4));
      const [place, count] = module.HEAPU32.subarray(at / 4, at / 4 + 2);
      return module.HEAPF64.subarray(place / 8, place / 8 + count);
    };
    return {
      step() {
        module.HEAPU32[at / 4] = 64;  // sizeof(elastin_lab_reading)
        checked(module._elastin_lab_test_step(handle, at));
        const [strain, stress, modulus, ratio, target, target_ratio] = module.HEAPF64.subarray(at / 8 + 2, at / 8 + 8);
        const [own, last, of_law] = module.HEAP32.subarray(at / 4 + 1, at / 4 + 4);
        return {own: own !== 0, own_end: own === 2, last: last !== 0, of_law: of_law !== 0, strain, stress, modulus, ratio,
          target, target_ratio};
      },
      positions: () => view('positions'),
      tensions: () => view('tensions'),
      free() {
        module._elastin_lab_test_free(handle);
        module._free(at);
      },
    };
  }

  free() { this.module._elastin_lab_free(this.handle); }
}

if (typeof module !== 'undefined') module.exports = {ElastinLab, ElastinSimulation, ElastinError, Memory, call};
