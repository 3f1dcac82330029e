// Traffic of the CRCL or Modbus sockets and commands of pages: commands as the daemon keeps them, polls
// as they arrive.
import type {Snapshot, WireEvent, WireEvents} from '../protocol';
import {simTime, type State} from '../state';
import {button, card, download, h, text} from './dom';
import {hexOf, modbusDump, ModbusText} from './modbus_text';
import {conveyorRegisters, mapRegisters} from './named_registers';
import {simSeconds, wallClock} from './time';
import {prettyXml} from './xml';

const kMaxCommands = 50000;
const kMaxPolls = 400;
const kMaxOpen = 500; // requests and commands without an answer so far
const kShown = 150;
const kDrawPeriod_ms = 120;

interface Row {
  event: WireEvent;
  type: string;
  summary: string;
  bad: boolean;
  latency: string;
  searched?: string;
}

const decoder = new TextDecoder();

/** Head of a column; the arrows' one has its meaning in words. */
const heading = (text: string) =>
  text === '⇄'
    ? h(
        'th',
        {scope: 'col', title: '→ from the client, ← to the client', 'aria-label': 'direction'},
        text
      )
    : h('th', {scope: 'col'}, text);

export class TrafficPanel {
  readonly element = h('div', {class: 'panel traffic'});
  private readonly body: HTMLElement;
  private readonly detail = h('div', {class: 'detail', hidden: true});
  private readonly note = h('small', {});
  private readonly more = button('Show more', () => this.showMore(), {hidden: true});
  private readonly filter = h('input', {
    type: 'search',
    placeholder: 'Filter',
    title: 'Words that type, id, state, client or content have',
    'aria-label': 'Filter'
  });
  private readonly source = h(
    'select',
    {'aria-label': 'Listener'},
    h('option', {value: ''}, 'all')
  );
  private readonly quiet: HTMLInputElement;
  private readonly pauseButton = button('Pause', () => this.pause());
  private readonly modbus = new Map<string, ModbusText>(); // by source, of the present cell
  private commands: Row[] = [];
  private polls: Row[] = [];
  private readonly open = new Map<string, Row>(); // by source, peer and id
  private instance = '';
  private last = 0n; // number of the latest event
  private pausedAt: bigint | null = null;
  private limit = kShown;
  private dropped = 0n;
  private drawn = 0;

  constructor(
    private readonly state: State,
    private readonly wire: 'crcl' | 'modbus'
  ) {
    state.cellChanged.on(() => this.modbus.clear());
    state.registerMapChanged.on(() => this.modbus.clear());
    const crcl = wire === 'crcl';
    const title = crcl ? 'CRCL commands' : 'Modbus traffic';
    this.body = h('tbody', {'data-testid': `${wire}-rows`});
    this.quiet = h('input', {type: 'checkbox', checked: crcl, 'data-testid': `${wire}-quiet`});
    const heads = crcl
      ? ['time', '⇄', 'type, id', 'state', 'ms']
      : ['time', '⇄', 'function', 'registers', 'ms'];
    this.filter.addEventListener('input', () => this.draw());
    this.source.addEventListener('change', () => this.draw());
    this.quiet.addEventListener('change', () => {
      state.watch({polls: this.wantsPolls});
      this.draw();
    });
    this.element.append(
      card(
        title,
        h(
          'div',
          {class: 'row'},
          this.filter,
          this.pauseButton,
          button('Clear', () => this.clear(), {
            title: 'Empty this list; the daemon keeps its own'
          })
        ),
        h(
          'div',
          {class: 'row'},
          h(
            'label',
            {
              class: 'row check',
              title: crcl ? 'GetStatus and statuses' : 'Reads and their replies'
            },
            this.quiet,
            crcl ? 'hide polls' : 'hide reads'
          ),
          crcl ? this.source : null,
          h('span', {class: 'fill'}),
          button('JSON', () => this.save('json'), {
            title: 'Save the filtered list as JSON, one event a line',
            'aria-label': 'Save as JSON'
          }),
          button('Text', () => this.save('text'), {
            title: 'Save the filtered list as readable text',
            'aria-label': 'Save as text'
          })
        ),
        h(
          'div',
          {class: 'scroll tall', tabindex: 0, role: 'region', 'aria-label': title},
          h(
            'table',
            {class: 'events'},
            h('thead', {}, h('tr', {}, ...heads.map(heading))),
            this.body
          )
        ),
        h('div', {class: 'row'}, this.note, this.more),
        this.detail
      )
    );
    state.wireEvents.on((message) => this.take(message));
    state.pastChanged.on(() => this.draw());
    state.cellChanged.on((cell) =>
      this.source.replaceChildren(
        h('option', {value: ''}, 'all'),
        ...cell.robots.map((robot) => h('option', {value: `crcl.${robot.name}`}, robot.name)),
        h('option', {value: 'page'}, 'pages')
      )
    );
  }

