// One chart: signals of at most two units over simulated time.
import uPlot from 'uplot';
import {column, type Recording} from '../history';
import {button, h, text} from './dom';
import type {ChartSignal} from './signals';
import {simSeconds} from './time';

export interface Range {
  from_s: number;
  to_s: number;
}

/** The panel that a chart belongs to. */
export interface ChartHost {
  readonly range: Range;
  /** Recorded values in that range. */
  readonly recording: Recording;
  /** Moment of the past that is shown, with the values of its state; null = the present. */
  readonly moment: {time_s: number; value: (signal: ChartSignal) => number} | null;
  indexOf(signal: ChartSignal): number;
  zoom(range: Range | null): void;
  goTo(time_s: number): void;
  remove(chart: Chart): void;
}

const kHeight_px = 178;
const kColors = ['#f5b82e', '#3f8efc', '#37d67a', '#ff6b81', '#b88cff', '#2bd4d4'];
const kMaxSignals = kColors.length;
const kLeastDrag_px = 6;
const kWheelZoom = 1.3;

interface Trace {
  signal: ChartSignal;
  color: string;
  row: HTMLElement;
  reading: HTMLElement;
}

export class Chart {
  readonly element = h('figure', {class: 'strip', 'data-testid': 'chart'});
  private readonly legend = h('figcaption');
  private readonly holder = h('div', {class: 'plot'});
  private traces: Trace[] = [];
  private plot: uPlot | null = null;

  /** `firstColor`: number of the first signal's colour, so that charts differ. */
  constructor(
    private readonly host: ChartHost,
    private readonly firstColor: number
  ) {
    this.element.append(this.legend, this.holder);
    this.holder.addEventListener('wheel', (event) => this.turnWheel(event), {passive: false});
  }

  get signals(): ChartSignal[] {
    return this.traces.map(({signal}) => signal);
  }

  /** Adds a signal; returns why it cannot, or an empty text. */
  add(signal: ChartSignal): string {
    if (this.signals.includes(signal)) return `${signal.name} is in this chart already.`;
    if (this.traces.length === kMaxSignals) return `A chart has at most ${kMaxSignals} signals.`;
    const units = new Set([...this.units, signal.unit]);
    if (units.size > 2)
      return `This chart has the units ${this.units.map(named).join(' and ')}; add ${signal.name} to another one.`;
    const colors = kColors.map((_, i) => kColors[(this.firstColor + i) % kColors.length]!);
    const color = colors.find((one) => this.traces.every((trace) => trace.color !== one))!;
    const reading = h('output', {'data-testid': `reading ${signal.name}`});
    const swatch = h('i', {class: 'swatch'});
    swatch.style.background = color;
    const row = h(
      'div',
      {class: 'signal'},
      swatch,
      h('span', {}, `${signal.name}${signal.unit ? ` [${signal.unit}]` : ''}`),
      reading,
      button('×', () => this.remove(signal), {
        class: 'icon',
        'aria-label': `Remove ${signal.name}`
      })
    );
    this.legend.append(row);
    this.traces.push({signal, color, row, reading});
    this.rebuild();
    return '';
  }

  private remove(signal: ChartSignal): void {
    this.traces.find((trace) => trace.signal === signal)?.row.remove();
    this.traces = this.traces.filter((trace) => trace.signal !== signal);
    if (this.traces.length === 0) this.host.remove(this);
    else this.rebuild();
  }

  destroy(): void {
    this.plot?.destroy();
    this.plot = null;
    this.element.remove();
  }

  resize(): void {
    this.plot?.setSize({width: this.width, height: kHeight_px});
  }

  draw(): void {
    if (!this.plot) return;
    const {recording} = this.host;
    this.plot.setData(
      [
        recording.times,
        ...this.traces.map(({signal}) => column(recording, this.host.indexOf(signal)))
      ],
      true
    );
    this.read();
  }

  private get units(): string[] {
    return [...new Set(this.signals.map(({unit}) => unit))];
  }

  private get width(): number {
    return Math.max(200, (this.element.parentElement?.clientWidth ?? 0) - 2);
  }

