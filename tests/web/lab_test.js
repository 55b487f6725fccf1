// Opens pages of `elastin lab` from disk in a headless Chromium and works them as a visitor does.
//   node lab_test.js CHROMIUM WHAT PAGE [arguments]
//     drag PAGE                     drags a molecule by mouse and by finger, pins one, pushes, pauses, steps, by keys too
//     settings PAGE                 begins as the scene has it, and says what an address has that the page has not
//     refused_stepper PAGE          of cells of second order: what cannot step them is said and taken back
//     words PAGE TEXT …             says each of these texts once the body was pulled; after -- those that it must not say
//     strategies PAGE NAME E ERROR NAME E ERROR …   switches to each strategy, runs the tension test and compares E [Pa] and
//                                   its error with the command's; "none": no error
//     rest PAGE                     a body at rest is not drawn again and again
//     painters PAGE                 by the graphics card and by the processor the body looks the same
//     wild PAGE SECONDS SEED        clicks, drags and slides at random: no exception, nothing that is not finite, memory flat
//     access PAGE                   labels, roles, contrast, what overflows, at 1400 and 390 px, light and dark
//     axe PAGE AXE                  axe-core's own rules, AXE its axe.min.js, at 1400 and 390 px, light and dark
//     refused PAGE                  without WebGL the processor draws; without WebAssembly the page says so
//     frames PAGE SECONDS [STRATEGY [PAINTER]]   pictures a second of a body that is pulled; drawn by graphics or processor
//     pictures PAGE FOLDER          screenshots at 1400 and 390 px, light and dark
'use strict';
const fs = require('node:fs'), path = require('node:path'), {Browser, sleep} = require('./browser.js');
const [chromium, what, page, ...more] = process.argv.slice(2), url = 'file://' + path.resolve(page);

function must(holds, words) {
  if (!holds) throw new Error(words);
}

const text = (browser, id) => browser.eval(`document.getElementById('${id}').textContent`);

/** Where the highest molecule that is seen stands on the page, and its number. */
const top_molecule = browser => browser.eval(`(() => {
  const {viewer} = lab, box = viewer.canvas.getBoundingClientRect();
  for (let y = 8; y < box.height; y += 4)
    for (let x = 8; x < box.width; x += 6) {
      const molecule = viewer.molecule_at(x, y);
      if (molecule >= 0) return {x: x + box.left, y: y + box.top, molecule};
    }
})()`);

/** How far a drawn molecule is from where it rests [m]. */
const moved = (browser, molecule) => browser.eval(`Math.hypot(...[0, 1, 2].map(k =>
  lab.viewer.positions[3 * ${molecule} + k] - lab.shown.rest[3 * ${molecule} + k]))`);

async function sound(browser) {
  must(browser.said.length === 0, `the page said: ${browser.said.join('; ')}`);
  const errors = await browser.eval('document.documentElement.dataset.errors');
  must(!errors, `the page said: ${errors}`);
  must(await browser.eval('!lab.viewer?.positions || lab.viewer.positions.every(v => Number.isFinite(v))'), 'a position is not finite');
  const words = await browser.eval('(document.body.innerText.match(/.{0,30}(NaN|undefined|Infinity).{0,20}/) ?? [])[0]');
  must(!words, `the page says "${words}"`);
  const outside = browser.asked.filter(address => !/^(file|blob|data|about):/.test(address));
  must(outside.length === 0, `the page requested ${outside}`);
}

async function drag_by_mouse(browser) {
  const {x, y, molecule} = await top_molecule(browser), before = await moved(browser, molecule);
  await browser.mouse('mousePressed', x, y);
  for (let i = 1; i <= 8; ++i) {
    await browser.mouse('mouseMoved', x + 6 * i, y - 3 * i);
    await sleep(40);
  }
  await browser.until('/hand [0-9.]+ [nµmkMG]?N/.test(document.getElementById("readout").textContent)', 20);
  const after = await moved(browser, molecule);
  must(after > before + 0.005 * await browser.eval('lab.body.size'), `the molecule went from ${before} to ${after} m`);
  await browser.mouse('mouseReleased', x + 48, y - 24, 0);
  await browser.until('!/hand/.test(document.getElementById("readout").textContent)', 10);
}

/** Back to rest, so that a molecule is still where it was seen when the hand comes down. */
async function rest(browser) {
  const before = await browser.eval('lab.answer[0].time');
  await browser.eval('document.getElementById("reset").click()');
  await browser.until(`!lab.rebuild && lab.answer[0].time < ${before}`, 20);
}

