// The panel of the scene editor: things, additions, properties and text.
import type {CellView, Pick} from '../scene/cell_view';
import type {Access} from '../ui/access';
import {Actions} from '../ui/actions';
import {button, card, download, h, notify, text} from '../ui/dom';
import type {State} from '../state';
import {ClearanceMeter} from './clearance';
import {DragInView} from './drag_in_view';
import {onEditorKey} from './keys';
import {propertyForm, type Schema} from './properties';
import {SceneEditor} from './scene_editor';
import {kKinds, placeOf, turns, type Thing} from './things';

const kTurn_deg = 15;

export class EditorPanel {
  readonly element: HTMLElement;
  readonly editor: SceneEditor;
  private schema: Schema | null = null;
  private readonly summary = h('p', {class: 'meaning', 'data-testid': 'editor-summary'});
  private readonly complaint = h('p', {
    class: 'complaint',
    role: 'alert',
    'data-testid': 'editor-problem'
  });
  private readonly things = h('div', {class: 'things', 'data-testid': 'editor-things'});
  private readonly offers = h('select', {'aria-label': 'Addition', 'data-testid': 'editor-offer'});
  private readonly properties = h('div', {'data-testid': 'editor-properties'});
  private readonly whole = h('textarea', {
    'aria-label': 'Text of the scene',
    'data-testid': 'editor-text',
    spellcheck: 'false',
    rows: 16
  });
  private readonly file = h('input', {
    type: 'file',
    accept: '.yaml,.yml',
    'aria-label': 'Scene file',
    'data-testid': 'editor-file',
    hidden: true
  });
  private readonly clearance = h('p', {class: 'meaning', 'data-testid': 'editor-clearance'});
  private readonly meter: ClearanceMeter;
  private readonly work: HTMLElement;
  private readonly begin: HTMLButtonElement;
  private listed = '';
  private formOf = '';

  constructor(
    private readonly state: State,
    private readonly access: Access,
    private readonly view: CellView
  ) {
    const editor = (this.editor = new SceneEditor(state));
    this.begin = access.guard(
      button('Edit', () => void editor.begin(), {
        'data-testid': 'editor-begin',
        title: 'Edits the scene of the paused cell'
      }),
      () => (editor.busy ? 'The daemon is building the cell.' : ''),
      false,
      'admin'
    );
    this.work = h(
      'div',
      {class: 'work', hidden: true},
      this.makeThings(),
      this.makeProperties(),
      this.makeText()
    );
    this.element = h(
      'div',
      {class: 'panel editor'},
      card(
        'Scene editor',
        h('div', {class: 'row'}, this.begin, ...this.makeActions()),
        this.summary,
        this.complaint
      ),
      this.work
    );
    editor.changed.on(() => this.update());
    state.display.on(() => this.showBegin());
    this.meter = new ClearanceMeter(editor, view);
    new DragInView(
      editor,
      view,
      (picks) => this.mark(picks),
      (x_m, y_m) => text(this.clearance, this.meter.describe(x_m, y_m))
    );
    onEditorKey(editor, this.element);
    this.update();
  }

  /** Whether the editor takes a pick in the view for itself. */
  takePick(pick: Pick | null): boolean {
    if (!this.editor.open) return false;
    this.editor.pick(pick);
    return true;
  }

  /** Turns the chosen thing; false where there is none. */
  turn(): boolean {
    const {chosen} = this.editor;
    if (!this.editor.open || !chosen || !turns(chosen)) return false;
    void this.editor.shift(0, 0, kTurn_deg);
    return true;
  }

  /** Gives up the choice; false where there was none. */
  close(): boolean {
    if (!this.editor.open || !this.editor.chosen) return false;
    this.editor.choose(null);
    return true;
  }

  // ---- parts of the panel

  private readonly actions = new Actions();

  private makeActions(): HTMLElement[] {
    const {editor} = this;
    const chosen = (): boolean => editor.open;
    return [
      this.actions.add(
        'Undo',
        () => void editor.undo(),
        () => editor.open && editor.canUndo,
        {
          'data-testid': 'editor-undo',
          title: 'Takes the last change back (Ctrl Z)'
        }
      ),
      this.actions.add(
        'Redo',
        () => void editor.redo(),
        () => editor.open && editor.canRedo,
        {
          'data-testid': 'editor-redo',
          title: 'Makes the change again (Ctrl Y)'
        }
      ),
      this.actions.add(
        'Apply',
        () => void this.apply(),
        () => editor.open && !editor.isApplied,
        {
          'data-testid': 'editor-apply',
          title: 'Resets the cell to this scene'
        }
      ),
      this.actions.add('Save', () => this.save(), chosen, {
        'data-testid': 'editor-save',
        title: 'Downloads the scene as a file, with its comments'
      }),
      this.actions.add('Close', () => editor.leave(), chosen, {
        'data-testid': 'editor-leave',
        title: 'Shows the cell again; the draft is kept'
      })
    ];
  }

