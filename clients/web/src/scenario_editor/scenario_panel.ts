// The scenario editor in the place of the view: timeline, properties, text and files.
import type {Schema} from '../editor/properties';
import type {Path, Value} from '../editor/scene_text';
import type {State} from '../state';
import type {Access} from '../ui/access';
import {Actions} from '../ui/actions';
import {button, card, docsLink, download, h, notify, text} from '../ui/dom';
import type {Programs} from '../ui/programs';
import type {TimedEvent} from './events';
import {fieldForm} from './field_form';
import {faultFields, killFields, orderFields, scenarioGroups, type Field} from './fields';
import {onScenarioKey} from './keys';
import {firstTarget, offeredIn, offersOf, targetFields, type Offer} from './offers';
import {ScenarioEditor} from './scenario_editor';
import {Timeline} from './timeline';

const kTyping_ms = 500;
const kNext_s = 5; // a new fault comes so long after the last event
const kNarrow = '(max-width: 900px)'; // the editor then covers the panels

export class ScenarioPanel {
  readonly element: HTMLElement;
  readonly editor: ScenarioEditor;
  private readonly timeline: Timeline;
  private schema: Schema | null = null;
  private readonly summary = h('p', {class: 'meaning', 'data-testid': 'scenario-summary'});
  private readonly complaint = h('p', {
    class: 'complaint',
    role: 'alert',
    'data-testid': 'scenario-complaint'
  });
  private readonly problems = h('ul', {
    class: 'problems',
    'data-testid': 'scenario-problems'
  });
  private readonly fileName = h('input', {
    'aria-label': 'Name of the scenario',
    'data-testid': 'scenario-file-name',
    autocomplete: 'off',
    spellcheck: 'false'
  });
  private readonly shipped = h('select', {
    'aria-label': 'Shipped scenario',
    'data-testid': 'scenario-shipped'
  });
  private readonly offers = h('select', {
    'aria-label': 'Addition',
    'data-testid': 'scenario-offer'
  });
  private readonly properties = h('div', {'data-testid': 'scenario-properties'});
  private readonly whole = h('textarea', {
    'aria-label': 'Text of the scenario',
    'data-testid': 'scenario-text',
    spellcheck: 'false',
    wrap: 'off'
  });
  private readonly seed = h('input', {
    'aria-label': 'Seed of the run',
    'data-testid': 'scenario-seed',
    inputmode: 'numeric',
    autocomplete: 'off',
    placeholder: 'seed'
  });
  private readonly file = h('input', {
    type: 'file',
    accept: '.yaml,.yml',
    'aria-label': 'Scenario file',
    'data-testid': 'scenario-file',
    hidden: true
  });
  private readonly actions = new Actions();
  private typing: ReturnType<typeof setTimeout> | null = null;
  private formOf = '';
  private offered: Offer[] = [];
  private shownGroups = new Set(['Scenario', 'End', 'Expectations']);

  constructor(
    private readonly state: State,
    private readonly access: Access,
    private readonly programs: Programs
  ) {
    const editor = (this.editor = new ScenarioEditor(state, programs));
    this.timeline = new Timeline(editor);
    this.element = h(
      'section',
      {
        class: 'editor scenario-editor',
        'aria-label': 'Scenario editor',
        tabindex: -1,
        hidden: true
      },
      this.makeHead(),
      this.summary,
      this.complaint,
      this.makeAdditions(),
      this.timeline.element,
      h(
        'div',
        {class: 'columns'},
        card('Properties', this.properties),
        card('Text', h('div', {role: 'status'}, this.problems), this.whole)
      )
    );
    editor.changed.on(() => this.update());
    state.programsChanged.on(({running, name, timeS}) =>
      this.timeline.showTime(running && name === editor.name ? timeS : 0)
    );
    state.cellChanged.on(() => editor.open && this.update());
    onScenarioKey(editor, this.element);
    this.whole.addEventListener('input', () => this.typed(kTyping_ms));
    this.whole.addEventListener('change', () => this.typed(0));
    this.file.addEventListener('change', () => void this.openFile());
    this.fileName.addEventListener('change', () => {
      editor.name = this.fileName.value.replace(/[^\w.-]/g, '_') || 'scenario';
      this.fileName.value = editor.name;
      this.update();
    });
    this.update();
  }

