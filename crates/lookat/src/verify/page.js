// The page is complete without this script but for the pictures, the sorting and the controls. What it imports comes before it in
// the same script.

import { largest, paintColors, paintDifferences, paintWipe } from './paint.js';
import { SIGNED } from './ramp.js';
import { digits, part } from './readout.js';
import { makeWipe } from './wipe.js';

const GAP = 24; // pixels between the panes, as in the style
const NARROWEST = 300; // pixels of a pane
const TALLEST = 640;
const KEPT = 4e6; // pixels of pictures that stay unpacked when they are out of view

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const main = document.querySelector('main');
const bar = document.querySelector('.bar');
const slider = document.getElementById('exposure');

// Numbers --------------------------------------------------------------------------------------------------

/** The number that each of the 65536 half floats is. */
const HALF = Float32Array.from({ length: 65536 }, (_, bits) => {
  const [sign, exponent, fraction] = [bits >> 15 ? -1 : 1, bits >> 10 & 31, bits & 1023];
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? (1 + fraction / 1024) * 2 ** (exponent - 15) : fraction * 2 ** -24);
});

// Pictures -------------------------------------------------------------------------------------------------

/** The numbers of a scene: red, green and blue of each pixel. */
async function unpack(text) {
  const characters = atob(text);
  const packed = new Uint8Array(characters.length);
  for (let i = 0; i < packed.length; i++) packed[i] = characters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  // First all high bytes, then all low ones; in both the expected picture and then what is to be added.
  const [all, count] = [bytes.length / 2, bytes.length / 4];
  const half = (i) => HALF[bytes[i] << 8 | bytes[all + i]];
  const [expected, actual, difference] = [1, 2, 3].map(() => new Float32Array(count));
  for (let i = 0; i < count; i++) {
    const added = half(count + i);
    expected[i] = half(i);
    // To what is not finite nothing can be added: there is the actual value itself.
    const finite = Number.isFinite(expected[i]);
    actual[i] = finite ? expected[i] + added : added;
    difference[i] = finite ? added : NaN;
  }
  return { expected, actual, difference };
}

/** The difference of the channel that differs most, in false color. */
function showDifference(viewer) {
  const image = new ImageData(viewer.width, viewer.height);
  paintDifferences(viewer.numbers.difference, largest, viewer.scale, image);
  viewer.canvases.difference.getContext('2d').putImageData(image, 0, 0);
}

/** Expected left of a share of the width, actual beyond. */
function showPictures(viewer, kind, percent) {
  const split = Math.round(viewer.width * percent / 100);
  paintWipe(viewer.canvases[kind].getContext('2d'), viewer.expected, viewer.actual, split);
}

function exposePictures(viewer) {
  const tone = { stops: Number(slider.value) + viewer.stops, curve: 'none', channel: 'color' };
  paintColors(viewer.numbers.expected, tone, viewer.expected);
  paintColors(viewer.numbers.actual, tone, viewer.actual);
  showPictures(viewer, 'wipe', viewer.percent);
  showPictures(viewer, 'expected', 100);
  showPictures(viewer, 'actual', 0);
}

// Viewers --------------------------------------------------------------------------------------------------

function makeViewer(element) {
  const { id, only, ...measures } = element.dataset;
  const viewer = { element, id, only, percent: 50, point: null, numbers: null, near: false, canvases: {} };
  for (const [name, text] of Object.entries(measures)) viewer[name] = Number(text);
  const article = element.closest('article');
  viewer.name = article.querySelector('h2').textContent;
  element.append(document.getElementById('viewer').content.cloneNode(true));
  const thumbnails = document.querySelectorAll(`a[href="#${article.id}"] img`);
  for (const figure of element.querySelectorAll('figure')) {
    const kind = figure.dataset.shows;
    viewer.canvases[kind] = figure.querySelector('canvas');
    const thumbnail = viewer.thumbnail + (kind === 'difference' && !only ? 1 : 0);
    figure.querySelector('img').src = thumbnails[thumbnail].src;
    const frame = figure.querySelector('.frame');
    const label = kind === 'wipe' ? 'expected and actual' : kind;
    frame.setAttribute('aria-label', `${viewer.name}, ${label}`);
    listenToFrame(viewer, frame);
  }
  listenToWipe(viewer);
  listenToScale(viewer);
  read(viewer);
  return viewer;
}

