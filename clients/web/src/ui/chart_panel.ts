// Strip charts of any signal over simulated time.
import uPlot from 'uplot';
import {column, History, PastRecording, type Recording} from '../history';
import type {Snapshot} from '../protocol';
import {simTime, type State} from '../state';
import {button, card, download, h, notify, text} from './dom';
import {signalsOf, type ChartSignal} from './signals';
import {suggest} from './suggest';

const kSpan_s = 60;
const kMaxPoints = 4000;
const kPastSpan_s = 6; // around a moment of the past
const kMaxCharts = 6;
const kDrawPeriod_ms = 100;
const kColors = ['#f5b82e', '#3f8efc', '#37d67a', '#ff6b81', '#b88cff', '#2bd4d4'];

interface Strip {
  signal: ChartSignal;
  index: number; // of the signal
  plot: uPlot;
  element: HTMLElement;
  reading: HTMLElement;
}

export class ChartPanel {
  readonly element = h('div', {class: 'panel charts'});
  private readonly list = h('div', {class: 'strips'});
  private readonly choice = h('input', {
    type: 'search',
    list: 'signals',
    placeholder: 'Add a signal …',
    'aria-label': 'Signal to chart',
    'data-testid': 'chart-choice'
  });
  private readonly names = h('datalist', {id: 'signals'});
  private readonly complaint = h('p', {
    class: 'complaint',
    role: 'alert',
    'data-testid': 'chart-complaint'
  });
  private readonly pauseButton = button('Pause', () => this.pause());
  private signals: ChartSignal[] = [];
  private strips: Strip[] = [];
  private history = new History([], kSpan_s, kMaxPoints);
  private frozen: Recording | null = null; // what is shown while paused
  private past: {epoch: bigint; record: PastRecording} | null = null;
  private drawn = 0;

  constructor(private readonly state: State) {
    this.choice.addEventListener('change', () => this.choose(this.choice.value));
    this.choice.addEventListener('input', () => this.complaint.replaceChildren());
    this.element.append(
      card(
        'Strip charts',
        h(
          'div',
          {class: 'row'},
          this.choice,
          this.names,
          this.pauseButton,
          button('CSV', () => this.save(), {title: 'Saves what the charts hold'})
        ),
        this.complaint,
        this.list
      )
    );
    state.cellChanged.on((cell) => {
      this.signals = signalsOf(cell);
      this.history = new History(this.signals, kSpan_s, kMaxPoints);
      this.past = null;
      this.names.replaceChildren(...this.signals.map((s) => h('option', {value: s.name})));
      const names = this.strips.length
        ? this.strips.map((s) => s.signal.name)
        : [
            `${cell.robots[0]?.name} tool z`,
            `${cell.robots[0]?.name} gripper force 1`,
            'step time'
          ];
      this.clear();
      for (const name of names) {
        const signal = this.signals.find((s) => s.name === name);
        if (signal) this.add(signal);
      }
    });
    state.snapshotChanged.on((snapshot) => this.take(snapshot));
    state.pastChanged.on((past) => this.lookBack(past));
    state.pastRead.on((past) => this.keep(past));
    new ResizeObserver(() => {
      this.strips.forEach((s) => s.plot.setSize({width: this.width(), height: 130}));
      this.draw();
    }).observe(this.list);
  }

  private width(): number {
    return Math.max(200, this.list.clientWidth - 2);
  }

  private get shown(): Recording {
    const {past} = this.state;
    if (past && this.past) {
      const now = simTime(past);
      return this.past.record.between(now - kPastSpan_s / 2, now + kPastSpan_s / 2);
    }
    return this.frozen ?? this.history.live;
  }

  private clear(): void {
    this.strips.forEach((s) => s.plot.destroy());
    this.strips = [];
    this.list.replaceChildren();
  }

  /** Adds the signal of this name; says so when there is none, and which there are. */
  private choose(typed: string): void {
    const name = typed.trim().toLowerCase();
    this.complaint.replaceChildren();
    if (!name) return;
    const signal = this.signals.find((s) => s.name.toLowerCase() === name);
    if (signal) {
      this.add(signal);
      this.choice.value = '';
      return;
    }
    const meant = suggest(
      name,
      this.signals.map((s) => s.name)
    );
    this.complaint.append(
      `There is no signal “${typed.trim()}”.`,
      ...(meant.length ? [' Did you mean '] : [' Try a robot’s name, “belt”, “tool”, “J1”.']),
      ...meant.flatMap((other, i) => [
        i === 0 ? '' : i === meant.length - 1 ? ' or ' : ', ',
        button(other, () => this.choose(other), {class: 'link'})
      ]),
      meant.length ? '?' : ''
    );
  }