  /** Opens the editor, with a shipped scenario or, with an empty name, the last draft. */
  async begin(name: string): Promise<void> {
    if (await this.editor.begin(name)) this.element.focus();
    else notify(this.editor.complaint, 'error');
  }

  /** Gives up the choice, then the editor; false where it was not open. */
  close(): boolean {
    const {editor} = this;
    if (!editor.open) return false;
    if (editor.chosen) editor.choose(null);
    else editor.leave();
    return true;
  }

  // ---- parts of the editor

  private makeHead(): HTMLElement {
    const {editor} = this;
    const always = (): boolean => true;
    const run = this.access.guard(
      button('Run', () => void this.run(), {
        class: 'primary',
        'data-testid': 'scenario-run',
        title: 'Resets the cell and runs this scenario'
      }),
      () => this.runRefusal(),
      false,
      'admin'
    );
    return h(
      'div',
      {class: 'row head'},
      h('h2', {}, 'Scenario editor ', docsLink('scenarios.html', 'scenarios')),
      this.fileName,
      this.actions.add(
        'Undo',
        () => editor.undo(),
        () => editor.canUndo,
        {'data-testid': 'scenario-undo', title: 'Takes the last change back (Ctrl Z)'}
      ),
      this.actions.add(
        'Redo',
        () => editor.redo(),
        () => editor.canRedo,
        {'data-testid': 'scenario-redo', title: 'Makes the change again (Ctrl Y)'}
      ),
      this.actions.add('Save', () => this.save(), always, {
        'data-testid': 'scenario-save',
        title: 'Downloads the scenario as a file, with its comments'
      }),
      this.seed,
      run,
      h('span', {class: 'gap'}),
      this.shipped,
      this.actions.add('Open', () => void editor.begin(this.shipped.value), always, {
        'data-testid': 'scenario-open',
        title: 'Opens this shipped scenario'
      }),
      this.actions.add('Open a file', () => this.file.click(), always, {
        title: 'Edits a scenario file of yours'
      }),
      this.actions.add('New', () => editor.clear(), always, {
        'data-testid': 'scenario-new',
        title: 'Begins with an empty scenario'
      }),
      this.file,
      this.actions.add('Close', () => editor.leave(), always, {
        'data-testid': 'scenario-close',
        title: 'Shows the cell again; the draft is kept (Escape)'
      })
    );
  }

  private makeAdditions(): HTMLElement {
    const {editor} = this;
    const chosen = (): boolean => editor.chosen !== null;
    const readable = (): boolean => editor.scenario.problem === '';
    return h(
      'div',
      {class: 'row add'},
      this.offers,
      this.actions.add('Add', () => this.add(), readable, {'data-testid': 'scenario-add'}),
      this.actions.add('Copy', () => editor.copy(editor.chosen!), chosen, {
        'data-testid': 'scenario-copy',
        title: 'Adds the same, 5 s later'
      }),
      this.actions.add('Remove', () => editor.remove(editor.chosen!), chosen, {
        'data-testid': 'scenario-remove',
        title: 'Removes the chosen event (Delete)'
      })
    );
  }

  // ---- actions

  private add(): void {
    const {editor} = this;
    const offer = this.offered[Number(this.offers.value)];
    if (!offer) return;
    const begins = editor.events.map(({begin_s}) => begin_s?.[1] ?? 0);
    const after = Math.ceil((Math.max(0, ...begins) + kNext_s) / kNext_s) * kNext_s;
    // A job begins with its orders.
    const at_s = offer.list === 'orders' && editor.events.length === 0 ? 0 : after;
    editor.add(offer.list, offer.make(editor.scenario, at_s));
    if (editor.chosen) this.timeline.focus(editor.chosen);
  }

  private typed(wait_ms: number): void {
    if (this.typing) clearTimeout(this.typing);
    this.typing = setTimeout(() => {
      this.typing = null;
      this.editor.rewrite(this.whole.value);
    }, wait_ms);
  }

