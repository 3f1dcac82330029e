// The events of a scenario on a scale of simulated time: choose, drag, stretch.
import {button, h} from '../ui/dom';
import {lastTime, lengthOf, rounded, timesText, type TimedEvent} from './events';
import type {ScenarioEditor} from './scenario_editor';

const kLeastSpan_s = 30;
const kMostSpan_s = 100000;
const kMost = 1e6; // longest time of scenarios [s]
const kDragged_px = 3;
const kTicks = 5;

/** A round number that is not smaller. */
export function roundUp(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 3, 5, 10].find((digit) => digit * power >= value * (1 - 1e-9))!;
}

/** Times that dragging keeps to, for a shown span [s]. */
export const gridOf = (span_s: number): number => (span_s <= 30 ? 0.1 : span_s <= 120 ? 0.5 : 1);

interface Drag {
  id: string;
  end: boolean;
  x: number;
  by_s: number;
}

export class Timeline {
  readonly element: HTMLElement;
  private readonly axis = h('div', {class: 'track axis', 'aria-hidden': 'true'});
  private readonly rows = h('div', {class: 'rows'});
  private readonly scale = h('output', {'aria-label': 'Shown time'});
  private zoom_s: number | null = null;
  private drag: Drag | null = null;
  private now_s = 0;

  constructor(private readonly editor: ScenarioEditor) {
    this.element = h(
      'div',
      {class: 'timeline', role: 'group', 'aria-label': 'Events over simulated time'},
      h(
        'div',
        {class: 'row head'},
        h(
          'span',
          {class: 'name zoom'},
          button('−', () => this.zoomBy(2), {class: 'icon', 'aria-label': 'Show a longer time'}),
          button('+', () => this.zoomBy(0.5), {class: 'icon', 'aria-label': 'Show a shorter time'}),
          this.scale
        ),
        this.axis
      ),
      this.rows
    );
    this.element.addEventListener('pointermove', (event) => this.move(event));
    this.element.addEventListener('pointerup', () => this.drop());
    this.element.addEventListener('pointercancel', () => {
      this.drag = null;
      this.show();
    });
  }

  /** Time of the run that is shown, since its start; 0 = none. */
  showTime(now_s: number): void {
    if (this.now_s === now_s) return;
    this.now_s = now_s;
    for (const mark of this.rows.querySelectorAll<HTMLElement>('.now')) this.placeNow(mark);
  }

  private get span_s(): number {
    return this.zoom_s ?? roundUp(Math.max(kLeastSpan_s, 1.2 * lastTime(this.editor.events)));
  }
  /** Where events without an end stop to be shown. */
  private get end_s(): number {
    return Math.min(this.span_s, this.editor.limit_s);
  }
  private zoomBy(factor: number): void {
    const next = roundUp(this.span_s * factor * (factor < 1 ? 0.8 : 1));
    this.zoom_s = Math.min(kMostSpan_s, Math.max(1, next));
    this.show();
  }
  private percent(time_s: number): string {
    return `${Math.min(100, (100 * time_s) / this.span_s).toFixed(3)}%`;
  }
  private placeNow(mark: HTMLElement): void {
    mark.hidden = this.now_s <= 0 || this.now_s > this.span_s;
    mark.style.left = this.percent(this.now_s);
  }

  show(): void {
    const {events, chosen} = this.editor;
    const focused = this.rows.querySelector<HTMLElement>('.bar:focus')?.dataset.event;
    const span_s = this.span_s;
    this.scale.textContent = `${rounded(span_s)} s`;
    this.axis.replaceChildren(
      ...Array.from({length: kTicks + 1}, (_, i) => {
        const tick = h('span', {}, `${rounded((span_s * i) / kTicks)}`);
        tick.style.left = `${(100 * i) / kTicks}%`;
        return tick;
      })
    );
    this.rows.replaceChildren(
      ...events.map((event) => this.row(this.preview(event), event, event.id === chosen?.id))
    );
    if (events.length === 0)
      this.rows.append(
        h('p', {class: 'meaning'}, 'No orders or faults yet. Choose one above and add it.')
      );
    if (focused)
      this.rows
        .querySelector<HTMLElement>(`.bar[data-event="${focused}"]`)
        ?.focus({preventScroll: true});
  }

  /** The event as it is where the pointer has dragged it. */
  private preview(event: TimedEvent): TimedEvent {
    if (this.drag?.id !== event.id) return event;
    const {end, by_s} = this.drag;
    const [first, last] = event.begin_s ?? [0, 0];
    if (!end) {
      const from = Math.max(0, first + by_s);
      return {...event, begin_s: [from, from + last - first]};
    }
    const length_s = Math.max(0, this.shownLength(event) + by_s);
    return event.list === 'kill_controller'
      ? {...event, begin_s: [first, first + length_s]}
      : {...event, lasts_s: length_s};
  }

