// A body in 3D: connections as lines, molecules as spheres, the surface as triangles; turned by hand. WebGL 2, no library:
// these three shapes are all that it ever draws.
'use strict';

const shaders = {
  colour: `
    uniform int map;
    vec3 colour_of(float v) {
      if (map == 0) {  // blue pushes, red pulls
        float s = sqrt(clamp(abs(v), 0., 1.));
        return mix(vec3(.56, .58, .63), v < 0. ? vec3(.09, .38, .93) : vec3(.9, .2, .15), s);
      }
      v = clamp(v, 0., 1.);  // dark violet over green to yellow
      return v < .5 ? mix(vec3(.27, .13, .52), vec3(.13, .57, .55), v * 2.) : mix(vec3(.13, .57, .55), vec3(.98, .86, .2), v * 2. - 1.);
    }`,
  lines: [`#version 300 es
    in vec2 corner; in vec3 from, to; in vec2 value;
    uniform mat4 view, lens; uniform vec2 size; uniform float wide;
    out float v; out float depth;
    void main() {
      vec4 a = view * vec4(from, 1.), b = view * vec4(to, 1.);
      vec4 p = lens * a, q = lens * b;
      vec2 way = (q.xy / q.w - p.xy / p.w) * size;
      vec2 side = length(way) > 0. ? normalize(vec2(-way.y, way.x)) : vec2(0., 1.);
      gl_Position = mix(p, q, corner.x);
      gl_Position.xy += side * corner.y * wide / size * gl_Position.w;
      v = mix(value.x, value.y, corner.x); depth = mix(a.z, b.z, corner.x);
    }`, `
    in float v; in float depth; uniform float near; uniform float deep; uniform vec3 ground; out vec4 paint;
    void main() { paint = vec4(mix(colour_of(v), ground, .55 * clamp((-depth - near) / deep, 0., 1.)), 1.); }`],
  spheres: [`#version 300 es
    in vec3 place; in float radius, value;
    uniform mat4 view, lens; uniform vec2 size; uniform float share;
    out float v; out float depth;
    void main() {
      vec4 p = view * vec4(place, 1.);
      gl_Position = lens * p;
      gl_PointSize = max(2., lens[1][1] * size.y * radius * share / gl_Position.w);
      v = value; depth = p.z;
    }`, `
    in float v; in float depth; uniform float near; uniform float deep; uniform vec3 ground; out vec4 paint;
    void main() {
      vec2 p = gl_PointCoord * 2. - 1.;
      float r = dot(p, p);
      if (r > 1.) discard;
      vec3 normal = vec3(p.x, -p.y, sqrt(1. - r));
      float light = .45 + .6 * max(0., dot(normal, normalize(vec3(-.4, .6, .8))));
      paint = vec4(mix(colour_of(v) * light, ground, .4 * clamp((-depth - near) / deep, 0., 1.)), 1.);
    }`],
  surface: [`#version 300 es
    in vec3 place; in float value; uniform mat4 view, lens; out float v; out vec3 at;
    void main() { vec4 p = view * vec4(place, 1.); gl_Position = lens * p; v = value; at = p.xyz; }`, `
    in float v; in vec3 at; uniform float opaque; out vec4 paint;
    void main() {
      vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
      paint = vec4(colour_of(v) * (.5 + .5 * abs(dot(normal, normalize(vec3(-.3, .5, .8))))), opaque);
    }`],
};

function bytes_of(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  return bytes.buffer;
}

/** What the page holds of a body, as arrays. */
function unpack_body(json) {
  const body = {rest: new Float32Array(bytes_of(json.rest)), radius: new Float32Array(bytes_of(json.radius)),
    ends: new Uint32Array(bytes_of(json.ends)), surface: new Uint32Array(bytes_of(json.surface)), membrane: json.membrane};
  return Object.assign(body, box_of(body.rest));
}

