// Things that a scene can get: of the types of its own text and of files of types.
import {SceneText, type Value} from './scene_text';
import {contentOf, kKinds, placeOf, thingsOf, type Entry, type Kind, type Thing} from './things';

export interface Offer {
  kind: Kind;
  /** Empty for kinds without types. */
  type: string;
  /** File that has the type; empty = the scene itself, or no file is needed. */
  file: string;
  value: Entry;
}

export interface Spot {
  x: number;
  y: number;
}

/** Something to stand on. */
interface Support extends Spot {
  name: string;
  z: number;
}

const kSpotStep_m = 0.15;
/** Steps from the first spot, the nearest first. */
const kSpots = [-3, -2, -1, 0, 1, 2, 3]
  .flatMap((x) => [-2, -1, 0, 1, 2].map((y) => [x, y] as const))
  .sort(([ax, ay], [bx, by]) => Math.hypot(ax, ay) - Math.hypot(bx, by));

const isEntry = (value: unknown): value is Entry =>
  value !== null && typeof value === 'object' && !Array.isArray(value);
const numbers = (value: Value | undefined): number[] =>
  Array.isArray(value) ? value.map(Number) : [];

export class Library {
  private readonly files: {file: string; types: SceneText}[];

  constructor(files: {file: string; text: string}[]) {
    this.files = files.map(({file, text}) => ({file, types: new SceneText(text)}));
  }

  /** Everything that a scene can get, by kinds; types of its own first. */
  offers(scene: SceneText): Offer[] {
    const offers: Offer[] = [];
    for (const kind of kKinds) {
      if (!kind.types) {
        if (!kind.single || scene.get([kind.key]) === undefined)
          offers.push({kind, type: '', file: '', value: {}});
        continue;
      }
      for (const {file, types} of [{file: '', types: scene}, ...this.files]) {
        const found = types.get([kind.types]);
        for (const [type, value] of Object.entries(isEntry(found) ? found : {}))
          if (isEntry(value) && !offers.some((o) => o.kind === kind && o.type === type))
            offers.push({kind, type, file, value});
      }
    }
    return offers;
  }

  /** The tray's slots that take this type and are empty. */
  freeSlots(scene: SceneText, tray: Thing, type: string): string[] {
    const of = this.offers(scene).find(
      ({kind, type}) => kind === tray.kind && type === tray.value.type
    );
    const slots = Array.isArray(of?.value.slots) ? of.value.slots : [];
    const taken = isEntry(tray.value.gears) ? Object.keys(tray.value.gears) : [];
    return slots
      .filter(isEntry)
      .filter((slot) => slot.gear === type && !taken.includes(String(slot.name)))
      .map((slot) => String(slot.name));
  }
}

/** A name that nothing in the scene has. */
export function freeName(scene: SceneText, wish: string, others: string[] = []): string {
  const taken = new Set([...others, 'floor', 'conveyor']);
  for (const thing of thingsOf(scene)) {
    taken.add(thing.name);
    for (const name of contentOf(thing)) taken.add(name);
  }
  const tools = scene.get(['tools']);
  for (const tool of Array.isArray(tools) ? tools : [])
    if (isEntry(tool)) taken.add(String(tool.name));
  const stem = wish.replace(/^sku_/, '').replace(/_\d+$/, '');
  for (let i = 1; ; ++i) if (!taken.has(`${stem}_${i}`)) return `${stem}_${i}`;
}

function withTypes(text: string, file: string): string {
  const scene = new SceneText(text);
  const named = scene.get(['types']) ?? [];
  const known = Array.isArray(named) ? named : [named];
  return file === '' || known.includes(file) ? text : scene.append(['types'], file);
}

/** Spots to try for something new, the best first: about a thing, or what there is to stand on. */
export function spotsNear(scene: SceneText, chosen: Thing | null): Spot[] {
  const {x, y} = (chosen && placeOf(chosen)) ?? supportFor(scene, chosen);
  return kSpots.map(([i, j]) => ({
    x: Number((x + i * kSpotStep_m).toFixed(6)),
    y: Number((y + j * kSpotStep_m).toFixed(6))
  }));
}

/** The support of a thing, or else the first fixed box, the belt, or the floor. */
function supportFor(scene: SceneText, chosen: Thing | null): Support {
  const all = supportsOf(scene);
  const name = chosen?.kind.key === 'conveyor' ? 'conveyor' : (chosen?.value.on ?? chosen?.name);
  return all.find((support) => support.name === name) ?? all[0]!;
}

function supportsOf(scene: SceneText): Support[] {
  const supports: Support[] = [];
  for (const {kind, name, value} of thingsOf(scene)) {
    const [x = 0, y = 0, z = 0] = numbers(value.xyz_m);
    if (kind.key === 'fixed')
      supports.push({name, x, y, z: z + (numbers(value.size_m)[2] ?? 0) / 2});
    if (kind.key === 'conveyor') supports.push({name: 'conveyor', x, y, z});
  }
  return [...supports, {name: 'floor', x: 0, y: 0, z: 0}];
}

