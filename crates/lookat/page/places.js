// Places of the text, as links to the editor.

/** @typedef {{at: {reading: number, file: number, start: number}, text: string, path: string, line: number, column: number}} Place */

/**
 * A link to a place. The program opens it if it knows an editor; otherwise the browser asks VS Code.
 * @param {Place} place
 * @param {((at: Place['at']) => void) | null} open
 */
export function placeLink({ at, text, path, line, column }, open) {
  const link = Object.assign(document.createElement('a'), { textContent: text, title: 'open in the editor' });
  const parts = path.replaceAll('\\', '/').replace(/^\/?/, '/').split('/').map(encodeURIComponent);
  link.href = open ? '#' : `vscode://file${parts.join('/')}:${line}:${column}`;
  if (open) {
    link.addEventListener('click', (event) => {
      event.preventDefault();
      open(at);
    });
  }
  return link;
}