  private async openFile(): Promise<void> {
    const [file] = this.file.files ?? [];
    this.file.value = '';
    if (!file) return;
    this.editor.replace(
      file.name.replace(/\.ya?ml$/, '').replace(/[^\w.-]/g, '_'),
      await file.text()
    );
  }

  private save(): void {
    const {editor} = this;
    download(`${editor.name}.yaml`, new Blob([editor.text], {type: 'application/yaml'}));
    editor.noteSaved();
  }

  private runRefusal(): string {
    const {editor} = this;
    const refusal = this.programs.anyRefusal();
    if (refusal || !editor.open) return refusal;
    if (!editor.check && editor.problems.length === 0)
      return 'The daemon is checking the scenario.';
    if (editor.problems.length > 0) return 'The scenario has mistakes.';
    return editor.check?.runRefusal ?? '';
  }

  private async run(): Promise<void> {
    const typed = this.seed.value.trim();
    if (!/^\d{0,18}$/.test(typed))
      return text(this.complaint, `seed: “${typed}” is not a whole number from 0`);
    if (!(await this.editor.run(typed ? BigInt(typed) : undefined))) return;
    if (matchMedia(kNarrow).matches) this.editor.leave();
  }

  // ---- showing

  private update(): void {
    const {editor} = this;
    this.element.hidden = !editor.open;
    this.element.setAttribute('aria-busy', String(editor.busy || editor.isChecking));
    if (editor.open) {
      this.actions.update(true, editor.busy);
      text(this.complaint, editor.complaint);
      text(this.summary, this.describe());
      if (document.activeElement !== this.fileName) this.fileName.value = editor.name;
      if (this.typing === null && this.whole.value !== editor.text) this.whole.value = editor.text;
      this.listShipped();
      this.listOffers();
      this.listProblems();
      this.timeline.show();
      setTimeout(() => void this.showProperties()); // the focus has moved on then
    }
    this.access.update();
  }

  private describe(): string {
    const {editor} = this;
    const state = editor.isChanged ? 'not saved' : 'as its file';
    if (editor.problems.length > 0 && !editor.isChecking)
      return `${editor.problems.length === 1 ? 'One mistake' : `${editor.problems.length} mistakes`}, ${state}.`;
    if (!editor.check) return `Being checked, ${state}.`;
    const {kits, faults, timeLimitS, runRefusal} = editor.check;
    const count = (n: number, what: string): string => `${n} ${what}${n === 1 ? '' : 's'}`;
    return `Valid: ${count(kits, 'kit')}, ${count(faults, 'fault')}, at most ${timeLimitS} s; ${state}. ${runRefusal}`;
  }

  private listShipped(): void {
    const {names} = this.editor;
    if (this.shipped.dataset.names === names.join()) return;
    this.shipped.dataset.names = names.join();
    this.shipped.replaceChildren(
      ...names.map((name) => h('option', {value: name}, name.replaceAll('_', ' ')))
    );
  }

  private listOffers(): void {
    const {cell} = this.state;
    this.offered = cell ? offersOf(cell, this.editor.kinds) : [];
    const key = this.offered.map(({label}) => label).join();
    if (this.offers.dataset.names === key) return;
    this.offers.dataset.names = key;
    const groups = [...new Set(this.offered.map(({group}) => group))];
    this.offers.replaceChildren(
      ...groups.map((group) =>
        h(
          'optgroup',
          {label: group},
          ...this.offered.flatMap((offer, i) =>
            offer.group === group
              ? [h('option', {value: i, title: offer.meaning}, offer.label)]
              : []
          )
        )
      )
    );
  }

  private listProblems(): void {
    const {problems} = this.editor;
    this.problems.replaceChildren(
      ...problems.map(({line, message}) =>
        h(
          'li',
          {},
          line > 0
            ? button(message, () => this.goToLine(line), {class: 'link', title: 'Shows the line'})
            : message
        )
      )
    );
    this.problems.hidden = problems.length === 0;
    this.whole.setAttribute('aria-invalid', String(problems.length > 0));
  }

