// Dragging of the chosen thing in the view, on a grid.
import type {CellView, Pick} from '../scene/cell_view';
import type {SceneEditor} from './scene_editor';
import {placeOf, type Thing} from './things';

const kGrid_m = 0.005;

const snapped = (value: number): number => Math.round(value / kGrid_m) * kGrid_m;

export class DragInView {
  private held: Thing | null = null;

  constructor(
    private readonly editor: SceneEditor,
    view: CellView,
    private readonly mark: (picks: Pick[]) => void,
    private readonly onDrag: (x_m: number, y_m: number) => void
  ) {
    const grabber = {
      grab: (pick: Pick) => this.grab(pick),
      drag: (x_m: number, y_m: number, free: boolean) => this.drag(x_m, y_m, free),
      drop: (x_m: number, y_m: number) => void this.drop(x_m, y_m)
    };
    editor.changed.on(() => view.setGrabber(editor.open ? grabber : null));
  }

  /** Only the chosen thing is dragged, so that the view can be turned from anywhere else. */
  private grab(pick: Pick): Pick[] | null {
    const {chosen} = this.editor;
    if (!chosen || this.editor.busy || !placeOf(chosen)) return null;
    const picks = this.editor.picksOf(chosen);
    const isIts = picks.some((own) => JSON.stringify(own) === JSON.stringify(pick));
    this.held = isIts ? chosen : null;
    return this.held ? picks : null;
  }

  private drag(x_m: number, y_m: number, free: boolean): [number, number] {
    const place = this.held && placeOf(this.held);
    const [x, y] =
      !place || free
        ? [x_m, y_m]
        : [snapped(place.x + x_m) - place.x, snapped(place.y + y_m) - place.y];
    this.onDrag(x, y);
    return [x, y];
  }

  private async drop(x_m: number, y_m: number): Promise<void> {
    const {held} = this;
    const place = held && placeOf(held);
    if (!held || !place) return;
    const moved = await this.editor.move(held, {...place, x: place.x + x_m, y: place.y + y_m});
    if (!moved) this.editor.restore();
    this.mark(this.editor.picksOf(held));
  }
}
