import {button, h} from './dom';

export interface Shortcut {
  keys: string[];
  does: string;
  run: () => void;
}

/** Keyboard shortcuts and the list of them under "?". */
export class Shortcuts {
  constructor(private readonly all: Shortcut[]) {
    addEventListener('keydown', (event) => {
      const target = event.target as HTMLElement;
      if (
        event.ctrlKey ||
        event.metaKey ||
        event.altKey ||
        event.repeat ||
        document.querySelector('dialog[open]')
      )
        return;
      if (
        /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName) ||
        (event.key === ' ' && target.tagName === 'BUTTON')
      )
        return;
      const shortcut = this.all.find((s) => s.keys.includes(event.key));
      if (!shortcut) return;
      event.preventDefault();
      shortcut.run();
    });
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
