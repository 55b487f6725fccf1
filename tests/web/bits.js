// What bits.c does, in the module for browsers: prints the same lines where both are bitwise identical.
//   node bits.js FOLDER [steps]      folder of elastin.js and elastin.wasm
'use strict';
const fs = require('node:fs'), path = require('node:path');
const folder = path.resolve(process.argv[2]), steps = +(process.argv[3] || 1000);
const elastin_module = require(path.join(folder, 'elastin.js'));

/** The C functions, with strings for words; a status that is not 0 throws. */
function face(module) {
  const room = module._malloc(256);
  const text = word => {
    const at = module._malloc(module.lengthBytesUTF8(word) + 1);
    module.stringToUTF8(word, at, module.lengthBytesUTF8(word) + 1);
    return at;
  };
  const numbers = values => {
    const at = module._malloc(8 * values.length);
    module.HEAPF64.set(values, at / 8);
    return at;
  };
  const wholes = values => {
    const at = module._malloc(4 * values.length);
    module.HEAP32.set(values, at / 4);
    return at;
  };
  const call = (name, ...values) => {
    const status = module['_elastin_' + name](...values);
    if (status) throw Object.assign(new Error(module.UTF8ToString(module._elastin_message())), {status});
  };
  const word = at => module.HEAPU32[at / 4];
  return {module, room, text, numbers, wholes, call, word};
}

function checksum(module, at, count, sum) {
  for (const half of module.HEAPU32.subarray(at / 4, at / 4 + 2 * count)) sum = Math.imul(sum ^ half, 16777619) >>> 0;
  return sum;
}

function lattice({call, wholes, numbers, room, word}) {
  call('lattice', wholes([6, 5, 4]), numbers([0.1, 0.1, 0.1]), 3, 1000, room);
  return word(room);
}

function tetrahedra({call, module, wholes, numbers, room, word}) {
  const positions = [], cells = [], order = [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]];
  for (let m = 0; m < 64; ++m) for (let axis = 0; axis < 3; ++axis) positions.push(0.1 * (m >> 2 * axis & 3));
  for (let cube = 0; cube < 27; ++cube)
    for (const [b, c] of order)
      for (const corner of [0, b, c, 7])
        cells.push(cube % 3 + (corner & 1) + 4 * (Math.floor(cube / 3) % 3 + (corner >> 1 & 1)) + 16 * (Math.floor(cube / 9) + (corner >> 2)));
  const arrays = room + 32, size = 64;
  module.HEAPU32.fill(0, arrays / 4, arrays / 4 + size / 4);
  // size; seven pointers; four counts; two doubles
  module.HEAPU32.set([size, numbers(positions), 0, 0, 0, 0, 0, wholes(cells), 64, 0, 0, 6 * 27], arrays / 4);
  module.HEAPF64.set([1000, 0], arrays / 8 + 6);
  call('body_from_arrays', arrays, room);
  return word(room);
}

function run(f, name, body, strategy, stepper) {
  const {module, room, call, word} = f;
  const material = f.numbers([0, 1e5, 0.25, 0, 0, 0]), options = f.wholes(new Array(16).fill(0));
  module.HEAPU32[material / 4] = 48;
  module.HEAPU32.set([24, f.text(stepper)], options / 4);
  if (module._elastin_simulate(body, f.text(strategy), material, options, room)) return;
  const tissue = word(room);
  call('body_positions', body, room, room + 4);
  const [rest, count] = [word(room), word(room + 4)];
  for (let m = 0; m < count / 3; ++m) if (module.HEAPF64[rest / 8 + 3 * m + 2] === 0) call('fix', tissue, m, 0);
  const down = f.numbers([0, 2.5, 0, -9.81]);
  module.HEAPU32[down / 4] = f.text('acceleration_x');
  module.HEAPU32[down / 4 + 4] = f.text('acceleration_z');
  call('add', tissue, f.text('gravity'), down, 2);
  const taken = stepper === 'velocity_verlet' || stepper === 'symplectic_euler' ? steps : steps / 10;
  for (let i = 0; i < taken; ++i) call('step', tissue, 2e-3, 0);
  let sum = 2166136261;
  for (const what of ['positions', 'velocities']) {
    call(what, tissue, room, room + 4);
    sum = checksum(module, word(room), word(room + 4), sum);
  }
  console.log(`${name} ${strategy} ${stepper} ${sum.toString(16).padStart(8, '0')}`);
  module._elastin_simulation_free(tissue);
}

elastin_module({wasmBinary: fs.readFileSync(path.join(folder, 'elastin.wasm'))}).then(module => {
  const f = face(module), {room, call, word} = f;
  const name_of = (...values) => {
    call(...values, room, 0, 0);
    return module.UTF8ToString(word(room));
  };
  call('strategy_count', room);
  const strategies = word(room), table = f.text('steppers');
  call('row_count', table, room);
  const steppers = word(room);
  for (const [name, body] of [['lattice', lattice(f)], ['tetrahedra', tetrahedra(f)]])
    for (let s = 0; s < strategies; ++s)
      for (let k = 0; k < steppers; ++k) run(f, name, body, name_of('strategy', s), name_of('row', table, k));
}).catch(problem => {
  console.error(problem);
  process.exit(1);
});
