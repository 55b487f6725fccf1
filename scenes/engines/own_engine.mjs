// An engine of one's own for `elastin compare SCENE --engine 'node scenes/engines/own_engine.mjs'`.
// Springs in explicit steps, slowed down until nothing moves. Reads the request from standard input, prints the answer.
import { readFileSync } from "node:fs";

const request = JSON.parse(readFileSync(0, "utf8")), body = request.body;
const count = body.positions.length, axes = [0, 1, 2];
const x = Float64Array.from(body.positions.flat()), v = new Float64Array(3 * count);
const fixed = new Uint8Array(3 * count), loads = new Float64Array(3 * count), stiffness = new Float64Array(count);
for (const { molecule, fixed: held, displacement } of body.supports)
  for (const axis of axes) {
    fixed[3 * molecule + axis] = held[axis];
    x[3 * molecule + axis] += displacement[axis];
  }
for (const { molecule, force } of body.forces) loads.set(force, 3 * molecule);
for (const { a, b, stiffness: k } of body.connections) {
  stiffness[a] += 2 * k;
  stiffness[b] += 2 * k;
}
const stable = 0.9 * Math.min(...body.masses.map((mass, i) => 2 / Math.sqrt(stiffness[i] / mass)));
const dt = Math.min(request.dt, stable), keep = 0.98, start = performance.now();
let steps = 0, force;
for (; steps < request.most_steps; ++steps) {
  force = loads.slice();
  for (const { a, b, rest_length, stiffness: k } of body.connections) {
    const span = axes.map((axis) => x[3 * b + axis] - x[3 * a + axis]);
    const density = k * (1 - rest_length / Math.hypot(...span));
    for (const axis of axes) {
      force[3 * a + axis] += density * span[axis];
      force[3 * b + axis] -= density * span[axis];
    }
  }
  let scale = 0, loose = 0;
  force.forEach((f, i) => {
    scale = Math.max(scale, Math.abs(f));
    if (!fixed[i]) loose = Math.max(loose, Math.abs(f));
  });
  if (loose < 1e-6 * scale) break;
  for (let i = 0; i < 3 * count; ++i)
    if (!fixed[i]) x[i] += dt * (v[i] = keep * v[i] + (dt * force[i]) / body.masses[Math.floor(i / 3)]);
}
const rows = (list) => body.positions.map((_, i) => [...list.slice(3 * i, 3 * i + 3)]);
console.log(JSON.stringify({ engine: "forty lines of JavaScript", positions: rows(x), steps,
                             reactions: rows(force.map((f, i) => (fixed[i] ? -f : 0))),
                             at_rest: steps < request.most_steps,
                             seconds_per_step: (performance.now() - start) / 1000 / Math.max(steps, 1) }));
