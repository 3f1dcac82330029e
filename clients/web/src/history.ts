import type {Snapshot} from './protocol';

export interface Readable {
  read: (s: Snapshot) => number;
}

/** Values of signals over simulated time, in order of time. */
export interface Recording {
  times: number[];
  rows: Float64Array[];
}

/** All signals over the simulated time of one epoch, from live and from requested states. */
export class SignalRecord implements Recording {
  readonly times: number[] = [];
  readonly rows: Float64Array[] = [];

  constructor(private readonly signals: Readable[]) {}

  /** Adds a state at its place in time. A time that is recorded already is ignored. */
  add(time_s: number, snapshot: Snapshot): void {
    const at = this.indexAfter(time_s);
    if (at > 0 && time_s - this.times[at - 1]! < 1e-6) return;
    const row = Float64Array.from(this.signals, (signal) => signal.read(snapshot));
    if (at === this.times.length) {
      this.times.push(time_s);
      this.rows.push(row);
    } else {
      this.times.splice(at, 0, time_s);
      this.rows.splice(at, 0, row);
    }
  }

  /** Drops rows before `oldest_s`, and rows before `fine_s` that follow another by less than `spacing_s`. */
  thin(oldest_s: number, fine_s: number, spacing_s: number): void {
    let kept = 0,
      last = -Infinity;
    for (let i = 0; i < this.times.length; ++i) {
      const time = this.times[i]!;
      if (time < oldest_s || (time < fine_s && time - last < spacing_s)) continue;
      last = time;
      this.times[kept] = time;
      this.rows[kept++] = this.rows[i]!;
    }
    this.times.length = this.rows.length = kept;
  }

  /** Rows between two times, with the nearest row on either side, so that lines reach the edges. */
  between(from_s: number, to_s: number): Recording {
    const begin = Math.max(0, this.indexAfter(from_s) - 1),
      end = this.indexAfter(to_s) + 1;
    return {times: this.times.slice(begin, end), rows: this.rows.slice(begin, end)};
  }

  /** Middle of the longest gap between two times that is longer than `least_s`; null = no such gap. */
  longestGap(from_s: number, to_s: number, least_s: number): number | null {
    if (to_s <= from_s) return null;
    let at = this.indexAfter(from_s);
    // Nothing recorded at the left edge: this edge first.
    if (at === 0 && (this.times[0] ?? Infinity) - from_s > least_s) return from_s;
    let longest = least_s,
      middle: number | null = null;
    for (let begin = this.times[Math.max(0, at - 1)]!; begin < to_s; ++at) {
      const end = this.times[at] ?? to_s;
      const a = Math.max(begin, from_s),
        b = Math.min(end, to_s);
      if (b - a > longest) {
        longest = b - a;
        middle = (a + b) / 2;
      }
      if (this.times[at] === undefined) break;
      begin = end;
    }
    return middle;
  }

  private indexAfter(time_s: number): number {
    let low = 0,
      high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle]! <= time_s + 1e-9) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

/** Values of the signal with this index; null where it has none, which charts draw as a gap. */
export function column(record: Recording, index: number): (number | null)[] {
  return record.rows.map((row) => {
    const value = row[index]!;
    return Number.isFinite(value) ? value : null;
  });
}
