// Data of the picked object, with its pose in the frame of the pendant's target.
import type {ContactSide, Pose, Snapshot} from '../protocol';
import type {CellView, Pick} from '../scene/cell_view';
import type {State} from '../state';
import {toMatrix, toVector} from '../scene/convert';
import {groupOf} from '../scene/parts';
import {button, Facts, h, text} from './dom';
import {toRollPitchYaw} from './rotation';
import type {RobotSwitch} from './robot_switch';
import {units} from './units';
import {Quaternion, Vector3} from 'three';

export class PickCard {
  readonly element = h('aside', {
    class: 'pick',
    hidden: true,
    'aria-label': 'Picked object',
    'data-testid': 'pick'
  });
  private readonly title = h('h2');
  private readonly facts = new Facts();
  private readonly target = button('', () => this.useAsTarget(), {'data-testid': 'pick-to-target'});
  private pick: Pick | null = null;
  private position_R: Vector3 | null = null;
  /** Sets the target of the chosen robot to a position [m] in its CRCL frame. */
  onTarget: (name: string, position_R: Vector3) => void = () => {};

  constructor(
    private readonly state: State,
    private readonly view: CellView,
    private readonly robots: RobotSwitch
  ) {
    this.element.append(
      h(
        'div',
        {class: 'row'},
        this.title,
        button('×', () => void this.close(), {class: 'icon', 'aria-label': 'Close'})
      ),
      this.facts.element,
      h('div', {class: 'row'}, this.target)
    );
    robots.changed.on(() => this.show(this.pick));
    state.display.on((snapshot) => this.update(snapshot));
    state.cellChanged.on(() => this.show(null));
  }

  /** Returns false where nothing was picked. */
  close(): boolean {
    if (this.pick === null) return false;
    this.view.select(null);
    this.show(null);
    return true;
  }

  show(pick: Pick | null): void {
    this.pick = pick;
    this.element.hidden = pick === null;
    this.facts.element.replaceChildren();
    Object.assign(this.facts, {values: new Map()});
    this.position_R = null;
    if (this.state.snapshot) this.update(this.state.snapshot);
  }

  private update(snapshot: Snapshot): void {
    const cell = this.state.cell,
      pick = this.pick;
    if (!pick || !cell) return;
    let name = '',
      pose: Pose | undefined,
      what = '';
    if (pick.kind === 'body') {
      const body = cell.bodies[pick.index],
        state = snapshot.bodies[pick.index];
      if (!body || !state) return;
      name = body.name;
      this.facts.set('type', body.type);
      this.facts.set('mass', `${(body.massKg * 1000).toFixed(1)} g`);
      pose = state.bodyInWorld;
      const v = state.velocityMS;
      this.facts.set(
        'speed',
        v ? `${units.lengthText(Math.hypot(v.x, v.y, v.z))} ${units.length}/s` : '–'
      );
      const lost = state.lostStep !== undefined ? 'lost: fell out of the cell' : '';
      this.facts.set('state', lost || groupOf(state) || 'moving freely');
      const {geometry} = body;
      if (geometry.case === 'gear')
        this.facts.set(
          'peg',
          `up to ${units.lengthText(geometry.value.pegTopM)} ${units.length} above its position`
        );
      if (geometry.case === 'part') {
        this.facts.set('material', geometry.value.material);
        this.facts.set('pieces', String(geometry.value.pieces.length));
      }
      this.showContacts(snapshot, 'body', pick.index);
    } else if (pick.kind === 'robot') {
      name = cell.robots[pick.index]?.name ?? '';
      this.facts.set('model', cell.robots[pick.index]?.model ?? '');
      pose = snapshot.robots[pick.index]?.toolInWorld;
      what = 'tool ';
      this.showContacts(snapshot, 'robot', pick.index);
    } else if (pick.kind === 'belt') {
      name = 'belt';
      pose = cell.conveyor?.beltInWorld;
      this.facts.set('load', `${snapshot.conveyor?.loadKg.toFixed(2)} kg`);
    } else {
      name = pick.name;
      const box = this.state.appearance?.fixed.find((b) => b.name === pick.name);
      const s = box?.sizeM;
      if (s)
        this.facts.set(
          'size',
          [s.x, s.y, s.z].map((x) => units.lengthText(x)).join(' × ') + ` ${units.length}`
        );
      const fixture = cell.fixtures.find((f) => f.name === pick.name);
      if (fixture) this.facts.set('pieces', String(fixture.pieces.length));
      pose = box?.boxInWorld ?? fixture?.fixtureInWorld;
      what = box ? 'centre ' : '';
    }
    this.showPose(pose, what);
    text(this.title, name);
  }

