// A soft body of Rapier from body.json: `soft_body(RAPIER, data)`. Run as a program it is an engine of `elastin compare`:
// a request, one line of JSON, comes in, the equilibrium goes out. npm install @dimforge/rapier3d-compat
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

/** SoftBodyDesc: edges, each of the natural frequency that gives it k; without springs cells with E and nu. */
export function soft_body(RAPIER, data, solver = RAPIER.SoftBodySolver.Constraints) {
  const held = data.supports.map((support) => support.molecule), fixed = new Set(held);
  const desc = new RAPIER.SoftBodyDesc(new Float32Array(data.positions.flat()))
    .setMasses(new Float32Array(data.masses)).setPinnedParticles(new Uint32Array(held)).setSelfContacts(false)
    .setNoSurfaceCollider().setCanSleep(false);
  if (data.connections.length) {
    const moving = data.connections.filter(({ a, b }) => !(fixed.has(a) && fixed.has(b)));
    const weight = (i) => (fixed.has(i) ? 0 : 1 / data.masses[i]);
    return desc.setEdges(new Uint32Array(moving.flatMap(({ a, b }) => [a, b]))).setEdgeSoftness(
      new Uint32Array(moving.keys()), moving.map(({ a, b, stiffness }) => ({
        naturalFrequency: Math.sqrt(stiffness * (weight(a) + weight(b))) / (2 * Math.PI), dampingRatio: 1 })));
  }
  const { youngs_modulus, poissons_ratio } = data.tetrahedra[0];
  if (data.tetrahedra.some((cell) => cell.youngs_modulus !== youngs_modulus))
    throw new Error("Rapier has one material a body, and these cells have several");
  const material = new RAPIER.SoftBodyMaterial();
  Object.assign(material, { youngModulus: youngs_modulus, poissonRatio: poissons_ratio });
  return desc.setMaterial(material).setEdges(new Uint32Array(0)).setVolumePreservation(false).setSolver(solver)
    .setCells(new Uint32Array(data.tetrahedra.flatMap((cell) => cell.nodes)))
    .setCellModel(RAPIER.SoftBodyCellModel.Corotational);
}

async function answer({ body: data, dt, iterations, most_steps, tolerance }) {
  if (data.supports.some(({ fixed }) => !fixed.every(Boolean)))
    return { error: "Rapier pins molecules in all directions or in none: write fixed_grip: clamped" };
  if (data.supports.some(({ displacement }) => displacement.some((value) => value !== 0)))
    return { error: "Rapier gives no reactions: load the body by a force, not by a displacement" };
  const found = createRequire(process.cwd() + "/").resolve("@dimforge/rapier3d-compat");
  const RAPIER = (await import(pathToFileURL(found))).default;
  await RAPIER.init();
  const world = new RAPIER.World({ x: 0, y: 0, z: 0 });
  world.timestep = dt;
  world.numSolverIterations = iterations ?? world.numSolverIterations;
  const body = world.createSoftBody(soft_body(RAPIER, data));
  const count = data.positions.length;
  const start = performance.now();
  const noise = 2 ** -21 * Math.max(...data.positions.flat().map(Math.abs));  // of single precision
  let steps = 0, energy = 0, before = body.particlePositions();
  for (let quiet = 0; steps < most_steps && quiet < 3;) {
    for (let i = 0; i < 50; ++i, ++steps) {
      body.resetForces();
      for (const { molecule, force: [x, y, z] } of data.forces) body.addParticleForce(molecule, { x, y, z }, true);
      world.step();
      // Kinetic damping: all that moves is stopped where the kinetic energy has passed a largest value.
      const now = body.particleVelocities().reduce((sum, v, i) => sum + data.masses[Math.floor(i / 3)] * v * v, 0);
      if (now < energy) for (let p = 0; p < count; ++p) body.setParticleVelocity(p, { x: 0, y: 0, z: 0 });
      energy = now < energy ? 0 : now;
    }
    const now = body.particlePositions();
    let moved = 0, far = 0;
    now.forEach((x, i) => {
      moved = Math.max(moved, Math.abs(x - before[i]));
      far = Math.max(far, Math.abs(x - data.positions[Math.floor(i / 3)][i % 3]));
    });
    quiet = moved <= Math.max(tolerance * far, noise) ? quiet + 1 : 0;
    before = now;
  }
  const positions = data.positions.map((_, i) => [...before.slice(3 * i, 3 * i + 3)]);
  return { engine: `@dimforge/rapier3d-compat ${RAPIER.version()}`, positions, iterations: world.numSolverIterations, steps, at_rest: steps < most_steps,
           seconds_per_step: (performance.now() - start) / 1000 / steps };
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href)
  console.log(JSON.stringify(await answer(JSON.parse(readFileSync(0))).catch((error) => ({ error: error.message }))));
