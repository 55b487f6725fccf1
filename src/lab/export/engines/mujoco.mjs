// An engine of `elastin compare`: MuJoCo with the body.xml in the request's folder. npm install @mujoco/mujoco
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

async function answer({ body: data, dt, folder, most_steps, tolerance }) {
  if (data.supports.some(({ displacement }) => displacement.some((value) => value !== 0)))
    return { error: "this driver of MuJoCo loads bodies by forces, not by displacements" };
  const found = createRequire(process.cwd() + "/").resolve("@mujoco/mujoco");
  const mujoco = await (await import(pathToFileURL(found))).default();
  const model = mujoco.MjModel.from_xml_string(readFileSync(`${folder}/body.xml`, "utf8"));
  model.opt.timestep = dt;
  const state = new mujoco.MjData(model);
  // Axes that are held have no joint: which coordinate moves which molecule along which axis.
  const joints = [];
  data.positions.forEach((_, i) => {
    const first = model.body_jntadr[i + 1];
    for (let j = 0; j < model.body_jntnum[i + 1]; ++j)
      joints.push([i, [0, 1, 2].findIndex((axis) => model.jnt_axis[3 * (first + j) + axis] === 1)]);
  });
  const load = new Float64Array(joints.length);
  for (const { molecule, force } of data.forces)
    joints.forEach(([i, axis], q) => { if (i === molecule) load[q] = force[axis]; });
  const start = performance.now();
  let steps = 0, energy = 0, before = Array.from(state.qpos), cause;
  for (let quiet = 0; steps < most_steps && quiet < 3 && !cause;) {
    for (let i = 0; i < 50; ++i, ++steps) {
      if (steps < 50) load.forEach((f, q) => { state.qfrc_applied[q] = (f * (steps + 1)) / 50; });
      mujoco.mj_step(model, state);
      // Kinetic damping: all that moves is stopped where the kinetic energy has passed a largest value.
      const now = state.qvel.reduce((sum, v, q) => sum + data.masses[joints[q][0]] * v * v, 0);
      if (now < energy) state.qvel.fill(0);
      energy = now < energy ? 0 : now;
    }
    const now = Array.from(state.qpos);
    const far = Math.max(...now.map(Math.abs)), moved = Math.max(...now.map((x, q) => Math.abs(x - before[q])));
    // MuJoCo sets a body that has become unstable back to where it was, and its clock too.
    if (state.time < (steps - 25) * dt) cause = "it became unstable: take smaller time steps";
    quiet = moved <= tolerance * far ? quiet + 1 : 0;
    before = now;
  }
  const positions = data.positions.map((place) => [...place]);
  joints.forEach(([i, axis], q) => { positions[i][axis] += before[q]; });
  return { engine: `@mujoco/mujoco ${mujoco.mj_versionString?.() ?? ""}`.trim(), positions, steps, at_rest: steps < most_steps && !cause, cause,
           seconds_per_step: (performance.now() - start) / 1000 / steps };
}

console.log(JSON.stringify(await answer(JSON.parse(readFileSync(0))).catch((error) => ({ error: error.message }))));
