// Buttons that jog a robot, while held or by one step a click. The daemon stops the robot when a held
// button is not renewed; leaving the page, the button or the window ends the jog at once. All robots
// share one speed and one step.
import type {MessageInitShape} from '@bufbuild/protobuf';
import type {ViewerRequestSchema} from '../protocol';
import {kNotReady} from '../robot_status';
import type {State} from '../state';
import {h, notify, text} from './dom';
import type {Access} from './access';
import {units} from './units';

type Body = Extract<
  NonNullable<MessageInitShape<typeof ViewerRequestSchema>['body']>,
  {case: 'jog'}
>;
export type Direction = NonNullable<Body['value']['direction']>;

const kRenew_ms = 100;
const kRefusal_ms = 500;
/** Steps of the tool, and of joints and rotations, in display units. */
const kLengthSteps = {
  mm: [0.1, 1, 10, 50],
  m: [0.0001, 0.001, 0.01, 0.05],
  in: [0.005, 0.05, 0.5, 2]
};
const kAngleSteps = {deg: [0.1, 1, 5, 15], rad: [0.001, 0.02, 0.1, 0.25]};

export class Jog {
  /** Controls for speed and steps. */
  readonly element: HTMLElement;
  private readonly speed = h('input', {
    type: 'range',
    min: 1,
    max: 100,
    value: 100,
    'aria-label': 'Highest speed of the tool in jogs and moves',
    title:
      'Speed limit of the tool in jogs and moves from this page, as in mode T1; joints and rotations scale with it',
    'data-testid': 'jog-speed'
  });
  private readonly shownSpeed = h('output', {'data-testid': 'jog-speed-text'});
  private readonly mode = h('select', {
    'aria-label': 'Jog while held, or by steps',
    title: 'Jog while the button is held, or by one step a click',
    'data-testid': 'jog-step'
  });
  private timer = 0;
  private robot = -1;
  private pressed: HTMLButtonElement | null = null;
  /** Its place when it was pressed; the layout may move it later. */
  private place: DOMRect | null = null;
  private complained = '';
  private ready = 0; // when the jogged robot was last seen ready

  constructor(
    private readonly state: State,
    private readonly access: Access
  ) {
    this.element = h(
      'div',
      {class: 'row jog-bar', role: 'group', 'aria-label': 'Jogs'},
      h('span', {}, 'jog'),
      this.speed,
      this.shownSpeed,
      this.mode
    );
    this.speed.addEventListener('input', () => this.showSpeed());
    this.showUnits();
    units.changed.on(() => this.showUnits());
    state.cellChanged.on(() => this.showSpeed());
    for (const event of ['blur', 'pagehide']) addEventListener(event, () => this.end());
    document.addEventListener('visibilitychange', () => document.hidden && this.end());
    for (const event of ['pointerup', 'pointercancel']) addEventListener(event, () => this.end());
    addEventListener('pointermove', ({clientX: x, clientY: y}) => {
      const at = this.place;
      if (at && (x < at.left || x > at.right || y < at.top || y > at.bottom)) this.end();
    });
    document.documentElement.addEventListener('pointerleave', () => this.place && this.end());
    state.accessChanged.on(() => this.state.lockedReason && this.end());
    // A button that is disabled while pressed may not receive its release.
    state.display.on(() => this.pressed?.disabled && this.end());
  }

  /** Share of the highest speed for moves and jogs from the page. */
  get share(): number {
    return Number(this.speed.value) / 100;
  }

