// Changes of a scenario's text by the editor: they say what was meant, and leave all else as it was.
import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, readdirSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const folder = join(root, 'world/scenarios');
const ofPage = createRequire(join(root, 'clients/web/package.json'));
const {parse} = ofPage('yaml');
const schema = JSON.parse(readFileSync(join(folder, 'scenario.schema.json'), 'utf8'));

let model, built;

before(async () => {
  built = mkdtempSync(join(tmpdir(), 'aprsim-scenario-'));
  await ofPage('esbuild').build({
    stdin: {
      contents: `export * from './events'; export * from './fields';
        export {SceneText} from '../editor/scene_text';
        export {roundUp, gridOf} from './timeline'; export {problemOf} from './scenario_editor';`,
      resolveDir: join(root, 'clients/web/src/scenario_editor'),
      loader: 'ts'
    },
    bundle: true,
    format: 'esm',
    outfile: join(built, 'model.mjs'),
    logLevel: 'error'
  });
  model = await import(pathToFileURL(join(built, 'model.mjs')).href);
});
after(() => rmSync(built, {recursive: true, force: true}));

const shipped = readdirSync(folder)
  .filter((name) => name.endsWith('.yaml'))
  .map((name) => [name, readFileSync(join(folder, name), 'utf8')]);
const commentsOf = (text) => text.match(/(^|\s)#.*$/gm)?.map((line) => line.trim()) ?? [];

/** Kinds as the daemon describes them; only these parts are read. */
const kinds = [
  {name: 'robot-slow', target: 'ROBOT', momentary: false, parameters: [parameter('share', 0.5)]},
  {name: 'crcl-slow', target: 'ROBOT', momentary: false, parameters: [parameter('delay', 0.2)]},
  {name: 'part-missing', target: 'GEAR', momentary: true, parameters: []}
];
function parameter(name, usual) {
  return {name, unit: 's', min: 0.01, max: 1, default: usual, meaning: 'A value'};
}

/** Numbers in [0, 1) that are the same in every run. */
function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}
const read = (text) => new model.SceneText(text);
const eventsOf = (text) => model.eventsOf(read(text), kinds);
const at = (value, path) => path.reduce((inner, key) => inner?.[key], value);

/** One random change: its new text, and what that has to say. */
function change(text, random) {
  const wanted = parse(text);
  const events = eventsOf(text);
  const pick = (list) => list[Math.floor(random() * list.length)];
  const number = () => Math.round(random() * 1e5 + 1) / 1e3;
  const event = pick(events);
  const kind = event ? Math.floor(random() * 5) : 4;
  const scenario = read(text);
  const own = event && at(wanted, event.path);
  if (kind === 0) {
    const begin_s = number();
    if (event.begin_s === null) return [model.withBegin(scenario, event, begin_s), wanted];
    const [first, last] = event.begin_s;
    const end = Number((begin_s + last - first).toFixed(3));
    own.at_s = first === last ? begin_s : [begin_s, end];
    if (event.cancel_s !== null && begin_s !== first)
      own.cancel.at_s = Number(Math.max(0, event.cancel_s + begin_s - first).toFixed(3));
    return [model.withBegin(scenario, event, begin_s), wanted];
  }
  if (kind === 1) {
    if (event.stretches) {
      const lasts_s = number();
      if (event.list === 'orders') own.deadline_s = lasts_s;
      else if (event.list === 'faults') own.for_s = lasts_s;
      else own.at_s = [event.begin_s[0], Number((event.begin_s[0] + lasts_s).toFixed(3))];
      return [model.withLasts(scenario, event, lasts_s), wanted];
    }
    return [model.withLasts(scenario, event, 3), wanted];
  }
  if (kind === 2) {
    const next = model.withCopy(scenario, event);
    const copy = structuredClone(own);
    const added = at(parse(next.text), [event.list])?.at(-1);
    if (own.name !== undefined) copy.name = added.name;
    if (event.begin_s) {
      const [first, last] = event.begin_s.map((time) => Number((time + 5).toFixed(3)));
      copy.at_s = first === last ? first : [first, last];
    }
    wanted[event.list].push(copy);
    return [next.text, wanted];
  }
  if (kind === 3) {
    wanted[event.list].splice(event.path[1], 1);
    if (wanted[event.list].length === 0 && event.list !== 'orders') delete wanted[event.list];
    return [model.without(scenario, event), wanted];
  }
  const list = pick(['orders', 'faults', 'kill_controller']);
  const entry = list === 'orders' ? {name: 'new', tray: 'sku_x'} : {kind: 'a', at_s: number()};
  (wanted[list] ??= []).push(entry);
  return [model.withNew(scenario, list, entry).text, wanted];
}