/** Unpacks and paints, if that is not done yet. */
async function show(viewer) {
  if (viewer.numbers || viewer.unpacking) return;
  viewer.unpacking = true;
  const numbers = await unpack(document.getElementById(viewer.id).textContent);
  viewer.unpacking = false;
  if (!viewer.near) return;
  const { width, height } = viewer;
  viewer.numbers = numbers;
  [viewer.expected, viewer.actual] = [new ImageData(width, height), new ImageData(width, height)];
  for (const canvas of Object.values(viewer.canvases)) [canvas.width, canvas.height] = [width, height];
  exposePictures(viewer);
  showDifference(viewer);
  viewer.element.dataset.ready = '';
}

/** Gives the memory back. */
function forget(viewer) {
  viewer.numbers = viewer.expected = viewer.actual = null;
  for (const canvas of Object.values(viewer.canvases)) canvas.width = canvas.height = 0;
  delete viewer.element.dataset.ready;
}

/** Says what the numbers of the pixel under the pointer are. */
function read(viewer) {
  const { element, point, numbers, reduced } = viewer;
  const reading = element.querySelector('.reading');
  element.toggleAttribute('data-pointed', Boolean(point && numbers));
  if (!point || !numbers) {
    reading.textContent = 'Point at a picture to read its numbers.';
    return;
  }
  element.style.setProperty('--x', `${100 * point.x / viewer.width}%`);
  element.style.setProperty('--y', `${100 * point.y / viewer.height}%`);
  const place = 3 * (point.y * viewer.width + point.x);
  const pixel = (label, write) => part(label, Array.from(numbers[label].subarray(place, place + 3), write));
  const position = part('x, y', [`${viewer.x + reduced * point.x}, ${viewer.y + reduced * point.y}`]);
  if (viewer.only) {
    reading.replaceChildren(position, pixel(viewer.only, digits));
    return;
  }
  reading.replaceChildren(
    position,
    pixel('expected', digits),
    pixel('actual', digits),
    pixel('difference', (value) => (value > 0 ? '+' : '') + digits(value)),
  );
}

function pointAt(viewer, x, y) {
  const within = (place, size) => Math.min(Math.max(place, 0), size - 1);
  viewer.point = { x: within(x, viewer.width), y: within(y, viewer.height) };
  read(viewer);
}

function listenToFrame(viewer, frame) {
  const point = (event) => {
    const box = frame.getBoundingClientRect();
    const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    pointAt(viewer, Math.floor(x * viewer.width), Math.floor(y * viewer.height));
  };
  const leave = (event) => {
    if (event.pointerType === 'touch') return;
    viewer.point = null;
    read(viewer);
  };
  frame.addEventListener('pointerdown', point);
  frame.addEventListener('pointermove', point);
  frame.addEventListener('pointerleave', leave);
  frame.addEventListener('blur', leave);
  frame.addEventListener('keydown', (event) => {
    if (!(event.key in ARROWS)) return;
    const [x, y] = ARROWS[event.key];
    event.preventDefault();
    const { x: atX, y: atY } = viewer.point ?? { x: viewer.width >> 1, y: viewer.height >> 1 };
    const step = event.shiftKey ? 10 : 1;
    pointAt(viewer, atX + step * x, atY + step * y);
  });
}

function listenToWipe(viewer) {
  const range = viewer.element.querySelector('input');
  const frame = viewer.element.querySelector('[data-shows=wipe] .frame');
  range.setAttribute('aria-label', `${viewer.name}, how much of the expected picture is shown`);
  makeWipe({ frame, handle: frame, range, left: 'expected' }, (percent) => {
    viewer.percent = percent;
    viewer.element.style.setProperty('--split', `${100 * Math.round(viewer.width * percent / 100) / viewer.width}%`);
    if (viewer.numbers) showPictures(viewer, 'wipe', percent);
  });
}

function listenToScale(viewer) {
  const rescale = (factor) => {
    viewer.scale *= factor;
    const [least, most] = viewer.element.querySelectorAll('.scale output');
    const text = String(Number(viewer.scale.toPrecision(3)));
    least.textContent = `\u2212${text}`;
    most.textContent = `+${text}`;
    if (viewer.numbers) showDifference(viewer);
  };
  viewer.element.querySelector('.finer').addEventListener('click', () => rescale(0.5));
  viewer.element.querySelector('.coarser').addEventListener('click', () => rescale(2));
  rescale(1);
}