async function drag_by_finger(browser) {
  await rest(browser);
  const {x, y, molecule} = await top_molecule(browser);
  await browser.touch('touchStart', [[x, y]]);
  for (let i = 1; i <= 8; ++i) await browser.touch('touchMove', [[x - 6 * i, y - 2 * i]]);
  await browser.until('lab.hand', 10);
  must(await browser.eval(`lab.hand.molecule === ${molecule} % lab.shown.molecules`), 'another molecule was gripped');
  await browser.touch('touchEnd', []);
  await browser.until('!lab.hand', 10);
}

async function work_controls(browser) {
  // A test that is stopped while the page waits for its next step.
  await browser.eval('document.getElementById("test").click()');
  await browser.until('lab.testing === "runs"', 20);
  await browser.eval('lab.worker.postMessage({kind: "stop_test"}), 0');
  await sleep(300);
  await browser.eval('document.getElementById("test").click()');
  await rest(browser);
  await browser.eval('document.querySelector("input[value=pin]").click()');
  const {x, y} = await top_molecule(browser);
  await browser.mouse('mousePressed', x, y);
  await browser.mouse('mouseReleased', x, y, 0);
  must(await browser.eval('lab.pins.size') === 1, 'no molecule was pinned');
  await browser.eval('document.getElementById("unpin").click()');
  await browser.eval('document.querySelector("input[value=push]").click()');
  await browser.mouse('mousePressed', x, y);
  await browser.until('lab.answer[0].push && Math.hypot(...lab.answer[0].push) > 0', 20);
  await browser.mouse('mouseReleased', x, y, 0);
  await browser.eval('document.getElementById("play").click()');
  await sleep(200);
  const before = await browser.eval('lab.answer[0].time');
  await sleep(200);
  must(await browser.eval('lab.answer[0].time') === before, 'time goes on while paused');
  await browser.eval('document.getElementById("step").click()');
  await browser.until(`lab.answer[0].time > ${before}`, 20);
  await browser.eval('document.getElementById("play").click()');
  await browser.eval('document.getElementById("canvas").focus()');
  for (const key of ['n', 'w', 'w']) await browser.send('Input.dispatchKeyEvent', {type: 'keyDown', key, text: key});
  await browser.until('lab.hand && lab.answer[0].force && Math.hypot(...lab.answer[0].force) > 0', 20);
  await browser.eval('document.getElementById("reset").click()');
  await browser.until('lab.answer[0].time < 0.2 && !lab.hand', 20);
  await browser.eval('document.getElementById("gravity").value = 9.81, document.getElementById("gravity").dispatchEvent(new Event("input"))');
  await sleep(700);
  must((await browser.eval('location.hash')).includes('gravity=9.81'), 'the address does not carry the settings');
}

/** The picture of the body as numbers 0 … 255, red, green, blue and opacity of 200 x 160 pixels, and how much of it is covered. */
async function picture_of(browser) {
  const numbers = await browser.eval(`(() => {
    const {viewer} = lab, paper = Object.assign(document.createElement('canvas'), {width: 200, height: 160}).getContext('2d');
    viewer.sharpen(viewer.finest);
    viewer.draw();
    paper.drawImage(viewer.canvas, 0, 0, 200, 160);
    return Array.from(paper.getImageData(0, 0, 200, 160).data);
  })()`);
  return [numbers, numbers.filter((v, i) => i % 4 === 3 && v > 127).length / (200 * 160)];
}

