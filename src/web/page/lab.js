// The page of the lab: controls, worker, pictures and curves brought together. Needs the scripts before it.
'use strict';

const part = id => document.getElementById(id), all = (what, within = document) => [...within.querySelectorAll(what)];
const root = document.documentElement, scene = JSON.parse(part('scene').textContent), first = scene.settings;
const tool_hints = {drag: 'Drag a molecule: the hand pulls it like a spring and shows its force. Let go, and see it ring.',
  push: 'Press on the body: a round probe pushes it away and shows its force.',
  pin: 'Click a molecule: it stays where it is. A second click releases it.',
  turn: 'Drag anywhere: the view turns, and the body is left alone.'};
const painters = {graphics: GraphicsPainter, processor: ProcessorPainter};  // the page finds which suits, unless its address says it
const series_colours = ['var(--one)', 'var(--two)', 'var(--three)'];

for (const kind of ['error', 'unhandledrejection'])
  addEventListener(kind, event => { root.dataset.errors = (root.dataset.errors || '') + (event.message ?? event.reason) + '; '; });

/** Says why something does not work, in the page and to a screen reader. */
function complain(text) {
  part('problem').textContent = text;
  part('problem').hidden = !text;
}

/** A number with two digits and without a power of ten. */
const short = value => String(+value.toPrecision(2));

/** "+0.12 %"; "—" where there is no target. */
const error_text = error => {
  if (!Number.isFinite(error)) return '—';
  const percent = Math.round(1e4 * error) / 100 || 0;  // never -0
  return `${percent > 0 ? '+' : ''}${percent.toFixed(2)} %`.replace('-', '−');
};

const said = text => { part('said').textContent = text; };

class Lab {
  constructor(body) {
    this.body = body;
    this.sliders = {};
    this.playing = true;
    this.tool = 'drag';
    this.pins = new Set();
    this.count = 0;
    this.pace = new Pace();
    this.history = [];
    this.waiting = new Map();
    this.curves = {test: new Curve(part('curve'), {x: {title: 'strain', unit: '%'}, y: {title: 'stress', unit: 'Pa'}}),
      energy: new Curve(part('energy'), {x: {title: 'time', unit: 's', floating: true}, y: {title: 'energy', unit: 'J'}})};
    this.fill();
    this.choose_tool(this.tool);
    this.read_hash();
  }

  // --- controls -------------------------------------------------------------------------------------------------------
  fill() {
    const option = ({name, summary}) => Object.assign(new Option(name, name), {title: summary});
    all('.strategy').forEach((select, i) => {
      if (i) select.append(new Option('—', ''));
      select.append(...scene.strategies.map(option));
    });
    part('stepper').append(...scene.steppers.map(option));
    const size = this.body.size, gravity = Math.hypot(...first.gravity);
    // The slowest vibration of a body of this size is about so fast [1/s]; it rings down in a few swings.
    const rate = Math.sqrt(first.E / first.density) / size, damped = first.phi || first.psi || first.alpha;
    const viscosity = first.E / (rate || 1) / 30;
    this.start = {E: first.E, nu: first.nu, density: first.density, phi: first.phi, psi: first.psi,
      alpha: damped || scene.released ? first.alpha : 0.6 * rate, pressure: 0, gravity, tilt: 0, load: 100 * scene.own_load_share,
      stiffness: Math.max(1e-6, +(0.1 * first.E * size * (scene.membrane && !scene.solid ? 0.02 : 1)).toPrecision(2)), probe: 0.12 * size, strain: 20};
    const scales = {phi: first.phi || viscosity, psi: first.psi || viscosity, alpha: rate, pressure: 0.01 * first.E};
    const several = scene.bodies.length > 0;
    const own_kinds = {nu: {most: Math.max(slider_kinds.nu.most, first.nu)},
      ...several && {E: {whole: first.E}, density: {whole: first.density}}};
    for (const [name, kind] of Object.entries(slider_kinds))
      this.sliders[name] = new Slider(part(name), part(name + '-out'), {...kind, ...own_kinds[name]}, this.start[name],
        scales[name]);
    const hide = names => names.forEach(name => { for (const one of [part(name), part(name + '-out'), document.querySelector(`label[for=${name}]`)]) one.hidden = true; });
    if (scene.own_constants || scene.parts > 1) hide(['nu']);
    if (!scene.viscous) hide(['phi', 'psi']);
    if (!scene.membrane || scene.solid) hide(['pressure']);
    if (!scene.own_load) hide(['load']);
    part('jello').hidden = several;  // it is of one material
    part('molecule').max = scene.molecules - 1;
    part('connections').checked = true;
    part('molecules').checked = !this.body.membrane;
    part('surface').checked = this.body.membrane;
    part('surface').disabled = !this.body.surface.length;
    const counted = (count, name) => `${count.toLocaleString('en')} ${name}${count === 1 ? '' : 's'}`;
    part('about').textContent = [counted(scene.molecules, 'molecule'), counted(scene.connections, 'connection'),
      ...(scene.cells ? [counted(scene.cells, 'cell')] : [])].join(', ') +
      (several ? `; its bodies are of several materials: ${this.materials()}.`
        : `; its material has Young's modulus E = ${with_prefix(first.E, 'Pa')} and Poisson's ratio ν = ` +
          `${+first.nu.toPrecision(4)}.`) +
      (scene.left_out.length ? ` Of the scene this page leaves out: ${scene.left_out.join('; ')}.` : '');
    part('test-note').textContent = 'How stiff is the whole body? ' + (scene.own_test ? "It is pulled as in the scene's own test, where its E and ν are read, "
      : `It is pulled by a strain of 10⁻⁴ along its longest side${scene.supports ? ", without the scene's supports" : ''}, ` +
        'where its E and ν are read, ') +
      'and then on to the strain that you set.';
    if (scene.no_test) {
      part('test-note').textContent = `The body as a whole is not pulled here: ${scene.no_test}.`;
      for (const one of [part('test').closest('.bar'), part('pull-step')]) one.hidden = true;
    }
    this.curves.energy.set([], 'Energy over time');
  }

