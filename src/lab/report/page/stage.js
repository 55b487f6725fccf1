// The body's part of a page: which strategy, which colour, which state, and its controls. Needs body.js, colours.js, viewer.js.
'use strict';

const colour_kinds = {
  tension: {title: 'tension of the connections', unit: 'N'},
  strain: {title: 'strain', unit: ''},
  displacement: {title: 'displacement', unit: 'm'},
  error: {title: 'distance from the best', unit: 'm'},
};

class Stage {
  /** body and runs (states by strategy, see body.js) of one scene; section holds the controls, each with its data-part. */
  constructor(section, body, runs) {
    this.part = name => section.querySelector(`[data-part="${name}"]`);
    this.canvas = section.querySelector('.view canvas');
    this.body = body;
    this.runs = runs;
    this.best = section.dataset.best;
    this.ranges = new Map();
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
    if (this.run) this.show();
  }

  fill_controls() {
    const strategy = this.part('strategy'), known = this.runs.has(this.best);
    for (const name of this.runs.keys()) strategy.append(new Option(name === this.best ? name + ' (best)' : name, name));
    if (known) strategy.value = this.best;
    else this.part('colour').querySelector('[value=error]').remove();
    const shown = {connections: true, molecules: !this.body.membrane, surface: this.body.membrane};
    for (const [name, on] of Object.entries(shown)) {
      this.part(name).checked = on;
      this.part(name).disabled = name === 'surface' && !this.body.surface.length;
    }
    // Displacements are enlarged to an eighth of the body where nobody could see them otherwise.
    let longest = 0;
    for (const {frames} of this.runs.values())
      for (const frame of frames) longest = lengths_of(frame.displacements).reduce((a, b) => Math.max(a, b), longest);
    const most = longest > 0 ? Math.max(1, round_down(0.12 * this.body.size / longest)) : 1, scale = this.part('scale');
    for (const times of [...new Set([1, round_down(Math.sqrt(most)), most])])
      scale.append(new Option(times === 1 ? 'true to scale' : `× ${times.toLocaleString('en')}`, times));
    scale.value = longest < 0.03 * this.body.size ? most : 1;
  }

  listen() {
    this.silence = new AbortController();
    const on = (name, kind, does) => this.part(name).addEventListener(kind, does, {signal: this.silence.signal});
    on('strategy', 'change', () => this.choose());
    on('scale', 'change', () => this.aim());
    on('colour', 'change', () => this.show());
    on('step', 'input', () => { this.pause(); this.show(); });
    on('play', 'click', () => this.playing ? this.pause() : this.play());
    for (const name of this.shapes) on(name, 'change', () => this.look());
    this.canvas.addEventListener('pointermove', event => this.tell(event), {signal: this.silence.signal});
  }

  /** Another strategy: its last state. */
  choose() {
    this.pause();
    this.run = this.runs.get(this.part('strategy').value);
    const {frames, in_time} = this.run, step = this.part('step');
    step.max = frames.length - 1;
    step.step = in_time || frames.length < 2 ? 1 : 0.02;
    step.value = frames.length - 1;
    this.part('steps').hidden = frames.length < 2;
    this.aim();
  }

  /** The picture holds the body at rest and at the end; of a motion every state. */
  aim() {
    const {frames, in_time} = this.run, times = +this.part('scale').value;
    const states = (in_time ? frames : frames.slice(-1)).map(frame => positions_of(this.body, frame.displacements, times));
    this.viewer.fit(in_time ? states : [this.body.rest, ...states]);
    this.show();
  }

