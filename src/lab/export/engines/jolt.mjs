// A soft body of Jolt from body.json: `soft_body(Jolt, data)`. Run as a program it is an engine of `elastin compare`:
// a request, one line of JSON, comes in, the equilibrium goes out. npm install jolt-physics
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

/** SoftBodySharedSettings: vertices with their masses (held ones have none to move), edges of the compliance 1/k. */
export function soft_body(Jolt, data) {
  const settings = new Jolt.SoftBodySharedSettings();
  const held = new Set(data.supports.map((support) => support.molecule));
  data.positions.forEach(([x, y, z], i) => {
    const vertex = new Jolt.SoftBodySharedSettingsVertex();
    vertex.mPosition = new Jolt.Float3(x, y, z);
    vertex.mInvMass = held.has(i) ? 0 : 1 / data.masses[i];
    settings.mVertices.push_back(vertex);
  });
  for (const { a, b, rest_length, stiffness } of data.connections) {
    const edge = new Jolt.SoftBodySharedSettingsEdge(a, b, 1 / stiffness);
    edge.mRestLength = rest_length;
    settings.mEdgeConstraints.push_back(edge);
  }
  settings.Optimize();
  return settings;
}

function make_world(Jolt, jobs) {
  const world = new Jolt.JoltSettings();
  const pairs = new Jolt.ObjectLayerPairFilterTable(1);
  const layers = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
  layers.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  world.mObjectLayerPairFilter = pairs;
  world.mBroadPhaseLayerInterface = layers;
  world.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 1, pairs, 1);
  return new Jolt.JoltInterface(world);
}

async function answer({ body: data, dt, iterations, most_steps, tolerance }) {
  if (data.supports.some(({ fixed }) => !fixed.every(Boolean)))
    return { error: "Jolt holds molecules in all directions or in none: write fixed_grip: clamped" };
  if (data.supports.some(({ displacement }) => displacement.some((value) => value !== 0)))
    return { error: "Jolt gives no reactions: load the body by a force, not by a displacement" };
  const found = createRequire(process.cwd() + "/").resolve("jolt-physics");
  const Jolt = await (await import(pathToFileURL(found))).default();
  const world = make_world(Jolt);
  const creation = new Jolt.SoftBodyCreationSettings(
    soft_body(Jolt, data), new Jolt.RVec3(0, 0, 0), new Jolt.Quat(0, 0, 0, 1), 0);
  // Its iterations are substeps of one pass each. Loads act in each, as its gravity does; it has no other forces on
  // single vertices.
  const passes = iterations ?? creation.mNumIterations, velocity = new Jolt.Vec3(0, 0, 0);
  Object.assign(creation, { mUpdatePosition: false, mMakeRotationIdentity: true, mGravityFactor: 0, mLinearDamping: 0,
                            mVertexRadius: 0, mNumIterations: 1, mMaxLinearVelocity: 1e6 });
  const system = world.GetPhysicsSystem(), bodies = system.GetBodyInterface();
  const soft = bodies.CreateSoftBody(creation);
  bodies.AddBody(soft.GetID(), Jolt.EActivation_Activate);
  soft.SetAllowSleeping(false);
  const motion = Jolt.castObject(soft.GetMotionProperties(), Jolt.SoftBodyMotionProperties);
  const vertices = data.positions.map((_, i) => motion.GetVertex(i));
  const pushed = data.forces.map(({ molecule, force }) =>
    [vertices[molecule], force.map((f) => (f * dt) / passes / data.masses[molecule])]);
  const read = () => vertices.map(({ mPosition: p }) => [p.GetX(), p.GetY(), p.GetZ()]);
  const start = performance.now();
  const noise = 2 ** -21 * Math.max(...data.positions.flat().map(Math.abs));  // of single precision
  let steps = 0, energy = 0, before = read();
  for (let quiet = 0; steps < most_steps && quiet < 3;) {
    for (let i = 0; i < 50; ++i, ++steps) {
      for (let pass = 0; pass < passes; ++pass) {
        for (const [vertex, [x, y, z]] of pushed) {
          const v = vertex.mVelocity;
          velocity.Set(v.GetX() + x, v.GetY() + y, v.GetZ() + z);
          vertex.mVelocity = velocity;
        }
        world.Step(dt / passes, 1);
        // Kinetic damping: all that moves is stopped where the kinetic energy has passed a largest value.
        const now = vertices.reduce((sum, { mVelocity: v }, p) => sum + data.masses[p] * v.LengthSq(), 0);
        velocity.Set(0, 0, 0);
        if (now < energy) for (const vertex of vertices) vertex.mVelocity = velocity;
        energy = now < energy ? 0 : now;
      }
    }
    const now = read();
    let moved = 0, far = 0;
    now.forEach((p, i) => p.forEach((x, axis) => {
      moved = Math.max(moved, Math.abs(x - before[i][axis]));
      far = Math.max(far, Math.abs(x - data.positions[i][axis]));
    }));
    quiet = moved <= Math.max(tolerance * far, noise) ? quiet + 1 : 0;
    before = now;
  }
  const version = JSON.parse(readFileSync(new URL("../package.json", pathToFileURL(found)))).version;
  return { engine: `jolt-physics ${version}`, positions: before, iterations: passes, steps, at_rest: steps < most_steps,
           seconds_per_step: (performance.now() - start) / 1000 / steps };
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href)
  console.log(JSON.stringify(await answer(JSON.parse(readFileSync(0))).catch((error) => ({ error: error.message }))));
