// Draws a body pixel by pixel for viewer.js, where there is no graphics card: several times as fast as WebGL that the processor
// imitates. Each pixel keeps how near it is, 1/distance, which is linear over the picture. Needs three for
// the camera's matrices, and the lamp of graphics_painter.js.
'use strict';

const rod_shades = [1.03, 0.99, 0.91, 0.76];

class ProcessorPainter {
  constructor(canvas, camera) {
    this.canvas = canvas;
    this.camera = camera;
    this.smooth = false;
    this.paper = canvas.getContext('2d', {willReadFrequently: true});  // else an imitated card draws again
    this.cut = {x: 0, y: 0, z: 0, w: 1};
    this.ground = new THREE.Color();
    this.inks = new Uint32Array(rod_shades.length);
    this.lines = this.lines_seen = new Float32Array(0);
  }

  set_body(body) {
    this.body = body;
    this.mean_radius = body.radius.reduce((sum, radius) => sum + radius, 0) / (body.radius.length || 1);
    this.seen = new Float32Array(4 * body.radius.length);  // right, up, distance from the eye, and how far before the cut [m]
  }

  set_state(positions, colours) {
    this.positions = positions;
    this.colours = colours;
  }

  set_lines(lines) {
    this.lines = lines;
    this.lines_seen = new Float32Array(4 * lines.length / 3);
  }

  set_cut(cut) { this.cut = cut; }

  paint(view) {
    const {canvas, camera, body: {radius, ends, surface}} = this, [width, height] = [view.width, view.height].map(size => Math.floor(size * view.scale));
    if (!this.image || this.image.width !== width || this.image.height !== height) {
      Object.assign(canvas, {width, height});
      this.image = new ImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      this.nearness = new Float32Array(width * height);
    }
    this.pixels.fill(0);
    this.nearness.fill(0);
    this.view = view;
    this.ground.set(view.ground);
    this.scale = height / 2 / Math.tan(camera.fov * Math.PI / 360);  // pixels of a metre that is a metre away
    this.camera.updateMatrixWorld();
    this.look_at(this.positions, this.seen, this.cut);
    this.look_at(this.lines, this.lines_seen, {x: 0, y: 0, z: 0, w: 1});
    if (view.surface) for (let face = 0; 3 * face < surface.length; ++face) this.paint_face(face);
    if (view.connections) for (let rod = 0; 2 * rod < ends.length; ++rod) this.paint_rod(rod);
    if (view.molecules) for (let molecule = 0; molecule < radius.length; ++molecule) this.paint_molecule(molecule);
    const {r, g, b} = new THREE.Color(view.ink);
    for (let from = 0; from < this.lines_seen.length; from += 8) this.paint_line(this.lines_seen, from, from + 4, 0, r, g, b);
    this.paper.putImageData(this.image, 0, 0);
  }

  look_at(positions, seen, cut) {
    const m = this.camera.matrixWorldInverse.elements;
    for (let from = 0, to = 0; from < positions.length; from += 3, to += 4) {
      const x = positions[from], y = positions[from + 1], z = positions[from + 2];
      seen[to] = m[0] * x + m[4] * y + m[8] * z + m[12];
      seen[to + 1] = m[1] * x + m[5] * y + m[9] * z + m[13];
      seen[to + 2] = -(m[2] * x + m[6] * y + m[10] * z + m[14]);
      seen[to + 3] = cut.w - (cut.x * x + cut.y * y + cut.z * z);
    }
  }

  /** Red, green, blue [0 … 1], so bright, as a pixel; mixed with the ground by a share. */
  ink(red, green, blue, bright, share) {
    const {ground: {r, g, b}} = this, own = 255 * bright * (1 - share), far = 255 * share;
    return 0xff000000 | Math.min(255, own * blue + far * b) << 16 | Math.min(255, own * green + far * g) << 8 | Math.min(255, own * red + far * r);
  }

  /** Distant parts fade into the ground. */
  fading(far) { return 0.5 * Math.max(0, Math.min(1, (far - this.view.near_side) / this.view.depth)); }

