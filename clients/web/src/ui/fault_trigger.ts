// Trigger of an injected fault, with the fields that each kind needs.
import type {MessageInitShape} from '@bufbuild/protobuf';
import {
  BodyKind,
  type CellDescription,
  type FaultQuantity,
  type InjectFaultRequestSchema
} from '../protocol';
import {h} from './dom';

type Trigger = Exclude<MessageInitShape<typeof InjectFaultRequestSchema>['trigger'], undefined>;

/** Simulated time as a protobuf duration. */
export function duration(time_s: number): {seconds: bigint; nanos: number} {
  if (Math.abs(time_s) > 1e9) throw new Error(`${time_s} s is too long`);
  const ns = Math.round(time_s * 1e9);
  const seconds = Math.trunc(ns / 1e9);
  return {seconds: BigInt(seconds), nanos: ns - seconds * 1e9};
}

/** The number in a field; throws where there is none. */
export function numberIn(field: HTMLInputElement, name: string): number {
  const text = field.value.trim().replace(',', '.');
  const value = Number(text);
  if (text === '') throw new Error(`${name} is empty: it needs a number`);
  if (!Number.isFinite(value)) throw new Error(`${name}: “${field.value}” is not a number`);
  return value;
}

/** The whole number in a field, within the range of the protocol. */
function wholeIn(field: HTMLInputElement, name: string): number {
  const value = numberIn(field, name);
  if (!Number.isInteger(value) || value < 0 || value >= 2 ** 32)
    throw new Error(`${name}: “${field.value}” is not a whole number from 0`);
  return value;
}

export class FaultTrigger {
  readonly element: HTMLElement;
  private readonly kind = select('trigger');
  private readonly fields = h('div', {class: 'fields'});
  private readonly time = input('trigger-time');
  private readonly type = select('trigger-type');
  private readonly robot = select('trigger-robot');
  private readonly anyRobot = select('trigger-any-robot');
  private readonly count = input('trigger-count', '1');
  private readonly eye = select('trigger-eye');
  private readonly quantity = select('trigger-quantity');
  private readonly joint = input('trigger-joint', '1');
  private readonly side = select('trigger-side', ['above', 'below']);
  private readonly limit = input('trigger-limit');
  private readonly event = input('trigger-event', 'order-submitted');
  private quantities: FaultQuantity[] = [];

  constructor() {
    const ways: [string, string][] = [
      ['', 'at once'],
      ['at', 'at a simulated time'],
      ['placed', 'when a gear is placed'],
      ['grasped', 'at a robot’s grasp'],
      ['beam', 'when a photo-eye’s beam is broken'],
      ['crossing', 'when a value crosses a limit'],
      ['reported', 'when an event is reported']
    ];
    this.kind.append(...ways.map(([value, label]) => h('option', {value}, label)));
    this.kind.addEventListener('change', () => this.show());
    this.quantity.addEventListener('change', () => this.show());
    this.element = h('div', {class: 'fields'}, h('label', {}, 'when', this.kind), this.fields);
  }

  offer(cell: CellDescription, quantities: FaultQuantity[]): void {
    this.quantities = quantities;
    const types = cell.bodies
      .filter(({kind}) => kind === BodyKind.GEAR || kind === BodyKind.PART)
      .map(({type}) => type);
    fill(this.type, [...new Set(types)]);
    fill(
      this.robot,
      cell.robots.map(({name}) => name)
    );
    this.anyRobot.replaceChildren(
      h('option', {value: ''}, 'any'),
      ...cell.robots.map(({name}) => h('option', {value: name}, name))
    );
    fill(this.eye, cell.conveyor?.photoEyes.map(({name}) => name) ?? []);
    fill(
      this.quantity,
      quantities.map(({name}) => name)
    );
    this.show();
  }

  /** Trigger as the daemon accepts it; throws for invalid numbers. */
  get value(): Trigger {
    switch (this.kind.value) {
      case 'at':
        return {case: 'at', value: duration(numberIn(this.time, 'time'))};
      case 'placed':
        return {case: 'placed', value: {type: this.type.value, robot: this.anyRobot.value}};
      case 'grasped':
        return {
          case: 'grasped',
          value: {robot: this.robot.value, count: wholeIn(this.count, 'grasp')}
        };
      case 'beam':
        return {case: 'beam', value: {eye: this.eye.value}};
      case 'crossing': {
        const limit = numberIn(this.limit, 'limit');
        return {
          case: 'crossing',
          value: {
            quantity: this.quantity.value,
            robot: this.ofRobot ? this.robot.value : '',
            joint: this.ofJoint ? wholeIn(this.joint, 'joint') : 0,
            limit: {case: this.side.value === 'above' ? 'above' : 'below', value: limit}
          }
        };
      }
      case 'reported':
        return {case: 'reported', value: {event: this.event.value.trim()}};
      default:
        return {case: undefined};
    }
  }

  private get chosen(): FaultQuantity | undefined {
    return this.quantities.find(({name}) => name === this.quantity.value);
  }
  private get ofRobot(): boolean {
    return this.chosen?.ofRobot ?? false;
  }
  private get ofJoint(): boolean {
    return this.quantity.value === 'joint-position';
  }

  private show(): void {
    const field = (label: string, control: HTMLElement): HTMLElement =>
      h('label', {}, label, control);
    const all: Record<string, () => HTMLElement[]> = {
      at: () => [field('time since the reset [s]', this.time)],
      placed: () => [field('type', this.type), field('by', this.anyRobot)],
      grasped: () => [field('robot', this.robot), field('grasp', this.count)],
      beam: () => [field('photo-eye', this.eye)],
      crossing: () => [
        field('value', this.quantity),
        ...(this.ofRobot ? [field('robot', this.robot)] : []),
        ...(this.ofJoint ? [field('joint', this.joint)] : []),
        field('goes', this.side),
        field(`limit [${this.chosen?.unit ?? ''}]`, this.limit)
      ],
      reported: () => [field('event', this.event)]
    };
    this.fields.replaceChildren(...(all[this.kind.value]?.() ?? []));
    this.fields.hidden = this.fields.childElementCount === 0;
  }
}

function input(id: string, value = ''): HTMLInputElement {
  return h('input', {autocomplete: 'off', 'data-testid': id, value});
}

function select(id: string, names: string[] = []): HTMLSelectElement {
  const choice = h('select', {'data-testid': id});
  fill(choice, names);
  return choice;
}

function fill(choice: HTMLSelectElement, names: string[]): void {
  const before = choice.value;
  choice.replaceChildren(...names.map((name) => h('option', {value: name}, name)));
  if (names.includes(before)) choice.value = before;
}