/** Middle and diagonal of the box around places. */
function box_of(places) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < places.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], places[i]);
    high[i % 3] = Math.max(high[i % 3], places[i]);
  }
  return {middle: low.map((v, k) => (v + high[k]) / 2), size: Math.hypot(...low.map((v, k) => high[k] - v)) || 1};
}

function unpack_states(json) {
  return json.frames.map(frame => ({at: frame.at, most: frame.most, ways: new Float32Array(bytes_of(frame.ways)),
    tensions: Float32Array.from(new Int16Array(bytes_of(frame.tensions)), share => share * frame.most / 32767)}));
}

/** The state at a place between two frames, 2.25 = a quarter of the way from frame 2 to frame 3. */
function state_at(frames, place) {
  const first = Math.min(Math.floor(place), frames.length - 1), part = place - first;
  const a = frames[first], b = frames[Math.min(first + 1, frames.length - 1)];
  if (part < 1e-6) return a;
  const mixed = (x, y) => Float32Array.from(x, (v, i) => v + part * (y[i] - v));
  return {at: a.at + part * (b.at - a.at), ways: mixed(a.ways, b.ways), tensions: mixed(a.tensions, b.tensions)};
}

/** Lengthening of each connection over its length at rest, without the loss of digits that lengths far larger bring. */
function strains_of(body, ways) {
  const {ends, rest} = body, strains = new Float32Array(ends.length / 2);
  for (let c = 0; c < strains.length; ++c) {
    const a = 3 * ends[2 * c], b = 3 * ends[2 * c + 1];
    let square = 0, change = 0;
    for (let k = 0; k < 3; ++k) {
      const d = rest[b + k] - rest[a + k], w = ways[b + k] - ways[a + k];
      square += d * d;
      change += w * (2 * d + w);
    }
    const length = Math.sqrt(square);
    strains[c] = length > 0 ? change / (length * (length + Math.sqrt(Math.max(0, square + change)))) : 0;
  }
  return strains;
}

/** Of each molecule the mean over its connections. */
function means_of(body, values) {
  const sums = new Float32Array(body.radius.length), counts = new Uint16Array(body.radius.length);
  body.ends.forEach((molecule, i) => { sums[molecule] += values[i >> 1]; ++counts[molecule]; });
  return sums.map((sum, i) => counts[i] ? sum / counts[i] : 0);
}

function sizes_of(ways, others) {
  const sizes = new Float32Array(ways.length / 3);
  for (let i = 0; i < sizes.length; ++i) {
    let square = 0;
    for (let k = 3 * i; k < 3 * i + 3; ++k) square += (ways[k] - (others ? others[k] : 0)) ** 2;
    sizes[i] = Math.sqrt(square);
  }
  return sizes;
}

function product(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; ++i) for (let j = 0; j < 4; ++j) for (let k = 0; k < 4; ++k) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

