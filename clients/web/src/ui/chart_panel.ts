// Charts of any signals over simulated time: live, paused, zoomed, and back to where the daemon's
// history begins.
import {column, SignalRecord, type Recording} from '../history';
import type {PastQuery} from '../past';
import type {HistorySpan, Snapshot} from '../protocol';
import {simTime, stepSize, type State} from '../state';
import {Chart, type ChartHost, type Range} from './chart';
import {button, card, download, h, text} from './dom';
import {signalsOf, type ChartSignal} from './signals';
import {suggest} from './suggest';

const kSpans_s = [10, 60, 600];
const kLeastSpan_s = 1; // that is shown at the start of a run
const kMaxCharts = 6;
const kDrawPeriod_ms = 100;
const kRest = 5; // times as long as drawing took, before it is done again
const kFine_s = 60; // live rows of this last while are all kept
const kCoarse_s = 0.1; // from row to row before that
const kThinEvery = 300; // rows
const kPoints = 240; // that the daemon is asked for over the width of a chart
const kMaxEpochs = 4; // that are recorded
const kRetry_ms = 2000; // after a query that failed

export class ChartPanel implements ChartHost {
  readonly element = h('div', {class: 'panel charts'});
  /** Asks for a moment to be shown, of the epoch that the charts show. */
  onMoment: (epoch: bigint, time_s: number) => void = () => {};
  private readonly list = h('div', {class: 'strips'});
  private readonly choice = h('input', {
    type: 'search',
    list: 'signals',
    placeholder: 'Add a signal …',
    'aria-label': 'Signal to chart',
    'data-testid': 'chart-choice'
  });
  private readonly names = h('datalist', {id: 'signals'});
  private readonly target = h('select', {
    'aria-label': 'Chart to add the signal to',
    'data-testid': 'chart-target'
  });
  private readonly span = h(
    'select',
    {'aria-label': 'Span of time', title: 'Span of simulated time', 'data-testid': 'chart-span'},
    ...kSpans_s.map((span) =>
      h('option', {value: span}, span < 60 ? `${span} s` : `${span / 60} min`)
    )
  );
  private readonly complaint = h('p', {
    class: 'complaint',
    role: 'alert',
    'data-testid': 'chart-complaint'
  });
  private readonly pauseButton = button('Pause', () => this.pause(), {
    'data-testid': 'chart-pause'
  });
  private signals: ChartSignal[] = [];
  private charts: Chart[] = [];
  private records = new Map<bigint, SignalRecord>();
  private fixed: Range | null = null; // paused or zoomed
  private drawn = 0;
  private period_ms = kDrawPeriod_ms;
  private timer = 0;
  private added = 0;
  private failed = -Infinity; // when a query failed

  constructor(private readonly state: State) {
    this.span.value = '60';
    this.span.addEventListener('change', () => this.zoom(null));
    this.choice.addEventListener('change', () => this.choose(this.choice.value));
    this.choice.addEventListener('input', () => this.complaint.replaceChildren());
    this.element.append(
      card(
        'Charts',
        h('div', {class: 'row'}, this.choice, this.names, 'in', this.target),
        h(
          'div',
          {class: 'row'},
          this.span,
          button('−', () => this.scale(2), {'aria-label': 'Zoom out', title: 'Zoom out'}),
          button('+', () => this.scale(0.5), {
            'aria-label': 'Zoom in',
            title: 'Zoom in; or drag over a chart, or turn the wheel with Ctrl',
            'data-testid': 'chart-zoom-in'
          }),
          this.pauseButton,
          button('CSV', () => this.save(), {title: 'Save the shown values'})
        ),
        this.complaint,
        this.list
      )
    );
    state.cellChanged.on(() => this.build());
    state.snapshotChanged.on((snapshot) => this.take(snapshot));
    state.pastChanged.on(() => this.drawSoon());
    state.spansChanged.on(() => state.pastReader.wake());
    state.pastReader.background = () => this.nextQuery();
    new ResizeObserver(() => {
      this.charts.forEach((chart) => chart.resize());
      this.draw();
      state.pastReader.wake();
    }).observe(this.list);
  }

  // ---- what the charts ask for

  get range(): Range {
    if (this.fixed) return this.fixed;
    const {snapshot, past} = this.state;
    const now = snapshot ? simTime(snapshot) : 0;
    const span = Number(this.span.value);
    if (past) return {from_s: now - span / 2, to_s: now + span / 2};
    const from_s = Math.max(now - span, Math.min(this.oldest_s, now - kLeastSpan_s));
    return {from_s, to_s: now};
  }