  paint_molecule(molecule) {
    const {seen, scale, pixels, nearness, view, image: {width, height}} = this, at = 4 * molecule, far = seen[at + 2];
    if (!(far > this.camera.near && seen[at + 3] >= 0)) return;
    const [lx, ly, lz] = towards_lamp, radius = this.body.radius[molecule] * view.share, size = Math.max(scale * radius / far, 1.2);
    const x = width / 2 + scale * seen[at] / far, y = height / 2 - scale * seen[at + 1] / far, share = this.fading(far);
    const {molecules} = this.colours, [red, green, blue] = [molecules[3 * molecule], molecules[3 * molecule + 1], molecules[3 * molecule + 2]];
    const {r, g, b} = this.ground, own = 255 * (1 - share), [far_red, far_green, far_blue] = [255 * share * r, 255 * share * g, 255 * share * b];
    for (let row = Math.max(0, Math.ceil(y - size - 0.5)), last = Math.min(height - 1, y + size - 0.5); row <= last; ++row) {
      const v = (y - row - 0.5) / size, half = size * Math.sqrt(Math.max(0, 1 - v * v));
      for (let column = Math.max(0, Math.ceil(x - half - 0.5)), end = Math.min(width - 1, x + half - 0.5); column <= end; ++column) {
        const u = (column + 0.5 - x) / size, w = Math.sqrt(Math.max(0, 1 - u * u - v * v)), near = 1 / (far - radius * w), pixel = row * width + column;
        if (!(near > nearness[pixel])) continue;
        nearness[pixel] = near;
        const bright = own * (0.5 + 0.55 * Math.max(0, lx * u + ly * v + lz * w));
        pixels[pixel] = 0xff000000 | Math.min(255, bright * blue + far_blue) << 16 | Math.min(255, bright * green + far_green) << 8 | Math.min(255, bright * red + far_red);
      }
    }
  }

  // Thousands of rods a picture: numbers alone, for what is allocated must be collected.
  paint_rod(rod) {
    const {colours: {connections, molecules}, body: {ends}} = this, a = ends[2 * rod], b = ends[2 * rod + 1];
    const red = connections ? connections[3 * rod] : (molecules[3 * a] + molecules[3 * b]) / 2;
    const green = connections ? connections[3 * rod + 1] : (molecules[3 * a + 1] + molecules[3 * b + 1]) / 2;
    const blue = connections ? connections[3 * rod + 2] : (molecules[3 * a + 2] + molecules[3 * b + 2]) / 2;
    this.paint_line(this.seen, 4 * a, 4 * b, 0.05 * this.mean_radius, red, green, blue);
  }

  /** Between two points whose numbers in `seen` begin at p and q, so thick [m]. */
  paint_line(seen, p, q, radius, red, green, blue) {
    const {scale, image: {width, height}, inks} = this, least = this.camera.near;
    const before = seen[p + 2] - least, behind = seen[q + 2] - least;
    if (!(before >= 0 || behind >= 0) || !(seen[p + 3] >= 0 || seen[q + 3] >= 0)) return;
    // The range of the rod that is before the eye and not cut away.
    const eye = before / (before - behind), cut = seen[p + 3] / (seen[p + 3] - seen[q + 3]);
    const from = Math.max(before < 0 ? eye : 0, seen[p + 3] < 0 ? cut : 0), to = Math.min(behind < 0 ? eye : 1, seen[q + 3] < 0 ? cut : 1);
    if (!(from <= to)) return;
    const along = seen[q] - seen[p], upward = seen[q + 1] - seen[p + 1], away = seen[q + 2] - seen[p + 2];
    const near0 = 1 / (seen[p + 2] + from * away), near1 = 1 / (seen[p + 2] + to * away), near = (near0 + near1) / 2;
    const x0 = width / 2 + scale * near0 * (seen[p] + from * along), y0 = height / 2 - scale * near0 * (seen[p + 1] + from * upward);
    const x1 = width / 2 + scale * near1 * (seen[p] + to * along), y1 = height / 2 - scale * near1 * (seen[p + 1] + to * upward);
    const half = Math.max(scale * radius * near, 0.6, this.view.scale), share = this.fading(1 / near);
    for (let i = 0; i < inks.length; ++i) inks[i] = this.ink(red, green, blue, rod_shades[i], share);
    if (Math.abs(x1 - x0) >= Math.abs(y1 - y0)) {
      if (x0 <= x1) this.paint_band(x0, y0, near0, x1, y1, near1, half, 1, width, width, height);
      else this.paint_band(x1, y1, near1, x0, y0, near0, half, 1, width, width, height);
    } else if (y0 <= y1) this.paint_band(y0, x0, near0, y1, x1, near1, half, width, 1, height, width);
    else this.paint_band(y1, x1, near1, y0, x0, near0, half, width, 1, height, width);
  }

