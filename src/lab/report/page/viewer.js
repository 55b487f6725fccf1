// A body in 3D, turned by hand: molecules as spheres, connections as rods, faces. Needs three (THREE with OrbitControls),
// body.js, colours.js and marks.js; knows nothing of strategies, runs or the rest of the page.
'use strict';

/** Molecules in a row of the textures that hold their places and colours. */
const texture_width = 1024;

/** Both shaders of what is drawn once for each molecule or connection: a corner of a flat shape, turned to the eye. Distant
 *  parts fade into the ground. Corners stay as they are from picture to picture, and read where their molecules are from
 *  textures. They are no instances: those of four corners cost a graphics card a whole group of threads each, and one that
 *  is imitated by the processor some 30 µs. */
const shader_parts = {
  read: `
    precision highp sampler2D;
    uniform sampler2D places, tints, rod_tints;
    vec4 read(sampler2D numbers, float i) { int at = int(i); return texelFetch(numbers, ivec2(at % ${texture_width}, at / ${texture_width}), 0); }`,
  fade: `
    uniform float near_side, depth; uniform vec3 ground; varying float distance_to_eye;
    uniform vec4 cut; varying vec3 place;
    // Where nothing is cut, no rod's point is discarded, so that hidden ones are left out before they are computed.
    void cut_away() {
    #ifdef CUT
      if (dot(cut.xyz, place) > cut.w) discard;
    #endif
    }
    vec3 faded(vec3 colour) { return mix(colour, ground, .5 * clamp((distance_to_eye - near_side) / depth, 0., 1.)); }`,
  // The disc is larger than the sphere at its middle, for it is seen in perspective.
  sphere_vertex: `
    varying vec3 place;
    uniform float share, pixel;
    varying vec3 tint, middle, at; varying float size, distance_to_eye;
    void main() {
      vec4 molecule = read(places, position.z);
      place = molecule.xyz;
      vec4 p = modelViewMatrix * vec4(place, 1.);
      tint = read(tints, position.z).rgb; middle = p.xyz; distance_to_eye = -p.z;
      size = max(molecule.w * share, 1.2 * pixel * -p.z);
      at = middle + vec3(1.15 * size * position.xy, 0.);
      gl_Position = projectionMatrix * vec4(at, 1.);
    }`,
  sphere_fragment: `
    uniform mat4 projectionMatrix; varying vec3 tint, middle, at; varying float size;
    void main() {
      cut_away();
      vec3 ray = normalize(at);
      float along = dot(ray, middle), inside = along * along - dot(middle, middle) + size * size;
      if (inside < 0.) discard;
      vec3 hit = (along - sqrt(inside)) * ray, normal = (hit - middle) / size;
      vec4 p = projectionMatrix * vec4(hit, 1.);
      gl_FragDepthEXT = .5 + .5 * p.z / p.w;
      gl_FragColor = vec4(faded(tint * (.5 + .55 * max(0., dot(normal, normalize(vec3(-.4, .6, .8)))))), 1.);
    }`,
  rod_vertex: `
    attribute vec2 ends;  // this corner's own end first
    uniform float width, pixel, near; uniform vec2 canvas; uniform bool own_tints;
    varying vec3 tint, place; varying float across, distance_to_eye;
    void main() {
      vec3 own = read(places, ends.x).xyz, other = read(places, ends.y).xyz;
      vec3 from = position.x < .5 ? own : other, to = position.x < .5 ? other : own;
      place = own;
      vec4 a = modelViewMatrix * vec4(from, 1.), b = modelViewMatrix * vec4(to, 1.);
      float front = -near;  // a rod that passes the eye ends before it
      if (a.z > front && b.z < front) a = mix(a, b, (a.z - front) / (a.z - b.z));
      if (b.z > front && a.z < front) b = mix(b, a, (b.z - front) / (b.z - a.z));
      vec4 p = projectionMatrix * a, q = projectionMatrix * b, end = position.x < .5 ? p : q;
      vec2 along = (q.xy / q.w - p.xy / p.w) * canvas;
      vec2 side = length(along) > 0. ? normalize(vec2(-along.y, along.x)) : vec2(0., 1.);
      float half_width = max(width / (pixel * end.w), 1.);  // in pixels
      gl_Position = end;
      gl_Position.xy += side * position.y * 2. * half_width / canvas * end.w;
      tint = (own_tints ? read(rod_tints, position.z) : read(tints, ends.x)).rgb;
      across = position.y; distance_to_eye = end.w;
    }`,
  rod_fragment: `
    varying vec3 tint; varying float across;
    void main() {
      cut_away();
      gl_FragColor = vec4(faded(tint * (.65 + .4 * sqrt(max(0., 1. - across * across)))), 1.);
    }`,
};

/** Four corners (x, y, number) and two triangles for each of so many flat shapes, x from `least` to 1. */
function corners_of(count, least) {
  const geometry = new THREE.BufferGeometry(), corners = new Float32Array(12 * count), index = new Uint32Array(6 * count);
  for (let i = 0; i < count; ++i) {
    corners.set([least, -1, i, least, 1, i, 1, -1, i, 1, 1, i], 12 * i);
    index.set([4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 2, 4 * i + 1, 4 * i + 3], 6 * i);
  }
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry.setAttribute('position', new THREE.BufferAttribute(corners, 3));
}

