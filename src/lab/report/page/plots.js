// Plots under a visitor's hand: crosshair with values, box zoom, series that are switched off in the legend. What is drawn
// first stands in the page; this draws it again in another range. Needs colours.js.
'use strict';

const svg_element = (name, attributes = {}) => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};

/** A value on an axis {unit} in words, with this many digits. */
function axis_text(value, {unit}, digits = 4) {
  if (unit === '%') return `${+(100 * value).toPrecision(digits)} %`;
  if (unit && !/[/^ ]/.test(unit)) return with_prefix(value, unit, digits);
  return `${+value.toPrecision(digits)}${unit ? ' ' + unit : ''}`;
}

/** Round values from low to high, some five of them; of a logarithmic axis low and high are logarithms. */
function ticks_of(low, high, logarithmic) {
  if (logarithmic && high - low > 1) {
    const every = Math.ceil((high - low) / 7), ticks = [];
    for (let decade = Math.ceil(low - 1e-9); decade <= high + 1e-9; decade += every) ticks.push(10 ** decade);
    return ticks;
  }
  const [from, to] = logarithmic ? [10 ** low, 10 ** high] : [low, high];
  const step = round_down((to - from) / 3.2), ticks = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to * (1 + 1e-12); ++i) ticks.push(i * step);
  return ticks;
}

class PlotView {
  /** data: what plot_json of src/lab/report/plot.h writes. section: the scene, whose visitor's choices the plot follows. */
  constructor(svg, data, section) {
    Object.assign(this, {svg, data, section});
    [this.left, this.top, this.right, this.bottom] = svg.dataset.box.split(' ').map(Number);
    const [x_low, x_high, y_low, y_high] = svg.dataset.range.split(' ').map(Number);
    this.whole = this.range = {x: [x_low, x_high], y: [y_low, y_high]};
    this.ticks = svg.querySelector('.ticks');
    this.first_ticks = this.ticks.innerHTML;
    this.series = [...svg.querySelectorAll('.series')].map((group, i) => ({group, ...data.series[i],
      line: group.querySelector('.line'), marks: [...group.children].filter(child => !child.classList.contains('line'))}));
    const clip = svg_element('clipPath', {id: `clip-${PlotView.count = (PlotView.count ?? 0) + 1}`});
    clip.append(svg_element('rect', {x: this.left - 8, y: this.top - 8, width: this.right - this.left + 16, height: this.bottom - this.top + 16}));
    this.cross = svg_element('path', {class: 'cross'});
    this.frame = svg_element('rect', {class: 'frame', visibility: 'hidden'});
    svg.append(clip, this.cross, this.frame);
    for (const {group} of this.series) group.setAttribute('clip-path', `url(#${clip.id})`);
    this.listen();
  }

  /** Where a point lies [px of the drawing] in a range. */
  place([x, y], range = this.range) {
    const share = (value, axis, [low, high]) => ((this.data[axis].logarithmic ? Math.log10(value) : value) - low) / (high - low);
    return [this.left + share(x, 'x', range.x) * (this.right - this.left), this.bottom - share(y, 'y', range.y) * (this.bottom - this.top)];
  }

  /** The value of an axis at a share of its length. */
  value(axis, share) {
    const [low, high] = this.range[axis], at = low + share * (high - low);
    return this.data[axis].logarithmic ? 10 ** at : at;
  }

  zoom(range) {
    this.range = range;
    for (const {line, marks, points, stairs} of this.series) {
      const places = points.map(point => this.place(point)), text = v => v.toFixed(1);
      line?.setAttribute('d', places.map(([x, y], i) => !i ? `M${text(x)} ${text(y)}` : stairs ? `H${text(x)}V${text(y)}` : `L${text(x)} ${text(y)}`).join(''));
      marks.forEach((mark, i) => {
        const [x, y] = this.place(points[i], this.whole);
        mark.setAttribute('transform', `translate(${text(places[i][0] - x)} ${text(places[i][1] - y)})`);
      });
    }
    const level = this.svg.querySelector('.level');
    if (level) level.style.visibility = range === this.whole ? '' : 'hidden';
    if (range === this.whole) this.ticks.innerHTML = this.first_ticks;
    else this.draw_ticks();
    this.hide();
    this.svg.dispatchEvent(new Event('zoomed'));
  }

  draw_ticks() {
    this.ticks.replaceChildren();
    const label = (x, y, anchor, text) => {
      const element = svg_element('text', {x, y, 'text-anchor': anchor});
      element.textContent = text;
      this.ticks.append(element);
    };
    const digits = axis => {
      const ticks = ticks_of(...this.range[axis], this.data[axis].logarithmic), most = Math.max(...ticks.map(Math.abs));
      const gap = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : most;
      return {ticks, digits: Math.min(9, Math.max(1, Math.ceil(Math.log10(most / gap || 1)) + 1))};
    };
    const x = digits('x'), y = digits('y');
    for (const value of x.ticks) {
      const [at] = this.place([value, this.value('y', 0)]);
      this.ticks.append(svg_element('path', {class: 'grid', d: `M${at} ${this.top}V${this.bottom}`}));
      label(at, this.bottom + 18, 'middle', axis_text(value, this.data.x, x.digits));
    }
    for (const value of y.ticks) {
      const [, at] = this.place([this.value('x', 0), value]);
      this.ticks.append(svg_element('path', {class: 'grid', d: `M${this.left} ${at}H${this.right}`}));
      label(this.left - 7, at + 4, 'end', axis_text(value, this.data.y, y.digits));
    }
  }

