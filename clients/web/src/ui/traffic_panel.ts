// Taps: what goes over the CRCL sockets or the Modbus sockets, live.
import type {WireEvent} from '../protocol';
import type {State} from '../state';
import {button, card, h, text} from './dom';
import {modbusDump, modbusLine} from './modbus_text';
import {prettyXml} from './xml';

const kRows = 400;
const kDrawPeriod_ms = 120;

interface Row {
  event: WireEvent;
  type: string;
  summary: string;
  bad: boolean;
  latency: string;
  at: string;
}

export class TrafficPanel {
  readonly element = h('div', {class: 'panel traffic'});
  private readonly body: HTMLElement;
  private readonly detail = h('div', {class: 'detail', hidden: true});
  private readonly note = h('small', {});
  private readonly filter = h('input', {
    type: 'search',
    placeholder: 'Filter: type, id, state, text',
    'aria-label': 'Filter'
  });
  private readonly source = h(
    'select',
    {'aria-label': 'Listener'},
    h('option', {value: ''}, 'all')
  );
  private readonly quiet = h('input', {type: 'checkbox', checked: true});
  private readonly pauseButton = button('Pause', () => this.pause());
  private rows: Row[] = [];
  private waiting: Row[] = [];
  private readonly started = new Map<string, Row>(); // commands whose end has not been seen
  private paused = false;
  private lost = 0;
  private drawn = 0;

  constructor(
    state: State,
    private readonly wire: 'crcl' | 'modbus'
  ) {
    const title = wire === 'crcl' ? 'CRCL traffic' : 'Modbus traffic';
    this.body = h('tbody', {'data-testid': `${wire}-rows`});
    const heads =
      wire === 'crcl'
        ? ['time', '', 'from', 'type', 'id', 'state', 'ms']
        : ['time', '', 'client', 'function', 'no.', 'values', 'ms'];
    this.filter.addEventListener('input', () => this.draw());
    this.source.addEventListener('change', () => this.draw());
    this.quiet.addEventListener('change', () => this.draw());
    this.element.append(
      card(
        title,
        h(
          'div',
          {class: 'row'},
          this.filter,
          wire === 'crcl' ? this.source : null,
          this.pauseButton,
          button('Clear', () => this.clear())
        ),
        wire === 'crcl'
          ? h('label', {class: 'row check'}, this.quiet, 'hide GetStatus and its statuses')
          : null,
        h(
          'div',
          {class: 'scroll tall', tabindex: 0, role: 'region', 'aria-label': title},
          h(
            'table',
            {class: 'events'},
            h('thead', {}, h('tr', {}, ...heads.map((t) => h('th', {scope: 'col'}, t)))),
            this.body
          )
        ),
        this.note,
        this.detail
      )
    );
    state.wireEvents.on(({events, dropped}) => this.take(events, dropped));
    state.cellChanged.on((cell) =>
      this.source.replaceChildren(
        h('option', {value: ''}, 'all'),
        ...cell.robots.map((robot) => h('option', {value: `crcl.${robot.name}`}, robot.name))
      )
    );
  }

  private take(events: WireEvent[], dropped: number): void {
    const mine = events.filter((event) => (event.source === 'modbus') === (this.wire === 'modbus'));
    if (mine.length === 0) return;
    this.lost += dropped;
    for (const event of mine) this.add(event);
    if (performance.now() - this.drawn > kDrawPeriod_ms) this.draw();
    else
      window.setTimeout(
        () => performance.now() - this.drawn > kDrawPeriod_ms && this.draw(),
        kDrawPeriod_ms + 10
      );
  }

