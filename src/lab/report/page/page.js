// What the page does beyond showing itself: one scene at a time, tables that sort, plots that tell, bodies that turn.
'use strict';

const all = (what, within = document) => [...within.querySelectorAll(what)];
const root = document.documentElement;
addEventListener('error', event => { root.dataset.errors = (root.dataset.errors || '') + event.message + '; '; });

// --- tables -----------------------------------------------------------------------------------------------------------
function sort_by(head, column) {
  const body = head.closest('table').tBodies[0], falling = head.getAttribute('aria-sort') === 'ascending';
  const key = row => {
    const cell = row.cells[column];
    return cell?.dataset.v !== undefined ? +cell.dataset.v : cell?.textContent ?? '';
  };
  const order = (a, b) => typeof a === 'number' && typeof b === 'number' ? a - b
    : typeof a === 'number' ? -1 : typeof b === 'number' ? 1 : a.localeCompare(b, undefined, {numeric: true});
  body.append(...[...body.rows].sort((a, b) => (falling ? -1 : 1) * order(key(a), key(b))));
  all('th', head.parentElement).forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', falling ? 'descending' : 'ascending');
}
all('thead tr').forEach(row => [...row.cells].forEach((head, column) =>
  head.firstElementChild.addEventListener('click', () => sort_by(head, column))));

// --- plots ------------------------------------------------------------------------------------------------------------
const tip = document.body.appendChild(Object.assign(document.createElement('div'), {id: 'tip', role: 'status'}));
function tell(mark) {
  tip.textContent = mark.getAttribute('aria-label');
  const at = mark.getBoundingClientRect(), box = tip.getBoundingClientRect();
  tip.style.left = Math.max(8, Math.min(innerWidth - box.width - 8, at.left + at.width / 2 - box.width / 2)) + 'px';
  tip.style.top = (at.top - box.height - 8 < 8 ? at.bottom + 8 : at.top - box.height - 8) + 'px';
  tip.style.visibility = 'visible';
}
function single_out(section, name) {
  all('svg', section).forEach(svg => {
    const own = all('.series', svg).filter(series => series.dataset.series === name);
    svg.classList.toggle('told', own.length > 0);
    all('.series', svg).forEach(series => series.classList.toggle('on', own.includes(series)));
  });
}
all('svg .mark').forEach(mark => {
  mark.querySelector('title').remove();  // its aria-label says the same
  for (const kind of ['pointerenter', 'focus']) mark.addEventListener(kind, () => tell(mark));
  for (const kind of ['pointerleave', 'blur']) mark.addEventListener(kind, () => { tip.style.visibility = 'hidden'; });
});
all('.scene').forEach(section => {
  const name_of = target => target.closest('.key, .series')?.dataset.series || target.closest('tbody tr')?.cells[0].textContent;
  section.addEventListener('pointerover', event => single_out(section, name_of(event.target)));
  section.addEventListener('pointerleave', () => single_out(section, undefined));
});

function save(name, url) {
  Object.assign(document.createElement('a'), {download: name, href: url}).click();
}
function file_of(svg) {
  const copy = svg.cloneNode(true), style = getComputedStyle(root);
  const colour = name => style.getPropertyValue(name).trim();
  copy.insertAdjacentHTML('afterbegin', `<style>svg{${['--ink', '--faint', '--grid', '--paper'].map(n => `${n}:${colour(n)}`).join(';')};` +
    'background:var(--paper);font-family:system-ui,sans-serif}text{fill:var(--faint)}.axis{fill:var(--ink)}.grid{stroke:var(--grid)}</style>');
  return new XMLSerializer().serializeToString(copy);
}
all('button[data-save]').forEach(button => button.addEventListener('click', () => {
  const figure = button.closest('.card'), name = button.dataset.name;
  const canvas = figure.querySelector('canvas');
  if (canvas) {
    canvas.viewer.draw();
    return save(name + '.png', canvas.toDataURL('image/png'));
  }
  const svg = all('svg', figure).find(one => one.getClientRects().length);
  const text = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(file_of(svg));
  if (button.dataset.save === 'svg') return save(name + '.svg', text);
  const image = new Image();
  image.onload = () => {
    const paper = Object.assign(document.createElement('canvas'), {width: 2 * svg.viewBox.baseVal.width, height: 2 * svg.viewBox.baseVal.height});
    paper.getContext('2d').drawImage(image, 0, 0, paper.width, paper.height);
    save(name + '.png', paper.toDataURL('image/png'));
  };
  image.src = text;
}));

