import {Connection} from './connection';
import {PastReader} from './past';
import type {
  Bookmark,
  CellDescription,
  CellAppearance,
  FaultList,
  HistorySpan,
  ListFaultKindsResponse,
  PastSnapshot,
  Permission,
  ProgramStatus,
  RegisterInfo,
  SceneDraft,
  ServerStatus,
  Snapshot,
  Welcome,
  WireEvents
} from './protocol';

type Listener<T> = (value: T) => void;

const kDisplay_ms = 95; // from text to text
const kRest = 4; // times as long as a display took, until the next

/** One kind of event with its listeners. */
export class Signal<T> {
  private listeners: Listener<T>[] = [];
  on(listener: Listener<T>): void {
    this.listeners.push(listener);
  }
  emit(value: T): void {
    for (const listener of this.listeners) listener(value);
  }
}

/** The state of the cell as the page knows it, with signals of its changes. */
export class State {
  readonly connection = new Connection();
  readonly pastReader = new PastReader(this.connection);
  cell: CellDescription | null = null;
  /** Shown state: the present, or a moment of the past. */
  snapshot: Snapshot | null = null;
  /** Present state. */
  live: Snapshot | null = null;
  /** Shown moment of the past; null = the present is shown. */
  past: Snapshot | null = null;
  /** A scene that is edited is shown in place of the cell. */
  draft = false;
  spans: HistorySpan[] = [];
  bookmarks: Bookmark[] = [];
  welcome: Welcome | null = null;
  /** Appearance of the shown cell. */
  appearance: CellAppearance | null = null;
  /** Description of the present cell, whatever is shown. */
  private present: {cell: CellDescription | null; appearance: CellAppearance | null} = {
    cell: null,
    appearance: null
  };
  permission: Permission | null = null;
  registerMap: RegisterInfo[] = [];
  faults: FaultList | null = null;
  programs: ProgramStatus | null = null;
  faultKinds: ListFaultKindsResponse | null = null;
  connected = false;
  retryIn_s = 0;
  refusal = ''; // reason why the daemon accepts no further viewer

  readonly cellChanged = new Signal<CellDescription>();
  readonly snapshotChanged = new Signal<Snapshot>();
  readonly accessChanged = new Signal<void>();
  readonly statusChanged = new Signal<ServerStatus>();
  readonly registerMapChanged = new Signal<void>();
  readonly registersChanged = new Signal<number[]>();
  readonly faultsChanged = new Signal<FaultList>();
  readonly programsChanged = new Signal<ProgramStatus>();
  readonly faultKindsChanged = new Signal<ListFaultKindsResponse>();
  readonly spansChanged = new Signal<HistorySpan[]>();
  readonly bookmarksChanged = new Signal<Bookmark[]>();
  /** A moment of the past is shown, or the present again (null). */
  readonly pastChanged = new Signal<Snapshot | null>();
  /** A draft is shown, or the cell again. */
  readonly draftChanged = new Signal<boolean>();
  readonly wireEvents = new Signal<WireEvents>();
  /** About ten times a second, for text. */
  readonly display = new Signal<Snapshot>();

  private returned = false; // to the daemon of before; its cell has not come yet
  private watching = {rateHz: 30, crcl: false, modbus: false, registers: false, polls: false};
  private shown = 0;
  private displayPeriod_ms = kDisplay_ms;

  constructor() {
    this.pastReader.ready = () => this.connected && this.permission !== null;
    this.connection.onUpdate = (update) => this.take(update.body);
    this.connection.onState = (connected, retryIn_s, refusal) => {
      this.connected = connected;
      this.refusal = refusal;
      this.retryIn_s = retryIn_s;
      if (connected) this.sendWatch();
      else this.permission = null;
      this.accessChanged.emit();
    };
  }

  /** Reason why no command can be sent; empty where it can. */
  get lockedReason(): string {
    return (
      this.refusedReason ||
      (this.past ? 'The past is shown: return to now first.' : '') ||
      (this.draft ? 'A draft of the scene is shown: leave the editor first.' : '')
    );
  }

  /** The same reason, regardless of the past. */
  get refusedReason(): string {
    if (!this.connected) return this.refusal || 'No connection to the daemon.';
    if (!this.permission) return 'Waiting for the daemon.';
    return this.permission.control ? '' : this.permission.reason;
  }

  /** Shows a draft of a scene, or the cell again (null). */
  showDraft(draft: SceneDraft | null): void {
    if (draft?.snapshot && draft.cell) {
      const began = !this.draft;
      if (began) this.showPast(null);
      this.draft = true;
      this.showCell(draft.cell, draft.appearance ?? null);
      this.show(draft.snapshot, true);
      if (began) this.draftChanged.emit(true);
    } else {
      if (!this.draft) return;
      this.draft = false;
      if (this.present.cell) this.showCell(this.present.cell, this.present.appearance);
      if (this.live) this.show(this.live, true);
      this.draftChanged.emit(false);
    }
    this.accessChanged.emit();
  }

  private showCell(cell: CellDescription, appearance: CellAppearance | null): void {
    this.cell = cell;
    this.appearance = appearance;
    this.snapshot = null;
    this.cellChanged.emit(cell);
  }

