// What the lens makes of the scene: circles of confusion, and the range of depths that are sharp.

import { isPerspective, unitAt } from './camera.js';

/** @typedef {import('./camera.js').Camera} Camera */

/** The distance between circles, in pixels of the page. */
const STEP = 44;
/** What is blurred by at most so many pixels of the picture is sharp. */
const SHARP = 1;
const SVG = 'http://www.w3.org/2000/svg';
const $ = (id) => /** @type {any} */ (document.getElementById(id));

/**
 * Pixels of the picture per unit of length at depth 1. Of an orthographic camera it is the same at all depths.
 * @param {Camera} camera
 * @param {number[]} resolution
 */
function pixelsPerUnit(camera, resolution) {
  const [x0, x1] = camera.screenWindow;
  return resolution[0] / Math.abs(x1 - x0) / unitAt(camera, 1);
}

/**
 * The diameter of the circle of confusion of a point, in pixels of the picture (PBR 6.2.3).
 * @param {Camera} camera
 * @param {number[]} resolution
 * @param {number} depth
 */
export function circleOfConfusion(camera, resolution, depth) {
  const [focal, distance] = [camera.focalDistance ?? Infinity, depth].map((z) => z - camera.lensDepth);
  const pixels = 2 * camera.lensRadius * pixelsPerUnit(camera, resolution);
  return isPerspective(camera) ? pixels * Math.abs(1 / focal - 1 / distance) : pixels * Math.abs(distance / focal - 1);
}

/**
 * The nearest and the farthest depth that are sharp.
 * @param {Camera} camera
 * @param {number[]} resolution
 * @returns {[number, number]}
 */
export function sharpRange(camera, resolution) {
  const focal = (camera.focalDistance ?? Infinity) - camera.lensDepth;
  const most = SHARP / (2 * camera.lensRadius * pixelsPerUnit(camera, resolution));
  if (!isPerspective(camera)) return [focal * (1 - most), focal * (1 + most)];
  const least = 1 / focal - most;
  return [camera.lensDepth + 1 / (1 / focal + most), least > 0 ? camera.lensDepth + 1 / least : Infinity];
}

/** A number for people. */
const short = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(4))) : '\u221e');

/**
 * Makes the overlay.
 * @param {(question: object) => Promise<any>} ask
 * @param {() => {camera: Camera, resolution: number[], crop: number[]} | null} view
 */
export function makeBlur(ask, view) {
  const [overlay, check, band, words] = [$('blur'), $('show-blur'), $('sharp'), $('sharp-range')];
  /** Counts the questions: the answer to the last one counts. */
  let asked = 0;

  /** The circles at the places where something is. */
  function draw({ columns, depths }, { camera, resolution, crop }) {
    const rows = depths.length / columns;
    const [width, height] = [crop[2] - crop[0], crop[3] - crop[1]];
    overlay.setAttribute('viewBox', `0 0 ${width} ${height}`);
    const circles = depths.map((depth, index) => {
      if (depth === null || depth <= 0) return null;
      const diameter = circleOfConfusion(camera, resolution, depth);
      const circle = document.createElementNS(SVG, 'circle');
      circle.setAttribute('class', diameter <= SHARP ? 'sharp' : '');
      circle.setAttribute('cx', String((index % columns + 0.5) / columns * width));
      circle.setAttribute('cy', String((Math.floor(index / columns) + 0.5) / rows * height));
      const pixel = width / overlay.clientWidth;
      circle.setAttribute('r', String(diameter <= SHARP ? 2.5 * pixel : Math.max(diameter / 2, pixel)));
      return circle;
    });
    overlay.replaceChildren(...circles.filter((circle) => circle));
    showBand(camera, resolution, depths.filter((depth) => depth > 0));
  }

  /** The sharp range among the depths of the picture. */
  function showBand(camera, resolution, depths) {
    const [near, far] = sharpRange(camera, resolution);
    words.textContent = `${short(near)} to ${short(far)}`;
    const [low, high] = [Math.min(...depths, camera.focalDistance ?? Infinity), Math.max(...depths, camera.focalDistance ?? 0)];
    // On a logarithmic scale, equal blur has equal length near and far.
    const place = (depth) => 100 * Math.min(Math.max(Math.log(depth / low) / Math.log(high / low), 0), 1);
    band.style.setProperty('--from', `${place(Math.max(near, low))}%`);
    band.style.setProperty('--to', `${place(Math.min(far, high))}%`);
    band.dataset.low = short(low);
    band.dataset.high = short(high);
  }

  async function update() {
    const seen = view();
    const hasLens = seen !== null && seen.camera.lensRadius > 0 && seen.camera.kind !== 'environment';
    check.disabled = !hasLens;
    const isShown = hasLens && check.checked;
    [overlay.toggleAttribute('hidden', !isShown), $('sharpness').hidden = !isShown];
    const question = ++asked;
    if (!isShown) return;
    const [columns, rows] = [overlay.clientWidth, overlay.clientHeight].map((size) => Math.min(Math.max(Math.round(size / STEP), 3), 40));
    const answer = await ask({ type: 'depths', columns, rows });
    const now = view();
    if (answer && now && question === asked) draw(answer, now);
  }
  check.addEventListener('change', update);
  return update;
}
