// Put at the end of a page by page_test.cpp: does what a visitor does and prints the result on the console: DRIVEN and a line of JSON.
'use strict';

const seconds = time => new Promise(done => setTimeout(done, 1000 * time));

/** Shares of the canvas: how far the body reaches in width and height, and the least distance to an edge. */
function extent_of(viewer) {
  viewer.draw();
  const {width, height} = viewer.canvas, paper = Object.assign(document.createElement('canvas'), {width, height}).getContext('2d');
  paper.drawImage(viewer.canvas, 0, 0);
  const pixels = paper.getImageData(0, 0, width, height).data;
  let [left, right, low, high] = [width, -1, height, -1];
  for (let i = 0; i < width * height; ++i) {
    if (!pixels[4 * i + 3]) continue;
    [left, right] = [Math.min(left, i % width), Math.max(right, i % width)];
    [low, high] = [Math.min(low, Math.floor(i / width)), Math.max(high, Math.floor(i / width))];
  }
  return {width: (right - left) / width, height: (high - low) / height,
    edge: Math.min(left / width, 1 - right / width, low / height, 1 - high / height)};
}

async function at_width(stage, width) {
  stage.canvas.parentElement.style.width = width;
  await seconds(0.2);
  return extent_of(stage.viewer);
}

/** The camera's direction [rad] and distance, over the body's size. */
function camera_of({viewer}) {
  const {x, y, z} = viewer.camera.position.clone().sub(viewer.controls.target);
  return {yaw: Math.atan2(y, x), distance: Math.hypot(x, y, z) / viewer.reach, side: viewer.controls.target.distanceTo(viewer.middle) / viewer.reach};
}

function mouse(kind, target, x, y, more = {}) {
  target.dispatchEvent(new MouseEvent(kind, {clientX: x, clientY: y, bubbles: true, cancelable: true, ...more}));
}

async function hand(stage) {
  const {canvas} = stage, out = {};
  stage.viewer.reset();
  out.start = camera_of(stage);
  mouse('mousedown', canvas, 100, 100);
  mouse('mousemove', document, 160, 100);
  mouse('mouseup', document, 160, 100);
  out.dragged = camera_of(stage);
  mouse('mousedown', canvas, 100, 100, {shiftKey: true});
  mouse('mousemove', document, 160, 100, {shiftKey: true});
  mouse('mouseup', document, 160, 100);
  out.shifted = camera_of(stage);
  stage.viewer.reset();
  const wheel = () => canvas.dispatchEvent(new WheelEvent('wheel', {deltaY: -100, bubbles: true, cancelable: true}));
  canvas.blur();
  out.scrolled_past = wheel() && camera_of(stage).distance;  // not cancelled: the page scrolls
  canvas.focus();
  wheel();
  out.zoomed = camera_of(stage).distance;
  canvas.dispatchEvent(new KeyboardEvent('keydown', {key: '0', bubbles: true}));
  out.reset = camera_of(stage);
  canvas.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight', bubbles: true, cancelable: true}));
  out.key = camera_of(stage);
  stage.viewer.reset();
  return out;
}

async function playing(stage) {
  const play = stage.part('play'), step = stage.part('step'), seen = [];
  const note = () => seen.push([play.getAttribute('aria-label'), +(step.value / step.max).toFixed(2)]);
  note();
  play.click();
  await seconds(0.8);
  note();
  play.click();
  await seconds(0.5);
  note();
  const paused = step.value;
  play.click();
  await seconds(3);
  note();
  return {seen, paused: +paused / step.max};
}

/** Of molecules in front, the one that is found where it is seen. */
function picks(stage) {
  const {viewer} = stage, {camera, canvas} = viewer, eye = camera.position;
  viewer.draw();
  const distance = molecule => eye.distanceTo(new THREE.Vector3(...stage.viewer.positions.slice(3 * molecule, 3 * molecule + 3)));
  const front = [...stage.body.radius.keys()].sort((a, b) => distance(a) - distance(b)).slice(0, 5);
  return front.map(molecule => {
    const seen = new THREE.Vector3(...viewer.positions.slice(3 * molecule, 3 * molecule + 3)).project(camera);
    return viewer.molecule_at((seen.x + 1) / 2 * canvas.clientWidth, (1 - seen.y) / 2 * canvas.clientHeight) === molecule;
  });
}

