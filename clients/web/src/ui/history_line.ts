// Timeline under the view: shows any moment that the daemon keeps, steps and plays through the past,
// sets bookmarks, and returns the cell to a moment.
import {MomentLine, type PastReader, type When} from '../past';
import {BookmarkKind, type Bookmark} from '../protocol';
import {simTime, stepSize, type State} from '../state';
import type {Access} from './access';
import {button, h, notify, text} from './dom';
import {simSeconds} from './time';

const kTick_ms = 40; // of playing
const kMarks_ms = 1000; // between two drawings while the line grows
const kKinds: Record<number, string> = {
  [BookmarkKind.OWN]: 'own',
  [BookmarkKind.COMMAND]: 'command',
  [BookmarkKind.REFUSAL]: 'refusal',
  [BookmarkKind.GRASP]: 'grasp',
  [BookmarkKind.RELEASE]: 'release',
  [BookmarkKind.PROTECTIVE_STOP]: 'stop',
  [BookmarkKind.FAULT]: 'fault',
  [BookmarkKind.STOPPED]: 'stop'
};

export class HistoryLine {
  readonly element: HTMLElement;
  private readonly slider = h('input', {
    type: 'range',
    min: 0,
    max: 0,
    step: 1,
    value: 0,
    'aria-label': 'Moment',
    'data-testid': 'moment'
  });
  private readonly marks = h('div', {class: 'marks'});
  private readonly when = h('output', {'data-testid': 'past-time'}, 'now');
  private readonly what = h('span', {class: 'what', 'data-testid': 'bookmark-text'});
  private readonly play = button('▶', () => this.toggle(), {
    class: 'icon',
    'aria-label': 'Play the past',
    'data-testid': 'past-play'
  });
  private readonly speed = h(
    'select',
    {'aria-label': 'Speed of the past', 'data-testid': 'past-speed'},
    ...['0.01', '0.05', '0.1', '0.25', '0.5', '1'].map((v) => h('option', {value: v}, `${v}×`))
  );
  private readonly now = button('Now', () => this.leave(), {
    'data-testid': 'past-now',
    title: 'From the past back to now (n)'
  });
  private readonly resume: HTMLButtonElement;
  private readonly reader: PastReader;
  private line = new MomentLine([]);
  private moment: When | null = null; // shown moment
  private reading = false; // the moment has been asked for and not come
  private timer = 0;
  private drawn = 0; // the marks, when
  private played = 0; // steps that are due, with their fraction

  constructor(
    private readonly state: State,
    private readonly access: Access
  ) {
    this.speed.value = '0.1';
    this.reader = state.pastReader;
    this.reader.onProblem = (message) => {
      this.reading = false;
      this.pause();
      notify(message, 'error');
    };
    this.resume = access.guard(
      button('Resume from here', () => this.confirmResume(), {
        'data-testid': 'resume-here',
        title: 'Return the cell itself to this moment, after confirmation'
      }),
      () => (this.moment ? '' : 'Select a moment of the past first.'),
      true
    );
    const bookmark = access.guard(
      button('Bookmark', () => this.confirmBookmark(), {'data-testid': 'bookmark'}),
      () => '',
      true
    );
    this.slider.addEventListener('input', () => this.go(this.line.at(this.slider.valueAsNumber)));
    this.element = h(
      'section',
      {class: 'history-line', hidden: true, 'aria-label': 'The past'},
      h('div', {class: 'track'}, this.slider, this.marks),
      h(
        'div',
        {class: 'row'},
        button('|◀', () => this.jump(-1), {
          class: 'icon',
          'aria-label': 'The bookmark before',
          title: 'The bookmark before',
          'data-testid': 'bookmark-before'
        }),
        button('−1 ms', () => this.move(-1), {'data-testid': 'past-back', title: '1 ms back ([)'}),
        this.play,
        button('+1 ms', () => this.move(1), {'data-testid': 'past-on', title: '1 ms on (])'}),
        button('▶|', () => this.jump(1), {
          class: 'icon',
          'aria-label': 'The next bookmark',
          title: 'The next bookmark',
          'data-testid': 'bookmark-next'
        }),
        this.speed,
        this.when,
        this.what,
        h('span', {class: 'fill'}),
        bookmark,
        this.now,
        this.resume
      )
    );
    state.spansChanged.on(() => this.grow());
    state.bookmarksChanged.on(() => this.drawMarks());
    state.pastChanged.on((past) => {
      if (!past) this.forget();
    });
  }

  /** Moves by a number of steps; from the present, starts at the latest moment. */
  move(steps: number): void {
    this.pause();
    const place = this.moment ? this.line.placeOf(this.moment) : this.line.last;
    this.go(this.line.at((place ?? 0) + steps));
  }

  /** Shows the moment nearest to a simulated time of an epoch, if it is kept. */
  goTo(epoch: bigint, time_s: number): void {
    this.pause();
    const step = BigInt(Math.max(0, Math.round(time_s / stepSize(this.state.cell))));
    const moment = {epoch, step};
    if (this.line.placeOf(moment) !== null) this.go(moment);
    else notify('The daemon does not keep this moment.');
  }

  /** Returns to the present. */
  leave(): void {
    this.forget();
    this.state.showPast(null);
  }

  private forget(): void {
    this.pause();
    this.reader.leave();
    this.reading = false;
    this.moment = null;
    text(this.when, 'now');
    text(this.what, '');
    this.element.classList.remove('past');
    this.grow();
    this.access.update();
  }

