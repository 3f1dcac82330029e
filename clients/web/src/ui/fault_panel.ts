// Faults that the daemon has recorded: one entry a cause, and a timeline.
import {FaultSeverity, type Fault, type FaultList, type Snapshot} from '../protocol';
import {simTime, type State} from '../state';
import {button, card, h} from './dom';
import {saveIncident} from './incident';
import {simSeconds, wallClock} from './time';
import {units} from './units';

const kSpan_s = 300;
const kKinds: Record<number, string> = {
  [FaultSeverity.UNSPECIFIED]: 'note',
  [FaultSeverity.NOTE]: 'note',
  [FaultSeverity.WARNING]: 'warning',
  [FaultSeverity.ERROR]: 'error',
  [FaultSeverity.STOP]: 'stop'
};

const serious = (fault: Fault): boolean => fault.severity >= FaultSeverity.ERROR;

export class FaultPanel {
  readonly element = h('div', {class: 'panel faults'});
  readonly count = h('span', {class: 'count', hidden: true, 'data-testid': 'fault-count'});
  private readonly list = h('ol', {class: 'fault-list', 'data-testid': 'faults'});
  private readonly lanes = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  private readonly note = h('small', {});
  private all: Fault[] = [];
  private readonly cleared = new Map<bigint, bigint>(); // cleared on this page, with their counts then

  constructor(private readonly state: State) {
    this.lanes.setAttribute('class', 'timeline');
    this.lanes.setAttribute('role', 'img');
    this.lanes.setAttribute('aria-label', 'Faults over the last five minutes of simulated time');
    this.element.append(
      card(
        'Faults',
        this.lanes,
        this.list,
        this.note,
        h(
          'div',
          {class: 'row'},
          button('Clear', () => this.clear(), {
            title: 'Hide faults that are over; the daemon keeps them'
          }),
          button('Save this incident', () => void saveIncident(), {
            'data-testid': 'save-incident',
            title: 'Save the last minute of simulated time as a file for aprsim replay'
          })
        )
      )
    );
    state.faultsChanged.on((list) => this.take(list));
    state.display.on((snapshot) => this.drawLanes(snapshot));
    units.changed.on(() => this.draw());
    state.accessChanged.on(() => {
      // A restarted daemon numbers its faults from the start.
      if (!state.connected) this.cleared.clear();
    });
  }

  private take(list: FaultList): void {
    this.all = list.faults;
    this.note.textContent = list.discarded ? `${list.discarded} older entries were discarded.` : '';
    this.draw();
  }

  /** Lasting faults first, then the latest. */
  private get shown(): Fault[] {
    const first = (fault: Fault): boolean => fault.active && serious(fault);
    return this.all
      .filter((fault) => fault.active || this.cleared.get(fault.id) !== fault.count)
      .sort(
        (a, b) =>
          Number(first(b)) - Number(first(a)) ||
          (first(a) ? b.severity - a.severity : 0) ||
          (b.last?.timeS ?? 0) - (a.last?.timeS ?? 0)
      );
  }

  private clear(): void {
    for (const fault of this.all) this.cleared.set(fault.id, fault.count);
    this.draw();
  }

  private draw(): void {
    const shown = this.shown;
    const marked = shown.filter(serious);
    const stops = marked.filter((fault) => fault.severity === FaultSeverity.STOP);
    this.count.hidden = marked.length === 0;
    this.count.textContent = String(marked.length);
    this.count.dataset.kind = stops.length > 0 ? 'stop' : 'error';
    this.count.title = `${stops.length} stopped something, ${marked.length - stops.length} were errors`;
    this.list.replaceChildren(
      ...(shown.length
        ? shown.map((fault) => this.line(fault))
        : [h('li', {'data-kind': 'none'}, 'No faults.')])
    );
  }

  private line(fault: Fault): HTMLElement {
    const kind = kKinds[fault.severity] ?? 'note';
    return h(
      'li',
      {'data-kind': kind},
      h(
        'div',
        {},
        h('strong', {}, fault.source),
        h('span', {class: 'kind'}, fault.active ? `${kind}, lasts` : kind),
        fault.count > 1n ? h('span', {class: 'times'}, `${fault.count}×`) : null
      ),
      h('div', {}, units.inText(fault.message)),
      h('small', {}, this.when(fault))
    );
  }

  private when(fault: Fault): string {
    const {first, last} = fault;
    if (!first || !last) return '';
    const now = this.state.snapshot?.epoch;
    const at = (time: typeof last): string =>
      `${simSeconds(time.simTimeS)}${now !== undefined && time.epoch !== now ? ` of run ${time.epoch}` : ''}, ${wallClock(time.timeS)}`;
    return fault.count > 1n ? `last ${at(last)}; first ${at(first)}` : at(last);
  }

  private drawLanes(snapshot: Snapshot): void {
    if (!this.element.offsetParent) return;
    const lanes = [
      'cell',
      ...(this.state.cell?.robots.map((r) => r.name) ?? []),
      'belt',
      'physics',
      'simulation'
    ];
    const width = Math.max(200, this.lanes.clientWidth),
      height = 20 * lanes.length + 16,
      left = 72;
    this.lanes.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.lanes.setAttribute('height', String(height));
    const now = simTime(snapshot),
      from = Math.max(0, now - kSpan_s);
    const x = (t: number): number =>
      left + ((Math.max(t, from) - from) / Math.max(10, now - from)) * (width - left - 8);
    const pieces: SVGElement[] = [];
    const make = (tag: string, attributes: Record<string, string | number>, content = ''): void => {
      const piece = document.createElementNS('http://www.w3.org/2000/svg', tag);
      for (const [name, value] of Object.entries(attributes))
        piece.setAttribute(name, String(value));
      piece.textContent = content;
      pieces.push(piece);
    };
    lanes.forEach((lane, i) => {
      make('text', {x: 0, y: 20 * i + 14}, lane);
      make('line', {x1: left, x2: width - 4, y1: 20 * i + 10, y2: 20 * i + 10});
    });
    for (const {source, severity, first, last, active} of this.shown) {
      const lane = lanes.indexOf(source);
      if (lane < 0 || !last || last.epoch !== snapshot.epoch) continue;
      const end = active ? now : last.simTimeS;
      if (end < from) continue;
      const kind = kKinds[severity] ?? 'note',
        y = 20 * lane + 10;
      // A circle at the last occurrence, a line while it lasts, a small circle at the first one.
      make('circle', {cx: x(last.simTimeS), cy: y, r: kind === 'note' ? 3 : 5, class: kind});
      if (active)
        make('line', {x1: x(last.simTimeS), x2: x(end), y1: y, y2: y, class: `${kind} span`});
      if (first && first.epoch === last.epoch && first.simTimeS >= from)
        make('circle', {cx: x(first.simTimeS), cy: y, r: 3, class: kind});
    }
    make('text', {x: left, y: height - 2, class: 'axis'}, simSeconds(from));
    make('text', {x: width - 8, y: height - 2, class: 'axis end'}, simSeconds(now));
    this.lanes.replaceChildren(...pieces);
  }
}
