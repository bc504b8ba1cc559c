// What the canvas shows: the picture, the reference, both, their difference, the error map or a layer.

import { LAYERS } from './layers.js';
import { CHANNELS, isFinitePixel, largest, paintColors, paintDifferences, paintShares, paintWipe } from './paint.js';
import { isSameSize, minus } from './picture.js';
import { AMOUNTS, SIGNED } from './ramp.js';
import { digits } from './readout.js';

/** @typedef {import('./picture.js').Picture} Picture */
/** @typedef {{name: string, gradient: string, ends: string[], isScaled?: boolean}} Legend */

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/** False color shows luminances from 2^-8 to 2^2, and so many stops less as the exposure is more. */
const [DARKEST, BRIGHTEST] = [-8, 2];
/** The powers of ten of the relative errors at the ends of their ramp. */
const [LEAST_ERROR, MOST_ERROR] = [-3, 0];

/** A number for the end of a ramp. */
const short = (value) => (value === 0 ? '0' : digits(value).replace('-', '\u2212'));

/**
 * The range of differences that holds nearly all of them: 1, 2 or 5 times a power of ten.
 * @param {Picture} difference
 */
function limitOf({ pixels }) {
  const step = 3 * Math.max(Math.floor(pixels.length / 3 / 20000), 1);
  const sizes = [];
  for (let at = 0; at < pixels.length; at += step) {
    const size = Math.abs(largest(pixels, at));
    if (size > 0 && size < Infinity) sizes.push(size);
  }
  if (!sizes.length) return 1;
  const held = sizes.sort((a, b) => a - b)[Math.ceil(0.995 * sizes.length) - 1];
  const power = 10 ** Math.floor(Math.log10(held));
  return power * ([1, 2, 5].find((factor) => held <= factor * power * 1.000001) ?? 10);
}

/**
 * @param {(number: number) => void} askForLayer
 */
