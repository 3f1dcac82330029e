// Fields of a scenario as elements.
import {h} from '../ui/dom';
import type {Path, Value} from '../editor/scene_text';
import type {Field} from './fields';

let lists = 0;

/** A form row for each field; `set` is called with each changed value. */
export function fieldForm(
  fields: readonly Field[],
  set: (path: Path, value: Value | undefined) => void,
  complain: (message: string) => void
): HTMLElement {
  return h('div', {class: 'properties'}, ...fields.map((field) => rowOf(field, set, complain)));
}

function rowOf(
  field: Field,
  set: (path: Path, value: Value | undefined) => void,
  complain: (message: string) => void
): HTMLElement {
  const {label, meaning, unit, text, placeholder, choices, suggestions} = field;
  const attributes = {
    title: meaning || label,
    'aria-label': label,
    'data-testid': `scenario-${field.path.join('-')}`
  };
  const known = choices && (choices.includes(text) ? choices : [text, ...choices]);
  const list = suggestions && suggestions.length > 0 ? `scenario-list-${++lists}` : null;
  const control = known
    ? h(
        'select',
        attributes,
        ...known.map((choice) =>
          h('option', {value: choice}, choice || (placeholder ? `(${placeholder})` : '–'))
        )
      )
    : h('input', {...attributes, placeholder, list, autocomplete: 'off', spellcheck: 'false'});
  control.value = text;
  control.addEventListener('change', () => {
    try {
      set(field.path, field.parse(control.value));
    } catch (problem) {
      complain((problem as Error).message);
    }
  });
  return h(
    'label',
    {title: meaning},
    h('span', {}, label),
    control,
    h('small', {}, unit),
    list && h('datalist', {id: list}, ...suggestions!.map((value) => h('option', {value})))
  );
}
