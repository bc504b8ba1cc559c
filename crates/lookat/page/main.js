// The page of `lookat view`: shows the picture, and moves the camera.

import { makeAsker } from './ask.js';
import { makeBlur } from './blur.js';
import { depthOf } from './camera.js';
import { makeComparison } from './compare.js';
import { makeDisplay } from './display.js';
import { makeEditor } from './edit.js';
import { listen } from './gestures.js';
import { makePanel } from './panel.js';
import { makePointing } from './pointing.js';
import { makeReading } from './reading.js';
import { makeSave } from './save.js';
import { connect } from './socket.js';
import { makeStatus } from './status.js';
import { makeZoom } from './zoom.js';

/** @typedef {import('./camera.js').Camera} Camera */
/** @typedef {{resolution: number[], crop: number[], samplesPerPixel: number}} Film */

const $ = (id) => /** @type {any} */ (document.getElementById(id));
const frame = $('frame');

/** What a request can set of the camera. */
const KEYS = ['lookAt', 'fov', 'lensRadius', 'focalDistance', 'screenWindow', 'time'];

/** This page, among those that show the scene. */
const me = crypto.getRandomValues(new Uint32Array(1))[0];
let number = 0;
/** @type {Film?} */
let film = null;
/** @type {Camera?} */
let camera = null;
/** The camera of the file. @type {Camera?} */
let own = null;
/** What the page sets instead of the file. @type {Record<string, unknown>} */
let set = {};
let hasEditor = false;
/** The name of the scene. */
let name = '';

// What the program tells -----------------------------------------------------------------------------------

function say(text) {
  if ($('spoken').textContent !== text) $('spoken').textContent = text;
}

/** What to do with each type of news. @type {Record<string, (news: any) => void>} */
const news = {
  scene({ name: path, messages, hasErrors, film: newFilm, filmRefused, camera: fileCamera, ...scene }) {
    name = path.split(/[\\/]/).pop();
    document.title = `${name} \u2013 lookat`;
    [$('name').textContent, $('name').title] = [name, path];
    $('error').hidden = !hasErrors;
    $('errors').textContent = hasErrors ? messages : '';
    $('trouble').textContent = `The file has errors.${newFilm ? ' This is the last picture without them.' : ''}`;
    $('texts').textContent = (!hasErrors && messages) || 'No warnings and no notes.';
    // The last line counts the messages.
    $('counts').textContent = hasErrors ? 'errors' : messages.trim().split('\n').pop()?.split(': ').pop() || 'none';
    say(hasErrors ? 'The file has errors.' : 'The file has been read.');
    if (newFilm) film = newFilm;
    own = fileCamera;
    $('film-refused').textContent = filmRefused ?? '';
    [$('undo').disabled, $('redo').disabled, $('discard').disabled] = [!scene.canUndo, !scene.canRedo, !scene.hasUnsaved];
    if (scene.hasLost) {
      $('edit-refused').textContent = 'Another program has changed the file: your unsaved changes were discarded.';
      // It shows lines that are gone.
      $('changes').close();
    }
    hasEditor = scene.hasEditor;
    $('light-count').textContent = String(scene.lights.length);
    pointing.showLights(scene.lights);
    panel.showFilm(film);
    zoom.fit();
    pointing.refresh();
  },
  view({ by, number: of, set: itsSet, camera: itsCamera, refused }) {
    $('refused').textContent = by === me && refused ? refused : '';
    // From before what this page is about to ask for, or asked for last.
    if (isAsked || (by === me && of < number)) return;
    set = Object.fromEntries(Object.entries(itsSet).filter(([, value]) => value !== null));
    if (String(camera?.lookAt) !== String(itsCamera.lookAt)) pointing.unmark();
    camera = itsCamera;
    panel.showCamera(itsCamera, own);
    updateBlur();
  },
  picked: (picked) => asker.answer(picked),
  depths: (depths) => asker.answer(depths),
  changed: (changed) => asker.answer(changed),
  edited(edited) {
    showEdited(edited, edited.by === me);
  },
  looking: (looking) => comparison.look(looking),
  compared: (compared) => comparison.compare(compared),
  values: (values) => asker.answer(values),
};

/** @param {import('./picture.js').Picture} picture */
function showPicture(picture) {
  display.take(picture);
  zoom.mark();
  reading.read();
  if (picture.content === 'reference') comparison.forget();
  if (!['growing', 'finished'].includes(picture.content)) return;
  showStatus(picture);
  nameFiles(name, picture.isFinal);
  comparison.judge();
}

// Requests -------------------------------------------------------------------------------------------------

let isAsked = false;

/**
 * Moves the camera, at most once in each frame of the display.
 * @param {Camera} newCamera
 */
