// Whether someone is typing into a field: then news does not change it.

/** @param {HTMLInputElement} input */
export function noteTyping(input) {
  const set = (isTyping) => () => input.toggleAttribute('data-typing', isTyping);
  input.addEventListener('input', set(true));
  // Before other listeners, which may show the old value again.
  input.addEventListener('change', set(false), { capture: true });
  input.addEventListener('blur', set(false));
}

/** @param {HTMLInputElement} input */
export const isTyping = (input) => input.hasAttribute('data-typing');