// --- bodies -----------------------------------------------------------------------------------------------------------
function with_prefix(value, unit) {
  for (const [factor, letter] of [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']])
    if (Math.abs(value) >= factor) return `${(value / factor).toPrecision(3)} ${letter}${unit}`;
  return `${value.toPrecision(3)} ${unit}`;
}

/** The number of the form 1, 2 or 5 times a power of ten that is not above. */
function round_down(value) {
  const decade = 10 ** Math.floor(Math.log10(value)), first = value / decade;
  return decade * (first >= 5 ? 5 : first >= 2 ? 2 : 1);
}

class Stage {
  constructor(section) {
    this.part = name => section.querySelector(`[data-part="${name}"]`);
    this.canvas = section.querySelector('canvas');
    const views = all('script.view', section).map(script => JSON.parse(script.textContent));
    this.body = unpack_body(views.find(view => view.kind === 'body'));
    this.runs = new Map(views.filter(view => view.kind === 'states').map(view => [view.strategy, {frames: unpack_states(view), in_time: view.in_time}]));
    this.best = section.dataset.best;
    this.viewer = this.canvas.viewer = new Viewer(this.canvas);
    for (const name of this.runs.keys()) this.part('strategy').append(new Option(name === this.best ? name + ' (best)' : name, name));
    if (this.runs.has(this.best)) this.part('strategy').value = this.best;
    if (!this.runs.has(this.best)) this.part('colour').querySelector('[value=error]').remove();
    Object.assign(this.viewer.look, {lines: true, spheres: !this.body.membrane, surface: this.body.membrane});
    for (const name of ['lines', 'spheres', 'surface']) {
      this.part(name).checked = this.viewer.look[name];
      this.part(name).disabled = name === 'surface' && !this.body.surface.length;
      this.part(name).addEventListener('change', event => { this.viewer.look[name] = event.target.checked; this.viewer.request(); });
    }
    this.part('strategy').addEventListener('change', () => this.choose());
    for (const name of ['colour', 'step', 'enlarge']) this.part(name).addEventListener('input', () => this.show());
    this.part('play').addEventListener('click', () => this.play());
    this.choose();
  }

  /** Another strategy: its last state; ways enlarged to a tenth of the body where nobody could see them otherwise. */
  choose() {
    this.run = this.runs.get(this.part('strategy').value);
    const {frames} = this.run, step = this.part('step');
    step.max = frames.length - 1;
    step.step = this.run.in_time ? 1 : frames.length > 1 ? 0.02 : 1;
    step.value = frames.length - 1;
    step.parentElement.hidden = frames.length < 2;
    const longest = Math.max(...[...this.runs.values()].map(run => Math.max(...run.frames.map(frame => sizes_of(frame.ways).reduce((a, b) => Math.max(a, b), 0)))));
    if (!this.part('enlarge').options.length) {
      const most = longest > 0 ? Math.max(1, round_down(0.12 * this.body.size / longest)) : 1;
      for (const times of [...new Set([1, round_down(Math.sqrt(most)), most])])
        this.part('enlarge').append(new Option(times === 1 ? 'true to scale' : `× ${times.toLocaleString('en')}`, times));
      this.part('enlarge').value = longest < 0.03 * this.body.size ? most : 1;
    }
    // Where the body goes is in the picture from the start.
    const end = frames[frames.length - 1].ways, times = +this.part('enlarge').value;
    const box = box_of([...this.body.rest, ...this.body.rest.map((v, i) => v + times * end[i])]);
    this.viewer.aim({middle: box_of(this.body.rest.map((v, i) => v + times * end[i])).middle, size: this.run.in_time ? box.size : (box.size + this.body.size) / 2});
    this.show();
  }

  play() {
    const step = this.part('step'), last = +step.max, begin = performance.now(), seconds = this.run.in_time ? 4 : 2;
    const tick = now => {
      const part = Math.min(1, (now - begin) / 1000 / seconds);
      step.value = part * last;
      this.show();
      if (part < 1) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** What is coloured in one state: values of connections or of molecules. */
  values(state, place) {
    const kind = this.part('colour').value;
    if (kind === 'tension') return {lines: state.tensions};
    if (kind === 'strain') return {lines: strains_of(this.body, state.ways)};
    if (kind === 'way') return {molecules: sizes_of(state.ways)};
    const best = this.runs.get(this.best).frames;
    return {molecules: sizes_of(state.ways, state_at(best, place / (this.run.frames.length - 1 || 1) * (best.length - 1)).ways)};
  }

  /** One scale for the whole course, so that the slider shows growth: from the largest push to as large a pull where there
   *  is both; otherwise from the least to the most of the end. */
  scale(kind) {
    this.scales ??= {};
    return this.scales[kind + this.part('strategy').value] ??= (() => {
      const {frames} = this.run, of = place => { const v = this.values(frames[place], place); return v.lines ?? v.molecules; };
      let low = Infinity, high = -Infinity;
      const take = array => array.forEach(v => { low = Math.min(low, v); high = Math.max(high, v); });
      take(of(frames.length - 1));
      if (kind !== 'tension' && kind !== 'strain') low = 0;
      if (!(low < -0.02 * high && high > -0.02 * low)) return {low, high: high > low ? high : low + 1e-300, signed: false};
      frames.forEach((frame, place) => take(of(place)));
      high = Math.max(high, -low);
      return {low: -high, high, signed: true};
    })();
  }

  show() {
    const {frames} = this.run, place = +this.part('step').value, state = state_at(frames, place);
    const kind = this.part('colour').value, values = this.values(state, place);
    const {low, high, signed} = this.scale(kind), of_scale = v => signed ? v / high : (v - low) / (high - low);
    const over = array => array && Float32Array.from(array, of_scale);
    const lines = over(values.lines), molecules = over(values.molecules ?? means_of(this.body, values.lines));
    const times = +this.part('enlarge').value;
    const places = this.body.rest.map((v, i) => v + times * state.ways[i]);
    this.viewer.show(this.body, places, {lines, molecules}, signed ? 0 : 1);
    this.part('at').textContent = this.run.in_time ? with_prefix(state.at, 's') : `${(100 * state.at).toFixed(0)} % of the load`;
    const unit = {tension: 'N', strain: '', way: 'm', error: 'm'}[kind];
    const told = v => kind === 'strain' ? `${(100 * v).toPrecision(3)} %` : v === 0 ? '0' : with_prefix(v, unit);
    this.part('low').textContent = told(low);
    this.part('high').textContent = told(high);
    this.part('ramp').style.background = signed ? 'linear-gradient(90deg,#1761ed,#9094a1,#e63326)' : 'linear-gradient(90deg,#452185,#21918c,#fadb33)';
    this.canvas.setAttribute('aria-label', `The body with ${this.part('strategy').value}, coloured by ${kind} up to ${told(high)}; arrow keys turn it, + and - zoom, 0 resets`);
  }
}

function stage(section) {
  if (section.staged || !section.querySelector('script.view')) return;
  section.staged = true;
  try {
    section.stage = new Stage(section);
  } catch (problem) {
    section.querySelector('.view').textContent = `No picture: ${problem.message}.`;
    root.dataset.errors = (root.dataset.errors || '') + problem.message + '; ';
  }
}

// --- scenes -----------------------------------------------------------------------------------------------------------
const scenes = all('.scene'), choice = document.getElementById('scene');
function go() {
  const wanted = scenes.find(section => '#' + section.id === location.hash) ?? scenes[0];
  scenes.forEach(section => { section.hidden = section !== wanted; });
  if (choice) choice.value = wanted.id;
  if (wanted) stage(wanted);
}
choice?.addEventListener('change', () => { location.hash = choice.value; });
addEventListener('hashchange', () => { go(); document.getElementById('scene')?.scrollIntoView({block: 'start'}); });
go();
root.dataset.ready = 'yes';