class Viewer {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl2', {antialias: true, alpha: true, premultipliedAlpha: false});
    if (!this.gl) throw new Error('this browser has no WebGL 2');
    this.programs = {};
    for (const [name, [vertex, fragment]] of Object.entries(shaders).filter(([, v]) => Array.isArray(v)))
      this.programs[name] = this.program(vertex, '#version 300 es\nprecision highp float;\nprecision highp int;' + shaders.colour + fragment);
    this.buffers = {};
    this.look = {lines: true, spheres: true, surface: false};
    this.reset();
    this.listen();
    new ResizeObserver(() => this.request()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.request());
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return program;
  }

  reset() {
    Object.assign(this, {yaw: -0.6, pitch: 0.35, zoom: 1, shift: [0, 0]});
    this.request();
  }

  /** What is looked at: {middle, size} of a box. */
  aim(box) { this.box = box; }

  /** values: {lines: one a connection, molecules: one a molecule}, both already over their largest. */
  show(body, places, values, map) {
    this.body = body;
    this.map = map;
    const {ends, surface} = body, m = ends.length / 2;
    const lines = new Float32Array(8 * m), spheres = new Float32Array(5 * body.radius.length);
    for (let c = 0; c < m; ++c) {
      for (let e = 0; e < 2; ++e) {
        for (let k = 0; k < 3; ++k) lines[8 * c + 3 * e + k] = places[3 * ends[2 * c + e] + k];
        lines[8 * c + 6 + e] = values.lines ? values.lines[c] : values.molecules[ends[2 * c + e]];
      }
    }
    body.radius.forEach((radius, i) => {
      for (let k = 0; k < 3; ++k) spheres[5 * i + k] = places[3 * i + k];
      spheres[5 * i + 3] = radius;
      spheres[5 * i + 4] = values.molecules[i];
    });
    const triangles = new Float32Array(4 * surface.length);
    surface.forEach((molecule, i) => {
      for (let k = 0; k < 3; ++k) triangles[4 * i + k] = places[3 * molecule + k];
      triangles[4 * i + 3] = values.molecules[molecule];
    });
    this.fill('lines', lines);
    this.fill('spheres', spheres);
    this.fill('surface', triangles);
    this.request();
  }

  fill(name, data) {
    const gl = this.gl;
    this.buffers[name] ??= {buffer: gl.createBuffer()};
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name].buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    this.buffers[name].floats = data.length;
  }

  request() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  camera() {
    const {box: body, yaw, pitch, canvas} = this, far = 1.75 * body.size / this.zoom;
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    const turn = [cy, -sp * sy, cp * sy, 0, sy, sp * cy, -cp * cy, 0, 0, cp, sp, 0, 0, 0, 0, 1];  // z is up
    const to_middle = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...body.middle.map(v => -v), 1];
    const away = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, this.shift[0] * body.size, this.shift[1] * body.size, -far, 1];
    const near = Math.max(far - 1.5 * body.size, far / 200), end = far + 1.5 * body.size, f = 1 / Math.tan(0.3);
    const aspect = canvas.width / canvas.height, wide = Math.min(1, aspect);
    const lens = [f * wide / aspect, 0, 0, 0, 0, f * wide, 0, 0, 0, 0, (near + end) / (near - end), -1, 0, 0, 2 * near * end / (near - end), 0];
    return {view: product(away, product(turn, to_middle)), lens: new Float32Array(lens), near: far - 0.5 * body.size};
  }

  draw() {
    const {gl, canvas} = this, scale = Math.min(devicePixelRatio || 1, 2);
    if (!this.body || !canvas.clientWidth) return;
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const at = this.camera();
    if (this.look.surface) this.paint('surface', at, [['place', 3], ['value', 1]], program => {
      gl.uniform1f(gl.getUniformLocation(program, 'opaque'), 1);
      gl.drawArrays(gl.TRIANGLES, 0, this.buffers.surface.floats / 4);
    });
    if (this.look.spheres) this.paint('spheres', at, [['place', 3], ['radius', 1], ['value', 1]], program => {
      gl.uniform1f(gl.getUniformLocation(program, 'share'), this.look.lines ? 0.45 : 1);
      gl.drawArrays(gl.POINTS, 0, this.buffers.spheres.floats / 5);
    });
    if (this.look.lines) this.paint('lines', at, [['from', 3], ['to', 3], ['value', 2]], program => {
      this.corners ??= this.quad();
      const corner = gl.getAttribLocation(program, 'corner');
      gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
      gl.enableVertexAttribArray(corner);
      gl.vertexAttribPointer(corner, 2, gl.FLOAT, false, 0, 0);
      gl.uniform1f(gl.getUniformLocation(program, 'wide'), (this.look.surface ? 0.7 : 1.1) * scale);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.buffers.lines.floats / 8);
    }, 1);
    this.count_pixels();
  }

  /** Once, for whoever checks the page: how many pixels the body takes. */
  count_pixels() {
    if (this.canvas.dataset.pixels) return;
    const {gl, canvas} = this, pixels = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let drawn = 0;
    for (let i = 3; i < pixels.length; i += 4) drawn += pixels[i] > 0;
    canvas.dataset.pixels = drawn;
  }

  quad() {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 0, 1, 1, -1, 1, 1]), gl.STATIC_DRAW);
    return buffer;
  }

  paint(name, at, attributes, draw, each = 0) {
    const gl = this.gl, program = this.programs[name], uniform = what => gl.getUniformLocation(program, what);
    gl.useProgram(program);
    gl.bindVertexArray(this.buffers[name].array ??= gl.createVertexArray());
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name].buffer);
    const stride = 4 * attributes.reduce((sum, [, count]) => sum + count, 0);
    let offset = 0;
    for (const [attribute, count] of attributes) {
      const place = gl.getAttribLocation(program, attribute);
      if (place >= 0) {
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, count, gl.FLOAT, false, stride, offset);
        gl.vertexAttribDivisor(place, each);
      }
      offset += 4 * count;
    }
    gl.uniformMatrix4fv(uniform('view'), false, at.view);
    gl.uniformMatrix4fv(uniform('lens'), false, at.lens);
    gl.uniform2f(uniform('size'), this.canvas.width, this.canvas.height);
    gl.uniform1i(uniform('map'), this.map);
    gl.uniform1f(uniform('near'), at.near);
    gl.uniform1f(uniform('deep'), this.box.size);
    const dark = matchMedia('(prefers-color-scheme: dark)').matches;
    gl.uniform3fv(uniform('ground'), dark ? [.09, .1, .13] : [.97, .97, .98]);
    draw(program);
    gl.bindVertexArray(null);
  }

  listen() {
    const canvas = this.canvas, fingers = new Map();
    const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    canvas.addEventListener('pointerdown', event => {
      fingers.set(event.pointerId, {x: event.clientX, y: event.clientY});
      canvas.setPointerCapture(event.pointerId);
    });
    for (const kind of ['pointerup', 'pointercancel']) canvas.addEventListener(kind, event => fingers.delete(event.pointerId));
    canvas.addEventListener('pointermove', event => {
      const finger = fingers.get(event.pointerId);
      if (!finger) return;
      const dx = event.clientX - finger.x, dy = event.clientY - finger.y, before = fingers.size > 1 ? spread() : 0;
      fingers.set(event.pointerId, {x: event.clientX, y: event.clientY});
      if (fingers.size > 1) this.turn(0, 0, spread() / (before || 1));
      else if (event.shiftKey) this.move(dx, dy);
      else this.turn(dx * 0.008, dy * 0.008, 1);
    });
    canvas.addEventListener('wheel', event => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;  // a page that is scrolled past must not zoom
      event.preventDefault();
      this.turn(0, 0, Math.exp(-event.deltaY * 0.0015));
    }, {passive: false});
    const keys = {ArrowLeft: [-.1, 0, 1], ArrowRight: [.1, 0, 1], ArrowUp: [0, -.1, 1], ArrowDown: [0, .1, 1],
      '+': [0, 0, 1.15], '-': [0, 0, 1 / 1.15]};
    canvas.addEventListener('keydown', event => {
      if (event.key === '0') this.reset();
      if (!keys[event.key]) return;
      event.preventDefault();
      this.turn(...keys[event.key]);
    });
    canvas.addEventListener('dblclick', () => this.reset());
  }

  turn(yaw, pitch, zoom) {
    this.yaw += yaw;
    this.pitch = Math.max(-1.55, Math.min(1.55, this.pitch + pitch));
    this.zoom = Math.max(0.2, Math.min(20, this.zoom * zoom));
    this.request();
  }

  move(dx, dy) {
    const share = 1.3 / (this.zoom * this.canvas.clientHeight);
    this.shift = [this.shift[0] + dx * share, this.shift[1] - dy * share];
    this.request();
  }
}
