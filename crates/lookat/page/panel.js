// The fields of the camera and the film, and what the picture shows at a place.

import { LAYERS } from './layers.js';
import { placeLink } from './places.js';
import { isTyping, noteTyping } from './typing.js';
import { full } from './readout.js';

/** @typedef {import('./camera.js').Camera} Camera */

/** Least and most, by the camera of the file and the longest distance of a target. @typedef {(own: Camera, distance: number) => [number, number]} Range */

/**
 * A row of numbers. `key` and `from` say where they are, `names` what each of them is.
 * @typedef {object} Row
 * @property {string} label
 * @property {string} key
 * @property {number} from
 * @property {string[]} names
 * @property {string[]} kinds of cameras that have it
 * @property {Range} [range] of its sliders
 */

const ALL = ['perspective', 'orthographic', 'environment', 'realistic'];
const [PERSPECTIVE, FLAT, REALISTIC] = [['perspective'], ['perspective', 'orthographic'], ['realistic']];
const XYZ = ['x', 'y', 'z'];

/** Twice the largest edge of the file's screen window, to both sides. @type {Range} */
function around({ screenWindow }) {
  const largest = 2 * Math.max(...screenWindow.map(Math.abs));
  return [-largest, largest];
}

/** @type {Row[]} */
const ROWS = [
  { label: 'eye', key: 'lookAt', from: 0, names: XYZ, kinds: ALL },
  { label: 'target', key: 'lookAt', from: 3, names: XYZ, kinds: ALL },
  { label: 'up vector', key: 'lookAt', from: 6, names: XYZ, kinds: ALL },
  { label: 'fov', key: 'fov', from: 0, names: [''], kinds: PERSPECTIVE, range: () => [1, 179] },
  { label: 'lensradius', key: 'lensRadius', from: 0, names: [''], kinds: FLAT, range: (_, distance) => [0, distance / 20] },
  { label: 'focaldistance', key: 'focalDistance', from: 0, names: [''], kinds: FLAT, range: (_, distance) => [distance / 50, 3 * distance] },
  { label: 'focusdistance', key: 'focalDistance', from: 0, names: [''], kinds: REALISTIC, range: (_, distance) => [distance / 50, 3 * distance] },
  { label: 'screenwindow', key: 'screenWindow', from: 0, names: ['left', 'right', 'bottom', 'top'], kinds: FLAT, range: around },
  { label: 'time', key: 'time', from: 0, names: [''], kinds: ALL, range: ({ times }) => times ?? [0, 1] },
  { label: 'frameaspectratio', key: 'aspect', from: 0, names: [''], kinds: FLAT, range: () => [0.2, 5] },
];

/** @type {{label: string, key: string, names: string[], range?: () => [number, number]}[]} */
const FILM = [
  { label: 'resolution', key: 'resolution', names: ['xresolution', 'yresolution'] },
  { label: 'cropwindow', key: 'crop', names: ['left', 'right', 'top', 'bottom'], range: () => [0, 1] },
  { label: 'pixelsamples', key: 'samplesPerPixel', names: [''] },
];

/** As many digits as there is room for. The numbers that nobody edits keep all of theirs. */
const short = (value) => String(Number(value.toPrecision(4)));

const list = (value) => (Array.isArray(value) ? value : [value]);

/**
 * The window with another ratio of width and height, and the same shorter side.
 * @param {number[]} window
 * @param {number} ratio
 */
function withAspect([x0, x1, y0, y1], ratio) {
  const half = Math.min(Math.abs(x1 - x0), Math.abs(y1 - y0)) / 2;
  const [x, y] = [half * Math.max(ratio, 1) * Math.sign(x1 - x0), half * Math.max(1 / ratio, 1) * Math.sign(y1 - y0)];
  const [middleX, middleY] = [(x0 + x1) / 2, (y0 + y1) / 2];
  return [middleX - x, middleX + x, middleY - y, middleY + y];
}

/** @param {Camera} camera */
const aspectOf = ({ screenWindow: [x0, x1, y0, y1] }) => Math.abs((x1 - x0) / (y1 - y0));