  private rebuild(): void {
    this.plot?.destroy();
    const common = {
      stroke: '#8b98a8',
      grid: {stroke: 'rgba(139,152,168,.18)', width: 1},
      ticks: {show: false},
      font: '11px system-ui',
      labelFont: '11px system-ui',
      labelSize: 15
    };
    this.plot = new uPlot(
      {
        width: this.width,
        height: kHeight_px,
        legend: {show: false},
        cursor: {
          y: false,
          sync: {key: 'charts'},
          drag: {x: true, y: false, setScale: false},
          bind: {dblclick: () => () => this.zoomOut()}
        },
        scales: {
          x: {
            time: false,
            range: () => {
              const {from_s, to_s} = this.host.range;
              return [from_s, to_s];
            }
          }
        },
        axes: [
          {...common, size: 24, label: 'simulated time [s]'},
          ...this.units.map((unit, i) => ({
            ...common,
            scale: unit || 'none',
            size: 48,
            side: i === 0 ? 3 : 1,
            grid: {...common.grid, show: i === 0},
            label: named(unit)
          }))
        ],
        series: [
          {},
          ...this.traces.map(({signal, color}) => ({
            stroke: color,
            width: 1.6,
            scale: signal.unit || 'none',
            points: {show: false}
          }))
        ],
        hooks: {
          setCursor: [() => this.read()],
          setSelect: [(plot) => this.select(plot)],
          draw: [(plot) => this.mark(plot)]
        }
      },
      [[], ...this.traces.map(() => [])],
      this.holder
    );
    this.listenForClicks(this.plot);
    this.draw();
  }

  // ---- zoom and the timeline

  private zoomOut(): null {
    this.host.zoom(null);
    return null;
  }

  private select(plot: uPlot): void {
    const {left, width} = plot.select;
    if (width < kLeastDrag_px) return;
    plot.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
    this.host.zoom({from_s: plot.posToVal(left, 'x'), to_s: plot.posToVal(left + width, 'x')});
  }

  /** With Ctrl, as browsers zoom; the wheel alone scrolls the panel. */
  private turnWheel(event: WheelEvent): void {
    if (!event.ctrlKey || !this.plot) return;
    event.preventDefault();
    const at = this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, 'x');
    const factor = event.deltaY > 0 ? kWheelZoom : 1 / kWheelZoom;
    const {from_s, to_s} = this.host.range;
    this.host.zoom({from_s: at - factor * (at - from_s), to_s: at + factor * (to_s - at)});
  }

  private listenForClicks(plot: uPlot): void {
    let down_px = 0;
    plot.over.addEventListener('pointerdown', ({clientX}) => (down_px = clientX));
    plot.over.addEventListener('click', ({clientX, detail}) => {
      if (detail > 1 || Math.abs(clientX - down_px) >= kLeastDrag_px) return;
      this.host.goTo(plot.posToVal(clientX - plot.over.getBoundingClientRect().left, 'x'));
    });
  }

  /** Draws a line at the moment of the past that is shown. */
  private mark(plot: uPlot): void {
    const {moment} = this.host;
    if (!moment) return;
    const x = Math.round(plot.valToPos(moment.time_s, 'x', true)),
      {left, width, top, height} = plot.bbox;
    if (x < left || x > left + width) return;
    plot.ctx.save();
    plot.ctx.strokeStyle = '#6cb6ff';
    plot.ctx.lineWidth = 2;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  /** Shows each value under the cursor with its time; without a cursor that of the moment shown. */
  private read(): void {
    const {plot} = this;
    if (!plot) return;
    const times = plot.data[0];
    const at = plot.cursor.idx;
    const pointed = at !== null && at !== undefined && (plot.cursor.left ?? -1) >= 0;
    const {moment} = this.host;
    this.traces.forEach(({signal, reading}, i) => {
      const time_s = pointed ? times[at] : moment?.time_s;
      const value = pointed
        ? plot.data[i + 1]?.[at]
        : moment
          ? moment.value(signal)
          : plot.data[i + 1]?.[times.length - 1];
      const known = value !== null && value !== undefined && Number.isFinite(value);
      const shown = `${known ? tidy(value) : '–'} ${signal.unit}`.trim();
      text(reading, time_s === undefined ? shown : `${simSeconds(time_s)}: ${shown}`);
    });
  }
}

/** A unit as an axis is labelled. */
function named(unit: string): string {
  return unit ? `[${unit}]` : '[1]';
}

/** Five significant digits, without powers of ten where they can be avoided. */
function tidy(value: number): string {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(3);
  const whole = size < 1 ? 1 : Math.floor(Math.log10(size)) + 1;
  return value.toFixed(Math.max(0, 5 - whole));
}
