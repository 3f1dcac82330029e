// The values of a thing as fields, with units and ranges from the schema of scene files.
import {h} from '../ui/dom';
import type {Path, Value} from './scene_text';
import type {Thing} from './things';

/** The part of JSON schema that scene files use. */
export interface Schema {
  description?: string;
  type?: string | string[];
  enum?: Value[];
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  exclusiveMaximum?: number;
  properties?: {[key: string]: Schema};
  items?: Schema;
  anyOf?: Schema[];
}

const kUnits: [RegExp, string][] = [
  [/_m_s2$/, 'm/s²'],
  [/_rad_s2$/, 'rad/s²'],
  [/_m_s$/, 'm/s'],
  [/_rad_s$/, 'rad/s'],
  [/_n_m$/, 'N/m'],
  [/_n_s$/, 'N/s'],
  [/_mm$/, 'mm'],
  [/_ms$/, 'ms'],
  [/_m$/, 'm'],
  [/_deg$/, '°'],
  [/_kg$/, 'kg'],
  [/_hz$/, 'Hz'],
  [/_px$/, 'px'],
  [/_n$/, 'N'],
  [/_s$/, 's']
];
const kAxes = ['x', 'y', 'z'];
const kTurns = ['roll', 'pitch', 'yaw'];
/** Keys that things of every kind may have without saying so. */
const kOptional = ['yaw_deg', 'rpy_deg'];
const kMostFields = 40;

export function unitOf(key: string): string {
  return kUnits.find(([form]) => form.test(key))?.[1] ?? '';
}

/** The permitted values in words; empty if all are. */
export function rangeOf(schema: Schema | undefined, unit: string): string {
  if (!schema) return '';
  const {minimum, maximum, exclusiveMinimum: above, exclusiveMaximum: below} = schema;
  const from = above !== undefined ? `above ${above}` : minimum !== undefined ? `${minimum}` : '';
  const to = below !== undefined ? `below ${below}` : maximum !== undefined ? `${maximum}` : '';
  const last = unit ? ` ${unit}` : '';
  if (from && to) return (above !== undefined ? `${from}, up to ${to}` : `${from} to ${to}`) + last;
  if (to) return `up to ${to}${last}`;
  return from ? (above !== undefined ? from : `${from} or more`) + last : '';
}

interface Field {
  path: Path;
  label: string;
  value: Value | undefined;
  schema: Schema | undefined;
}

/** Fields of a thing, the maps in it included. Lists of maps are left to the text. */
export function fieldsOf(thing: Thing, schema: Schema | undefined): Field[] {
  const fields: Field[] = [];
  const walk = (value: Value, of: Schema | undefined, path: Path): void => {
    if (fields.length >= kMostFields) return;
    const key = String(path[path.length - 1] ?? '');
    if (Array.isArray(value)) {
      if (value.length > 3 || !value.every((n) => typeof n === 'number')) return;
      const names = key === 'rpy_deg' ? kTurns : kAxes;
      value.forEach((n, i) =>
        fields.push({
          path: [...path, i],
          label: `${path.join('.')} ${names[i]}`,
          value: n,
          schema: of?.items
        })
      );
    } else if (value !== null && typeof value === 'object') {
      for (const [inner, v] of Object.entries(value))
        walk(v, of?.properties?.[inner], [...path, inner]);
    } else fields.push({path, label: path.join('.'), value, schema: of});
  };
  walk(thing.value, schema, []);
  for (const key of kOptional) {
    const stands = thing.value.on !== undefined;
    if (thing.value[key] !== undefined || !schema?.properties?.[key]) continue;
    if (thing.value.look_at_m !== undefined || stands !== (key === 'yaw_deg')) continue;
    if (key === 'yaw_deg')
      fields.push({path: [key], label: key, value: undefined, schema: schema.properties[key]});
  }
  return fields;
}

function parsed(field: Field, text: string): Value {
  const types = [field.schema?.type ?? []].flat();
  const isNumber = typeof field.value === 'number' || (types.length === 1 && types[0] !== 'string');
  if (typeof field.value === 'boolean') return text === 'true';
  if (!isNumber) return text;
  const number = Number(text.trim().replace(',', '.'));
  if (text.trim() === '' || !Number.isFinite(number))
    throw new Error(`${field.label}: “${text}” is not a number`);
  return number;
}

/** The form of a thing; `set` is called with each changed value. */
export function propertyForm(
  thing: Thing,
  schema: Schema | undefined,
  set: (path: Path, value: Value) => void,
  complain: (message: string) => void
): HTMLElement {
  const rows = fieldsOf(thing, schema).map((field) => {
    const key = String(field.path.find((part) => /_/.test(String(part))) ?? field.path[0]);
    const unit = unitOf(key);
    const range = rangeOf(field.schema, unit);
    const meaning = [field.schema?.description, range].filter(Boolean).join('; ');
    const attributes = {
      title: meaning || field.label,
      'aria-label': field.label,
      'data-testid': `property-${field.path.join('-')}`
    };
    const choices = field.schema?.enum ?? (typeof field.value === 'boolean' ? [true, false] : null);
    const control = choices
      ? h(
          'select',
          attributes,
          ...choices.map((choice) => h('option', {value: String(choice)}, String(choice)))
        )
      : h('input', {...attributes, autocomplete: 'off', spellcheck: 'false'});
    control.value = field.value === undefined ? '0' : String(field.value);
    control.addEventListener('change', () => {
      try {
        set(field.path, parsed(field, control.value));
      } catch (problem) {
        complain((problem as Error).message);
      }
    });
    return h('label', {title: meaning}, h('span', {}, field.label), control, h('small', {}, unit));
  });
  return h('div', {class: 'properties'}, ...rows);
}
