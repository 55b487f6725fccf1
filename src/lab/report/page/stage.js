// The body's part of a page: which strategy, which colour, which state, and its controls. Needs body.js, colours.js, viewer.js, slice.js.
'use strict';

/** What can be coloured; `field`: of the states, of which one at least is not 0 everywhere; `shape`: on what it stands. */
const colour_kinds = {
  tension: {title: 'tension of the connections', unit: 'N', field: 'tensions', shape: 'connections'},
  strain: {title: 'strain', unit: ''},
  stress: {title: 'von Mises stress', unit: 'Pa', field: 'stresses', shape: 'surface'},
  displacement: {title: 'displacement', unit: 'm'},
  force: {title: 'reaction or load of a molecule', unit: 'N', field: 'forces'},
  pressure: {title: 'contact pressure', unit: 'Pa', field: 'pressures', shape: 'surface'},
  error: {title: 'distance from the best', unit: 'm'},
};

class Stage {
  /** body and runs (states by strategy, see body.js, with the frequency [Hz] of each that is a mode) of one scene; section holds the controls, each with its data-part. */
  constructor(section, body, runs) {
    this.section = section;
    this.part = name => section.querySelector(`[data-part="${name}"]`);
    this.canvas = section.querySelector('.view canvas');
    this.body = body;
    this.runs = runs;
    for (const run of runs.values()) run.modes = run.frequencies?.some(Number.isFinite);
    this.best = section.dataset.best;
    this.ranges = new Map();
    this.typed = new Map();
    colour_kinds.stress.unit = body.membrane ? 'N/m' : 'Pa';
    this.shapes = ['connections', 'molecules', 'surface'];
    this.viewer = this.canvas.viewer = new Viewer(this.canvas);
    this.viewer.set_body(body);
    if (!this.part('strategy').options.length) this.fill_controls();
    this.listen();
    this.look();
    this.choose();
  }

  /** What the boxes say is drawn. */
  look() {
    this.viewer.set_look(Object.fromEntries(this.shapes.map(name => [name, this.part(name).checked])));
    this.note_inside();
    if (this.run) this.show();
  }

  fill_controls() {
    const strategy = this.part('strategy'), known = this.runs.has(this.best);
    for (const name of this.runs.keys()) strategy.append(new Option(name === this.best ? `${name} (${this.section.dataset.bestWord})` : name, name));
    if (known) strategy.value = this.best;
    const has_field = field => [...this.runs.values()].some(({frames}) => frames.some(frame => frame[field]));
    const has = field => [...this.runs.values()].some(({frames}) => frames.some(frame => frame[field]?.some(value => value)));
    const strained = this.body.ends.length + this.body.surface.length > 0;
    for (const [kind, {field}] of Object.entries(colour_kinds))
      if (kind === 'error' ? known : kind === 'strain' ? strained : !field || has(field)) this.part('colour').append(new Option(colour_kinds[kind].title, kind));
    // Solids are seen by the stress on their surface, graphs of springs by their connections.
    const solid = !this.body.membrane && has('stresses');
    const of_modes = [...this.runs.values()].some(run => run.modes);
    if (of_modes) this.part('colour').value = 'displacement';
    else if (solid) this.part('colour').value = 'stress';
    const shown = {connections: !solid, molecules: !solid && !this.body.membrane, surface: solid || this.body.membrane};
    for (const [name, on] of Object.entries(shown)) {
      this.part(name).checked = on;
      this.part(name).disabled = name === 'surface' && !this.body.surface.length;
    }
    // Displacements are enlarged to an eighth of the body where nobody could see them otherwise, unless the body touches something:
    // bodies that are drawn enlarged lie in each other.
    let longest = 0;
    for (const {frames} of this.runs.values())
      for (const frame of frames) longest = lengths_of(frame.displacements).reduce((a, b) => Math.max(a, b), longest);
    const most = longest > 0 && !this.body.obstacles.length ? Math.max(1, round_down(0.12 * this.body.size / longest)) : 1, scale = this.part('scale');
    const touches = has_field('pressures');
    for (const times of [...new Set([1, round_down(Math.sqrt(most)), most])])
      scale.append(new Option(times !== 1 ? `× ${times.toLocaleString('en')}` : of_modes ? 'shape of the mode, enlarged' : 'true to scale', times));
    scale.value = longest < 0.03 * this.body.size && !touches ? most : 1;
  }

