// The free space beside the chosen thing, also while it is dragged.
import type {CellView} from '../scene/cell_view';
import {gap_m, moved, type Footprint} from '../scene/footprint';
import type {SceneEditor} from './scene_editor';
import type {Thing} from './things';

const kFar_m = 1;

export interface Clearance {
  /** Name of the nearest thing at the same height. */
  name: string;
  gap_m: number;
}

export class ClearanceMeter {
  private own: Footprint[] = [];
  private others: {name: string; footprints: Footprint[]}[] = [];

  constructor(
    private readonly editor: SceneEditor,
    private readonly view: CellView
  ) {}

  /** Takes over where things are in the view. */
  take(chosen: Thing): void {
    const {editor, view} = this;
    const footprints = (thing: Thing): Footprint[] =>
      editor.picksOf(thing).flatMap((pick) => view.footprintsOf(pick));
    this.own = footprints(chosen);
    this.others = editor.things
      .filter(({id}) => id !== chosen.id)
      .map((thing) => ({name: thing.name, footprints: footprints(thing)}));
  }

  /** Where the chosen thing is displaced by this much; null where nothing is at its height. */
  measure(x_m = 0, y_m = 0): Clearance | null {
    const own = this.own.map((footprint) => moved(footprint, x_m, y_m));
    let nearest: Clearance | null = null;
    for (const {name, footprints} of this.others) {
      for (const a of own) {
        for (const b of footprints) {
          const gap = gap_m(a, b);
          if (gap < (nearest?.gap_m ?? Infinity)) nearest = {name, gap_m: gap};
        }
      }
    }
    return nearest;
  }

  /** The same in words; empty where nothing is drawn. */
  describe(x_m = 0, y_m = 0): string {
    if (this.own.length === 0) return '';
    const nearest = this.measure(x_m, y_m);
    if (!nearest || nearest.gap_m > kFar_m) return `Nothing at its height within ${kFar_m} m.`;
    return `Clearance: ${(1e3 * nearest.gap_m).toFixed(1)} mm to ${nearest.name}.`;
  }
}
