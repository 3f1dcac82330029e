// What the picked object is and where it is.
import type {ContactSide, Snapshot} from '../protocol';
import type {Pick, View} from '../scene/view';
import type {State} from '../state';
import {toVector} from '../scene/convert';
import {groupOf} from '../scene/parts';
import {button, Facts, h, text} from './dom';
import {toRollPitchYaw} from './rotation';
import {units} from './units';
import {Vector3} from 'three';

export class PickCard {
  readonly element = h('aside', {
    class: 'pick',
    hidden: true,
    'aria-label': 'Picked object',
    'data-testid': 'pick'
  });
  private readonly title = h('h2');
  private readonly facts = new Facts();
  private pick: Pick | null = null;

  constructor(
    private readonly state: State,
    view: View
  ) {
    this.element.append(
      h(
        'div',
        {class: 'row'},
        this.title,
        button(
          '×',
          () => {
            view.select(null);
            this.show(null);
          },
          {class: 'icon', 'aria-label': 'Close'}
        )
      ),
      this.facts.element
    );
    view.onPick = (pick) => this.show(pick);
    state.display.on((snapshot) => this.update(snapshot));
    state.cellChanged.on(() => this.show(null));
  }

  private show(pick: Pick | null): void {
    this.pick = pick;
    this.element.hidden = pick === null;
    this.facts.element.replaceChildren();
    Object.assign(this.facts, {values: new Map()});
    if (this.state.snapshot) this.update(this.state.snapshot);
  }

  private update(snapshot: Snapshot): void {
    const cell = this.state.cell,
      pick = this.pick;
    if (!pick || !cell) return;
    let name = '';
    if (pick.kind === 'body') {
      const body = cell.bodies[pick.index],
        state = snapshot.bodies[pick.index];
      if (!body || !state) return;
      name = body.name;
      this.facts.set('type', body.type);
      this.facts.set('mass', `${(body.massKg * 1000).toFixed(1)} g`);
      this.showPose(state.bodyInWorld);
      const v = state.velocityMS;
      this.facts.set(
        'speed',
        v ? `${units.lengthText(Math.hypot(v.x, v.y, v.z))} ${units.length}/s` : '–'
      );
      const lost = state.lostStep !== undefined ? 'lost, fallen out of the cell' : '';
      this.facts.set('state', lost || groupOf(state) || 'moving freely');
      this.showContacts(snapshot, 'body', pick.index);
    } else if (pick.kind === 'robot') {
      name = cell.robots[pick.index]?.name ?? '';
      this.facts.set('model', cell.robots[pick.index]?.model ?? '');
      this.showPose(snapshot.robots[pick.index]?.toolInWorld, 'tool ');
      this.showContacts(snapshot, 'robot', pick.index);
    } else if (pick.kind === 'belt') {
      name = 'belt';
      this.facts.set('load', `${snapshot.conveyor?.loadKg.toFixed(2)} kg`);
    } else {
      name = pick.name;
      const box = this.state.looks?.fixed.find((b) => b.name === pick.name);
      const s = box?.sizeM;
      if (s)
        this.facts.set(
          'size',
          [s.x, s.y, s.z].map((x) => units.lengthText(x)).join(' × ') + ` ${units.length}`
        );
      this.showPose(box?.boxInWorld);
    }
    text(this.title, name);
  }

  /** What it touches, with how many points and what force they bear together. */
  private showContacts(snapshot: Snapshot, kind: 'body' | 'robot', index: number): void {
    const totals = new Map<string, {name: string; points: number; force: Vector3}>();
    const is = (side: ContactSide | undefined): boolean =>
      side?.thing.case === kind && side.thing.value === index;
    for (const contact of snapshot.contacts) {
      const first = is(contact.first);
      if (!first && !is(contact.second)) continue;
      const other = first ? contact.second : contact.first;
      // By what it is, not by its name: a tray, a robot and something fixed may share one.
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
      fixed: cell.fixed
    };
    const name = names[thing.case][thing.value] ?? '?';
    const part = side?.part ? ` ${side.part}` : '';
    const shared = Object.values(names).filter((all) => all.includes(name)).length > 1;
    return (shared ? `${thing.case} ${name}` : name) + part;
  }

  private showPose(pose: import('../protocol').Pose | undefined, prefix = ''): void {
    const p = pose?.positionM;
    if (!p) return;
    this.facts.set(
      `${prefix}position`,
      `${units.lengthText(p.x)}, ${units.lengthText(p.y)}, ${units.lengthText(p.z)} ${units.length}`
    );
    this.facts.set(
      `${prefix}turn`,
      toRollPitchYaw(pose.orientation)
        .map((a) => units.angleText(a))
        .join(', ') + ` ${units.angleSign}`
    );
  }
}