  private makeThings(): HTMLElement {
    const {editor} = this;
    const add = (): void => {
      const offer = editor.library.offers(editor.scene)[Number(this.offers.value)];
      if (offer) void editor.add(offer);
    };
    return card(
      'Things',
      h(
        'div',
        {class: 'row add'},
        this.offers,
        this.actions.add('Add', add, () => editor.open, {
          'data-testid': 'editor-add',
          title: 'Adds this near the chosen thing, or into its first empty slot'
        })
      ),
      this.things
    );
  }

  private makeProperties(): HTMLElement {
    const {editor} = this;
    const chosen = (): boolean => editor.open && editor.chosen !== null;
    const place = (): boolean => chosen() && turns(editor.chosen!);
    return card(
      'Properties',
      this.properties,
      h(
        'div',
        {class: 'row'},
        this.actions.add('Turn left', () => void editor.shift(0, 0, kTurn_deg), place, {
          'data-testid': 'editor-turn-left',
          title: `Turns it by ${kTurn_deg}° (r)`
        }),
        this.actions.add('Turn right', () => void editor.shift(0, 0, -kTurn_deg), place, {
          'data-testid': 'editor-turn-right',
          title: `Turns it by -${kTurn_deg}° (Shift R)`
        }),
        this.actions.add(
          'Copy',
          () => void editor.copy(editor.chosen!),
          () => chosen() && !editor.chosen!.kind.single && placeOf(editor.chosen!) !== null,
          {'data-testid': 'editor-copy', title: 'Adds another one beside it'}
        ),
        this.actions.add('Remove', () => void editor.remove(editor.chosen!), chosen, {
          'data-testid': 'editor-remove',
          title: 'Removes it (Delete)'
        })
      )
    );
  }

  private makeText(): HTMLElement {
    const {editor} = this;
    this.file.addEventListener('change', () => void this.openFile());
    return h(
      'details',
      {class: 'card said', 'data-testid': 'editor-text-card'},
      h('summary', {}, 'Text and files'),
      this.whole,
      h(
        'div',
        {class: 'row'},
        this.actions.add(
          'Use this text',
          () => void editor.rewrite(this.whole.value),
          () => editor.open,
          {
            'data-testid': 'editor-use-text'
          }
        ),
        this.actions.add(
          'Open a file',
          () => this.file.click(),
          () => editor.open,
          {
            title: 'Edits a scene file of yours'
          }
        ),
        this.actions.add(
          'Empty scene',
          () => void editor.clear(),
          () => editor.open,
          {
            'data-testid': 'editor-empty',
            title: 'Begins with a floor alone'
          }
        ),
        this.file
      )
    );
  }

  // ---- files

  private async openFile(): Promise<void> {
    const [file] = this.file.files ?? [];
    this.file.value = '';
    if (file) await this.editor.replace(file.name.replace(/\.ya?ml$/, ''), await file.text());
  }

  private save(): void {
    download(
      `${this.editor.name.replace(/[^\w.-]/g, '_') || 'scene'}.yaml`,
      new Blob([this.editor.text], {type: 'application/yaml'})
    );
  }

  private async apply(): Promise<void> {
    if (await this.editor.apply()) notify('The cell is as the scene says.');
  }

  // ---- showing

  private showBegin(): void {
    const paused = this.state.live?.paused ?? false;
    text(this.begin, paused ? 'Edit' : 'Pause and edit');
    this.begin.hidden = this.editor.open;
  }

  private update(): void {
    const {editor} = this;
    this.showBegin();
    this.work.hidden = !editor.open;
    this.actions.update(editor.open, editor.busy);
    if (this.complaint.textContent !== editor.problem) text(this.complaint, editor.problem);
    text(this.summary, this.describe());
    this.element.setAttribute('aria-busy', String(editor.busy));
    if (editor.open && !editor.busy) {
      this.listThings();
      this.listOffers();
      void this.showProperties();
      if (this.whole.value !== editor.text && !editor.problem) this.whole.value = editor.text;
      this.mark(editor.chosen ? editor.picksOf(editor.chosen) : []);
      this.showClearance();
    }
    this.access.update();
  }

