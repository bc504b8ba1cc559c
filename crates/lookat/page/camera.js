// How gestures move a camera. Vectors are arrays of three numbers, in the world of the scene.

/**
 * A camera, as the program describes it.
 * @typedef {object} Camera
 * @property {'perspective' | 'orthographic' | 'environment' | 'realistic'} kind
 * @property {number[]} lookAt eye, target and up vector
 * @property {boolean} hasLookAt
 * @property {boolean[]} mirrored
 * @property {number | null} fov in degrees
 * @property {number | null} viewAngle of a lens system, in degrees
 * @property {number} lensDepth
 * @property {number} lensRadius
 * @property {number | null} focalDistance
 * @property {number[]} screenWindow
 * @property {number | null} time the instant, or null while the shutter is open for longer
 * @property {[number, number] | null} times of motion, or null if nothing moves
 */

/** @typedef {number[]} Vector */
/** @type {(a: Vector, b: Vector, by?: number) => Vector} */
export const add = (a, b, by = 1) => a.map((value, i) => value + by * b[i]);
/** @type {(a: Vector, b: Vector) => Vector} */
const minus = (a, b) => add(a, b, -1);
/** @type {(a: Vector, b: Vector) => number} */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @type {(a: Vector, b: Vector) => Vector} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @type {(a: Vector) => Vector} */
const unit = (a) => a.map((value) => value / Math.hypot(...a));

/**
 * Turns a vector around an axis of length one.
 * @param {Vector} v
 * @param {Vector} axis
 * @param {number} angle in radians
 */
function turn(v, axis, angle) {
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  const along = add([0, 0, 0], axis, dot(axis, v) * (1 - cos));
  return add(add(along, v, cos), cross(axis, v), sin);
}

/**
 * Eye, target and directions of a camera. Right and up are those of the screen; `distance` is that of the target.
 * @param {Camera} camera
 */
function parts({ lookAt, mirrored }) {
  const [eye, target, up] = [lookAt.slice(0, 3), lookAt.slice(3, 6), lookAt.slice(6)];
  const away = minus(target, eye);
  const forward = unit(away);
  const side = unit(cross(up, forward));
  const right = mirrored[0] ? side.map((value) => -value) : side;
  const top = cross(forward, side);
  return { eye, target, up, forward, side, right, top: mirrored[1] ? top.map((value) => -value) : top, distance: Math.hypot(...away) };
}

/** @type {(camera: Camera) => boolean} */
export const isPerspective = ({ kind }) => kind === 'perspective' || kind === 'realistic';

/**
 * The size of a unit of the screen at a distance.
 * @param {Camera} camera
 * @param {number} distance
 */
export function unitAt(camera, distance) {
  return isPerspective(camera) ? distance * Math.tan((camera.viewAngle ?? camera.fov ?? 90) * Math.PI / 360) : 1;
}

/**
 * Width and height of the screen window; negative if its edges are reversed.
 * @param {number[]} window
 */
const extent = ([x0, x1, y0, y1]) => [x1 - x0, y1 - y0];

/** @type {(camera: Camera, eye: Vector, target: Vector, up: Vector) => Camera} */
const placed = (camera, eye, target, up) => ({ ...camera, lookAt: [...eye, ...target, ...up] });

/** The angle that is kept between the direction of view and the up vector, in radians. */
const LEAST_ANGLE = 0.02;

/**
 * Orbits around a point. `x` and `y` are fractions of the width of the film to the right and down.
 * @param {Camera} camera
 * @param {Vector | null} point the target if there is none
 * @param {number} x
 * @param {number} y
 * @returns {Camera}
 */
export function orbit(camera, point, x, y) {
  const { eye, target, up, forward, side } = parts(camera);
  // A camera that sees everything turns around itself.
  const center = camera.kind === 'environment' ? eye : point ?? target;
  const [across, down] = extent(camera.screenWindow);
  const sign = (size, isMirrored) => Math.sign(size) * (isMirrored ? -1 : 1);
  const axis = unit(up);
  const angle = Math.acos(Math.min(Math.max(dot(forward, axis), -1), 1));
  const wanted = Math.PI * y * sign(down, camera.mirrored[1]);
  // Looking up makes the angle to the up vector smaller.
  const tilt = Math.min(Math.max(angle + wanted, LEAST_ANGLE), Math.PI - LEAST_ANGLE) - angle;
  const yaw = Math.PI * x * sign(across, camera.mirrored[0]);
  const move = (p) => add(center, turn(turn(minus(p, center), side, tilt), axis, yaw));
  return placed(camera, move(eye), move(target), up);
}

/**
 * Moves the camera along the film, so that what is at `distance` follows the pointer.
 * @param {Camera} camera
 * @param {number} x in fractions of the width of the film
 * @param {number} y in fractions of the height of the film, down
 * @param {number | null} distance that of the target if there is none
 * @returns {Camera}
 */
export function pan(camera, x, y, distance) {
  const view = parts(camera);
  const [across, down] = extent(camera.screenWindow);
  const size = unitAt(camera, distance ?? view.distance);
  const by = add(view.right.map((value) => -x * across * size * value), view.top, y * down * size);
  return placed(camera, add(view.eye, by), add(view.target, by), view.up);
}

/**
 * Comes nearer by a factor below 1, towards what is at the place of the film and as far away as the target. An
 * orthographic camera scales its window.
 * @param {Camera} camera
 * @param {number} factor
 * @param {number[]} at fractions of the film
 * @returns {Camera}
 */
export function dolly(camera, factor, [x, y]) {
  const [x0, x1, y0, y1] = camera.screenWindow;
  const [across, up] = [x0 + x * (x1 - x0), y1 - y * (y1 - y0)];
  if (camera.kind === 'orthographic') {
    const scaled = [x0, x1, y0, y1].map((edge, i) => (i < 2 ? across : up) + factor * (edge - (i < 2 ? across : up)));
    return { ...camera, screenWindow: scaled };
  }
  const view = parts(camera);
  const size = isPerspective(camera) ? unitAt(camera, view.distance) : 0;
  const point = add(add(view.target, view.right, across * size), view.top, up * size);
  const eye = add(view.eye, minus(point, view.eye), 1 - factor);
  return placed(camera, eye, add(eye, view.forward, view.distance * factor), view.up);
}

/**
 * Rolls the camera.
 * @param {Camera} camera
 * @param {number} angle in radians
 * @returns {Camera}
 */
export function roll(camera, angle) {
  const { eye, target, up, forward } = parts(camera);
  return placed(camera, eye, target, turn(up, forward, angle));
}

/**
 * The depth of a point: its distance along the viewing direction.
 * @param {Camera} camera
 * @param {Vector} point
 */
export function depthOf(camera, point) {
  const { eye, forward } = parts(camera);
  return dot(minus(point, eye), forward);
}
