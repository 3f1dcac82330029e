// The things of a scene: names, kinds, and places.
import {SceneText, type Path, type Value} from './scene_text';

/** A kind of things, by the key under which scenes have them. */
export interface Kind {
  key: string;
  label: string;
  /** Key of the map that has its pose; absent = the thing itself. */
  pose?: string;
  /** The scene has one of it at most, without a name. */
  single?: boolean;
  /** The text of an entry names a type of this key. */
  types?: string;
}

export const kKinds: readonly Kind[] = [
  {key: 'trays', label: 'Trays and kits', types: 'tray_types'},
  {key: 'gears', label: 'Gears', types: 'gear_types'},
  {key: 'parts', label: 'Parts', types: 'part_types'},
  {key: 'fixed', label: 'Fixed boxes'},
  {key: 'fixtures', label: 'Fixtures'},
  {key: 'robots', label: 'Robots', pose: 'base', types: 'robot_types'},
  {key: 'holders', label: 'Tool holders'},
  {key: 'cameras', label: 'Cameras'},
  {key: 'conveyor', label: 'Belt', single: true},
  {key: 'light_curtain', label: 'Light curtain', single: true}
];

export type Entry = {[key: string]: Value};

export interface Thing {
  /** Different for all things of a scene, and the same after changes of it. */
  id: string;
  kind: Kind;
  name: string;
  path: Path;
  value: Entry;
}

export interface Place {
  x: number;
  y: number;
  yaw_deg: number;
}

const isEntry = (value: Value | undefined): value is Entry =>
  value !== null && typeof value === 'object' && !Array.isArray(value);

export function thingsOf(scene: SceneText): Thing[] {
  const things: Thing[] = [];
  for (const kind of kKinds) {
    const value = scene.get([kind.key]);
    if (kind.single && isEntry(value))
      things.push({id: kind.key, kind, name: kind.label, path: [kind.key], value});
    if (kind.single || !Array.isArray(value)) continue;
    value.forEach((entry, i) => {
      if (!isEntry(entry)) return;
      const name = String(entry.name ?? `${kind.key} ${i + 1}`);
      things.push({id: `${kind.key}/${name}`, kind, name, path: [kind.key, i], value: entry});
    });
  }
  return things;
}

/** Names of the gears and parts in a tray's slots. */
export function contentOf(thing: Thing): string[] {
  const {gears} = thing.value;
  if (thing.kind.key !== 'trays' || !isEntry(gears)) return [];
  return Object.values(gears).map((gear) => String(isEntry(gear) ? gear.name : gear));
}

/** The thing that has this name in the cell: itself, or the tray in which it lies. */
export function findByName(things: Thing[], name: string): Thing | undefined {
  return (
    things.find((thing) => thing.name === name && !thing.kind.single) ??
    things.find((thing) => contentOf(thing).includes(name))
  );
}

function vector(value: Value | undefined): number[] | null {
  return Array.isArray(value) && value.every((n) => typeof n === 'number')
    ? (value as number[])
    : null;
}

const standsOnSomething = ({value}: Thing): boolean => value.on !== undefined;

function poseOf(thing: Thing): {path: Path; value: Entry} {
  if (!thing.kind.pose) return {path: thing.path, value: thing.value};
  const pose = thing.value[thing.kind.pose];
  return {path: [...thing.path, thing.kind.pose], value: isEntry(pose) ? pose : {}};
}

/** Where a thing is, seen from above; null where the scene does not say it in the world's frame. */
export function placeOf(thing: Thing): Place | null {
  if (standsOnSomething(thing)) {
    const xy = vector(thing.value.xy_m);
    return xy && {x: xy[0]!, y: xy[1]!, yaw_deg: Number(thing.value.yaw_deg ?? 0)};
  }
  if (thing.value.on_flange !== undefined) return null;
  const {value} = poseOf(thing);
  const xyz = vector(value.xyz_m) ?? (thing.kind.pose ? [0, 0, 0] : null);
  return xyz && {x: xyz[0]!, y: xyz[1]!, yaw_deg: vector(value.rpy_deg)?.[2] ?? 0};
}

/** Whether it can be turned about the vertical by one number. */
export function turns(thing: Thing): boolean {
  return placeOf(thing) !== null && thing.value.look_at_m === undefined;
}

const round = (value: number): number => Number(value.toFixed(6)) + 0;
/** An angle within half a turn. */
export function wrapped(deg: number): number {
  const turned = ((((deg + 180) % 360) + 360) % 360) - 180;
  return round(turned === -180 ? 180 : turned);
}

/** Text of a scene in which a thing is at another place. */
export function withPlace(scene: SceneText, thing: Thing, {x, y, yaw_deg}: Place): string {
  const before = placeOf(thing);
  if (!before) throw new Error(`${thing.name} has no place of its own`);
  const turned = yaw_deg !== before.yaw_deg ? wrapped(yaw_deg) : null;
  if (standsOnSomething(thing)) {
    const moved = scene.set([...thing.path, 'xy_m'], [round(x), round(y)]);
    return turned === null ? moved : withValue(moved, [...thing.path, 'yaw_deg'], turned);
  }
  const {path, value} = poseOf(thing);
  const z = vector(value.xyz_m)?.[2] ?? 0;
  const moved = scene.set([...path, 'xyz_m'], [round(x), round(y), z]);
  if (turned === null) return moved;
  const [roll = 0, pitch = 0] = vector(value.rpy_deg) ?? [];
  return withValue(moved, [...path, 'rpy_deg'], [roll, pitch, turned]);
}

function withValue(text: string, path: Path, value: Value): string {
  return new SceneText(text).set(path, value);
}