  /** Whether this panel, while open, needs GetStatus, statuses and reads. */
  get wantsPolls(): boolean {
    return !this.quiet.checked;
  }

  private take({events, dropped, wire}: WireEvents): void {
    if (wire !== this.wire) return;
    const instance = this.state.welcome?.instanceId ?? '';
    if (instance !== this.instance) {
      this.instance = instance;
      this.last = 0n;
      this.clear();
    }
    this.dropped = dropped;
    // After a reconnection the daemon starts with the events that it keeps.
    for (const event of events) if (event.number > this.last) this.add(event);
    if (performance.now() - this.drawn > kDrawPeriod_ms) this.draw();
    else
      window.setTimeout(
        () => performance.now() - this.drawn > kDrawPeriod_ms && this.draw(),
        kDrawPeriod_ms + 10
      );
  }

  private add(event: WireEvent): void {
    this.last = event.number;
    const row = this.row(event);
    if (!row) return;
    const list = event.poll ? this.polls : this.commands,
      most = event.poll ? kMaxPolls : kMaxCommands;
    list.push(row);
    if (list.length > most) list.splice(0, list.length - most);
  }

  /** A row for the event; null where it updates another row. */
  /** Text of the messages of a listener: "modbus" of the conveyor, "modbus.NAME" of a scene's server. */
  private textOf(source: string): ModbusText {
    let text = this.modbus.get(source);
    if (text) return text;
    // The ports with TLS have the same registers.
    const plain = source.replace(/^modbus_tls/, 'modbus');
    const server = this.state.cell?.modbusServers.find(({name}) => plain === `modbus.${name}`);
    const isConveyor = plain === 'modbus';
    text = new ModbusText(
      isConveyor ? conveyorRegisters(this.state.registerMap) : server ? mapRegisters(server) : []
    );
    this.modbus.set(source, text);
    return text;
  }

  private row(event: WireEvent): Row | null {
    const latency = event.fromClient ? '' : (event.latencyS * 1000).toFixed(2);
    if (event.source === 'page')
      return {
        event,
        latency,
        type: event.type,
        summary: event.state ? `refused: ${event.state}` : 'accepted',
        bad: event.state !== ''
      };
    const key = `${event.source} ${this.wire === 'modbus' ? event.peer : ''} ${event.id}`;
    if (this.wire === 'modbus') {
      const request = event.fromClient ? undefined : this.open.get(key)?.event.data;
      const row = {
        event,
        latency,
        ...this.textOf(event.source).line(event.data, event.fromClient, request)
      };
      if (event.fromClient) this.expect(key, row);
      else this.open.delete(key);
      return row;
    }
    const row = {
      event,
      latency,
      type: event.type.replace(/Type$/, ''),
      summary: event.state.replace('CRCL_', ''),
      bad: /^CRCL_Error/.test(event.state) || (event.fromClient && event.state !== '')
    };
    if (event.poll) return row;
    if (event.fromClient) {
      this.expect(key, row);
      return row;
    }
    // The first status that reports a command done or failed updates the command's row.
    const command = this.open.get(key);
    if (!command) return row;
    command.latency = ((event.timeS - command.event.timeS) * 1000).toFixed(0);
    command.summary = row.summary;
    command.bad = row.bad;
    delete command.searched;
    this.open.delete(key);
    return null;
  }

  private expect(key: string, row: Row): void {
    this.open.delete(key);
    this.open.set(key, row);
    if (this.open.size > kMaxOpen) this.open.delete(this.open.keys().next().value!);
  }

  private pause(): void {
    this.pausedAt = this.pausedAt === null ? this.last : null;
    text(this.pauseButton, this.pausedAt === null ? 'Pause' : 'Resume');
    this.draw();
  }

  private clear(): void {
    this.commands = [];
    this.polls = [];
    this.open.clear();
    this.limit = kShown;
    this.detail.hidden = true;
    this.draw();
  }

  private showMore(): void {
    this.limit += 2 * kShown;
    this.draw();
  }

  private wanted(row: Row, words: string[]): boolean {
    if (this.pausedAt !== null && row.event.number > this.pausedAt) return false;
    const past = this.state.past;
    if (past && isAfter(row.event, past)) return false;
    if (this.source.value && row.event.source !== this.source.value) return false;
    if (words.length === 0) return true;
    row.searched ??=
      `${row.type} ${row.event.id} ${row.summary} ${row.event.source} ${row.event.peer} ${this.isText(row.event) ? decoder.decode(row.event.data) : ''}`.toLowerCase();
    return words.every((word) => row.searched!.includes(word));
  }

  /** The latest rows that pass the filter, the latest first, at most `most`. */
  private latest(most: number): Row[] {
    const words = this.filter.value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    const found: Row[] = [];
    const polls = this.quiet.checked ? [] : this.polls;
    let c = this.commands.length - 1,
      p = polls.length - 1;
    while (found.length < most && (c >= 0 || p >= 0)) {
      const command = this.commands[c],
        poll = polls[p];
      const later = !poll || (command && command.event.number > poll.event.number);
      const row = later ? command! : poll!;
      if (later) --c;
      else --p;
      if (this.wanted(row, words)) found.push(row);
    }
    return found;
  }