  private goToLine(line: number): void {
    const lines = this.whole.value.split('\n');
    const start = lines.slice(0, line - 1).reduce((sum, {length}) => sum + length + 1, 0);
    this.whole.focus();
    this.whole.setSelectionRange(start, start + (lines[line - 1]?.length ?? 0));
    const height = parseFloat(getComputedStyle(this.whole).lineHeight) || 16;
    this.whole.scrollTop = Math.max(0, (line - 3) * height);
  }

  private async showProperties(): Promise<void> {
    this.schema ??= (await (await fetch('scenario.schema.json')).json()) as Schema;
    const {editor} = this;
    const {chosen} = editor;
    const key = JSON.stringify([chosen?.id, chosen?.value, editor.text, editor.complaint]);
    if (key === this.formOf) return;
    this.formOf = key;
    const focused = (document.activeElement as HTMLElement | null)?.dataset.testid;
    this.properties.replaceChildren(
      ...(chosen ? this.eventForm(chosen) : this.wholeForm(this.schema))
    );
    if (focused?.startsWith('scenario-'))
      this.properties.querySelector<HTMLElement>(`[data-testid="${focused}"]`)?.focus();
  }

  private readonly complain = (message: string): void => text(this.complaint, message);

  private eventForm(event: TimedEvent): HTMLElement[] {
    const {editor, schema} = this;
    const {cell, faultKinds} = this.state;
    const set = (path: Path, value: Value | undefined): void =>
      editor.setField(event, path[0] === 'target' ? ['target'] : path, value);
    const form = (fields: Field[]): HTMLElement => fieldForm(fields, set, this.complain);
    const head = h('h3', {}, event.title);
    if (!cell || !schema) return [head];
    const offered = offeredIn(editor.scenario, cell, faultKinds?.quantities ?? []);
    if (event.list === 'orders') return [head, form(orderFields(event, schema, offered))];
    if (event.list === 'kill_controller') return [head, form(killFields(event, schema))];
    const kind = editor.kinds.find(({name}) => name === event.value.kind);
    return [
      head,
      h('p', {class: 'meaning'}, kind ? `${kind.meaning}.` : ''),
      fieldForm([this.kindField(event)], () => {}, this.complain),
      ...(kind ? [form(targetFields(event, kind, cell))] : []),
      form(faultFields(event, schema, kind, offered))
    ];
  }

  private kindField(event: TimedEvent): Field {
    const {editor} = this;
    const before = editor.kinds.find(({name}) => name === event.value.kind);
    return {
      path: ['kind'],
      label: 'kind',
      unit: '',
      meaning: 'Kind of the fault',
      text: String(event.value.kind ?? ''),
      placeholder: '',
      choices: editor.kinds.map(({name}) => name),
      parse: (name) => {
        const kind = editor.kinds.find((known) => known.name === name);
        const same = kind?.target === before?.target;
        const target = String(event.value.target ?? '');
        if (kind)
          editor.setKind(event, kind, same ? target : firstTarget(kind.target, this.state.cell!));
        return undefined;
      }
    };
  }

  private wholeForm(schema: Schema): HTMLElement[] {
    const {editor} = this;
    if (editor.scenario.problem)
      return [h('p', {class: 'meaning'}, 'The text cannot be read. Correct it first.')];
    return scenarioGroups(editor.scenario, schema).map(({title, fields, more}) => {
      const names = h(
        'select',
        {'aria-label': 'Measure', 'data-testid': 'scenario-measure'},
        ...(more?.names ?? []).map((name) => h('option', {value: name}, name))
      );
      const group = h(
        'details',
        {open: this.shownGroups.has(title), 'data-testid': `scenario-group-${title}`},
        h('summary', {}, title),
        fieldForm(fields, (path, value) => editor.set(path, value), this.complain),
        more &&
          h(
            'div',
            {class: 'row add'},
            names,
            button('Expect', () => editor.set([...more.path, names.value], 0), {
              'data-testid': 'scenario-expect',
              title: 'Adds an expected value of this measure'
            })
          )
      );
      group.addEventListener('toggle', () =>
        group.open ? this.shownGroups.add(title) : this.shownGroups.delete(title)
      );
      return group;
    });
  }
}