export function makeDisplay(askForLayer) {
  const canvas = $('picture');
  const context = canvas.getContext('2d');
  /** @type {Record<string, Picture?>} */
  const pictures = { picture: null, reference: null, errors: null };
  /** @type {Map<number, Picture>} */
  const layers = new Map();
  /** The layer that was asked for last, of which view and width. */
  let asked = '';
  /** The difference, and the range of its colors. */
  let difference = /** @type {{of: Picture, to: Picture, picture: Picture, limit: number}?} */ (null);
  let scale = 1;
  let percent = 50;

  const tone = () => ({ stops: Number($('exposure').value), curve: $('curve').value, channel: $('channel').value });
  const layerOf = (mode) => LAYERS.findIndex(({ name }) => name === mode);

  /** Clears nothing where the size stays. */
  function resize({ width, height }) {
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  }

  /** @returns {{image: ImageData, legend: Legend?}} */
  function painted(picture) {
    const image = new ImageData(picture.width, picture.height);
    const { stops, curve, channel } = tone();
    if (channel !== 'false color') {
      paintColors(picture.pixels, { stops, curve, channel }, image);
      return { image, legend: null };
    }
    const { pixels } = picture;
    const place = (at) => (Math.log2(Math.max(CHANNELS.luminance(pixels, at), 1e-37)) + stops - DARKEST) / (BRIGHTEST - DARKEST);
    paintShares(AMOUNTS, (at) => (isFinitePixel(pixels, at) ? place(at) : NaN), image);
    const ends = [DARKEST, BRIGHTEST].map((power) => short(2 ** (power - stops)));
    return { image, legend: { name: 'luminance', gradient: AMOUNTS.gradient, ends } };
  }

  function show(picture) {
    const { image, legend } = painted(picture);
    resize(picture);
    context.putImageData(image, 0, 0);
    return legend;
  }

  /** The reference in the size of the picture, which is smaller while the camera moves. */
  function fitted(reference, { width, height }) {
    const { image } = painted(reference);
    if (reference.width === width && reference.height === height) return image;
    const [from, to] = [new OffscreenCanvas(reference.width, reference.height), new OffscreenCanvas(width, height)];
    from.getContext('2d')?.putImageData(image, 0, 0);
    const context = to.getContext('2d');
    context?.drawImage(from, 0, 0, width, height);
    return context?.getImageData(0, 0, width, height) ?? image;
  }

  function showWipe(picture, reference) {
    const { image, legend } = painted(picture);
    resize(picture);
    const split = Math.round(picture.width * percent / 100);
    paintWipe(context, fitted(reference, picture), image, split);
    $('frame').style.setProperty('--split', `${100 * split / picture.width}%`);
    return legend;
  }

  /**
   * The picture minus the reference. The colors of a picture that grows keep their range.
   * @returns {{picture: Picture, limit: number}}
   */
  function differenceOf(picture, reference) {
    const before = difference?.to === reference ? difference : null;
    if (before && before.of === picture) return before;
    const isGrowing = before?.of.generation === picture.generation && !picture.isFinal;
    const whole = minus(picture, reference);
    const now = { of: picture, to: reference, picture: whole, limit: before && isGrowing ? before.limit : limitOf(whole) };
    difference = now;
    return now;
  }

  /** @returns {Legend} */
  function showDifference(picture, reference) {
    const { picture: { pixels }, limit: whole } = differenceOf(picture, reference);
    const [limit, pick] = [whole * scale, CHANNELS[tone().channel.replace('false color', 'luminance')] ?? largest];
    const image = new ImageData(picture.width, picture.height);
    paintDifferences(pixels, pick, limit, image);
    resize(picture);
    context.putImageData(image, 0, 0);
    return { name: 'picture \u2212 reference', gradient: SIGNED.gradient, ends: [short(-limit), `+${short(limit)}`], isScaled: true };
  }

  /** @returns {Legend} */
  function showErrors(errors) {
    const image = new ImageData(errors.width, errors.height);
    const { pixels } = errors;
    const place = (at) => (Math.log10(Math.max(pixels[at], 1e-9)) - LEAST_ERROR) / (MOST_ERROR - LEAST_ERROR);
    paintShares(AMOUNTS, (at) => (Number.isFinite(pixels[at]) ? place(at) : NaN), image);
    resize(errors);
    context.putImageData(image, 0, 0);
    const ends = [LEAST_ERROR, MOST_ERROR].map((power) => `${100 * 10 ** power} %`);
    return { name: 'relative error', gradient: AMOUNTS.gradient, ends };
  }

  /** @returns {Legend?} */
  function showLayer(layer) {
    const image = new ImageData(layer.width, layer.height);
    const { name, paint } = LAYERS[layer.number];
    const range = paint(layer.pixels, image);
    resize(layer);
    context.putImageData(image, 0, 0);
    return range && { name, gradient: AMOUNTS.gradient, ends: range.map(short) };
  }

  /** @param {Legend?} legend */
  function showLegend(legend) {
    $('scale').hidden = !legend;
    if (!legend) return;
    const { name, gradient, ends, isScaled = false } = legend;
    [$('scale-name').textContent, $('least').textContent, $('most').textContent] = [name, ...ends];
    $('scale').style.setProperty('--ramp', gradient);
    for (const id of ['finer', 'coarser']) $(id).hidden = !isScaled;
  }

  function draw() {
    const { picture, reference, errors } = pictures;
    if (!picture) return;
    const mode = $('show').value;
    const layer = layers.get(layerOf(mode));
    $('divider').hidden = $('wipe').hidden = !(mode === 'wipe' && reference);
    if (mode === 'reference' && reference) showLegend(show(reference));
    else if (mode === 'wipe' && reference) showLegend(showWipe(picture, reference));
    else if (mode === 'difference' && reference && isSameSize(picture, reference)) showLegend(showDifference(picture, reference));
    else if (mode === 'errors' && errors?.generation === picture.generation && isSameSize(picture, errors)) showLegend(showErrors(errors));
    // The layer of the view before stays until the next one is there.
    else if (layer) showLegend(showLayer(layer));
    else showLegend(show(picture));
    $('frame').style.setProperty('--across', canvas.width);
    $('frame').style.setProperty('--down', canvas.height);
    ask(mode);
  }

  /** Asks for the layer that is chosen, once for each view and size. */
  function ask(mode) {
    const [number, { picture }] = [layerOf(mode), pictures];
    if (number < 0 || !picture) return;
    const layer = layers.get(number);
    if (layer?.generation === picture.generation && layer.width === picture.width) return;
    const key = `${number} ${picture.generation} ${picture.width}`;
    if (key === asked) return;
    asked = key;
    askForLayer(number);
  }

  for (const id of ['exposure', 'curve', 'channel', 'show']) {
    $(id).addEventListener(id === 'exposure' ? 'input' : 'change', () => {
      const { stops } = tone();
      $('stops').textContent = `${stops > 0 ? '+' : ''}${stops} stops`;
      asked = '';
      draw();
    });
  }
  for (const [id, factor] of [['finer', 0.5], ['coarser', 2]]) {
    $(id).addEventListener('click', () => {
      scale *= Number(factor);
      draw();
    });
  }

  return {
    pictures,
    draw,
    /** @param {Picture} newPicture */
    take(newPicture) {
      if (newPicture.content === 'layer') layers.set(newPicture.number, newPicture);
      else if (newPicture.content in pictures) pictures[newPicture.content] = newPicture;
      else pictures.picture = newPicture;
      const mode = $('show').value;
      // The layer is drawn already.
      if (newPicture.content !== 'layer' && layers.has(layerOf(mode))) ask(mode);
      else draw();
    },
    forgetReference() {
      pictures.reference = null;
      draw();
    },
    /** The layer that is shown. */
    layer: () => layers.get(layerOf($('show').value)) ?? null,
    /** @param {number} share */
    wipe(share) {
      percent = share;
      draw();
    },
  };
}
