// The core's thread: it steps the bodies when the page wants a picture, and tests them. Messages in: start, settings, hand,
// frame, pin, test, reset. Messages out: ready, frame, tested, problem. Needs the module and elastin.js before it.
'use strict';

const far_away = {centre: [0, 0, 0], radius: 0, stiffness: 0};
const core = {lab: null, bodies: [], settings: null, hand: null, probe: far_away, pins: new Map(), test: null, time_left: 0};

/** One body under the hand: a strategy of its own. */
class LiveBody {
  constructor(strategy, before) {
    this.strategy = strategy;
    this.simulation = core.lab.simulate({...core.settings, strategy});
    const stable = core.lab.stable_step(this.simulation);
    this.step = core.settings.explicit ? 0.8 * stable : core.settings.step || Math.min(1 / 120, 200 * stable);
    if (!Number.isFinite(this.step)) this.step = 1 / 120;
    if (before) core.lab.carry(before.simulation, this.simulation);
    for (const molecule of core.pins.keys()) this.simulation.fix(molecule);
    this.cost = 0;  // [s] of a step, on average
    this.stopped = '';
    if (core.hand) this.grip();
  }

  grip() {
    const {molecule, target, stiffness} = core.hand;
    this.coupling = this.simulation.couple(molecule, target, stiffness, core.hand.damping || 0);
  }

  let_go() {
    if (this.coupling !== undefined) this.simulation.decouple(this.coupling);
    this.coupling = undefined;
  }

  /** One step; a step that cannot be taken is said, and the body waits for a change. */
  advance(dt) {
    const {gravity, own_load} = core.settings;
    this.push = core.lab.push(this.simulation, gravity, own_load, core.probe);
    const begin = performance.now();
    try {
      this.simulation.step(dt);
      this.stopped = '';
    } catch (problem) {
      if (!problem.stopped) throw problem;
      this.stopped = problem.message;
    }
    const cost = 1e-3 * (performance.now() - begin);
    this.cost = this.cost ? this.cost + 0.05 * (cost - this.cost) : cost;
  }

  free() { this.simulation.free(); }
}

function make_bodies(keep) {
  const before = core.bodies;
  core.bodies = [];
  try {
    core.bodies = core.settings.strategies.map((strategy, i) => new LiveBody(strategy, keep ? before[i] ?? before[0] : undefined));
  } finally {
    for (const body of before) body.free();
  }
  core.time_left = 0;
}

/** Steps all bodies by the same time, at most `budget` [s] long; gives the time that they have gone [s]. */
function advance(wanted, budget, single) {
  const dt = Math.min(...core.bodies.map(body => body.step)), end = performance.now() + 1000 * budget;
  core.time_left = single ? dt : Math.min(core.time_left + wanted, 4 * wanted + dt);
  let gone = 0, steps = 0;
  while (core.time_left >= dt * (1 - 1e-9)) {
    for (const body of core.bodies) if (!body.stopped) body.advance(dt);
    core.time_left -= dt;
    gone += dt;
    ++steps;
    if (performance.now() > end) {
      core.time_left = 0;
      break;
    }
  }
  return {gone, steps, dt};
}

/** What a colour needs in addition to the positions: numbers of connections or of molecules. */
function colour_values(body, colour, connections) {
  const {simulation} = body;
  if (colour === 'tension') return Float32Array.from(simulation.view('tensions').subarray(0, connections));
  if (colour === 'stress') return core.lab.stress(simulation, core.settings.density, core.molecules);
  if (colour !== 'speed') return undefined;
  const v = simulation.view('velocities');
  return Float32Array.from({length: v.length / 3}, (_, i) => Math.hypot(v[3 * i], v[3 * i + 1], v[3 * i + 2]));
}

