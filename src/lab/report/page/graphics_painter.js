// Draws a body by WebGL 2 for viewer.js: molecules as spheres, connections as rods, faces. Needs three.
'use strict';

/** Where light comes from, in the camera's axes: right, up, towards the eye. */
const towards_lamp = [-0.4, 0.6, 0.8].map(v => v / Math.hypot(0.4, 0.6, 0.8));

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
      gl_FragColor = vec4(faded(tint * (.5 + .55 * max(0., dot(normal, vec3(${towards_lamp}))))), 1.);
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

/** Four corners (x, y, number) and two triangles for each of a number of flat shapes, x from `least` to 1. */
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

class GraphicsPainter {
  /** Throws where the browser has no WebGL 2. */
  constructor(canvas, camera) {
    const attributes = {antialias: true, alpha: true, premultipliedAlpha: false}, context = canvas.getContext('webgl2', attributes);
    if (!context) throw new Error('this browser has no WebGL 2, or it is switched off');
    this.camera = camera;
    this.smooth = true;
    this.renderer = new THREE.WebGLRenderer({canvas, context, ...attributes});
    this.renderer.setClearColor(0, 0);
    this.build_scene();
  }

  build_scene() {
    this.scene = new THREE.Scene();
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
    this.outlines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
    this.outlines.frustumCulled = false;
    for (const part of Object.values(this.parts)) part.frustumCulled = false;
    const lamp = new THREE.DirectionalLight(0xffffff, 0.55);
    lamp.position.set(...towards_lamp);
    this.camera.add(lamp, lamp.target);
    this.scene.add(this.camera, new THREE.AmbientLight(0xffffff, 0.6), this.outlines, ...Object.values(this.parts));
  }

  /** {radius, ends, surface}, see body.js. */
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

  set_state(positions, colours) {
    this.positions = positions;
    this.colours = colours;
    this.stale = new Set(['places', 'tints', 'rod_tints', 'surface']);
  }

  /** Gives what is drawn the last state: what is not seen costs nothing. */
  fill_parts({molecules, connections: rods, surface: faces}) {
    const {positions, colours, body: {surface}} = this;
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
    if (stale('places', molecules || rods)) this.fill_texture('places', positions);
    if (stale('tints', molecules || rods && !colours.connections)) this.fill_texture('tints', colours.molecules);
    if (stale('rod_tints', rods && colours.connections)) this.fill_texture('rod_tints', colours.connections);
    if (!stale('surface', faces)) return;
    this.fill('surface', 'position', gather(surface, positions));
    this.fill('surface', 'color', colours.faces ? gather(surface.map((_, i) => Math.floor(i / 3)), colours.faces) : gather(surface, colours.molecules));
  }

  set_lines(lines) {
    this.lines = lines;
    this.outlines.geometry.dispose();
    this.outlines.geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(lines), 3));
  }

  /** cut: {x, y, z, w}, see viewer.js; shaders without a cut are other ones. */
  set_cut(cut, is_cut) {
    this.uniforms.cut.value.copy(cut);
    for (const {material} of [this.parts.molecules, this.parts.connections]) {
      material.needsUpdate ||= is_cut !== 'CUT' in material.defines;
      material.defines = is_cut ? {CUT: ''} : {};
    }
    this.cut_plane.normal.set(-cut.x, -cut.y, -cut.z);
    this.cut_plane.constant = cut.w;
  }

  /** view: the canvas {width, height} [px], its `scale` in pixels of the screen, `share` of a molecule's radius that is drawn,
   *  the depth [m] of what is seen from `near_side` on, `ground` and `ink` as colours, and whether parts are drawn: molecules,
   *  connections, surface. */
  paint(view) {
    const {renderer, camera, parts} = this, {width, height, scale, share, near_side, depth, ground} = view;
    if (this.canvas_size !== [width, height, scale].join()) {
      this.canvas_size = [width, height, scale].join();
      renderer.setPixelRatio(scale);
      renderer.setSize(width, height, false);
    }
    for (const [name, part] of Object.entries(parts)) part.visible = view[name];
    this.fill_parts(view);
    Object.entries({near_side, depth, share, near: camera.near, width: 0.05 * this.mean_radius,
      pixel: 2 * Math.tan(camera.fov * Math.PI / 360) / (height * scale)}).forEach(([name, value]) => { this.uniforms[name].value = value; });
    this.uniforms.ground.value.set(ground);
    this.outlines.material.color.set(view.ink);
    this.outlines.visible = this.outlines.geometry.attributes.position?.count > 0;
    this.uniforms.canvas.value.set(width * scale, height * scale);
    renderer.render(this.scene, camera);
  }

  release() {
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }
}