/** @param {Camera} camera */
const distanceOf = ({ lookAt }) => Math.hypot(...[0, 1, 2].map((i) => lookAt[i + 3] - lookAt[i]));

/**
 * The camera with another number in a row.
 * @param {Camera} camera
 * @param {Row} row
 * @param {number} index
 * @param {number} value
 * @returns {Camera}
 */
function changed(camera, { key, from }, index, value) {
  if (key === 'aspect') return { ...camera, screenWindow: withAspect(camera.screenWindow, value) };
  const old = camera[key];
  if (Array.isArray(old)) return { ...camera, [key]: old.with(from + index, value) };
  const next = { ...camera, [key]: value };
  // A new lens is sharp at the target.
  if (key === 'lensRadius' && value > 0 && !camera.focalDistance) next.focalDistance = distanceOf(camera);
  return next;
}

/** A row of inputs with a label for each, and with a slider for each if there is a range. */
function makeField(label, names, range) {
  const field = document.createElement('div');
  field.className = 'field';
  const numbers = document.createElement('div');
  numbers.className = 'numbers';
  const title = document.createElement(names.length > 1 ? 'span' : 'label');
  title.textContent = label;
  const inputs = names.map((name) => {
    const input = Object.assign(document.createElement('input'), { type: 'number', step: 'any', id: `${label}-${name}` });
    input.setAttribute('aria-label', `${label} ${name}`.trim());
    input.title = name;
    noteTyping(input);
    return input;
  });
  if (title instanceof HTMLLabelElement) title.htmlFor = inputs[0].id;
  const sliders = (range ? names : []).map((name) => {
    const slider = Object.assign(document.createElement('input'), { type: 'range', step: 'any' });
    slider.setAttribute('aria-label', `${`${label} ${name}`.trim()}, slider`);
    return slider;
  });
  field.append(title, numbers);
  if (names.length === 1) {
    numbers.append(...sliders, ...inputs);
  } else {
    numbers.append(...inputs);
    const below = Object.assign(document.createElement('div'), { className: 'numbers' });
    below.append(...sliders);
    if (sliders.length) field.append(below);
  }
  return { field, inputs, sliders };
}

/** Shows a number, unless someone is typing it. */
function show(input, value) {
  if (!isTyping(input)) input.value = value === null ? '' : short(value);
}

/**
 * Makes the fields.
 * @param {{camera: (change: (camera: Camera) => Camera) => void, film: (change: object) => void}} act
 */
