// A body in 3D, turned by hand: what is seen of it, from where, and what is under the pointer. A painter draws it:
// graphics_painter.js or processor_painter.js. Needs three (THREE with OrbitControls), body.js, colours.js and marks.js; knows
// nothing of strategies, runs or the rest of the page.
'use strict';

/** False where the processor imitates a graphics card, and where there is no WebGL 2 at all. */
function drawn_by_graphics_card() {
  const context = document.createElement('canvas').getContext('webgl2', {failIfMajorPerformanceCaveat: true});
  const names = context?.getExtension('WEBGL_debug_renderer_info'), card = context?.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER);
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return !!context && !/swiftshader|llvmpipe|software|basic render/i.test(card);
}

class Viewer {
  /** Drawn by the graphics card where there is one, unless the page says otherwise: Painter(canvas, camera) has smooth,
   *  set_body(body), set_state(positions, colours), set_lines(lines), set_cut(cut, is_cut), paint(view) and release(). */
  constructor(canvas, Painter = drawn_by_graphics_card() ? GraphicsPainter : ProcessorPainter) {
    this.canvas = canvas;
    this.camera = new THREE.PerspectiveCamera(24, 1, 1, 10);
    this.camera.up.set(0, 0, 1);
    this.painter = new Painter(canvas, this.camera);
    this.marks = canvas.parentElement.appendChild(Object.assign(document.createElement('canvas'), {className: 'marks'}));
    this.marks.setAttribute('aria-hidden', 'true');
    this.look = {connections: true, molecules: true, surface: false};
    this.cut = new THREE.Vector4(0, 0, 0, 1);  // what is beyond the plane cut.xyz · x = cut.w is not drawn
    this.direction = [-0.6, 0.35];  // from which bodies are seen first: about the z axis, and upwards [rad]
    this.finest = this.painter.smooth ? 1 : 2;  // pixels along a side for each that is seen: four make edges smooth
    this.sharpness = this.finest;
    this.depth = 1.2;
    this.share = 1;  // of a molecule's radius that is drawn
    this.listen();
  }

  /** The body that is shown: {radius, ends, surface}, see body.js. */
  set_body(body) {
    this.body = body;
    this.painter.set_body(body);
  }

  /** One state. positions: three a molecule [m]. colours, red green blue [0 … 1] each: molecules, one for each; connections,
   *  one for each, or none for those of their ends; faces, one for each, or none for those of their corners. */
  set_state(positions, colours) {
    this.positions = positions;
    this.painter.set_state(positions, colours);
    this.request();
  }

  /** Lines in addition to the body, three floats a point, two points a line [m]: the outlines of obstacles. */
  set_lines(lines) {
    this.depth = lines.length ? 3 : 1.2;  // of what is drawn, in lengths from the middle
    this.painter.set_lines(lines);
    this.request();
  }

  /** What is drawn: connections, molecules, surface, each true or false. */
  set_look(look) {
    this.look = look;
    if (this.fitted && !this.touched) this.reset();
    this.request();
  }

  /** 1 where the eye is on the upper side of the body along an axis (0, 1, 2), else −1. */
  side_of_eye(axis) { return this.camera.position.getComponent(axis) >= this.middle.getComponent(axis) ? 1 : -1; }

  /** Draws nothing beyond a plane across an axis, on its upper side (1) or its lower (−1), at a share of the extent of what
   *  was fitted; axis −1 draws all. */
  set_cut(axis, side, share) {
    const cut = this.cut.set(0, 0, 0, 1);
    if (axis >= 0) {
      let low = Infinity, high = -Infinity;
      for (const positions of this.fitted)
        for (let i = axis; i < positions.length; i += 3) [low, high] = [Math.min(low, positions[i]), Math.max(high, positions[i])];
      cut.setComponent(axis, side);
      cut.w = side * (low + share * (high - low));
    }
    this.painter.set_cut(cut, axis >= 0);
    this.request();
  }

  is_cut_away(x, y, z) { return this.cut.x * x + this.cut.y * y + this.cut.z * z > this.cut.w; }

  /** What is marked: {molecule} or {face}, or nothing. */
  set_picked(picked) {
    this.picked = picked;
    this.request();
  }

