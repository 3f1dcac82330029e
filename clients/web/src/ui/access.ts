// Controls that command the cell; disabled, with the reason, while that is not permitted.
import type {State} from '../state';
import {h, notify} from './dom';
import {units} from './units';

/** Roles of viewers; each role includes the previous ones. */
export type Role = 'operate' | 'inject' | 'admin';

type Control = HTMLButtonElement | HTMLInputElement | HTMLSelectElement | HTMLFieldSetElement;

interface Guarded {
  control: Control;
  title: string;
  own: () => string;
  inPast: boolean;
  role: Role;
}

export class Access {
  private readonly controls: Guarded[] = [];
  readonly banner = h('div', {class: 'banner', role: 'status', hidden: true});

  constructor(private readonly state: State) {
    state.accessChanged.on(() => this.update());
    state.display.on(() => this.update());
  }

  /**
   * Enables a control for viewers with a role only. `own` returns a further reason to disable it, or
   * an empty text. `inPast`: the control works while the past is shown.
   */
  guard<T extends Control>(
    control: T,
    own: () => string = () => '',
    inPast = false,
    role: Role = 'operate'
  ): T {
    this.controls.push({control, title: control.title, own, inPast, role});
    this.apply(this.controls[this.controls.length - 1]!);
    return control;
  }

  /** Forgets controls that were removed from the page. */
  prune(): void {
    for (let i = this.controls.length; i-- > 0; ) {
      if (!this.controls[i]!.control.isConnected) this.controls.splice(i, 1);
    }
  }

  /** Sends a command and shows the reason of a refusal. */
  async command(body: Parameters<State['connection']['request']>[0]): Promise<boolean> {
    try {
      await this.state.connection.request(body);
      return true;
    } catch (problem) {
      notify(units.inText((problem as Error).message), 'error');
      return false;
    }
  }

  update(): void {
    for (const entry of this.controls) this.apply(entry);
    const fault = this.state.snapshot?.worldFault;
    const stopped = fault ? `The simulation has stopped until the cell is reset: ${fault}` : '';
    const reason = this.state.connected ? stopped || this.state.lockedReason : '';
    if (this.banner.dataset.reason === reason) return;
    this.banner.dataset.reason = reason;
    this.banner.hidden = reason === '';
    this.banner.replaceChildren(h('span', {}, reason));
    if (reason && !stopped && this.state.permission?.tokenHelps)
      this.banner.append(this.tokenForm());
  }

  private apply({control, title, own, inPast, role}: Guarded): void {
    const locked = inPast ? this.state.refusedReason : this.state.lockedReason;
    const reason = locked || this.state.lacks(role) || own();
    if (control.disabled !== (reason !== '')) control.disabled = reason !== '';
    const shown = reason || title;
    if (control.title !== shown) control.title = shown;
  }

  private tokenForm(): HTMLElement {
    const input = h('input', {
      type: 'password',
      name: 'token',
      'aria-label': 'Access token',
      placeholder: 'Access token',
      autocomplete: 'off'
    });
    return h(
      'form',
      {
        class: 'token',
        onsubmit: (event: Event) => {
          event.preventDefault();
          void this.authenticate(input.value);
        }
      },
      input,
      h('button', {type: 'submit'}, 'Unlock')
    );
  }

  async authenticate(token: string): Promise<void> {
    if (await this.command({case: 'authenticate', value: {token}}))
      sessionStorage.setItem('token', token);
    else sessionStorage.removeItem('token');
  }
}
