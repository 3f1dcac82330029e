// The daemon's programs: starting the demo and scenarios, and their progress.
import type {OrderProgress, ProgramStatus} from '../protocol';
import type {State} from '../state';
import type {Access} from './access';
import {button, card, h, text} from './dom';
import {kDemo, type Programs} from './programs';
import {simSeconds} from './time';

export class RunCard {
  readonly element: HTMLElement;
  private readonly choice = h('select', {'data-testid': 'scenario'});
  private readonly description = h('p', {class: 'meaning'});
  private readonly seed = h('input', {
    inputmode: 'numeric',
    autocomplete: 'off',
    placeholder: '1',
    'data-testid': 'seed'
  });
  private readonly now = h('output', {'data-testid': 'program-state'}, '–');
  private readonly complaint = h('p', {
    class: 'complaint',
    role: 'alert',
    'data-testid': 'program-complaint'
  });
  private readonly orders = h('ul', {class: 'orders', 'data-testid': 'orders'});
  private readonly lines = h('pre', {tabindex: 0, 'data-testid': 'program-lines'});
  private readonly report = h('pre', {tabindex: 0, 'data-testid': 'program-report'});
  private readonly waits: HTMLElement;
  private readonly said = h(
    'details',
    {class: 'said', hidden: true},
    h('summary', {}, 'Output'),
    this.lines
  );
  private readonly reported = h(
    'details',
    {class: 'said report', hidden: true, open: true},
    h('summary', {}, 'Report'),
    this.report
  );

  constructor(
    private readonly state: State,
    private readonly access: Access,
    private readonly programs: Programs,
    edit: (name: string) => void
  ) {
    this.waits = h(
      'div',
      {class: 'row', hidden: true, 'data-testid': 'program-waits'},
      'The cell is paused.',
      access.guard(button('Resume', () => void access.command({case: 'resume', value: {}})))
    );
    const demo = access.guard(
      button('Run the demo', () => void this.start(kDemo), {
        'data-testid': 'run-demo',
        title:
          'Starts a controller that fills kits with gears and empties them again, until it is stopped'
      }),
      () => programs.refusal(kDemo),
      false,
      'admin'
    );
    const run = access.guard(
      button('Run', () => void this.start(this.choice.value), {
        'data-testid': 'run-scenario',
        title: 'Resets the cell and runs the scenario'
      }),
      () => programs.refusal(this.choice.value),
      false,
      'admin'
    );
    const stop = access.guard(
      button('Stop', () => void this.stop(), {'data-testid': 'stop-program'}),
      () => this.status?.refusal || (this.status?.running ? '' : 'Nothing is running.'),
      false,
      'admin'
    );
    const editing = (
      [
        ['Edit', 'edit-scenario', 'Opens this scenario in the editor', () => this.choice.value],
        [
          'Scenario editor',
          'scenario-editor',
          'Begins a scenario, or goes on with the last',
          () => ''
        ]
      ] as const
    ).map(([label, id, title, name]) =>
      access.guard(
        button(label, () => edit(name()), {'data-testid': id, title}),
        undefined,
        true,
        'admin'
      )
    );
    this.choice.addEventListener('change', () => this.describe());
    this.element = card(
      'Demo and scenarios',
      h('div', {class: 'row'}, demo, stop, this.now),
      h('fieldset', {}, h('label', {}, 'scenario', this.choice), h('label', {}, 'seed', this.seed)),
      this.description,
      h('div', {class: 'row'}, run, ...editing),
      this.complaint,
      this.waits,
      this.orders,
      this.said,
      this.reported
    );
    state.programsChanged.on((status) => this.show(status));
    state.display.on(({paused}) => {
      this.waits.hidden = !paused || !this.status?.running || state.past !== null;
    });
  }

  private get status(): ProgramStatus | null {
    return this.state.programs;
  }

  private async start(name: string): Promise<void> {
    const typed = this.seed.value.trim();
    const ofScenario = this.status?.offers.some((o) => o.name === name && o.scenario);
    if (ofScenario && typed !== '' && !/^\d{1,18}$/.test(typed)) {
      text(this.complaint, `seed: “${typed}” is not a whole number from 0`);
      return;
    }
    const seed = ofScenario && typed !== '' ? BigInt(typed) : undefined;
    await this.attempt(this.programs.start(name, seed));
  }

  private async stop(): Promise<void> {
    await this.attempt(this.programs.stop());
  }

  private async attempt(request: Promise<void>): Promise<void> {
    try {
      await request;
      text(this.complaint, '');
    } catch (problem) {
      text(this.complaint, (problem as Error).message);
    }
  }

  private show(status: ProgramStatus): void {
    const scenarios = status.offers.filter((offer) => offer.scenario).map(({name}) => name);
    if ([...this.choice.options].map(({value}) => value).join() !== scenarios.join()) {
      this.choice.replaceChildren(
        ...scenarios.map((name) => h('option', {value: name}, name.replaceAll('_', ' ')))
      );
      this.describe();
    }
    text(this.now, stateOf(status));
    this.now.dataset.state = status.running ? 'busy' : status.failed ? 'bad' : '';
    this.orders.replaceChildren(...status.orders.map(line));
    text(this.lines, status.lines.slice().reverse().join('\n'));
    this.said.hidden = status.lines.length === 0;
    text(this.report, status.report);
    this.reported.hidden = status.report === '';
    this.access.update();
  }

  private describe(): void {
    const chosen = this.status?.offers.find(({name}) => name === this.choice.value);
    text(this.description, chosen ? chosen.description + '.' : '');
  }
}

function stateOf(status: ProgramStatus): string {
  if (!status.name) return status.refusal || 'nothing is running';
  const parts = status.placed === 1 ? '1 part placed' : `${status.placed} parts placed`;
  const time = status.timeS > 0 ? `, ${simSeconds(status.timeS)}` : '';
  if (status.stopping && status.running) return `${status.name} is stopping`;
  if (status.running) return `${status.name} running: ${parts}${time}`;
  return `${status.name}: ${status.endReason}; ${parts}${time}`;
}

function line(order: OrderProgress): HTMLElement {
  const {name, state, kits, done, parts, partsWanted} = order;
  return h(
    'li',
    {'data-state': state},
    h(
      'div',
      {},
      h('span', {}, name),
      h('small', {}, `${state}: ${done} of ${kits} kits, ${parts} of ${partsWanted} parts`)
    ),
    h('progress', {max: Math.max(1, partsWanted), value: parts, 'aria-label': `Parts of ${name}`})
  );
}