  /** E and ν of each of several bodies, in words. */
  materials() {
    const most = 6, words = ({name, E, nu}) => `${name} E = ${with_prefix(E, 'Pa')}, ν = ${+nu.toPrecision(4)}`;
    return scene.bodies.slice(0, most).map(words).join('; ') + (scene.bodies.length > most ? `; and ${scene.bodies.length - most} more` : '');
  }

  choose_tool(tool) {
    this.tool = tool;
    part('tool-hint').textContent = tool_hints[tool];
  }

  /** The scene's own settings, then what the address says. Says what of it the page does not have. */
  read_hash() {
    const hash = values_from_hash(location.hash), names = scene.strategies.map(one => one.name);
    const unknown = [], beyond = [];
    const has = (name, options) => {
      if (hash[name] && !options.includes(hash[name])) unknown.push(`${name}=${hash[name]}`);
      return options.includes(hash[name]);
    };
    all('.strategy').forEach((select, i) => {
      const name = 's' + (i + 1);
      select.value = has(name, names) ? hash[name] : i ? '' : first.strategy;
    });
    // What conserves energy in steps of the scene's length may gain it where a hand pulls or springs fold: then the page begins
    // with something that never does.
    const steppers = scene.steppers.map(one => one.name), own = scene.steppers.find(one => one.name === first.stepper);
    hash.stepper ??= hash.scheme;  // the former name
    const usual = own?.newton ? 'backward_euler' : own?.name ?? (scene.cells ? 'backward_euler' : 'symplectic_euler');
    part('stepper').value = has('stepper', steppers) ? hash.stepper : usual;
    part('one-iteration').checked = hash.one !== undefined ? hash.one === '1' : (first.iterations ?? 1) === 1;
    for (const [name, slider] of Object.entries(this.sliders)) {
      const value = number_from_hash(hash[name]), taken = slider.takes(value);
      slider.value = taken ? value : this.start[name];
      if (hash[name] !== undefined && !taken) beyond.push(`${name}=${hash[name]}`);
    }
    for (const name of ['colour', 'speed'])
      if (has(name, [...part(name).options].map(option => option.value))) part(name).value = hash[name];
    this.painter = hash.painter;
    this.show_choices();
    const words = (list, text) => list.length ? [`${text}: ${list.join(', ')}.`] : [];
    this.unread = [...words(beyond, "The page's address has values that no slider reaches, which are left out"),
      ...words(unknown, "The page's address names what this page does not have, which is left out")].join(' ');
    complain(this.unread);
  }

  hash() {
    const values = {painter: this.painter};
    all('.strategy').forEach((select, i) => { values['s' + (i + 1)] = select.value; });
    Object.assign(values, {stepper: part('stepper').value, one: part('one-iteration').checked ? '1' : '0', colour: part('colour').value,
      speed: part('speed').value});
    for (const [name, slider] of Object.entries(this.sliders)) if (slider.value !== this.start[name]) values[name] = slider.value;
    return hash_of(values);
  }

  /** What the choices mean, and which of them there is now: one Newton iteration a step is one for steppers that iterate by
   *  Newton's method alone, a tilt where there is weight. */
  show_choices() {
    const stepper = scene.steppers.find(one => one.name === part('stepper').value), {strategies} = this;
    part('one-iteration').closest('label').hidden = !stepper.newton;
    part('tilt').disabled = !(this.sliders.gravity.value > 0);
    const chosen = scene.strategies.filter(one => strategies.includes(one.name));
    part('meaning').replaceChildren(...[...chosen, stepper].map(({name, summary}) => {
      const item = document.createElement('li');
      item.append(Object.assign(document.createElement('b'), {textContent: name}), ': ' + summary);
      return item;
    }));
    this.second = strategies.length > 1 ? '' : ['standard', ...scene.strategies.map(one => one.name)].find(name => name !== strategies[0] &&
      scene.strategies.some(one => one.name === name));
    part('compare').textContent = strategies.length > 1 ? 'Back to one body' : `Compare with ${this.second}`;
    part('compare').closest('li').hidden = strategies.length < 2 && !this.second;
  }

  get strategies() { return all('.strategy').map(select => select.value).filter(Boolean); }

  /** The messages to the worker. */
  settings() {
    const value = name => this.sliders[name].value, stepper = scene.steppers.find(one => one.name === part('stepper').value);
    const tilt = value('tilt') * Math.PI / 180, g = first.gravity, size = Math.hypot(...g);
    // Down is where the scene's weight points, tilted about the axis towards the reader.
    const down = size > 0 ? g.map(v => v / size) : [0, 0, -1], [c, s] = [Math.cos(tilt), Math.sin(tilt)];
    const turned = [c * down[0] - s * down[2], down[1], s * down[0] + c * down[2]];
    return {strategies: this.strategies, stepper: stepper.name, explicit: stepper.explicit, iterations: part('one-iteration').checked ? 1 : 0,
      step: first.step, E: value('E'), nu: value('nu'), density: value('density'), phi: value('phi'), psi: value('psi'), alpha: value('alpha'),
      pressure: value('pressure'), gravity: turned.map(v => v * value('gravity')), own_load: value('load') / 100};
  }