  private add(signal: ChartSignal): void {
    if (this.strips.some((s) => s.signal === signal)) return;
    if (this.strips.length >= kMaxCharts)
      return notify(`At most ${kMaxCharts} charts at once; remove one first.`, 'error');
    const color = kColors[this.strips.length % kColors.length]!;
    const holder = h('div', {class: 'plot'});
    const reading = h('output', {'data-testid': `reading ${signal.name}`});
    const axis = {
      stroke: '#8b98a8',
      grid: {stroke: 'rgba(139,152,168,.18)', width: 1},
      ticks: {show: false},
      font: '11px system-ui'
    };
    const element = h(
      'figure',
      {class: 'strip'},
      h(
        'figcaption',
        {},
        h('span', {}, `${signal.name}${signal.unit ? ` [${signal.unit}]` : ''}`),
        reading,
        button('×', () => this.remove(strip), {
          class: 'icon',
          'aria-label': `Remove ${signal.name}`
        })
      ),
      holder
    );
    this.list.append(element);
    const plot = new uPlot(
      {
        width: this.width(),
        height: 130,
        legend: {show: false},
        cursor: {y: false, sync: {key: 'charts'}},
        scales: {x: {time: false}},
        axes: [
          {...axis, size: 24},
          {...axis, size: 52}
        ],
        series: [{}, {stroke: color, width: 1.6, points: {show: false}}],
        hooks: {setCursor: [() => this.read(strip)], draw: [(plot) => this.mark(plot)]}
      },
      [[], []],
      holder
    );
    const strip: Strip = {signal, index: this.signals.indexOf(signal), plot, element, reading};
    this.strips.push(strip);
    this.show(strip);
  }

  private remove(strip: Strip): void {
    strip.plot.destroy();
    strip.element.remove();
    this.strips = this.strips.filter((s) => s !== strip);
  }

  /** The charts show what was around that moment. */
  private lookBack(past: Snapshot | null): void {
    if (!past) this.past = null;
    else this.keep(past);
    if (performance.now() - this.drawn >= kDrawPeriod_ms) this.draw();
    else window.setTimeout(() => this.draw(), kDrawPeriod_ms);
  }

  private keep(past: Snapshot): void {
    if (!this.state.past) return;
    if (this.past?.epoch !== past.epoch) {
      const live = this.state.live?.epoch === past.epoch;
      this.past = {
        epoch: past.epoch,
        record: new PastRecording(this.signals, live ? this.history.copy() : {times: [], rows: []})
      };
    }
    this.past.record.add(simTime(past), past);
    this.draw();
  }

  private take(snapshot: Snapshot): void {
    if (this.state.past) return;
    this.history.take(simTime(snapshot), snapshot);
    if (performance.now() - this.drawn >= kDrawPeriod_ms && !this.frozen) this.draw();
  }

  private draw(): void {
    if (!this.element.offsetParent) return;
    this.drawn = performance.now();
    this.strips.forEach((strip) => this.show(strip));
  }

  private show(strip: Strip): void {
    strip.plot.setData([this.shown.times, column(this.shown, strip.index)]);
    this.read(strip);
  }

  /** A line at the moment of the past that is shown. */
  private mark(plot: uPlot): void {
    const {past} = this.state;
    if (!past) return;
    const x = Math.round(plot.valToPos(simTime(past), 'x', true)),
      {top, height} = plot.bbox;
    plot.ctx.save();
    plot.ctx.strokeStyle = '#6cb6ff';
    plot.ctx.lineWidth = 2;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  /** The value under the cursor with its time, else the latest. */
  private read(strip: Strip): void {
    const [times, values] = strip.plot.data;
    const {past} = this.state;
    if (past && (strip.plot.cursor.left ?? -1) < 0) {
      const value = strip.signal.read(past);
      const number = Number.isFinite(value) ? tidy(value) : '–';
      text(strip.reading, `${simTime(past).toFixed(3)} s: ${number} ${strip.signal.unit}`.trim());
      return;
    }
    const at = strip.plot.cursor.idx;
    const pointed = at !== null && at !== undefined && (strip.plot.cursor.left ?? -1) >= 0;
    const value = values?.[pointed ? at : times.length - 1];
    const number = value === null || value === undefined ? '–' : tidy(value);
    const shown = `${number} ${strip.signal.unit}`.trim();
    text(strip.reading, pointed ? `${times[at]!.toFixed(3)} s: ${shown}` : shown);
  }

  private pause(): void {
    this.frozen = this.frozen ? null : this.history.copy();
    text(this.pauseButton, this.frozen ? 'Go on' : 'Pause');
    this.draw();
  }

  private save(): void {
    const head = [
      'time [s]',
      ...this.strips.map((s) => s.signal.name + (s.signal.unit ? ` [${s.signal.unit}]` : ''))
    ];
    const columns = this.strips.map((s) => column(this.shown, s.index));
    const lines = this.shown.times.map((t, i) =>
      [t.toFixed(4), ...columns.map((values) => values[i]?.toPrecision(9) ?? '')].join(',')
    );
    download(
      `${this.state.cell?.scene ?? 'cell'}.csv`,
      new Blob([[head.join(','), ...lines].join('\n') + '\n'], {type: 'text/csv'})
    );
  }
}

/** Five digits that count, without powers of ten where they can be left out. */
function tidy(value: number): string {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(3);
  const whole = size < 1 ? 1 : Math.floor(Math.log10(size)) + 1;
  return value.toFixed(Math.max(0, 5 - whole));
}
