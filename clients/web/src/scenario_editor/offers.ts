// Events that a scenario can get, and names of the cell that its fields offer.
import {BodyKind, type CellDescription, type FaultKind, type FaultQuantity} from '../protocol';
import {kLabels, namesOf} from '../ui/fault_target';
import type {SceneText} from '../editor/scene_text';
import {freeName, isEntry, type Entry, type List, type TimedEvent} from './events';
import {withPresent, type Field, type Offered} from './fields';

export interface Offer {
  list: List;
  group: string;
  label: string;
  meaning: string;
  make: (scenario: SceneText, at_s: number) => Entry;
}

const kFaultLength_s = 10;

/** Types of kit trays in the cell. */
const kitsOf = (cell: CellDescription): string[] => [
  ...new Set(cell.bodies.filter(({kind}) => kind === BodyKind.KIT_TRAY).map(({type}) => type))
];

/** A target of this form: of the first names in the cell, no name twice. */
export function firstTarget(pattern: string, cell: CellDescription): string {
  const words = pattern.split(':').filter(Boolean);
  const names = words.map((word, i) => {
    const all = namesOf(word, cell, 0);
    return (words.indexOf(word) < i ? all[1] : all[0]) ?? '';
  });
  return names.join(':');
}

export function offersOf(cell: CellDescription, kinds: readonly FaultKind[]): Offer[] {
  return [
    ...kitsOf(cell).map((tray) => ({
      list: 'orders' as const,
      group: 'Orders of kits',
      label: `order ${tray}`,
      meaning: 'An order of kits of this type',
      make: (scenario: SceneText, at_s: number): Entry => ({
        name: freeName(scenario, 'orders', 'kit'),
        tray,
        ...(at_s > 0 ? {at_s} : {})
      })
    })),
    ...kinds.map((kind) => ({
      list: 'faults' as const,
      group: 'Faults',
      label: kind.name.replaceAll('-', ' '),
      meaning: kind.meaning,
      make: (_: SceneText, at_s: number): Entry => {
        const target = firstTarget(kind.target, cell);
        return {
          kind: kind.name,
          ...(target ? {target} : {}),
          at_s,
          ...(kind.momentary ? {} : {for_s: kFaultLength_s})
        };
      }
    })),
    {
      list: 'kill_controller',
      group: 'Controller',
      label: 'kill the controller',
      meaning: 'The controller is killed and started again',
      make: (_, at_s): Entry => ({at_s})
    }
  ];
}

/** Fields of a fault's target: one for each word of the kind's form. */
export function targetFields(event: TimedEvent, kind: FaultKind, cell: CellDescription): Field[] {
  const words = kind.target.split(':').filter(Boolean);
  const parts = String(event.value.target ?? '').split(':');
  const robot = cell.robots.findIndex(({name}) => name === parts[0]);
  return words.map((word, i) => {
    const names = namesOf(word, cell, Math.max(0, robot));
    const text = parts[i] ?? '';
    return {
      path: ['target', i],
      label: kLabels[word] ?? word,
      unit: '',
      meaning: `Target of the fault: ${kLabels[word] ?? word}`,
      text,
      placeholder: '',
      ...(names.length > 0 ? {choices: withPresent(names, text)} : {}),
      parse: (typed: string) =>
        words.map((_, j) => (j === i ? typed.trim() : (parts[j] ?? ''))).join(':')
    };
  });
}

/** Names that fields of the scenario offer. */
export function offeredIn(
  scenario: SceneText,
  cell: CellDescription,
  quantities: readonly FaultQuantity[]
): Offered {
  const namesIn = (list: List): string[] => {
    const entries = scenario.get([list]);
    return (Array.isArray(entries) ? entries : []).flatMap((entry) =>
      isEntry(entry) && entry.name !== undefined ? [String(entry.name)] : []
    );
  };
  const orders = namesIn('orders');
  const robots = cell.robots.map(({name}) => name);
  const types = cell.bodies
    .filter(({kind}) => kind === BodyKind.GEAR || kind === BodyKind.PART)
    .map(({type}) => type);
  const conditions = [
    ...robots.map((robot) => `grasp:${robot}:1`),
    ...[...new Set(types)].map((type) => `placed:${type}`),
    ...(cell.conveyor?.photoEyes ?? []).map(({name}) => `beam:${name}`),
    ...orders.flatMap((name) =>
      ['announced', 'submitted', 'cancelled'].map((what) => `event:${name}-${what}`)
    ),
    ...quantities.flatMap(({name, ofRobot}) =>
      ofRobot ? robots.map((robot) => `${name}:${robot}>0`) : [`${name}>0`]
    )
  ];
  return {kits: kitsOf(cell), conditions, orders, faults: namesIn('faults')};
}
