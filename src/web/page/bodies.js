// Several bodies side by side as one that a viewer draws, each moved aside by its own offset. Needs viewer.js, body.js, colours.js.
'use strict';

/** Copies of a body, next to each other along x. */
function side_by_side(body, count) {
  const molecules = body.radius.length, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  body.rest.forEach((v, i) => {
    low[i % 3] = Math.min(low[i % 3], v);
    high[i % 3] = Math.max(high[i % 3], v);
  });
  const apart = 1.35 * (high[0] - low[0]) + 0.15 * body.size, offsets = Array.from({length: count}, (_, i) => (i - (count - 1) / 2) * apart);
  const repeated = (Type, array, change) => {
    const all = new Type(count * array.length);
    for (let copy = 0; copy < count; ++copy)
      array.forEach((v, i) => { all[copy * array.length + i] = change ? change(v, i, copy) : v; });
    return all;
  };
  const shifted = (v, i, copy) => v + (i % 3 === 0 ? offsets[copy] : 0), numbered = (v, i, copy) => v + copy * molecules;
  return {rest: repeated(Float32Array, body.rest, shifted), radius: repeated(Float32Array, body.radius),
    ends: repeated(Uint32Array, body.ends, numbered), surface: repeated(Uint32Array, body.surface, numbered),
    membrane: body.membrane, size: body.size, offsets, molecules};
}

/** The viewer of a lab: what a hand does is drawn over the bodies. */
class LabViewer extends Viewer {
  /** The point of the canvas [px] where a place [m] is seen. */
  seen_at(place) {
    const p = new THREE.Vector3(...place).project(this.camera);
    return [(1 + p.x) / 2 * this.canvas.clientWidth, (1 - p.y) / 2 * this.canvas.clientHeight];
  }

  /** The place [m] under a point of the canvas [px], as far from the eye as `like`. */
  place_under(x, y, like) {
    const {camera, canvas} = this, depth = new THREE.Vector3(...like).project(camera).z;
    const p = new THREE.Vector3(2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight, depth).unproject(camera);
    return [p.x, p.y, p.z];
  }

  draw_marks(canvas, scale, style) {
    super.draw_marks(canvas, scale, style);
    const paper = canvas.getContext('2d'), colour = name => style.getPropertyValue(name).trim();
    for (const {from, to, text} of this.lines ?? []) {
      const a = this.seen_at(from), b = this.seen_at(to);
      paper.strokeStyle = paper.fillStyle = colour('--accent');
      paper.lineWidth = 2;
      paper.beginPath();
      paper.moveTo(...a);
      paper.lineTo(...b);
      paper.stroke();
      paper.beginPath();
      paper.arc(...b, 5, 0, 7);
      paper.fill();
      if (text) this.write(paper, text, b[0] + 10, b[1] - 8, colour);
    }
    for (const {place, radius} of this.probes ?? []) {
      const middle = this.seen_at(place);
      paper.globalAlpha = 0.35;
      paper.fillStyle = colour('--accent');
      paper.beginPath();
      paper.arc(...middle, radius / this.metres_a_pixel(place), 0, 7);
      paper.fill();
      paper.globalAlpha = 1;
    }
    for (const place of this.pins ?? []) {
      const [x, y] = this.seen_at(place);
      paper.fillStyle = colour('--bad');
      paper.strokeStyle = colour('--paper');
      paper.lineWidth = 1.5;
      paper.beginPath();
      paper.arc(x, y, 5, 0, 7);
      paper.fill();
      paper.stroke();
    }
    (this.names ?? []).forEach((text, copy) => {
      paper.textAlign = 'center';
      this.write(paper, text, this.middle_of(copy), 18, colour);
    });
  }

  /** Where the middle of one of the bodies is seen, from the left [px]. */
  middle_of(copy) {
    const {camera, positions, names} = this, count = positions.length / names.length, place = new THREE.Vector3();
    let left = Infinity, right = -Infinity;
    for (let i = copy * count; i < (copy + 1) * count; i += 3) {
      const {x} = place.fromArray(positions, i).project(camera);
      left = Math.min(left, x);
      right = Math.max(right, x);
    }
    return (2 + left + right) / 4 * this.canvas.clientWidth;
  }

  write(paper, text, x, y, colour) {
    paper.font = '600 13px system-ui, sans-serif';
    paper.textBaseline = 'middle';
    paper.lineWidth = 4;
    paper.strokeStyle = colour('--paper');
    paper.strokeText(text, x, y);
    paper.fillStyle = colour('--ink');
    paper.fillText(text, x, y);
    paper.textAlign = 'left';
  }

  metres_a_pixel(place) {
    const distance = this.camera.position.distanceTo(new THREE.Vector3(...place));
    return 2 * Math.tan(this.camera.fov * Math.PI / 360) * distance / this.canvas.clientHeight;
  }
}