const actions = {
  async drag(browser) {
    await browser.open(url, 1400, 1000);
    await drag_by_mouse(browser);
    await drag_by_finger(browser);
    await work_controls(browser);
  },

  async rest(browser) {
    await browser.open(url, 1400, 1000);
    await browser.until('lab.at_rest', 60);
    await browser.eval(`(() => {
      const {viewer} = lab, draw = viewer.draw;
      globalThis.counted = 0;
      viewer.draw = function () { ++counted; draw.call(this); };
    })()`);
    await sleep(500);  // once more, with all pixels
    const before = await browser.eval('counted'), time = await browser.eval('lab.answer[0].time');
    await browser.until(`lab.answer[0].time > ${time} + 0.5`, 60);
    must(await browser.eval('counted') === before, 'a body at rest is drawn again');
    must(await browser.eval('lab.viewer.sharpness') >= 1, 'a body at rest is drawn with few pixels');
    await browser.eval('lab.hold_at(lab.shown.molecules - 1, lab.shown.rest.slice(-3).map((v, k) => v + (k ? 0 : 0.2 * lab.body.size)))');
    await browser.until(`counted > ${before + 2}`, 20);
    await browser.eval('document.getElementById("reset").click()');
    await browser.until('lab.at_rest', 60);
    await browser.eval('document.getElementById("test").click()');
    await browser.until('document.documentElement.dataset.tested', 120);
    await browser.until('lab.at_rest', 60);
    const off = await browser.eval('Math.max(...lab.viewer.positions.map((v, i) => Math.abs(v - lab.shown.rest[i]))) / lab.body.size');
    must(off < 1e-3, `after the test the body is drawn ${off} of its size off`);
  },

  async painters(browser) {
    for (const parts of [['connections'], ['molecules'], ['surface'], ['connections', 'molecules', 'surface']]) {
      const pictures = [];
      for (const painter of ['graphics', 'processor']) {
        await browser.open(`${url}#painter=${painter}`, 1400, 1000);
        await browser.until('lab.at_rest', 60);
        await browser.eval(`for (const name of ['connections', 'molecules', 'surface']) document.getElementById(name).checked = ${JSON.stringify(parts)}.includes(name); lab.look()`);
        pictures.push((await picture_of(browser))[0]);
      }
      // Edges fall within a pixel of each other; elsewhere tints and shades are nearly the same.
      let covered = 0, apart = 0, differences = 0;
      const [a, b] = pictures;
      for (let i = 0; i < a.length; i += 4) {
        covered += a[i + 3] > 127;
        apart += Math.abs(a[i + 3] - b[i + 3]) > 127;
        if (a[i + 3] > 250 && b[i + 3] > 250) differences += (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2])) / 3;
      }
      console.log(`${parts}: ${covered} pixels, ${apart} of them covered by one painter alone, colours ${(differences / covered).toFixed(1)} of 255 apart`);
      must(covered > 1000, `${parts}: ${covered} pixels are covered`);
      must(apart < 0.03 * covered, `${parts}: ${apart} of ${covered} pixels are covered by one painter alone`);
      must(differences < 12 * covered, `${parts}: colours are ${differences / covered} of 255 apart`);
    }
  },

  async settings(browser) {
    await browser.open(url, 1400, 1000);
    const shown = () => browser.eval('["alpha", "phi", "psi"].map(name => document.getElementById(name + "-out").textContent).join()');
    const first = await shown();
    must(!/—|NaN/.test(first), `the page begins with the damping ${first}`);
    await browser.eval('document.getElementById("scene-material").click()');
    await browser.until('!lab.rebuild', 20);
    must(await shown() === first, `the page begins with the damping ${first}, and the scene has ${await shown()}`);
    await sleep(400);
    const address = await browser.eval('location.hash');
    must(address.includes('stepper=') && !address.includes('NaN'), `the address is ${address}`);
    const wrong = ['alpha=-1', 'phi=much', 'psi=-2', 'E=1e+30', 's1=nosuch', 'stepper=none', 'colour=pink'];
    const says_all = async () => {
      const said = await text(browser, 'problem');
      for (const one of wrong) must(said.includes(one), `of ${one} in its address the page says: ${said}`);
      must(await shown() === first, `an address without damping that can be leaves ${await shown()}`);
    };
    await browser.open(`${url}#${wrong.join('&')}`, 1400, 1000);
    await says_all();
    await browser.open(url, 1400, 1000);
    await browser.eval(`location.hash = '#${wrong.join('&')}'`);
    await browser.until('document.getElementById("problem").textContent && !lab.rebuild', 20);
    await sleep(300);
    await says_all();
  },

  async refused_stepper(browser) {
    await browser.open(url, 1400, 1000);
    const before = await browser.eval('document.getElementById("stepper").value');
    await browser.eval('(() => { const s = document.getElementById("stepper"); s.value = "xpbd"; s.dispatchEvent(new Event("change")); })()');
    await browser.until('document.getElementById("problem").textContent.includes("xpbd") && !lab.rebuild', 20);
    await browser.until(`document.getElementById("stepper").value === '${before}'`, 20);
    must(await browser.eval('document.getElementById("phi").hidden && document.getElementById("psi").hidden'), 'cells of second order have a viscosity');
  },

  async words(browser) {
    await browser.open(url, 1400, 1000);
    await browser.eval('document.getElementById("test").click()');
    await browser.until('document.documentElement.dataset.tested', 120);
    const said = await browser.eval('document.body.innerText + document.getElementById("said").textContent'), end = more.indexOf('--');
    more.forEach((one, i) => {
      if (i !== end) must(said.includes(one) === (end < 0 || i < end), `of "${one}" the page says: ${said.slice(0, 3000)}`);
    });
  },

  async strategies(browser) {
    await browser.open(url, 1400, 1000);
    for (let i = 0; i < more.length; i += 3) {
      const [name, modulus, error] = [more[i], +more[i + 1], more[i + 2]];
      await browser.eval(`(() => { const s = document.getElementById('strategy-1'); s.value = '${name}'; s.dispatchEvent(new Event('change')); })()`);
      must(await browser.eval('document.getElementById("strategy-1").value') === name, `the page has no strategy ${name}`);
      await browser.until(`lab.settled?.[0] === '${name}'`, 60);
      await browser.eval('document.getElementById("test").click()');
      await browser.until('!document.documentElement.dataset.tested', 10);
      await browser.until('document.documentElement.dataset.tested', 120);
      const read = +(await browser.eval('document.querySelector("#results tr").dataset.modulus'));
      console.log(`${name}: E = ${read} Pa in the page, ${modulus} Pa by the command, ${read / modulus - 1} apart`);
      must(Math.abs(read / modulus - 1) < 1e-3, `${name}: the page says E = ${read} Pa, the command ${modulus} Pa`);
      const off = await browser.eval('lab.results()[0].error');
      must(error === 'none' ? !Number.isFinite(off) : Math.abs(off - error) < 1e-3, `${name}: the page says an error of ${off}, the command ${error}`);
    }
    await browser.eval('(() => { const s = document.getElementById("strategy-2"); s.value = s.options[1].value; s.dispatchEvent(new Event("change")); })()');
    await browser.until('lab.answer?.length === 2 && lab.viewer.positions.length === 6 * lab.shown.molecules', 60);
  },

  async wild(browser) {
    const [seconds, seed] = [+more[0], +(more[1] ?? 1)];
    const random_from = seed => () => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32;
    const random = random_from(seed);
    await browser.open(url, 1400, 1000);
    // The controls are worked by the page itself: each command of this script leaves there 0.3 kB of the browser's own record.
    await browser.eval(`globalThis.random = (${random_from})(${seed + 1}), globalThis.worked = 0;
    globalThis.work_one = () => {
      const controls = [...document.querySelectorAll('button:not([id$=csv]):not(#png):not(#link), select, input')].filter(one => one.getClientRects().length);
      const one = controls[Math.floor(random() * controls.length)], at = random();
      ++worked;
      if (one.type === 'range') { one.value = +one.min + at * (one.max - one.min); one.dispatchEvent(new Event('input')); }
      else if (one.type === 'number') one.value = Math.floor(at * 2000) - 100;
      else if (one.tagName === 'SELECT') { one.selectedIndex = Math.floor(at * one.options.length); one.dispatchEvent(new Event('change')); }
      else one.click();
    }, 0`);
    const begin_work = () => browser.eval('globalThis.working = setInterval(work_one, 80), 0');
    // What is left after collection [MB], each time with one body that begins again: bodies and curves may take their memory.
    const memory = async () => {
      await browser.eval('lab.compare_with(""), document.getElementById("reset").click()');
      // A step of the tension test to a large strain may take the core long: then the next time counts.
      for (const end = Date.now() + 10e3; Date.now() < end; await sleep(200))
        if (await browser.eval('!lab.rebuild && !lab.testing && lab.answer?.length === 1'))
          return heap.push(await browser.eval('gc(), gc(), performance.memory.usedJSHeapSize / 1e6'));
    };
    const begin = Date.now(), heap = [];
    let drags = 0, next = begin + 10e3;
    await begin_work();
    for (; Date.now() < begin + 1000 * seconds; ++drags) {
      const x = 40 + 780 * random(), y = 180 + 600 * random();
      await browser.mouse('mousePressed', x, y);
      for (let i = 0; i < 5; ++i) await browser.mouse('mouseMoved', x + 300 * (random() - 0.5), y + 300 * (random() - 0.5));
      await browser.mouse('mouseReleased', x, y, 0);
      await sleep(60);
      if (Date.now() < next) continue;
      await browser.eval('clearInterval(working)');
      await sound(browser);
      await memory();
      await begin_work();
      next = Date.now() + 10e3;
    }
    const count = drags + await browser.eval('worked');
    must(heap.length >= seconds / 60, `the memory was read ${heap.length} times alone`);
    const median = values => values.sort((a, b) => a - b)[values.length >> 1], third = Math.ceil(heap.length / 3);
    const said = heap.map(size => size.toFixed(1)).join(' '), early = median(heap.slice(0, third)), late = median(heap.slice(-third));
    console.log(`${count} actions in ${seconds} s; heap after collection [MB] ${said}: ${early.toFixed(2)} in the first third, ${late.toFixed(2)} in the last`);
    must(late < early + 1, 'the memory grows');
  },

  async frames(browser) {
    const [seconds, strategy, painter] = [+more[0], more[1], more[2]];
    await browser.open(url + (painter ? '#painter=' + painter : ''), 1400, 1000);
    if (strategy) {
      await browser.eval(`(() => { const s = document.getElementById('strategy-1'); s.value = '${strategy}'; s.dispatchEvent(new Event('change')); })()`);
      await browser.until(`lab.settled?.[0] === '${strategy}'`, 60);
    }
    await browser.eval(`(() => {
      const {viewer} = lab, draw = viewer.draw;
      viewer.draw = function () { ++counted; draw.call(this); };
      globalThis.counted = 0;
      lab.hold_at(lab.shown.molecules - 1, [0, 1, 2].map(k => lab.shown.rest[3 * lab.shown.molecules - 3 + k] - (k ? 0 : lab.shown.offsets[0]) + 0.2 * lab.body.size));
    })()`);
    await sleep(4000);  // the pace finds how many pixels there is time for
    const count = async () => ({pictures: await browser.eval('counted'), at: Date.now(), time: await browser.eval('lab.answer[0].time')});
    const begin = await count();
    await sleep(1000 * seconds);
    const end = await count(), passed = (end.at - begin.at) / 1000;
    console.log(`${await text(browser, 'about')} ${await browser.eval('lab.strategies[0]')}: ${((end.pictures - begin.pictures) / passed).toFixed(1)} pictures a second, ` +
      `${((end.time - begin.time) / passed).toFixed(2)} of real time, ${await browser.eval('lab.viewer.canvas.width')} x ${await browser.eval('lab.viewer.canvas.height')} pixels, ` +
      `by the ${painter ?? 'painter that the page chose'}, sharpness ${(await browser.eval('lab.pace.sharpness')).toFixed(2)}, core ${(1000 * await browser.eval('lab.pace.core')).toFixed(1)} ms a picture`);
    must(end.pictures > begin.pictures && end.time > begin.time, 'nothing moves');
  },

  async access(browser) {
    for (const [width, dark] of [[1400, false], [1400, true], [390, false], [390, true]]) {
      await browser.open(url, width, width > 600 ? 1000 : 844, dark);
      await browser.until('lab.answer', 30);
      const faults = await browser.eval(`(${check_access})()`);
      must(faults.length === 0, `${width} px, ${dark ? 'dark' : 'light'}: ${faults.join('; ')}`);
      await browser.send('Accessibility.enable');  // not before: its record of what has changed grows while nobody reads it
      const {nodes} = await browser.send('Accessibility.getFullAXTree');
      const nameless = nodes.filter(node => ['button', 'checkbox', 'radio', 'slider', 'combobox', 'spinbutton', 'img', 'figure', 'application', 'region']
        .includes(node.role?.value) && !node.ignored && !node.name?.value && node.role.value !== 'figure');
      must(nameless.length === 0, `without a name: ${nameless.map(node => node.role.value)}`);
    }
  },

  async axe(browser) {
    const rules = fs.readFileSync(more[0], 'utf8');
    for (const [width, dark] of [[1400, false], [1400, true], [390, false], [390, true]]) {
      await browser.open(url, width, width > 600 ? 1000 : 844, dark);
      await browser.until('lab.answer', 30);
      await browser.eval(rules + ';0');
      const {violations, passes} = JSON.parse(await browser.eval('axe.run().then(found => JSON.stringify({violations: found.violations, passes: found.passes.length}))'));
      console.log(`${width} px, ${dark ? 'dark' : 'light'}: ${violations.length} violations, ${passes} rules hold`);
      must(violations.length === 0, violations.map(one => `${one.id}: ${one.help}: ${one.nodes.map(node => node.target).join(' ')}`).join('; '));
    }
  },

  async refused(browser) {
    await browser.open(url, 1400, 1000);  // this browser was started without 3D
    await browser.until('lab.answer', 30);
    must(await browser.eval('lab.viewer.painter instanceof ProcessorPainter'), 'without WebGL it is not the processor that draws');
    const [, drawn] = await picture_of(browser);
    must(drawn > 0.05, `without WebGL the body covers ${drawn} of its picture`);
    await browser.eval('document.getElementById("test").click()');
    await browser.until('document.documentElement.dataset.tested', 120);
    must(+(await browser.eval('document.querySelector("#results tr").dataset.modulus')) > 0, 'no E without WebGL');
    browser.said = [];
    await browser.send('Page.addScriptToEvaluateOnNewDocument', {source: 'delete globalThis.WebAssembly; document.addEventListener("DOMContentLoaded", () => document.documentElement.dataset.ready = "yes")'});
    await browser.open(url, 1400, 1000);
    must((await text(browser, 'problem')).includes('no WebAssembly'), `without WebAssembly the page says: ${await text(browser, 'problem')}`);
    return 'no page';
  },

  async pictures(browser) {
    for (const [width, dark] of [[1400, false], [1400, true], [390, false], [390, true]]) {
      await browser.open(url, width, width > 600 ? 1000 : 844, dark);
      await sleep(1500);
      await browser.picture(path.join(more[0], `lab-${width}-${dark ? 'dark' : 'light'}.png`), true);
    }
  },
};

