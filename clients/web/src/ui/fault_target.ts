// Target of a fault: one choice for each word of the target's pattern, such as "ROBOT:NUMBER".
import {BodyKind, type CellDescription} from '../protocol';
import {h} from './dom';

/** Labels of the words of targets' patterns. */
export const kLabels: Record<string, string> = {
  ROBOT: 'robot',
  NUMBER: 'joint',
  GEAR: 'gear',
  TRAY: 'tray',
  NAME: 'part',
  EYE: 'photo-eye',
  CAMERA: 'camera'
};

/** Names in the cell for a word of a target's pattern. */
export function namesOf(word: string, cell: CellDescription, robot: number): string[] {
  const bodies = (...kinds: BodyKind[]): string[] =>
    cell.bodies.filter(({kind}) => kinds.includes(kind)).map(({name}) => name);
  switch (word) {
    case 'ROBOT':
      return cell.robots.map(({name}) => name);
    case 'NUMBER':
      return (cell.robots[robot]?.joints ?? []).map((_, i) => String(i + 1));
    case 'GEAR':
      return bodies(BodyKind.GEAR, BodyKind.PART);
    case 'TRAY':
      return bodies(BodyKind.KIT_TRAY, BodyKind.PART_TRAY);
    case 'NAME':
      return bodies(BodyKind.GEAR, BodyKind.PART, BodyKind.KIT_TRAY, BodyKind.PART_TRAY);
    case 'EYE':
      return cell.conveyor?.photoEyes.map(({name}) => name) ?? [];
    case 'CAMERA':
      return cell.cameras.map(({name}) => name);
    default:
      return [];
  }
}

export class FaultTarget {
  readonly element = h('div', {class: 'fields'});
  private words: string[] = [];
  private choices: HTMLSelectElement[] = [];

  /** Offers the targets in the cell for a pattern; keeps a choice that is still offered. */
  offer(pattern: string, cell: CellDescription): void {
    const before = this.choices.map(({value}) => value);
    this.words = pattern.split(':').filter(Boolean);
    this.choices = this.words.map((_, i) =>
      h('select', {
        'data-testid': `target-${i}`,
        onchange: () => this.words.includes('NUMBER') && this.fill(cell)
      })
    );
    this.element.replaceChildren(
      ...this.words.map((word, i) => h('label', {}, kLabels[word] ?? word, this.choices[i]))
    );
    this.element.hidden = this.words.length === 0;
    this.fill(cell, before);
  }

  /** Target as the daemon accepts it. */
  get value(): string {
    return this.choices.map(({value}) => value).join(':');
  }

  private fill(cell: CellDescription, before = this.choices.map(({value}) => value)): void {
    this.words.forEach((word, i) => {
      const robot = this.words[0] === 'ROBOT' ? Math.max(0, this.choices[0]!.selectedIndex) : 0;
      const names = namesOf(word, cell, robot);
      const choice = this.choices[i]!;
      choice.replaceChildren(...names.map((name) => h('option', {value: name}, name)));
      // Two targets of one kind default to different ones.
      const first = this.words.indexOf(word) < i ? names[1] : names[0];
      choice.value = names.includes(before[i] ?? '') ? before[i]! : (first ?? '');
    });
  }
}
