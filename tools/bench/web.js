// The other side of `tools/bench/commands web`: node web.js NPM CELLS KIND STRATEGY SIDE DT STEPS takes the same steps in WebAssembly
// and prints the seconds that they took and where the first molecule is then.
'use strict';
const fs = require('node:fs');
const [npm, cells, kind, strategy, side, dt, steps] = process.argv.slice(2), {load} = require(npm);

load().then(elastin => {
  const body = kind === 'lattice' ? elastin.lattice([+side, +side, +side], 0.01, {density: 1000})
    : elastin.body({...JSON.parse(fs.readFileSync(cells)), density: 1000});
  const tissue = body.simulate(strategy, {youngs_modulus: 1e5, poissons_ratio: 0.25}), forces = tissue.host_forces;
  for (let i = 0; i < forces.length; i += 3) forces[i] = 1e-2 * i / forces.length;
  tissue.step(+dt);
  const begin = process.hrtime.bigint();
  for (let i = 0; i < +steps; ++i) tissue.step(+dt);
  console.log(`${1e-9 * Number(process.hrtime.bigint() - begin)} ${tissue.positions[0]}`);
}).catch(problem => {
  console.error(problem);
  process.exit(1);
});