  /** A button that jogs `robot` in one direction, also with Space and Enter. */
  makeButton(
    label: string,
    name: string,
    robot: number,
    direction: () => Direction
  ): HTMLButtonElement {
    const element = h(
      'button',
      {
        type: 'button',
        class: 'jog',
        'aria-label': name,
        'data-testid': `jog ${name}`,
        title: `Jogs ${name}`
      },
      label
    );
    element.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || element.disabled) return;
      event.preventDefault();
      element.focus();
      if (this.stepping) return;
      this.begin(element, robot, direction());
      this.place = element.getBoundingClientRect();
    });
    element.addEventListener('click', () => {
      if (this.stepping) void this.step(element, robot, direction());
    });
    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('keydown', (event) => {
      if (event.key !== ' ' && event.key !== 'Enter') return;
      if (!this.stepping || event.repeat) event.preventDefault(); // a step is made by the click
      if (!this.stepping && !event.repeat) this.begin(element, robot, direction());
    });
    element.addEventListener('keyup', () => this.end());
    element.addEventListener('blur', () => this.pressed === element && this.end());
    return this.access.guard(element, () => {
      const state = this.state.snapshot?.robots[robot];
      if (!state || state.initialized) {
        if (this.pressed === element) this.ready = performance.now();
        return '';
      }
      // Near the end of its reach a robot refuses part of the jog and is made ready again.
      const shortly = this.pressed === element && performance.now() - this.ready < kRefusal_ms;
      return shortly && !state.protectiveStop ? '' : kNotReady;
    });
  }

  private get stepping(): boolean {
    return this.mode.value !== '';
  }

  private slides(robot: number, joint: number): boolean {
    return this.state.cell?.robots[robot]?.joints[joint]?.prismatic ?? false;
  }

  private showUnits(): void {
    const {value} = this.mode;
    this.mode.replaceChildren(
      h('option', {value: ''}, 'while held'),
      ...kLengthSteps[units.length].map((length, i) =>
        h(
          'option',
          {value: i},
          `${length} ${units.length}, ${kAngleSteps[units.angle][i]} ${units.angle}`
        )
      )
    );
    this.mode.value = value;
    this.showSpeed();
  }

  private showSpeed(): void {
    const most_m_s = this.state.welcome?.manualSpeedMS ?? 0;
    const shown = units.speedText(this.share * most_m_s);
    text(this.shownSpeed, shown);
    this.speed.setAttribute('aria-valuetext', shown);
  }

  private async step(
    element: HTMLButtonElement,
    robot: number,
    direction: Direction
  ): Promise<void> {
    const size = Number(this.mode.value);
    const along =
      direction.case === 'joint'
        ? this.slides(robot, direction.value.joint ?? 0)
        : direction.case === 'tool' && direction.value.along !== undefined;
    const step = along
      ? units.metres(kLengthSteps[units.length][size]!)
      : units.radians(kAngleSteps[units.angle][size]!);
    element.classList.add('held');
    const waiting = Number(element.dataset.steps ?? 0) + 1;
    element.dataset.steps = String(waiting);
    try {
      // The answer comes when the step has been made.
      await this.state.connection.request(
        {case: 'jog', value: {robot, direction, speed: this.share, step}},
        Infinity
      );
    } catch (problem) {
      notify(units.inText((problem as Error).message), 'error');
    }
    const left = Number(element.dataset.steps) - 1;
    element.dataset.steps = String(left);
    element.classList.toggle('held', left > 0);
  }

  private begin(element: HTMLButtonElement, robot: number, direction: Direction): void {
    this.end();
    this.pressed = element;
    this.robot = robot;
    this.complained = '';
    this.ready = performance.now();
    element.classList.add('held');
    const speed = this.share;
    const renew = (): void => {
      this.state.connection
        .request({case: 'jog', value: {robot, direction, speed}})
        .catch((problem: Error) => {
          if (this.pressed === element && this.complained !== problem.message)
            notify(units.inText((this.complained = problem.message)), 'error');
        });
    };
    renew();
    this.timer = window.setInterval(renew, kRenew_ms);
  }

  private end(): void {
    if (!this.pressed) return;
    clearInterval(this.timer);
    this.pressed.classList.remove('held');
    this.pressed = this.place = null;
    this.state.connection.send({
      case: 'jog',
      value: {robot: this.robot, direction: {case: undefined}, speed: 1}
    });
  }
}
