// Strip charts of any signal over simulated time.
import uPlot from 'uplot';
import type {Snapshot} from '../protocol';
import {simTime, type State} from '../state';
import {button, card, download, h, notify, text} from './dom';
import {signalsOf, type ChartSignal} from './signals';

const kSpan_s = 60;
const kMaxPoints = 4000;
const kMaxCharts = 6;
const kColors = ['#f5b82e', '#3f8efc', '#37d67a', '#ff6b81', '#b88cff', '#2bd4d4'];

interface Strip {
  signal: ChartSignal;
  values: number[];
  plot: uPlot;
  element: HTMLElement;
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
  private readonly pauseButton = button('Pause', () => this.pause());
  private signals: ChartSignal[] = [];
  private strips: Strip[] = [];
  private times: number[] = [];
  private paused = false;
  private drawn = 0;

  constructor(private readonly state: State) {
    this.choice.addEventListener('change', () => {
      const signal = this.signals.find((s) => s.name === this.choice.value);
      if (signal) this.add(signal);
      this.choice.value = '';
    });
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
        this.list
      )
    );
    state.cellChanged.on((cell) => {
      this.signals = signalsOf(cell);
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
    new ResizeObserver(() =>
      this.strips.forEach((s) => s.plot.setSize({width: this.width(), height: 130}))
    ).observe(this.list);
  }

  private width(): number {
    return Math.max(200, this.list.clientWidth - 2);
  }

  private clear(): void {
    this.strips.forEach((s) => s.plot.destroy());
    this.strips = [];
    this.times = [];
    this.list.replaceChildren();
  }

  private add(signal: ChartSignal): void {
    if (this.strips.some((s) => s.signal === signal)) return;
    if (this.strips.length >= kMaxCharts)
      return notify(`At most ${kMaxCharts} charts at once; remove one first.`, 'error');
    const color = kColors[this.strips.length % kColors.length]!;
    const holder = h('div', {class: 'plot'});
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
        `${signal.name}${signal.unit ? ` [${signal.unit}]` : ''}`,
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
        cursor: {y: false},
        scales: {x: {time: false}},
        axes: [
          {...axis, size: 24},
          {...axis, size: 52}
        ],
        series: [{}, {stroke: color, width: 1.6, points: {show: false}, spanGaps: true}]
      },
      [[], []],
      holder
    );
    const strip: Strip = {signal, values: this.times.map(() => NaN), plot, element};
    this.strips.push(strip);
  }

  private remove(strip: Strip): void {
    strip.plot.destroy();
    strip.element.remove();
    this.strips = this.strips.filter((s) => s !== strip);
  }

  private take(snapshot: Snapshot): void {
    if (this.paused || this.strips.length === 0) return;
    const now = simTime(snapshot);
    const last = this.times[this.times.length - 1];
    if (last !== undefined && now === last) return;
    if (last !== undefined && now < last) {
      this.times = [];
      this.strips.forEach((s) => (s.values = []));
    }
    this.times.push(now);
    this.strips.forEach((s) => s.values.push(s.signal.read(snapshot)));
    let old = Math.max(0, this.times.length - kMaxPoints);
    while (this.times[old]! < now - kSpan_s) ++old;
    if (old > 200 || this.times.length > kMaxPoints) {
      this.times.splice(0, old);
      this.strips.forEach((s) => s.values.splice(0, old));
    }
    if (!this.element.offsetParent || performance.now() - this.drawn < 100) return;
    this.drawn = performance.now();
    this.strips.forEach((s) => s.plot.setData([this.times, s.values]));
  }

  private pause(): void {
    this.paused = !this.paused;
    text(this.pauseButton, this.paused ? 'Go on' : 'Pause');
  }

  private save(): void {
    const head = [
      'time [s]',
      ...this.strips.map((s) => s.signal.name + (s.signal.unit ? ` [${s.signal.unit}]` : ''))
    ];
    const lines = this.times.map((t, i) =>
      [
        t.toFixed(4),
        ...this.strips.map((s) => (Number.isFinite(s.values[i]) ? s.values[i]!.toPrecision(9) : ''))
      ].join(',')
    );
    download(
      `${this.state.cell?.scene ?? 'cell'}.csv`,
      'text/csv',
      [head.join(','), ...lines].join('\n') + '\n'
    );
  }
}
