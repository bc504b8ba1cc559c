// Writing into the file: the lines that change are shown first.

/** @typedef {{file: string, line: number, removed: string[], added: string[]}} ChangedLines */
/** @typedef {{lines: ChangedLines[], isWritten: boolean, refused: string?}} Edited */

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/**
 * The text of a change, line by line.
 * @param {ChangedLines} changed
 */
function showLines({ file, line, removed, added }) {
  const place = Object.assign(document.createElement('p'), { textContent: `${file}:${line}` });
  const text = Object.assign(document.createElement('pre'), { tabIndex: 0 });
  for (const [sign, name, lines] of [['-', 'removed', removed], ['+', 'added', added]]) {
    for (const content of lines) {
      text.append(Object.assign(document.createElement('span'), { className: name, textContent: `${sign} ${content}\n` }));
    }
  }
  return [place, text];
}

/**
 * Makes the buttons and the dialog work.
 * @param {(action: 'show' | 'write' | 'discard' | 'undo' | 'redo') => void} ask
 * @param {(text: string) => void} say
 */
export function makeEditor(ask, say) {
  const dialog = $('changes');
  $('write').addEventListener('click', () => ask('show'));
  $('discard').addEventListener('click', () => ask('discard'));
  $('undo').addEventListener('click', () => ask('undo'));
  $('redo').addEventListener('click', () => ask('redo'));
  dialog.addEventListener('close', () => {
    if (dialog.returnValue === 'write') ask('write');
  });
  document.addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.repeat || dialog.open) return;
    const key = event.key.toLowerCase();
    // A field has an undo of its own.
    if (key !== 's' && event.target instanceof HTMLInputElement) return;
    const action = { s: 'show', z: event.shiftKey ? 'redo' : 'undo', y: 'redo' }[key];
    if (!action) return;
    event.preventDefault();
    ask(action);
  });
  /**
   * Shows the answer to an edit.
   * @param {Edited} edited
   * @param {boolean} isOwn whether this page asked
   */
  return ({ lines, isWritten, refused }, isOwn) => {
    if (!isOwn) return;
    $('edit-refused').textContent = refused ?? '';
    if (refused) return;
    if (isWritten) say('The file has been written.');
    if (!lines.length) return;
    $('lines').replaceChildren(...lines.flatMap(showLines));
    dialog.returnValue = '';
    dialog.showModal();
  };
}
