// The divider between two pictures, moved by pointer and keys.

/**
 * @param {object} parts
 * @param {HTMLElement} parts.frame around the pictures
 * @param {HTMLElement} parts.handle what can be dragged
 * @param {HTMLInputElement} parts.range for keys; from 0 to 100
 * @param {string} parts.left the name of the picture on the left
 * @param {(percent: number) => void} show
 */
export function makeWipe({ frame, handle, range, left }, show) {
  const wipe = () => {
    const percent = Number(range.value);
    range.setAttribute('aria-valuetext', `${Math.round(percent)} % ${left}`);
    show(percent);
  };
  const drag = (event) => {
    const box = frame.getBoundingClientRect();
    range.value = String(100 * (event.clientX - box.left) / box.width);
    wipe();
  };
  range.addEventListener('input', wipe);
  handle.addEventListener('pointerdown', (event) => {
    if (event.button) return;
    handle.setPointerCapture(event.pointerId);
    drag(event);
  });
  handle.addEventListener('pointermove', (event) => {
    if (handle.hasPointerCapture(event.pointerId)) drag(event);
  });
  // After a drag, the arrow keys go on with it.
  handle.addEventListener('mousedown', (event) => {
    event.preventDefault();
    range.focus({ preventScroll: true });
  });
  wipe();
}
