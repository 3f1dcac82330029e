// The injected faults of a snapshot as text, with simulated times.
import {
  InjectedFaultState,
  type CellDescription,
  type InjectedFault,
  type Snapshot
} from './protocol';
import {stepSize} from './state';
import {simSeconds} from './ui/time';

export interface FaultSpan {
  id: bigint;
  title: string; // kind and target
  state: 'waits' | 'lasts' | 'over';
  begin_s: number | null; // null: not begun
  end_s: number | null; // null: not ended
  trigger: string; // condition of its begin; empty: none
  details: string; // parameters and note
}

/** Faults in the order of their injection. */
export function spansOf(snapshot: Snapshot, cell: CellDescription): FaultSpan[] {
  const step_s = stepSize(cell);
  const time = (step: bigint | undefined): number | null =>
    step === undefined ? null : Number(step) * step_s;
  return snapshot.injectedFaults.map((fault) => ({
    id: fault.id,
    title: `${fault.kind} ${fault.target}`.trim(),
    state:
      fault.state === InjectedFaultState.PENDING
        ? 'waits'
        : fault.state === InjectedFaultState.ACTIVE
          ? 'lasts'
          : 'over',
    begin_s: time(fault.beginStep),
    end_s: time(fault.endStep),
    trigger: fault.trigger,
    details: [parametersOf(fault), fault.note].filter(Boolean).join('; ')
  }));
}

function parametersOf(fault: InjectedFault): string {
  return Object.entries(fault.parameters)
    .map(([name, value]) => `${name} ${Number(value.toPrecision(6))}`)
    .join(', ');
}

/** Begin and end in simulated time. */
export function timesOf(span: FaultSpan): string {
  const at = simSeconds;
  if (span.state === 'waits') return span.trigger ? `waits, ${span.trigger}` : 'waits';
  if (span.begin_s === null) return 'cancelled before it began';
  const begin = at(span.begin_s) + (span.trigger ? `, ${span.trigger}` : '');
  if (span.end_s === null) return `since ${begin}`;
  return span.end_s > span.begin_s ? `${begin}, to ${at(span.end_s)}` : `at ${begin}`;
}
