// How large a pixel is, and moving over a picture that is larger than its room.

import { placeOf } from './gestures.js';

/** Display pixels for each pixel of the picture; 0 fits the room. */
const LEVELS = [0, 1, 2, 4, 8, 16, 32];
/** The turn of a wheel that is a level. */
const TURN = 60;

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/**
 * @param {object} page
 * @param {() => number[] | null} page.size width and height of the picture
 * @param {(place: number[] | null) => void} page.point
 * @param {() => void} page.speak says the numbers of the pixel that is pointed at
 * @param {() => number[] | null} page.pointer
 */
export function makeZoom({ size, point, pointer, speak }) {
  const [room, frame, canvas, select, drag] = ['room', 'frame', 'picture', 'zoom', 'drag'].map($);
  const isHand = () => drag.value === 'picture';

  /** Display pixels for each pixel of the picture. */
  const scale = () => frame.clientWidth * devicePixelRatio / (size()?.[0] ?? 1);

  /** Whether each pixel of the picture is several of the display. Small pictures of a moving camera look better smooth. */
  function mark() {
    frame.toggleAttribute('data-magnified', canvas.width === size()?.[0] && scale() >= 1.5);
    frame.toggleAttribute('data-hand', isHand());
  }

  /** Gives the frame its size, which no picture changes. */
  function fit() {
    const [width, height] = size() ?? [0, 0];
    if (!width) return;
    const fitting = Math.min((room.clientWidth - 16) / width, (room.clientHeight - 16) / height);
    const factor = Number(select.value) / devicePixelRatio || fitting;
    room.style.setProperty('--ratio', width / height);
    frame.style.setProperty('--wide', `${Math.max(width * factor, 1)}px`);
    frame.style.setProperty('--tall', `${Math.max(height * factor, 1)}px`);
    mark();
  }

  /** Zooms, and keeps what is at a place of the window there. */
  function zoomTo(level, { clientX, clientY }) {
    const [x, y] = placeOf(frame, { clientX, clientY });
    select.value = String(level);
    fit();
    const after = frame.getBoundingClientRect();
    room.scrollBy(after.left + x * after.width - clientX, after.top + y * after.height - clientY);
  }

  const middle = () => {
    const { left, top } = room.getBoundingClientRect();
    return { clientX: left + room.clientWidth / 2, clientY: top + room.clientHeight / 2 };
  };

  /** The next level in a direction. */
  function step(direction, place = middle()) {
    const now = Number(select.value);
    const level = now
      ? LEVELS[Math.min(Math.max(LEVELS.indexOf(now) + direction, 0), LEVELS.length - 1)]
      : LEVELS.find((level) => level > scale() * 1.01) ?? now;
    if (direction > 0 || now) zoomTo(level, place);
  }

  let turned = 0;
  // Before the camera: these listeners come first.
  frame.addEventListener('wheel', (event) => {
    if (!event.ctrlKey && !event.metaKey && !isHand()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    turned -= event.deltaY * (event.deltaMode === 1 ? 32 : 1);
    if (Math.abs(turned) < TURN) return;
    step(Math.sign(turned), event);
    turned = 0;
  }, { passive: false });

  frame.addEventListener('pointerdown', (event) => {
    if (!isHand() && event.button !== 1) return;
    event.stopImmediatePropagation();
    point(placeOf(frame, event));
    // Fingers scroll by themselves.
    if (event.pointerType === 'touch') return;
    event.preventDefault();
    frame.focus({ preventScroll: true });
    frame.setPointerCapture(event.pointerId);
    const move = ({ movementX, movementY }) => room.scrollBy(-movementX, -movementY);
    frame.addEventListener('pointermove', move);
    frame.addEventListener('lostpointercapture', () => frame.removeEventListener('pointermove', move), { once: true });
  });

  /** Points at a pixel beside the one that is pointed at, and scrolls there. */
  function walk(x, y) {
    const [width, height] = [canvas.width, canvas.height];
    const at = pointer() ?? [0.5, 0.5];
    const next = (share, count, by) => (Math.min(Math.max(Math.floor(share * count) + by, 0), count - 1) + 0.5) / count;
    const place = [next(at[0], width, x), next(at[1], height, y)];
    point(place);
    speak();
    const [inside, box] = [room.getBoundingClientRect(), frame.getBoundingClientRect()];
    const beyond = (share, start, length, from, to) => {
      const [at, margin] = [start + share * length, Math.min(40, (to - from) / 4)];
      return Math.min(at - from - margin, 0) + Math.max(at - to + margin, 0);
    };
    room.scrollBy(
      beyond(place[0], box.left, box.width, inside.left, inside.left + room.clientWidth),
      beyond(place[1], box.top, box.height, inside.top, inside.top + room.clientHeight),
    );
  }

  frame.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const far = event.shiftKey ? 10 : 1;
    const keys = {
      ArrowLeft: () => walk(-far, 0),
      ArrowRight: () => walk(far, 0),
      ArrowUp: () => walk(0, -far),
      ArrowDown: () => walk(0, far),
      '+': () => step(1),
      '=': () => step(1),
      '-': () => step(-1),
      0: () => zoomTo(0, middle()),
    };
    const isToggle = event.key.toLowerCase() === 'h';
    const action = isToggle ? () => { drag.value = isHand() ? 'camera' : 'picture'; mark(); } : isHand() ? keys[event.key] : null;
    if (!action) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    action();
  });

  select.addEventListener('change', () => {
    // The picture has the size of before still.
    const place = middle();
    zoomTo(Number(select.value), place);
  });
  drag.addEventListener('change', mark);
  new ResizeObserver(fit).observe(room);
  return { fit, mark };
}