/** Room for four numbers each. */
function texture_of(count) {
  const rows = Math.max(1, Math.ceil(count / texture_width));
  return new THREE.DataTexture(new Float32Array(4 * texture_width * rows), texture_width, rows, THREE.RGBAFormat, THREE.FloatType);
}

class Viewer {
  /** Edges are smooth if antialias is true, for three times the time where the processor draws. Throws where the browser has no WebGL 2. */
  constructor(canvas, antialias = true) {
    const context = canvas.getContext('webgl2', {antialias, alpha: true, premultipliedAlpha: false});
    if (!context) throw new Error('this browser has no WebGL 2, or it is switched off');
    this.canvas = canvas;
    this.marks = canvas.parentElement.appendChild(Object.assign(document.createElement('canvas'), {className: 'marks'}));
    this.marks.setAttribute('aria-hidden', 'true');
    this.renderer = new THREE.WebGLRenderer({canvas, context, antialias, alpha: true, premultipliedAlpha: false});
    this.renderer.setClearColor(0, 0);
    this.look = {connections: true, molecules: true, surface: false};
    this.direction = [-0.6, 0.35];  // from which bodies are seen first: about the z axis, and upwards [rad]
    this.sharpness = 1;
    this.build_scene();
    this.listen();
  }

  build_scene() {
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(24, 1, 1, 10);
    this.camera.up.set(0, 0, 1);
    this.uniforms = {near_side: {value: 0}, depth: {value: 1}, ground: {value: new THREE.Color()}, share: {value: 1}, width: {value: 0},
      pixel: {value: 0}, near: {value: 0}, canvas: {value: new THREE.Vector2()}, cut: {value: new THREE.Vector4(0, 0, 0, 1)},
      places: {value: null}, tints: {value: null}, rod_tints: {value: null}, own_tints: {value: false}};
    const material = (vertex, fragment) => new THREE.ShaderMaterial({uniforms: this.uniforms, vertexShader: shader_parts.read + vertex,
      fragmentShader: shader_parts.fade + fragment, defines: {}, side: THREE.DoubleSide, extensions: {fragDepth: true}});
    const paint = new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: true, side: THREE.DoubleSide, shininess: 0,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
    this.renderer.localClippingEnabled = true;
    this.cut_plane = new THREE.Plane(new THREE.Vector3(), 1);
    paint.clippingPlanes = [this.cut_plane];
    this.parts = {
      molecules: new THREE.Mesh(new THREE.BufferGeometry(), material(shader_parts.sphere_vertex, shader_parts.sphere_fragment)),
      connections: new THREE.Mesh(new THREE.BufferGeometry(), material(shader_parts.rod_vertex, shader_parts.rod_fragment)),
      surface: new THREE.Mesh(new THREE.BufferGeometry(), paint),
    };
    for (const part of Object.values(this.parts)) part.frustumCulled = false;
    const lamp = new THREE.DirectionalLight(0xffffff, 0.55);
    lamp.position.set(-0.5, 0.7, 0.9);
    this.camera.add(lamp);
    this.scene.add(this.camera, new THREE.AmbientLight(0xffffff, 0.6), ...Object.values(this.parts));
  }

