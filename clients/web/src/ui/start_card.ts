// Where to start: in the view until something has run.
import type {State} from '../state';
import type {Access} from './access';
import {button, h, notify} from './dom';
import {kDemo, type Programs} from './programs';

export class StartCard {
  readonly element = h('aside', {
    class: 'start',
    hidden: true,
    'aria-label': 'Where to start',
    'data-testid': 'start'
  });
  private closed = false;

  /** `showScenarios` opens the panel with scenarios and faults. */
  constructor(
    private readonly state: State,
    access: Access,
    programs: Programs,
    showScenarios: () => void
  ) {
    const run = access.guard(
      button(
        'Run the demo',
        () =>
          void programs.start(kDemo).catch((problem: Error) => notify(problem.message, 'error')),
        {
          class: 'primary',
          'data-testid': 'start-demo',
          title: 'Starts a controller that fills kits with gears and empties them again'
        }
      ),
      () => programs.refusal(kDemo),
      false,
      'admin'
    );
    this.element.append(
      h('p', {}, 'Nothing has run in this cell yet.'),
      run,
      button('Scenarios and faults', showScenarios, {'data-testid': 'start-scenarios'}),
      button('×', () => void this.close(), {class: 'icon', 'aria-label': 'Close'})
    );
    for (const signal of [state.programsChanged, state.display]) signal.on(() => this.show());
  }

  /** Returns false where it is not shown. */
  close(): boolean {
    if (this.element.hidden) return false;
    this.closed = this.element.hidden = true;
    return true;
  }

  private show(): void {
    this.element.hidden = this.closed || !this.offers() || this.hasRun();
  }

  private offers(): boolean {
    const {programs, past} = this.state;
    return !past && programs !== null && programs.refusal === '' && programs.offers.length > 0;
  }

  /** Whether a program, a robot or the belt has been commanded since the daemon's start or a reset. */
  private hasRun(): boolean {
    const {programs, live} = this.state;
    if (programs?.name) return true;
    const belt = live?.conveyor;
    return (
      (live?.robots.some((robot) => robot.action?.ticket) ?? false) ||
      Boolean(belt && (belt.run || belt.travelM !== 0))
    );
  }
}
