import {Connection} from './connection';
import type {
  CellDescription,
  CellLooks,
  FaultList,
  ListFaultKindsResponse,
  Permission,
  ProgramStatus,
  RegisterInfo,
  ServerStatus,
  Snapshot,
  Welcome,
  WireEvents
} from './protocol';

type Listener<T> = (value: T) => void;

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

/** What the page knows of the cell, and who wants to hear of it. */
export class State {
  readonly connection = new Connection();
  cell: CellDescription | null = null;
  snapshot: Snapshot | null = null;
  welcome: Welcome | null = null;
  looks: CellLooks | null = null;
  permission: Permission | null = null;
  registerMap: RegisterInfo[] = [];
  faults: FaultList | null = null;
  programs: ProgramStatus | null = null;
  faultKinds: ListFaultKindsResponse | null = null;
  connected = false;
  retryIn_s = 0;
  refusal = ''; // what the daemon says when it takes no further viewer

  readonly cellChanged = new Signal<CellDescription>();
  readonly snapshotChanged = new Signal<Snapshot>();
  readonly accessChanged = new Signal<void>();
  readonly statusChanged = new Signal<ServerStatus>();
  readonly registersChanged = new Signal<number[]>();
  readonly faultsChanged = new Signal<FaultList>();
  readonly programsChanged = new Signal<ProgramStatus>();
  readonly faultKindsChanged = new Signal<ListFaultKindsResponse>();
  readonly wireEvents = new Signal<WireEvents>();
  /** About ten times a second, for what people read. */
  readonly display = new Signal<Snapshot>();

  private watching = {rateHz: 30, crcl: false, modbus: false, registers: false, polls: false};
  private shown = 0;

  constructor() {
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

  /** Why commands are not possible; empty when they are. */
  get lockedReason(): string {
    if (!this.connected) return this.refusal || 'No connection to the daemon.';
    if (!this.permission) return 'Waiting for the daemon.';
    return this.permission.control ? '' : this.permission.reason;
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
        this.welcome = body.value;
        break;
      case 'permission':
        this.permission = body.value;
        this.accessChanged.emit();
        break;
      case 'looks':
        this.looks = body.value;
        break;
      case 'cell':
        this.cell = body.value;
        this.snapshot = null;
        this.cellChanged.emit(body.value);
        break;
      case 'snapshot':
        this.snapshot = body.value;
        this.snapshotChanged.emit(body.value);
        if (performance.now() - this.shown > 95) {
          this.shown = performance.now();
          this.display.emit(body.value);
        }
        break;
      case 'status':
        this.statusChanged.emit(body.value);
        break;
      case 'registerMap':
        this.registerMap = body.value.registers;
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

/** Simulated time [s]. */
export function simTime(snapshot: Snapshot): number {
  const t = snapshot.simTime;
  return t ? Number(t.seconds) + t.nanos * 1e-9 : 0;
}
