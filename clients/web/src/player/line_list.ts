import {button, card, h} from '../ui/dom';
import {simSeconds} from '../ui/time';
import {indexAt, type Line} from './recording';

const kMostLines = 400; // shown at once

/** Lines of a run around the current moment; a click seeks to a line's time. */
export class LineList {
  readonly element = h('div', {class: 'panel'});
  private readonly list = h('ol', {class: 'wire-lines'});
  private readonly choice = h('select', {'aria-label': 'Which lines'});
  private lines: Line[] = [];
  private time_s = 0;
  private shown = '';

  constructor(
    title: string,
    private readonly all: Line[],
    private readonly seek: (time_s: number) => void
  ) {
    const wires = [...new Set(all.map((line) => line.wire))].sort();
    this.choice.append(
      h('option', {value: ''}, 'all'),
      ...wires.map((wire) => h('option', {value: wire}, wire))
    );
    this.choice.addEventListener('change', () => this.choose());
    this.element.append(
      card(title, h('div', {class: 'row'}, wires.length > 1 && this.choice), this.list)
    );
    this.choose();
  }

  update(time_s: number): void {
    this.time_s = time_s;
    if (!this.element.offsetParent) return;
    const present = this.lines.length ? indexAt(this.lines, time_s) : -1;
    const begin = Math.max(0, Math.min(present - 100, this.lines.length - kMostLines));
    const state = `${this.choice.value} ${begin} ${present}`;
    if (state === this.shown) return;
    this.shown = state;
    this.list.replaceChildren(
      ...this.lines.slice(begin, begin + kMostLines).map((line, i) => {
        const past = line.time_s <= time_s + 1e-9;
        const arrow = line.direction === 'in' ? '→' : line.direction === 'out' ? '←' : '';
        return h(
          'li',
          {
            'data-past': String(past),
            'aria-current': begin + i === present && past ? 'true' : undefined
          },
          button(simSeconds(line.time_s), () => this.seek(line.time_s), {class: 'link'}),
          ` ${line.wire === 'cell' ? '' : line.wire} ${arrow} `,
          line.text
        );
      })
    );
    this.list.querySelector('[aria-current]')?.scrollIntoView({block: 'nearest'});
  }

  private choose(): void {
    this.lines = this.choice.value
      ? this.all.filter((line) => line.wire === this.choice.value)
      : this.all;
    this.shown = '';
    this.update(this.time_s);
  }
}