  private describe(): string {
    const {editor} = this;
    if (!editor.open)
      return editor.busy
        ? 'The daemon is building the cell.'
        : 'Changes are drafted beside the cell, which stays as it is until they are applied.';
    const count = editor.things.length;
    const state = editor.isApplied ? 'as in the cell' : 'not applied to the cell';
    const comments = editor.asWritten ? '' : ' The daemon composed its text: it has no comments.';
    return `${editor.name}: ${count} ${count === 1 ? 'thing' : 'things'}, ${state}.${comments}`;
  }

  private mark(picks: Pick[]): void {
    this.view.select(picks[0] ?? null);
  }

  private listThings(): void {
    const {things, chosen, refused} = this.editor;
    const key = JSON.stringify([things.map(({id}) => id), chosen?.id, refused]);
    if (key === this.listed) return;
    this.listed = key;
    const focused = this.things.contains(document.activeElement);
    const groups = kKinds.flatMap((kind) => {
      const own = things.filter((thing) => thing.kind === kind);
      if (own.length === 0) return [];
      return [
        h('h3', {}, kind.label),
        h('ul', {}, ...own.map((thing) => h('li', {}, this.entry(thing, chosen, refused))))
      ];
    });
    this.things.replaceChildren(...groups);
    if (focused)
      this.things.querySelector<HTMLElement>('[aria-pressed=true]')?.focus({preventScroll: true});
  }

  private entry(thing: Thing, chosen: Thing | null, refused: string | null): HTMLElement {
    return button(thing.name, () => this.editor.choose(thing), {
      'aria-pressed': String(thing.id === chosen?.id),
      'data-state': thing.id === refused ? 'bad' : null,
      'data-testid': `thing-${thing.id}`
    });
  }

  private reachText(thing: Thing): string {
    const reach = this.editor.reachOf(thing);
    if (reach.length === 0) return '';
    const each = reach.map(({robot, reached, slots}) => `${robot} ${reached} of ${slots}`);
    return `Slots in reach from above: ${each.join(', ')}.`;
  }

  private showClearance(): void {
    const {chosen} = this.editor;
    if (!chosen) return;
    this.meter.take(chosen);
    text(this.clearance, this.meter.describe());
  }

  private listOffers(): void {
    const offers = this.editor.library.offers(this.editor.scene);
    const names = offers.map(({kind, type}) => `${kind.key}/${type}`).join();
    if (this.offers.dataset.names === names) return;
    this.offers.dataset.names = names;
    const before = this.offers.selectedOptions[0]?.dataset.name;
    const options = offers.map(({kind, type}, i) =>
      h('option', {value: i, 'data-name': `${kind.key}/${type}`}, type || kind.label)
    );
    this.offers.replaceChildren(
      ...kKinds.flatMap((kind) => {
        const own = options.filter((_, i) => offers[i]!.kind === kind);
        return own.length > 0 ? [h('optgroup', {label: kind.label}, ...own)] : [];
      })
    );
    const same = options.find((option) => option.dataset.name === before);
    if (same) this.offers.value = same.value;
  }

  private async showProperties(): Promise<void> {
    this.schema ??= (await (await fetch('scene.schema.json')).json()) as Schema;
    const {chosen, problem} = this.editor;
    const reach = chosen ? this.reachText(chosen) : '';
    const key = JSON.stringify([chosen?.id, chosen?.value, problem, reach]);
    if (key === this.formOf) return;
    this.formOf = key;
    if (!chosen) {
      this.properties.replaceChildren(
        h('p', {class: 'meaning'}, 'Choose a thing in the view or in the list.')
      );
      return;
    }
    const list = this.schema.properties?.[chosen.kind.key];
    const focused = (document.activeElement as HTMLElement | null)?.dataset.testid;
    this.properties.replaceChildren(
      h('h3', {}, chosen.name),
      h('p', {class: 'meaning', 'data-testid': 'editor-reach'}, reach),
      this.clearance,
      propertyForm(
        chosen,
        chosen.kind.single ? list : list?.items,
        (path, value) => void this.editor.set(chosen, path, value),
        (message) => text(this.complaint, message)
      )
    );
    if (focused?.startsWith('property-'))
      this.properties.querySelector<HTMLElement>(`[data-testid="${focused}"]`)?.focus();
  }
}