  /** Contacts by partner, with their number of points and total force. */
  private showContacts(snapshot: Snapshot, kind: 'body' | 'robot', index: number): void {
    const totals = new Map<string, {name: string; points: number; force: Vector3}>();
    const is = (side: ContactSide | undefined): boolean =>
      side?.thing.case === kind && side.thing.value === index;
    for (const contact of snapshot.contacts) {
      const first = is(contact.first);
      if (!first && !is(contact.second)) continue;
      const other = first ? contact.second : contact.first;
      // The key has kind and index, since things of different kinds may share a name.
      const key = `${other?.thing.case} ${other?.thing.value} ${other?.part}`;
      const total = totals.get(key) ?? {
        name: this.nameOf(other),
        points: 0,
        force: new Vector3()
      };
      totals.set(key, total);
      ++total.points;
      total.force.addScaledVector(toVector(contact.forceN), first ? 1 : -1);
    }
    const lines = [...totals.values()].map(
      ({name, points, force}) =>
        `${name} (${points} ${points === 1 ? 'point' : 'points'}, ${force.length().toFixed(2)} N)`
    );
    this.facts.set('contacts', lines.join('\n') || 'none');
  }

  private nameOf(side: ContactSide | undefined): string {
    const {cell} = this.state,
      thing = side?.thing;
    if (!cell || thing?.case === undefined) return '?';
    const names = {
      body: cell.bodies.map((body) => body.name),
      robot: cell.robots.map((robot) => robot.name),
      tool: cell.tools.map((tool) => tool.name),
      fixed: cell.fixed
    };
    const name = names[thing.case][thing.value] ?? '?';
    const part = side?.part ? ` ${side.part}` : '';
    const shared = Object.values(names).filter((all) => all.includes(name)).length > 1;
    return (shared ? `${thing.case} ${name}` : name) + part;
  }

  private showPose(pose: Pose | undefined, what: string): void {
    const robot = this.state.cell?.robots[this.robots.chosen];
    this.target.hidden = !pose || !robot;
    if (!pose) return;
    const position = (p: {x: number; y: number; z: number}): string =>
      `${[p.x, p.y, p.z].map((v) => units.lengthText(v)).join(', ')} ${units.length}`;
    if (robot) {
      const at = new Vector3(),
        turn = new Quaternion();
      toMatrix(robot.baseInWorld)
        .multiply(toMatrix(robot.referenceInBase))
        .invert()
        .multiply(toMatrix(pose))
        .decompose(at, turn, new Vector3());
      this.position_R = at;
      const angles = toRollPitchYaw({x: turn.x, y: turn.y, z: turn.z, w: turn.w});
      this.facts.set(`${what}for ${robot.name}`, position(at), 'key');
      this.facts.set(
        'roll, pitch, yaw',
        `${angles.map((a) => units.angleText(a)).join(', ')} ${units.angleSign}`
      );
      text(this.target, `Use as target of ${robot.name}`);
      const title = `Copy these coordinates, in the CRCL frame of ${robot.name}, into the target of its tool`;
      if (this.target.title !== title) this.target.title = title;
    }
    if (pose.positionM) this.facts.set(`${what}in the world`, position(pose.positionM));
  }

  private useAsTarget(): void {
    if (this.position_R) this.onTarget(this.title.textContent ?? '', this.position_R);
  }
}
