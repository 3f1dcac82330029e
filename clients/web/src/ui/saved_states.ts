// Named states of the cell that the daemon keeps.
import type {State} from '../state';
import type {Access} from './access';
import {button, h, notify} from './dom';

export class SavedStates {
  private names: string[] = [];
  private readonly rows = h('ul', {class: 'states', 'data-testid': 'saved-states'});
  private readonly name = h('input', {
    name: 'state',
    maxlength: 64,
    'aria-label': 'Name of the state',
    placeholder: 'name',
    autocomplete: 'off',
    required: true
  });

  constructor(
    state: State,
    private readonly access: Access
  ) {
    state.statusChanged.on(({savedStates}) => {
      if (savedStates.join('\n') === this.names.join('\n')) return;
      this.names = savedStates;
      if (this.rows.isConnected) this.fill();
    });
  }

  open(): void {
    const save = h(
      'form',
      {
        class: 'row',
        onsubmit: (event: Event) => {
          event.preventDefault();
          void this.save();
        }
      },
      this.name,
      this.access.guard(h('button', {type: 'submit', 'data-testid': 'save-state'}, 'Save'))
    );
    const dialog = h(
      'dialog',
      {class: 'dialog', 'aria-label': 'Saved states'},
      h('h2', {}, 'Saved states'),
      h(
        'p',
        {},
        'A state is the whole cell, including motions in progress. The daemon keeps it until it exits.'
      ),
      save,
      this.rows,
      h(
        'div',
        {class: 'row end'},
        button('Close', () => dialog.close())
      )
    );
    dialog.addEventListener('close', () => {
      dialog.remove();
      this.access.prune();
    });
    document.body.append(dialog);
    this.fill();
    dialog.showModal();
  }

  private async save(): Promise<void> {
    const name = this.name.value.trim();
    if (!(await this.access.command({case: 'saveState', value: {name}}))) return;
    notify(`Saved as ${name}.`);
    this.names = [...new Set([...this.names, name])].sort();
    this.fill();
  }

  private async load(name: string): Promise<void> {
    if (await this.access.command({case: 'loadState', value: {name}}))
      notify(`Continued from ${name}.`);
  }

  private fill(): void {
    this.rows.replaceChildren(
      ...this.names.map((name) =>
        h(
          'li',
          {},
          h('span', {}, name),
          this.access.guard(
            button('Load', () => void this.load(name), {'aria-label': `Load ${name}`})
          )
        )
      )
    );
    if (this.names.length === 0) this.rows.replaceChildren(h('li', {}, 'No saved states.'));
    this.access.prune();
  }
}
