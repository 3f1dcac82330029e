// Pictures of the scene's cameras, live while the panel is open.
import {h, text} from './dom';

interface Camera {
  name: string;
  width: number;
  height: number;
  rateHz: number;
}

/** One camera: its next picture is asked for when the last one has come. */
class CameraView {
  readonly element: HTMLElement;
  private readonly picture: HTMLImageElement;
  private readonly note = h('figcaption', {});
  private url = '';

  constructor(private readonly camera: Camera) {
    this.picture = h('img', {
      alt: `Picture of the camera ${camera.name}`,
      width: camera.width,
      height: camera.height,
      'data-testid': `camera-${camera.name}`
    });
    this.element = h('figure', {class: 'camera'}, this.picture, this.note);
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
      this.say(`step ${answer.headers.get('X-Step') ?? ''}`);
    } catch (error) {
      this.say(error instanceof Error ? error.message : String(error));
      await new Promise((next) => setTimeout(next, kRetry_ms));
    }
  }

  private say(remark: string): void {
    const {name, width, height} = this.camera;
    text(this.note, `${name}, ${width} × ${height}${remark ? `, ${remark}` : ''}`);
  }
}

const kRetry_ms = 2000;

function credentials(): Record<string, string> {
  const token = sessionStorage.getItem('token');
  return token ? {Authorization: `Bearer ${token}`} : {};
}

/** The panel of all cameras; nothing is rendered for it while it is closed. */
export class CameraPanel {
  readonly element = h('div', {class: 'panel cameras'});
  private views: CameraView[] | null = null;
  private opened = 0; // counts

  /** Opens or closes the panel. */
  show(open: boolean): void {
    ++this.opened;
    if (open) void this.run(this.opened);
  }

  private async run(opened: number): Promise<void> {
    const isWanted = (): boolean => this.opened === opened;
    this.views ??= await this.load();
    if (!isWanted()) return;
    await Promise.all((this.views ?? []).map((view) => view.run(isWanted)));
  }

  private async load(): Promise<CameraView[] | null> {
    try {
      const answer = await fetch('cameras', {headers: credentials()});
      if (!answer.ok) throw new Error((await answer.text()).trim());
      const cameras = (await answer.json()) as Camera[];
      const views = cameras.map((camera) => new CameraView(camera));
      this.element.replaceChildren(
        ...(views.length > 0
          ? views.map((view) => view.element)
          : [h('p', {}, 'The scene has no cameras; its key cameras lists them.')])
      );
      return views;
    } catch (error) {
      this.element.replaceChildren(h('p', {}, error instanceof Error ? error.message : ''));
      return null;
    }
  }
}