function move(newCamera) {
  if (!camera) return;
  $('edit-refused').textContent = '';
  for (const key of KEYS) if (newCamera[key] !== camera[key]) set[key] = newCamera[key];
  // What is marked is elsewhere then.
  if (newCamera.lookAt !== camera.lookAt || newCamera.screenWindow !== camera.screenWindow) pointing.unmark();
  camera = newCamera;
  number++;
  panel.showCamera(newCamera, own);
  updateBlur();
  if (isAsked) return;
  isAsked = true;
  requestAnimationFrame(ask);
}

/** Sends the camera, if it waits to be sent. */
function ask() {
  if (!isAsked) return;
  isAsked = false;
  request({ type: 'view', by: me, number, camera: set });
}

function reset() {
  set = {};
  request({ type: 'view', by: me, number: ++number, camera: set });
}

/**
 * Shows what is at a place, and focuses the lens there.
 * @param {number[]} place
 */
async function click(place) {
  const hit = await pointing.show(place);
  const isFocused = hit && hit.depth > 0 && camera && camera.lensRadius > 0 && $('focus').checked;
  if (isFocused) move({ ...camera, focalDistance: hit.depth });
}

/** Opens a place in the editor, if the program knows one. */
const opener = () => (hasEditor ? (at) => request({ type: 'open', by: me, at }) : null);

// The frame ------------------------------------------------------------------------------------------------

/**
 * A place of the picture in pixels of the full film.
 * @param {number[]} place
 */
function filmPlace([x, y]) {
  const [x0, y0, x1, y1] = film?.crop ?? [0, 0, 1, 1];
  return [x0 + x * (x1 - x0), y0 + y * (y1 - y0)];
}

// The whole page -------------------------------------------------------------------------------------------

const display = makeDisplay((layer) => request({ type: 'layer', layer }));
const reading = makeReading(display, filmPlace);
// Before the gestures: what moves the picture does not move the camera.
const zoom = makeZoom({
  size: () => film && [film.crop[2] - film.crop[0], film.crop[3] - film.crop[1]],
  point: reading.point,
  pointer: reading.pointer,
  speak: () => say($('pixel').textContent),
});
const comparison = makeComparison(display, (wanted) => request(wanted), say);
const showStatus = makeStatus(say);
const nameFiles = makeSave();
const showEdited = makeEditor((action) => {
  // A field that is left by a click on a button has just changed the camera.
  ask();
  $('edit-refused').textContent = '';
  request(action === 'show' ? { type: 'show', by: me } : { type: 'edit', by: me, action });
}, say);
const panel = makePanel({
  camera: (change) => camera && move(change(camera)),
  film: (change) => request({ type: 'film', ...change }),
});
const pointing = makePointing({
  ask: (question, patience) => asker.ask(question, patience),
  filmPlace,
  panel,
  opener,
});
listen(frame, {
  camera: () => camera,
  /** The part of the film that a pixel of the page is, along x and y. */
  scale() {
    const [[x0, y0], [x1, y1]] = [filmPlace([0, 0]), filmPlace([1, 1])];
    const [width, height] = film?.resolution ?? [1, 1];
    return [(x1 - x0) / width / frame.clientWidth, (y1 - y0) / height / frame.clientHeight];
  },
  /** A place of the picture in fractions of the film. */
  place(at) {
    const [x, y] = filmPlace(at);
    const [width, height] = film?.resolution ?? [1, 1];
    return [x / width, y / height];
  },
  move,
  click,
  reset,
  async point(place) {
    const hit = await pointing.pick(place);
    return hit && camera ? { p: hit.pLookAt, depth: depthOf(camera, hit.pLookAt) } : null;
  },
  hover: reading.point,
  expose(stops) {
    $('exposure').value = Number($('exposure').value) + stops;
    $('exposure').dispatchEvent(new Event('input'));
  },
  showBlur: () => $('show-blur').click(),
});
const updateBlur = makeBlur((question) => asker.ask(question), () => (camera && film ? { camera, ...film } : null));
$('reset').addEventListener('click', reset);
$('film-reset').addEventListener('click', () => request({ type: 'film' }));
$('panel').addEventListener('submit', (event) => event.preventDefault());
reading.read();

/** @type {(request: object) => void} */
const request = connect({
  picture: showPicture,
  news: (message) => news[message.type]?.(message),
  connection(isOpen) {
    $('connection').textContent = isOpen ? 'connected' : 'connection lost';
    $('connection').toggleAttribute('data-lost', !isOpen);
    // Requests without a connection are lost: what the program tells next counts.
    if (isOpen) number = 0;
    else asker.giveUp();
  },
});
const asker = makeAsker(me, request);
