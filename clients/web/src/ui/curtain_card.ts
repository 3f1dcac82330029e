// The light curtain: output, beams, and a button that breaks them.
import type {CellDescription, Pose, Snapshot} from '../protocol';
import {toMatrix} from '../scene/convert';
import type {State} from '../state';
import type {Access} from './access';
import {button, card, Facts, h, text} from './dom';
import {units} from './units';
import {Vector3} from 'three';

/** A length without zeros at its end. */
const plain = (m: number): string => `${Number(units.lengthText(m))} ${units.length}`;

const kReactions = ['none', 'belt stop', 'protective stop', 'belt and robots stop'];

export class CurtainCard {
  readonly element: HTMLElement;
  private readonly facts = new Facts();
  private readonly beams = h('div', {
    class: 'beams',
    role: 'img',
    'aria-label': 'Beams of the light curtain, the lowest on the left'
  });
  private readonly reach: HTMLButtonElement;

  constructor(
    private readonly state: State,
    access: Access
  ) {
    this.reach = access.guard(
      button(
        'Break light curtain',
        () => void access.command({case: 'intruder', value: this.intruder()}),
        {
          title: 'Place a box in the beams, as a person reaching in would',
          'data-testid': 'reach'
        }
      ),
      undefined,
      false,
      'inject'
    );
    this.element = card(
      'Light curtain',
      this.facts.element,
      this.beams,
      h('div', {class: 'row'}, this.reach)
    );
    state.cellChanged.on((cell) => this.build(cell));
    units.changed.on(() => state.cell && this.build(state.cell));
    state.display.on((snapshot) => this.show(snapshot));
  }

  private build(cell: CellDescription): void {
    const curtain = cell.lightCurtain;
    this.element.hidden = !curtain;
    if (!curtain) return;
    this.facts.set(
      'beams',
      `${curtain.beams}, ${plain(curtain.pitchM)} apart, ${plain(curtain.rangeM)} long`
    );
    this.facts.set('reaction', kReactions[curtain.reaction] ?? '?');
    this.beams.replaceChildren(...Array.from({length: curtain.beams}, () => h('span')));
  }

  private show(snapshot: Snapshot): void {
    const curtain = this.state.cell?.lightCurtain,
      now = snapshot.lightCurtain;
    if (!curtain || !now) return;
    this.facts.set('output', now.broken ? 'broken' : 'clear', now.broken ? 'bad' : 'good');
    now.distanceM.forEach((distance, i) => {
      const beam = this.beams.children[i] as HTMLElement | undefined;
      beam?.classList.toggle('broken', distance < curtain.rangeM);
    });
    text(this.reach, snapshot.intruder ? 'Clear light curtain' : 'Break light curtain');
  }

  /** A box in the middle of the beams; nothing where one is there already. */
  private intruder() {
    const curtain = this.state.cell?.lightCurtain;
    if (!curtain || this.state.snapshot?.intruder) return {};
    const middle = new Vector3(
      curtain.rangeM / 2,
      0,
      (curtain.beams * curtain.pitchM) / 2
    ).applyMatrix4(toMatrix(curtain.curtainInWorld as Pose));
    return {
      intruder: {
        intruderInWorld: {
          positionM: {x: middle.x, y: middle.y, z: middle.z},
          orientation: {w: 1, x: 0, y: 0, z: 0}
        },
        sizeM: {x: 0.16, y: 0.3, z: 0.12}
      }
    };
  }
}
