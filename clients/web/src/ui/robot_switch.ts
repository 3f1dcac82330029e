// State, speed and Stop of every robot, always in view; one robot is chosen for the pendant.
import type {RobotDescription, Snapshot} from '../protocol';
import {statusOf} from '../robot_status';
import {Signal, type State} from '../state';
import type {Access} from './access';
import {button, h, text} from './dom';
import {units} from './units';

const kFew = 2; // that have a row each

interface Row {
  name: HTMLButtonElement;
  state: HTMLElement;
  speed: HTMLElement;
  why: HTMLElement;
}

export class RobotSwitch {
  readonly element = h('section', {class: 'robot-switch', 'aria-label': 'Robots'});
  readonly changed = new Signal<number>();
  /** The pendant of the chosen robot was requested. */
  readonly wanted = new Signal<void>();
  chosen = 0;
  private rows: Row[] = [];

  constructor(
    private readonly state: State,
    private readonly access: Access
  ) {
    state.cellChanged.on((cell) => this.build(cell.robots));
    state.display.on((snapshot) => this.show(snapshot));
  }

  choose(index: number): void {
    const robot = this.state.cell?.robots[index];
    if (!robot) return;
    this.chosen = index;
    localStorage.setItem('robot', robot.name);
    this.rows.forEach((row, i) => row.name.setAttribute('aria-pressed', String(i === index)));
    this.changed.emit(index);
  }

  chooseNext(): void {
    this.choose((this.chosen + 1) % Math.max(1, this.rows.length));
    this.wanted.emit();
  }

  private build(robots: RobotDescription[]): void {
    this.rows = robots.map((robot, i) => ({
      name: button(
        robot.name,
        () => {
          this.choose(i);
          this.wanted.emit();
        },
        {
          class: 'name',
          title: `Show the pendant of ${robot.name}`,
          'data-testid': `choose-${robot.name}`
        }
      ),
      state: h('span', {class: 'state', 'data-testid': `state-${robot.name}`}),
      speed: h('output', {
        title: 'Speed of the tool',
        'aria-label': `Speed of ${robot.name}'s tool`,
        'data-testid': `speed-${robot.name}`
      }),
      why: h('p', {class: 'why', 'aria-live': 'polite', 'data-testid': `why-${robot.name}`})
    }));
    this.element.hidden = robots.length === 0;
    this.element.classList.toggle('many', robots.length > kFew);
    this.element.replaceChildren(
      ...this.rows.map(({name, state, speed, why}, i) =>
        h('div', {class: 'robot-row'}, name, state, speed, this.stopButton(robots[i]!.name, i), why)
      )
    );
    const known = robots.findIndex((robot) => robot.name === localStorage.getItem('robot'));
    this.choose(Math.max(0, known));
  }

  private stopButton(name: string, robot: number): HTMLButtonElement {
    return this.access.guard(
      button(
        'Stop',
        () =>
          void this.access.command({
            case: 'robot',
            value: {robot, action: {case: 'stop', value: {}}}
          }),
        {
          class: 'danger',
          'aria-label': `Stop ${name}`,
          'data-testid': `stop-${name}`,
          title: 'Stop all motion of this robot (s stops all robots)'
        }
      )
    );
  }

  private show(snapshot: Snapshot): void {
    this.rows.forEach(({state, speed, why}, i) => {
      const robot = snapshot.robots[i];
      if (!robot) return;
      const status = statusOf(robot);
      text(state, status.text);
      state.dataset.state = status.look;
      text(why, status.stopped ? units.inText(robot.action?.description ?? '') : '');
      const v = robot.toolVelocityMS;
      text(speed, v ? `${units.lengthText(Math.hypot(v.x, v.y, v.z))} ${units.length}/s` : '–');
    });
  }
}