/** Magnifies by whole numbers of device pixels where that does not waste much room. */
function fit(viewers) {
  document.documentElement.style.scrollPaddingTop = `${bar.offsetHeight}px`;
  const view = document.body.dataset.view;
  const fitting = Math.floor((main.clientWidth + GAP) / (NARROWEST + GAP));
  const columns = Math.max(1, Math.min(fitting, { wipe: 2, side: 3, large: 1 }[view]));
  const room = (main.clientWidth - GAP * (columns - 1)) / columns;
  // On fine displays nobody sees that pixels are uneven.
  const enough = devicePixelRatio < 2 ? 0.8 : 0.95;
  const tallest = view === 'large' ? 0.8 * innerHeight : TALLEST;
  for (const { element, width, height } of viewers) {
    const most = Math.min(room, tallest * width / height);
    const whole = Math.floor(most * devicePixelRatio / width) * width / devicePixelRatio;
    const shown = whole > enough * most ? whole : most;
    element.style.setProperty('--shown', `${shown}px`);
    element.toggleAttribute('data-magnified', shown * devicePixelRatio >= width);
  }
}

// The whole page -------------------------------------------------------------------------------------------

function listenToBar(viewers) {
  const label = document.getElementById('stops');
  let asked = false;
  const change = () => {
    const stops = Number(slider.value);
    const size = `${Math.abs(stops)} stop${Math.abs(stops) === 1 ? '' : 's'}`;
    const text = (stops > 0 ? '+' : stops < 0 ? '\u2212' : '') + size;
    label.textContent = text;
    slider.setAttribute('aria-valuetext', text);
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      viewers.filter((viewer) => viewer.numbers).forEach(exposePictures);
    });
  };
  slider.addEventListener('input', change);
  bar.querySelector('button').addEventListener('click', () => {
    slider.value = 0;
    change();
  });
  for (const radio of bar.querySelectorAll('[name=view]')) {
    radio.addEventListener('change', () => {
      document.body.dataset.view = radio.value;
      fit(viewers);
    });
  }
  bar.hidden = false;
  change();
}

/** Shows what is near the window. */
function watch(viewers) {
  const of = new Map(viewers.map((viewer) => [viewer.element, viewer]));
  const pixels = (viewer) => viewer.numbers ? viewer.width * viewer.height : 0;
  const kept = () => viewers.reduce((sum, viewer) => sum + pixels(viewer), 0);
  const observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const viewer = of.get(target);
      viewer.near = isIntersecting;
      if (isIntersecting) show(viewer);
      else if (viewer.numbers && kept() > KEPT) forget(viewer);
    }
  }, { rootMargin: '600px' });
  for (const viewer of viewers) observer.observe(viewer.element);
}

/** Sorts rows, and the scenes below with them. What has no number comes last. */
function sort(heading) {
  const sorted = heading.getAttribute('aria-sort');
  const descending = sorted ? sorted === 'ascending' : heading.cellIndex > 0;
  for (const other of heading.parentElement.cells) other.removeAttribute('aria-sort');
  heading.setAttribute('aria-sort', descending ? 'descending' : 'ascending');
  const body = document.querySelector('tbody');
  const rank = (row) => Number(row.cells[heading.cellIndex]?.dataset.rank || NaN);
  const compare = heading.cellIndex === 0
    ? (a, b) => a.cells[0].textContent.localeCompare(b.cells[0].textContent, 'en', { numeric: true })
    : (a, b) => rank(a) - rank(b);
  const known = (row) => heading.cellIndex === 0 || !Number.isNaN(rank(row));
  const rows = [...body.rows];
  const ranked = rows.filter(known).sort((a, b) => descending ? compare(b, a) : compare(a, b));
  body.append(...ranked, ...rows.filter((row) => !known(row)));
  main.append(...[...body.rows].map((row) => document.querySelector(row.querySelector('a').hash)));
}

function listenToTable() {
  for (const heading of document.querySelectorAll('thead th')) {
    heading.addEventListener('click', () => sort(heading));
  }
  document.querySelector('tbody').addEventListener('click', (event) => {
    if (event.target.closest('a') || !getSelection().isCollapsed) return;
    event.target.closest('tr')?.querySelector('a').click();
  });
}

const viewers = [...document.querySelectorAll('.viewer')].map(makeViewer);
main.style.setProperty('--ramp', SIGNED.gradient);
fit(viewers);
new ResizeObserver(() => fit(viewers)).observe(main);
listenToBar(viewers);
listenToTable();
watch(viewers);
