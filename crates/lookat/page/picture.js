// The picture: linear values, drawn with an exposure and a tone curve.

import { rgba, srgb } from './tone.js';

/** The color of pixels that are infinite or not a number. */
const NOT_FINITE = rgba(255, 0, 255);
/** Larger values count as this one, so that no curve overflows. */
const MOST = 1e6;

/**
 * @typedef {object} Picture
 * @property {number} width
 * @property {number} height
 * @property {number} generation counts the views
 * @property {number} number of the request that it follows
 * @property {number} done samples of all pixels
 * @property {number} total
 * @property {number} seconds
 * @property {boolean} isFinal
 * @property {Float32Array} pixels red, green and blue, row by row
 */

/**
 * The picture of a message.
 * @param {ArrayBuffer} message
 * @returns {Picture}
 */
export function decode(message) {
  const [width, height, generation, number, done, total, seconds, final] = new Float64Array(message, 0, 8);
  const pixels = new Float32Array(message, 64);
  return { width, height, generation, number, done, total, seconds, isFinal: final === 1, pixels };
}

/**
 * The tone curves, as those of `lookat convert --tone`. Each changes a pixel in place.
 * @type {Record<string, ((pixel: Float64Array) => void) | null>}
 */
const CURVES = {
  none: null,
  reinhard(pixel) {
    const luminance = 0.212671 * pixel[0] + 0.71516 * pixel[1] + 0.072169 * pixel[2];
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
 * Draws a picture into a canvas of its size.
 * @param {HTMLCanvasElement} canvas
 * @param {Picture} picture
 * @param {{stops: number, curve: string}} tone
 */
export function draw(canvas, picture, { stops, curve }) {
  const { width, height, pixels } = picture;
  // Setting the size clears the canvas, even to the same size.
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
  const image = context.createImageData(width, height);
  const colors = new Uint32Array(image.data.buffer);
  const [gain, bend, pixel] = [2 ** stops, CURVES[curve], new Float64Array(3)];
  for (let i = 0, at = 0; i < colors.length; i++, at += 3) {
    const [red, green, blue] = [pixels[at] * gain, pixels[at + 1] * gain, pixels[at + 2] * gain];
    // Only of finite numbers are these 0.
    if ((red - red) + (green - green) + (blue - blue) !== 0) {
      colors[i] = NOT_FINITE;
    } else if (bend) {
      pixel[0] = Math.min(Math.max(red, 0), MOST);
      pixel[1] = Math.min(Math.max(green, 0), MOST);
      pixel[2] = Math.min(Math.max(blue, 0), MOST);
      bend(pixel);
      colors[i] = rgba(srgb(pixel[0]), srgb(pixel[1]), srgb(pixel[2]));
    } else {
      colors[i] = rgba(srgb(red), srgb(green), srgb(blue));
    }
  }
  context.putImageData(image, 0, 0);
}

/**
 * The values of the pixel at a place, in fractions of the picture.
 * @param {Picture} picture
 * @param {number} x
 * @param {number} y
 * @returns {number[]}
 */
export function valuesAt(picture, x, y) {
  const index = (share, size) => Math.min(Math.max(Math.floor(share * size), 0), size - 1);
  const [column, row] = [index(x, picture.width), index(y, picture.height)];
  const at = 3 * (row * picture.width + column);
  return Array.from(picture.pixels.subarray(at, at + 3));
}