function frame({wanted, budget, single, colour, buffers}) {
  const {gone, steps, dt} = wanted > 0 || single ? advance(wanted, budget, single) : {gone: 0, steps: 0, dt: core.bodies[0].step};
  const said = core.bodies.map((body, i) => {
    const view = body.simulation.view('positions');
    const positions = buffers?.[i]?.length === view.length ? buffers[i] : new Float32Array(view.length);
    positions.set(view);
    return {positions, values: colour_values(body, colour, core.connections), time: body.simulation.time, cost: body.cost, step: body.step,
      energies: core.lab.energies(body.simulation), stopped: body.stopped,
      force: body.coupling !== undefined ? body.simulation.coupling_force(body.coupling) : undefined, push: body.push};
  });
  return {kind: 'frame', bodies: said, gone, steps, dt};
}

/** One step of the test of every body. */
function test_step() {
  const said = core.test.map(test => {
    if (test.over) return {positions: test.positions, over: true, problem: test.problem};
    try {
      const reading = test.run.step();
      test.over = reading.last;
      test.positions = Float32Array.from(test.run.positions());
      return {positions: test.positions, values: Float32Array.from(test.run.tensions().subarray(0, core.connections)), reading, over: test.over};
    } catch (problem) {
      if (!problem.stopped) throw problem;
      test.over = true;
      test.problem = problem.message;
      return {positions: test.positions, over: true, problem: problem.message};
    }
  });
  const over = core.test.every(test => test.over);
  if (over) end_test();
  return {kind: 'tested', bodies: said, over};
}

function end_test() {
  for (const test of core.test ?? []) test.run.free();
  core.test = null;
}

const answers = {
  async start({wasm, parcel, settings, molecules, connections}) {
    core.module = await elastin_module({wasmBinary: wasm, print() {}, printErr() {}});
    core.lab = new ElastinLab(core.module, new Uint8Array(parcel));
    Object.assign(core, {settings, molecules, connections});
    make_bodies(false);
    return {kind: 'ready'};
  },
  /** keep: the bodies go on from where they are. */
  settings({settings, keep, rebuild}) {
    const before = core.settings;
    core.settings = settings;
    try {
      if (rebuild) make_bodies(keep);
    } catch (problem) {
      if (!(problem instanceof ElastinError)) throw problem;
      core.settings = before;
      if (!core.bodies.length) make_bodies(false);
      return {kind: 'refused', message: problem.message};
    }
    return {kind: 'settled'};
  },
  reset() {
    make_bodies(false);
    return {kind: 'settled'};
  },
  /** Grips a molecule, moves the hand, or releases the molecule. */
  hand({hand}) {
    const same = core.hand && hand && hand.molecule === core.hand.molecule && hand.stiffness === core.hand.stiffness;
    core.hand = hand;
    for (const body of core.bodies)
      if (same && body.coupling !== undefined) body.simulation.move_coupling(body.coupling, hand.target);
      else {
        body.let_go();
        if (hand) body.grip();
      }
  },
  probe({probe}) { core.probe = probe ?? far_away; },
  pin({molecule, on}) {
    for (const body of core.bodies)
      if (on) body.simulation.fix(molecule);
      else body.simulation.release(molecule);
    if (on) core.pins.set(molecule, true);
    else core.pins.delete(molecule);
  },
  test({strain, steps}) {
    end_test();
    core.test = core.settings.strategies.map(strategy => ({run: core.lab.test({...core.settings, strategy}, strain, steps)}));
    return {kind: 'testing'};
  },
  stop_test() { end_test(); },
  test_step() { return core.test ? test_step() : undefined; },
  frame,
};

onmessage = async ({data}) => {
  try {
    const said = await answers[data.kind](data) ?? {};
    if (data.number === undefined) return;  // nobody waits for an answer
    const buffers = (said.bodies ?? []).flatMap(body => [body.positions, body.values]).filter(Boolean).map(array => array.buffer);
    postMessage({...said, answer: data.number}, said.kind === 'frame' ? buffers : []);
  } catch (problem) {
    postMessage({kind: 'problem', message: problem.message || String(problem), answer: data.number});
  }
};
