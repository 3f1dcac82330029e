// The bar at the top: state and control of the simulation.
import type {ListenerStatus, Snapshot} from '../protocol';
import {simTime, type State} from '../state';
import type {Access} from './access';
import {button, h, text} from './dom';
import {SavedStates} from './saved_states';
import {simSeconds} from './time';
import {unitChoice} from './units';

export class Toolbar {
  readonly element: HTMLElement;
  private readonly time = h(
    'output',
    {class: 'time', 'data-testid': 'sim-time', title: 'Simulated time since the last reset'},
    '–'
  );
  private readonly factor = h(
    'output',
    {'data-testid': 'rtf', title: 'Simulated to wall time, measured'},
    '–'
  );
  private readonly step = h('output', {title: 'Mean wall time of one physics step'}, '–');
  private readonly clients = button('–', () => this.showListeners(), {
    class: 'link',
    title: 'Clients of all listeners; press for a list',
    'data-testid': 'clients'
  });
  private listeners: ListenerStatus[] = [];
  private readonly listenerRows = h('tbody', {'data-testid': 'listeners'});
  private readonly scene = h('span', {class: 'scene'}, '');
  private readonly connection = h(
    'span',
    {class: 'connection', role: 'status', 'data-testid': 'connection'},
    'connecting'
  );
  private readonly play: HTMLButtonElement;
  private stepping = false; // until the daemon has answered
  private readonly speed: HTMLSelectElement;

  constructor(
    private readonly state: State,
    private readonly access: Access,
    theme: () => void,
    help: () => void
  ) {
    this.play = access.guard(
      button('Pause', () => this.toggle(), {
        class: 'play',
        'data-testid': 'play',
        title: 'Pause or resume (space)'
      })
    );
    const single = access.guard(
      button('Step', () => this.takeSteps(1), {
        'data-testid': 'step',
        title: 'Take one step of 1 ms while paused (.)'
      }),
      () => (state.snapshot?.paused ? '' : 'Pause first.')
    );
    const many = access.guard(
      button('+100', () => this.takeSteps(100), {title: 'Take 100 steps while paused (,)'}),
      () => (state.snapshot?.paused ? '' : 'Pause first.')
    );
    this.speed = access.guard(
      h(
        'select',
        {'aria-label': 'Speed', title: 'Simulated to wall time', onchange: () => this.setSpeed()},
        ...['0.1', '0.25', '0.5', '1', '2', '5', '10', 'max'].map((v) =>
          h('option', {value: v}, v === 'max' ? 'max' : `${v}×`)
        )
      )
    );
    this.speed.value = '1';
    const reset = access.guard(
      button('Reset', () => this.reset(), {
        'data-testid': 'reset',
        title: 'Rebuild the cell from its scene'
      }),
      undefined,
      false,
      'admin'
    );
    const stop = access.guard(
      button('Stop cell', () => this.stopCell(), {
        class: 'danger stop-cell',
        'data-testid': 'stop-cell',
        title: 'Stop all robots and the belt (s or Escape)'
      }),
      () => '',
      true
    );
    const states = new SavedStates(state, access);
    this.element = h(
      'header',
      {class: 'toolbar'},
      h(
        'h1',
        {},
        h(
          'a',
          {class: 'brand', href: '#', 'aria-label': 'aprsim, first view'},
          h('img', {src: 'icon.svg', alt: '', width: 26, height: 26}),
          h('strong', {}, 'aprsim')
        )
      ),
      this.scene,
      this.connection,
      stop,
      h(
        'div',
        {class: 'group', role: 'group', 'aria-label': 'Simulation'},
        this.play,
        single,
        many,
        this.speed,
        reset,
        button('States', () => states.open(), {
          'data-testid': 'states',
          title: 'Save the cell’s state, or continue from a saved one'
        })
      ),
      h(
        'div',
        {class: 'gauges'},
        gauge('time', this.time),
        gauge('real time', this.factor),
        gauge('step', this.step),
        gauge('clients', this.clients)
      ),
      h(
        'div',
        {class: 'group end'},
        unitChoice(),
        h(
          'a',
          {class: 'docs', href: 'docs/', target: '_blank', rel: 'noopener', title: 'Documentation'},
          'Docs'
        ),
        button('◐', theme, {
          class: 'icon',
          'aria-label': 'Dark or light',
          title: 'Dark or light (d)'
        }),
        button('?', help, {
          class: 'icon',
          'aria-label': 'Keyboard shortcuts',
          'data-testid': 'help-button',
          title: 'Keyboard shortcuts (?)'
        })
      )
    );
    state.display.on((snapshot) => this.show(snapshot));
    state.cellChanged.on((cell) => text(this.scene, cell.scene));
    state.accessChanged.on(() => this.showConnection());
    state.statusChanged.on((status) => {
      text(this.clients, String(status.listeners.reduce((sum, l) => sum + l.clients, 0)));
      this.listeners = status.listeners;
      if (this.listenerRows.isConnected) this.fillListeners();
    });
  }

