// The numbers of a pixel as text.

/**
 * A number to three digits.
 * @param {number} value
 */
export function digits(value) {
  const size = Math.abs(value);
  if (!Number.isFinite(value)) return special(value);
  if (size === 0 || size >= 100) return value.toFixed(0);
  return size < 0.001 ? value.toExponential(2) : value.toPrecision(3);
}

/**
 * The shortest text of a 32-bit float that no other one has.
 * @param {number} value
 */
export function full(value) {
  if (!Number.isFinite(value)) return special(value);
  for (let count = 1; count < 9; count++) {
    const text = value.toPrecision(count);
    if (Math.fround(Number(text)) === value) return String(Number(text));
  }
  return String(Number(value.toPrecision(9)));
}

/** @param {number} value */
const special = (value) => (Number.isNaN(value) ? 'NaN' : value > 0 ? '\u221e' : '-\u221e');

/**
 * A name and the numbers after it.
 * @param {string} label
 * @param {string[]} texts
 */
export function part(label, texts) {
  const span = document.createElement('span');
  span.append(Object.assign(document.createElement('small'), { textContent: label }));
  span.append(texts.map((text) => ` ${text.padEnd(8)}`).join(''));
  return span;
}
