import {button, h} from './dom';

export interface Shortcut {
  keys: string[];
  does: string;
  run: (key: string, held: boolean) => void;
  /** Again and again while the key is held. */
  repeats?: boolean;
  /** Whatever has the focus, dialogs included, but fields that take text. */
  always?: boolean;
}

const kTextless = /^(button|checkbox|color|file|image|radio|range|reset|submit)$/;

/** Whether keys are text for whatever has the focus. */
function takesText(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return !kTextless.test(target.type);
  return (
    target instanceof HTMLTextAreaElement ||
    (target instanceof HTMLElement && target.isContentEditable)
  );
}

/** Keyboard shortcuts and the list of them under "?". */
export class Shortcuts {
  constructor(private readonly all: Shortcut[]) {
    // Before anything that has the focus hears of the key: it may have a meaning of its own for it.
    addEventListener('keydown', (event) => this.press(event), {capture: true});
    // Buttons take the release of the space bar for a click.
    addEventListener(
      'keyup',
      (event) => {
        if (this.find(event)?.always) swallow(event);
      },
      {capture: true}
    );
  }

  private find(event: KeyboardEvent): Shortcut | undefined {
    if (event.ctrlKey || event.metaKey || event.altKey || takesText(event.target)) return undefined;
    const shortcut = this.all.find((s) => s.keys.includes(event.key));
    if (!shortcut || shortcut.always) return shortcut;
    const busy =
      event.target instanceof HTMLSelectElement || document.querySelector('dialog[open]') !== null;
    return busy ? undefined : shortcut;
  }

  private press(event: KeyboardEvent): void {
    // The space bar has another job here.
    if (event.key === 'Enter' && (event.target as HTMLInputElement).type === 'checkbox')
      (event.target as HTMLInputElement).click();
    const shortcut = this.find(event);
    if (!shortcut) return;
    swallow(event);
    if (event.repeat && !shortcut.repeats) return;
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
        'Drag to turn the view, right-drag to move it, wheel or pinch to zoom, click an object to see what it is.'
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

function swallow(event: KeyboardEvent): void {
  event.preventDefault();
  event.stopImmediatePropagation();
}
