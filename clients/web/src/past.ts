import type {Connection} from './connection';
import type {HistorySpan, Moment, PastSnapshot} from './protocol';

/** A moment: after a step of an epoch. */
export type When = Pick<Moment, 'epoch' | 'step'>;

/** All kept moments as one line of numbers from 0, one a step. */
export class MomentLine {
  constructor(private readonly spans: HistorySpan[]) {}

  get last(): number {
    return Math.max(
      0,
      this.spans.reduce((sum, {firstStep, lastStep}) => sum + Number(lastStep - firstStep) + 1, 0) -
        1
    );
  }

  at(place: number): When | null {
    let left = Math.max(0, Math.min(Math.round(place), this.last));
    for (const {epoch, firstStep, lastStep} of this.spans) {
      const steps = Number(lastStep - firstStep) + 1;
      if (left < steps) return {epoch, step: firstStep + BigInt(left)};
      left -= steps;
    }
    return null;
  }

  /** Number of a moment; null where it is not kept. */
  placeOf({epoch, step}: When): number | null {
    let before = 0;
    for (const span of this.spans) {
      if (span.epoch === epoch && step >= span.firstStep && step <= span.lastStep)
        return before + Number(step - span.firstStep);
      before += Number(span.lastStep - span.firstStep) + 1;
    }
    return null;
  }

  /** Places where another epoch begins. */
  get seams(): number[] {
    const seams: number[] = [];
    let place = 0;
    for (const {firstStep, lastStep} of this.spans) {
      if (place > 0) seams.push(place);
      place += Number(lastStep - firstStep) + 1;
    }
    return seams;
  }
}

/** A request for a moment; `use` receives null where the daemon cannot give it. */
export interface PastQuery {
  moment: When;
  use: (past: PastSnapshot | null) => void;
}

const kBackgroundPause_ms = 15;
const kPatience_ms = 120000; // a busy daemon is slow

/**
 * Reads moments of the past, one at a time: the daemon answers one query of a viewer at a time and
 * drops others. A newer query replaces one that waits. Background queries are made in between.
 * A query that the connection loses is made again after the reconnection.
 */
export class PastReader {
  onProblem: (message: string) => void = () => {};
  /** Supplies the next background query; null = none. Call `wake` when there is one again. */
  background: () => PastQuery | null = () => null;
  /** Whether the daemon takes queries now. Call `wake` when it does again. */
  ready: () => boolean = () => true;
  private busy = false;
  private endPause: () => void = () => {};
  private wanted: {moment: When; use: (past: PastSnapshot) => void} | null = null;
  private turn = 0; // counts leave()

  constructor(private readonly connection: Connection) {}

  ask(moment: When, use: (past: PastSnapshot) => void): void {
    this.wanted = {moment, use};
    this.wake();
  }

  wake(): void {
    if (!this.busy) void this.run();
    else if (this.wanted) this.endPause();
  }

  /** Discards the query that waits and the answer of the one under way. */
  leave(): void {
    ++this.turn;
    this.wanted = null;
  }

  get idle(): boolean {
    return !this.busy && !this.wanted;
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.ready()) {
      const {wanted, turn} = this;
      this.wanted = null;
      if (wanted) {
        let problem = '';
        const past = await this.read(wanted.moment, (message) => (problem = message));
        if (turn !== this.turn) continue;
        if (past) wanted.use(past);
        else if (!this.ready()) this.wanted ??= wanted;
        else if (problem) this.onProblem(problem);
        continue;
      }
      const query = this.background();
      if (!query) break;
      const begin = performance.now();
      query.use(await this.read(query.moment, () => {}));
      // Half of the time is left to others.
      const pause_ms = Math.max(kBackgroundPause_ms, performance.now() - begin);
      if (!this.wanted) await this.pause(pause_ms);
    }
    this.busy = false;
  }

  /** A pause that the next query of the user ends. */
  private async pause(longest_ms: number): Promise<void> {
    await new Promise<void>((go) => {
      this.endPause = go;
      window.setTimeout(go, longest_ms);
    });
  }

  private async read(
    {epoch, step}: When,
    onProblem: (message: string) => void
  ): Promise<PastSnapshot | null> {
    try {
      const past = await this.connection.ask({case: 'past', value: {epoch, step}}, kPatience_ms);
      return past?.snapshot ? past : null;
    } catch (problem) {
      onProblem((problem as Error).message);
      return null;
    }
  }
}
