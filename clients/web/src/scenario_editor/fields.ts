// Values of a scenario as texts in fields, by the schema of scenario files and the kinds of faults.
import {unitOf, type Schema} from '../editor/properties';
import type {SceneText, Path, Value} from '../editor/scene_text';
import type {FaultKind} from '../protocol';
import {isEntry, type TimedEvent} from './events';

export interface Field {
  path: Path;
  label: string;
  unit: string;
  meaning: string;
  /** Its value as text; empty = absent. */
  text: string;
  placeholder: string;
  /** The texts it may have; absent = any. */
  choices?: string[];
  /** Texts to offer. */
  suggestions?: string[];
  /** The value of a text; undefined = the key is left out. Throws with the reason. */
  parse: (text: string) => Value | undefined;
}

/** The number in a text; throws if there is none. */
export function numberIn(text: string, label: string): number {
  const number = Number(text.trim().replace(',', '.'));
  if (text.trim() === '' || !Number.isFinite(number))
    throw new Error(`${label}: “${text}” is not a number`);
  return number;
}

function numbersIn(text: string, label: string): number[] {
  return text.split(/,\s+|\s+to\s+|\s*;\s*|\s+/).map((part) => numberIn(part, label));
}

/** A bound of a measure in words: "1", "1 or more", "up to 2" or "1 to 2". */
export function boundText(value: Value | undefined): string {
  if (!isEntry(value)) return value === undefined || value === null ? '' : String(value);
  const {min, max} = value;
  if (min !== undefined && max !== undefined) return `${String(min)} to ${String(max)}`;
  if (max !== undefined) return `up to ${String(max)}`;
  return min === undefined ? '' : `${String(min)} or more`;
}

export function boundOf(text: string, label: string): Value {
  const trimmed = text.trim();
  const most = /^up to (.+)$/.exec(trimmed);
  if (most) return {max: numberIn(most[1]!, label)};
  const least = /^(.+) or more$/.exec(trimmed);
  if (least) return {min: numberIn(least[1]!, label)};
  const both = /^(\S+) to (\S+)$/.exec(trimmed);
  if (both) return {min: numberIn(both[1]!, label), max: numberIn(both[2]!, label)};
  return numberIn(trimmed, label);
}

const isNumber = ({type}: Schema): boolean => type === 'number' || type === 'integer';

type Form = Pick<Field, 'text' | 'parse'> & Partial<Field>;

/** How a value of a schema is written as one text; null = it is left to the file. */
function formOf(schema: Schema, value: Value | undefined, label: string): Form | null {
  const text = value === undefined || value === null ? '' : String(value);
  const some = (of: (text: string) => Value) => (typed: string) =>
    typed.trim() === '' ? undefined : of(typed);
  if (schema.enum)
    return {
      text,
      choices: ['', ...schema.enum.map(String)],
      parse: some((typed) => schema.enum!.find((known) => String(known) === typed) ?? typed)
    };
  if (schema.type === 'boolean')
    return {text, choices: ['', 'true', 'false'], parse: some((typed) => typed === 'true')};
  if (isNumber(schema)) return {text, parse: some((typed) => numberIn(typed, label))};
  const list = schema.type === 'array' ? schema : schema.anyOf?.find(({type}) => type === 'array');
  if (list?.items && isNumber(list.items))
    return {
      text: Array.isArray(value) ? value.map(String).join(', ') : text,
      parse: some((typed) => {
        const numbers = numbersIn(typed, label);
        return numbers.length === 1 && schema.anyOf ? numbers[0]! : numbers;
      })
    };
  if (list && list.items?.type !== 'object')
    return {
      text: Array.isArray(value) ? value.map(String).join(' ') : text,
      parse: some((typed) => typed.trim().split(/\s+/))
    };
  if (schema.anyOf) return {text: boundText(value), parse: some((typed) => boundOf(typed, label))};
  if (Array.isArray(schema.type)) return {text, parse: some((typed) => typed.trim())};
  return null;
}

/** The field of a value; null where it is edited in the text. */
export function schemaField(
  schema: Schema & {default?: Value},
  value: Value | undefined,
  path: Path,
  label = path.join('.')
): Field | null {
  const form = formOf(schema, value, label);
  if (!form) return null;
  return {
    path,
    label,
    unit: unitOf(String(path[path.length - 1])),
    meaning: schema.description ?? '',
    placeholder: schema.default === undefined ? '' : String(schema.default),
    ...form
  };
}

