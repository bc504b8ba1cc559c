// From linear values to what a display gets: exposure, tone curve, sRGB.

/** The least linear value that sRGB rounds to each of its 256 levels. */
const LEAST = Float64Array.from({ length: 257 }, (_, level) => {
  const encoded = (level - 0.5) / 255;
  if (level === 0 || level === 256) return level ? Infinity : -Infinity;
  return encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
});

/** The level at the start of each 65536th of 0..1. None has more than one level within. */
const LEVEL = new Uint8Array(65536);
for (let i = 0, level = 0; i < 65536; i++) {
  while (i / 65536 >= LEAST[level + 1]) level++;
  LEVEL[i] = level;
}

/**
 * The sRGB level, 0..255, of a linear value.
 * @param {number} value
 */
export function srgb(value) {
  if (!(value > 0)) return 0;
  if (value >= 1) return 255;
  const level = LEVEL[value * 65536 | 0];
  return value >= LEAST[level + 1] ? level + 1 : level;
}

/**
 * A color as canvases have it in memory.
 * @param {number} red
 * @param {number} green
 * @param {number} blue
 */
export function rgba(red, green, blue) {
  return (255 << 24 | blue << 16 | green << 8 | red) >>> 0;
}
