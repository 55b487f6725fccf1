// What stands in front of a body in 3D: the directions of the axes and a length to compare with, drawn in two dimensions.
'use strict';

const axis_colours = ['#e5484d', '#2f9e44', '#3b82f6'];

/** Three arrows from a corner at (x, y) [px]. directions: of each axis its right, upward and towards-the-eye share. */
function draw_axes(paper, directions, x, y, length, ink) {
  paper.lineWidth = 2;
  paper.font = '600 12px system-ui, sans-serif';
  paper.textAlign = 'center';
  paper.textBaseline = 'middle';
  const far_first = [0, 1, 2].sort((a, b) => directions[a][2] - directions[b][2]);
  for (const axis of far_first) {
    const [right, up] = directions[axis], end = [x + length * right, y - length * up];
    paper.strokeStyle = paper.fillStyle = axis_colours[axis];
    paper.beginPath();
    paper.moveTo(x, y);
    paper.lineTo(...end);
    paper.stroke();
    paper.fillText('xyz'[axis], end[0] + 9 * right, end[1] - 9 * up);
  }
  paper.fillStyle = ink;
  paper.beginPath();
  paper.arc(x, y, 2.5, 0, 7);
  paper.fill();
}

/** A bar of a round length that ends at (right, y) [px] and is at most so long; metres [m] a pixel. None
 *  where a picture has no height. */
function draw_scale_bar(paper, metres, right, y, most, ink) {
  if (!(metres > 0 && metres < Infinity)) return;
  const length = round_down(most * metres), pixels = length / metres;
  paper.strokeStyle = paper.fillStyle = ink;
  paper.lineWidth = 1.5;
  paper.beginPath();
  paper.moveTo(right - pixels, y - 5);
  paper.lineTo(right - pixels, y);
  paper.lineTo(right, y);
  paper.lineTo(right, y - 5);
  paper.stroke();
  paper.font = '12px system-ui, sans-serif';
  paper.textAlign = 'right';
  paper.textBaseline = 'bottom';
  paper.fillText(with_prefix(length, 'm', 0), right, y - 7);
}

/** The legend of a saved picture, its lower left corner at (x, y) [px]. legend: {title, map, low, high}. */
function draw_legend(paper, legend, x, y, width, ink) {
  const colours = legend_colours(legend.map), step = width / colours.length;
  colours.forEach((colour, i) => {
    paper.fillStyle = colour;
    paper.fillRect(x + i * step, y - 10, step + 1, 10);
  });
  paper.fillStyle = ink;
  paper.font = '12px system-ui, sans-serif';
  paper.textBaseline = 'bottom';
  for (const [align, at, height, text] of [['left', x, 14, legend.low], ['right', x + width, 14, legend.high], ['left', x, 30, legend.title]]) {
    paper.textAlign = align;
    paper.fillText(text, at, y - height);
  }
}

/** Marks what is read: a ring around one point, an outline of several [px]. */
function draw_picked(paper, points) {
  for (const [style, width] of [['#fff', 5], ['#111827', 2.5]]) {
    paper.strokeStyle = style;
    paper.lineWidth = width;
    paper.beginPath();
    if (points.length === 1) paper.arc(...points[0], 9, 0, 7);
    else points.forEach((point, i) => i ? paper.lineTo(...point) : paper.moveTo(...point));
    if (points.length > 1) paper.closePath();
    paper.stroke();
  }
}