  /** When the values begin that the daemon keeps or this page has recorded. */
  private get oldest_s(): number {
    const recorded = this.record?.times[0] ?? Infinity;
    const {kept} = this;
    return kept ? Math.min(recorded, Number(kept.firstStep) * stepSize(this.state.cell)) : recorded;
  }

  private get kept(): HistorySpan | undefined {
    return this.state.spans.find(({epoch}) => epoch === this.state.snapshot?.epoch);
  }

  get recording(): Recording {
    const {from_s, to_s} = this.range;
    return this.record?.between(from_s, to_s) ?? {times: [], rows: []};
  }

  get moment(): ChartHost['moment'] {
    const {past} = this.state;
    return past && {time_s: simTime(past), value: (signal) => signal.read(past)};
  }

  indexOf(signal: ChartSignal): number {
    return this.signals.indexOf(signal);
  }

  goTo(time_s: number): void {
    const {snapshot} = this.state;
    if (snapshot) this.onMoment(snapshot.epoch, Math.max(0, time_s));
  }

  /** Null: the chosen span again, up to now. */
  zoom(range: Range | null): void {
    const least_s = 10 * stepSize(this.state.cell);
    this.fixed = range && range.to_s - range.from_s >= least_s ? range : range && this.range;
    text(this.pauseButton, this.fixed ? 'Follow' : 'Pause');
    this.draw();
    this.state.pastReader.wake();
  }

  remove(chart: Chart): void {
    chart.destroy();
    this.charts = this.charts.filter((other) => other !== chart);
    this.offerTargets();
  }

  private scale(factor: number): void {
    const {from_s, to_s} = this.range;
    const half = (factor * (to_s - from_s)) / 2,
      middle = (from_s + to_s) / 2;
    // Live charts keep their right edge.
    if (this.fixed || this.state.past) this.zoom({from_s: middle - half, to_s: middle + half});
    else this.zoom({from_s: to_s - 2 * half, to_s});
  }

  private pause(): void {
    this.zoom(this.fixed ? null : this.range);
  }

  // ---- signals

  private build(): void {
    const {cell} = this.state;
    if (!cell) return;
    this.signals = signalsOf(cell);
    this.records.clear();
    this.fixed = null;
    text(this.pauseButton, 'Pause');
    this.names.replaceChildren(...this.signals.map((s) => h('option', {value: s.name})));
    const groups = this.charts.length
      ? this.charts.map((chart) => chart.signals.map((s) => s.name))
      : [
          cell.robots.map(({name}) => `${name} tool z`),
          [1, 2].map((finger) => `${cell.robots[0]?.name} gripper force ${finger}`),
          ['step time']
        ];
    this.charts.forEach((chart) => chart.destroy());
    this.charts = [];
    for (const names of groups) {
      const found = names
        .map((name) => this.signals.find((s) => s.name === name))
        .filter((s): s is ChartSignal => s !== undefined);
      if (found.length === 0) continue;
      const chart = this.newChart();
      for (const signal of found) chart.add(signal);
    }
    this.offerTargets();
  }

  private newChart(): Chart {
    const chart = new Chart(this, this.charts.length);
    this.list.append(chart.element);
    this.charts.push(chart);
    return chart;
  }

  private offerTargets(): void {
    const before = this.target.value;
    this.target.replaceChildren(
      h('option', {value: ''}, 'new chart'),
      ...this.charts.map((_, i) => h('option', {value: i}, `chart ${i + 1}`))
    );
    this.target.value = Number(before) < this.charts.length ? before : '';
  }

  /** Adds the signal of this name; an unknown name gets suggestions. */
  private choose(typed: string): void {
    const name = typed.trim().toLowerCase();
    this.complaint.replaceChildren();
    if (!name) return;
    const signal = this.signals.find((s) => s.name.toLowerCase() === name);
    if (!signal) return this.suggest(typed.trim());
    const problem = this.add(signal);
    text(this.complaint, problem);
    if (!problem) this.choice.value = '';
  }

  private add(signal: ChartSignal): string {
    const chosen = this.charts[this.target.value === '' ? -1 : Number(this.target.value)];
    if (chosen) return chosen.add(signal);
    if (this.charts.length >= kMaxCharts)
      return `There are at most ${kMaxCharts} charts; add to one of them or remove one.`;
    const problem = this.newChart().add(signal);
    this.offerTargets();
    return problem;
  }

