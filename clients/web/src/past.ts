import type {HistorySpan, Moment, PastSnapshot} from './protocol';
import type {State} from './state';

/** A moment: after a step of an epoch. */
export type When = Pick<Moment, 'epoch' | 'step'>;

/** All moments that are kept as one line of numbers, from 0, a step each. */
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

  /** Null for a moment that is not kept. */
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

/** Asks for moments of the past, one at a time; of those asked for meanwhile the last one is next. */
export class PastReader {
  private busy = false;
  private wanted: {moment: When; use: (past: PastSnapshot) => void} | null = null;
  private turn = 0; // counts leave()

  constructor(
    private readonly state: State,
    private readonly onProblem: (message: string) => void
  ) {}

  ask(moment: When, use: (past: PastSnapshot) => void): void {
    this.wanted = {moment, use};
    if (!this.busy) void this.next();
  }

  /** What is on its way is not wanted any more. */
  leave(): void {
    ++this.turn;
    this.wanted = null;
  }

  get idle(): boolean {
    return !this.busy && !this.wanted;
  }

  private async next(): Promise<void> {
    this.busy = true;
    while (this.wanted) {
      const {moment, use} = this.wanted,
        turn = this.turn;
      this.wanted = null;
      try {
        const past = await this.state.connection.ask(
          {case: 'past', value: {epoch: moment.epoch, step: moment.step}},
          20000
        );
        if (past?.snapshot && turn === this.turn) use(past);
      } catch (problem) {
        if (turn === this.turn) this.onProblem((problem as Error).message);
      }
    }
    this.busy = false;
  }
}