  listen() {
    const on = (id, kind, does) => part(id).addEventListener(kind, does);
    for (const [name, slider] of Object.entries(this.sliders))
      slider.input.addEventListener('input', () => {
        slider.exact = undefined;
        slider.show();
        if (!['strain', 'stiffness', 'probe'].includes(name)) this.change(slider.kind.rebuild);
      });
    all('.strategy').forEach(select => select.addEventListener('change', () => this.choose_bodies()));
    for (const id of ['stepper', 'one-iteration']) on(id, 'change', () => this.change(true));
    all('input[name=tool]').forEach(input => input.addEventListener('change', () => this.choose_tool(input.value)));
    on('play', 'click', () => this.play(!this.playing));
    on('step', 'click', () => { this.play(false); this.single = true; });
    on('reset', 'click', () => this.reset());
    on('compare', 'click', () => this.compare_with(this.second));
    on('test', 'click', () => this.testing ? this.stop_test() : this.test());
    on('jello', 'click', () => this.jello());
    on('scene-material', 'click', () => this.set_sliders(this.start));
    on('pin', 'click', () => this.pin(+part('molecule').value));
    on('unpin', 'click', () => { for (const molecule of [...this.pins]) this.pin(molecule); });
    on('let-go', 'click', () => this.let_go());
    all('.pull').forEach(button => button.addEventListener('click', () => this.pull(+button.dataset.axis, +button.dataset.sign)));
    for (const id of ['connections', 'molecules', 'surface']) on(id, 'change', () => this.look());
    on('colour', 'change', () => { this.range = 0; });
    for (const id of ['colour', 'speed']) on(id, 'change', () => this.keep_address());
    document.addEventListener('visibilitychange', () => { this.last = undefined; });
    on('png', 'click', () => this.viewer && save_file(scene.name + '.png', this.viewer.picture(this.legend).toDataURL('image/png')));
    on('link', 'click', () => this.copy_link());
    on('view-reset', 'click', () => this.viewer?.reset());
    on('curve-csv', 'click', () => this.save_curve());
    on('energy-csv', 'click', () => this.save_energies());
    part('canvas').addEventListener('keydown', event => this.key(event));
    addEventListener('hashchange', () => { if (this.own_hash !== location.hash) { this.read_hash(); this.choose_bodies(); } });
  }

  key(event) {
    const axes = {d: [0, 1], a: [0, -1], e: [1, 1], q: [1, -1], w: [2, 1], s: [2, -1]}, input = part('molecule');
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (axes[event.key]) this.pull(...axes[event.key]);
    else if (event.key === 'n' || event.key === 'p') {
      input.value = (+input.value + (event.key === 'n' ? 1 : scene.molecules - 1)) % scene.molecules;
      said(`molecule ${input.value}`);
    } else if (event.key === 'x') this.pin(+input.value);
    else if (event.key === 'Escape') this.let_go();
    else if (event.key === ' ') this.play(!this.playing);
    else return;
    event.preventDefault();
  }

  set_sliders(values) {
    for (const [name, value] of Object.entries(values)) if (this.sliders[name].kind.rebuild) this.sliders[name].value = value;
    this.change(true);
  }

  /** Labelle's dessert: soft, hardly damped, one Newton iteration a step. */
  jello() {
    const viscosity = 2 * this.body.size / 0.17;
    this.set_sliders({E: 5e3, nu: scene.own_constants ? this.start.nu : 0.3, density: 1000, alpha: scene.viscous ? 0 : 0.3,
      phi: scene.viscous ? viscosity : 0, psi: scene.viscous ? viscosity : 0, pressure: 0});
    part('stepper').value = 'backward_euler';
    part('one-iteration').checked = true;
    this.change(true);
    said('Jell-O: E = 5 kPa, hardly damped, one Newton iteration a step');
  }

  // --- worker ---------------------------------------------------------------------------------------------------------
  /** A message to the worker, and its answer. */
  ask(message, transfer = []) {
    const number = ++this.count;
    return new Promise((resolve, reject) => {
      this.waiting.set(number, {resolve, reject});
      this.worker.postMessage({...message, number}, transfer);
    });
  }

  hear({data}) {
    const {resolve, reject} = this.waiting.get(data.answer) ?? {};
    this.waiting.delete(data.answer);
    if (data.kind === 'problem') {
      if (reject) reject(new Error(data.message));
      else complain(`Elastin: ${data.message}.`);
    } else resolve?.(data);
  }

  async begin() {
    this.worker = new Worker(URL.createObjectURL(new Blob([part('worker').textContent], {type: 'text/javascript'})));
    this.worker.onmessage = event => this.hear(event);
    this.worker.onerror = event => complain(`The core stopped: ${event.message}`);
    const unpack = async id => new Uint8Array(await new Response(new Blob([bytes_of(part(id).textContent)]).stream()
      .pipeThrough(new DecompressionStream('gzip'))).arrayBuffer());
    const [wasm, parcel] = await Promise.all([unpack('wasm'), unpack('parcel')]);
    await this.ask({kind: 'start', wasm, parcel, settings: this.settings(), molecules: scene.molecules, connections: scene.connections},
      [wasm.buffer, parcel.buffer]);
    for (const id of ['wasm', 'parcel', 'worker']) part(id).remove();
    this.unread = '';
    this.note_settled();
    this.listen();
    this.show_bodies();
    this.loop();
  }

