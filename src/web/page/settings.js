// What the controls say, as numbers in SI units and as the part of the page's address after #. A slider knows its own
// scale. Needs colours.js.
'use strict';

/** Sliders by name: {least, most} of a plain one; {decades} of one that covers this number of powers of ten on both sides of where
 *  the scene begins; {from, decades, zero} of one that goes up from `from` and is 0 at its left end. */
const slider_kinds = {
  E: {unit: 'Pa', decades: 2, rebuild: true},
  nu: {unit: '', least: 0, most: 0.49, step: 0.01, rebuild: true},
  density: {unit: 'kg/m³', decades: 1, rebuild: true},
  phi: {unit: 'Pa s', zero: true, decades: 5, rebuild: true},
  psi: {unit: 'Pa s', zero: true, decades: 5, rebuild: true},
  alpha: {unit: '1/s', zero: true, decades: 4, rebuild: true},
  pressure: {unit: 'Pa', zero: true, decades: 4, rebuild: true},
  gravity: {unit: 'm/s²', least: 0, most: 20, step: 0.01},
  tilt: {unit: '°', least: -180, most: 180, step: 1},
  load: {unit: '%', least: 0, most: 200, step: 1},
  stiffness: {unit: 'N/m', decades: 3},
  probe: {unit: 'm', decades: 1},
  strain: {unit: '%', least: -30, most: 100, step: 1},
};

class Slider {
  /** input: a range; output: where its value stands in words; start: where the scene begins. */
  constructor(input, output, kind, start, scale) {
    Object.assign(this, {input, output, kind, start, scale: scale || start || 1});
    const {decades, zero, least, most, step} = kind;
    Object.assign(input, decades ? {min: zero ? 0 : -decades, max: decades, step: 0.02} : {min: least, max: most, step});
    this.value = start;
  }

  get value() {
    if (this.exact !== undefined) return this.exact;  // until somebody moves it: a range has steps
    const at = +this.input.value, {decades, zero} = this.kind;
    if (!decades) return at;
    if (zero) return at === 0 ? 0 : this.scale * 10 ** (at - 0.6 * decades);
    return this.scale * 10 ** at;
  }

  /** Whether a value is a number where the slider goes, as one from the page's address may not be. */
  takes(value) {
    if (!Number.isFinite(value) || (this.kind.zero && value < 0)) return false;
    const at = this.place(value), end = 1e-6 * (this.input.max - this.input.min);
    return Number.isFinite(at) && at >= +this.input.min - end && at <= +this.input.max + end;
  }

  place(value) {
    const {decades, zero} = this.kind;
    if (!decades) return value;
    if (zero) return value > 0 ? Math.log10(value / this.scale) + 0.6 * decades : 0;
    return Math.log10(value / this.scale);
  }

  set value(value) {
    this.exact = value;
    this.input.value = this.place(value);
    this.show();
  }

  /** In words: next to it and for a screen reader. Of several materials a slider scales all, `whole` being 1. */
  show() {
    const {unit, decades, whole} = this.kind, value = this.value;
    this.text = whole ? `${+(value / whole).toPrecision(3)} × the scene's` : decades ? with_prefix(value, unit) : `${+value.toFixed(3)}${unit && unit !== '°' && unit !== '%' ? ' ' : ''}${unit}`;
    if (unit === 'kg/m³' && !whole) this.text = `${+value.toPrecision(4)} kg/m³`;
    this.output.textContent = this.text;
    this.input.setAttribute('aria-valuetext', this.text);
  }
}

/** Names and values as the page's address holds them; numbers with six digits, and none that is not finite. */
function hash_of(values) {
  const said = value => typeof value === 'number' ? Number.isFinite(value) : value !== '' && value !== undefined;
  const pairs = Object.entries(values).filter(([, value]) => said(value));
  return '#' + pairs.map(([name, value]) => `${name}=${encodeURIComponent(typeof value === 'number' ? +value.toPrecision(6) : value)}`).join('&');
}

/** A number of the address; NaN of what is none, or is missing. */
function number_from_hash(text) { return text?.trim() ? Number(text) : NaN; }

function values_from_hash(hash) {
  return Object.fromEntries(hash.replace(/^#/, '').split('&').filter(Boolean).map(pair => {
    const [name, value] = pair.split('=');
    try {
      return [name, decodeURIComponent(value ?? '')];
    } catch {
      return [name, ''];
    }
  }));
}