  /** Its length, or how much of it is shown if it has no end. */
  private shownLength(event: TimedEvent): number {
    return lengthOf(event) ?? Math.max(0, this.end_s - (event.begin_s?.[1] ?? 0));
  }

  private row(shown: TimedEvent, event: TimedEvent, isChosen: boolean): HTMLElement {
    const times = timesText(shown);
    const [first, last] = shown.begin_s ?? [0, 0];
    const end = shown.lasts_s === null ? Math.max(last, this.end_s) : last + shown.lasts_s;
    const part = (kind: string, from: number, to: number): HTMLElement => {
      const drawn = h('i', {class: kind});
      drawn.style.left = this.percent(from);
      drawn.style.right = `calc(100% - ${this.percent(to)})`;
      return drawn;
    };
    const bar = button(shown.begin_s ? '' : times, () => this.editor.choose(event), {
      class: 'bar',
      'aria-pressed': String(isChosen),
      'aria-label': `${shown.title}, ${times}`,
      title: `${shown.title}, ${times}`,
      'data-event': event.id,
      'data-testid': `event-${event.id.replace('/', '-')}`,
      onpointerdown: (down: Event) => this.grasp(down as PointerEvent, event, false)
    });
    bar.style.left = this.percent(first);
    bar.style.width = shown.begin_s ? `calc(${this.percent(end)} - ${this.percent(first)})` : '';
    const track = h(
      'div',
      {class: 'track', 'data-list': event.list},
      ...(shown.begin_s ? [part('lasts', last, end)] : []),
      ...(last > first ? [part('drawn', first, last)] : []),
      shown.cancel_s !== null && part('cancel', shown.cancel_s, shown.cancel_s),
      bar
    );
    if (event.stretches && shown.begin_s) {
      const handle = h('span', {
        class: 'handle',
        'aria-hidden': 'true',
        title: 'Drag to change the duration',
        'data-testid': `stretch-${event.id.replace('/', '-')}`,
        onpointerdown: (down: Event) => this.grasp(down as PointerEvent, event, true)
      });
      const least = `calc(${this.percent(first)} + 24px)`;
      handle.style.left = `max(${this.percent(end)}, ${least})`;
      track.append(handle);
    }
    const now = h('i', {class: 'now', hidden: true});
    this.placeNow(now);
    track.append(now);
    return h(
      'div',
      {class: 'row'},
      h('span', {class: 'name', title: shown.title}, shown.title, h('small', {}, times)),
      track
    );
  }

  private grasp(down: PointerEvent, event: TimedEvent, end: boolean): void {
    if (down.button !== 0 || !event.begin_s) return;
    this.element.setPointerCapture(down.pointerId);
    this.drag = {id: event.id, end, x: down.clientX, by_s: 0};
  }

  private move({clientX, altKey}: PointerEvent): void {
    const {drag} = this;
    const event = drag && this.editor.events.find(({id}) => id === drag.id);
    if (!drag || !event) return;
    const moved_px = clientX - drag.x;
    if (Math.abs(moved_px) < kDragged_px && drag.by_s === 0) return;
    const from_s = drag.end ? this.shownLength(event) : (event.begin_s?.[0] ?? 0);
    const width_px = this.axis.getBoundingClientRect().width;
    const to_s = Math.min(kMost, Math.max(0, from_s + (moved_px * this.span_s) / width_px));
    const grid = altKey ? 0.01 : gridOf(this.span_s);
    drag.by_s = rounded(Math.round(to_s / grid) * grid) - from_s;
    this.show();
  }

  private drop(): void {
    const {drag} = this;
    this.drag = null;
    const event = drag && this.editor.events.find(({id}) => id === drag.id);
    if (!drag || !event) return;
    if (drag.by_s === 0) {
      this.editor.choose(event);
      this.focus(event);
      return this.show();
    }
    this.editor.choose(event);
    if (drag.end) this.editor.lasts(event, this.shownLength(event) + drag.by_s);
    else this.editor.begins(event, (event.begin_s?.[0] ?? 0) + drag.by_s);
    this.focus(event);
  }

  /** Gives the keys to an event. */
  focus({id}: TimedEvent): void {
    this.rows.querySelector<HTMLElement>(`.bar[data-event="${id}"]`)?.focus({preventScroll: true});
  }
}