  /** New settings; the bodies go on from where they are. Several changes in one picture are one. */
  change(rebuild, restart) {
    this.show_choices();
    this.rebuild = {rebuild: rebuild || this.rebuild?.rebuild, keep: !restart && !this.complained && this.rebuild?.keep !== false};  // what stands still goes on from rest
    this.keep_address();
  }

  /** The address carries the settings. */
  keep_address() {
    this.own_hash = this.hash();
    clearTimeout(this.hashing);
    this.hashing = setTimeout(() => history.replaceState(null, '', this.own_hash), 300);
  }

  async settle() {
    const {rebuild, keep} = this.rebuild;
    this.rebuild = this.still = undefined;
    const settings = this.settings();
    const answer = await this.ask({kind: 'settings', settings, rebuild, keep});
    complain(answer.kind === 'refused' ? `${answer.message}.` : this.unread);
    this.unread = '';
    if (rebuild) {
      this.history = [];
      this.last = undefined;  // the time of the preparation is not simulated
    }
    if (answer.kind !== 'refused') this.note_settled();
    else if (!this.rebuild) this.take_back();
  }

  /** What the core runs with now. */
  note_settled() {
    this.settled = this.strategies;
    this.settled_stepper = part('stepper').value;
    this.settled_values = Object.entries(this.sliders).filter(([, {kind}]) => kind.rebuild).map(([name, {value}]) => [name, value]);
  }

  /** What was refused: the strategies, the stepper and the values that ran before stay. */
  take_back() {
    all('.strategy').forEach((select, i) => { select.value = this.settled[i] ?? ''; });
    part('stepper').value = this.settled_stepper;
    for (const [name, value] of this.settled_values) this.sliders[name].value = value;
    this.show_choices();
    this.keep_address();
    this.show_bodies();
  }

  choose_bodies() {
    this.show_bodies();
    this.change(true);
  }

  /** A second body with this strategy, or, with none, the first alone. */
  compare_with(strategy) {
    part('strategy-2').value = strategy;
    if (!strategy) part('strategy-3').value = '';
    this.choose_bodies();
  }

  show_bodies() {
    const count = this.strategies.length;
    if (this.shown && this.count_shown === count) return;
    this.count_shown = count;
    this.shown = side_by_side(this.body, count);
    this.drawn = this.pictured = undefined;
    this.buffers = undefined;
    if (!this.viewer) return;
    this.viewer.set_body(this.shown);
    this.viewer.direction = count > 1 ? [-0.2, 0.3] : [-0.6, 0.35];  // side by side, the bodies do not hide each other
    this.seen = false;
    this.look();
    this.viewer.set_state(this.shown.rest.slice(), {molecules: new Float32Array(this.shown.rest.length).fill(0.5)});
    this.viewer.fit([this.shown.rest]);
  }

  // --- pictures -------------------------------------------------------------------------------------------------------
  async open_viewer() {
    try {
      const text = await unpacked(part('three').textContent);
      document.head.append(Object.assign(document.createElement('script'), {textContent: text}));
      this.viewer = part('canvas').viewer = new LabViewer(part('canvas'), painters[this.painter]);
      new Hand(part('canvas'), this);
    } catch (problem) {
      complain(`The body is not drawn: ${problem.message}. The tension test, the curves and the numbers work without it.`);
      part('canvas').parentElement.hidden = true;
    }
    part('three').remove();
  }

  look() {
    this.viewer?.set_look(Object.fromEntries(['connections', 'molecules', 'surface'].map(name => [name, part(name).checked])));
  }

  loop() {
    const tick = async now => {
      requestAnimationFrame(tick);
      if (this.busy) return;
      this.busy = true;
      try {
        await this.picture(now);
      } catch (problem) {
        complain(`The core says: ${problem.message}.`);
      } finally {
        this.busy = false;
      }
    };
    requestAnimationFrame(tick);
  }

  async picture(now) {
    if (this.testing) return this.test_picture(now);
    if (this.rebuild) await this.settle();
    const speed = +part('speed').value, interval = 1e-3 * (now - (this.last ?? now)), passed = Math.min(0.5, interval);
    const single = this.single, colour = part('colour').value;
    if (this.is_still(colour)) return;
    this.last = this.playing ? now : undefined;
    this.single = false;
    const begin = performance.now();
    const answer = await this.ask({kind: 'frame', wanted: this.playing ? passed * speed : 0, single, budget: this.pace.budget, colour,
      buffers: this.buffers}, (this.buffers ?? []).map(array => array.buffer));
    if (interval > 0 && !this.at_rest) this.pace.note(interval, 1e-3 * (performance.now() - begin));
    this.buffers = answer.bodies.map(body => body.positions);
    if (answer.bodies.length !== this.count_shown) return;
    this.show(answer, passed);
    if (this.viewer && !this.seen) this.viewer.fit([this.shown.rest, this.viewer.positions.slice()]);  // a body may begin elsewhere than at rest
    this.seen = true;
  }

  /** Nothing moves and nothing was changed since the last picture, which then is drawn once more as sharp as can be. */
  is_still(colour) {
    const state = [colour, this.count_shown, this.playing, JSON.stringify([this.hand, this.probe, [...this.pins]])].join();
    const still = !this.playing && !this.single && this.seen && this.still === state;
    this.still = state;
    if (this.viewer) this.viewer.sharpen(!still && !this.at_rest ? this.pace.sharpness : this.viewer.finest);
    return still;
  }

