// The hand on the canvas: drags, pushes and pins by mouse, finger or pen. What misses the body turns it. Needs bodies.js.
'use strict';

class Hand {
  /** lab: {viewer, tool, playing, body, hold(hand), push(place), pin(molecule)}. */
  constructor(canvas, lab) {
    this.canvas = canvas;
    this.lab = lab;
    canvas.addEventListener('pointerdown', event => this.down(event), {capture: true});
    canvas.addEventListener('pointermove', event => this.move(event));
    for (const kind of ['pointerup', 'pointercancel', 'lostpointercapture']) canvas.addEventListener(kind, event => this.up(event));
  }

  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  place_of(molecule) {
    const {positions} = this.lab.viewer;
    return Array.from(positions.subarray(3 * molecule, 3 * molecule + 3));
  }

  down(event) {
    const {viewer, tool} = this.lab;
    if (!viewer || event.button > 0 || event.shiftKey || this.pointer !== undefined || tool === 'turn') return;
    const point = this.at(event), molecule = viewer.molecule_at(...point, event.pointerType === 'touch' ? 28 : 16);
    if (molecule < 0) return;
    viewer.controls.enabled = false;
    this.canvas.focus({preventScroll: true});
    this.pointer = event.pointerId;
    this.canvas.setPointerCapture(event.pointerId);
    this.depth = this.place_of(molecule);
    this.molecule = molecule;
    if (tool === 'pin') this.lab.pin(molecule);
    else this.go(point);
  }

  move(event) {
    if (event.pointerId === this.pointer) this.go(this.at(event));
  }

  go(point) {
    const {viewer, tool} = this.lab, place = viewer.place_under(...point, this.depth);
    if (tool === 'drag') this.lab.hold(this.molecule, place);
    if (tool === 'push') this.lab.push(this.molecule, place);
  }

  up(event) {
    if (event.pointerId !== this.pointer) return;
    this.pointer = undefined;
    this.lab.viewer.controls.enabled = true;
    this.lab.let_go();
  }
}
