import {button, h} from './dom';

export interface Shortcut {
  keys: string[];
  does: string;
  run: (key: string, held: boolean) => void;
  /** Repeats while the key is held. */
  repeats?: boolean;
}

/** Something that Escape closes; false where it was closed already. */
export type Closer = () => boolean;

const kTextless = /^(button|checkbox|color|file|image|radio|range|reset|submit)$/;

const kPressable =
  'button, summary, a[href], input, select, textarea, [contenteditable], [role=tab], [role=button]';

/** Whether the focused element itself has a meaning for this key. */
function isOwnKey(key: string, target: EventTarget | null): boolean {
  return (
    (key === ' ' || key === 'Enter') &&
    target instanceof Element &&
    target.closest(kPressable) !== null
  );
}

/** Whether the focused element takes keys as text. */
function takesText(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return !kTextless.test(target.type);
  return (
    target instanceof HTMLTextAreaElement ||
    (target instanceof HTMLElement && target.isContentEditable)
  );
}

/** Keyboard shortcuts and the list of them under "?". */
export class Shortcuts {
  /** `closers`: what Escape closes, the uppermost first, before it does anything else. */
  constructor(
    private readonly all: Shortcut[],
    private readonly closers: Closer[] = []
  ) {
    // In the capture phase: selects and sliders have meanings of their own for letters.
    addEventListener('keydown', (event) => this.press(event), {capture: true});
  }

  private find(event: KeyboardEvent): Shortcut | undefined {
    if (event.ctrlKey || event.metaKey || event.altKey || takesText(event.target)) return undefined;
    if (isOwnKey(event.key, event.target)) return undefined;
    const shortcut = this.all.find((s) => s.keys.includes(event.key));
    const busy =
      event.target instanceof HTMLSelectElement || document.querySelector('dialog[open]') !== null;
    return busy ? undefined : shortcut;
  }

  private press(event: KeyboardEvent): void {
    const shortcut = this.find(event);
    if (!shortcut) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.repeat && !shortcut.repeats) return;
    if (event.key === 'Escape' && this.closers.some((close) => close())) return;
    shortcut.run(event.key, event.repeat);
  }

  show(): void {
    const dialog = h(
      'dialog',
      {class: 'dialog', 'aria-label': 'Keyboard shortcuts', 'data-testid': 'help'},
      h('h2', {}, 'Keyboard shortcuts'),
      h(
        'dl',
        {class: 'keys'},
        ...this.all.flatMap((s) => [
          h('dt', {}, ...s.keys.map((key) => h('kbd', {}, key === ' ' ? 'space' : key))),
          h('dd', {}, s.does)
        ])
      ),
      h(
        'p',
        {},
        'Drag to turn the view, right-drag to move it, wheel or pinch to zoom, click an object for its data. Space and Enter press the focused button.'
      ),
      h(
        'div',
        {class: 'row end'},
        button('Close', () => dialog.close())
      )
    );
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
  }
}
