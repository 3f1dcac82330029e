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

/** Values of the signal with this index; null where it had none, which charts take for a gap. */
export function column(record: Recording, index: number): (number | null)[] {
  return record.rows.map((row) => {
    const value = row[index]!;
    return Number.isFinite(value) ? value : null;
  });
}
