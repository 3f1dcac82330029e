// Input that writes one register or coil of the PLC and shows the reason of a refusal.
import type {RegisterInfo} from '../protocol';
import type {State} from '../state';
import type {Access} from './access';
import {button, h, text} from './dom';

export class RegisterInput {
  readonly element: HTMLElement;
  private readonly result = h('small', {class: 'refusal', role: 'alert'});

  constructor(
    private readonly info: RegisterInfo,
    private readonly state: State,
    access: Access
  ) {
    const coil = info.area === 'coil';
    const range = `${info.min} to ${info.max}`;
    const input = access.guard(
      h('input', {
        type: 'text',
        inputmode: 'numeric',
        size: 6,
        autocomplete: 'off',
        placeholder: range.replace(' to ', '…'),
        'aria-label': `Counts for ${info.name}, ${range}`
      })
    );
    this.element = coil
      ? h(
          'div',
          {class: 'register-input'},
          ...[1, 0].map((value) =>
            access.guard(
              button(value ? 'on' : 'off', () => void this.write(String(value)), {
                'aria-label': `${info.name} ${value ? 'on' : 'off'}`
              })
            )
          ),
          this.result
        )
      : h(
          'form',
          {
            class: 'register-input',
            onsubmit: (event: Event) => {
              event.preventDefault();
              void this.write(input.value).then((done) => done && (input.value = ''));
            }
          },
          input,
          access.guard(h('button', {type: 'submit', 'aria-label': `Write ${info.name}`}, 'Write')),
          this.result
        );
  }

  /** Decimal, or hexadecimal with 0x. */
  private async write(typed: string): Promise<boolean> {
    const value = /^\s*(-?\d+|0x[0-9a-f]+)\s*$/i.test(typed) ? Number(typed) : NaN;
    if (!Number.isSafeInteger(value)) {
      text(this.result, `“${typed.trim()}” is not a whole number`);
      return false;
    }
    const {area, address} = this.info;
    try {
      await this.state.connection.request({
        case: 'writeRegister',
        value: {area, address, value: BigInt(value)}
      });
      text(this.result, '');
      return true;
    } catch (problem) {
      text(this.result, (problem as Error).message);
      return false;
    }
  }
}