  private go(moment: When | null): void {
    if (!moment) return;
    this.moment = moment;
    this.element.classList.add('past');
    const place = this.line.placeOf(moment);
    if (place !== null) this.slider.value = String(place);
    text(this.what, this.textAt(moment));
    this.reading = true;
    this.reader.ask(moment, (past) => {
      this.reading = false;
      this.state.showPast(past);
      const shown = past.snapshot!;
      text(this.when, `${simSeconds(simTime(shown))}${this.run(shown.epoch)}`);
    });
    this.access.update();
  }

  private grow(): void {
    this.line = new MomentLine(this.state.spans);
    this.element.hidden = this.state.spans.length === 0;
    this.slider.max = String(this.line.last);
    const place = this.moment ? this.line.placeOf(this.moment) : this.line.last;
    this.slider.value = String(place ?? 0);
    if (performance.now() - this.drawn > kMarks_ms) this.drawMarks();
  }

  private run(epoch: bigint): string {
    return this.state.spans.length > 1 ? ` of run ${epoch}` : '';
  }

  // ---- playing

  private toggle(): void {
    if (this.timer) return this.pause();
    if (!this.moment) this.go(this.line.at(0));
    this.played = 0;
    text(this.play, '❚❚');
    this.play.setAttribute('aria-label', 'Pause the past');
    this.timer = window.setInterval(() => this.tick(), kTick_ms);
  }

  private pause(): void {
    window.clearInterval(this.timer);
    this.timer = 0;
    text(this.play, '▶');
    this.play.setAttribute('aria-label', 'Play the past');
  }

  private tick(): void {
    // A slow daemon makes it slower, not jerky.
    if (!this.moment || this.reading) return;
    this.played += Number(this.speed.value) * kTick_ms;
    const steps = Math.floor(this.played);
    if (steps === 0) return;
    this.played -= steps;
    const place = this.line.placeOf(this.moment);
    if (place === null || place >= this.line.last) return this.pause();
    this.go(this.line.at(place + steps));
  }

  // ---- bookmarks

  private get kept(): {bookmark: Bookmark; place: number}[] {
    const kept = [];
    for (const bookmark of this.state.bookmarks) {
      const place = bookmark.moment ? this.line.placeOf(bookmark.moment) : null;
      if (place !== null) kept.push({bookmark, place});
    }
    return kept;
  }

  private jump(way: 1 | -1): void {
    this.pause();
    const here = (this.moment && this.line.placeOf(this.moment)) ?? this.line.last;
    const others = this.kept.filter(({place}) => way * (place - here) > 0);
    const next = way > 0 ? others[0] : others[others.length - 1];
    if (next) this.go(this.line.at(next.place));
    else notify(way > 0 ? 'There is no later bookmark.' : 'There is no earlier bookmark.');
  }

  private textAt({epoch, step}: When): string {
    return this.state.bookmarks
      .filter(({moment}) => moment?.epoch === epoch && moment.step === step)
      .map((bookmark) => bookmark.text || kKinds[bookmark.kind] || '')
      .join('; ');
  }

  private drawMarks(): void {
    this.drawn = performance.now();
    const width = Math.max(1, this.line.last);
    const mark = (place: number, kind: string, title: string): HTMLElement => {
      const element = h('i', {'data-kind': kind, title});
      element.style.left = `${(100 * place) / width}%`;
      return element;
    };
    // Draw more severe marks on top.
    const order = ['command', 'release', 'grasp', 'own', 'refusal', 'fault', 'stop'];
    const marks = this.kept
      .map(({bookmark, place}) => ({place, kind: kKinds[bookmark.kind] ?? 'own', bookmark}))
      .sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind));
    this.marks.replaceChildren(
      ...this.line.seams.map((place) => mark(place, 'seam', 'the cell was rebuilt')),
      ...marks.map(({place, kind, bookmark}) => mark(place, kind, bookmark.text || kind))
    );
  }

  private confirmBookmark(): void {
    const moment = this.moment ?? this.line.at(this.line.last);
    if (!moment) return;
    const input = h('input', {
      name: 'bookmark',
      maxlength: 100,
      'aria-label': 'Text of the bookmark',
      autocomplete: 'off'
    });
    const dialog = this.dialog('Bookmark this moment', [input], 'Set', () => ({
      case: 'addBookmark',
      value: {moment, text: input.value.trim()}
    }));
    input.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') dialog.querySelector<HTMLElement>('[data-confirm]')!.click();
    });
  }

  // ---- the cell itself

  private confirmResume(): void {
    const {moment} = this;
    if (!moment) return;
    this.pause();
    const when = this.when.textContent ?? '';
    this.dialog(
      'Resume from here?',
      [
        h(
          'p',
          {},
          `The cell itself returns to ${when} and continues from there, with all robots, parts, the belt and motions in progress. Connections stay open; controllers may not expect this.`
        )
      ],
      'Resume from here',
      () => ({case: 'resumeFrom', value: {moment}}),
      () => this.leave()
    );
  }

  private dialog(
    title: string,
    content: HTMLElement[],
    action: string,
    command: () => Parameters<Access['command']>[0],
    then: () => void = () => {}
  ): HTMLDialogElement {
    const dialog = h(
      'dialog',
      {class: 'dialog', 'aria-label': title},
      h('h2', {}, title),
      ...content,
      h(
        'div',
        {class: 'row end'},
        button('Cancel', () => dialog.close()),
        button(
          action,
          () => {
            dialog.close();
            void this.access.command(command()).then((done) => done && then());
          },
          {'data-testid': 'confirm', 'data-confirm': true}
        )
      )
    );
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
    return dialog;
  }
}