  private suggest(typed: string): void {
    const meant = suggest(
      typed.toLowerCase(),
      this.signals.map((s) => s.name)
    );
    this.complaint.append(
      `There is no signal “${typed}”.`,
      ...(meant.length ? [' Did you mean '] : [' Try a robot’s name, “belt”, “tool”, “J1”.']),
      ...meant.flatMap((other, i) => [
        i === 0 ? '' : i === meant.length - 1 ? ' or ' : ', ',
        button(other, () => this.choose(other), {class: 'link'})
      ]),
      meant.length ? '?' : ''
    );
  }

  // ---- values

  private get record(): SignalRecord | undefined {
    const {snapshot} = this.state;
    return snapshot ? this.records.get(snapshot.epoch) : undefined;
  }

  private take(snapshot: Snapshot): void {
    if (this.state.draft) return;
    const record = this.recordOf(snapshot.epoch);
    record.add(simTime(snapshot), snapshot);
    const {past, live} = this.state;
    if (!past && live?.epoch === snapshot.epoch && ++this.added % kThinEvery === 0) {
      const now = simTime(snapshot);
      record.thin(now - 1.1 * kSpans_s[kSpans_s.length - 1]!, now - kFine_s, kCoarse_s);
    }
    if (!this.fixed || past) this.drawSoon();
  }

  private recordOf(epoch: bigint): SignalRecord {
    let record = this.records.get(epoch);
    if (!record) {
      record = new SignalRecord(this.signals);
      this.records.set(epoch, record);
      if (this.records.size > kMaxEpochs) this.records.delete(this.records.keys().next().value!);
    }
    return record;
  }

  /** The moment that the charts lack most, as long as they are seen. */
  private nextQuery(): PastQuery | null {
    const {snapshot, cell} = this.state;
    if (!snapshot || !this.element.offsetParent) return null;
    if (performance.now() - this.failed < kRetry_ms) return null;
    const {epoch} = snapshot;
    const {kept} = this;
    if (!kept) return null;
    const step_s = stepSize(cell),
      {from_s, to_s} = this.range;
    const gap_s = this.recordOf(epoch).longestGap(
      Math.max(from_s, Number(kept.firstStep) * step_s),
      Math.min(to_s, Number(kept.lastStep) * step_s),
      Math.max(4 * step_s, (to_s - from_s) / kPoints)
    );
    if (gap_s === null) return null;
    const step = BigInt(Math.ceil(gap_s / step_s - 1e-6));
    return {
      moment: {epoch, step},
      use: (past) => {
        if (!past?.snapshot || !this.state.isOfSceneShown(past)) {
          this.failed = performance.now();
          return;
        }
        this.recordOf(epoch).add(simTime(past.snapshot), past.snapshot);
        this.drawSoon();
      }
    };
  }

  private drawSoon(): void {
    const wait_ms = this.drawn + this.period_ms - performance.now();
    if (wait_ms <= 0) this.draw();
    else if (!this.timer) this.timer = window.setTimeout(() => this.draw(), wait_ms);
  }

  private draw(): void {
    window.clearTimeout(this.timer);
    this.timer = 0;
    if (!this.element.offsetParent) return;
    const begin = performance.now();
    this.charts.forEach((chart) => chart.draw());
    // uPlot draws in microtasks that were queued before this one.
    queueMicrotask(() => {
      this.drawn = performance.now();
      this.period_ms = Math.max(kDrawPeriod_ms, kRest * (this.drawn - begin));
    });
  }

  private save(): void {
    const {recording} = this;
    const signals = [...new Set(this.charts.flatMap((chart) => chart.signals))];
    const head = ['time [s]', ...signals.map((s) => s.name + (s.unit ? ` [${s.unit}]` : ''))];
    const columns = signals.map((s) => column(recording, this.indexOf(s)));
    const lines = recording.times.map((t, i) =>
      [t.toFixed(4), ...columns.map((values) => values[i]?.toPrecision(9) ?? '')].join(',')
    );
    download(
      `${this.state.cell?.scene ?? 'cell'}.csv`,
      new Blob([[head.join(','), ...lines].join('\n') + '\n'], {type: 'text/csv'})
    );
  }
}