  /** Shows a moment of the past, or the present (null). */
  showPast(moment: PastSnapshot | null): void {
    if (moment) this.showDraft(null);
    const past = moment?.snapshot ?? null;
    if (!past && !this.past) return;
    const before = this.past;
    this.past = past;
    // The scene may have been a different one.
    if (moment?.cell) this.turnTo(moment.cell, moment.appearance ?? null);
    else this.turnTo(this.present.cell, this.present.appearance);
    const shown = past ?? this.live;
    if (shown) this.show(shown, true);
    this.pastChanged.emit(past);
    if (!before !== !past) this.accessChanged.emit();
  }

  /** Whether a moment belongs to the shown scene. */
  isOfSceneShown(moment: PastSnapshot): boolean {
    return isAlike(moment.cell ?? this.present.cell, this.cell);
  }

  private turnTo(cell: CellDescription | null, appearance: CellAppearance | null): void {
    if (cell && !isAlike(cell, this.cell)) this.showCell(cell, appearance);
  }

  private show(snapshot: Snapshot, atOnce = false): void {
    this.snapshot = snapshot;
    this.snapshotChanged.emit(snapshot);
    const begin = performance.now();
    if (atOnce || begin - this.shown > this.displayPeriod_ms) {
      this.shown = begin;
      this.display.emit(snapshot);
      // A slow page leaves most of its time to the messages that wait.
      this.displayPeriod_ms = Math.max(kDisplay_ms, kRest * (performance.now() - begin));
    }
  }

  /** Reason why this role is not given; empty where it is. */
  lacks(role: string): string {
    const roles = ['none', 'view', 'operate', 'inject', 'admin'];
    const has = this.permission?.role ?? 'none';
    return roles.indexOf(has) < roles.indexOf(role)
      ? `This needs the role ${role}; yours is ${has}.`
      : '';
  }

  watch(changes: Partial<State['watching']>): void {
    const before = JSON.stringify(this.watching);
    Object.assign(this.watching, changes);
    if (JSON.stringify(this.watching) !== before) this.sendWatch();
  }

  private sendWatch(): void {
    this.connection.send({case: 'watch', value: this.watching});
  }

  private take(body: import('./protocol').ViewerUpdate['body']): void {
    switch (body.case) {
      case 'welcome':
        this.returned = this.welcome?.instanceId === body.value.instanceId;
        this.welcome = body.value;
        break;
      case 'permission':
        this.permission = body.value;
        // Without the permission it may have been refused.
        this.sendWatch();
        this.pastReader.wake();
        this.accessChanged.emit();
        break;
      case 'appearance':
        this.present.appearance = body.value;
        break;
      case 'cell': {
        const {returned} = this;
        this.returned = false;
        this.present.cell = body.value;
        // A lost connection does not end the view of the past.
        if ((returned && this.past) || this.draft) {
          this.live = null;
          break;
        }
        this.cell = body.value;
        this.appearance = this.present.appearance;
        this.snapshot = this.live = null;
        // The shown moment belongs to a cell that has been rebuilt.
        this.showPast(null);
        this.cellChanged.emit(body.value);
        break;
      }
      case 'snapshot':
        this.live = body.value;
        if (!this.past && !this.draft) this.show(body.value);
        break;
      case 'history':
        this.spans = body.value.spans;
        this.spansChanged.emit(this.spans);
        break;
      case 'bookmarks':
        this.bookmarks = body.value.bookmarks;
        this.bookmarksChanged.emit(this.bookmarks);
        break;
      case 'status':
        this.statusChanged.emit(body.value);
        break;
      case 'registerMap':
        this.registerMap = body.value.registers;
        this.registerMapChanged.emit();
        break;
      case 'registers':
        this.registersChanged.emit(body.value.values);
        break;
      case 'wireEvents':
        this.wireEvents.emit(body.value);
        break;
      case 'faults':
        this.faults = body.value;
        this.faultsChanged.emit(body.value);
        break;
      case 'programs':
        this.programs = body.value;
        this.programsChanged.emit(body.value);
        break;
      case 'faultKinds':
        this.faultKinds = body.value;
        this.faultKindsChanged.emit(body.value);
        break;
    }
  }
}

/** Whether both show the same things, wherever these are. */
function isAlike(a: CellDescription | null, b: CellDescription | null): boolean {
  if (a === b || !a || !b) return a === b;
  const things = ({scene, bodies, tools, fixed}: CellDescription): string =>
    JSON.stringify([scene, bodies, tools, fixed], (_, value: unknown) =>
      typeof value === 'bigint' ? String(value) : value
    );
  return things(a) === things(b);
}

/** Length of a step of the simulation [s]. */
export function stepSize(cell: CellDescription | null): number {
  const step = cell?.stepSize;
  return step ? Number(step.seconds) + step.nanos * 1e-9 : 1e-3;
}

/** Simulated time [s]. */
export function simTime(snapshot: Snapshot): number {
  const t = snapshot.simTime;
  return t ? Number(t.seconds) + t.nanos * 1e-9 : 0;
}