/** Text of a scene with one thing more, and the thing's name. `chosen`: what it goes near or into. */
export function withNew(
  scene: SceneText,
  library: Library,
  offer: Offer,
  chosen: Thing | null,
  {x, y}: Spot
): {text: string; id: string; name: string} {
  const {kind, type, file} = offer;
  const name = freeName(scene, type || kSingular[kind.key] || kind.key);
  const slot = chosen?.kind.key === 'trays' && library.freeSlots(scene, chosen, type)[0];
  const key = kind.single ? kind.key : `${kind.key}/${name}`;
  if (chosen && slot) {
    const text = scene.set([...chosen.path, 'gears', slot], name);
    return {text: withTypes(text, file), id: chosen.id, name};
  }
  const support = supportFor(scene, chosen);
  const entry = entryOf(offer, name, support, x, y);
  const text = kind.single ? scene.set([kind.key], entry) : scene.append([kind.key], entry);
  return {text: withTypes(text, file), id: key, name};
}

const kSingular: {[key: string]: string} = {
  fixed: 'box',
  fixtures: 'fixture',
  holders: 'holder',
  cameras: 'camera'
};

/** Sizes that a new thing has until they are edited. */
function entryOf(offer: Offer, name: string, on: Support, x: number, y: number): Entry {
  const {type} = offer;
  const above = (height: number): number => Number((on.z + height).toFixed(6));
  switch (offer.kind.key) {
    case 'trays':
    case 'parts':
      return {name, type, on: on.name, xy_m: [x, y]};
    case 'gears': {
      const {hub} = offer.value;
      return {name, type, xyz_m: [x, y, above(isEntry(hub) ? Number(hub.height_m ?? 0) : 0)]};
    }
    case 'fixed':
      return {name, size_m: [0.6, 0.6, 0.1], xyz_m: [x, y, above(0.05)]};
    case 'fixtures': {
      const piece = {box: {size_m: [0.1, 0.1, 0.05]}, pose: {xyz_m: [0, 0, 0.025]}};
      return {name, xyz_m: [x, y, above(0)], pieces: [piece]};
    }
    case 'robots':
      return {name, type, base: {xyz_m: [x, y, above(0)]}};
    case 'cameras':
      return {name, xyz_m: [x, y, above(1.2)], look_at_m: [x, y, above(0)]};
    case 'holders':
      return {
        name,
        xyz_m: [x, y, above(0.2)],
        seat_m: 0.02,
        gap_m: 0.06,
        bar_m: [0.1, 0.02, 0.01]
      };
    case 'conveyor':
      return {
        xyz_m: [x, y, above(0.9)],
        length_m: 2,
        width_m: 0.4,
        max_speed_m_s: 0.3,
        max_accel_m_s2: 0.5
      };
    default: // light_curtain
      return {xyz_m: [x, y, 0.3], beams: 24, pitch_m: 0.04, range_m: 2};
  }
}

/** Text of a scene with a copy of a thing and its content at another spot, and the copy's name. */
export function withCopy(
  scene: SceneText,
  thing: Thing,
  {x, y}: Spot
): {text: string; id: string; name: string} {
  const name = freeName(scene, thing.name);
  const entry = structuredClone(thing.value);
  entry.name = name;
  const taken = [name];
  if (isEntry(entry.gears))
    for (const [slot, gear] of Object.entries(entry.gears)) {
      const old = String(isEntry(gear) ? gear.name : gear);
      const free = freeName(scene, old, taken);
      taken.push(free);
      if (isEntry(gear)) gear.name = free;
      else entry.gears[slot] = free;
    }
  const pose = thing.kind.pose ? entry[thing.kind.pose] : entry;
  if (entry.on !== undefined) entry.xy_m = [x, y];
  else if (isEntry(pose) && pose.xyz_m) pose.xyz_m = [x, y, numbers(pose.xyz_m)[2] ?? 0];
  return {
    text: scene.append([thing.kind.key], entry),
    id: `${thing.kind.key}/${name}`,
    name
  };
}

/** Text without a thing. Robots are also taken out of the lists of robots that trays have. */
export function without(scene: SceneText, thing: Thing): string {
  let {text} = scene;
  if (thing.kind.key === 'robots') {
    for (const tray of thingsOf(scene).filter(({kind}) => kind.key === 'trays')) {
      const robots = tray.value.reachable_by;
      if (!Array.isArray(robots) || !robots.includes(thing.name)) continue;
      const left = robots.filter((robot) => robot !== thing.name);
      const path = [...tray.path, 'reachable_by'];
      const now = new SceneText(text);
      text = left.length > 0 ? now.set(path, left) : now.remove(path);
    }
  }
  return new SceneText(text).remove(thing.path);
}

/** A scene to begin with. */
export const kEmptyScene =
  '# Units: metres, degrees. World frame: z up.\n\ntypes: []\n\nfloor: true\n';
