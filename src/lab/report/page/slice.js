// The image that a body was made of, in a plane across an axis, with the outlines of the body there.
'use strict';

/** Where the faces of a body cross the plane across an axis at a place [m]: two points a line, two numbers a point. */
function outline_at(surface, positions, axis, at) {
  const [u, v] = [0, 1, 2].filter(k => k !== axis), lines = [];
  for (let face = 0; face < surface.length; face += 3) {
    const ends = [];
    for (let k = 0; k < 3; ++k) {
      const a = 3 * surface[face + k], b = 3 * surface[face + (k + 1) % 3];
      const before = positions[a + axis] - at, after = positions[b + axis] - at;
      if (before < 0 === after < 0) continue;
      const share = before / (before - after);
      ends.push(...[u, v].map(i => positions[a + i] + share * (positions[b + i] - positions[a + i])));
    }
    if (ends.length === 4) lines.push(ends);
  }
  return lines;
}

/** Draws both into a canvas. image: size, values of voxels, x fastest, and to_voxel, which takes a place [m] to voxels: four
 *  numbers an axis. */
function draw_slice(canvas, image, body, positions, axis, at) {
  const [u, v] = [0, 1, 2].filter(k => k !== axis), paper = canvas.getContext('2d'), {width, height} = canvas;
  const low = [Infinity, Infinity, Infinity], high = low.map(end => -end);
  for (const places of [body.rest, positions])
    places.forEach((place, i) => { low[i % 3] = Math.min(low[i % 3], place); high[i % 3] = Math.max(high[i % 3], place); });
  const metres = 1.1 * Math.max((high[u] - low[u]) / width, (high[v] - low[v]) / height);  // a pixel
  const left = (low[u] + high[u] - metres * width) / 2, top = (low[v] + high[v] + metres * height) / 2;
  const pixels = paper.createImageData(width, height), place = [0, 0, 0];
  place[axis] = at;
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      place[u] = left + metres * (x + 0.5), place[v] = top - metres * (y + 0.5);
      const voxel = [0, 1, 2].map(k => Math.round(image.to_voxel.slice(4 * k, 4 * k + 3).reduce((sum, factor, i) => sum + factor * place[i], image.to_voxel[4 * k + 3])));
      const inside = voxel.every((number, k) => number >= 0 && number < image.size[k]);
      const value = inside ? image.values[voxel[0] + image.size[0] * (voxel[1] + image.size[1] * voxel[2])] : 0;
      pixels.data.set([value, value, value, 255], 4 * (x + width * y));
    }
  paper.putImageData(pixels, 0, 0);
  for (const [places, colour, thickness] of [[body.rest, '#5aa9ff', 1], [positions, '#ff8a3d', 1.5]]) {
    paper.strokeStyle = colour;
    paper.lineWidth = thickness;
    paper.beginPath();
    for (const [a, b, c, d] of outline_at(body.surface, places, axis, at)) {
      paper.moveTo((a - left) / metres, (top - b) / metres);
      paper.lineTo((c - left) / metres, (top - d) / metres);
    }
    paper.stroke();
  }
  canvas.setAttribute('role', 'img');
  canvas.title = `The image at ${'xyz'[axis]} = ${with_prefix(at, 'm')}, with the outline of the body: at rest in blue, with its displacements as shown in orange`;
  canvas.setAttribute('aria-label', canvas.title);
}
