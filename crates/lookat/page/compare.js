// The reference, and the verdict about it.

import { makeWipe } from './wipe.js';

/** @typedef {{hasErrors: boolean, errorsRefused: string?, reference: string?, isShown: boolean, referenceRefused: string?, file: string?}} Looking */
/** @typedef {{generation: number, text: string, agrees: boolean?}} Compared */

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/** What there is to see with a reference only. */
const NEEDS_REFERENCE = ['reference', 'wipe', 'difference'];

/** @param {string} path */
const fileName = (path) => path.split(/[\\/]/).pop() ?? path;

/**
 * @param {ReturnType<import('./display.js').makeDisplay>} display
 * @param {(request: object) => void} request
 * @param {(text: string) => void} say
 */
export function makeComparison(display, request, say) {
  /** @type {Looking?} */
  let looking = null;
  /** @type {Compared?} */
  let compared = null;

  for (const [id, from] of [['keep', 'picture'], ['use-file', 'file'], ['forget', 'nothing']]) {
    $(id).addEventListener('click', () => request({ type: 'reference', from }));
  }
  $('error-layers').addEventListener('change', () => request({ type: 'errors', isOn: $('error-layers').checked }));
  $('show').addEventListener('change', () => {
    if ($('show').value === 'errors' && !looking?.hasErrors) request({ type: 'errors', isOn: true });
  });
  makeWipe({ frame: $('frame'), handle: $('divider'), range: $('wipe'), left: 'reference' }, display.wipe);
  // The camera stays.
  $('divider').addEventListener('pointerdown', (event) => event.stopPropagation());

  /** Shows the verdict, if it is about this picture and this reference. */
  function judge() {
    const { picture } = display.pictures;
    const isNow = compared && picture?.isFinal && compared.generation === picture.generation
      && looking?.reference && !looking.referenceRefused;
    const agrees = isNow ? compared?.agrees : null;
    const words = looking?.referenceRefused ? 'There is no verdict.'
      : !looking?.reference
        ? 'Keep a picture or use a file to compare with.'
      : !isNow ? 'The verdict follows when the picture is finished.'
      : agrees === true ? 'agrees: noise explains the differences'
      : agrees === false ? 'differs by more than noise'
      : 'measured; undecided between noise and bias';
    const verdict = $('verdict');
    if (isNow && verdict.textContent !== words) say(words);
    verdict.textContent = words;
    verdict.className = agrees === true ? 'agrees' : agrees === false ? 'differs' : '';
    $('measures').textContent = isNow ? compared?.text : '';
    $('measures').parentElement.toggleAttribute('data-empty', !isNow);
  }

  return {
    judge,
    /** @param {Looking} news */
    look(news) {
      looking = news;
      const { reference, isShown, referenceRefused, file, hasErrors, errorsRefused } = news;
      $('reference').textContent = reference ? fileName(reference) : 'none';
      $('reference').title = reference ?? '';
      $('reference-refused').textContent = referenceRefused ?? errorsRefused ?? '';
      $('use-file').disabled = !file;
      $('use-file').textContent = file ? `use ${fileName(file)}` : 'use file';
      $('use-file').title = file ?? '';
      $('forget').disabled = !reference;
      $('error-layers').checked = hasErrors;
      for (const option of $('show').options) option.disabled = NEEDS_REFERENCE.includes(option.value) && !isShown;
      if (!isShown && NEEDS_REFERENCE.includes($('show').value)) $('show').value = 'picture';
      if (!isShown) display.forgetReference();
      else display.draw();
      judge();
    },
    /** Forgets the verdict about another reference. */
    forget() {
      compared = null;
      judge();
    },
    /** @param {Compared} news */
    compare(news) {
      compared = news;
      judge();
    },
  };
}
