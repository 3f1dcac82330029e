// Buttons that move a robot only while they are held. The daemon stops the robot when it does not
// hear of the button for a moment; leaving the page, the button or the window ends it at once.
import type {State} from '../state';
import {h, notify} from './dom';
import type {Access} from './access';

export type Direction =
  | {case: 'joint'; value: {joint: number; negative: boolean}}
  | {
      case: 'tool';
      value: {
        along?: {x: number; y: number; z: number};
        about?: {x: number; y: number; z: number};
        inToolFrame: boolean;
      };
    };

const kRenew_ms = 100;

export class Jog {
  private timer = 0;
  private robot = -1;
  private pressed: HTMLButtonElement | null = null;
  private complained = '';

  constructor(
    private readonly state: State,
    private readonly access: Access
  ) {
    for (const event of ['blur', 'pagehide']) addEventListener(event, () => this.end());
    document.addEventListener('visibilitychange', () => document.hidden && this.end());
    for (const event of ['pointerup', 'pointercancel']) addEventListener(event, () => this.end());
    state.accessChanged.on(() => this.state.lockedReason && this.end());
    // A button that is disabled under the finger may never hear of its release.
    state.display.on(() => this.pressed?.disabled && this.end());
  }

  /** A button that jogs `robot` one way. Space and Enter hold it as well. */
  makeButton(
    label: string,
    name: string,
    robot: number,
    direction: () => Direction,
    speed: () => number
  ): HTMLButtonElement {
    const element = h(
      'button',
      {
        type: 'button',
        class: 'jog',
        'aria-label': name,
        'data-testid': `jog ${name}`,
        title: `Hold: ${name}`
      },
      label
    );
    const begin = (): void => this.begin(element, robot, direction(), speed());
    element.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || element.disabled) return;
      event.preventDefault();
      element.focus();
      begin();
    });
    element.addEventListener('pointerleave', () => this.pressed === element && this.end());
    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('keydown', (event) => {
      if ((event.key === ' ' || event.key === 'Enter') && !event.repeat) begin();
      if (event.key === ' ' || event.key === 'Enter') event.preventDefault();
    });
    element.addEventListener('keyup', () => this.end());
    element.addEventListener('blur', () => this.pressed === element && this.end());
    return this.access.guard(element, () => {
      const state = this.state.snapshot?.robots[robot];
      return state && !state.initialized ? 'The robot is not ready: make it ready first.' : '';
    });
  }

  private begin(
    element: HTMLButtonElement,
    robot: number,
    direction: Direction,
    speed: number
  ): void {
    this.end();
    this.pressed = element;
    this.robot = robot;
    this.complained = '';
    element.classList.add('held');
    const renew = (): void => {
      this.state.connection
        .request({case: 'jog', value: {robot, direction, speed}})
        .catch((problem: Error) => {
          if (this.pressed === element && this.complained !== problem.message)
            notify((this.complained = problem.message), 'error');
        });
    };
    renew();
    this.timer = window.setInterval(renew, kRenew_ms);
  }

  private end(): void {
    if (!this.pressed) return;
    clearInterval(this.timer);
    this.pressed.classList.remove('held');
    this.pressed = null;
    this.state.connection.send({
      case: 'jog',
      value: {robot: this.robot, direction: {case: undefined}, speed: 1}
    });
  }
}
