// Saves the view as a picture or a film.
import type {CellView} from '../scene/cell_view';
import {button, download, notify} from './dom';

const kFilmRate = 30; // pictures a second
const kFilmKinds = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

function stamped(name: string, ending: string): string {
  return `${name}-${new Date().toISOString().replace(/[:.]/g, '-').slice(0, 19)}.${ending}`;
}

/** Two buttons: save the view as PNG, and record it as WebM until pressed again. */
export function pictureButtons(view: CellView, name: string): HTMLButtonElement[] {
  let recorder: MediaRecorder | null = null;
  const picture = button(
    'Picture',
    () => void view.picturePng().then((blob) => download(stamped(name, 'png'), blob)),
    {title: 'Save the view as PNG', 'data-testid': 'picture'}
  );
  const film = button('Film', () => (recorder ? recorder.stop() : begin()), {
    title: 'Record the view as WebM until pressed again',
    'aria-pressed': 'false',
    'data-testid': 'film'
  });

  function begin(): void {
    const kind = kFilmKinds.find((one) => MediaRecorder.isTypeSupported(one));
    if (!kind) return notify('This browser cannot record WebM.', 'error');
    const pieces: Blob[] = [];
    recorder = new MediaRecorder(view.film(kFilmRate), {mimeType: kind});
    recorder.addEventListener('dataavailable', (event) => pieces.push(event.data));
    recorder.addEventListener('stop', () => {
      recorder = null;
      film.setAttribute('aria-pressed', 'false');
      download(stamped(name, 'webm'), new Blob(pieces, {type: 'video/webm'}));
    });
    recorder.start(1000);
    film.setAttribute('aria-pressed', 'true');
  }
  return [picture, film];
}
