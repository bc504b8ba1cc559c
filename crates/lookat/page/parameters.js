// Fields for the parameters of directives, from the schema of the format.

import { placeLink } from './places.js';
import { srgb } from './tone.js';
import { isTyping, noteTyping } from './typing.js';

/** @typedef {{name: string, type: string, count: number | null, texture: boolean, default: string, range: string?, unit: string?, meaning: string}} Facts */
/** @typedef {{facts: Facts, given: {type: string, values: (number | string)[]} | null}} Parameter */
/** @typedef {{directive: string, kind: string, name: string?, place: import('./places.js').Place, parameters: Parameter[]}} Directive */
/** @typedef {{at: object, name: string, valueType: string, values: (number | string)[]}} Change */

const make = (name, properties = {}) => Object.assign(document.createElement(name), properties);
const short = (value) => String(Number(value.toPrecision(5)));

/** The numbers of a value of each type. */
const SIZES = { rgb: 3, xyz: 3, point3: 3, vector3: 3, normal: 3, point2: 2, vector2: 2, blackbody: 2 };
const NAMES = { 2: ['x', 'y'], 3: ['x', 'y', 'z'], 4: ['1', '2', '3', '4'] };

/** The linear value of an sRGB level. */
function linear(level) {
  const encoded = level / 255;
  return encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
}

/** A color for people, and how much brighter the values are. */
function shownColor(values) {
  const scale = Math.max(...values, 1);
  const hex = values.map((value) => srgb(value / scale).toString(16).padStart(2, '0'));
  return { color: `#${hex.join('')}`, scale };
}

/**
 * The fields of a parameter: what they show, and what they give.
 * @param {Facts} facts
 * @param {(values: (number | string)[]) => void} give
 */
function makeInputs(facts, give) {
  const label = (input, part = '') => input.setAttribute('aria-label', `${facts.name} ${part}`.trim());
  if (facts.type === 'bool') {
    const input = make('input', { type: 'checkbox' });
    label(input);
    input.addEventListener('change', () => give([String(input.checked)]));
    return { parts: [input], show: (values) => { input.checked = (values?.[0] ?? facts.default) === 'true'; } };
  }
  if (facts.type === 'string') {
    const words = [...(facts.range ?? '').matchAll(/"([^"]*)"/g)].map((match) => match[1]);
    // A page names no files.
    const input = words.length ? make('select') : make('input', { type: 'text', readOnly: true, title: 'to be changed in the file' });
    input.append(...words.map((word) => make('option', { textContent: word })));
    label(input);
    input.addEventListener('change', () => give([input.value]));
    const standard = facts.default.replaceAll('"', '');
    return { parts: [input], show: (values) => { input.value = values?.[0] ?? (words.length ? standard : ''); } };
  }
  return makeNumbers(facts, give, label);
}

/** Fields for numbers: with a color, or with a slider for a single one. */
function makeNumbers(facts, give, label) {
  const size = (SIZES[facts.type] ?? 1) * (facts.count ?? 1);
  const isColor = facts.type === 'rgb';
  const names = isColor ? ['red', 'green', 'blue'] : NAMES[size] ?? [''];
  const inputs = names.map((name) => {
    const input = make('input', { type: 'number', step: 'any', title: name });
    label(input, name);
    noteTyping(input);
    return input;
  });
  /** The values with all their digits. @type {number[]?} */
  let current = null;
  /** The defaults as far as they are numbers: one for each field, or one for all. */
  const standard = facts.default.split(' ').map(Number);
  const standardOf = (index) => standard[index] ?? standard[0];
  inputs.forEach((input, index) => { input.placeholder = Number.isFinite(standardOf(index)) ? short(standardOf(index)) : facts.default; });
  const hasSlider = size === 1 && facts.type === 'float' && Number.isFinite(standardOf(0));
  const extra = isColor ? make('input', { type: 'color' }) : hasSlider ? make('input', { type: 'range', step: 'any', min: '0' }) : null;
  if (extra) label(extra, extra.type === 'color' ? 'color' : 'slider');
  let scale = 1;
  /** @param {number[]?} values */
  const show = (values) => {
    current = values;
    inputs.forEach((input, index) => {
      if (!isTyping(input)) input.value = values ? short(values[index]) : '';
    });
    const shown = values ?? inputs.map((_, index) => standardOf(index));
    if (!extra || !shown.every(Number.isFinite)) return;
    if (isColor) [extra.value, scale] = Object.values(shownColor(shown));
    else if (extra !== document.activeElement) {
      extra.max = String(facts.unit === 'degrees' ? 180 : Math.max(1, 2 * shown[0]));
      extra.value = String(shown[0]);
    }
  };
  inputs.forEach((input, index) => input.addEventListener('change', () => {
    const value = input.valueAsNumber;
    if (!Number.isFinite(value)) return show(current);
    // What is not given starts at the default, or at the number that is.
    return give(inputs.map((_, at) => (at === index ? value : [current?.[at], standardOf(at), value].find(Number.isFinite))));
  }));
  extra?.addEventListener('input', () => {
    const levels = [1, 3, 5].map((at) => parseInt(extra.value.slice(at, at + 2), 16));
    give(isColor ? levels.map((level) => Number(short(scale * linear(level)))) : [Number(short(extra.valueAsNumber))]);
  });
  return { parts: [...(extra ? [extra] : []), ...inputs], show };
}