/** A triangle in space, rotated and stretched by known factors in its plane. */
function strain_of(first, second) {
  const turn = new THREE.Matrix4().makeRotationFromEuler(new THREE.Euler(0.3, -0.7, 1.1)), back = new THREE.Matrix4().makeRotationFromEuler(new THREE.Euler(1, 2, 3));
  const corners = [[0.2, 0.1], [1.3, 0.4], [0.5, 1.2]];
  const place = (x, y, matrix) => new THREE.Vector3(x, y, 0).applyMatrix4(matrix).toArray();
  const rest = corners.flatMap(([x, y]) => place(x, y, turn)), after = corners.flatMap(([x, y]) => place(first * x, second * y, back));
  return face_strains_of({rest, surface: new Uint32Array([0, 1, 2])}, after.map((v, i) => v - rest[i]))[0];
}

function colours(stage) {
  const kind = stage.part('colour');
  return [...kind.options].map(option => {
    kind.value = option.value;
    kind.dispatchEvent(new Event('change'));
    return [stage.part('title').textContent, stage.part('low').value, stage.part('high').value, stage.legend().map];
  });
}

/** Ends of the colours as they are, and with the state at rest as the last one: those of all states. */
function ranges_of_states(stage) {
  const ends = () => {
    stage.ranges.clear();
    return colours(stage);
  };
  const loaded = ends();
  stage.run.frames.push(stage.run.frames[0]);
  const unloaded = ends();
  stage.run.frames.pop();
  stage.ranges.clear();
  return {loaded, unloaded};
}

/** How the same body opens with other states, of other displacements: the scale of its displacements, the title of its colours, and the word next to a cut. */
function opened(stage, times, change, frequencies) {
  const section = stage.section.cloneNode(true);
  stage.section.after(section);
  for (const name of ['strategy', 'colour', 'scale']) section.querySelector(`[data-part="${name}"]`).replaceChildren();
  const frames = stage.run.frames.map(frame => ({...frame, displacements: frame.displacements.map(u => times * u), ...change}));
  const one = new Stage(section, stage.body, new Map([['standard', {frames, frequencies}]]));
  for (const [name, on] of [['surface', true], ['connections', false], ['molecules', false]]) one.part(name).checked = on;
  one.look();
  one.part('cut').value = 'y';
  one.cut();
  const found = {scale: one.part('scale').selectedOptions[0].text, title: one.legend().title, inside: one.part('inside').hidden ? '' : one.part('inside').textContent};
  one.release();
  section.remove();
  return found;
}

/** Back and forth between scenes, more often than a browser allows pictures at a time. */
async function visits(count) {
  const most = [];
  for (let visit = 0; visit < count; ++visit) {
    const wanted = `scene-${1 - visit % 2}`;
    location.replace('#' + wanted);
    for (let wait = 0; wait < 100 && !document.getElementById(wanted).stage; ++wait) await seconds(0.02);
    most.push([...document.querySelectorAll('.scene')].filter(section => section.stage).length);
  }
  return [Math.min(...most), Math.max(...most)];
}

(async () => {
  while (document.documentElement.dataset.ready !== 'yes') await seconds(0.05);
  const stage = document.querySelector('.scene').stage, out = {};
  if (stage) {
    out.wide = await at_width(stage, '1140px');
    out.narrow = await at_width(stage, '342px');
    out.hand = await hand(stage);
    out.playing = await playing(stage);
    out.picks = picks(stage);
    out.strains = [[1.2, 0.9], [0.7, 1.1], [1, 1], [1.05, 1.3]].map(([first, second]) => strain_of(first, second));
    out.colours = colours(stage);
    out.ranges = ranges_of_states(stage);
    out.opened = {free: opened(stage, 0.1, {}), touching: opened(stage, 0.1, {pressures: new Float32Array(stage.body.radius.length)}),
      modes: opened(stage, 1, {}, [NaN, 10, 20, 30])};
    out.picture = [stage.picture().width, stage.viewer.canvas.width];
    out.staged = await visits(18);
  }
  console.log('DRIVEN ' + JSON.stringify({...out, errors: document.documentElement.dataset.errors ?? '', view: document.querySelector('.view').textContent}));
})();
