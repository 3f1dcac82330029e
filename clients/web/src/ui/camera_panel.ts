// Pictures of the scene's cameras, live while the panel is open.
import type {CameraDescription} from '../protocol';
import {stepSize, type State} from '../state';
import {CameraMarks, marksOf, poseOf} from './camera_marks';
import {h, text} from './dom';
import {simSeconds} from './time';

/** One camera: its next picture is asked for when the last one has come. */
class CameraView {
  readonly element: HTMLElement;
  private readonly picture: HTMLImageElement;
  private readonly marks: CameraMarks;
  private readonly note = h('figcaption', {});
  private url = '';

  constructor(
    readonly camera: CameraDescription,
    private readonly state: State,
    private readonly hasMarks: () => boolean
  ) {
    this.picture = h('img', {
      alt: `Picture of the camera ${camera.name}`,
      width: camera.widthPx,
      height: camera.heightPx,
      'data-testid': `camera-${camera.name}`
    });
    this.marks = new CameraMarks(camera);
    const frame = h('div', {class: 'camera-frame'}, this.picture);
    frame.append(this.marks.element);
    this.element = h('figure', {class: 'camera'}, frame, this.note);
    this.say('');
  }

  /** Shows pictures until `isWanted` says no. */
  async run(isWanted: () => boolean): Promise<void> {
    while (isWanted()) {
      const begin = performance.now();
      await this.show();
      const rest_ms = 1000 / this.camera.rateHz - (performance.now() - begin);
      await new Promise((next) => setTimeout(next, Math.max(0, rest_ms)));
    }
  }

  private async show(): Promise<void> {
    try {
      const answer = await fetch(`camera?name=${encodeURIComponent(this.camera.name)}`, {
        headers: credentials()
      });
      if (!answer.ok) throw new Error((await answer.text()).trim());
      const before = this.url;
      this.url = URL.createObjectURL(await answer.blob());
      this.picture.src = this.url;
      await this.picture.decode();
      if (before) URL.revokeObjectURL(before);
      this.mark(answer.headers.get('X-Pose'));
      this.say(simSeconds(Number(answer.headers.get('X-Step')) * stepSize(this.state.cell)));
    } catch (error) {
      this.say(error instanceof Error ? error.message : String(error));
      await new Promise((next) => setTimeout(next, kRetry_ms));
    }
  }

  private mark(pose: string | null): void {
    const X_WC = poseOf(pose);
    const {cell, live} = this.state;
    const shows = this.hasMarks() && X_WC && cell && live && !this.state.past;
    this.marks.show(shows ? marksOf(this.camera, X_WC, cell, live) : []);
  }

  private say(remark: string): void {
    const {name, widthPx, heightPx} = this.camera;
    text(this.note, `${name}, ${widthPx} × ${heightPx}${remark ? `, ${remark}` : ''}`);
  }
}

const kRetry_ms = 2000;

function credentials(): Record<string, string> {
  const token = sessionStorage.getItem('token');
  return token ? {Authorization: `Bearer ${token}`} : {};
}

/** Whether both lists have the same pictures. */
function areAlike(views: CameraView[], cameras: CameraDescription[]): boolean {
  return (
    views.length === cameras.length &&
    views.every(({camera}, i) => {
      const other = cameras[i]!;
      return (
        camera.name === other.name &&
        camera.widthPx === other.widthPx &&
        camera.heightPx === other.heightPx &&
        camera.focalXPx === other.focalXPx
      );
    })
  );
}

/** The panel of all cameras of the present scene; nothing is rendered for it while it is closed. */
export class CameraPanel {
  readonly element = h('div', {class: 'panel cameras'});
  private readonly pictures = h('div', {});
  private readonly detections = h('input', {
    type: 'checkbox',
    checked: true,
    'data-testid': 'camera-detections'
  });
  private views: CameraView[] = [];
  private opened = 0; // counts
  private isOpen = false;

  constructor(private readonly state: State) {
    this.element.append(
      h('label', {class: 'check'}, this.detections, ' mark detections of the vision lines'),
      this.pictures
    );
    state.cellChanged.on(() => this.follow());
  }

  /** Opens or closes the panel. */
  show(open: boolean): void {
    this.isOpen = open;
    ++this.opened;
    this.follow();
    if (open) this.run(this.views);
  }

  /** Shows the cameras of the present scene. */
  private follow(): void {
    const {cell, past} = this.state;
    if (!cell || past) return;
    const isEmpty = this.pictures.childElementCount === 0;
    if (!isEmpty && areAlike(this.views, cell.cameras)) return;
    this.views = cell.cameras.map(
      (camera) => new CameraView(camera, this.state, () => this.detections.checked)
    );
    this.pictures.replaceChildren(
      ...(this.views.length > 0
        ? this.views.map((view) => view.element)
        : [h('p', {}, 'The scene has no cameras; its key cameras lists them.')])
    );
    if (this.isOpen) this.run(this.views);
  }

  private run(views: CameraView[]): void {
    const opened = this.opened;
    const isWanted = (): boolean => this.opened === opened && this.views === views;
    for (const view of views) void view.run(isWanted);
  }
}
