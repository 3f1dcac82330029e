// Changes of a scene's text by the editor: they say what was meant, and leave all else as it was.
import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, readdirSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const scenes = join(root, 'world/scenes');
const ofPage = createRequire(join(root, 'clients/web/package.json'));
const {parse, parseDocument} = ofPage('yaml');

let editor, folder;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'aprsim-editor-'));
  await ofPage('esbuild').build({
    stdin: {
      contents: `export * from './scene_text'; export * from './draft'; export * from './things';
        export * from './library';`,
      resolveDir: join(root, 'clients/web/src/editor'),
      loader: 'ts'
    },
    bundle: true,
    format: 'esm',
    outfile: join(folder, 'editor.mjs'),
    logLevel: 'error'
  });
  editor = await import(pathToFileURL(join(folder, 'editor.mjs')).href);
});
after(() => rmSync(folder, {recursive: true, force: true}));

/** Numbers in [0, 1) that are the same in every run. */
function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

const shipped = readdirSync(scenes)
  .filter((name) => name.endsWith('.yaml'))
  .map((name) => [name, readFileSync(join(scenes, name), 'utf8')]);
const commentsOf = (text) => text.match(/(^|\s)#.*$/gm)?.map((line) => line.trim()) ?? [];
const kLists = ['trays', 'parts', 'fixed', 'fixtures', 'robots', 'cameras', 'gears'];

/** All paths of a value, with what is there. */
function* pathsOf(value, path = []) {
  if (path.length > 0) yield [path, value];
  if (value === null || typeof value !== 'object') return;
  for (const [key, inner] of Object.entries(value))
    yield* pathsOf(inner, [...path, Array.isArray(value) ? Number(key) : key]);
}
function at(value, path) {
  return path.reduce((inner, key) => inner?.[key], value);
}

/** One random change: its new text, and what that has to say. */
function change(text, random) {
  const wanted = parse(text) ?? {};
  const scene = new editor.SceneText(text);
  const pick = (list) => list[Math.floor(random() * list.length)];
  const number = () => Math.round((random() * 4 - 2) * 1e4) / 1e4;
  const kind = Math.floor(random() * 5);
  if (kind === 0) {
    const numbers = [...pathsOf(wanted)].filter(([, value]) => typeof value === 'number');
    if (numbers.length === 0) return [text, wanted];
    const [path] = pick(numbers);
    const value = number();
    at(wanted, path.slice(0, -1))[path.at(-1)] = value;
    return [scene.set(path, value), wanted];
  }
  if (kind === 1) {
    const vectors = [...pathsOf(wanted)].filter(
      ([, value]) => Array.isArray(value) && value.every((n) => typeof n === 'number')
    );
    if (vectors.length === 0) return [text, wanted];
    const [path, value] = pick(vectors);
    const next = value.map((old) => (random() < 0.5 ? old : number()));
    at(wanted, path.slice(0, -1))[path.at(-1)] = next;
    return [scene.set(path, next), wanted];
  }
  if (kind === 2) {
    const key = pick(kLists);
    const entry = {name: `new_${Math.floor(random() * 1e6)}`, xyz_m: [number(), 0, 1], yes: 'on'};
    (wanted[key] ??= []).push(entry);
    return [scene.append([key], entry), wanted];
  }
  const entries = kLists.flatMap((key) => (wanted[key] ?? []).map((_, i) => [key, i]));
  if (entries.length === 0) return [text, wanted];
  const [key, i] = pick(entries);
  if (kind === 3) {
    const name = pick(['yaw_deg', 'rpy_deg', 'extra']);
    const value = name === 'rpy_deg' ? [0, 0, number()] : number();
    wanted[key][i][name] = value;
    return [scene.set([key, i, name], value), wanted];
  }
  wanted[key].splice(i, 1);
  if (wanted[key].length === 0) delete wanted[key];
  return [scene.remove([key, i]), wanted];
}

test('random changes of every shipped scene say what was meant', () => {
  for (const [name, original] of shipped) {
    for (let seed = 1; seed <= 3; ++seed) {
      const random = randomNumbers(seed * 977);
      let text = original;
      for (let i = 0; i < 15; ++i) {
        const [next, wanted] = change(text, random);
        assert.deepEqual(parse(next) ?? {}, wanted, `${name}, seed ${seed}, change ${i}:\n${next}`);
        text = next;
      }
    }
  }
});

test('a changed number changes no other byte', () => {
  for (const [name, text] of shipped) {
    const numbers = [...pathsOf(parse(text))].filter(([, value]) => typeof value === 'number');
    for (const [path] of numbers.filter((_, i) => i % 3 === 0)) {
      const next = new editor.SceneText(text).set(path, 0.7071);
      const [line, ...more] = text
        .split('\n')
        .map((old, i) => [old, next.split('\n')[i]])
        .filter(([old, now]) => old !== now);
      assert.equal(more.length, 0, `${name} ${path}`);
      const rest = line[1].split('0.7071');
      assert.ok(
        rest.some((_, i) => {
          const head = rest.slice(0, i + 1).join('0.7071'),
            tail = rest.slice(i + 1).join('0.7071');
          return line[0].startsWith(head) && line[0].endsWith(tail);
        }),
        `${name} ${path}: ${line.join(' -> ')}`
      );
    }
  }
});

test('additions and removals keep the comments of everything else', () => {
  for (const [name, text] of shipped) {
    const scene = parse(text);
    for (const key of kLists.filter((list) => scene[list])) {
      const added = new editor.SceneText(text).append([key], {name: 'one_more'});
      assert.deepEqual(commentsOf(added), commentsOf(text), `${name} ${key}`);
      const index = scene[key].length;
      assert.equal(new editor.SceneText(added).remove([key, index]), text, `${name} ${key}`);
    }
  }
});

test('texts that are no maps, or empty, take the first thing', () => {
  for (const text of ['', '# a cell\n', '{}\n', 'trays:\n', 'trays: []\n', 'trays: [] # none\n']) {
    const next = new editor.SceneText(text).append(['trays'], {name: 'a', xy_m: [1, 2]});
    assert.deepEqual(parse(next), {trays: [{name: 'a', xy_m: [1, 2]}]}, JSON.stringify(text));
    assert.deepEqual(commentsOf(next), commentsOf(text));
  }
  assert.match(new editor.SceneText('- a\n').problem, /map/);
  assert.match(new editor.SceneText('a: [1\n').problem, /./);
  assert.equal(parseDocument('a: 1').errors.length, 0);
});

test('undo and redo give the same texts, byte for byte', () => {
  const random = randomNumbers(5);
  for (const [name, original] of shipped.slice(0, 4)) {
    const draft = new editor.Draft(name, original);
    const texts = [original];
    for (let i = 0; i < 40; ++i) {
      const kind = random();
      if (kind < 0.5) {
        const [next] = change(draft.text, random);
        if (next === draft.text) continue;
        texts.splice(texts.indexOf(draft.text) + 1, Infinity, next);
        draft.change(next);
      } else {
        const at = texts.indexOf(draft.text) + (kind < 0.8 ? -1 : 1);
        const wanted = texts[at] ?? draft.text;
        assert.equal(
          at >= 0 && at < texts.length,
          (kind < 0.8 ? draft.undoable : draft.redoable) !== null
        );
        kind < 0.8 ? draft.undo() : draft.redo();
        assert.equal(draft.text, wanted);
      }
    }
    while (draft.undoable !== null) draft.undo();
    assert.equal(draft.text, original);
  }
});

test('a thing that is moved and turned is there, and comes back', () => {
  for (const [name, text] of shipped) {
    const things = editor.thingsOf(new editor.SceneText(text));
    for (const thing of things.filter((t) => editor.placeOf(t)).slice(0, 12)) {
      const place = editor.placeOf(thing);
      const to = {
        x: place.x + 0.1,
        y: place.y - 0.2,
        yaw_deg: editor.turns(thing) ? 345 : place.yaw_deg
      };
      const moved = new editor.SceneText(editor.withPlace(new editor.SceneText(text), thing, to));
      const now = editor.thingsOf(moved).find(({id}) => id === thing.id);
      const at = editor.placeOf(now);
      assert.ok(Math.hypot(at.x - to.x, at.y - to.y) < 1e-5, `${name} ${thing.id}`);
      assert.equal(at.yaw_deg, editor.turns(thing) ? -15 : place.yaw_deg, `${name} ${thing.id}`);
      assert.equal(editor.thingsOf(moved).length, things.length);
    }
  }
  for (const [deg, wanted] of [
    [180, 180],
    [-180, 180],
    [190, -170],
    [-345, 15],
    [720, 0]
  ])
    assert.equal(editor.wrapped(deg), wanted);
});

test('additions and copies have names that nothing else has', () => {
  const folder = join(scenes, 'types');
  const library = new editor.Library(
    readdirSync(folder).map((file) => ({
      file: `types/${file}`,
      text: readFileSync(join(folder, file), 'utf8')
    }))
  );
  const namesOf = (scene) =>
    editor.thingsOf(scene).flatMap((thing) => [thing.id, ...editor.contentOf(thing)]);
  for (const [name, text] of shipped.filter((_, i) => i % 3 === 0)) {
    const scene = new editor.SceneText(text);
    const offers = library.offers(scene);
    assert.ok(
      offers.some(({kind}) => kind.key === 'robots'),
      name
    );
    for (const offer of offers) {
      const added = editor.withNew(scene, library, offer, null, {x: 0.5, y: -0.25});
      const after = new editor.SceneText(added.text);
      assert.equal(after.problem, '', `${name} ${offer.type}`);
      const names = namesOf(after);
      assert.equal(new Set(names).size, names.length, `${name} ${offer.type}`);
      assert.equal(names.length, namesOf(scene).length + 1, `${name} ${offer.type}`);
      if (offer.file) assert.ok([after.get(['types'])].flat().includes(offer.file));
    }
    for (const thing of editor.thingsOf(scene).filter(({kind}) => !kind.single)) {
      const after = new editor.SceneText(editor.withCopy(scene, thing, {x: 1, y: 2}).text);
      const names = namesOf(after);
      assert.equal(new Set(names).size, names.length, `${name} ${thing.id}`);
      const removed = editor.without(
        after,
        editor.thingsOf(after).find((t) => !namesOf(scene).includes(t.id))
      );
      assert.deepEqual(parse(removed), parse(text), `${name} ${thing.id}`);
    }
  }
});
