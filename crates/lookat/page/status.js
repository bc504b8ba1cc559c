// How far the picture is.

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/** @param {number} seconds */
function time(seconds) {
  if (seconds < 1) return `${Math.round(1000 * seconds)} ms`;
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 120) return `${Math.round(seconds)} s`;
  return seconds < 7200 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

/** @param {number[]} values */
const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];

/**
 * @param {(text: string) => void} say
 * @returns {(picture: import('./picture.js').Picture) => void}
 */
export function makeStatus(say) {
  /** When the pictures of a moving camera came within the last second, in milliseconds. */
  let arrivals = [];
  return ({ width, height, done, total, seconds, isFinal, isSmall }) => {
    const now = performance.now();
    arrivals = isSmall ? [...arrivals.filter((at) => now - at < 1000), now] : [];
    const size = `${width} \u00d7 ${height}`;
    const perPixel = (count) => Math.round(10 * count / (width * height)) / 10;
    const share = `${perPixel(done)} of ${perPixel(total)} samples`;
    const steps = arrivals.slice(1).map((at, i) => at - arrivals[i]);
    const pace = steps.length > 4 ? `${Math.round(median(steps))} ms per picture, ${arrivals.length} per second` : time(seconds);
    const texts = {
      moving: `moving: ${pace}, ${size}`,
      growing: `${share}, ${time(seconds)}, about ${time(seconds * (total - done) / done)} left, ${size}`,
      finished: `finished: ${share}, ${time(seconds)}, ${size}`,
    };
    $('samples').textContent = texts[isSmall ? 'moving' : isFinal ? 'finished' : 'growing'];
    $('progress').value = isSmall ? 0 : done / total;
    const all = perPixel(total);
    if (isFinal) say(`The picture is finished, with ${all} ${all === 1 ? 'sample' : 'samples'} per pixel.`);
  };
}