  show({bodies, gone}, passed) {
    this.answer = bodies;
    const {offsets, molecules} = this.shown, positions = new Float32Array(this.shown.rest.length);
    bodies.forEach((body, copy) => {
      for (let i = 0; i < 3 * molecules; ++i) positions[3 * molecules * copy + i] = body.positions[i] + (i % 3 ? 0 : offsets[copy]);
    });
    if (this.viewer) {
      this.marks(bodies, positions);
      const colours = this.colours(bodies, positions);
      if (!this.is_drawn(positions)) this.viewer.set_state(positions, colours);
    }
    this.drawn = positions;
    if (gone > 0) this.keep_energies(bodies, gone);
    this.show_status(bodies, gone, passed);
  }

  /** Whether these positions are drawn already, but for what rounding moves, with the marks and colours of now. */
  is_drawn(positions) {
    const {lines, probes, pins, names} = this.viewer, slack = 1e-9 * this.body.size;
    const marks = JSON.stringify([lines.map(line => [line.from.map(v => Math.round(v / slack)), line.to, line.text]), probes, pins.length, names,
      part('colour').value, this.range]);
    const same = this.pictured?.length === positions.length && marks === this.marks_drawn &&
      positions.every((v, i) => Math.abs(v - this.pictured[i]) <= slack);
    this.marks_drawn = marks;
    if (!same) this.pictured = positions;
    this.unmoved = same ? (this.unmoved ?? 0) + 1 : 0;
    return same;
  }

  /** For some pictures nothing has moved. */
  get at_rest() { return this.unmoved > 9; }

  /** Hand, probe, pins and names over the picture. */
  marks(bodies, positions) {
    const {viewer, shown: {offsets, molecules}} = this;
    const place = (copy, molecule) => Array.from(positions.subarray(3 * (copy * molecules + molecule), 3 * (copy * molecules + molecule) + 3));
    const shifted = (at, copy) => [at[0] + offsets[copy], at[1], at[2]];
    viewer.lines = this.hand ? bodies.map((body, copy) => ({from: place(copy, this.hand.molecule), to: shifted(this.hand.target, copy),
      text: body.force ? with_prefix(Math.hypot(...body.force), 'N') : ''})) : [];
    viewer.probes = this.probe ? bodies.map((_, copy) => ({place: shifted(this.probe.centre, copy), radius: this.probe.radius})) : [];
    viewer.pins = bodies.flatMap((_, copy) => [...this.pins].map(molecule => place(copy, molecule)));
    viewer.names = bodies.length > 1 ? this.strategies : [];
  }

  /** Colours of everything by what is chosen, over a range that grows at once and shrinks slowly. */
  colours(bodies, positions) {
    const colour = part('colour').value, joined = list => {
      const all_values = new Float32Array(list.reduce((sum, one) => sum + one.length, 0));
      let at = 0;
      for (const one of list) { all_values.set(one, at); at += one.length; }
      return all_values;
    };
    const values = {};
    if (colour === 'strain') values.connections = strains_of(this.shown, positions.map((v, i) => v - this.shown.rest[i]));
    else {
      const list = bodies.map(body => body.values);
      const wanted = colour === 'tension' ? scene.connections : scene.molecules;
      if (list.some(one => one?.length !== wanted)) list.fill(new Float32Array(wanted));
      values[colour === 'tension' ? 'connections' : 'molecules'] = joined(list);
    }
    values.molecules ??= means_of(this.shown, values.connections);
    let most = 0;
    for (const v of values.connections ?? values.molecules) most = Math.max(most, Math.abs(v));
    const now = performance.now(), shrunk = 0.97 ** (0.06 * Math.min(500, now - (this.ranged ?? now)));  // by 3 % in 1/60 s
    this.ranged = now;
    this.range = Math.max(most, shrunk * (this.range ?? 0), this.noise(colour));
    const map = values.connections ? 'signed' : 'rising', range = this.range, mapped = numbers => numbers && colours_of(map, numbers.map(v => v / range));
    this.show_legend(colour, map);
    return {connections: mapped(values.connections), molecules: mapped(values.molecules)};
  }

  /** What rounding leaves of a quantity in a body at rest, and more: no colours are given to less. */
  noise(what) {
    const {size} = this.body, apart = size / Math.cbrt(scene.molecules), {E, density} = first;
    return 1e-9 * {tension: E * apart ** 2, stress: E, strain: 1, speed: Math.sqrt(E / density), energy: 1e-7 * E * size ** 3}[what];
  }

  show_legend(colour, map) {
    const unit = {tension: 'N', stress: 'Pa', strain: '', speed: 'm/s'}[colour];
    const text = v => Math.abs(v) <= this.noise(colour) ? '0' : (colour === 'strain' ? `${short(100 * v)} %` : with_prefix(+v.toPrecision(2), unit, 0)).replace('-', '−');
    const title = {tension: 'tension of the connections: blue pressed, red pulled', stress: 'stress (von Mises)',
      strain: 'strain of the connections: blue shorter, red longer', speed: 'speed'}[colour];
    this.legend = {title, map, low: map === 'signed' ? text(-this.range) : '0', high: text(this.range)};
    part('legend-title').textContent = title;
    part('legend-low').textContent = this.legend.low;
    part('legend-high').textContent = this.legend.high;
    if (this.ramp !== map) part('ramp').style.background = `linear-gradient(90deg,${legend_colours(map)})`;
    this.ramp = map;
  }