  /** The body that is shown: {radius, ends, surface}, see body.js. */
  set_body(body) {
    this.body = body;
    this.stale = new Set();
    const connections = body.ends.length / 2, faces = new THREE.BufferGeometry();
    for (const name of ['position', 'color'])
      faces.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * body.surface.length), 3).setUsage(THREE.DynamicDrawUsage));
    const rods = corners_of(connections, 0), ends = new Float32Array(8 * connections);
    for (let i = 0; i < connections; ++i) {
      const [a, b] = [body.ends[2 * i], body.ends[2 * i + 1]];
      ends.set([a, b, a, b, b, a, b, a], 8 * i);
    }
    rods.setAttribute('ends', new THREE.BufferAttribute(ends, 2));
    this.mean_radius = body.radius.reduce((sum, radius) => sum + radius, 0) / (body.radius.length || 1);
    for (const [name, geometry] of Object.entries({molecules: corners_of(body.radius.length, -1), connections: rods, surface: faces})) {
      this.parts[name].geometry.dispose();
      this.parts[name].geometry = geometry;
    }
    this.drawable = {molecules: body.radius.length, connections, surface: body.surface.length};
    for (const [name, count] of [['places', body.radius.length], ['tints', body.radius.length], ['rod_tints', connections]]) {
      this.uniforms[name].value?.dispose();
      this.uniforms[name].value = texture_of(count);
    }
    body.radius.forEach((radius, molecule) => { this.uniforms.places.value.image.data[4 * molecule + 3] = radius; });
  }

  /** Three numbers for each, into the texture of this name. */
  fill_texture(name, numbers) {
    const texture = this.uniforms[name].value, {data} = texture.image;
    for (let from = 0, to = 0; from < numbers.length; from += 3, to += 4) {
      data[to] = numbers[from];
      data[to + 1] = numbers[from + 1];
      data[to + 2] = numbers[from + 2];
    }
    texture.needsUpdate = true;
  }

  fill(part, name, write) {
    const attribute = this.parts[part].geometry.attributes[name];
    write(attribute.array);
    attribute.needsUpdate = true;
  }

  /** One state. positions: three a molecule [m]. colours, red green blue [0 … 1] each: molecules, one for each; connections,
   *  one for each, or none for those of their ends; faces, one for each, or none for those of their corners. */
  set_state(positions, colours) {
    this.positions = positions;
    this.colours = colours;
    this.stale = new Set(['places', 'tints', 'rod_tints', 'surface']);
    this.request();
  }

  /** Gives what is drawn the last state: what is not seen costs nothing. */
  fill_parts() {
    const {positions, colours, look, drawable, body: {surface}} = this, rods = look.connections && drawable.connections > 0;
    const stale = (name, wanted) => wanted && this.stale.delete(name);
    const gather = (numbers, from) => array => {
      for (let i = 0, to = 0; i < numbers.length; ++i) {
        const at = 3 * numbers[i];
        array[to++] = from[at];
        array[to++] = from[at + 1];
        array[to++] = from[at + 2];
      }
    };
    this.uniforms.own_tints.value = !!colours.connections;
    if (stale('places', look.molecules || rods)) this.fill_texture('places', positions);
    if (stale('tints', look.molecules || rods && !colours.connections)) this.fill_texture('tints', colours.molecules);
    if (stale('rod_tints', rods && colours.connections)) this.fill_texture('rod_tints', colours.connections);
    if (!stale('surface', look.surface && drawable.surface > 0)) return;
    this.fill('surface', 'position', gather(surface, positions));
    this.fill('surface', 'color', colours.faces ? gather(surface.map((_, i) => Math.floor(i / 3)), colours.faces) : gather(surface, colours.molecules));
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
    const cut = this.uniforms.cut.value.set(0, 0, 0, 1);
    if (axis >= 0) {
      let low = Infinity, high = -Infinity;
      for (const positions of this.fitted)
        for (let i = axis; i < positions.length; i += 3) [low, high] = [Math.min(low, positions[i]), Math.max(high, positions[i])];
      cut.setComponent(axis, side);
      cut.w = side * (low + share * (high - low));
    }
    for (const {material} of [this.parts.molecules, this.parts.connections]) {
      material.needsUpdate ||= axis >= 0 !== 'CUT' in material.defines;
      material.defines = axis >= 0 ? {CUT: ''} : {};
    }
    this.cut_plane.normal.set(-cut.x, -cut.y, -cut.z);
    this.cut_plane.constant = cut.w;
    this.request();
  }

  is_cut_away(x, y, z) {
    const cut = this.uniforms.cut.value;
    return cut.x * x + cut.y * y + cut.z * z > cut.w;
  }

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
    const {canvas, camera, renderer} = this, full = Math.min(devicePixelRatio || 1, 2), scale = Math.min(full * this.sharpness, 2);
    if (!this.positions || !canvas.clientWidth || !canvas.clientHeight || this.released) return;
    if (this.unseen || !Number.isFinite(camera.position.lengthSq() + this.controls.target.lengthSq())) this.look_from(...this.direction);
    if (this.unseen) return;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.floor(width * scale) || canvas.height !== Math.floor(height * scale)) {
      renderer.setPixelRatio(scale);
      renderer.setSize(width, height, false);
    }
    const distance = camera.position.distanceTo(this.middle);
    camera.aspect = width / height;
    camera.near = Math.max(distance - 1.2 * this.reach, 0.01 * this.reach);
    camera.far = distance + 1.2 * this.reach;
    camera.updateProjectionMatrix();
    for (const [name, part] of Object.entries(this.parts)) part.visible = this.look[name] && this.drawable[name] > 0;
    this.fill_parts();
    const style = getComputedStyle(canvas), ground = style.getPropertyValue('--paper').trim();
    Object.entries({near_side: distance - this.reach, depth: 2 * this.reach, share: this.radius_share(), near: camera.near,
      width: 0.05 * this.mean_radius, pixel: 2 * Math.tan(camera.fov * Math.PI / 360) / (height * scale)})
      .forEach(([name, value]) => { this.uniforms[name].value = value; });
    this.uniforms.ground.value.set(ground || '#fff');
    this.uniforms.canvas.value.set(width * scale, height * scale);
    renderer.render(this.scene, camera);
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
    this.sharpness = 1;
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

  /** The molecule that is seen at a point of the canvas [px], or −1. */
  molecule_at(x, y) { return this.nearest_molecule(x, y)?.molecule ?? -1; }

  nearest_molecule(x, y) {
    const {camera, canvas, positions, body} = this, {origin: o, direction: d} = this.ray_at(x, y);
    const share = this.uniforms.share.value, slack = 4 * 2 * Math.tan(camera.fov * Math.PI / 360) / canvas.clientHeight;  // four pixels
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

  /** Moves the eye around the body: angles [rad], and distance times so much. */
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
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.marks.remove();
  }
}