  listen() {
    this.silence = new AbortController();
    const on = (name, kind, does) => this.part(name).addEventListener(kind, does, {signal: this.silence.signal});
    on('strategy', 'change', () => this.choose());
    on('scale', 'change', () => this.aim());
    on('colour', 'change', () => this.choose_colour());
    for (const end of ['low', 'high']) on(end, 'change', () => this.type_range());
    on('cut', 'change', () => this.cut());
    on('cut_at', 'input', () => this.cut());
    on('step', 'input', () => { this.pause(); this.show(); });
    on('play', 'click', () => this.playing ? this.pause() : this.play());
    for (const name of this.shapes) on(name, 'change', () => this.look());
    const on_canvas = (kind, does) => this.canvas.addEventListener(kind, does, {signal: this.silence.signal});
    let from = [0, 0];
    on_canvas('pointerdown', event => { from = [event.clientX, event.clientY]; });
    on_canvas('click', event => {
      if (Math.hypot(event.clientX - from[0], event.clientY - from[1]) < 5) this.pick(event);
    });
  }

  /** Another strategy by the name of its run, which of a study says more. */
  choose_strategy(name) {
    const strategy = [name, name.split(', ')[0]].find(known => this.runs.has(known));
    if (!strategy || strategy === this.part('strategy').value) return;
    this.part('strategy').value = strategy;
    this.choose();
  }

  /** What the colour stands on is shown: faces, or connections without the faces that would hide them. */
  choose_colour() {
    const {shape} = colour_kinds[this.part('colour').value], box = shape && this.part(shape);
    if (box && !box.disabled && !box.checked) {
      box.checked = true;
      if (shape === 'connections') this.part('surface').checked = false;
      this.look();
    }
    this.show();
  }

  /** The ends of the colours as they are typed; nothing, or no number, gives them back. */
  type_range() {
    const kind = this.part('colour').value, {unit} = colour_kinds[kind];
    const [low, high] = ['low', 'high'].map(end => without_prefix(this.part(end).value, unit));
    if (low === undefined || high === undefined || !(low < high)) this.typed.delete(kind);
    else this.typed.set(kind, {low, high, map: Math.abs(low + high) < 1e-6 * high ? 'signed' : 'rising'});
    this.show();
  }

  /** What lies before a plane, on the eye's side of it when it was chosen, is not drawn. */
  cut() {
    const axis = 'xyz'.indexOf(this.part('cut').value || '?');
    this.part('cut_at').hidden = axis < 0;
    if (axis !== this.cut_axis) this.cut_side = axis < 0 ? 0 : this.viewer.side_of_eye(axis);
    this.cut_axis = axis;
    this.viewer.set_cut(axis, this.cut_side, +this.part('cut_at').value);
    this.note_inside();
    this.show_slice();
  }

  /** Of a solid the faces of its surface alone are known: behind a cut they are a shell. */
  note_inside() {
    const {viewer: {look}, body} = this, note = this.part('inside'), inner = body.radius.length > new Set(body.surface).size;
    note.hidden = !(this.cut_axis >= 0) || body.membrane || !look.surface || look.connections || look.molecules;
    note.textContent = 'The surface alone is drawn' + (inner ? ': connections and molecules show the inside.' : '.');
  }

  /** The image that the body was made of, in the plane of the cut. */
  show_slice() {
    const {image} = this.body, slice = this.slice ??= document.createElement('canvas');
    slice.remove();
    if (!image || !(this.cut_axis >= 0)) return;
    this.canvas.parentElement.append(Object.assign(slice, {className: 'slice', width: 220, height: 220}));
    draw_slice(slice, image, this.body, this.viewer.positions, this.cut_axis, this.cut_side * this.viewer.cut.w);
  }

  /** Another strategy: its last state; of vibrations the first mode. */
  choose() {
    this.pause();
    this.run = this.runs.get(this.part('strategy').value);
    const {frames, in_time, modes} = this.run, step = this.part('step');
    step.max = frames.length - 1;
    step.step = in_time || modes || frames.length < 2 ? 1 : 0.02;
    step.value = modes ? 1 : frames.length - 1;
    this.part('steps').hidden = frames.length < 2;
    this.aim();
  }

  /** The picture holds the body at rest and at the end; of a motion every state. */
  aim() {
    const {frames, in_time, modes} = this.run, times = +this.part('scale').value;
    const states = (in_time || modes ? frames : frames.slice(-1)).flatMap(frame =>
      (modes ? [times, -times] : [times]).map(scale => positions_of(this.body, frame.displacements, scale)));
    this.viewer.fit(in_time ? states : [this.body.rest, ...states]);
    this.show();
  }

  play() {
    const step = this.part('step'), last = +step.max, length = this.run.in_time ? 4000 : 2000;  // ms
    const first = +step.value < last ? +step.value : 0, begin = performance.now();
    if (this.run.modes) step.value = +step.value || 1;
    const tick = this.run.modes ? () => {  // a mode swings about the rest until it is paused
      this.swing = Math.cos(2 * Math.PI * (performance.now() - begin) / 1500);
      this.show();
      this.playing = requestAnimationFrame(tick);
    } : () => {
      const position = Math.min(last, first + (performance.now() - begin) / length * last);
      step.value = position;
      this.show();
      if (position < last) this.playing = requestAnimationFrame(tick);
      else this.pause();
    };
    this.playing = requestAnimationFrame(tick);
    this.mark_playing();
  }