export function makePanel(act) {
  const rows = ROWS.map((row) => {
    const made = makeField(row.label, row.names, row.range);
    made.inputs.forEach((input, index) => input.addEventListener('change', () => {
      const value = input.valueAsNumber;
      if (Number.isFinite(value) && (row.key !== 'aspect' || value > 0)) act.camera((camera) => changed(camera, row, index, value));
      // It is no number, or no ratio.
      else if (shown) panel.showCamera(...shown);
    }));
    made.sliders.forEach((slider, index) => slider.addEventListener('input', () => {
      act.camera((camera) => changed(camera, row, index, slider.valueAsNumber));
    }));
    document.getElementById('camera')?.append(made.field);
    return { ...row, ...made };
  });
  const film = FILM.map((row) => ({ ...row, ...makeField(row.label, row.names, row.range) }));
  const change = () => {
    const values = film.map(({ key, inputs }) => [key, inputs.map((input) => input.valueAsNumber)]);
    if (values.flatMap(([, numbers]) => numbers).some(Number.isNaN)) return;
    const { resolution, crop, samplesPerPixel } = Object.fromEntries(values);
    act.film({ resolution: resolution.map(Math.round), crop, samplesPerPixel: Math.round(samplesPerPixel[0]) });
  };
  let isWaiting = false;
  /** At most once in each frame of the display. */
  const changeSoon = () => {
    if (isWaiting) return;
    isWaiting = true;
    requestAnimationFrame(() => {
      isWaiting = false;
      change();
    });
  };
  for (const { field, inputs, sliders, range } of film) {
    inputs.forEach((input) => input.addEventListener('change', change));
    sliders.forEach((slider, index) => {
      [slider.min, slider.max] = (range?.() ?? []).map(String);
      noteTyping(slider);
      slider.addEventListener('input', () => {
        // At least a pixel is left.
        const [other, size] = [inputs[index ^ 1].valueAsNumber, film[0].inputs[index >> 1].valueAsNumber];
        const value = slider.valueAsNumber;
        inputs[index].value = short(index % 2 ? Math.max(value, other + 1 / size) : Math.min(value, other - 1 / size));
        changeSoon();
      });
      // The answer shows the film as it is.
      slider.addEventListener('change', change);
    });
    document.getElementById('film')?.append(field);
  }

  /** The longest distance of the target so far gives the sliders their range, so that they do not slip away. */
  let reach = 0;
  /** The camera that is shown, and the one of the file. @type {[Camera, Camera?]?} */
  let shown = null;
  const panel = {
    /**
     * @param {Camera} camera
     * @param {Camera | null} own the camera of the file
     */
    showCamera(camera, own) {
      shown = [camera, own];
      // The file has a new range.
      const isOwn = own && String(own.lookAt) === String(camera.lookAt);
      reach = isOwn ? distanceOf(camera) : Math.max(reach, distanceOf(camera));
      const kind = document.getElementById('kind');
      if (kind) kind.textContent = camera.kind + (camera.hasLookAt ? '' : ', placed without LookAt');
      for (const { key, from, kinds, names, range, field, inputs, sliders } of rows) {
        field.hidden = !kinds.includes(camera.kind) || (key === 'time' && !camera.times);
        const numbersOf = (of) => (key === 'aspect' ? [aspectOf(of)] : list(of[key]).slice(from, from + names.length));
        const numbers = numbersOf(camera);
        inputs.forEach((input, index) => show(input, numbers[index]));
        const isIdle = key === 'focalDistance' && !camera.lensRadius;
        for (const input of [...inputs, ...sliders]) input.disabled = isIdle;
        const differs = own !== null && String(numbersOf(own)) !== String(numbers);
        field.toggleAttribute('data-set', differs && !isIdle);
        if (!range) continue;
        const [least, most] = range(own ?? camera, reach);
        sliders.forEach((slider, index) => {
          const value = numbers[index] ?? 0;
          [slider.min, slider.max] = [String(Math.min(least, value)), String(Math.max(most, value))];
          show(slider, numbers[index]);
        });
      }
    },
    /** @param {{resolution: number[], crop: number[], samplesPerPixel: number} | null} of */
    showFilm(of) {
      if (!of) return;
      const [width, height] = of.resolution;
      const [x0, y0, x1, y1] = of.crop;
      const values = { ...of, crop: [x0 / width, x1 / width, y0 / height, y1 / height] };
      for (const { key, inputs, sliders } of film) {
        list(values[key]).forEach((value, index) => [inputs[index], sliders[index]].forEach((input) => input && show(input, value)));
      }
    },
    /**
     * @param {import('./pointing.js').Hit?} hit
     * @param {((at: object) => void) | null} open opens a place in the editor
     */
    showHit(hit, open) {
      const make = (name, content) => {
        const element = document.createElement(name);
        element.append(content);
        return element;
      };
      const link = (place) => place && placeLink(place, open);
      const lines = hit ? [
        ['shape', hit.shape], ['at', link(hit.shapePlace)], ['material', hit.material], ['at', link(hit.materialPlace)],
        ['depth', short(hit.depth)], ['point', hit.p.map(short).join(' ')],
      ] : [];
      const shown = lines.filter(([, content]) => content).flatMap(([name, content]) => [make('dt', name), make('dd', content)]);
      document.getElementById('hit')?.replaceChildren(...(hit ? shown : [make('dd', 'Nothing is there.')]));
    },
    /** @param {number[][]} values of each layer */
    showValues(values) {
      const make = (name, text) => Object.assign(document.createElement(name), { textContent: text });
      const lines = values.flatMap((numbers, layer) => [make('dt', LAYERS[layer].name), make('dd', numbers.map(full).join(' '))]);
      document.getElementById('values')?.replaceChildren(...lines);
    },
  };
  return panel;
}