/** Fields of all keys of a map, maps in it included. */
function fieldsIn(schema: Schema | undefined, value: Value | undefined, path: Path): Field[] {
  return Object.entries(schema?.properties ?? {}).flatMap(([key, of]) => {
    const inner = isEntry(value) ? value[key] : undefined;
    const at = [...path, key];
    if (of.type === 'object' && of.properties) return fieldsIn(of, inner, at);
    return schemaField(of, inner, at) ?? [];
  });
}

/** Names in the cell that fields offer. */
export interface Offered {
  kits: string[];
  /** Conditions of faults. */
  conditions: string[];
  orders: string[];
  faults: string[];
}

export function orderFields(
  event: TimedEvent,
  schema: Schema | undefined,
  offered: Offered
): Field[] {
  const {items} = schema?.properties?.orders ?? {};
  const others = offered.orders.filter((name) => name !== event.value.name);
  const events = [
    'placed:1',
    ...others.map((name) => `submitted:${name}`),
    ...offered.faults.map((name) => `fault:${name}`)
  ];
  return fieldsIn(items, event.value, []).flatMap((field) => {
    const key = String(field.path[field.path.length - 1]);
    if (field.path[0] === 'destination') return [];
    if (key === 'tray') return {...field, choices: withPresent(offered.kits, field.text)};
    return key === 'when' ? {...field, suggestions: events} : field;
  });
}

/** The texts of a list with the present one. */
export const withPresent = (list: string[], present: string): string[] =>
  list.includes(present) ? list : [present, ...list];

/** Name, condition and times of a fault, then its parameters. */
export function faultFields(
  event: TimedEvent,
  schema: Schema | undefined,
  kind: FaultKind | undefined,
  offered: Offered
): Field[] {
  const {items} = schema?.properties?.faults ?? {};
  const keys = ['name', 'at_s', 'when', ...(kind?.momentary ? [] : ['for_s'])];
  const fields = keys.flatMap((key) => {
    const of = items?.properties?.[key];
    const field = of && schemaField(of, event.value[key], [key]);
    if (!field) return [];
    return key === 'when' ? {...field, suggestions: offered.conditions} : field;
  });
  const given = isEntry(event.value.with) ? event.value.with : {};
  return [
    ...fields,
    ...(kind?.parameters ?? []).map(({name, unit, min, max, default: usual, meaning}) => ({
      path: ['with', name],
      label: name,
      unit: unit === '1' ? '' : unit,
      meaning: `${meaning}: ${short(min)} to ${short(max)}`,
      text: given[name] === undefined ? '' : String(given[name]),
      placeholder: short(usual),
      parse: (text: string) => (text.trim() === '' ? undefined : numberIn(text, name))
    }))
  ];
}

export const short = (value: number): string => String(Number(value.toPrecision(4)));

export function killFields(event: TimedEvent, schema: Schema | undefined): Field[] {
  return fieldsIn(schema?.properties?.kill_controller?.items, event.value, []);
}

export interface Group {
  title: string;
  fields: Field[];
  /** Keys that can be added. */
  more?: {path: Path; names: string[]};
}

/** Everything but the events: fields in groups. */
export function scenarioGroups(scenario: SceneText, schema: Schema | undefined): Group[] {
  const properties = schema?.properties ?? {};
  const at = (key: string): Value | undefined => scenario.get([key]);
  const simple = Object.entries(properties).flatMap(([key, of]) =>
    of.type === 'object' || of.items?.type === 'object'
      ? []
      : (schemaField(of, at(key), [key]) ?? [])
  );
  const expected = at('expect');
  const present = isEntry(expected) ? expected : {};
  const measures = properties.expect?.properties ?? {};
  return [
    {title: 'Scenario', fields: simple},
    {title: 'End', fields: fieldsIn(properties.stop, at('stop'), ['stop'])},
    {
      title: 'Expectations',
      fields: Object.entries(present).flatMap(
        ([name, value]) =>
          schemaField(measures[name] ?? {anyOf: []}, value, ['expect', name], name) ?? []
      ),
      more: {path: ['expect'], names: Object.keys(measures).filter((name) => !(name in present))}
    },
    {title: 'Variation', fields: fieldsIn(properties.vary, at('vary'), ['vary'])},
    {title: 'Score', fields: fieldsIn(properties.scoring, at('scoring'), ['scoring'])}
  ];
}