/**
 * Shows directives with a field for each parameter, and keeps them up to date.
 * @param {HTMLElement} place
 * @param {{change: (change: () => Change) => Promise<string | undefined>, open: () => ((at: object) => void) | null}} act
 */
export function makeDirectives(place, act) {
  const remark = make('p', { className: 'remark' });
  remark.setAttribute('role', 'status');
  /** What is shown, by directive, type and line; the fields stay as long as it is the same. */
  let [key, sections] = ['', /** @type {((directive: Directive) => void)[]} */ ([])];
  /** The newest change of each parameter that waits for the one before it. @type {Map<string, () => Change>} */
  const waiting = new Map();
  let isBusy = false;

  /** Sends changes one after another, because each moves the places of the next. */
  async function send(name, change) {
    waiting.set(name, change);
    if (isBusy) return;
    isBusy = true;
    while (waiting.size) {
      const [first, next] = /** @type {[string, () => Change]} */ (waiting.entries().next().value);
      waiting.delete(first);
      remark.textContent = (await act.change(next)) ?? '';
      if (remark.textContent) remark.scrollIntoView({ block: 'nearest' });
    }
    isBusy = false;
  }

  /** The section of a directive: a function that shows its values. */
  function makeSection(number, { directive, kind, name, parameters }) {
    const title = make('h3', { textContent: `${directive} "${name ?? kind}"${name ? `, ${kind}` : ''} ` });
    const link = make('small');
    title.append(link);
    place.append(title);
    let current;
    const rows = parameters.map(({ facts }) => {
      const give = (values) => send(`${number} ${facts.name}`, () => ({ at: current.place.at, name: facts.name, valueType: facts.type, values }));
      const { parts, show } = makeInputs(facts, give);
      const [field, numbers, words] = [make('div', { className: 'field' }), make('div', { className: 'numbers' }), make('small')];
      const label = make('span', { textContent: facts.name, title: [facts.meaning, facts.range, facts.unit].filter(Boolean).join(', ') });
      numbers.append(...parts);
      field.append(label, numbers, words);
      place.append(field);
      return (given) => {
        const isOther = given && given.type !== facts.type;
        words.hidden = !isOther;
        numbers.toggleAttribute('data-other', Boolean(isOther));
        words.textContent = isOther ? `${given.type} ${given.values.slice(0, 8).join(' ')}` : '';
        field.toggleAttribute('data-default', !given);
        show(given && !isOther ? given.values : null);
      };
    });
    return (described) => {
      current = described;
      link.replaceChildren(placeLink(described.place, act.open()));
      rows.forEach((row, index) => row(described.parameters[index].given));
    };
  }

  return {
    /** @param {Directive[]} directives */
    show(directives) {
      const newKey = directives.map(({ directive, kind, name, place: at }) => `${directive} ${kind} ${name} ${at.path}:${at.line}`).join('\n');
      if (newKey !== key) {
        key = newKey;
        place.replaceChildren();
        sections = directives.map((directive, number) => makeSection(number, directive));
        place.append(remark);
        remark.textContent = '';
      }
      sections.forEach((section, index) => section(directives[index]));
    },
  };
}