  /** A body that moves out of the picture is followed, as far as three times its size, until somebody turns the view. */
  keep_in_view() {
    const {viewer} = this;
    if (!viewer || viewer.touched || this.hand || !viewer.positions) return;
    const {x, y, z} = viewer.middle, most = 3 * this.body.size * this.count_shown, p = viewer.positions;
    let outside = false;
    for (let i = 0; i < p.length; i += 3) {
      if (!(Math.hypot(p[i] - x, p[i + 1] - y, p[i + 2] - z) < most)) return;
      const [right, down] = viewer.seen_at([p[i], p[i + 1], p[i + 2]]);
      outside ||= right < 0 || down < 0 || right > viewer.canvas.clientWidth || down > viewer.canvas.clientHeight;
    }
    if (outside) viewer.fit([...viewer.fitted.slice(-3), p.slice()]);
  }

  /** Numbers in words, four times a second. */
  show_status(bodies, gone, passed) {
    this.sum = {gone: (this.sum?.gone ?? 0) + gone, passed: (this.sum?.passed ?? 0) + passed};
    const now = performance.now();
    if (now - (this.status_time ?? 0) < 250) return;
    this.status_time = now;
    this.keep_in_view();
    const forces = bodies.map(body => body.force).filter(Boolean), wanted = +part('speed').value;
    const rare = wanted * this.sum.passed < 2 * bodies[0].step;  // in slow motion steps may be rarer than these words
    const ratio = rare ? wanted : this.sum.passed > 0 ? this.sum.gone / this.sum.passed : 0;
    this.sum = undefined;
    const words = [`t = ${bodies[0].time.toFixed(2 + Math.max(0, Math.ceil(-Math.log10(wanted))))} s`, this.playing ? `${short(ratio)} × real time` : 'paused'];
    if (forces.length) words.push('hand ' + forces.map(force => with_prefix(Math.hypot(...force), 'N')).join(' / '));
    if (this.probe) words.push('probe ' + bodies.map(body => with_prefix(Math.hypot(...(body.push ?? [0, 0, 0])), 'N')).join(' / '));
    part('readout').textContent = words.join(' · ');
    const beyond = body => body.energies[1] > this.sliders.E.value * this.body.size ** 3 && part('stepper').value !== 'backward_euler';
    const stopped = bodies.find(body => body.stopped) ?? bodies.find(beyond);
    const slow = this.playing && ratio < 0.8 * wanted && !stopped;
    const cause = this.pace.core > this.pace.drawing ? 'each step costs too much here' : 'this browser takes long to draw';
    part('readout').textContent += slow ? ` · slower than chosen: ${cause}` : '';
    const trouble = !stopped ? '' : stopped.stopped ? `A body stands still: ${stopped.stopped}. Reset it, or choose an implicit stepper.`
      : `A body has more elastic energy than it could hold: ${part('stepper').value} is not stable here. Choose backward_euler and reset it.`;
    if (trouble !== (this.complained ?? '')) complain(trouble);
    this.complained = trouble;
    part('canvas').setAttribute('aria-label', `The body with ${this.strategies.join(', ')}, coloured by ${this.legend?.title ?? 'tension'}`);
    this.show_cost(bodies);
    this.show_energies();
  }

  show_cost(bodies) {
    part('cost').replaceChildren(...bodies.map((body, i) => this.row(i, [with_prefix(body.step, 's'),
      body.cost ? with_prefix(body.cost, 's') : '—', body.cost ? `${short(body.step / body.cost)} × real time` : '—'])));
  }

  row(body, cells, name = this.strategies[body]) {
    const row = document.createElement('tr'), head = Object.assign(document.createElement('th'), {scope: 'row', textContent: name});
    head.style.borderLeft = `4px solid ${series_colours[body]}`;
    row.append(head, ...cells.map(text => Object.assign(document.createElement('td'), {className: 'n', textContent: text})));
    return row;
  }

  // --- energy ---------------------------------------------------------------------------------------------------------
  keep_energies(bodies) {
    this.history.push({time: bodies[0].time, energies: bodies.map(body => body.energies)});
    if (this.history.length > 600) this.history = this.history.filter((_, i) => i % 2);
  }

  show_energies() {
    const last = this.history.at(-1);
    if (!last) return;
    const noise = this.noise('energy'), seen = v => Math.abs(v) < noise ? 0 : v, said = v => Number.isFinite(v) ? with_prefix(seen(v), 'J') : 'not defined';
    const points = (i, kind) => this.history.map(one => [one.time, seen(one.energies[i]?.[kind])]);
    this.curves.energy.set(last.energies.flatMap((_, i) => [{name: 'kinetic', colour: series_colours[i], dashed: true, points: points(i, 0)},
      {name: 'elastic', colour: series_colours[i], points: points(i, 1)}]), 'Kinetic and elastic energy over time');
    part('energy-note').textContent = `Solid: elastic, ${last.energies.map(([, elastic]) => said(elastic)).join(' / ')}; ` +
      `dashed: kinetic, ${last.energies.map(([kinetic]) => said(kinetic)).join(' / ')}.`;
  }

  save_energies() {
    const head = ['time_s', ...this.strategies.flatMap(name => [`kinetic_J_${name}`, `elastic_J_${name}`])];
    this.save_csv('energy', csv_of(head, this.history.map(one => [one.time, ...one.energies.flat()])));
  }

  save_csv(name, text) { save_file(`${scene.name}-${name}.csv`, 'data:text/csv;charset=utf-8,' + encodeURIComponent(text)); }

  // --- hand -----------------------------------------------------------------------------------------------------------
  /** Which molecule of the one body a drawn one is, and a place next to it in the first body's axes. */
  own(molecule, place) {
    const {molecules, offsets} = this.shown, copy = Math.floor(molecule / molecules);
    return {molecule: molecule % molecules, place: place && [place[0] - offsets[copy], place[1], place[2]]};
  }