  pause() {
    const swung = this.playing && this.run.modes;
    cancelAnimationFrame(this.playing);
    this.playing = undefined;
    this.swing = 1;
    this.mark_playing();
    if (swung) this.show();
  }

  mark_playing() {
    const button = this.part('play');
    button.textContent = this.playing ? '❚❚' : '▶';
    button.setAttribute('aria-label', this.playing ? 'pause' : 'play');
  }

  /** What is coloured in one state, position between 0 and the last frame: numbers of connections, molecules or faces. */
  values(state, position) {
    const kind = this.part('colour').value;
    if (kind === 'tension') return {connections: state.tensions};
    if (kind === 'strain') return {connections: strains_of(this.body, state.displacements), faces: face_strains_of(this.body, state.displacements)};
    if (kind === 'displacement') return {molecules: lengths_of(state.displacements)};
    if (kind === 'stress') {
      const faces = state.stresses ?? new Float32Array(this.body.surface.length / 3);
      return {faces, molecules: means_of_faces(this.body, faces)};
    }
    if (kind === 'force' || kind === 'pressure')
      return {molecules: state[colour_kinds[kind].field] ?? new Float32Array(this.body.radius.length)};
    const best = this.runs.get(this.best).frames;
    const compared = state_at(best, position / (this.run.frames.length - 1 || 1) * (best.length - 1));
    return {molecules: lengths_of(state.displacements, compared.displacements)};
  }

  /** Numbers of everything that is shown: what has none of its own has the mean of its connections. */
  shown_values(state, position) {
    const values = this.values(state, position), {look} = this.viewer;
    values.molecules ??= means_of(this.body, values.connections);
    const seen = [look.connections && (values.connections ?? values.molecules), look.surface && (values.faces ?? values.molecules),
      look.molecules && values.molecules].filter(numbers => numbers?.length);
    return {values, seen};
  }

  /** Strains that displacements do not resolve: they come in steps of 2⁻²⁰ of the largest one (view.cpp). */
  strain_noise() {
    const {rest, ends, surface} = this.body;
    const length = (a, b) => Math.hypot(...[0, 1, 2].map(k => rest[3 * a + k] - rest[3 * b + k])) || Infinity;
    let shortest = Infinity, longest = 0;
    for (let i = 0; i < ends.length; i += 2) shortest = Math.min(shortest, length(ends[i], ends[i + 1]));
    for (let i = 0; i < surface.length; i += 3) shortest = Math.min(shortest, length(surface[i], surface[i + 1]));
    for (const {displacements} of this.run.frames) longest = lengths_of(displacements).reduce((a, b) => Math.max(a, b), longest);
    return 2 ** -19 * longest / shortest;
  }

  /** One range for all states, so that the slider shows growth: from the largest compression to as large a pull where there
   *  is both; otherwise from the least to the most of the state with the largest value, or from 0 where nothing is below it. It is
   *  that of what is seen, so that faces alone have all colours, too. */
  range() {
    const kind = this.part('colour').value;
    if (this.typed.has(kind)) return this.typed.get(kind);
    const key = [kind, this.part('strategy').value, ...Object.values(this.viewer.look)].join();
    if (!this.ranges.has(key)) this.ranges.set(key, this.range_of(kind));
    return this.ranges.get(key);
  }

  range_of(kind) {
    const ends = this.run.frames.map((frame, position) => {
      let low = Infinity, high = -Infinity;
      for (const numbers of this.shown_values(frame, position).seen.slice(0, 2))
        numbers.forEach(v => { low = Math.min(low, v); high = Math.max(high, v); });
      return low <= high ? {low, high} : {low: 0, high: 0};  // nothing is shown
    });
    const size = ({low, high}) => Math.max(-low, high), largest = ends.reduce((most, end) => size(end) >= size(most) ? end : most);
    if (kind === 'strain' && size(largest) < this.strain_noise()) return {low: 0, high: 0, map: 'rising'};
    const least = Math.min(...ends.map(({low}) => low)), most = Math.max(...ends.map(({high}) => high));
    if (least < -0.02 * most && most > -0.02 * least) return {low: -size(largest), high: size(largest), map: 'signed'};
    let {low, high} = largest;
    // What differs by less than a thousandth has one colour: its differences are not worth a scale.
    const alike = high - low < 1e-3 * size(largest);
    if (alike) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
    if (kind !== 'tension' && kind !== 'strain') low = 0;
    return {low, high, map: 'rising'};
  }