  toggle(): void {
    void this.access.command(
      this.state.live?.paused ? {case: 'resume', value: {}} : {case: 'pause', value: {}}
    );
  }

  /** `held`: the key repeats; further steps then wait until the previous ones have been taken. */
  takeSteps(steps: number, held = false): void {
    if (held && (this.stepping || !this.state.snapshot?.paused)) return;
    this.stepping = true;
    void this.access
      .command({case: 'step', value: {steps: BigInt(steps)}})
      .then(() => (this.stepping = false));
  }

  /** All robots and the belt. */
  stopCell(): void {
    void this.access.command({case: 'stopCell', value: {}});
  }

  private reset(): void {
    const dialog = h(
      'dialog',
      {class: 'dialog', 'aria-label': 'Reset the cell'},
      h('h2', {}, 'Reset the cell?'),
      h('p', {}, 'Robots, parts and belt return to the start of the scene. Connections stay open.'),
      h(
        'div',
        {class: 'row end'},
        button('Cancel', () => dialog.close()),
        button(
          'Reset',
          () => {
            dialog.close();
            void this.access.command({case: 'reset', value: {}});
          },
          {class: 'danger', 'data-testid': 'reset-confirm'}
        )
      )
    );
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
  }

  private showListeners(): void {
    this.fillListeners();
    const dialog = h(
      'dialog',
      {class: 'dialog', 'aria-label': 'Clients'},
      h('h2', {}, 'Clients'),
      h('p', {'data-testid': 'role'}, this.role()),
      h(
        'table',
        {},
        h(
          'thead',
          {},
          h('tr', {}, ...['listener', 'port', 'clients'].map((t) => h('th', {scope: 'col'}, t)))
        ),
        this.listenerRows
      ),
      h(
        'div',
        {class: 'row end'},
        button('Close', () => dialog.close())
      )
    );
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
  }

  private role(): string {
    const {role, name} = this.state.permission ?? {role: 'none', name: ''};
    return `Your role: ${role}${name ? `, by ${name}` : ''}.`;
  }

  private fillListeners(): void {
    this.listenerRows.replaceChildren(
      ...this.listeners.map(({name, port, clients}) =>
        h(
          'tr',
          {},
          h('td', {}, name),
          h('td', {}, port ? String(port) : location.port),
          h('td', {}, String(clients))
        )
      )
    );
  }

  private setSpeed(): void {
    const value = this.speed.value;
    void this.access.command({
      case: 'setSpeed',
      value: {
        speed:
          value === 'max' ? {case: 'maximum', value: true} : {case: 'factor', value: Number(value)}
      }
    });
  }

  private show(snapshot: Snapshot): void {
    text(this.time, simSeconds(simTime(snapshot)));
    text(this.factor, this.pace(snapshot));
    text(
      this.step,
      snapshot.stepTime
        ? `${(Number(snapshot.stepTime.seconds) * 1e6 + snapshot.stepTime.nanos / 1e3).toFixed(0)} µs`
        : '–'
    );
    const paused = this.state.live?.paused ?? snapshot.paused;
    text(this.play, paused ? 'Play' : 'Pause');
    this.play.classList.toggle('paused', paused);
    if (this.state.past || this.state.draft) return;
    const speed = snapshot.speedTarget === undefined ? 'max' : String(snapshot.speedTarget);
    if (document.activeElement !== this.speed && this.speed.value !== speed) this.showSpeed(speed);
  }

  private pace(snapshot: Snapshot): string {
    if (this.state.draft) return 'draft';
    if (this.state.past) return 'past';
    return snapshot.paused ? 'paused' : `${snapshot.realTimeFactor.toFixed(2)}×`;
  }

  /** Shows a speed that another client has set and that the list lacks. */
  private showSpeed(speed: string): void {
    if (![...this.speed.options].some((o) => o.value === speed))
      this.speed.append(h('option', {value: speed}, `${Number(Number(speed).toPrecision(3))}×`));
    this.speed.value = speed;
  }

  private showConnection(): void {
    const {connected, retryIn_s} = this.state;
    this.connection.dataset.state = connected ? 'up' : 'down';
    text(this.connection, connected ? 'live' : 'reconnecting');
    this.connection.title = connected ? '' : `in ${Math.max(retryIn_s, 0.1).toFixed(1)} s`;
    document.body.classList.toggle('offline', !connected);
  }
}

function gauge(name: string, value: HTMLElement): HTMLElement {
  return h('div', {class: 'gauge'}, h('span', {}, name), value);
}