test('every shipped scenario has its events on the timeline', () => {
  for (const [name, text] of shipped) {
    const scenario = parse(text);
    const events = eventsOf(text);
    const count = model.kLists.reduce((sum, list) => sum + (scenario[list]?.length ?? 0), 0);
    assert.equal(events.length, count, name);
    assert.equal(new Set(events.map(({id}) => id)).size, count, name);
    for (const event of events) {
      assert.deepEqual(at(scenario, event.path), event.value, `${name} ${event.id}`);
      assert.notEqual(event.title, '', `${name} ${event.id}`);
      assert.equal(event.begin_s === null, event.value.when !== undefined);
    }
  }
});

test('random changes of every shipped scenario say what was meant and keep comments', () => {
  for (const [name, original] of shipped) {
    const comments = commentsOf(original);
    for (let seed = 1; seed <= 4; ++seed) {
      const random = randomNumbers(seed * 977);
      let text = original;
      for (let i = 0; i < 15; ++i) {
        const [next, wanted] = change(text, random);
        assert.deepEqual(parse(next), wanted, `${name}, seed ${seed}, change ${i}:\n${next}`);
        text = next;
      }
      assert.deepEqual(commentsOf(text), comments, `${name}, seed ${seed}`);
    }
  }
});

test('a moved event comes back to the same bytes', () => {
  for (const [name, text] of shipped)
    for (const event of eventsOf(text).filter(
      ({begin_s, value}) => begin_s && value.at_s !== undefined
    )) {
      const moved = model.withBegin(read(text), event, event.begin_s[0] + 7.25);
      assert.notEqual(moved, text);
      const now = eventsOf(moved).find(({id}) => id === event.id);
      assert.equal(model.withBegin(read(moved), now, event.begin_s[0]), text, name);
    }
});

const kText = `# A job.
description: one job
scene: aprs

orders:
  - {name: first, tray: sku_a}  # the first
  - {name: second, tray: sku_b, when: submitted:first, cancel: {at_s: 40}}

faults:
  - {name: slow, kind: robot-slow, target: fanuc, at_s: [3, 9], with: {share: 0.4}, for_s: 5}
  - {kind: part-missing, target: part_1, when: event:first-announced}
  - {kind: crcl-slow, target: fanuc, when: grasp:fanuc:2}

kill_controller:
  - {at_s: 7}
`;
const event = (id, text = kText) => eventsOf(text).find((one) => one.id === id);

test('events have begin, length and words', () => {
  assert.deepEqual(
    eventsOf(kText).map((one) => [one.begin_s, one.lasts_s, model.timesText(one)]),
    [
      [[0, 0], null, 'at 0 s'],
      [null, null, 'when submitted:first, cancelled at 40 s'],
      [[3, 9], 5, 'at 3 to 9 s, for 5 s'],
      [null, 0, 'when event:first-announced'],
      [null, null, 'when grasp:fanuc:2'],
      [[7, 7], 0, 'at 7 s']
    ]
  );
  assert.equal(model.lastTime(eventsOf(kText)), 40);
});

test('a time replaces an event, and the other way round', () => {
  assert.equal(model.withBegin(read(kText), event('faults/2'), 12.5), kText);
  const timed = model.withField(read(kText), event('faults/2'), ['at_s'], 12.5);
  assert.match(timed, /\{kind: crcl-slow, target: fanuc, at_s: 12.5\}/);
  const waits = model.withField(read(timed), event('faults/2', timed), ['when'], 'fault:slow');
  assert.match(waits, /\{kind: crcl-slow, target: fanuc, when: "fault:slow"\}/);
  assert.equal(parse(waits).faults[2].at_s, undefined);
});

test('a momentary fault has no duration, a kill a span', () => {
  assert.equal(model.withLasts(read(kText), event('faults/1'), 5), kText);
  assert.match(model.withLasts(read(kText), event('kill_controller/0'), 3), /at_s: \[7, 10\]/);
  assert.match(model.withBegin(read(kText), event('faults/0'), -4), /at_s: \[0, 6\]/);
});

test('another kind keeps what it has too, and nothing else', () => {
  const [, other, momentary] = kinds;
  const slow = model.withKind(read(kText), event('faults/0'), other, 'fanuc');
  assert.deepEqual(parse(slow).faults[0], {
    name: 'slow',
    kind: 'crcl-slow',
    target: 'fanuc',
    at_s: [3, 9],
    for_s: 5
  });
  const missing = model.withKind(read(kText), event('faults/0'), momentary, 'part_2');
  assert.deepEqual(parse(missing).faults[0], {
    name: 'slow',
    kind: 'part-missing',
    target: 'part_2',
    at_s: [3, 9]
  });
});

test('a renamed order is renamed where others wait for it', () => {
  const next = parse(model.withField(read(kText), event('orders/0'), ['name'], 'kit'));
  assert.equal(next.orders[0].name, 'kit');
  assert.equal(next.orders[1].when, 'submitted:kit');
  assert.equal(next.faults[1].when, 'event:kit-announced');
});