  hold(drawn, at) {
    if (this.testing) this.stop_test();
    const {molecule, place} = this.own(drawn, at);
    part('molecule').value = molecule;
    this.hold_at(molecule, place);
  }

  hold_at(molecule, target) {
    const stiffness = this.sliders.stiffness.value, mass = first.density * this.body.size ** 3 / scene.molecules / 5;
    this.hand = {molecule, target, stiffness, damping: 0.1 * Math.sqrt(stiffness * mass)};
    this.worker.postMessage({kind: 'hand', hand: this.hand});
  }

  push(drawn, at) {
    if (this.testing) this.stop_test();
    const radius = this.sliders.probe.value;
    this.probe = {centre: this.own(drawn, at).place, radius, stiffness: this.sliders.stiffness.value};
    this.worker.postMessage({kind: 'probe', probe: this.probe});
  }

  let_go() {
    this.hand = this.probe = undefined;
    this.worker.postMessage({kind: 'hand', hand: null});
    this.worker.postMessage({kind: 'probe', probe: null});
  }

  pin(drawn) {
    const {molecule} = this.own(drawn);
    if (!(molecule >= 0 && molecule < scene.molecules)) return;
    const on = !this.pins.has(molecule);
    if (on) this.pins.add(molecule);
    else this.pins.delete(molecule);
    part('molecule').value = molecule;
    this.worker.postMessage({kind: 'pin', molecule, on});
    said(`molecule ${molecule} is ${on ? 'pinned' : 'released'}`);
  }

  /** From the keyboard: the hand goes on by a twentieth of the body. */
  pull(axis, sign) {
    const molecule = Math.min(scene.molecules - 1, Math.max(0, +part('molecule').value | 0));
    const from = this.hand?.molecule === molecule ? this.hand.target : this.first_place(molecule);
    const target = [...from];
    target[axis] += sign * 0.05 * this.body.size;
    this.hold_at(molecule, target);
    said(`molecule ${molecule} is pulled`);
  }

  /** Where a molecule of the first body is drawn, in its own axes; the worker's own arrays go back to it. */
  first_place(molecule) {
    const drawn = this.drawn ?? this.shown.rest;
    return [0, 1, 2].map(k => drawn[3 * molecule + k] - (k ? 0 : this.shown.offsets[0]));
  }

  play(on) {
    this.playing = on;
    this.status_time = 0;
    part('play').textContent = on ? 'Pause' : 'Play';
    said(on ? 'running' : 'paused');
  }

  async reset() {
    this.stop_test();
    this.let_go();
    this.history = [];
    this.range = 0;
    this.change(true, true);
    complain('');
  }

  // --- test -----------------------------------------------------------------------------------------------------------
  async test() {
    const strain = this.sliders.strain.value / 100;
    this.let_go();
    complain('');
    part('test').textContent = 'Stop the test';
    said('the tension test runs');
    this.readings = this.strategies.map(() => []);
    this.problems = [];
    this.test_settings = this.settings();
    this.testing = 'begins';
    this.test_strain = Math.abs(strain) < 1e-6 ? 0.01 : strain;
    delete root.dataset.tested;
  }

  stop_test() {
    if (!this.testing) return;
    this.testing = undefined;
    this.worker.postMessage({kind: 'stop_test'});
    this.end_test();
  }

  end_test() {
    this.testing = undefined;
    part('test').textContent = 'Pull the body';
    part('results').dataset.done = 'yes';
    this.last = this.still = undefined;
    this.range = 0;
  }

  async test_picture(now) {
    if (this.rebuild) await this.settle();
    const interval = this.last === undefined ? 0 : 1e-3 * (now - this.last);
    this.last = now;
    if (this.testing === 'begins') {
      await this.ask({kind: 'test', strain: this.test_strain, steps: 20});
      if (!this.testing) return;
      this.testing = 'runs';
    }
    let answer;
    const begin = performance.now();
    do {
      answer = await this.ask({kind: 'test_step'});
      if (!answer.bodies || answer.bodies.length !== this.count_shown || !this.testing) return;
      answer.bodies.forEach((body, i) => {
        if (body.reading) this.readings[i].push(body.reading);
        this.problems[i] = body.problem;
      });
    } while (this.pace.slow && !answer.over && performance.now() - begin < 100);
    if (interval > 0) this.pace.note(interval, 1e-3 * (performance.now() - begin));
    this.viewer?.sharpen(this.pace.sharpness);
    if (this.viewer && answer.bodies.every(body => body.positions)) this.show_test(answer.bodies);
    this.show_results(answer.bodies);
    if (!answer.over) return;
    this.end_test();
    this.say_results();
  }

  show_test(bodies) {
    this.pictured = undefined;
    this.unmoved = 0;
    const {offsets, molecules} = this.shown, positions = new Float32Array(this.shown.rest.length);
    bodies.forEach((body, copy) => {
      for (let i = 0; i < 3 * molecules; ++i) positions[3 * molecules * copy + i] = body.positions[i] + (i % 3 ? 0 : offsets[copy]);
    });
    this.marks(bodies, positions);
    const strains = strains_of(this.shown, positions.map((v, i) => v - this.shown.rest[i]));
    this.range = strains.reduce((most, v) => Math.max(most, Math.abs(v)), 1e-9);
    this.show_legend('strain', 'signed');
    const mapped = numbers => colours_of('signed', numbers.map(v => v / this.range));
    this.viewer.set_state(positions, {connections: mapped(strains), molecules: mapped(means_of(this.shown, strains))});
  }