  play() {
    const step = this.part('step'), last = +step.max, length = this.run.in_time ? 4000 : 2000;  // ms
    const first = +step.value < last ? +step.value : 0, begin = performance.now();
    const tick = () => {
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
    cancelAnimationFrame(this.playing);
    this.playing = undefined;
    this.mark_playing();
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
    const best = this.runs.get(this.best).frames;
    const beside = state_at(best, position / (this.run.frames.length - 1 || 1) * (best.length - 1));
    return {molecules: lengths_of(state.displacements, beside.displacements)};
  }

  /** Numbers of everything that is shown: what has none of its own has the mean of its connections. */
  shown_values(state, position) {
    const values = this.values(state, position), {look} = this.viewer;
    values.molecules ??= means_of(this.body, values.connections);
    const seen = [look.connections && (values.connections ?? values.molecules), look.surface && (values.faces ?? values.molecules),
      look.molecules && values.molecules].filter(numbers => numbers?.length);
    return {values, seen};
  }

  /** One range for all states, so that the slider shows growth: from the largest compression to as large a pull where there
   *  is both; otherwise from the least to the most of the end. It is that of what is seen, so that faces alone have all
   *  colours, too. */
  range() {
    const {frames} = this.run, kind = this.part('colour').value;
    const key = [kind, this.part('strategy').value, ...Object.values(this.viewer.look)].join();
    if (this.ranges.has(key)) return this.ranges.get(key);
    let low = Infinity, high = -Infinity;
    const widen = position => this.shown_values(frames[position], position).seen.slice(0, 2).forEach(numbers =>
      numbers.forEach(v => { low = Math.min(low, v); high = Math.max(high, v); }));
    widen(frames.length - 1);
    if (!(low <= high)) low = high = 0;  // nothing is shown
    if (kind !== 'tension' && kind !== 'strain') low = 0;
    let range = {low, high, map: 'rising'};
    if (low < -0.02 * high && high > -0.02 * low) {
      frames.forEach((_, position) => widen(position));
      high = Math.max(high, -low);
      range = {low: -high, high, map: 'signed'};
    }
    this.ranges.set(key, range);
    return range;
  }

  show() {
    const {viewer, run: {frames, in_time}} = this, position = +this.part('step').value, state = state_at(frames, position);
    const {values} = this.shown_values(state, position), {low, high, map} = this.range();
    const colours = numbers => numbers && colours_of(map, numbers.map(v => map === 'signed' ? v / high : (v - low) / (high - low || 1)));
    viewer.set_state(positions_of(this.body, state.displacements, +this.part('scale').value),
      {connections: colours(values.connections), molecules: colours(values.molecules), faces: colours(values.faces)});
    this.state = {...state, values};
    this.part('at').textContent = in_time ? with_prefix(state.at, 's') : `${(100 * state.at).toFixed(0)} % of the load`;
    this.show_legend();
  }

  text_of(value) {
    const kind = this.part('colour').value;
    return kind === 'strain' ? `${(100 * value).toPrecision(3)} %` : with_prefix(value, colour_kinds[kind].unit);
  }

  legend() {
    const {low, high, map} = this.range();
    return {title: colour_kinds[this.part('colour').value].title, map, low: this.text_of(low), high: this.text_of(high)};
  }

  show_legend() {
    const {title, map, low, high} = this.legend();
    this.part('title').textContent = title;
    this.part('low').textContent = low;
    this.part('high').textContent = high;
    this.part('ramp').style.background = `linear-gradient(90deg,${legend_colours(map)})`;
    this.canvas.setAttribute('aria-label', `The body with ${this.part('strategy').value}, coloured by ${title} from ${low} to ${high}; arrow keys turn it, + and - zoom, 0 resets`);
  }

  /** The molecule under the pointer, in words. */
  tell(event) {
    const box = this.canvas.getBoundingClientRect();
    const molecule = event.buttons ? -1 : this.viewer.molecule_at(event.clientX - box.left, event.clientY - box.top);
    const {values, displacements} = this.state;
    const far = Math.hypot(...displacements.subarray(3 * molecule, 3 * molecule + 3));
    this.canvas.title = molecule < 0 ? '' : `molecule ${this.body.note ? '' : molecule + ': '}displaced by ${with_prefix(far, 'm')}` +
      (values.connections ? `, mean ${this.part('colour').value} ${this.text_of(values.molecules[molecule])}` : '');
  }

  picture() { return this.viewer.picture(this.legend()); }

  /** Lets go of the graphics memory; the canvas is replaced, for a browser gives one of them one context for its life. */
  release() {
    this.pause();
    this.silence.abort();
    this.viewer.release();
    this.canvas.replaceWith(this.canvas.cloneNode());
  }
}
