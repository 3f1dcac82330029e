// What went wrong and what tripped, on a line of simulated time.
import {ActionState, DriveFault, type Snapshot} from '../protocol';
import {simTime, type State} from '../state';
import {button, card, h} from './dom';

interface Fault {
  time: number;
  epoch: bigint;
  lane: string;
  kind: 'error' | 'trip' | 'note';
  message: string;
}

const kMost = 300;
const kSpan_s = 300;

export class FaultPanel {
  readonly element = h('div', {class: 'panel faults'});
  readonly count = h('span', {class: 'count', hidden: true});
  private readonly list = h('ol', {class: 'fault-list', 'data-testid': 'faults'});
  private readonly lanes = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  private faults: Fault[] = [];
  private before: Snapshot | null = null;
  private shown = -1;

  constructor(private readonly state: State) {
    this.lanes.setAttribute('class', 'timeline');
    this.lanes.setAttribute('role', 'img');
    this.lanes.setAttribute('aria-label', 'Faults over the last five minutes of simulated time');
    this.element.append(
      card(
        'Faults',
        this.lanes,
        this.list,
        button('Clear', () => this.clear())
      )
    );
    state.snapshotChanged.on((snapshot) => this.look(snapshot));
    state.display.on((snapshot) => this.draw(snapshot));
  }

  private add(snapshot: Snapshot, lane: string, kind: Fault['kind'], message: string): void {
    this.faults.push({time: simTime(snapshot), epoch: snapshot.epoch, lane, kind, message});
    if (this.faults.length > kMost) this.faults.shift();
    this.count.hidden = false;
    this.count.textContent = String(this.faults.length);
  }

  private look(now: Snapshot): void {
    const before = this.before;
    this.before = now;
    if (!before || before.instanceId !== now.instanceId) return;
    if (before.epoch !== now.epoch) return this.add(now, 'cell', 'note', 'reset');
    now.robots.forEach((robot, i) => {
      const old = before.robots[i],
        name = robot.name;
      if (!old) return;
      if (robot.protectiveStop && !old.protectiveStop)
        this.add(now, name, 'trip', robot.action?.description || 'protective stop');
      else if (
        robot.action?.state === ActionState.ERROR &&
        (old.action?.state !== ActionState.ERROR ||
          old.action.description !== robot.action.description)
      ) {
        this.add(now, name, 'error', robot.action.description);
      } else if (
        old.action?.state === ActionState.ERROR &&
        robot.action?.state !== ActionState.ERROR
      )
        this.add(now, name, 'note', 'error cleared');
      if (old.gripper?.holding && !robot.gripper?.holding && robot.gripper!.setting < 0.5) {
        this.add(now, name, 'error', `lost ${old.gripper.heldBody} from the closed gripper`);
      }
    });
    const fault = now.conveyor?.fault,
      old = before.conveyor?.fault;
    if (fault !== old) {
      const message =
        fault === DriveFault.EMERGENCY_STOP
          ? 'emergency stop'
          : fault === DriveFault.WATCHDOG
            ? 'watchdog: no command in time'
            : fault === DriveFault.LIGHT_CURTAIN
              ? 'stopped by the light curtain'
              : 'fault reset';
      this.add(now, 'belt', fault ? 'trip' : 'note', message);
    }
    if (now.lightCurtain?.broken && !before.lightCurtain?.broken)
      this.add(now, 'cell', 'trip', 'light curtain broken');
    if (now.physicsFaults > before.physicsFaults) {
      this.add(
        now,
        'physics',
        'error',
        `contact deeper than 0.5 mm (${(now.maxPenetrationM * 1e3).toFixed(2)} mm)`
      );
    }
    if (now.worldFault && !before.worldFault) this.add(now, 'physics', 'trip', now.worldFault);
    if (now.missedSteps > before.missedSteps + 50n)
      this.add(
        now,
        'cell',
        'note',
        `${now.missedSteps - before.missedSteps} steps given up: the machine is too slow`
      );
  }

  private clear(): void {
    this.faults = [];
    this.count.hidden = true;
    this.shown = -1;
  }

  private draw(snapshot: Snapshot): void {
    if (!this.element.offsetParent) return;
    this.drawLanes(snapshot);
    if (this.shown === this.faults.length) return;
    this.shown = this.faults.length;
    this.list.replaceChildren(
      ...(this.faults.length
        ? [...this.faults]
            .reverse()
            .map((fault) =>
              h(
                'li',
                {'data-kind': fault.kind},
                h('time', {}, `${fault.time.toFixed(2)} s`),
                h('strong', {}, fault.lane),
                fault.message
              )
            )
        : [h('li', {'data-kind': 'none'}, 'Nothing so far.')])
    );
  }

  private drawLanes(snapshot: Snapshot): void {
    const lanes = [
      'cell',
      ...(this.state.cell?.robots.map((r) => r.name) ?? []),
      'belt',
      'physics'
    ];
    const width = Math.max(200, this.lanes.clientWidth),
      height = 20 * lanes.length + 16,
      left = 64;
    this.lanes.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.lanes.setAttribute('height', String(height));
    const now = simTime(snapshot),
      from = Math.max(0, now - kSpan_s);
    const x = (t: number): number =>
      left + ((t - from) / Math.max(10, now - from)) * (width - left - 8);
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
    for (const fault of this.faults) {
      const lane = lanes.indexOf(fault.lane);
      if (lane < 0 || fault.epoch !== snapshot.epoch || fault.time < from) continue;
      make('circle', {
        cx: x(fault.time),
        cy: 20 * lane + 10,
        r: fault.kind === 'note' ? 3 : 5,
        class: fault.kind
      });
    }
    make('text', {x: left, y: height - 2, class: 'axis'}, `${from.toFixed(0)} s`);
    make('text', {x: width - 8, y: height - 2, class: 'axis end'}, `${now.toFixed(0)} s`);
    this.lanes.replaceChildren(...pieces);
  }
}