/** Runs in the page: what a reader without eyes, or with weak ones, would miss. */
function check_access() {
  const faults = [], seen = one => one.getClientRects().length > 0 && !one.closest('.unseen');
  const name_of = one => one.id ? '#' + one.id : one.className || one.tagName;
  const luminance = rgb => rgb.slice(0, 3).map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const numbers = colour => colour.match(/[\d.]+/g).map(Number);
  const ground = one => {
    for (; one; one = one.parentElement) {
      const colour = numbers(getComputedStyle(one).backgroundColor);
      if (colour[3] !== 0) return colour;
    }
    return [255, 255, 255];
  };
  for (const one of document.querySelectorAll('p, label, button, select, output, th, td, h1, h2, span, text, input[type=number]')) {
    if (!seen(one) || ![...one.childNodes].some(node => node.nodeType === 3 && node.textContent.trim())) continue;
    const style = getComputedStyle(one), ink = numbers(one.tagName === 'text' ? style.fill : style.color);
    const [a, b] = [luminance(ink), luminance(ground(one))].sort((x, y) => y - x), ratio = (a + 0.05) / (b + 0.05);
    if (ratio < 4.5) faults.push(`${name_of(one)} "${one.textContent.trim().slice(0, 20)}": contrast ${ratio.toFixed(2)}`);
  }
  for (const one of document.querySelectorAll('input, select')) if (seen(one) && !one.labels.length && !one.getAttribute('aria-label')) faults.push(`${name_of(one)} has no label`);
  const ids = [...document.querySelectorAll('[id]')].map(one => one.id);
  for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) faults.push(`two parts are called ${id}`);
  for (const one of document.querySelectorAll('[aria-labelledby], [aria-describedby]'))
    for (const name of ['aria-labelledby', 'aria-describedby'])
      if (one.getAttribute(name) && !document.getElementById(one.getAttribute(name))) faults.push(`${name} of ${name_of(one)} names nothing`);
  if (document.documentElement.scrollWidth > innerWidth) faults.push(`the page is ${document.documentElement.scrollWidth} px wide in a window of ${innerWidth}`);
  for (const one of document.querySelectorAll('button, select, .tool span'))
    if (seen(one) && one.getBoundingClientRect().height < 24) faults.push(`${name_of(one)} is ${one.getBoundingClientRect().height} px high`);
  return faults;
}

(async () => {
  const browser = new Browser(chromium, what === 'refused' ? ['--disable-3d-apis'] : ['--enable-precise-memory-info', '--js-flags=--expose-gc']);
  try {
    if (!(await actions[what](browser))) await sound(browser);
  } finally {
    await browser.close();
  }
})().then(() => process.exit(0), problem => {
  console.error(problem);
  process.exit(1);
});
