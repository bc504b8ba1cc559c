// Pixels of a canvas: linear values with exposure, tone curve and channel, or in false color. `values` are red, green and blue,
// pixel by pixel.

import { NOT_FINITE, SIGNED } from './ramp.js';
import { rgba, srgb } from './tone.js';

/** Larger values count as this one, so that no curve overflows. */
const MOST = 1e6;

/** @typedef {(values: Float32Array | Float64Array, at: number) => number} Pick */

/**
 * The channels that can be seen alone.
 * @type {Record<string, Pick>}
 */
export const CHANNELS = {
  red: (values, at) => values[at],
  green: (values, at) => values[at + 1],
  blue: (values, at) => values[at + 2],
  luminance: (values, at) => 0.212671 * values[at] + 0.71516 * values[at + 1] + 0.072169 * values[at + 2],
};

/**
 * The channel that is the farthest from 0, with its sign.
 * @type {Pick}
 */
export function largest(values, at) {
  let most = values[at];
  if (Math.abs(values[at + 1]) > Math.abs(most)) most = values[at + 1];
  if (Math.abs(values[at + 2]) > Math.abs(most)) most = values[at + 2];
  return most;
}

/**
 * @param {Float32Array} values
 * @param {number} at
 */
export function isFinitePixel(values, at) {
  const [red, green, blue] = [values[at], values[at + 1], values[at + 2]];
  // Only of finite numbers are these 0.
  return (red - red) + (green - green) + (blue - blue) === 0;
}

/**
 * The tone curves, as those of `lookat convert --tone`. Each changes a pixel in place.
 * @type {Record<string, ((pixel: Float64Array) => void) | null>}
 */
const CURVES = {
  none: null,
  reinhard(pixel) {
    const luminance = CHANNELS.luminance(pixel, 0);
    const factor = (1 + luminance / 16) / (1 + luminance);
    for (let c = 0; c < 3; c++) pixel[c] *= factor;
  },
  aces(pixel) {
    for (let c = 0; c < 3; c++) {
      const x = pixel[c];
      pixel[c] = Math.min((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 1);
    }
  },
  neutral(pixel) {
    const [f90, desaturation] = [0.04, 0.15];
    const start = 0.8 - f90;
    const least = Math.min(pixel[0], pixel[1], pixel[2]);
    const offset = least <= 2 * f90 ? least - least * least / (4 * f90) : f90;
    for (let c = 0; c < 3; c++) pixel[c] -= offset;
    const peak = Math.max(pixel[0], pixel[1], pixel[2], 0);
    if (peak <= start) return;
    const newPeak = 1 - (1 - start) ** 2 / (peak + 1 - 2 * start);
    const kept = 1 / (desaturation * (peak - newPeak) + 1);
    for (let c = 0; c < 3; c++) pixel[c] = pixel[c] * newPeak / peak * kept + newPeak * (1 - kept);
  },
};

/**
 * How linear values are shown.
 * @typedef {object} Tone
 * @property {number} stops the exposure
 * @property {string} curve
 * @property {string} channel the only one, or `color`
 */

/**
 * Paints linear values.
 * @param {Float32Array} values
 * @param {Tone} tone
 * @param {ImageData} image
 */
export function paintColors(values, { stops, curve, channel }, image) {
  const colors = new Uint32Array(image.data.buffer);
  const [gain, bend, alone, pixel] = [2 ** stops, CURVES[curve], CHANNELS[channel], new Float64Array(3)];
  for (let i = 0, at = 0; i < colors.length; i++, at += 3) {
    if (!isFinitePixel(values, at)) {
      colors[i] = NOT_FINITE;
      continue;
    }
    if (alone) {
      pixel[0] = pixel[1] = pixel[2] = gain * alone(values, at);
    } else {
      pixel[0] = gain * values[at];
      pixel[1] = gain * values[at + 1];
      pixel[2] = gain * values[at + 2];
    }
    if (bend) {
      for (let c = 0; c < 3; c++) pixel[c] = Math.min(Math.max(pixel[c], 0), MOST);
      bend(pixel);
    }
    colors[i] = rgba(srgb(pixel[0]), srgb(pixel[1]), srgb(pixel[2]));
  }
}

/**
 * Paints a place on a ramp, from 0 to 1, for each pixel.
 * @param {import('./ramp.js').Ramp} ramp
 * @param {(at: number) => number} share of the pixel whose values begin at this place
 * @param {ImageData} image
 */
export function paintShares(ramp, share, image) {
  const colors = new Uint32Array(image.data.buffer);
  for (let i = 0, at = 0; i < colors.length; i++, at += 3) {
    const place = share(at);
    colors[i] = Number.isNaN(place) ? NOT_FINITE : ramp.colors[Math.round(1024 * Math.min(Math.max(place, 0), 1))];
  }
}

/**
 * Paints differences, from -scale to +scale.
 * @param {Float32Array} values
 * @param {Pick} pick
 * @param {number} scale
 * @param {ImageData} image
 */
export function paintDifferences(values, pick, scale, image) {
  paintShares(SIGNED, (at) => (isFinitePixel(values, at) ? 0.5 + 0.5 * pick(values, at) / scale : NaN), image);
}

/**
 * Paints one picture left of a column, and another one right of it.
 * @param {CanvasRenderingContext2D} context
 * @param {ImageData} left
 * @param {ImageData} right
 * @param {number} split
 */
export function paintWipe(context, left, right, split) {
  const { width, height } = right;
  if (split > 0) context.putImageData(left, 0, 0, 0, 0, split, height);
  if (split < width) context.putImageData(right, 0, 0, split, 0, width - split, height);
}
