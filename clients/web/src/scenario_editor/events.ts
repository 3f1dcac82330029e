// The events of a scenario: orders, faults and kills of the controller, with their times.
import {SceneText, type Path, type Value} from '../editor/scene_text';
import type {FaultKind} from '../protocol';

export type List = 'orders' | 'faults' | 'kill_controller';
export const kLists: readonly List[] = ['orders', 'faults', 'kill_controller'];
export type Entry = {[key: string]: Value};

export interface TimedEvent {
  /** Its list and its place in it. */
  id: string;
  list: List;
  path: Path;
  value: Entry;
  title: string;
  /** First and last time of its begin; null = it waits for an event. */
  begin_s: [number, number] | null;
  /** The event that it waits for; empty = none. */
  when: string;
  /** Null = to the end of the run; 0 = a moment. */
  lasts_s: number | null;
  /** Time of the cancellation of an order; null = none, or at an event. */
  cancel_s: number | null;
  /** Its duration can be changed. */
  stretches: boolean;
}

export const isEntry = (value: Value | undefined): value is Entry =>
  value !== null && typeof value === 'object' && !Array.isArray(value);

/** A time in milliseconds at most. */
export const rounded = (time_s: number): number => Number(time_s.toFixed(3)) + 0;

const numberOr = <T>(value: Value | undefined, other: T): number | T =>
  typeof value === 'number' ? value : other;
const wordOf = (value: Value | undefined): string =>
  value === undefined || value === null ? '' : String(value);

function timesOf(value: Value | undefined): [number, number] {
  if (Array.isArray(value)) return [numberOr(value[0], 0), numberOr(value[1], 0)];
  return [numberOr(value, 0), numberOr(value, 0)];
}

export function eventsOf(scenario: SceneText, kinds: readonly FaultKind[]): TimedEvent[] {
  if (scenario.problem) return [];
  return kLists.flatMap((list) => {
    const entries = scenario.get([list]);
    if (!Array.isArray(entries)) return [];
    return entries.flatMap((value, i) => (isEntry(value) ? [eventOf(list, i, value, kinds)] : []));
  });
}

function eventOf(list: List, i: number, value: Entry, kinds: readonly FaultKind[]): TimedEvent {
  const when = wordOf(value.when);
  const event: TimedEvent = {
    id: `${list}/${i}`,
    list,
    path: [list, i],
    value,
    title: '',
    begin_s: when ? null : timesOf(value.at_s),
    when,
    lasts_s: null,
    cancel_s: null,
    stretches: true
  };
  if (list === 'orders') {
    const count = numberOr(value.count, 1);
    event.title = `${wordOf(value.name)}: ${count === 1 ? '' : `${count} × `}${wordOf(value.tray)}`;
    event.lasts_s = numberOr(value.deadline_s, null);
    if (isEntry(value.cancel) && value.cancel.when === undefined)
      event.cancel_s = numberOr(value.cancel.at_s, 0);
  } else if (list === 'faults') {
    const kind = kinds.find(({name}) => name === value.kind);
    event.title = [value.kind, value.target].map(wordOf).filter(Boolean).join(' ');
    event.stretches = !kind?.momentary;
    event.lasts_s = kind?.momentary ? 0 : numberOr(value.for_s, null);
  } else {
    event.title = 'controller killed';
    event.lasts_s = 0;
  }
  return event;
}

/** Its times in words. */
export function timesText({begin_s, when, lasts_s, list, value}: TimedEvent): string {
  const parts: string[] = [];
  if (!begin_s) parts.push(`when ${when}`);
  else if (begin_s[0] === begin_s[1]) parts.push(`at ${rounded(begin_s[0])} s`);
  else parts.push(`at ${rounded(begin_s[0])} to ${rounded(begin_s[1])} s`);
  if (lasts_s) parts.push(list === 'orders' ? `deadline after ${lasts_s} s` : `for ${lasts_s} s`);
  if (isEntry(value.cancel))
    parts.push(
      `cancelled ${value.cancel.when ? `when ${wordOf(value.cancel.when)}` : `at ${numberOr(value.cancel.at_s, 0)} s`}`
    );
  return parts.join(', ');
}

/** Last time at which anything in the scenario begins or ends [s]. */
export function lastTime(events: readonly TimedEvent[]): number {
  return Math.max(
    0,
    ...events.map(({begin_s, lasts_s, cancel_s}) =>
      Math.max(begin_s ? begin_s[1] + (lasts_s ?? 0) : 0, cancel_s ?? 0)
    )
  );
}

// ---- changes: each gives the new text

/** Moves the begin of an event, unless it waits for another one. */
export function withBegin(scenario: SceneText, event: TimedEvent, begin_s: number): string {
  const from = rounded(Math.max(0, begin_s));
  if (!event.begin_s) return scenario.text;
  const [first, last] = event.begin_s;
  if (from === first) return scenario.text;
  const at = first === last ? from : [from, rounded(from + last - first)];
  const {text} = scenario;
  const moved = scenario.set([...event.path, 'at_s'], at);
  if (event.cancel_s === null || text === moved) return moved;
  const cancel_s = rounded(Math.max(0, event.cancel_s + from - first));
  return new SceneText(moved).set([...event.path, 'cancel', 'at_s'], cancel_s);
}

/** Changes the duration: of a fault, until an order's deadline, or of the span of a kill's time. */
export function withLasts(scenario: SceneText, event: TimedEvent, lasts_s: number): string {
  const length_s = rounded(Math.max(0, lasts_s));
  if (!event.stretches) return scenario.text;
  if (event.list === 'kill_controller') {
    const [first] = event.begin_s!;
    const at = length_s > 0 ? [first, rounded(first + length_s)] : first;
    return scenario.set([...event.path, 'at_s'], at);
  }
  if (length_s === 0) return scenario.text;
  const key = event.list === 'orders' ? 'deadline_s' : 'for_s';
  return scenario.set([...event.path, key], length_s);
}

