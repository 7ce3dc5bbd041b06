// Makes elements, and keeps what is shown up to date with the fewest changes.

export const part = (id) => document.getElementById(id);

// Attributes that are undefined or false are left out, and so are such children.
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== false) made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children.filter((child) => child !== false && child !== undefined && child !== null));
  return made;
}

const keyOf = (node) => node?.id || node?.getAttribute?.('data-key') || null;

// Replaces what `container` shows, only when it differs, and leaves the keyboard where it was.
export function show(container, ...children) {
  const fresh = element('div', {}, ...children);
  if (container.innerHTML === fresh.innerHTML) return;
  const key = container.contains(document.activeElement) ? keyOf(document.activeElement) : null;
  container.replaceChildren(...fresh.childNodes);
  if (key) container.querySelector(`[data-key="${CSS.escape(key)}"], #${CSS.escape(key)}`)?.focus();
}

export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// Scrolls a list to a row. The heights of rows that were never drawn are estimates, so it looks again
// when they are drawn.
export function bringIntoSight(row) {
  const scroll = () => row.scrollIntoView({ block: 'nearest' });
  scroll();
  requestAnimationFrame(() => requestAnimationFrame(scroll));
}

// A list with one row per item. Rows stay as long as their version does, so that long lists refresh
// without a flicker and without losing the keyboard.
export class KeyedList {
  #container;
  #rows = new Map();
  #key;
  #version;
  #make;

  constructor(container, { key, version, make }) {
    this.#container = container;
    [this.#key, this.#version, this.#make] = [key, version, make];
  }

  show(items) {
    const rows = new Map();
    for (const item of items) rows.set(this.#key(item), this.#rowOf(item));
    const wanted = [...rows.values()].map(({ node }) => node);
    this.#rows = rows;
    this.#arrange(wanted);
  }

  node(key) {
    return this.#rows.get(key)?.node ?? null;
  }

  #rowOf(item) {
    const version = this.#version(item);
    const known = this.#rows.get(this.#key(item));
    if (known?.version === version) return known;
    const node = this.#make(item);
    if (known?.node.contains(document.activeElement)) {
      known.node.replaceWith(node);
      node.querySelector('a, button')?.focus();
    }
    return { node, version };
  }

  #arrange(wanted) {
    const shown = this.#container.children;
    const same = shown.length === wanted.length && wanted.every((node, i) => shown[i] === node);
    if (same) return;
    const focused = this.#container.contains(document.activeElement) ? document.activeElement : null;
    this.#container.replaceChildren(...wanted);
    if (focused?.isConnected) focused.focus({ preventScroll: true });
  }
}