  private add(event: WireEvent): void {
    const at = new Date(event.timeS * 1000).toISOString().slice(11, 23);
    const latency = event.fromClient ? '' : (event.latencyS * 1000).toFixed(2);
    let row: Row;
    if (this.wire === 'modbus') {
      row = {event, latency, at, ...modbusLine(event.data, event.fromClient)};
    } else {
      row = {
        event,
        at,
        latency,
        type: event.type.replace(/Type$/, ''),
        summary: event.state.replace('CRCL_', ''),
        bad: /Error/.test(event.state) || (event.fromClient && event.state !== '')
      };
      this.followCommand(row);
    }
    (this.paused ? this.waiting : this.rows).push(row);
    const list = this.paused ? this.waiting : this.rows;
    if (list.length > kRows) list.splice(0, list.length - kRows);
  }

  /** The time from a command to the first status that calls it done or failed. */
  private followCommand(row: Row): void {
    const key = `${row.event.source} ${row.event.id}`;
    if (row.event.fromClient) {
      if (row.type !== 'GetStatus') this.started.set(key, row);
      if (this.started.size > kRows) this.started.delete(this.started.keys().next().value!);
      return;
    }
    const command = this.started.get(key);
    if (!command || !/Done|Error/.test(row.event.state)) return;
    command.latency = ((row.event.timeS - command.event.timeS) * 1000).toFixed(0);
    command.summary = row.summary;
    command.bad = /Error/.test(row.event.state);
    this.started.delete(key);
  }

  private pause(): void {
    this.paused = !this.paused;
    text(this.pauseButton, this.paused ? 'Go on' : 'Pause');
    if (!this.paused) {
      this.rows = [...this.rows, ...this.waiting].slice(-kRows);
      this.waiting = [];
    }
    this.draw();
  }

  private clear(): void {
    this.rows = [];
    this.waiting = [];
    this.lost = 0;
    this.detail.hidden = true;
    this.draw();
  }

  private wanted(row: Row): boolean {
    if (
      this.wire === 'crcl' &&
      this.quiet.checked &&
      (row.type === 'GetStatus' || !row.event.fromClient)
    )
      return false;
    if (this.source.value && row.event.source !== this.source.value) return false;
    const words = this.filter.value.trim().toLowerCase();
    if (!words) return true;
    const all =
      `${row.type} ${row.event.id} ${row.summary} ${row.event.peer} ${this.wire === 'crcl' ? new TextDecoder().decode(row.event.data) : ''}`.toLowerCase();
    return words.split(/\s+/).every((word) => all.includes(word));
  }

  private draw(): void {
    this.drawn = performance.now();
    if (!this.element.offsetParent) return;
    const shown = this.rows
      .filter((row) => this.wanted(row))
      .slice(-150)
      .reverse();
    this.body.replaceChildren(...shown.map((row) => this.line(row)));
    text(
      this.note,
      `${shown.length} of ${this.rows.length} shown${this.paused ? `, ${this.waiting.length} held back` : ''}${this.lost ? `, ${this.lost} lost because they came too fast` : ''}`
    );
  }

  private line(row: Row): HTMLElement {
    const {event} = row;
    const show = button(row.type || '?', () => this.show(row), {class: 'link'});
    const from = this.wire === 'crcl' ? event.source.replace('crcl.', '') : event.peer;
    return h(
      'tr',
      {class: row.bad ? 'bad' : '', title: event.peer},
      h('td', {}, h('time', {}, row.at)),
      h('td', {}, event.fromClient ? '→' : '←'),
      h('td', {}, from),
      h('td', {}, show),
      h('td', {}, String(event.id)),
      h('td', {}, row.summary),
      h('td', {}, row.latency)
    );
  }

  private show(row: Row): void {
    const content =
      this.wire === 'crcl'
        ? prettyXml(new TextDecoder().decode(row.event.data))
        : h('pre', {tabindex: 0}, modbusDump(row.event.data));
    this.detail.hidden = false;
    this.detail.replaceChildren(
      h(
        'div',
        {class: 'row'},
        h('strong', {}, `${row.type} ${row.event.fromClient ? 'from' : 'to'} ${row.event.peer}`),
        button('Close', () => (this.detail.hidden = true))
      ),
      content
    );
  }
}
