// The scenario editor without its looks: a draft, what is chosen in it, and the daemon's checks.
import {Draft} from '../editor/draft';
import {SceneText, type Path, type Value} from '../editor/scene_text';
import type {FaultKind, ScenarioCheck} from '../protocol';
import {Signal, type State} from '../state';
import type {Programs} from '../ui/programs';
import {
  emptyScenario,
  eventsOf,
  lengthOf,
  withBegin,
  withCopy,
  withField,
  withKind,
  withLasts,
  withNew,
  without,
  withoutKey,
  type Entry,
  type List,
  type TimedEvent
} from './events';

export interface Problem {
  /** From 1; 0 = not known. */
  line: number;
  message: string;
}

/** Length that an event without one gets when it is made longer. */
const kFirstLength_s = 10;

export class ScenarioEditor {
  readonly changed = new Signal<void>();
  open = false;
  name = 'scenario';
  /** Names of the shipped scenarios. */
  names: string[] = [];
  /** Reason why the last request was refused. */
  complaint = '';
  /** Result of the check of the present text; null while there is none. */
  check: ScenarioCheck | null = null;
  problems: Problem[] = [];
  /** Longest time of the run, as last checked [s]. */
  limit_s = Infinity;
  busy = false;
  private scene = '';
  private draft: Draft | null = null;
  private saved = '';
  private parsed = new SceneText('');
  private id: string | null = null;
  private checked: string | null = null;
  private checking = false;

  constructor(
    private readonly state: State,
    private readonly programs: Programs
  ) {}

  get text(): string {
    return this.draft?.text ?? '';
  }
  get scenario(): SceneText {
    if (this.parsed.text !== this.text) this.parsed = new SceneText(this.text);
    return this.parsed;
  }
  get kinds(): FaultKind[] {
    return this.state.faultKinds?.kinds ?? [];
  }
  get events(): TimedEvent[] {
    return eventsOf(this.scenario, this.kinds);
  }
  get chosen(): TimedEvent | null {
    return this.events.find(({id}) => id === this.id) ?? null;
  }
  get canUndo(): boolean {
    return this.draft?.undoable != null;
  }
  get canRedo(): boolean {
    return this.draft?.redoable != null;
  }
  /** Neither saved as a file nor as it was opened. */
  get isChanged(): boolean {
    return this.text !== this.saved;
  }

  get isChecking(): boolean {
    return this.checking;
  }

  // ---- beginning and end

  /** Opens the editor: with a shipped scenario, or with the last draft or an empty one. */
  async begin(name = ''): Promise<boolean> {
    return this.request(async () => {
      const {connection} = this.state;
      const source = await connection.scenarioSource(name);
      this.names = source.names;
      this.scene = source.scene;
      this.open = true;
      if (name) this.replace(name, source.text);
      else if (!this.draft) this.replace('scenario', emptyScenario(source.scene));
      else this.recheck();
    });
  }

  /** Closes the editor. The draft is kept. */
  leave(): void {
    this.open = false;
    this.changed.emit();
  }

  /** Goes on with another text. Undo returns to the present one. */
  replace(name: string, text: string): void {
    if (this.draft) this.draft.change(text);
    else this.draft = new Draft(name, text);
    this.name = name;
    this.saved = text;
    this.id = null;
    this.recheck();
  }
  clear(): void {
    this.replace('scenario', emptyScenario(this.scene));
  }
  /** The text has been saved as a file. */
  noteSaved(): void {
    this.saved = this.text;
    this.changed.emit();
  }

  /** Runs the scenario in the cell. */
  run(seed?: bigint): Promise<boolean> {
    return this.request(() => this.programs.startScenario(this.name, this.text, seed));
  }

  // ---- changes

  choose(event: TimedEvent | null): void {
    if (event?.id === (this.id ?? undefined)) return;
    this.id = event?.id ?? null;
    this.changed.emit();
  }
  add(list: List, entry: Entry): void {
    this.place(() => withNew(this.scenario, list, entry));
  }
  copy(event: TimedEvent): void {
    this.place(() => withCopy(this.scenario, event));
  }
  remove(event: TimedEvent): void {
    this.id = null;
    this.change(() => without(this.scenario, event));
  }
  begins(event: TimedEvent, begin_s: number): void {
    this.change(() => withBegin(this.scenario, event, begin_s));
  }
  lasts(event: TimedEvent, lasts_s: number): void {
    this.change(() => withLasts(this.scenario, event, lasts_s));
  }
  /** Moves the chosen event. */
  shift(by_s: number): void {
    const {chosen} = this;
    if (chosen?.begin_s) this.begins(chosen, chosen.begin_s[0] + by_s);
  }
  /** Makes the chosen event longer or shorter. */
  stretch(by_s: number): void {
    const {chosen} = this;
    if (!chosen) return;
    const length_s = lengthOf(chosen);
    this.lasts(chosen, length_s === null ? kFirstLength_s : length_s + by_s);
  }
  setField(event: TimedEvent, path: Path, value: Value | undefined): void {
    this.change(() => withField(this.scenario, event, path, value));
  }
  setKind(event: TimedEvent, kind: FaultKind, target: string): void {
    this.change(() => withKind(this.scenario, event, kind, target));
  }
  /** Sets a value outside the events, or removes it. */
  set(path: Path, value: Value | undefined): void {
    this.change(() =>
      value === undefined ? withoutKey(this.scenario, path) : this.scenario.set(path, value)
    );
  }
  rewrite(text: string): void {
    this.change(() => text);
  }
  undo(): void {
    this.draft?.undo();
    this.recheck();
  }
  redo(): void {
    this.draft?.redo();
    this.recheck();
  }

  private change(next: () => string): void {
    try {
      this.draft?.change(next());
      this.complaint = '';
    } catch (problem) {
      this.complaint = (problem as Error).message;
    }
    this.recheck();
  }
  private place(make: () => {text: string; id: string}): void {
    this.change(() => {
      const {text, id} = make();
      this.id = id;
      return text;
    });
  }

  // ---- the daemon

  private async request(work: () => Promise<void>): Promise<boolean> {
    this.busy = true;
    this.complaint = '';
    this.changed.emit();
    try {
      await work();
      return true;
    } catch (problem) {
      this.complaint = (problem as Error).message;
      return false;
    } finally {
      this.busy = false;
      this.changed.emit();
    }
  }

  /** Has the present text checked; of several in waiting only the last one. */
  private recheck(): void {
    if (this.checked !== this.text) this.check = null;
    if (!this.checking) void this.checkAll();
    this.changed.emit();
  }

  private async checkAll(): Promise<void> {
    this.checking = true;
    while (this.checked !== this.text) {
      const {text} = this;
      let check: ScenarioCheck | null = null;
      let problems: Problem[] = [];
      try {
        check = await this.state.connection.checkScenario(text);
        problems = check.problems.map(({message}) => problemOf(message));
      } catch (problem) {
        problems = [{line: 0, message: (problem as Error).message}];
      }
      this.checked = text;
      if (text !== this.text) continue;
      this.check = check;
      if (check && problems.length === 0) this.limit_s = check.timeLimitS;
      this.problems = problems;
    }
    this.checking = false;
    this.changed.emit();
  }
}

/** A message of the daemon's reader, which begins with the place in the text. */
export function problemOf(message: string): Problem {
  const [, line, column, rest] = /^scenario text:(\d+):(\d+): ([^]*)$/.exec(message) ?? [];
  if (!line) return {line: 0, message};
  return {line: Number(line), message: `line ${line}, column ${column}: ${rest}`};
}
