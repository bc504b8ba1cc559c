// False colors, by the Scientific color maps 8.0 of Fabio Crameri, https://doi.org/10.5281/zenodo.1243862.
// Copyright (c) 2023 Fabio Crameri, MIT License. Equal steps look equal, also with color vision deficiencies.

import { rgba } from './tone.js';

/** The color of pixels that are infinite or not a number. */
export const NOT_FINITE = rgba(255, 0, 255);

/**
 * @typedef {object} Ramp
 * @property {Uint32Array} colors 1025 of them, from the least value to the most
 * @property {string} gradient the same for a style
 */

/**
 * @param {number[][]} table
 * @returns {Ramp}
 */
function makeRamp(table) {
  const last = table.length - 1;
  const colors = Uint32Array.from({ length: 1025 }, (_, i) => {
    const place = i / 1024 * last;
    const before = Math.min(Math.floor(place), last - 1);
    const mix = (a, c) => Math.round(a + (table[before + 1][c] - a) * (place - before));
    const [red, green, blue] = table[before].map(mix);
    return rgba(red, green, blue);
  });
  return { colors, gradient: `linear-gradient(90deg, ${table.map((color) => `rgb(${color})`)})` };
}

/** Signed values: `vik`, the same points as those of `compare --picture`. */
export const SIGNED = makeRamp([
  [2, 58, 122], [3, 68, 129], [4, 78, 135], [8, 88, 142], [17, 100, 150], [31, 112, 158], [47, 124, 166],
  [66, 138, 175], [86, 151, 184], [106, 164, 193], [126, 176, 201], [146, 189, 210], [167, 201, 218],
  [187, 213, 226], [207, 224, 232], [224, 230, 233], [236, 229, 225], [238, 221, 211], [235, 209, 194],
  [230, 196, 177], [225, 184, 160], [220, 171, 143], [215, 159, 127], [210, 147, 111], [205, 136, 96],
  [200, 125, 81], [195, 114, 67], [190, 102, 52], [183, 90, 38], [174, 75, 24], [161, 60, 12], [147, 46, 6],
  [134, 35, 6],
]);

/** Values without a sign: `batlow`. */
export const AMOUNTS = makeRamp([
  [1, 25, 89], [8, 37, 91], [13, 49, 93], [15, 59, 95], [17, 67, 96], [19, 75, 97], [23, 82, 98], [27, 89, 98],
  [34, 96, 97], [43, 101, 94], [53, 106, 89], [65, 111, 83], [77, 115, 77], [90, 119, 69], [103, 123, 62],
  [116, 126, 56], [130, 130, 49], [143, 134, 45], [159, 137, 43], [175, 141, 46], [190, 144, 53], [205, 146, 63],
  [219, 149, 75], [231, 152, 90], [241, 157, 107], [248, 162, 126], [252, 168, 144], [253, 174, 162],
  [253, 180, 180], [253, 186, 196], [252, 191, 214], [251, 198, 232], [250, 204, 250],
]);