  /** A band along an axis of the picture from u0 to u1, at v0 and v1 across it, with the nearness of its ends. Pixels are
   *  `along` numbers apart along it, over `columns` of them, and `aside` numbers across it, over `rows`. */
  paint_band(u0, v0, near0, u1, v1, near1, half, along, aside, columns, rows) {
    const {pixels, nearness, inks} = this, length = u1 - u0, slope = length > 0 ? (v1 - v0) / length : 0, rise = length > 0 ? (near1 - near0) / length : 0;
    const reach = half * Math.hypot(1, slope), shade = inks.length / reach;
    for (let column = Math.max(0, Math.ceil(u0 - 0.5)), last = Math.min(columns - 1, u1 - 0.5); column <= last; ++column) {
      const gone = column + 0.5 - u0, middle = v0 + slope * gone - 0.5, nearer = near0 + rise * gone;
      for (let row = Math.max(0, Math.ceil(middle - reach)), end = Math.min(rows - 1, middle + reach); row <= end; ++row) {
        const pixel = column * along + row * aside;
        if (!(nearer > nearness[pixel])) continue;
        nearness[pixel] = nearer;
        pixels[pixel] = inks[Math.min(inks.length - 1, shade * Math.abs(row - middle) | 0)];
      }
    }
  }

  paint_face(face) {
    const {seen, scale, colours, body: {surface}, image: {width, height}} = this, corners = surface.subarray(3 * face, 3 * face + 3);
    let outline = Array.from(corners, molecule => seen.subarray(4 * molecule, 4 * molecule + 4));
    const [a, b, c] = outline, u = [0, 1, 2].map(k => b[k] - a[k]), v = [0, 1, 2].map(k => c[k] - a[k]);
    for (const [k, least] of [[2, this.camera.near], [3, 0]]) outline = trimmed(outline, k, least);
    if (outline.length < 3) return;
    const across = [u[2] * v[1] - u[1] * v[2], u[0] * v[2] - u[2] * v[0], u[0] * v[1] - u[1] * v[0]];  // right, up, towards the eye
    const slope = across.reduce((sum, v, k) => sum + v * towards_lamp[k], 0) * Math.sign(across[2]) / (Math.hypot(...across) || 1);
    const colour = k => colours.faces ? colours.faces[3 * face + k] : corners.reduce((sum, molecule) => sum + colours.molecules[3 * molecule + k] / 3, 0);
    const ink = this.ink(colour(0), colour(1), colour(2), 0.6 + 0.55 * Math.max(0, slope), 0);
    const points = outline.map(([x, y, far]) => [width / 2 + scale * x / far, height / 2 - scale * y / far, 0.998 / far]);  // behind the rods along it
    for (let i = 2; i < points.length; ++i) this.paint_triangle(points[0], points[i - 1], points[i], ink);
  }

  /** Corners (x, y) [px] and how near they are. */
  paint_triangle(a, b, c, ink) {
    const {pixels, nearness, image: {width, height}} = this, twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (!(Math.abs(twice) > 0)) return;
    const slope = k => [((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / twice, ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / twice][k];
    const [right, down] = [slope(0), slope(1)], edges = [[a, b], [b, c], [c, a]];
    for (let row = Math.max(0, Math.ceil(Math.min(a[1], b[1], c[1]) - 0.5)), last = Math.min(height - 1, Math.max(a[1], b[1], c[1]) - 0.5); row <= last; ++row) {
      let low = Infinity, high = -Infinity;  // where the middle of the row crosses edges
      for (const [p, q] of edges) {
        const s = (row + 0.5 - p[1]) / (q[1] - p[1]);
        if (!(s >= 0 && s <= 1)) continue;
        const x = p[0] + s * (q[0] - p[0]);
        low = Math.min(low, x);
        high = Math.max(high, x);
      }
      for (let column = Math.max(0, Math.ceil(low - 0.5)), end = Math.min(width - 1, high - 0.5); column <= end; ++column) {
        const near = a[2] + right * (column + 0.5 - a[0]) + down * (row + 0.5 - a[1]), pixel = row * width + column;
        if (!(near > nearness[pixel])) continue;
        nearness[pixel] = near;
        pixels[pixel] = ink;
      }
    }
  }

  release() {}
}

/** An outline [[number, …], …] without what has less than `least` of its number k. */
function trimmed(outline, k, least) {
  if (outline.every(corner => corner[k] >= least)) return outline;
  return outline.flatMap((corner, i) => {
    const next = outline[(i + 1) % outline.length], own = corner[k] - least, other = next[k] - least, kept = own >= 0 ? [corner] : [];
    if (own >= 0 !== other >= 0) kept.push(Array.from(corner, (v, at) => v + own / (own - other) * (next[at] - v)));
    return kept;
  });
}