  /** What each strategy measured at the end of the test as it is; undefined of one that has not come there. */
  results() {
    return (this.readings ?? []).map((readings, i) => {
      const own = readings.find(reading => reading.own_end);
      const error = scene.no_error ? NaN : own?.modulus / own?.target - 1;
      return own && {...own, strategy: this.test_settings.strategies[i], error};
    });
  }

  show_results(bodies) {
    const results = this.results();
    part('results').replaceChildren(...results.map((result, i) => {
      const problem = bodies[i]?.problem;
      if (!result) return this.row(i, [problem ? 'none' : '…', '', ''], this.test_settings.strategies[i]);
      const row = this.row(i, [with_prefix(result.modulus, 'Pa', 4), error_text(result.error),
        Number.isFinite(result.ratio) ? result.ratio.toFixed(4) : '—'], result.strategy);
      row.dataset.modulus = result.modulus;
      row.dataset.ratio = result.ratio;
      return row;
    }));
    part('tested').hidden = false;
    part('target').textContent = this.target_words(results.filter(result => Number.isFinite(result?.error)));
    const problem = bodies.find(body => body.problem)?.problem;
    if (problem) complain(`The test of a body stops here: ${problem}.`);
    this.curves.test.set([...this.readings.map((readings, i) => ({name: this.test_settings.strategies[i], colour: series_colours[i],
      points: [[0, 0], ...readings.map(reading => [reading.strain, reading.stress])].sort((a, b) => a[0] - b[0])})), this.target()], 'Stress–strain curve of each strategy; dashed: the target E');
  }

  /** What the dashed line is, and what errors are to. */
  target_words(results) {
    const {E, nu} = this.test_settings, own = this.own_target(), ratio = scene.own_constants ? '' : `; its ν = ${+nu.toPrecision(4)}`;
    const strain = `a strain of ${+(100 * results[0]?.strain).toPrecision(3)} %`;
    const material = scene.bodies.length ? '' : `the material's E = ${with_prefix(E, 'Pa', 4)} at rest${ratio}. `;
    const begin = own ? `Dashed: the target of ${results[0].strategy}, E = ${with_prefix(own, 'Pa', 4)}; ` : material && 'Dashed: ';
    const targets = results.map(result => `${result.strategy} ${with_prefix(result.target, 'Pa', 4)}`).join(', ');
    return begin + material + (scene.no_error ? `No error: ${scene.no_error}.`
      : results.some(result => result.of_law) ? `Errors are to the law's own E at ${strain}: ${targets}.`
        : own ? `Errors are to the material's E at ${strain}, with all that it has along the load: ${targets}.` : '');
  }

  /** The target at the strain of the test, where it is another than the material's E at rest, as with fibres; else
   *  undefined. */
  own_target() {
    const own = this.results().find(result => Number.isFinite(result?.error))?.target;
    return Math.abs(own / this.test_settings.E - 1) > 1e-3 ? own : undefined;
  }

  target() {
    if (scene.bodies.length) return {name: 'target', points: []};  // of several materials there is none
    const strains = this.readings.flat().map(reading => reading.strain), end = strains.reduce((far, v) => Math.abs(v) > Math.abs(far) ? v : far, 0);
    return {name: 'target', colour: 'var(--faint)', dashed: true, points: [[0, 0], [end, (this.own_target() ?? this.test_settings.E) * end]]};
  }

  say_results() {
    root.dataset.tested = 'yes';
    const off = ({error}) => Number.isFinite(error) ? `${(100 * error).toFixed(2)} per cent off the target` : 'without a target';
    said(this.results().map((result, i) => `${this.test_settings.strategies[i]}: ` + (!result ? this.problems[i] ?? 'no result'
      : `E is ${with_prefix(result.modulus, 'Pa', 4)}, ${off(result)}`)).join('; '));
  }

  save_curve() {
    const rows = (this.readings ?? []).flatMap((readings, i) => readings.map(reading => [this.test_settings.strategies[i], reading.strain, reading.stress, reading.modulus, reading.ratio]));
    this.save_csv('tension', csv_of(['strategy', 'strain', 'stress_Pa', 'effective_modulus_Pa', 'poissons_ratio'], rows));
  }

  async copy_link() {
    const address = location.href.replace(/#.*/, '') + this.hash();
    history.replaceState(null, '', this.own_hash = this.hash());
    try {
      await navigator.clipboard.writeText(address);
      said('the link is copied');
      part('link').textContent = 'Copied';
    } catch {
      part('link').textContent = 'It is in the address bar';
    }
    setTimeout(() => { part('link').textContent = 'Copy a link with these settings'; }, 2000);
  }
}

async function open_lab() {
  const missing = typeof WebAssembly === 'undefined' ? 'This browser has no WebAssembly, which Elastin runs in'
    : typeof DecompressionStream === 'undefined' ? 'This browser cannot unpack the page' : '';
  if (missing) return complain(`${missing}. Chrome 95, Firefox 113 and Safari 16.4 or newer can.`);
  const lab = window.lab = new Lab(body_from(JSON.parse(await unpacked(part('view').textContent))));
  part('view').remove();
  await lab.open_viewer();
  try {
    await lab.begin();
  } catch (problem) {
    complain(`Elastin could not start here: ${problem.message}. Chrome 95, Firefox 113 and Safari 16.4 or newer run it.`);
  }
  root.dataset.ready = 'yes';
}
open_lab();
