// Timeline of injected faults under the view: pending, active and recent ones, the latest first.
import {spansOf, timesOf, type FaultSpan} from '../injected_faults';
import type {Snapshot} from '../protocol';
import {simTime, type State} from '../state';
import {h, text} from './dom';
import {simSeconds} from './time';

const kLeast_s = 10; // least span of simulated time

interface Row {
  row: HTMLElement;
  bar: HTMLElement;
  times: HTMLElement;
}

export class FaultTimeline {
  readonly element: HTMLElement;
  private readonly list = h('ol', {'data-testid': 'fault-timeline'});
  private readonly from = h('span');
  private readonly to = h('span');
  private rows = new Map<bigint, Row>();
  private epoch = -1n;

  constructor(private readonly state: State) {
    this.element = h(
      'section',
      {class: 'fault-line', hidden: true, tabindex: 0, 'aria-label': 'Injected faults over time'},
      h(
        'div',
        {class: 'axis'},
        h('span', {}, 'injected faults'),
        h('span', {class: 'scale'}, this.from, this.to),
        h('span')
      ),
      this.list
    );
    state.display.on((snapshot) => this.show(snapshot));
  }

  private show(snapshot: Snapshot): void {
    if (!this.state.cell) return;
    const spans = spansOf(snapshot, this.state.cell).reverse();
    this.element.hidden = spans.length === 0;
    if (snapshot.epoch !== this.epoch) this.rows.clear();
    this.epoch = snapshot.epoch;
    const now = simTime(snapshot);
    const begun = spans.map(({begin_s}) => begin_s).filter((t): t is number => t !== null);
    const from = Math.max(0, Math.min(now - kLeast_s, ...begun));
    const width = Math.max(now, from + kLeast_s) - from;
    text(this.from, simSeconds(from));
    text(this.to, simSeconds(from + width));
    const rows = spans.map((span) => this.place(span, now, from, width));
    if (
      rows.some((row, i) => this.list.children[i] !== row) ||
      this.list.childElementCount > rows.length
    )
      this.list.replaceChildren(...rows);
  }

  private place(span: FaultSpan, now: number, from: number, width: number): HTMLElement {
    let entry = this.rows.get(span.id);
    if (!entry) {
      const bar = h('i');
      const times = h('small');
      const track = h('span', {class: 'track'}, bar);
      const row = h(
        'li',
        {'data-testid': `timeline-${span.id}`, title: span.details},
        h('span', {class: 'name', title: span.title}, span.title),
        track,
        times
      );
      entry = {row, bar, times};
      this.rows.set(span.id, entry);
    }
    entry.row.dataset.state = span.state;
    text(entry.times, timesOf(span));
    entry.bar.hidden = span.begin_s === null;
    if (span.begin_s !== null) {
      const end = span.end_s ?? now;
      entry.bar.style.left = `${(100 * (span.begin_s - from)) / width}%`;
      entry.bar.style.width = `${(100 * Math.max(0, end - span.begin_s)) / width}%`;
    }
    return entry.row;
  }
}
