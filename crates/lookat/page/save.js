// Saves the picture: as it is shown, and as `render` writes it.

const $ = (id) => /** @type {any} */ (document.getElementById(id));

/**
 * @returns {(name: string, isFinal: boolean) => void} names the files after a scene; those of `render` need a finished picture
 */
export function makeSave() {
  let stem = 'picture';
  $('save-shown').addEventListener('click', () => {
    $('picture').toBlob((blob) => {
      const address = URL.createObjectURL(blob);
      Object.assign(document.createElement('a'), { href: address, download: `${stem}-shown.png` }).click();
      setTimeout(() => URL.revokeObjectURL(address), 10000);
    });
  });
  return (name, isFinal) => {
    stem = name.replace(/\.[^.]*$/, '') || 'picture';
    for (const kind of ['exr', 'png']) {
      const link = $(`save-${kind}`);
      link.download = `${stem}.${kind}`;
      // A link without an address is disabled.
      if (isFinal) link.href = `picture.${kind}`;
      else link.removeAttribute('href');
    }
  };
}
