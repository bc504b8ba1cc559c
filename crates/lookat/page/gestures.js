// Mouse, touch and keys on the picture.

import { dolly, orbit, pan, roll } from './camera.js';

/** A press that moves by fewer pixels is a click. */
const CLICK = 4;
/** The movement of a key, in fractions of the film. */
const STEP = 0.03;

/**
 * What gestures need of the page.
 * @typedef {object} Page
 * @property {() => import('./camera.js').Camera | null} camera
 * @property {() => number[]} scale
 * @property {(at: number[]) => number[]} place
 * @property {(camera: import('./camera.js').Camera) => void} move
 * @property {(at: number[]) => void} click
 * @property {() => void} reset
 * @property {(at: number[]) => Promise<{p: number[], depth: number} | null>} point
 * @property {(at: number[] | null) => void} hover
 * @property {(stops: number) => void} expose
 * @property {() => void} showBlur
 */

/**
 * Turns the gestures on the picture into movements of the camera.
 * @param {HTMLElement} frame
 * @param {Page} page
 */
export function listen(frame, page) {
  listenToPointers(frame, page);
  frame.addEventListener('wheel', (event) => {
    event.preventDefault();
    const camera = page.camera();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 32 : 1);
    if (camera) page.move(dolly(camera, Math.exp(0.0015 * pixels), page.place(placeOf(frame, event))));
  }, { passive: false });
  // Letters are keys of the picture alone: elsewhere a screen reader may use them.
  frame.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (press(page, event.key, event.shiftKey)) event.preventDefault();
  });
}

/**
 * A place in fractions of the picture.
 * @param {HTMLElement} frame
 * @param {{clientX: number, clientY: number}} event
 */
export function placeOf(frame, { clientX, clientY }) {
  const box = frame.getBoundingClientRect();
  return [(clientX - box.left) / box.width, (clientY - box.top) / box.height];
}

/**
 * @param {HTMLElement} frame
 * @param {Page} page
 */
function listenToPointers(frame, page) {
  /** The pointers that are down, by their numbers. @type {Map<number, {clientX: number, clientY: number}>} */
  const down = new Map();
  /** @type {{isPan: boolean, start: number[], moved: boolean, point: {p: number[], depth: number} | null, isReady: boolean, x: number, y: number} | null} */
  let drag = null;

  /** Applies the movement since the last time, once it is known what is at the start of the drag. */
  const apply = () => {
    const camera = page.camera();
    if (!drag?.isReady || !camera) return;
    const [across, along] = page.scale();
    const { x, y, point, isPan } = drag;
    [drag.x, drag.y] = [0, 0];
    const aspect = frame.clientHeight / frame.clientWidth * along / across;
    page.move(isPan
      ? pan(camera, x * across, y * along, point?.depth ?? null)
      : orbit(camera, point?.p ?? null, x * across, y * along * aspect));
  };

  const begin = async () => {
    const mine = drag;
    if (!mine) return;
    mine.moved = true;
    const point = await page.point(mine.start);
    mine.point = point && point.depth > 0 ? point : null;
    mine.isReady = true;
    if (drag === mine) apply();
  };

  frame.addEventListener('pointerdown', (event) => {
    frame.setPointerCapture(event.pointerId);
    down.set(event.pointerId, event);
    const isPan = event.shiftKey || event.button !== 0;
    drag = down.size === 1
      ? { isPan, start: placeOf(frame, event), moved: false, point: null, isReady: false, x: 0, y: 0 }
      : null;
  });
  frame.addEventListener('pointermove', (event) => {
    page.hover(placeOf(frame, event));
    const before = down.get(event.pointerId);
    if (!before) return;
    if (down.size === 2) {
      pinch(frame, page, down, event);
    } else if (drag) {
      drag.x += event.clientX - before.clientX;
      drag.y += event.clientY - before.clientY;
      if (drag.moved) apply();
      else if (Math.hypot(drag.x, drag.y) >= CLICK) begin();
    }
    down.set(event.pointerId, event);
  });
  const end = (event) => {
    const isClick = event.type === 'pointerup' && drag && !drag.moved && down.size === 1 && event.button === 0;
    if (isClick) page.click(placeOf(frame, event));
    down.delete(event.pointerId);
    drag = null;
  };
  frame.addEventListener('pointerup', end);
  frame.addEventListener('pointercancel', end);
  frame.addEventListener('pointerleave', () => page.hover(null));
  frame.addEventListener('contextmenu', (event) => event.preventDefault());
}

/**
 * Two fingers: their middle pans, their distance dollies.
 * @param {HTMLElement} frame
 * @param {Page} page
 * @param {Map<number, {clientX: number, clientY: number}>} down before the event
 * @param {PointerEvent} event
 */
function pinch(frame, page, down, event) {
  const other = [...down].find(([id]) => id !== event.pointerId)?.[1];
  const [before, camera] = [down.get(event.pointerId), page.camera()];
  if (!other || !before || !camera) return;
  const apart = (one) => Math.max(Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY), 1);
  const middle = { clientX: (event.clientX + other.clientX) / 2, clientY: (event.clientY + other.clientY) / 2 };
  const [across, along] = page.scale();
  const [x, y] = [(event.clientX - before.clientX) / 2 * across, (event.clientY - before.clientY) / 2 * along];
  const factor = apart(before) / apart(event);
  page.move(dolly(pan(camera, x, y, null), factor, page.place(placeOf(frame, middle))));
}

/** The directions of the arrow keys, right and down. */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * Acts on a key. False if it has no meaning.
 * @param {Page} page
 * @param {string} key
 * @param {boolean} isShifted
 */
function press(page, key, isShifted) {
  const camera = page.camera();
  if (!camera) return false;
  const fov = (factor) => camera.fov && page.move({ ...camera, fov: Math.min(camera.fov * factor, 179) });
  const actions = {
    '+': () => page.move(dolly(camera, 0.9, [0.5, 0.5])),
    '=': () => page.move(dolly(camera, 0.9, [0.5, 0.5])),
    '-': () => page.move(dolly(camera, 1 / 0.9, [0.5, 0.5])),
    ',': () => page.move(roll(camera, -STEP)),
    '.': () => page.move(roll(camera, STEP)),
    '[': () => fov(1 / 1.05),
    ']': () => fov(1.05),
    e: () => page.expose(0.25),
    d: () => page.expose(-0.25),
    f: () => page.click([0.5, 0.5]),
    r: () => page.reset(),
    c: () => page.showBlur(),
  };
  if (key in ARROWS) {
    const [x, y] = ARROWS[key].map((direction) => direction * STEP);
    page.move(isShifted ? pan(camera, -x, -y, null) : orbit(camera, null, -x, -y));
    return true;
  }
  const action = actions[key.toLowerCase()];
  action?.();
  return Boolean(action);
}
