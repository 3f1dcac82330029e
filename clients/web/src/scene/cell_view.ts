// The view of the cell as the rest of the page uses it, with or without WebGL.
import type {MovePlan} from '../protocol';
import type {State} from '../state';
import type {Grabber} from './dragging';
import type {Footprint} from './footprint';
import {isWebGlAvailable} from './quality';
import {View} from './view';

/** Overlays on the cell. */
export interface Layers {
  groups: boolean;
  contacts: boolean;
  trails: boolean;
  targets: boolean;
  cameras: boolean;
  curtain: boolean;
  names: boolean;
}

export type Pick =
  | {kind: 'body'; index: number}
  | {kind: 'robot'; index: number}
  | {kind: 'fixed'; name: string}
  | {kind: 'belt'};

export interface CellView {
  /** False where the browser has no WebGL: nothing is drawn then. */
  readonly draws: boolean;
  readonly layers: Layers;
  onPick: (pick: Pick | null) => void;
  onProblem: (message: string) => void;
  setTheme(dark: boolean): void;
  setLayer(name: keyof Layers, on: boolean): void;
  select(pick: Pick | null): void;
  /** From now on decides what the pointer drags; null = nothing. */
  setGrabber(grabber: Grabber | null): void;
  /** Outlines from above of what is drawn for it. */
  footprintsOf(pick: Pick): Footprint[];
  clearTrails(): void;
  goHome(): void;
  focusRobot(index: number): void;
  /** Draws a planned move of a robot until the next call; null = none. */
  showPlan(shown: {robot: number; plan: MovePlan} | null): void;
  picturePng(): Promise<Blob>;
  film(rate_hz: number): MediaStream;
}

/** In place of the view without WebGL: one line. */
class BlankView implements CellView {
  readonly draws = false;
  readonly layers: Layers = {
    groups: false,
    contacts: false,
    trails: false,
    targets: false,
    cameras: false,
    curtain: false,
    names: false
  };
  onPick = (): void => {};
  onProblem = (): void => {};

  constructor(
    container: HTMLElement,
    readonly state: State
  ) {
    const note = document.createElement('p');
    note.className = 'blank';
    note.dataset.testid = 'no-webgl';
    note.textContent =
      'No 3D view: this browser does not offer WebGL 2. Everything else on this page works.';
    container.append(note);
    container.dataset.frames = 'none';
  }

  setTheme(): void {}
  setLayer(): void {}
  select(): void {}
  setGrabber(): void {}
  footprintsOf(): Footprint[] {
    return [];
  }
  clearTrails(): void {}
  goHome(): void {}
  focusRobot(): void {}
  showPlan(): void {}
  picturePng(): Promise<Blob> {
    return Promise.reject(new Error('there is no view'));
  }
  film(): MediaStream {
    throw new Error('there is no view');
  }
}

export function makeView(container: HTMLElement, state: State): CellView {
  if (!isWebGlAvailable) return new BlankView(container, state);
  try {
    return new View(container, state);
  } catch (problem) {
    console.warn(`no WebGL: ${(problem as Error).message}`);
    return new BlankView(container, state);
  }
}
