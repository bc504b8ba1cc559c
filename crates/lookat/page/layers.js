// The layers of a picture: how each is painted, and what its numbers are.

import { isFinitePixel, paintColors, paintShares } from './paint.js';
import { AMOUNTS } from './ramp.js';
import { rgba } from './tone.js';

/**
 * @typedef {object} Layer
 * @property {string} name as in `render --layers`
 * @property {string[]} axes the names of its numbers
 * @property {(values: Float32Array, image: ImageData) => number[] | null} paint returns the range of a ramp, if there is one
 */

/** As far as this there is nothing. */
const FAR = 1e10;

/** The color of what is nowhere. */
const NOTHING = rgba(0, 0, 0);

/**
 * The range of one number of all pixels.
 * @param {Float32Array} values
 * @param {number} axis
 */
function rangeOf(values, axis) {
  let [least, most] = [Infinity, -Infinity];
  for (let at = axis; at < values.length; at += 3) {
    if (values[at] < FAR) [least, most] = [Math.min(least, values[at]), Math.max(most, values[at])];
  }
  return least <= most ? [least, most] : [0, 1];
}

/** Near is bright. */
function paintDepth(values, image) {
  const [least, most] = rangeOf(values, 0);
  paintShares(AMOUNTS, (at) => (most - values[at]) / (most - least || 1), image);
  const colors = new Uint32Array(image.data.buffer);
  for (let i = 0; i < colors.length; i++) if (!(values[3 * i] < FAR)) colors[i] = NOTHING;
  return [most, least];
}

/** Paints three shares from 0 to 1 as they are, without a curve. */
function paintAs(share) {
  return (values, image) => {
    const ranges = [0, 1, 2].map((axis) => rangeOf(values, axis));
    const colors = new Uint32Array(image.data.buffer);
    for (let i = 0, at = 0; i < colors.length; i++, at += 3) {
      const level = (axis) => Math.round(255 * Math.min(Math.max(share(values[at + axis], ranges[axis], axis), 0), 1));
      const isNothing = values[at] === 0 && values[at + 1] === 0 && values[at + 2] === 0;
      colors[i] = isNothing || !isFinitePixel(values, at) ? NOTHING : rgba(level(0), level(1), level(2));
    }
    return null;
  };
}

const paintNormal = paintAs((value) => 0.5 + 0.5 * value);
const paintPosition = paintAs((value, [least, most]) => (value - least) / (most - least || 1));
// Repeated pictures repeat their colors.
const paintUv = paintAs((value, _, axis) => (axis === 2 ? 0 : value === 1 ? 1 : value - Math.floor(value)));

/** A color for each number, far from those of its neighbors. */
function paintNumbers(values, image) {
  const colors = new Uint32Array(image.data.buffer);
  for (let i = 0; i < colors.length; i++) {
    const number = values[3 * i];
    // Steps by the golden ratio do not meet again.
    const hue = 6 * (number * 0.618034 % 1);
    const level = (shift) => Math.round(70 + 170 * Math.min(Math.max(Math.abs((hue + shift) % 6 - 3) - 1, 0), 1));
    colors[i] = number > 0 ? rgba(level(0), level(4), level(2)) : NOTHING;
  }
  return null;
}

function paintAlbedo(values, image) {
  paintColors(values, { stops: 0, curve: 'none', channel: 'color' }, image);
  return null;
}

const XYZ = ['X', 'Y', 'Z'];

/** In the order of the program. @type {Layer[]} */
export const LAYERS = [
  { name: 'depth', axes: ['Z'], paint: paintDepth },
  { name: 'position', axes: XYZ, paint: paintPosition },
  { name: 'normal', axes: XYZ, paint: paintNormal },
  { name: 'shading-normal', axes: XYZ, paint: paintNormal },
  { name: 'uv', axes: ['U', 'V'], paint: paintUv },
  { name: 'albedo', axes: ['R', 'G', 'B'], paint: paintAlbedo },
  { name: 'shape', axes: ['number'], paint: paintNumbers },
  { name: 'material', axes: ['number'], paint: paintNumbers },
];
