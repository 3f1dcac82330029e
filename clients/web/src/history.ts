import type {Snapshot} from './protocol';

export interface Readable {
  read: (s: Snapshot) => number;
}

/** Values of signals over simulated time; what it holds never changes under who keeps it. */
export interface Recording {
  times: number[];
  rows: Float64Array[];
}

/**
 * What every signal was over the last while of simulated time, whether it is shown or not. Starts
 * anew when the time goes back: a reset, a saved state.
 */
export class History {
  private readonly times: number[] = [];
  private readonly rows: Float64Array[] = [];

  constructor(
    private readonly signals: Readable[],
    private readonly span_s: number,
    private readonly maxRows: number
  ) {}

  take(time_s: number, snapshot: Snapshot): void {
    const last = this.times[this.times.length - 1];
    if (last !== undefined && time_s === last) return;
    if (last !== undefined && time_s < last) this.drop(this.times.length);
    this.times.push(time_s);
    this.rows.push(Float64Array.from(this.signals, (signal) => signal.read(snapshot)));
    let old = Math.max(0, this.times.length - this.maxRows);
    while (this.times[old]! < time_s - this.span_s) ++old;
    // In lumps: each moves all that stays.
    if (old > 200 || this.times.length > this.maxRows) this.drop(old);
  }

  private drop(count: number): void {
    this.times.splice(0, count);
    this.rows.splice(0, count);
  }

  /** All of it as it is now. */
  copy(): Recording {
    return {times: [...this.times], rows: [...this.rows]};
  }

  /** What it is now; changes with it. */
  get live(): Recording {
    return {times: this.times, rows: this.rows};
  }
}

/**
 * What signals were around a moment of the past: what was recorded live, and what is shown or asked
 * for since. Of one epoch.
 */
export class PastRecording implements Recording {
  readonly times: number[];
  readonly rows: Float64Array[];

  constructor(
    private readonly signals: Readable[],
    known: Recording
  ) {
    this.times = [...known.times];
    this.rows = [...known.rows];
  }

  add(time_s: number, snapshot: Snapshot): void {
    const at = this.indexAfter(time_s);
    if (at > 0 && time_s - this.times[at - 1]! < 1e-6) return;
    this.times.splice(at, 0, time_s);
    this.rows.splice(
      at,
      0,
      Float64Array.from(this.signals, (signal) => signal.read(snapshot))
    );
  }

  /** Whether nothing is known within half of `span_s` about a time. */
  lacks(time_s: number, span_s: number): boolean {
    const at = this.indexAfter(time_s);
    const near = (i: number): boolean =>
      this.times[i] !== undefined && Math.abs(this.times[i]! - time_s) <= span_s / 2;
    return !near(at - 1) && !near(at);
  }

  /** What lies between two times. */
  between(from_s: number, to_s: number): Recording {
    const begin = this.indexAfter(from_s - 1e-9),
      end = this.indexAfter(to_s + 1e-9);
    return {times: this.times.slice(begin, end), rows: this.rows.slice(begin, end)};
  }

  private indexAfter(time_s: number): number {
    let low = 0,
      high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle]! <= time_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

/** Values of the signal with this index; null where it had none, which charts take for a gap. */
export function column(record: Recording, index: number): (number | null)[] {
  return record.rows.map((row) => {
    const value = row[index]!;
    return Number.isFinite(value) ? value : null;
  });
}