  /** Molecules are drawn smaller where connections are to be seen between them. */
  radius_share() { return this.look.connections && this.body.ends.length ? 0.45 : 1; }

  /** Looks so that all of these positions, arrays of three floats a molecule, are in the picture, and keeps it so while the
   *  canvas changes its size, until a hand turns the body. */
  fit(states) {
    this.fitted = states;
    this.touched = false;
    this.look_from(...this.direction);
  }

  /** Draws with this share of the screen's pixels along a side; axes and bar keep theirs. */
  sharpen(share) {
    if (share === this.sharpness) return;
    this.sharpness = share;
    this.request();
  }

  reset() { this.fit(this.fitted); }

  /** The nearest camera of this direction [rad] that sees everything, with an edge left free. Of a point (x, y, z) in the
   *  camera's axes, z towards the eye, |x − cx| ≤ t (D − z) is to hold, with t the slope of the picture's side: so
   *  x + t z ≤ t D + cx and −x + t z ≤ t D − cx, whose largest left sides give D and cx. */
  look_from(yaw, pitch) {
    this.unseen = !(this.canvas.clientWidth > 0 && this.canvas.clientHeight > 0);  // then when it is drawn first
    if (this.unseen) return;
    const {camera, body} = this, [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    const right = [cy, sy, 0], up = [-sp * sy, sp * cy, cp], eye = [sy * cp, -cy * cp, sp];
    const half = Math.tan(camera.fov * Math.PI / 360);
    const slopes = [0.92 * half * this.canvas.clientWidth / this.canvas.clientHeight, 0.88 * half];
    const most = [[-Infinity, -Infinity], [-Infinity, -Infinity]];  // of +x, −x and of +y, −y
    let near = -Infinity, far = Infinity, reach = 0;
    const along = (axis, positions, i) => axis[0] * positions[i] + axis[1] * positions[i + 1] + axis[2] * positions[i + 2];
    for (const positions of this.fitted)
      for (let i = 0; i < positions.length; i += 3) {
        const z = along(eye, positions, i);
        if (!Number.isFinite(along(right, positions, i) + along(up, positions, i) + z)) continue;
        const radius = this.look.molecules ? this.radius_share() * body.radius[i / 3] : 0;
        near = Math.max(near, z);
        far = Math.min(far, z);
        [right, up].forEach((axis, k) => {
          const at = along(axis, positions, i), free = radius * Math.hypot(1, slopes[k]) + slopes[k] * z;
          most[k][0] = Math.max(most[k][0], at + free);
          most[k][1] = Math.max(most[k][1], free - at);
        });
      }
    this.unseen = !(near >= far);  // nothing has a position
    if (this.unseen) return;
    const distance = Math.max(...most.map(([a, b], k) => (a + b) / (2 * slopes[k])), near + 1e-9);
    const shift = most.map(([a, b]) => (a - b) / 2), depth = (near + far) / 2;
    const point = z => new THREE.Vector3(...[0, 1, 2].map(k => shift[0] * right[k] + shift[1] * up[k] + z * eye[k]));
    this.controls.target.copy(point(depth));
    camera.position.copy(point(distance));
    const {x, y, z} = this.middle = this.controls.target.clone();
    for (const positions of this.fitted)
      for (let i = 0; i < positions.length; i += 3)
        reach = Math.max(reach, (Math.hypot(positions[i] - x, positions[i + 1] - y, positions[i + 2] - z) || 0) + body.radius[i / 3]);
    this.reach = reach || 1;
    this.controls.minDistance = 0.05 * this.reach;
    this.controls.maxDistance = 40 * this.reach;
    this.controls.update();
    this.request();
  }

  request() {
    if (this.waiting || this.released) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  draw() {
    const {canvas, camera, look, body} = this, full = Math.min(devicePixelRatio || 1, 2), scale = Math.min(full * this.sharpness, 2);
    if (!this.positions || !canvas.clientWidth || !canvas.clientHeight || this.released) return;
    if (this.unseen || !Number.isFinite(camera.position.lengthSq() + this.controls.target.lengthSq())) this.look_from(...this.direction);
    if (this.unseen) return;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight], distance = camera.position.distanceTo(this.middle);
    camera.aspect = width / height;
    camera.near = Math.max(distance - this.depth * this.reach, 0.01 * this.reach);
    camera.far = distance + this.depth * this.reach;
    camera.updateProjectionMatrix();
    const style = getComputedStyle(canvas);
    this.share = this.radius_share();
    this.painter.paint({width, height, scale, share: this.share, near_side: distance - this.reach, depth: 2 * this.reach,
      ground: style.getPropertyValue('--paper').trim() || '#fff', ink: style.getPropertyValue('--faint').trim() || '#666', molecules: look.molecules && body.radius.length > 0,
      connections: look.connections && body.ends.length > 0, surface: look.surface && body.surface.length > 0});
    this.draw_marks(this.marks, full, style);
  }

  /** Axes and scale bar on a canvas of the same size; the bar's length holds at the distance of the point one turns about. */
  draw_marks(canvas, scale, style) {
    const {camera} = this, [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const paper = canvas.getContext('2d'), ink = style.getPropertyValue('--faint').trim() || '#666';
    if (canvas.width !== Math.floor(width * scale)) canvas.width = width * scale;
    if (canvas.height !== Math.floor(height * scale)) canvas.height = height * scale;
    paper.setTransform(scale, 0, 0, scale, 0, 0);
    paper.clearRect(0, 0, width, height);
    const turn = camera.matrixWorldInverse.elements;
    draw_axes(paper, [0, 1, 2].map(axis => [turn[4 * axis], turn[4 * axis + 1], turn[4 * axis + 2]]), 44, height - 44, 26, ink);
    const metres = 2 * Math.tan(camera.fov * Math.PI / 360) * camera.position.distanceTo(this.controls.target) / height;
    draw_scale_bar(paper, metres, width - 16, height - 14, Math.min(0.3 * width, 160), ink);
    if (!this.picked) return;
    const molecules = this.picked.molecule >= 0 ? [this.picked.molecule] : [...this.body.surface.slice(3 * this.picked.face, 3 * this.picked.face + 3)];
    draw_picked(paper, molecules.map(molecule => {
      const at = new THREE.Vector3(...this.positions.slice(3 * molecule, 3 * molecule + 3)).project(camera);
      return [(at.x + 1) / 2 * width, (1 - at.y) / 2 * height];
    }));
  }

  /** What is seen, with axes, bar and legend, as a canvas of its own. */
  picture(legend) {
    const {canvas, marks, sharpness} = this;
    this.sharpness = this.finest;
    this.draw();
    this.sharpness = sharpness;
    const scale = canvas.width / canvas.clientWidth;
    const page = Object.assign(document.createElement('canvas'), {width: canvas.width, height: canvas.height});
    const paper = page.getContext('2d'), style = getComputedStyle(canvas);
    paper.fillStyle = style.getPropertyValue('--paper').trim() || '#fff';
    paper.fillRect(0, 0, page.width, page.height);
    paper.drawImage(canvas, 0, 0);
    paper.drawImage(marks, 0, 0);
    paper.scale(scale, scale);
    if (legend) draw_legend(paper, legend, 16, 56, Math.min(240, canvas.clientWidth - 32), style.getPropertyValue('--ink').trim() || '#000');
    return page;
  }

  ray_at(x, y) {
    const {camera, canvas} = this, caster = new THREE.Raycaster();
    camera.updateMatrixWorld();
    caster.setFromCamera({x: 2 * x / canvas.clientWidth - 1, y: 1 - 2 * y / canvas.clientHeight}, camera);
    return caster.ray;
  }

  /** What is drawn at a point of the canvas [px]: {molecule, distance} or {face, distance}; undefined where nothing is. */
  pick(x, y) {
    const found = [];
    if (this.look.surface) found.push(this.nearest_face(x, y));
    if (this.look.molecules || this.look.connections || !found.length) found.push(this.nearest_molecule(x, y));
    return found.filter(one => one).sort((a, b) => a.distance - b.distance)[0];
  }

  /** The molecule that is seen at a point of the canvas [px], or within `reach` of it where none is; or −1. */
  molecule_at(x, y, reach = 4) { return (this.nearest_molecule(x, y) ?? this.nearest_molecule(x, y, reach))?.molecule ?? -1; }

  nearest_molecule(x, y, pixels = 4) {
    const {camera, canvas, positions, body} = this, {origin: o, direction: d} = this.ray_at(x, y);
    const share = this.share, slack = pixels * 2 * Math.tan(camera.fov * Math.PI / 360) / canvas.clientHeight;
    let found, nearest = Infinity;
    for (let molecule = 0; molecule < body.radius.length; ++molecule) {
      const [px, py, pz] = positions.subarray(3 * molecule, 3 * molecule + 3);
      const vx = px - o.x, vy = py - o.y, vz = pz - o.z, along = vx * d.x + vy * d.y + vz * d.z;
      const aside = Math.sqrt(Math.max(0, vx * vx + vy * vy + vz * vz - along * along)), reach = share * body.radius[molecule];
      if (along > 0 && along < nearest && aside <= Math.max(reach, slack * along) && !this.is_cut_away(px, py, pz)) {
        found = {molecule, distance: along - reach};
        nearest = along;
      }
    }
    return found;
  }

  nearest_face(x, y) {
    const {positions, body: {surface}} = this, ray = this.ray_at(x, y), at = new THREE.Vector3();
    const corner = [0, 1, 2].map(() => new THREE.Vector3());
    let found;
    for (let face = 0; 3 * face < surface.length; ++face) {
      corner.forEach((place, k) => place.fromArray(positions, 3 * surface[3 * face + k]));
      if (!ray.intersectTriangle(...corner, false, at) || this.is_cut_away(at.x, at.y, at.z)) continue;
      const distance = at.distanceTo(ray.origin);
      if (!found || distance < found.distance) found = {face, distance};
    }
    return found;
  }

  listen() {
    const {canvas} = this;
    // A page that is scrolled past must not zoom: the wheel does so only in a canvas that was clicked. Heard before the
    // controls hear it.
    canvas.addEventListener('wheel', event => {
      this.controls.enableZoom = document.activeElement === canvas || event.ctrlKey;
      this.controls.zoomSpeed = Math.min(3, Math.abs(event.deltaY) / 40);
    }, {capture: true, passive: true});
    canvas.addEventListener('touchstart', () => Object.assign(this.controls, {enableZoom: true, zoomSpeed: 1}), {capture: true, passive: true});
    this.controls = Object.assign(new THREE.OrbitControls(this.camera, canvas), {enableKeys: false, screenSpacePanning: true, rotateSpeed: 0.7});
    this.controls.addEventListener('start', () => { this.touched = true; });
    this.controls.addEventListener('change', () => this.request());
    const keys = {ArrowLeft: [-.1, 0, 1], ArrowRight: [.1, 0, 1], ArrowUp: [0, .1, 1], ArrowDown: [0, -.1, 1],
      '+': [0, 0, 1 / 1.15], '-': [0, 0, 1.15]};
    canvas.addEventListener('keydown', event => {
      if (event.key === '0') this.reset();
      if (!keys[event.key]) return;
      event.preventDefault();
      this.turn(...keys[event.key]);
    });
    canvas.addEventListener('dblclick', () => this.reset());
    this.sizes = new ResizeObserver(() => {
      if (this.touched || !this.fitted) this.request();
      else this.reset();
    });
    this.sizes.observe(canvas);
    this.scheme = matchMedia('(prefers-color-scheme: dark)');
    this.on_scheme = () => this.request();
    this.scheme.addEventListener('change', this.on_scheme);
  }

  /** Moves the eye around the body: angles [rad], and distance times a factor. */
  turn(yaw, pitch, distance) {
    const offset = this.camera.position.clone().sub(this.controls.target), ball = new THREE.Spherical();
    ball.setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));  // three's angles are about y
    ball.theta += yaw;
    ball.phi = Math.max(0.02, Math.min(Math.PI - 0.02, ball.phi - pitch));
    ball.radius *= distance;
    const to = new THREE.Vector3().setFromSpherical(ball);
    this.camera.position.copy(this.controls.target).add(new THREE.Vector3(to.x, -to.z, to.y));
    this.touched = true;
    this.controls.update();
    this.request();
  }

  /** Gives back the graphics memory; browsers allow some sixteen pictures at a time. */
  release() {
    this.released = true;
    this.sizes.disconnect();
    this.scheme.removeEventListener('change', this.on_scheme);
    this.controls.dispose();
    this.painter.release();
    this.marks.remove();
  }
}
