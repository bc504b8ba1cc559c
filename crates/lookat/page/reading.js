// The numbers of the pixel under the pointer, with all their digits.

import { LAYERS } from './layers.js';
import { isSameSize, valuesAt } from './picture.js';
import { full, part } from './readout.js';

/**
 * @param {ReturnType<import('./display.js').makeDisplay>} display
 * @param {(place: number[]) => number[]} filmPlace
 */
export function makeReading(display, filmPlace) {
  const [reading, frame, mode] = ['pixel', 'frame', 'show'].map((id) => /** @type {any} */ (document.getElementById(id)));
  /** @type {number[]?} */
  let pointer = null;

  /** The parts of the text. */
  function parts(place) {
    const { picture, reference, errors } = display.pictures;
    const layer = display.layer();
    const of = (values) => values.map(full);
    if (layer) {
      const { name, axes } = LAYERS[layer.number];
      return [part(name, of(valuesAt(layer, place).slice(0, axes.length)))];
    }
    const colors = picture ? valuesAt(picture, place) : [];
    const shown = [part('picture', of(colors))];
    if (['reference', 'wipe', 'difference'].includes(mode.value) && reference) {
      const expected = valuesAt(reference, place);
      shown.push(part('reference', of(expected)));
      if (isSameSize(picture, reference)) {
        shown.push(part('difference', of(colors.map((value, c) => Math.fround(value - expected[c])))));
      }
    }
    if (mode.value === 'errors' && errors && picture && errors.generation === picture.generation) {
      const [share, error, replicates] = valuesAt(errors, place);
      shown.push(part('error', [`${(100 * share).toPrecision(3)} %`]), part('standard error', [full(error)]));
      shown.push(part('replicates', [String(replicates)]));
    }
    return shown;
  }

  function read() {
    for (const element of [frame, reading]) element.toggleAttribute('data-pointed', Boolean(pointer));
    reading.toggleAttribute('data-long', ['reference', 'wipe', 'difference', 'errors'].includes(mode.value));
    if (!pointer) {
      reading.textContent = 'Point at the picture to read its numbers.';
      return;
    }
    const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById('picture'));
    const corner = (share, size) => `${100 * Math.floor(share * size) / size}%`;
    frame.style.setProperty('--x', corner(pointer[0], canvas.width));
    frame.style.setProperty('--y', corner(pointer[1], canvas.height));
    const at = filmPlace(pointer).map(Math.floor).join(', ');
    reading.replaceChildren(part('x, y', [at]), ...parts(pointer));
  }

  mode.addEventListener('change', read);
  return {
    read,
    /** @param {number[] | null} place in fractions of the picture */
    point(place) {
      pointer = place;
      read();
    },
    pointer: () => pointer,
  };
}
