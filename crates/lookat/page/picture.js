// The pictures that the program sends.

/** What the numbers of a picture stand for, in the order of the program. */
const CONTENTS = ['growing', 'finished', 'reference', 'layer', 'errors'];

/**
 * @typedef {object} Picture
 * @property {number} width
 * @property {number} height
 * @property {number} generation counts the views
 * @property {number} number of the request that it follows, or of the layer
 * @property {number} done samples of all pixels
 * @property {number} total
 * @property {number} seconds
 * @property {string} content
 * @property {boolean} isFinal whether it is the picture that `render` makes
 * @property {boolean} isSmall whether it is one of a moving camera
 * @property {Float32Array} pixels three values each, of colors red, green and blue, row by row
 */

/**
 * The picture of a message.
 * @param {ArrayBuffer} message
 * @returns {Picture}
 */
export function decode(message) {
  const [width, height, generation, number, done, total, seconds, kind] = new Float64Array(message, 0, 8);
  const [content, pixels] = [CONTENTS[kind], new Float32Array(message, 64)];
  const [isFinal, isSmall] = [content === 'finished', content === 'growing' && done === total];
  return { width, height, generation, number, done, total, seconds, content, isFinal, isSmall, pixels };
}

/**
 * The values of the pixel at a place, in fractions of the picture.
 * @param {Picture} picture
 * @param {number[]} place
 * @returns {number[]}
 */
export function valuesAt(picture, [x, y]) {
  const index = (share, size) => Math.min(Math.max(Math.floor(share * size), 0), size - 1);
  const [column, row] = [index(x, picture.width), index(y, picture.height)];
  const at = 3 * (row * picture.width + column);
  return Array.from(picture.pixels.subarray(at, at + 3));
}

/**
 * One picture minus another one of its size.
 * @param {Picture} picture
 * @param {Picture} reference
 * @returns {Picture}
 */
export function minus(picture, reference) {
  return { ...picture, pixels: picture.pixels.map((value, at) => value - reference.pixels[at]) };
}

/** @type {(a: Picture?, b: Picture?) => boolean} */
export const isSameSize = (a, b) => a !== null && b !== null && a.width === b.width && a.height === b.height;