  private draw(): void {
    this.drawn = performance.now();
    if (!this.element.offsetParent) return;
    const shown = this.latest(this.limit);
    this.body.replaceChildren(...shown.map((row) => this.line(row)));
    this.more.hidden = shown.length < this.limit;
    const held = this.pausedAt === null ? '' : `, ${this.last - this.pausedAt} newer hidden`;
    const gone = this.dropped > 0n ? `; ${this.dropped} older ones dropped` : '';
    text(this.note, `${shown.length} shown of ${this.commands.length} commands${held}${gone}`);
  }

  /** Closes the details of an event; false where none are open. */
  closeDetail(): boolean {
    if (this.detail.hidden || !this.element.offsetParent) return false;
    this.detail.hidden = true;
    return true;
  }

  private isText(event: WireEvent): boolean {
    return this.wire === 'crcl' || event.source === 'page';
  }

  private line(row: Row): HTMLElement {
    const {event} = row;
    const show = button(row.type || '?', () => this.show(row), {class: 'link'});
    const client = this.wire === 'crcl' || event.source === 'page' ? event.source : event.peer;
    const from = client.replace('crcl.', '');
    return h(
      'tr',
      {class: row.bad ? 'bad' : '', title: event.peer},
      h(
        'td',
        {},
        h('time', {title: 'wall time'}, wallClock(event.timeS)),
        h('small', {title: 'simulated time'}, simSeconds(event.simTimeS))
      ),
      h('td', {}, event.fromClient ? '→' : '←'),
      h('td', {}, show, h('small', {}, `${from} · ${event.id}`)),
      h('td', {class: 'summary'}, row.summary),
      h('td', {}, row.latency)
    );
  }

  private show(row: Row): void {
    const {event} = row;
    const cut = Number(event.dataBytes) - event.data.length;
    this.detail.hidden = false;
    this.detail.replaceChildren(
      h(
        'div',
        {class: 'row'},
        h('strong', {}, `${row.type} ${event.fromClient ? 'from' : 'to'} ${event.peer}`),
        button('Close', () => void this.closeDetail())
      ),
      row.summary ? h('p', {}, row.summary) : '',
      this.content(event),
      cut > 0 ? h('small', {}, `${cut} further bytes were dropped.`) : ''
    );
    this.detail.scrollIntoView({block: 'nearest'});
  }

  private content(event: WireEvent): HTMLElement {
    if (event.source === 'page') return h('pre', {tabindex: 0}, pretty(decoder.decode(event.data)));
    if (this.wire === 'crcl') return prettyXml(decoder.decode(event.data));
    return h('pre', {tabindex: 0}, modbusDump(event.data));
  }

  private save(format: 'json' | 'text'): void {
    const rows = this.latest(Infinity).reverse();
    const lines = rows.map((row) => (format === 'json' ? this.asJson(row) : this.asText(row)));
    const name = `${this.state.cell?.scene ?? 'cell'}-${this.wire}.${format === 'json' ? 'jsonl' : 'txt'}`;
    download(
      name,
      new Blob(
        lines.map((line) => line + '\n'),
        {type: format === 'json' ? 'application/jsonl' : 'text/plain'}
      )
    );
  }

  private data(event: WireEvent): string {
    return this.isText(event) ? decoder.decode(event.data) : hexOf(event.data);
  }

  private asJson({event, summary, latency, bad}: Row): string {
    return JSON.stringify({
      wall_time: new Date(event.timeS * 1000).toISOString(),
      sim_time_s: Number(event.simTimeS.toFixed(6)),
      epoch: Number(event.epoch),
      source: event.source,
      peer: event.peer,
      from_client: event.fromClient,
      poll: event.poll,
      type: event.type || undefined,
      id: Number(event.id),
      state: summary,
      bad,
      duration_ms: latency === '' ? undefined : Number(latency),
      data: this.data(event),
      data_bytes: Number(event.dataBytes)
    });
  }

  private asText({event, type, summary, latency}: Row): string {
    const way = event.fromClient ? 'from' : 'to';
    const took = latency === '' ? '' : ` (${latency} ms)`;
    return `${new Date(event.timeS * 1000).toISOString()}  ${event.simTimeS.toFixed(3)} s of run ${event.epoch}  ${event.source} ${way} ${event.peer}  ${type} ${event.id}: ${summary}${took}\n    ${this.data(event)}`;
  }
}

/** Whether an event came after the shown moment of the past. */
function isAfter(event: WireEvent, past: Snapshot): boolean {
  if (event.epoch !== past.epoch) return event.epoch > past.epoch;
  return event.simTimeS > simTime(past) + 1e-9;
}

function pretty(json: string): string {
  try {
    return JSON.stringify(JSON.parse(json), null, 2);
  } catch {
    return json;
  }
}
