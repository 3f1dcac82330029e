// Starting the daemon's programs: the demo and scenarios.
import type {State} from '../state';
import {button, h} from './dom';

export const kDemo = 'demo';

export class Programs {
  constructor(private readonly state: State) {}

  /** Why this program cannot be started; empty where it can. */
  refusal(name: string): string {
    const refusal = this.anyRefusal();
    const offers = this.state.programs?.offers ?? [];
    return refusal || offers.some((offer) => offer.name === name)
      ? refusal
      : 'This scene does not offer it.';
  }

  /** Why no program can be started; empty where one can. */
  anyRefusal(): string {
    const status = this.state.programs;
    if (!status) return 'Waiting for the daemon.';
    if (status.refusal) return status.refusal;
    return status.running ? `${status.name} is running; stop it first.` : '';
  }

  /** Starts a program; rejects with the daemon's reason. In a paused cell it offers to resume first. */
  async start(name: string, seed?: bigint): Promise<void> {
    if (this.state.live?.paused && !(await this.offerToResume(name))) return;
    await this.state.connection.request({
      case: 'startProgram',
      value: {name, ...(seed === undefined ? {} : {seed})}
    });
  }

  /** Starts a scenario by its text; rejects with the daemon's reason. */
  async startScenario(name: string, text: string, seed?: bigint): Promise<void> {
    if (this.state.live?.paused && !(await this.offerToResume(name))) return;
    await this.state.connection.runScenario(name, text, seed);
  }

  async stop(): Promise<void> {
    await this.state.connection.request({case: 'stopProgram', value: {}});
  }

  /** True once the cell has been resumed; false where the user cancels. */
  private offerToResume(name: string): Promise<boolean> {
    return new Promise((decide, fail) => {
      let resumes = false;
      const dialog = h(
        'dialog',
        {class: 'dialog', 'aria-label': 'The cell is paused'},
        h('h2', {}, 'The cell is paused'),
        h('p', {}, `While it is paused, ${name} cannot move anything.`),
        h(
          'div',
          {class: 'row end'},
          button('Cancel', () => dialog.close()),
          button(
            'Resume and run',
            () => {
              resumes = true;
              dialog.close();
            },
            {class: 'primary', 'data-testid': 'resume-and-run'}
          )
        )
      );
      dialog.addEventListener('close', () => {
        dialog.remove();
        if (!resumes) return decide(false);
        this.state.connection.request({case: 'resume', value: {}}).then(() => decide(true), fail);
      });
      document.body.append(dialog);
      dialog.showModal();
    });
  }
}
