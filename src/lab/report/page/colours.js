// Colours for numbers. One description of each map serves molecules, connections, faces, the legend and the saved picture.
'use strict';

const colour_maps = {
  // −1 … 1: blue is compressed, red is pulled. The square root shows the small ones, too.
  signed: {stops: ['#1761ed', '#9094a1', '#e63326'], share: v => (1 + Math.sign(v) * Math.sqrt(Math.min(1, Math.abs(v)))) / 2},
  // 0 … 1: dark violet over green to yellow, as matplotlib's viridis, whose darkest tenth is left out.
  rising: {stops: ['#482576', '#365c8d', '#1f988b', '#6ccd5a', '#fde725'], share: v => Math.max(0, Math.min(1, v))},
};
for (const map of Object.values(colour_maps))
  map.rgb = map.stops.map(stop => [1, 3, 5].map(at => parseInt(stop.slice(at, at + 2), 16) / 255));

/** Red, green and blue [0 … 1] of each number, which is −1 … 1 or 0 … 1 as the map says. */
function colours_of(map, numbers) {
  const {rgb, share} = colour_maps[map], colours = new Float32Array(3 * numbers.length);
  numbers.forEach((number, i) => {
    const at = share(number) * (rgb.length - 1), first = Math.min(Math.floor(at), rgb.length - 2);
    for (let k = 0; k < 3; ++k) colours[3 * i + k] = rgb[first][k] + (at - first) * (rgb[first + 1][k] - rgb[first][k]);
  });
  return colours;
}

/** Colours along the legend from the least number to the largest, evenly spaced. */
function legend_colours(map, count = 25) {
  const least = map === 'signed' ? -1 : 0;
  const numbers = Array.from({length: count}, (_, i) => least + (1 - least) * i / (count - 1));
  const rgb = colours_of(map, numbers);
  return numbers.map((_, i) => `rgb(${[0, 1, 2].map(k => Math.round(255 * rgb[3 * i + k]))})`);
}

/** A quantity with three digits and the letter before its unit that keeps it short: 0.0123 m is 12.3 mm. A dash where there
 *  is no number. */
function with_prefix(value, unit, digits = 3) {
  if (!Number.isFinite(value)) return '—';
  const short = v => digits ? v.toPrecision(digits) : String(+v.toPrecision(6));
  for (const [factor, letter] of [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']])
    if (Math.abs(value) >= factor * (1 - 1e-9)) return `${short(value / factor)} ${letter}${unit}`;
  return value === 0 ? '0' : `${short(value)} ${unit}`;
}

/** The number of the form 1, 2 or 5 times a power of ten that is not above. */
function round_down(value) {
  const decade = 10 ** Math.floor(Math.log10(value)), first = value / decade;
  return decade * (first >= 5 ? 5 : first >= 2 ? 2 : 1);
}

/** The number of a text such as "12.3 mPa" or "5 %" in the unit; undefined where it is not a number. */
function without_prefix(text, unit) {
  const found = text.trim().replace(',', '.').match(/^([-+]?[\d.]+(?:e[-+]?\d+)?)\s*(.*)$/i);
  if (!found || !isFinite(+found[1])) return undefined;
  const letters = found[2] === unit || !found[2] ? '' : found[2].endsWith(unit) ? found[2].slice(0, found[2].length - unit.length) : found[2];
  const factor = {'': 1, G: 1e9, M: 1e6, k: 1e3, m: 1e-3, 'µ': 1e-6, u: 1e-6, n: 1e-9, '%': 0.01}[letters.trim()];
  return factor && +found[1] * factor;
}