test('the last value of a map goes with its map, the last order leaves an empty list', () => {
  const next = model.withField(read(kText), event('faults/0'), ['with', 'share'], undefined);
  assert.equal(parse(next).faults[0].with, undefined);
  let text = kText;
  while (event('orders/0', text)) text = model.without(read(text), event('orders/0', text));
  assert.deepEqual(parse(text).orders, []);
  assert.match(text, /^orders: \[\]$/m);
  const added = model.withNew(read(text), 'orders', {name: 'a', tray: 'b'});
  assert.deepEqual(parse(added.text).orders, [{name: 'a', tray: 'b'}]);
});

test('a scenario begins with all that it must have', () => {
  const text = model.emptyScenario('aprs');
  for (const key of schema.required) assert.ok(key in parse(text), key);
  assert.equal(read(text).problem, '');
  const {text: next} = model.withNew(read(text), 'faults', {kind: 'robot-slow', at_s: 5});
  assert.deepEqual(parse(next).faults, [{kind: 'robot-slow', at_s: 5}]);
  assert.deepEqual(commentsOf(next), commentsOf(text));
});

test('fields say a value and read the same value back', () => {
  for (const [name, text] of shipped) {
    const scenario = read(text);
    const offered = {kits: [], conditions: [], orders: [], faults: []};
    const fields = [
      ...model
        .scenarioGroups(scenario, schema)
        .flatMap((group) => group.fields.map((field) => [[], field])),
      ...eventsOf(text).flatMap((one) => {
        const kind = kinds.find((known) => known.name === one.value.kind);
        const own =
          one.list === 'orders'
            ? model.orderFields(one, schema, offered)
            : one.list === 'faults'
              ? model.faultFields(one, schema, kind, offered)
              : model.killFields(one, schema);
        return own.map((field) => [one.path, field]);
      })
    ];
    assert.ok(fields.length > 20, name);
    let said = 0;
    for (const [path, field] of fields) {
      const value = scenario.get([...path, ...field.path]);
      assert.equal(field.text === '', value === undefined, `${name} ${field.label}`);
      if (value === undefined) continue;
      ++said;
      const again = field.parse(field.text);
      const words = Array.isArray(value) && value.map(String);
      assert.ok(
        isSame(again, value) || isSame(again, words) || isSame(again, String(value)),
        `${name} ${field.label}: ${field.text}`
      );
    }
    assert.ok(said >= 4, name);
  }
});
const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);

test('fields come with units, ranges and usual values, and refuse what is no number', () => {
  const offered = {kits: ['sku_a'], conditions: ['grasp:fanuc:1'], orders: ['first'], faults: []};
  const fields = model.faultFields(event('faults/0'), schema, kinds[0], offered);
  const share = fields.find(({label}) => label === 'share');
  assert.deepEqual([share.text, share.unit, share.placeholder], ['0.4', 's', '0.5']);
  assert.match(share.meaning, /A value: 0.01 to 1/);
  assert.throws(() => share.parse('a bit'), /share: “a bit” is not a number/);
  assert.equal(share.parse(' '), undefined);
  assert.equal(share.parse('0,25'), 0.25);
  const begin = fields.find(({label}) => label === 'at_s');
  assert.deepEqual([begin.text, begin.unit], ['3, 9', 's']);
  assert.deepEqual(begin.parse('4 to 6'), [4, 6]);
  assert.equal(begin.parse('4'), 4);
  const momentary = model.faultFields(event('faults/1'), schema, kinds[2], offered);
  assert.ok(!momentary.some(({label}) => label === 'for_s'));
  const order = model.orderFields(event('orders/1'), schema, offered);
  assert.deepEqual(order.find(({label}) => label === 'tray').choices, ['sku_b', 'sku_a']);
  assert.match(order.find(({label}) => label === 'count').meaning, /1 to 1000/);
});

test('bounds are words and back', () => {
  for (const bound of [1, 0.5, {min: 1}, {max: 0.5}, {min: 1, max: 3}])
    assert.deepEqual(model.boundOf(model.boundText(bound), 'drops'), bound);
  assert.throws(() => model.boundOf('few', 'drops'), /drops: “few” is not a number/);
});

test('the scale is round, and places of the reader become lines', () => {
  assert.deepEqual([30, 31, 101, 600, 7].map(model.roundUp), [30, 50, 200, 1000, 10]);
  assert.deepEqual([10, 100, 500].map(model.gridOf), [0.1, 0.5, 1]);
  assert.deepEqual(model.problemOf('scenario text:7:3: faults[0].kind: found "x"'), {
    line: 7,
    message: 'line 7, column 3: faults[0].kind: found "x"'
  });
  assert.deepEqual(model.problemOf('too many drafts wait'), {
    line: 0,
    message: 'too many drafts wait'
  });
});

test('what cannot be read has no events', () => {
  for (const text of ['orders: [1', '- a\n', '']) assert.deepEqual(eventsOf(text), [], text);
  assert.deepEqual(eventsOf('orders: 3\nfaults: [1, x]\n'), []);
});
