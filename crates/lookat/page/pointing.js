// What the picture shows at a place, and changes of its parameters.

import { makeDirectives } from './parameters.js';

/** @typedef {import('./places.js').Place} Place */
/** @typedef {import('./parameters.js').Directive} Directive */
/** @typedef {{p: number[], pLookAt: number[], depth: number, shape: string, shapePlace: Place?, material: string, materialPlace: Place?, directives: Directive[]}} Hit */

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/**
 * @param {object} page
 * @param {(question: object, patience?: number) => Promise<any>} page.ask
 * @param {(place: number[]) => number[]} page.filmPlace
 * @param {ReturnType<import('./panel.js').makePanel>} page.panel
 * @param {() => ((at: object) => void) | null} page.opener
 */
export function makePointing({ ask, filmPlace, panel, opener }) {
  /** Counts the clicks: the answer to the last one counts. */
  let clicks = 0;
  /** The last place that was clicked, in fractions of the picture. @type {number[]?} */
  let clicked = null;
  /** The directives of the shape there. @type {Directive[]} */
  let pointed = [];
  /** Whether this page is changing a parameter. */
  let isChanging = false;
  /** The end of the last change: each moves the places of the next. @type {Promise<unknown>} */
  let changes = Promise.resolve();
  const directives = makeDirectives($('directives'), { change, open: opener });
  const lights = makeDirectives($('lights'), { change, open: opener });

  /**
   * What the picture shows at a place, in fractions of the picture. `null` where there is nothing, `undefined` without an answer.
   * @param {number[]} place
   * @returns {Promise<Hit | null | undefined>}
   */
  const pick = async (place) => (await ask({ type: 'pick', at: filmPlace(place) }))?.hit;

  /**
   * Shows what is at a place.
   * @param {number[]} place
   */
  async function show(place) {
    const click = ++clicks;
    const hit = await pick(place);
    if (hit === undefined || click !== clicks) return undefined;
    clicked = place;
    $('mark').hidden = false;
    $('frame').style.setProperty('--mark-x', `${100 * place[0]}%`);
    $('frame').style.setProperty('--mark-y', `${100 * place[1]}%`);
    pointed = hit?.directives ?? [];
    directives.show(pointed);
    panel.showHit(hit, opener());
    ask({ type: 'values', at: filmPlace(place) }).then((answer) => {
      if (answer && click === clicks) panel.showValues(answer.values);
    });
    return hit;
  }

  /**
   * Gives a parameter other values, after all earlier changes. Returns why not.
   * @param {() => import('./parameters.js').Change} wanted
   * @returns {Promise<string | undefined>}
   */
  function change(wanted) {
    $('edit-refused').textContent = '';
    const next = changes.then(async () => {
      isChanging = true;
      const shown = pointed.map(({ place }) => place.at);
      const changed = await ask({ type: 'change', ...wanted(), shown }, Infinity);
      isChanging = false;
      if (changed?.directives.length) {
        pointed = changed.directives;
        directives.show(pointed);
      }
      return changed ? changed.refused ?? undefined : 'The connection was lost.';
    });
    changes = next;
    return next;
  }

  return {
    pick,
    show,
    /** Shows what a new reading of the file has there. The place is known as long as the camera is the same. */
    refresh() {
      if (isChanging || !pointed.length) return;
      if (clicked && !$('mark').hidden) show(clicked);
      else directives.show(pointed = []);
    },
    /** Forgets the place: the camera has moved. */
    unmark() {
      $('mark').hidden = true;
      $('values').replaceChildren();
    },
    /** @param {Directive[]} all */
    showLights: (all) => lights.show(all),
  };
}
