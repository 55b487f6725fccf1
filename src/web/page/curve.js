// A plot that grows while one looks: lines in a figure, with the classes of the report's plots. Needs colours.js.
'use strict';

/** Round numbers from low to high, about this many. */
function ticks_between(low, high, about) {
  const step = round_down((high - low) / about * 1.001) || 1, ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) ticks.push(i * step);
  return ticks;
}

/** The factor and the letter of the prefix that suits a range of numbers. */
function prefix_for(most) {
  for (const [factor, letter] of [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n'], [1e-12, 'p']])
    if (most >= factor * 0.9999) return [factor, letter];
  return [1, ''];
}

class Curve {
  /** axes: {x: {title, unit, floating}, y: {title, unit}}; a unit "%" shows ratios in per cent; a floating axis need not begin
   *  at 0. */
  constructor(figure, axes) {
    this.figure = figure;
    this.axes = axes;
    this.series = [];
  }

  /** series: [{name, colour, points: [[x, y], …], dashed}]. The label is what a screen reader says. */
  set(series, label) {
    this.series = series;
    this.label = label;
    this.draw();
  }

  scale(axis, low, high) {
    const {title, unit} = this.axes[axis], most = Math.max(Math.abs(low), Math.abs(high));
    const [factor, letter] = unit === '%' ? [0.01, ''] : prefix_for(most);
    return {factor, title: `${title}${unit ? ` [${letter}${unit}]` : ''}`};
  }

  draw() {
    const width = Math.max(260, this.figure.clientWidth || 420), height = Math.round(Math.min(260, 0.62 * width));
    const [left, right, top, bottom] = [58, 12, 10, 40];
    const points = this.series.flatMap(one => one.points).filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
    const range = (k, {floating}) => {
      const values = points.map(point => point[k]), ends = floating ? values : [0, ...values], low = Math.min(...ends), high = Math.max(...ends);
      return high > low ? [low, high] : [0, 1];
    };
    const [[x0, x1], [y0, y1]] = [range(0, this.axes.x), range(1, this.axes.y)];
    const at = ([x, y]) => [left + (x - x0) / (x1 - x0) * (width - left - right), height - bottom - (y - y0) / (y1 - y0) * (height - top - bottom)];
    const x = this.scale('x', x0, x1), y = this.scale('y', y0, y1);
    const number = (value, scale) => String(+(value / scale.factor).toPrecision(4)).replace('-', '−');
    let inside = '';
    for (const tick of ticks_between(y0, y1, 4)) {
      const [, place] = at([x0, tick]);
      inside += `<line class="grid" x1="${left}" x2="${width - right}" y1="${place}" y2="${place}"/>` +
        `<text x="${left - 6}" y="${place + 4}" text-anchor="end" font-size="11">${number(tick, y)}</text>`;
    }
    for (const tick of ticks_between(x0, x1, 5)) {
      const [place] = at([tick, y0]);
      inside += `<line class="grid" y1="${top}" y2="${height - bottom}" x1="${place}" x2="${place}"/>` +
        `<text x="${place}" y="${height - bottom + 15}" text-anchor="middle" font-size="11">${number(tick, x)}</text>`;
    }
    for (const {points: line, colour, dashed} of this.series)
      inside += `<polyline fill="none" stroke="${colour}" stroke-width="2" ${dashed ? 'stroke-dasharray="5 4"' : ''} points="${
        line.filter(([a, b]) => Number.isFinite(a) && Number.isFinite(b)).map(point => at(point).map(v => v.toFixed(1)).join()).join(' ')}"/>`;
    inside += `<text class="axis" x="${(left + width - right) / 2}" y="${height - 6}" text-anchor="middle" font-size="12">${x.title}</text>` +
      `<text class="axis" transform="translate(13 ${(top + height - bottom) / 2}) rotate(-90)" text-anchor="middle" font-size="12">${y.title}</text>`;
    this.figure.innerHTML = `<svg viewBox="0 0 ${width} ${height}" role="img"><title></title>${inside}</svg>`;
    this.figure.querySelector('title').textContent = this.label || `${this.axes.y.title} over ${this.axes.x.title}`;
  }
}

/** Rows of numbers as a CSV file: names with units, then rows. */
function csv_of(head, rows) {
  return [head.join(','), ...rows.map(row => row.map(v => v === undefined || Number.isNaN(v) ? '' : v).join(','))].join('\n') + '\n';
}

/** Hands a file to the reader of the page. */
function save_file(name, url) {
  Object.assign(document.createElement('a'), {download: name, href: url}).click();
}
