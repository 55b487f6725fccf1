// What a page knows of a body and its states, as plain arrays: positions and displacements hold three floats a molecule
// [m], ends two molecules a connection, surface three molecules a face. No element of the page is touched here.
'use strict';

function bytes_of(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  return bytes.buffer;
}

/** The text that was packed as base64 of gzip. */
async function unpacked(text) {
  if (typeof DecompressionStream === 'undefined')
    throw new Error('this browser cannot unpack it; Chrome 80, Firefox 113 and Safari 16.4 or newer can');
  return new Response(new Blob([bytes_of(text)]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
}

/** A body from the JSON that body_view of src/lab/report/view.h writes. */
function body_from(json) {
  const body = {rest: new Float32Array(bytes_of(json.rest)), radius: new Float32Array(bytes_of(json.radius)),
    ends: new Uint32Array(bytes_of(json.ends)), surface: new Uint32Array(bytes_of(json.surface)), cells: new Int32Array(bytes_of(json.cells)),
    numbers: json.numbers && new Int32Array(bytes_of(json.numbers)), membrane: json.membrane, note: json.shown,
    image: json.image && {...json.image, values: new Uint8Array(bytes_of(json.image.values))},
    obstacles: (json.obstacles ?? []).map(({name, lines}) => ({name, lines: new Float32Array(bytes_of(lines))}))};
  return Object.assign(body, {size: diagonal_of(body.rest)});
}

/** Numbers that were written as whole shares of the largest, byte by byte, the sign in the lowest bit. */
function numbers_from({most, steps, planes}, count) {
  const bytes = new Uint8Array(bytes_of(planes)), numbers = new Float32Array(count);
  for (let i = 0; i < count; ++i) {
    let bits = 0;
    for (let at = i, weight = 1; at < bytes.length; at += count, weight *= 256) bits += weight * bytes[at];
    numbers[i] = (bits % 2 ? -(bits + 1) / 2 : bits / 2) / steps * most;
  }
  return numbers;
}

/** States from the JSON of states_view: at [s], share of the load or number of a vibration's mode, displacements [m], tensions [N], outer forces [N],
 *  stresses of faces [Pa] and contact pressures [Pa] where there are any; `pose i` of the obstacles: three axes and a place [m]. */
function states_from(json, body) {
  const molecules = body.radius.length, faces = body.surface.length / 3;
  const counts = {displacements: 3 * molecules, tensions: body.ends.length / 2, forces: molecules, stresses: faces, pressures: molecules};
  return json.frames.map(frame => Object.fromEntries([['at', frame.at], ...(frame.poses ?? []).map((pose, i) => [`pose ${i}`, pose]),
    ...Object.entries(counts).filter(([name]) => frame[name]).map(([name, count]) => [name, numbers_from(frame[name], count)])]));
}

/** Diagonal of the box around positions [m]; 1 where there is one position alone. */
function diagonal_of(positions) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  positions.forEach((v, i) => {
    low[i % 3] = Math.min(low[i % 3], v);
    high[i % 3] = Math.max(high[i % 3], v);
  });
  return Math.hypot(...low.map((v, k) => high[k] - v)) || 1;
}

/** The state between two frames: 2.25 is a quarter of the range from frame 2 to frame 3. */
function state_at(frames, position) {
  const first = Math.min(Math.floor(position), frames.length - 1), share = position - first;
  const a = frames[first], b = frames[Math.min(first + 1, frames.length - 1)];
  if (share < 1e-6) return a;
  const mixed = (x, y) => x.map((v, i) => v + share * ((y?.[i] ?? v) - v));
  const names = Object.keys(b).filter(name => name !== 'at');
  return Object.fromEntries([['at', a.at + share * (b.at - a.at)], ...names.map(name => [name, mixed(a[name] ?? b[name].map(() => 0), b[name])])]);
}

/** Ends of an obstacle's lines [m] in space, three numbers a point. */
function lines_in_space(lines, pose) {
  return lines.map((_, i) => pose[9 + i % 3] + [0, 1, 2].reduce((sum, axis) => sum + pose[3 * axis + i % 3] * lines[i - i % 3 + axis], 0));
}

/** Positions [m] with the displacements times a factor. */
function positions_of(body, displacements, times) {
  return body.rest.map((v, i) => v + times * displacements[i]);
}

/** Squared length of a connection at rest and its change, without the loss of digits that a difference of squares brings. */
function stretch_of(body, displacements, a, b) {
  let square = 0, change = 0;
  for (let k = 0; k < 3; ++k) {
    const d = body.rest[3 * b + k] - body.rest[3 * a + k], u = displacements[3 * b + k] - displacements[3 * a + k];
    square += d * d;
    change += u * (2 * d + u);
  }
  return {square, change};
}

/** Lengthening of each connection over its length at rest. */
function strains_of(body, displacements) {
  return Float32Array.from({length: body.ends.length / 2}, (_, c) => {
    const {square, change} = stretch_of(body, displacements, body.ends[2 * c], body.ends[2 * c + 1]);
    const length = Math.sqrt(square);
    return length > 0 ? change / (length * (length + Math.sqrt(Math.max(0, square + change)))) : 0;
  });
}

/** The principal strain of each face, λ − 1, that is the larger in size; 0 for a face without area.
 *  The stretches λ are the square roots of the eigenvalues of C = 1 + 2 E, E being Green's strain in the face, which the
 *  three edges alone determine: (change of the squared length of edge e) = 2 eᵀ E e. */
function face_strains_of(body, displacements) {
  const {rest, surface} = body;
  return Float32Array.from({length: surface.length / 3}, (_, face) => {
    const [a, b, c] = surface.subarray(3 * face, 3 * face + 3);
    const u = stretch_of(body, displacements, a, b), v = stretch_of(body, displacements, a, c), w = stretch_of(body, displacements, b, c);
    let dot = 0;
    for (let k = 0; k < 3; ++k) dot += (rest[3 * b + k] - rest[3 * a + k]) * (rest[3 * c + k] - rest[3 * a + k]);
    const width = Math.sqrt(u.square), foot = dot / width, height = Math.sqrt(v.square - foot * foot);
    if (!(width > 0 && height > 0)) return 0;
    // C − 1 in axes along the edge from a to b and across it.
    const shear = (u.change + v.change - w.change) / 2;
    const xx = u.change / u.square, xy = (shear - xx * width * foot) / (width * height);
    const yy = (v.change - xx * foot * foot - 2 * xy * foot * height) / (height * height);
    const mean = (xx + yy) / 2, spread = Math.hypot((xx - yy) / 2, xy);
    const strain = excess => excess / (1 + Math.sqrt(Math.max(0, 1 + excess)));
    const most = strain(mean + spread), least = strain(mean - spread);
    return most > -least ? most : least;
  });
}

/** Of each molecule the mean over its connections. */
function means_of(body, values) {
  const sums = new Float32Array(body.radius.length), counts = new Uint16Array(body.radius.length);
  body.ends.forEach((molecule, i) => { sums[molecule] += values[i >> 1]; ++counts[molecule]; });
  return sums.map((sum, i) => counts[i] ? sum / counts[i] : 0);
}

/** Of each molecule the mean over the faces at it; 0 inside. */
function means_of_faces(body, values) {
  const sums = new Float32Array(body.radius.length), counts = new Uint16Array(body.radius.length);
  body.surface.forEach((molecule, i) => { sums[molecule] += values[Math.floor(i / 3)]; ++counts[molecule]; });
  return sums.map((sum, i) => counts[i] ? sum / counts[i] : 0);
}

/** Of each molecule the length of its displacement, or of the difference to another [m]. */
function lengths_of(displacements, others) {
  return Float32Array.from({length: displacements.length / 3}, (_, molecule) => {
    const of = k => displacements[3 * molecule + k] - (others ? others[3 * molecule + k] : 0);
    return Math.hypot(of(0), of(1), of(2));
  });
}