  /** Shows and hides series by their names. */
  set_hidden(names) {
    for (const {group, name} of this.series) group.classList.toggle('off', names.has(name));
    for (const key of this.svg.querySelectorAll('.key')) {
      key.classList.toggle('off', names.has(key.dataset.series));
      key.setAttribute('aria-pressed', !names.has(key.dataset.series));
    }
    this.hide();
  }

  position_of(event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [at.x, at.y];
  }

  inside([x, y]) { return x >= this.left - 6 && x <= this.right + 6 && y >= this.top - 6 && y <= this.bottom + 6; }

  /** The nearest point of a series that is shown, within some pixels: {series, index, at}. */
  nearest([x, y], reach = 28) {
    let found;
    for (const series of this.series)
      if (series.name && !series.group.classList.contains('off'))
        series.points.forEach((point, index) => {
          const at = this.place(point), distance = Math.hypot(at[0] - x, at[1] - y);
          if (this.inside(at) && distance < reach) [reach, found] = [distance, {series, index, at}];
        });
    return found;
  }

  hover(event) {
    const position = this.position_of(event);
    if (!this.inside(position)) return this.hide();
    const point = this.nearest(position), [x, y] = point?.at ?? position;
    this.cross.setAttribute('d', `M${x} ${this.top}V${this.bottom}M${this.left} ${y}H${this.right}`);
    this.cross.style.visibility = 'visible';
    const values = point ? point.series.points[point.index]
      : [this.value('x', (x - this.left) / (this.right - this.left)), this.value('y', (this.bottom - y) / (this.bottom - this.top))];
    const mark = point?.series.marks[point.index], label = mark?.getAttribute('aria-label');
    const text = label ?? `${point ? point.series.name + ': ' : ''}${this.data.x.title} ${axis_text(values[0], this.data.x)}, ${this.data.y.title} ${axis_text(values[1], this.data.y)}`;
    const at = new DOMPoint(x, y).matrixTransform(this.svg.getScreenCTM());
    show_tip(text, {left: at.x, width: 0, top: at.y, bottom: at.y});
  }

  hide() {
    this.cross.style.visibility = 'hidden';
    hide_tip();
  }

  listen() {
    const {svg} = this;
    let from;
    svg.addEventListener('pointerdown', event => {
      if (event.button || event.pointerType === 'touch' || event.target.closest('.key') || !this.inside(this.position_of(event))) return;
      from = this.position_of(event);
      svg.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    svg.addEventListener('pointermove', event => {
      if (!from) return this.hover(event);
      const [x, y] = this.clamped(this.position_of(event));
      Object.entries({x: Math.min(x, from[0]), y: Math.min(y, from[1]), width: Math.abs(x - from[0]), height: Math.abs(y - from[1]), visibility: 'visible'})
        .forEach(([key, value]) => this.frame.setAttribute(key, value));
      this.hide();
    });
    svg.addEventListener('pointerup', event => {
      if (!from) return;
      const [x, y] = this.clamped(this.position_of(event)), [x0, y0] = this.clamped(from);
      from = undefined;
      this.frame.setAttribute('visibility', 'hidden');
      if (Math.abs(x - x0) > 6 && Math.abs(y - y0) > 6) return this.zoom_to(Math.min(x, x0), Math.max(x, x0), Math.min(y, y0), Math.max(y, y0));
      const point = this.nearest(this.position_of(event));
      if (point) svg.dispatchEvent(new CustomEvent('choose', {detail: point.series.name, bubbles: true}));
    });
    svg.addEventListener('pointerleave', () => this.hide());
    svg.addEventListener('dblclick', () => this.zoom(this.whole));
  }

  clamped([x, y]) { return [Math.max(this.left, Math.min(this.right, x)), Math.max(this.top, Math.min(this.bottom, y))]; }

  /** Zooms to what lies between these pixels of the drawing. */
  zoom_to(left, right, top, bottom) {
    const {x, y} = this.range;
    const cut = ([low, high], from, to) => [low + from * (high - low), low + to * (high - low)];
    const wide = this.right - this.left, tall = this.bottom - this.top;
    this.zoom({x: cut(x, (left - this.left) / wide, (right - this.left) / wide), y: cut(y, (this.bottom - bottom) / tall, (this.bottom - top) / tall)});
  }
}

/** All plots of a scene, with their legends and buttons. */
function plots_of(section) {
  const hidden = new Set(), views = [];
  for (const script of section.querySelectorAll('script.plot')) {
    const data = JSON.parse(script.textContent), card = script.closest('.card');
    const reset = Object.assign(document.createElement('button'), {type: 'button', textContent: 'whole plot', hidden: true});
    reset.dataset.zoom = 'reset';
    card.querySelector('.bar').append(reset);
    const own = [...card.querySelectorAll('svg')].map(svg => new PlotView(svg, data, section));
    reset.addEventListener('click', () => own.forEach(view => view.zoom(view.whole)));
    for (const view of own) view.svg.addEventListener('zoomed', () => { reset.hidden = own.every(one => one.range === one.whole); });
    views.push(...own);
  }
  const toggle = name => {
    if (!hidden.delete(name)) hidden.add(name);
    for (const view of views) view.set_hidden(hidden);
  };
  for (const view of views)
    for (const key of view.svg.querySelectorAll('.key')) {
      Object.entries({role: 'button', tabindex: 0, 'aria-pressed': true}).forEach(([name, value]) => key.setAttribute(name, value));
      key.addEventListener('click', () => toggle(key.dataset.series));
      key.addEventListener('keydown', event => {
        if (event.key !== 'Enter' && event.key !== ' ') return;
        event.preventDefault();
        toggle(key.dataset.series);
      });
    }
  return views;
}