  show() {
    const {viewer, run: {frames, in_time}} = this, position = +this.part('step').value, state = state_at(frames, position);
    const {values} = this.shown_values(state, position), {low, high, map} = this.range();
    const colours = numbers => numbers && colours_of(map, numbers.map(v => map === 'signed' ? v / high : (v - low) / (high - low || 1)));
    viewer.set_state(positions_of(this.body, state.displacements, this.swing * this.part('scale').value),
      {connections: colours(values.connections), molecules: colours(values.molecules), faces: colours(values.faces)});
    // Displacements that are drawn enlarged do not meet what the body touches.
    const to_scale = +this.part('scale').value === 1;
    viewer.set_lines(to_scale ? this.body.obstacles.flatMap(({lines}, i) => state[`pose ${i}`] ? [...lines_in_space(lines, state[`pose ${i}`])] : []) : []);
    this.state = {...state, values};
    this.show_picked();
    this.show_slice();
    this.part('at').textContent = in_time ? with_prefix(state.at, 's') : this.run.modes ? this.mode_text(position) : `${(100 * state.at).toFixed(0)} % of the load`;
    this.show_legend();
  }

  mode_text(position) {
    const {frames, frequencies} = this.run;
    return position > 0 ? `mode ${frames[position].at} of ${frames.at(-1).at}, ${with_prefix(frequencies[position], 'Hz')}` : 'without vibration';
  }

  text_of(value) {
    const kind = this.part('colour').value;
    return kind === 'strain' ? `${(100 * value).toPrecision(3)} %` : with_prefix(value, colour_kinds[kind].unit);
  }

  legend() {
    const {low, high, map} = this.range(), {title} = colour_kinds[this.part('colour').value];
    return {title: this.run.modes ? `${title}, of the enlarged mode` : title, map, low: this.text_of(low), high: this.text_of(high)};
  }

  show_legend() {
    const {title, map, low, high} = this.legend();
    this.part('title').textContent = title;
    this.part('low').value = low;
    this.part('high').value = high;
    this.part('ramp').style.background = `linear-gradient(90deg,${legend_colours(map)})`;
    this.canvas.setAttribute('aria-label', `The body with ${this.part('strategy').value}, coloured by ${title} from ${low} to ${high}; arrow keys turn it, + and - zoom, 0 resets`);
  }

  /** What is under the pointer is read below the picture until something else is clicked. */
  pick(event) {
    const box = this.canvas.getBoundingClientRect();
    this.picked = this.viewer.pick(event.clientX - box.left, event.clientY - box.top);
    this.viewer.set_picked(this.picked);
    this.show_picked();
  }

  show_picked() {
    const {picked, body} = this, place = this.part('picked');
    place.hidden = !picked;
    if (!picked) return;
    place.textContent = picked.molecule >= 0 ? this.molecule_text(picked.molecule) : this.face_text(picked.face);
  }

  number_of(molecule) { return this.body.numbers ? this.body.numbers[molecule] : molecule; }

  molecule_text(molecule) {
    const {state, body} = this, three = (numbers, k = 3 * molecule) => [0, 1, 2].map(i => with_prefix(numbers[k + i], 'm')).join(', ');
    const {values} = state, kind = this.part('colour').value;
    const texts = [`Molecule ${this.number_of(molecule)}: at rest (${three(body.rest)})`, `displacement (${three(state.displacements)})`];
    if (state.forces) texts.push(`reaction or load ${with_prefix(state.forces[molecule], 'N')}`);
    if (state.pressures) texts.push(`contact pressure ${with_prefix(state.pressures[molecule], 'Pa')}`);
    if (values.connections) texts.push(`mean ${kind} of its connections ${this.text_of(values.molecules[molecule])}`);
    return texts.join('; ') + '.';
  }

  face_text(face) {
    const {state, body} = this, corners = [...body.surface.slice(3 * face, 3 * face + 3)];
    const cell = body.cells[face], strain = face_strains_of(body, state.displacements)[face];
    const texts = [`${cell >= 0 ? `Cell ${cell}` : 'Face'}, side of molecules ${corners.map(molecule => this.number_of(molecule)).join(', ')}`,
      `strain ${(100 * strain).toPrecision(3)} %`];
    if (state.stresses) texts.push(`von Mises stress ${with_prefix(state.stresses[face], colour_kinds.stress.unit)}`);
    if (state.pressures) texts.push(`contact pressure ${with_prefix(corners.reduce((sum, molecule) => sum + state.pressures[molecule], 0) / 3, 'Pa')}`);
    return texts.join('; ') + '.';
  }

  picture() { return this.viewer.picture(this.legend()); }

  /** Frees the graphics memory; the canvas is replaced, for a browser gives one of them one context for its life. */
  release() {
    this.pause();
    this.silence.abort();
    this.viewer.release();
    this.slice?.remove();
    this.canvas.replaceWith(this.canvas.cloneNode());
  }
}