/** The duration that withLasts() changes; null = it has none yet. */
export function lengthOf({list, begin_s, lasts_s}: TimedEvent): number | null {
  return list === 'kill_controller' && begin_s ? begin_s[1] - begin_s[0] : lasts_s;
}

/** Sets a value of an event, or removes it; at_s and when replace each other. */
export function withField(
  scenario: SceneText,
  event: TimedEvent,
  path: Path,
  value: Value | undefined
): string {
  const whole = [...event.path, ...path];
  let {text} = scenario;
  if (value === undefined) text = withoutKey(scenario, whole);
  else {
    text = scenario.set(whole, value);
    const other = {at_s: 'when', when: 'at_s'}[String(path[path.length - 1])];
    const beside = [...whole.slice(0, -1), other ?? ''];
    if (other && scenario.get(beside) !== undefined) text = new SceneText(text).remove(beside);
  }
  if (path.length === 1 && path[0] === 'name')
    return withReferences(text, event.list, wordOf(event.value.name), wordOf(value));
  return text;
}

/** Removes a key, and the map around it if nothing is left. */
export function withoutKey(scenario: SceneText, path: Path): string {
  if (scenario.get(path) === undefined) return scenario.text;
  const around = path.slice(0, -1);
  const map = around.length > 0 ? scenario.get(around) : undefined;
  const alone = isEntry(map) && Object.keys(map).length === 1;
  return scenario.remove(alone && typeof around[around.length - 1] === 'string' ? around : path);
}

/** Renames an order or a fault where others wait for it. */
function withReferences(text: string, list: List, old: string, name: string): string {
  if (!old || !name || old === name) return text;
  const renamed = (when: string): string => {
    if (list === 'faults') return when === `fault:${old}` ? `fault:${name}` : when;
    if (when === `submitted:${old}`) return `submitted:${name}`;
    const [, event] = /^event:.*-(announced|submitted|cancelled)$/.exec(when) ?? [];
    return event && when === `event:${old}-${event}` ? `event:${name}-${event}` : when;
  };
  let scenario = new SceneText(text);
  for (const path of ['orders', 'faults'].flatMap((key) => whensOf(scenario, key))) {
    const when = wordOf(scenario.get(path));
    const next = renamed(when);
    if (next !== when) scenario = new SceneText(scenario.set(path, next));
  }
  return scenario.text;
}

function whensOf(scenario: SceneText, list: string): Path[] {
  const entries = scenario.get([list]);
  return (Array.isArray(entries) ? entries : []).flatMap((_, i) =>
    [
      [list, i, 'when'],
      [list, i, 'cancel', 'when']
    ].filter((path) => scenario.get(path) !== undefined)
  );
}

/** Makes a fault one of another kind; keeps what that one has too. */
export function withKind(
  scenario: SceneText,
  event: TimedEvent,
  kind: FaultKind,
  target: string
): string {
  let text = scenario.set([...event.path, 'kind'], kind.name);
  const change = (next: (scenario: SceneText) => string): void => {
    text = next(new SceneText(text));
  };
  const {value} = event;
  if (wordOf(value.target) !== target)
    change((s) =>
      target ? s.set([...event.path, 'target'], target) : withoutKey(s, [...event.path, 'target'])
    );
  if (isEntry(value.with))
    for (const name of Object.keys(value.with))
      if (!kind.parameters.some((parameter) => parameter.name === name))
        change((s) => withoutKey(s, [...event.path, 'with', name]));
  if (kind.momentary) change((s) => withoutKey(s, [...event.path, 'for_s']));
  return text;
}

export function withNew(scenario: SceneText, list: List, entry: Entry): {text: string; id: string} {
  const entries = scenario.get([list]);
  const index = Array.isArray(entries) ? entries.length : 0;
  return {text: scenario.append([list], entry), id: `${list}/${index}`};
}

const kCopyStep_s = 5;

/** Adds a copy of an event, some seconds later and with a name of its own. */
export function withCopy(scenario: SceneText, event: TimedEvent): {text: string; id: string} {
  const entry = structuredClone(event.value);
  if (entry.name !== undefined) entry.name = freeName(scenario, event.list, wordOf(entry.name));
  if (event.begin_s) {
    const [first, last] = event.begin_s.map((time_s) => rounded(time_s + kCopyStep_s));
    entry.at_s = first === last ? first! : [first!, last!];
  }
  return withNew(scenario, event.list, entry);
}

/** A name that no other entry of the list has. */
export function freeName(scenario: SceneText, list: List, wish: string): string {
  const entries = scenario.get([list]);
  const taken = (Array.isArray(entries) ? entries : []).map((entry) =>
    isEntry(entry) ? wordOf(entry.name) : ''
  );
  const stem = wish.replace(/_\d+$/, '');
  for (let i = 1; ; ++i) if (!taken.includes(`${stem}_${i}`)) return `${stem}_${i}`;
}

/** Removes an event. A scenario must have the key of its orders, be it empty. */
export function without(scenario: SceneText, event: TimedEvent): string {
  const entries = scenario.get([event.list]);
  const only = Array.isArray(entries) && entries.length === 1;
  if (event.list !== 'orders' || !only) return scenario.remove(event.path);
  return scenario.set(['orders'], []).replace(/^orders:\s+\[\]/m, 'orders: []');
}

/** A scenario to begin with. */
export const emptyScenario = (scene: string): string =>
  `# Times in simulated seconds since the start.\n\ndescription: A new scenario\nscene: ${scene}\n\norders: []\n`;
