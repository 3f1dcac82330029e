// Form to inject a fault. Kinds, targets, ranges and error messages come from the daemon.
import type {FaultKind, FaultParameter} from '../protocol';
import type {State} from '../state';
import type {Access} from './access';
import {card, docsLink, h, text} from './dom';
import {FaultTarget} from './fault_target';
import {duration, FaultTrigger, numberIn} from './fault_trigger';

export class InjectCard {
  readonly element: HTMLElement;
  private readonly kind = h('select', {'data-testid': 'fault-kind'});
  private readonly meaning = h('p', {class: 'meaning'});
  private readonly target = new FaultTarget();
  private readonly parameters = h('div', {class: 'fields'});
  private readonly trigger = new FaultTrigger();
  private readonly lasts = h('input', {
    autocomplete: 'off',
    placeholder: 'until ended',
    'data-testid': 'fault-duration'
  });
  private readonly lastsField = h('label', {}, 'lasts [s]', this.lasts);
  private readonly complaint = h('p', {
    class: 'complaint',
    role: 'alert',
    'data-testid': 'fault-complaint'
  });
  private readonly event = h('input', {
    autocomplete: 'off',
    placeholder: 'name of an event',
    'aria-label': 'Name of an event',
    'data-testid': 'event-name'
  });
  private inputs: {parameter: FaultParameter; field: HTMLInputElement}[] = [];
  private kinds: FaultKind[] = [];

  constructor(
    private readonly state: State,
    access: Access
  ) {
    const form = access.guard(
      h(
        'fieldset',
        {},
        h('label', {}, 'kind', this.kind),
        this.meaning,
        this.target.element,
        this.parameters,
        this.trigger.element,
        this.lastsField,
        h('div', {class: 'row'}, h('button', {type: 'submit', 'data-testid': 'inject'}, 'Inject'))
      ),
      undefined,
      false,
      'inject'
    );
    const report = access.guard(
      h(
        'fieldset',
        {class: 'row'},
        this.event,
        h('button', {type: 'submit', 'data-testid': 'report-event'}, 'Report event')
      ),
      undefined,
      false,
      'inject'
    );
    this.kind.addEventListener('change', () => this.choose());
    this.element = card(
      'Inject a fault',
      h('form', {novalidate: true, onsubmit: (e: Event) => this.submit(e, this.inject)}, form),
      h('form', {novalidate: true, onsubmit: (e: Event) => this.submit(e, this.report)}, report),
      this.complaint
    );
    this.element.querySelector('h2')!.append(' ', docsLink('faults.html', 'injected faults'));
    state.faultKindsChanged.on(() => this.offer());
    state.cellChanged.on(() => this.offer());
  }

  private offer(): void {
    const {cell, faultKinds} = this.state;
    if (!cell || !faultKinds) return;
    const before = this.kind.value;
    this.kinds = faultKinds.kinds;
    this.kind.replaceChildren(
      ...this.kinds.map(({name}) => h('option', {value: name}, name.replaceAll('-', ' ')))
    );
    if (this.kinds.some(({name}) => name === before)) this.kind.value = before;
    this.trigger.offer(cell, faultKinds.quantities);
    this.choose(before === this.kind.value);
  }

  /** `same`: only the cell has changed; keep the typed values. */
  private choose(same = false): void {
    const kind = this.chosen;
    if (!kind) return;
    text(this.meaning, kind.meaning + '.');
    this.target.offer(kind.target, this.state.cell!);
    this.lastsField.hidden = kind.momentary;
    if (same) return;
    text(this.complaint, '');
    this.inputs = kind.parameters.map((parameter) => ({
      parameter,
      field: h('input', {
        inputmode: 'decimal',
        autocomplete: 'off',
        placeholder: String(parameter.default),
        'data-testid': `parameter-${parameter.name}`
      })
    }));
    this.parameters.replaceChildren(
      ...this.inputs.map(({parameter: {name, unit, min, max, meaning}, field}) =>
        h(
          'label',
          {title: meaning},
          `${name}${unit === '1' ? '' : ` [${unit}]`}`,
          field,
          h('small', {}, `${short(min)} to ${short(max)}: ${meaning}`)
        )
      )
    );
    this.parameters.hidden = this.inputs.length === 0;
  }

  private get chosen(): FaultKind | undefined {
    return this.kinds.find(({name}) => name === this.kind.value);
  }

  private submit(event: Event, send: () => Promise<void>): void {
    event.preventDefault();
    send.call(this).then(
      () => text(this.complaint, ''),
      (problem: Error) => text(this.complaint, problem.message)
    );
  }

  private async inject(): Promise<void> {
    const kind = this.chosen;
    if (!kind) return;
    const parameters: Record<string, number> = {};
    for (const {parameter, field} of this.inputs)
      if (field.value.trim() !== '') parameters[parameter.name] = numberIn(field, parameter.name);
    const lasts = !kind.momentary && this.lasts.value.trim() !== '';
    await this.state.connection.request({
      case: 'injectFault',
      value: {
        kind: kind.name,
        target: this.target.value,
        parameters,
        trigger: this.trigger.value,
        ...(lasts ? {duration: duration(numberIn(this.lasts, 'lasts'))} : {})
      }
    });
  }

  private async report(): Promise<void> {
    await this.state.connection.request({
      case: 'reportEvent',
      value: {event: this.event.value.trim()}
    });
  }
}

function short(value: number): string {
  return String(Number(value.toPrecision(4)));
}
