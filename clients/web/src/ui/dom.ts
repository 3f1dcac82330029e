// Small helpers to build elements without inline markup, styles or scripts.
type Child = Node | string | null | undefined | false;
type Attributes = Record<string, string | number | boolean | EventListener | null | undefined>;

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === 'function') element.addEventListener(name.replace(/^on/, ''), value);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(
    ...children.filter((c): c is Node | string => c !== null && c !== undefined && c !== false)
  );
  return element;
}

/** Sets a text only where it differs, which saves the browser a layout. */
export function text(element: Element, value: string): void {
  if (element.textContent !== value) element.textContent = value;
}

export function button(
  label: string,
  onclick: () => void,
  attributes: Attributes = {}
): HTMLButtonElement {
  return h('button', {type: 'button', onclick, ...attributes}, label);
}

export function card(title: string, ...children: Child[]): HTMLElement {
  return h('section', {class: 'card'}, h('h2', {}, title), ...children);
}

/** A link to a page of the documents that explains `subject`. */
export function docsLink(page: string, subject: string): HTMLAnchorElement {
  const label = `Documentation: ${subject}`;
  return h(
    'a',
    {
      class: 'explain',
      href: `docs/${page}`,
      target: '_blank',
      rel: 'noopener',
      title: label,
      'aria-label': label
    },
    '?'
  );
}

/** A table of names and values; `set` changes a value. */
export class Facts {
  readonly element = h('dl', {class: 'facts'});
  private readonly values = new Map<string, HTMLElement>();

  set(name: string, value: string, state = ''): void {
    let cell = this.values.get(name);
    if (!cell) {
      cell = h('dd');
      this.values.set(name, cell);
      this.element.append(h('dt', {}, name), cell);
    }
    text(cell, value);
    if (cell.dataset.state !== state) cell.dataset.state = state;
  }
}

let toasts: HTMLElement | null = null;

/** Shows a short notice; errors stay longer. */
export function notify(message: string, kind: 'info' | 'error' = 'info'): void {
  toasts ??= document.body.appendChild(
    h('div', {class: 'toasts', role: 'status', 'aria-live': 'polite'})
  );
  const toast = h('div', {class: `toast ${kind}`}, message);
  toasts.append(toast);
  if (toasts.childElementCount > 4) toasts.firstElementChild?.remove();
  setTimeout(() => toast.remove(), kind === 'error' ? 7000 : 3500);
}

/** Saves a file where the browser saves files. */
export function download(name: string, content: Blob): void {
  const url = URL.createObjectURL(content);
  h('a', {href: url, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
